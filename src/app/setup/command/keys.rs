//! The keys of commands.

use eframe::egui::{Key, KeyboardShortcut, ModifierNames, Modifiers};

use super::{Command, LearnCommand};
use crate::app::setup::drive_choice::Mode;
use crate::app::setup::workspace_id::WorkspaceId;

impl Command {
    /// All its keys, the usual one first.
    pub fn shortcuts(self) -> impl Iterator<Item = KeyboardShortcut> {
        // A second key, usual in other programs.
        let also = match self {
            Command::Redo => Some(KeyboardShortcut::new(Modifiers::COMMAND, Key::Y)),
            // Without a slider in focus, which the first key would move.
            Command::Learn(LearnCommand::Next) => {
                Some(KeyboardShortcut::new(Modifiers::ALT, Key::ArrowRight))
            }
            Command::Learn(LearnCommand::Back) => {
                Some(KeyboardShortcut::new(Modifiers::ALT, Key::ArrowLeft))
            }
            _ => None,
        };
        self.shortcut().into_iter().chain(also)
    }

    /// Its keys as people read them, if it has any: `Ctrl+Shift+Z or Ctrl+Y`, `?`.
    pub fn keys(self) -> Option<String> {
        let text = |keys: KeyboardShortcut| {
            let is_mac = cfg!(target_os = "macos");
            let text = keys.format(&ModifierNames::NAMES, is_mac);
            // Punctuation is shown as the character itself.
            text.replace("Questionmark", "?")
                .replace("Period", ".")
                .replace("Slash", "/")
                .replace("ArrowRight", "Right")
                .replace("ArrowLeft", "Left")
        };
        let all: Vec<String> = self.shortcuts().map(text).collect();
        (!all.is_empty()).then(|| all.join(" or "))
    }

    /// A text with its keys in brackets, if it has any.
    pub fn with_keys(self, text: &str) -> String {
        match self.keys() {
            Some(keys) => format!("{text} ({keys})"),
            None => text.to_owned(),
        }
    }

    /// Its usual key, if it has one.
    pub fn shortcut(self) -> Option<KeyboardShortcut> {
        let ctrl = |key| Some(KeyboardShortcut::new(Modifiers::COMMAND, key));
        let ctrl_shift = |key| {
            Some(KeyboardShortcut::new(
                Modifiers::COMMAND | Modifiers::SHIFT,
                key,
            ))
        };
        let plain = |key| Some(KeyboardShortcut::new(Modifiers::NONE, key));
        match self {
            Command::Open => ctrl(Key::O),
            Command::OpenPath => ctrl_shift(Key::O),
            Command::SaveSession => ctrl(Key::S),
            Command::SaveSessionAs => ctrl_shift(Key::S),
            Command::ExportSvg => ctrl(Key::E),
            Command::ExportPng => ctrl_shift(Key::E),
            Command::Undo => ctrl(Key::Z),
            Command::Redo => ctrl_shift(Key::Z),
            Command::Palette => ctrl(Key::K),
            Command::Quit => ctrl(Key::Q),
            Command::SetMode(Mode::WholeSpan) => plain(Key::W),
            Command::SetMode(Mode::Live) => plain(Key::L),
            Command::TogglePause => plain(Key::Space),
            Command::Step => plain(Key::Period),
            Command::Restart => plain(Key::R),
            Command::KeepCurve => plain(Key::G),
            Command::ZoomAll => plain(Key::A),
            Command::DriveEditor => plain(Key::D),
            Command::Validation => plain(Key::T),
            Command::FitPanel => plain(Key::F),
            Command::Identification => plain(Key::I),
            Command::Sensitivity => plain(Key::S),
            Command::ResidualUnit => plain(Key::U),
            Command::SmallMultiples => plain(Key::M),
            Command::ToggleTheme => plain(Key::N),
            Command::SidePanel => plain(Key::P),
            Command::Help => plain(Key::Questionmark),
            Command::FindSlider => plain(Key::Slash),
            Command::Workspace(WorkspaceId::Tune) => ctrl(Key::Num1),
            Command::Workspace(WorkspaceId::Diagnose) => ctrl(Key::Num2),
            Command::Workspace(WorkspaceId::Explore) => ctrl(Key::Num3),
            Command::Workspace(WorkspaceId::Learn) => ctrl(Key::Num4),
            Command::Learn(LearnCommand::Next) => plain(Key::PageDown),
            Command::Learn(LearnCommand::Back) => plain(Key::PageUp),
            Command::Learn(LearnCommand::NextLesson) => ctrl(Key::PageDown),
            Command::Learn(LearnCommand::PreviousLesson) => ctrl(Key::PageUp),
            Command::Present => plain(Key::F11),
            Command::TogglePicture(picture) => {
                let number = [
                    Key::Num1,
                    Key::Num2,
                    Key::Num3,
                    Key::Num4,
                    Key::Num5,
                    Key::Num6,
                    Key::Num7,
                ];
                plain(number[picture as usize])
            }
            _ => None,
        }
    }
}
