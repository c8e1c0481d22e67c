//! Notes where named widgets are, for `shell::layout_dump` and the tests that read it.

use eframe::egui::{Context, Id, Rect};

/// Notes a widget's rectangle in this frame.
pub fn note(context: &Context, name: &str, rect: Rect) {
    context.data_mut(|data| {
        let places: &mut Vec<(String, Rect)> = data.get_temp_mut_or_default(Id::unique("layout"));
        places.retain(|(known, _)| known != name);
        places.push((name.to_owned(), rect));
    });
}
