//! Dialogs, one file each: import settings, path, command palette, help, about.

mod about;
mod help;
mod import;
mod new_device;
mod palette;
mod path;
#[cfg(test)]
mod tests;

use std::path::PathBuf;

use eframe::egui::{Id, Key, Popup, Ui};

use super::files::event::Purpose;
use super::setup::command::Command;
use super::setup::overlay::OverlayId;
use crate::model::preset::Preset;
use crate::recording::csv::{ImportSettings, Preview};

pub use self::import::ImportDialog;
pub use self::new_device::NewDeviceDialog;
pub use self::palette::Palette;
pub use self::path::PathDialog;

/// Whether Escape was pressed for a dialog; an open menu takes it first.
fn escape(ui: &Ui) -> bool {
    !Popup::is_any_open(ui.ctx()) && ui.input(|input| input.key_pressed(Key::Escape))
}

/// Whether Enter was pressed for a dialog, with nothing focused or in its text `field`. A
/// focused button or number takes it otherwise.
fn enter(ui: &Ui, field: Id) -> bool {
    let focused = ui.memory(|memory| memory.focused());
    focused.is_none_or(|id| id == field)
        && !Popup::is_any_open(ui.ctx())
        && ui.input(|input| input.key_pressed(Key::Enter))
}

/// What a requested file is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// A recording, a preset or a session.
    Any,
    /// A session's recording whose file is missing.
    Lost(OverlayId),
    /// A drive voltage.
    Drive,
    /// A drawn waveform.
    Waveform,
}

/// What the person answered.
#[derive(Debug, Clone, PartialEq)]
pub enum Answer {
    /// Run a command.
    Command(Command),
    /// Open a file.
    Open(PathBuf),
    /// The new path of a session's recording.
    Found(OverlayId, PathBuf),
    /// Drive with the voltage in a file.
    Drive(PathBuf),
    /// Edit the drawn waveform in a file.
    Waveform(PathBuf),
    /// Save to a file.
    Save(Purpose, PathBuf),
    /// Import a recording with these settings.
    Import(PathBuf, Box<ImportSettings>),
    /// Preview another recording of a file with several.
    Trial(PathBuf, usize),
    /// Take a device that was described.
    Device(Box<Preset>),
    /// Use the system's dialog.
    Browse(Option<Purpose>),
}

/// The dialogs, each open or not.
#[derive(Debug, Default)]
pub struct Dialogs {
    import: Option<ImportDialog>,
    /// The recordings that are open.
    runs: Vec<PathBuf>,
    device: Option<NewDeviceDialog>,
    path: Option<PathDialog>,
    palette: Option<Palette>,
    help: bool,
    about: bool,
}

impl Dialogs {
    /// Whether one is open that takes the keys.
    pub fn is_open(&self) -> bool {
        self.import.is_some()
            || self.device.is_some()
            || self.path.is_some()
            || self.palette.is_some()
    }

    /// Opens the import settings of a recording; starts from `known` settings, if given.
    pub fn ask_import(&mut self, path: PathBuf, preview: Preview, known: Option<ImportSettings>) {
        self.import = Some(ImportDialog::new(path, preview, known, &self.runs));
    }

    /// Says which recordings are open: those that another one can be put together with.
    pub fn know_runs(&mut self, runs: Vec<PathBuf>) {
        self.runs = runs;
    }

    /// Describes a new device.
    pub fn ask_device(&mut self) {
        self.device = Some(NewDeviceDialog::default());
    }

    /// Asks for a file to open (`None`) or to save to.
    pub fn ask_path(&mut self, purpose: Option<Purpose>) {
        self.path = Some(PathDialog::new(purpose));
    }

    /// Asks for a file for `target`.
    pub fn ask_file(&mut self, target: Target) {
        self.path = Some(PathDialog::asking_for(target));
    }

    /// Opens the command palette.
    pub fn open_palette(&mut self) {
        self.palette = Some(Palette::default());
    }

    /// Shows or hides keys and gestures.
    pub fn toggle_help(&mut self) {
        self.help = !self.help;
    }

    /// Shows name, version and source of the model.
    pub fn open_about(&mut self) {
        self.about = true;
    }

    /// Draws the open dialogs; returns the answer.
    pub fn show(&mut self, ui: &mut Ui) -> Option<Answer> {
        let mut answer = None;
        if let Some(dialog) = &mut self.import {
            let (open, given) = dialog.show(ui);
            answer = answer.or(given);
            if !open {
                self.import = None;
            }
        }
        if let Some(dialog) = &mut self.device {
            let (open, given) = dialog.show(ui);
            answer = answer.or(given);
            if !open {
                self.device = None;
            }
        }
        if let Some(dialog) = &mut self.path {
            let (open, given) = dialog.show(ui);
            answer = answer.or(given);
            if !open {
                self.path = None;
            }
        }
        if let Some(palette) = &mut self.palette {
            let (open, given) = palette.show(ui);
            answer = answer.or(given.map(Answer::Command));
            if !open {
                self.palette = None;
            }
        }
        help::show(ui, &mut self.help);
        about::show(ui, &mut self.about);
        answer
    }
}
