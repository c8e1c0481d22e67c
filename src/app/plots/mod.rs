//! Stand-in until branch `plots` lands.
pub mod device;
pub mod pyramid;
/// All pictures.
pub fn show(ui: &mut eframe::egui::Ui, _state: &mut super::state::State) {
    ui.label("plots");
}
