//! A path typed by hand: works where the system has no file dialog.

use std::path::{MAIN_SEPARATOR, Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};

use eframe::egui::{Align2, Context, Id, TextEdit, Ui, Window};

use super::{Answer, Target, enter, escape};
use crate::app::files::event::Purpose;
use crate::app::theme;

/// Names from a folder that are offered.
const OFFERED: usize = 8;
/// Names from a folder that are looked at.
const LOOKED_AT: usize = 20_000;

/// Something in a folder.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Offer {
    path: PathBuf,
    is_folder: bool,
}

/// The open dialog.
#[derive(Debug)]
pub struct PathDialog {
    /// `None` opens, else saves.
    purpose: Option<Purpose>,
    /// What a file that is opened is for.
    target: Target,
    /// What the text began with: a folder, so that a name is enough.
    start: String,
    text: String,
    error: Option<String>,
    /// The existing file that the person was asked about before it is replaced.
    confirm: Option<PathBuf>,
    /// Whether the text field is to take the keys.
    focus: bool,
    /// The text that `offers` was made for, or is being made.
    listed: Option<String>,
    coming: Option<Receiver<Vec<Offer>>>,
    offers: Vec<Offer>,
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
            coming: None,
            offers: Vec::new(),
        }
    }

    /// A dialog for a file with a purpose of its own.
    pub fn asking_for(target: Target) -> Self {
        Self {
            target,
            ..Self::new(None)
        }
    }

    /// Lists what goes on as the text does, in a thread: a folder may be far away. One
    /// at a time, so that a folder that does not answer costs one thread.
    fn list(&mut self, context: &Context) {
        if let Some(coming) = &self.coming {
            match coming.try_recv() {
                Ok(offers) => self.offers = offers,
                Err(std::sync::mpsc::TryRecvError::Empty) => return,
                Err(std::sync::mpsc::TryRecvError::Disconnected) => self.offers.clear(),
            }
            self.coming = None;
        }
        if self.listed.as_deref() == Some(self.text.as_str()) {
            return;
        }
        self.listed = Some(self.text.clone());
        let (send, coming) = channel();
        let (text, context) = (self.path_text(), context.clone());
        let started = std::thread::Builder::new()
            .name("folder".to_owned())
            .spawn(move || {
                // The dialog may be closed meanwhile.
                let _ = send.send(offers(&text));
                context.request_repaint();
            });
        self.coming = started.is_ok().then_some(coming);
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

    /// The path that is meant: one to save to has an extension.
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
                });
            }
            self.error = Some(if bare.is_dir() {
                "this is a folder: go on with the name of a file in it".to_owned()
            } else {
                format!("{}: there is no such file; check the path", bare.display())
            });
            return None;
        };
        if ends_in_folder || bare.is_dir() || path.is_dir() || path.file_name().is_none() {
            self.error = Some("give a file name after the folder".to_owned());
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
                "{} exists: press Replace to write over it, or give another name",
                path.display()
            ));
            self.confirm = Some(path);
            return None;
        }
        Some(Answer::Save(purpose, path))
    }

    /// Takes a changed text: what was said about the former one is void.
    fn changed(&mut self) {
        // A whole path typed or pasted after the folder is meant as it is.
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
                Target::Lost(_) => ("Where is the recording now?", "Open"),
                Target::Drive => ("Open a drive (CSV with t and V)", "Open"),
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
                    // The system's dialog knows recordings, presets and sessions only.
                    if self.target == Target::Any && ui.button("Browse...").clicked() {
                        answer = Some(Answer::Browse(self.purpose));
                    }
                    if ui.button("Cancel").clicked() {
                        open = false;
                    }
                });
                // Last: names that arrive late move no button from under the pointer.
                self.choices(ui);
            });
        (open && answer.is_none(), answer)
    }

    fn choices(&mut self, ui: &mut Ui) {
        let mut chosen = None;
        for offer in &self.offers {
            let name = offer.path.file_name().unwrap_or_default();
            let mut name = name.to_string_lossy().into_owned();
            if offer.is_folder {
                name.push(MAIN_SEPARATOR);
            }
            if ui.selectable_label(false, name).clicked() {
                chosen = Some(offer.clone());
            }
        }
        if let Some(offer) = chosen {
            self.text = offer.path.to_string_lossy().into_owned();
            if offer.is_folder {
                self.text.push(MAIN_SEPARATOR);
            }
            self.focus = true;
            self.changed();
        }
    }
}

/// What goes on as `text` does: folders first, hidden names only if asked for.
fn offers(text: &str) -> Vec<Offer> {
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
        .take(LOOKED_AT)
        .map(|entry| entry.path())
        .filter(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let hidden = name.starts_with('.') && !start.starts_with('.');
            !hidden && name.to_lowercase().starts_with(&start)
        })
        .collect();
    found.sort();
    // The disk is asked about few.
    found.truncate(4 * OFFERED);
    let mut offers: Vec<Offer> = found
        .into_iter()
        .map(|path| Offer {
            is_folder: path.is_dir(),
            path,
        })
        .collect();
    offers.sort_by_key(|offer| !offer.is_folder);
    offers.truncate(OFFERED);
    offers
}
