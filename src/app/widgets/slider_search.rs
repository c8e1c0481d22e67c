//! Jumps to a slider by its symbol or name: a field that a key puts the focus in. Enter puts the
//! focus on the first slider that fits, where the arrow keys then change the value.

use eframe::egui::{Context, Id, Key, Response, TextEdit, Ui};

use super::text::small;

/// Width of the field \[points\].
const FIELD_WIDTH: f32 = 112.0;
/// Frames after which a jump to a slider that is not shown is given up.
const MAX_JUMP_FRAMES: u64 = 90;

/// A slider that can be found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Findable {
    /// Id as typed by a person: `Cs`, or `quadratic_drag.cd`.
    pub id: String,
    /// Symbol on screen.
    pub symbol: String,
    /// Name in words.
    pub name: String,
}

impl Findable {
    /// How well it fits `text` in lower case; the least is the best, `None` is not at all.
    fn rank(&self, text: &str) -> Option<u8> {
        let lower = |text: &str| text.to_lowercase();
        let (id, symbol, name) = (lower(&self.id), lower(&self.symbol), lower(&self.name));
        if id == text || symbol == text {
            Some(0)
        } else if id.starts_with(text) || symbol.starts_with(text) {
            Some(1)
        } else if name.split(' ').any(|word| word.starts_with(text)) {
            Some(2)
        } else {
            (id.contains(text) || name.contains(text)).then_some(3)
        }
    }
}

/// The slider that `text` means: the one that fits best, the first of several.
pub fn find<'a>(sliders: &'a [Findable], text: &str) -> Option<&'a Findable> {
    let text = text.trim().to_lowercase();
    if text.is_empty() {
        return None;
    }
    let ranked = sliders.iter().filter_map(|s| Some((s.rank(&text)?, s)));
    ranked.min_by_key(|(rank, _)| *rank).map(|(_, s)| s)
}

fn asked_key() -> Id {
    Id::unique("slider search asked")
}

fn jump_key() -> Id {
    Id::unique("slider jump")
}

/// Puts the focus into the field in the next frame.
pub fn ask(context: &Context) {
    context.data_mut(|data| data.insert_temp(asked_key(), true));
    context.request_repaint();
}

/// Id of the slider that is about to take the focus.
pub fn pending(ui: &Ui) -> Option<String> {
    let (id, frame): (String, u64) = ui.data(|data| data.get_temp(jump_key()))?;
    let age = ui.ctx().cumulative_frame_nr().saturating_sub(frame);
    (age <= MAX_JUMP_FRAMES).then_some(id)
}

/// Gives the focus to the slider with this id if it was searched for.
pub fn arrive(ui: &Ui, id: &str, track: &Response) {
    if pending(ui).as_deref() == Some(id) {
        ui.data_mut(|data| data.remove_temp::<(String, u64)>(jump_key()));
        track.request_focus();
        ui.scroll_to_rect(track.rect, Some(eframe::egui::Align::Center));
    }
}

/// Draws the field, and what Enter would jump to.
pub fn show(ui: &mut Ui, sliders: &[Findable]) {
    let text_key = Id::unique("slider search text");
    let mut text: String = ui.data(|data| data.get_temp(text_key)).unwrap_or_default();
    ui.horizontal(|ui| {
        let edit = TextEdit::singleline(&mut text)
            .hint_text("Find a slider (/)")
            .desired_width(FIELD_WIDTH);
        let field = ui.add(edit);
        ui.ctx()
            .accesskit_node_builder(field.id, |node| node.set_label("find a slider"));
        if ui.data_mut(|data| data.remove_temp::<bool>(asked_key())) == Some(true) {
            text.clear();
            field.request_focus();
        }
        let found = find(sliders, &text);
        let enter = ui.input(|input| input.key_pressed(Key::Enter));
        if let Some(found) = found.filter(|_| field.lost_focus() && enter) {
            let frame = ui.ctx().cumulative_frame_nr();
            let jump = (found.id.clone(), frame);
            ui.data_mut(|data| data.insert_temp(jump_key(), jump));
            ui.ctx().request_repaint();
            text.clear();
        } else if let Some(found) = found {
            ui.label(small(format!("Enter: {}, {}", found.symbol, found.name)));
        } else if !text.trim().is_empty() {
            ui.label(small("no such slider").weak());
        }
    });
    ui.data_mut(|data| data.insert_temp(text_key, text));
}

#[cfg(test)]
mod tests {
    use super::super::slider_search::*;

    #[test]
    fn a_symbol_is_found_before_a_part_of_a_name() {
        let slider = |id: &str, symbol: &str, name: &str| Findable {
            id: id.to_owned(),
            symbol: symbol.to_owned(),
            name: name.to_owned(),
        };
        let sliders = [
            slider("Ca0", "Ca0", "initial adhesion"),
            slider("Ca", "Ca", "adhesion growth rate"),
            slider("alpha", "\u{3b1}", "coefficient of restitution"),
        ];
        let id = |text| find(&sliders, text).map(|s| s.id.as_str());
        assert_eq!(id("ca"), Some("Ca"));
        assert_eq!(id("ca0 "), Some("Ca0"));
        assert_eq!(id("\u{3b1}"), Some("alpha"));
        assert_eq!(id("resti"), Some("alpha"));
        assert_eq!(id("adhesion"), Some("Ca0"));
        assert_eq!(id("zzz"), None);
        assert_eq!(id(" "), None);
    }
}
