//! A typed path, for saving and opening.

use std::path::{MAIN_SEPARATOR, Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};

use eframe::egui::{Align2, Context, Id, TextEdit, Ui, Window};

use super::{Answer, Target, enter, escape};
use crate::app::files::event::Purpose;
use crate::app::theme;

/// Most names of a folder that are suggested.
const MAX_SUGGESTIONS: usize = 8;
/// Most names of a folder that are read, so that a huge folder does not take long.
const MAX_NAMES_READ: usize = 20_000;

/// A suggested file or folder.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Suggestion {
    path: PathBuf,
    is_folder: bool,
}

/// The open dialog.
#[derive(Debug)]
pub struct PathDialog {
    /// `None` opens, else saves.
    purpose: Option<Purpose>,
    /// What an opened file is for.
    target: Target,
    /// The text at the start: a folder, so that typing a name is enough.
    start: String,
    text: String,
    error: Option<String>,
    /// The existing file that the person was asked about before it is replaced.
    confirm: Option<PathBuf>,
    /// Whether the text field is to get the focus.
    focus: bool,
    /// The text that the suggestions belong to.
    listed: Option<String>,
    pending: Option<Receiver<Vec<Suggestion>>>,
    suggestions: Vec<Suggestion>,
}

impl PathDialog {
    /// A dialog that starts in the current folder.
    pub fn new(purpose: Option<Purpose>) -> Self {
        Self::starting_in(&std::env::current_dir().unwrap_or_default(), purpose)
    }

    /// A dialog that starts in `folder`.
    pub fn starting_in(folder: &Path, purpose: Option<Purpose>) -> Self {
        let name = purpose.map_or("", Purpose::file_name);
        Self {
            purpose,
            target: Target::Any,
            start: folder.join("").to_string_lossy().into_owned(),
            text: folder.join(name).to_string_lossy().into_owned(),
            error: None,
            confirm: None,
            focus: true,
            listed: None,
            pending: None,
            suggestions: Vec::new(),
        }
    }

    /// A dialog for a file for `target`.
    pub fn asking_for(target: Target) -> Self {
        Self {
            target,
            ..Self::new(None)
        }
    }

    /// Lists names that start with the text, in a thread, because a folder may be on a slow
    /// network. One at a time, so that a folder that does not respond costs one thread.
    fn list(&mut self, context: &Context) {
        if let Some(pending) = &self.pending {
            match pending.try_recv() {
                Ok(suggestions) => self.suggestions = suggestions,
                Err(std::sync::mpsc::TryRecvError::Empty) => return,
                Err(std::sync::mpsc::TryRecvError::Disconnected) => self.suggestions.clear(),
            }
            self.pending = None;
        }
        if self.listed.as_deref() == Some(self.text.as_str()) {
            return;
        }
        self.listed = Some(self.text.clone());
        let (send, pending) = channel();
        let (text, context) = (self.path_text(), context.clone());
        let started = std::thread::Builder::new()
            .name("folder".to_owned())
            .spawn(move || {
                // The dialog may be closed meanwhile.
                let _ = send.send(suggestions(&text));
                context.request_repaint();
            });
        self.pending = started.is_ok().then_some(pending);
    }

    /// The text with `~` as the person's home folder.
    fn path_text(&self) -> String {
        let text = self.text.trim();
        match text.strip_prefix('~') {
            Some(rest) if rest.is_empty() || rest.starts_with(['/', MAIN_SEPARATOR]) => {
                directories::BaseDirs::new().map_or_else(
                    || text.to_owned(),
                    |known| format!("{}{rest}", known.home_dir().display()),
                )
            }
            _ => text.to_owned(),
        }
    }

    /// The typed path; one to save to gets an extension.
    fn path(&self) -> PathBuf {
        let path = PathBuf::from(self.path_text());
        match (self.purpose, path.file_name()) {
            (Some(purpose), Some(name)) if path.extension().is_none() => {
                let suggested = purpose.file_name();
                let dot = suggested.find('.').unwrap_or(suggested.len());
                let mut name = name.to_owned();
                name.push(&suggested[dot..]);
                path.with_file_name(name)
            }
            _ => path,
        }
    }

    fn accept(&mut self) -> Option<Answer> {
        self.focus = true;
        let ends_in_folder = self.text.trim().ends_with(['/', MAIN_SEPARATOR]);
        let bare = PathBuf::from(self.path_text());
        let path = self.path();
        let Some(purpose) = self.purpose else {
            if bare.is_file() {
                return Some(match self.target {
                    Target::Any => Answer::Open(bare),
                    Target::Lost(id) => Answer::Found(id, bare),
                    Target::Drive => Answer::Drive(bare),
                    Target::Waveform => Answer::Waveform(bare),
                });
            }
            self.error = Some(if bare.is_dir() {
                "this is a folder; add the name of a file in it".to_owned()
            } else {
                format!("{}: there is no such file; check the path", bare.display())
            });
            return None;
        };
        if ends_in_folder || bare.is_dir() || path.is_dir() || path.file_name().is_none() {
            self.error = Some("add a file name after the folder".to_owned());
            return None;
        }
        let folder = path.parent().filter(|f| !f.as_os_str().is_empty());
        if let Some(folder) = folder
            && !folder.is_dir()
        {
            self.error = Some(format!("{}: there is no such folder", folder.display()));
            return None;
        }
        if path.exists() && self.confirm.as_ref() != Some(&path) {
            self.error = Some(format!(
                "{} exists: press Replace to overwrite it, or type another name",
                path.display()
            ));
            self.confirm = Some(path);
            return None;
        }
        Some(Answer::Save(purpose, path))
    }

    /// Reacts to a changed text: messages about the earlier one disappear.
    fn changed(&mut self) {
        // An absolute path typed or pasted after the folder replaces it.
        if let Some(typed) = self.text.strip_prefix(&self.start)
            && (typed.starts_with('~') || Path::new(typed).is_absolute())
        {
            self.text = typed.to_owned();
        }
        self.error = None;
        self.confirm = None;
    }

    /// Draws it; returns whether it stays open, and the answer.
    pub fn show(&mut self, ui: &mut Ui) -> (bool, Option<Answer>) {
        self.list(ui.ctx());
        let field_id = Id::unique("typed path");
        let mut answer = enter(ui, field_id).then(|| self.accept()).flatten();
        let mut open = !escape(ui);
        let (title, action) = match self.purpose {
            None => match self.target {
                Target::Any => ("Open a file", "Open"),
                Target::Lost(_) => ("Locate the recording", "Open"),
                Target::Drive => ("Open a drive (CSV with t and V)", "Open"),
                Target::Waveform => ("Open a drawn waveform", "Open"),
            },
            Some(_) if self.confirm.is_some() => ("Save to a file", "Replace"),
            Some(_) => ("Save to a file", "Save"),
        };
        Window::new(title)
            .collapsible(false)
            .resizable(false)
            .anchor(Align2::CENTER_TOP, [0.0, 90.0])
            .show(ui, |ui| {
                ui.horizontal(|ui| {
                    let label = ui.label("Path:").id;
                    let field = ui
                        .add(
                            TextEdit::singleline(&mut self.text)
                                .id(field_id)
                                .desired_width(560.0),
                        )
                        .labelled_by(label);
                    if std::mem::take(&mut self.focus) {
                        field.request_focus();
                    }
                    if field.changed() {
                        self.changed();
                    }
                });
                if let Some(error) = &self.error {
                    ui.colored_label(theme::error(ui.visuals().dark_mode), error);
                }
                ui.horizontal(|ui| {
                    if ui.button(action).clicked() {
                        answer = self.accept();
                    }
                    // The system's dialog opens only recordings, presets and sessions.
                    if self.target == Target::Any && ui.button("Browse...").clicked() {
                        answer = Some(Answer::Browse(self.purpose));
                    }
                    if ui.button("Cancel").clicked() {
                        open = false;
                    }
                });
                // Last, so that names that arrive later do not move a button under the pointer.
                self.suggestion_list(ui);
            });
        (open && answer.is_none(), answer)
    }

    fn suggestion_list(&mut self, ui: &mut Ui) {
        let mut chosen = None;
        for suggestion in &self.suggestions {
            let name = suggestion.path.file_name().unwrap_or_default();
            let mut name = name.to_string_lossy().into_owned();
            if suggestion.is_folder {
                name.push(MAIN_SEPARATOR);
            }
            if ui.selectable_label(false, name).clicked() {
                chosen = Some(suggestion.clone());
            }
        }
        if let Some(suggestion) = chosen {
            self.text = suggestion.path.to_string_lossy().into_owned();
            if suggestion.is_folder {
                self.text.push(MAIN_SEPARATOR);
            }
            self.focus = true;
            self.changed();
        }
    }
}

/// Names that start with `text`: folders first, hidden names only if `text` starts with a
/// dot.
fn suggestions(text: &str) -> Vec<Suggestion> {
    let path = Path::new(text);
    let (folder, start) = if text.ends_with(['/', MAIN_SEPARATOR]) {
        (path, String::new())
    } else {
        let start = path.file_name().unwrap_or_default().to_string_lossy();
        (path.parent().unwrap_or(path), start.to_lowercase())
    };
    let folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut found: Vec<PathBuf> = entries
        .flatten()
        .take(MAX_NAMES_READ)
        .map(|entry| entry.path())
        .filter(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let hidden = name.starts_with('.') && !start.starts_with('.');
            !hidden && name.to_lowercase().starts_with(&start)
        })
        .collect();
    found.sort();
    // Only these are looked up on the disk.
    found.truncate(4 * MAX_SUGGESTIONS);
    let mut suggestions: Vec<Suggestion> = found
        .into_iter()
        .map(|path| Suggestion {
            is_folder: path.is_dir(),
            path,
        })
        .collect();
    suggestions.sort_by_key(|suggestion| !suggestion.is_folder);
    suggestions.truncate(MAX_SUGGESTIONS);
    suggestions
}
