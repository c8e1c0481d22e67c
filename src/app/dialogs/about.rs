//! Name, version, licence, and the source of the model.

use eframe::egui::{Ui, Window};

use super::escape;

/// Draws it while `open`.
pub fn show(ui: &mut Ui, open: &mut bool) {
    if *open && escape(ui) {
        *open = false;
    }
    Window::new("About impactscope")
        .open(open)
        .resizable(false)
        .default_width(420.0)
        .show(ui, |ui| {
            ui.heading(concat!("impactscope ", env!("CARGO_PKG_VERSION")));
            ui.label(env!("CARGO_PKG_DESCRIPTION"));
            ui.add_space(6.0);
            ui.label("The model: J. H. Ryou and K. R. Oldham, Model identification for impact dynamics of a piezoelectric microactuator, J. Micromech. Microeng. 22 (2012) 115002.");
            ui.add_space(6.0);
            ui.label(concat!("Licence: ", env!("CARGO_PKG_LICENSE")));
        });
}
