//! The command palette: finds every command by name.

use eframe::egui::{Align2, Key, ScrollArea, TextEdit, Ui, Window};

use crate::app::setup::command::Command;

/// The open palette.
#[derive(Debug, Default)]
pub struct Palette {
    text: String,
    chosen: usize,
}

/// Commands whose name or help contains all the words; those with all words in the name
/// come first. If there are none, commands whose name contains the letters in this order.
fn matching(text: &str) -> Vec<Command> {
    let words: Vec<String> = text.split_whitespace().map(str::to_lowercase).collect();
    let has_all = |place: &str| words.iter().all(|word| place.contains(word));
    let (mut by_name, mut by_help) = (Vec::new(), Vec::new());
    for command in Command::all() {
        let (name, line) = command.text();
        let name = name.to_lowercase();
        if has_all(&name) {
            by_name.push(command);
        } else if has_all(&format!("{name} {}", line.to_lowercase())) {
            by_help.push(command);
        }
    }
    by_name.append(&mut by_help);
    if by_name.is_empty() {
        let letters = words.concat();
        by_name = Command::all();
        by_name.retain(|command| has_letters(&command.text().0.to_lowercase(), &letters));
    }
    by_name
}

/// Whether `text` contains `letters` in this order, possibly with others between them.
fn has_letters(text: &str, letters: &str) -> bool {
    let mut rest = text.chars();
    letters
        .chars()
        .all(|letter| rest.by_ref().any(|c| c == letter))
}

impl Palette {
    /// Draws it; returns whether it stays open, and the command chosen.
    pub fn show(&mut self, ui: &mut Ui) -> (bool, Option<Command>) {
        let (up, down, enter, escape) = ui.input_mut(|input| {
            let none = eframe::egui::Modifiers::NONE;
            (
                input.consume_key(none, Key::ArrowUp),
                input.consume_key(none, Key::ArrowDown),
                input.consume_key(none, Key::Enter),
                input.consume_key(none, Key::Escape),
            )
        });
        let found = matching(&self.text);
        if down {
            self.chosen += 1;
        }
        if up {
            self.chosen = self.chosen.saturating_sub(1);
        }
        self.chosen = self.chosen.min(found.len().saturating_sub(1));
        let mut command = enter.then(|| found.get(self.chosen).copied()).flatten();
        Window::new("Commands")
            .title_bar(false)
            .resizable(false)
            .anchor(Align2::CENTER_TOP, [0.0, 80.0])
            .show(ui, |ui| {
                let label = ui.label("Command:").id;
                let field = ui
                    .add(
                        TextEdit::singleline(&mut self.text)
                            .desired_width(480.0)
                            .hint_text("type part of a name"),
                    )
                    .labelled_by(label);
                if field.changed() {
                    self.chosen = 0;
                }
                field.request_focus();
                ScrollArea::vertical().max_height(360.0).show(ui, |ui| {
                    for (i, entry) in found.iter().enumerate() {
                        let keys = entry.keys().unwrap_or_default();
                        let (name, line) = entry.text();
                        let row = ui.selectable_label(
                            i == self.chosen,
                            format!("{name}   {line}   {keys}"),
                        );
                        if i == self.chosen && (up || down) {
                            row.scroll_to_me(None);
                        }
                        if row.clicked() {
                            command = Some(*entry);
                        }
                    }
                    if found.is_empty() {
                        ui.weak("no command matches");
                    }
                });
            });
        (command.is_none() && !escape, command)
    }
}

#[cfg(test)]
mod tests {
    use super::super::palette::*;

    #[test]
    fn finds_commands_by_words_in_any_order() {
        // Films are exported as PNG frames, too.
        let of_png = vec![Command::ExportPng, Command::ExportFilm];
        assert_eq!(matching("png export"), of_png);
        assert_eq!(matching("").len(), Command::all().len());
        assert!(matching("no such thing").is_empty());
        assert_eq!(matching("expng"), vec![Command::ExportPng]);
        assert_eq!(matching("UNDO")[0], Command::Undo);
    }
}
