//! The jobs in progress, in the status bar: whichever workspace or panel is open, each is seen
//! with its progress and can be cancelled.

use eframe::egui::Ui;

use crate::app::analysis::job::Job;
use crate::app::services::Services;
use crate::app::widgets::icon::{Icon, icon_button_enabled};
use crate::app::workspaces::tune::table_a1::calibrate;

/// A job as the status bar shows it.
struct Entry {
    name: &'static str,
    /// Share done, 0 to 1; `None` while it is not known.
    share: Option<f64>,
    is_cancelled: bool,
    cancel: Box<dyn FnOnce()>,
}

impl Entry {
    /// `None` for a job that has ended and only waits for its panel.
    fn of<P, T>(name: &'static str, job: &Job<P, T>, share: impl FnOnce(&P) -> f64) -> Option<Self>
    where
        P: Clone + Send + 'static,
        T: Send + 'static,
    {
        let of_button = job.clone();
        (!job.has_ended()).then(|| Self {
            name,
            share: job.progress().map(|progress| share(&progress)),
            is_cancelled: job.is_cancelled(),
            cancel: Box::new(move || of_button.cancel()),
        })
    }

    /// What is shown: `fit 40 %`.
    fn text(&self) -> String {
        match (self.is_cancelled, self.share) {
            (true, _) => format!("{} stops", self.name),
            (false, Some(share)) => format!("{} {:.0} %", self.name, 100.0 * share.clamp(0.0, 1.0)),
            (false, None) => self.name.to_owned(),
        }
    }
}

/// All jobs in progress.
fn entries(services: &Services, ui: &Ui) -> Vec<Entry> {
    let of_fit = |p: &crate::fit::Progress| p.iteration as f64 / p.expected.max(1) as f64;
    let state = &services.state;
    let (fitting, diagnosing) = (&state.fitting, &state.diagnosing);
    let identification = state.identification.job.as_ref();
    let table = calibrate::running(ui);
    [
        fitting
            .job
            .as_ref()
            .and_then(|job| Entry::of("fit", job, of_fit)),
        (fitting.profile.job.as_ref()).and_then(|(_, job)| Entry::of("profile", job, of_fit)),
        identification.and_then(|(_, job)| Entry::of("identification", job, of_fit)),
        table
            .as_ref()
            .and_then(|job| Entry::of("fit to Table A.1", job, |(share, _)| *share)),
        (diagnosing.running.as_ref())
            .and_then(|running| Entry::of("diagnosis", &running.job, |p| p.done)),
        (diagnosing.trial.making.as_ref()).and_then(|job| Entry::of("sealed trial", job, |()| 0.0)),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Draws them. Returns how many there are.
pub(super) fn show(services: &Services, ui: &mut Ui) -> usize {
    let entries = entries(services, ui);
    let count = entries.len();
    for entry in entries {
        // A job that ends makes the others move up. By its own name a button is not taken for the
        // one that was pressed in its place.
        ui.push_id(("job", entry.name), |ui| {
            ui.separator();
            ui.spinner();
            ui.label(entry.text());
            let label = format!("cancel {}", entry.name);
            let button = icon_button_enabled(ui, Icon::Remove, &label, !entry.is_cancelled);
            if button.on_hover_text("Stop it").clicked() {
                (entry.cancel)();
            }
        });
    }
    count
}
