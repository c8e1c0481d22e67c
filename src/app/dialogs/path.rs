//! A path typed by hand: works where the system has no file dialog.

use std::path::{Path, PathBuf};

use eframe::egui::{Align2, Key, TextEdit, Ui, Window};

use super::Answer;
use crate::app::files::Purpose;
use crate::app::theme;

/// Names from a folder that are offered.
const OFFERED: usize = 8;

/// The open dialog.
#[derive(Debug)]
pub struct PathDialog {
    /// `None` opens, else saves.
    purpose: Option<Purpose>,
    text: String,
    error: Option<String>,
    /// The text that `offers` was made for.
    listed: Option<String>,
    offers: Vec<PathBuf>,
}

impl PathDialog {
    /// A dialog that starts in the current folder.
    pub fn new(purpose: Option<Purpose>) -> Self {
        let folder = std::env::current_dir().unwrap_or_default();
        let name = purpose.map_or("", Purpose::file_name);
        Self {
            purpose,
            text: folder.join(name).to_string_lossy().into_owned(),
            error: None,
            listed: None,
            offers: Vec::new(),
        }
    }

    /// Existing files that go on as the text does; listed again only when it changes.
    fn list(&mut self) {
        if self.listed.as_deref() == Some(self.text.as_str()) {
            return;
        }
        self.listed = Some(self.text.clone());
        self.offers.clear();
        let path = Path::new(&self.text);
        let (folder, start) = if self.text.ends_with(std::path::MAIN_SEPARATOR) {
            (path, String::new())
        } else {
            let start = path.file_name().unwrap_or_default().to_string_lossy();
            (path.parent().unwrap_or(path), start.to_lowercase())
        };
        let Ok(entries) = std::fs::read_dir(folder) else {
            return;
        };
        self.offers = entries
            .flatten()
            // A folder with very many files must not hold up the window.
            .take(2000)
            .map(|entry| entry.path())
            .filter(|path| {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                !name.starts_with('.') && name.to_lowercase().starts_with(&start)
            })
            .collect();
        self.offers.sort();
        self.offers.truncate(OFFERED);
    }

    fn accept(&mut self) -> Option<Answer> {
        let path = PathBuf::from(self.text.trim());
        match self.purpose {
            None if path.is_file() => Some(Answer::Open(path)),
            None => {
                self.error = Some(format!("{}: there is no such file", path.display()));
                None
            }
            Some(_) if path.is_dir() || path.file_name().is_none() => {
                self.error = Some("give a file name after the folder".to_owned());
                None
            }
            Some(_) if !path.parent().is_some_and(Path::is_dir) => {
                self.error = Some("there is no such folder".to_owned());
                None
            }
            Some(purpose) => {
                let again = format!("{} exists: press again to replace it", path.display());
                if path.exists() && self.error.as_deref() != Some(&again) {
                    self.error = Some(again);
                    return None;
                }
                Some(Answer::Save(purpose, path))
            }
        }
    }

    /// Draws it; returns whether it stays open, and the answer.
    pub fn show(&mut self, ui: &mut Ui) -> (bool, Option<Answer>) {
        self.list();
        let (enter, escape) = ui.input(|i| (i.key_pressed(Key::Enter), i.key_pressed(Key::Escape)));
        let mut answer = enter.then(|| self.accept()).flatten();
        let mut open = !escape;
        let (title, action) = match self.purpose {
            None => ("Open a file", "Open"),
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
                        .add(TextEdit::singleline(&mut self.text).desired_width(560.0))
                        .labelled_by(label);
                    if self.listed.is_none() || !field.has_focus() && !field.lost_focus() {
                        field.request_focus();
                    }
                    if field.changed() {
                        self.error = None;
                    }
                });
                for offer in self.offers.clone() {
                    let name = offer.file_name().unwrap_or_default().to_string_lossy();
                    let name = if offer.is_dir() {
                        format!("{name}/")
                    } else {
                        name.into_owned()
                    };
                    if ui.selectable_label(false, name).clicked() {
                        self.text = offer.to_string_lossy().into_owned();
                        if offer.is_dir() {
                            self.text.push(std::path::MAIN_SEPARATOR);
                        }
                    }
                }
                if let Some(error) = &self.error {
                    ui.colored_label(theme::error(ui.visuals().dark_mode), error);
                }
                ui.horizontal(|ui| {
                    if ui.button(action).clicked() {
                        answer = self.accept();
                    }
                    if ui.button("Browse...").clicked() {
                        answer = Some(Answer::Browse(self.purpose));
                    }
                    if ui.button("Cancel").clicked() {
                        open = false;
                    }
                });
            });
        (open && answer.is_none(), answer)
    }
}
