use eframe::egui;
use impactscope::app::plots::device;
use impactscope::app::setup::*;
use impactscope::app::snapshot::*;
use impactscope::app::state::*;
use impactscope::model::drive::Waveform;
use impactscope::model::preset::Preset;
use impactscope::sim::{Options, simulate};
use std::sync::Arc;

pub fn state(name: &str, forces: bool) -> State {
    let preset = Preset::embedded(name).unwrap();
    let drive = Waveform::parse(&preset.drive, preset.duration).unwrap();
    let options = Options {
        forces,
        rate: if name == "paper" { 50e3 } else { 1e3 },
        ..Options::default()
    };
    let trace = simulate(&preset.model, &drive, preset.duration, &options).unwrap();
    if forces {
        for e in trace.events.iter().take(30) {
            eprintln!(
                "{name} {:?} {:.5} d {:.4}",
                e.kind, e.time, e.contact_duration
            );
        }
    }
    let model = Arc::new(preset.model.clone());
    let snapshot = Snapshot::new(1, &model, Arc::new(trace), &[], Default::default());
    let mut setup = impactscope::app::first_start::setup();
    setup.preset = preset;
    setup.drive = DriveChoice::Waveform(drive);
    setup.overlays.clear();
    let mut state = impactscope::app::first_start::state(setup, View::default());
    state.snapshot = Some(Arc::new(snapshot));
    state
}
struct App {
    states: Vec<State>,
    page: usize,
    dark: bool,
}
impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        ui.ctx().set_visuals(if self.dark {
            egui::Visuals::dark()
        } else {
            egui::Visuals::light()
        });
        egui::CentralPanel::default().show(ui, |ui| {
            let cells: Vec<(usize, f64, f32, f32)> = match self.page {
                0 => vec![
                    (0, 0.0002, 500., 150.),
                    (0, 0.0008, 500., 150.),
                    (0, 0.0338, 500., 150.),
                    (0, 0.01, 500., 150.),
                    (0, 0.033345, 500., 150.),
                    (0, 0.03335, 500., 150.),
                    (0, 0.0672, 500., 150.),
                    (0, 0.06704, 500., 150.),
                    (0, 0.03332, 500., 150.),
                    (1, 0.0338, 500., 150.),
                    (1, 0.02, 500., 150.),
                ],
                1 => vec![
                    (0, 0.0338, 1000., 240.),
                    (0, 0.033345, 1000., 260.),
                    (0, 0.0672, 750., 200.),
                ],
                _ => vec![
                    (2, 0.0, 500., 150.),
                    (2, 0.36, 500., 150.),
                    (3, 0.0, 500., 150.),
                    (3, 2.0, 500., 150.),
                    (2, 1.0, 700., 240.),
                    (3, 1.0, 700., 240.),
                ],
            };
            ui.horizontal_wrapped(|ui| {
                for (i, t, w, h) in cells {
                    ui.allocate_ui(egui::vec2(w, h), |ui| {
                        egui::Frame::new()
                            .stroke((1.0, egui::Color32::GRAY))
                            .show(ui, |ui| {
                                ui.set_min_size(egui::vec2(w - 4., h - 4.));
                                ui.set_max_size(egui::vec2(w - 4., h - 4.));
                                device::show(ui, &self.states[i], Some(t));
                            });
                    });
                }
            });
        });
    }
}
fn main() {
    let page = std::env::args()
        .nth(1)
        .and_then(|a| a.parse().ok())
        .unwrap_or(0);
    let dark = std::env::args().nth(2).is_none_or(|a| a == "dark");
    let states = vec![
        state("paper", true),
        state("paper", false),
        state("oscillator", true),
        state("faller", true),
    ];
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default().with_inner_size([1580.0, 960.0]),
        ..Default::default()
    };
    eframe::run_native(
        "v",
        options,
        Box::new(move |_| Ok(Box::new(App { states, page, dark }))),
    )
    .unwrap();
}
