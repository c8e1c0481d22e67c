//! Stub.
pub enum Place {
    Panel,
    Window,
}
pub fn show(_ui: &mut eframe::egui::Ui, _state: &mut crate::app::state::State, _place: Place) {}
