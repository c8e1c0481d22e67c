//! The jobs in progress, in the status bar: whichever workspace or panel is open, each is seen
//! with its progress and can be cancelled. Nothing moves under the pointer: each job has a place
//! of a fixed width, and one that ends keeps it while the pointer is over the list.

use eframe::egui::{Align, Id, Layout, Rect, TextStyle, TextWrapMode, Ui, Vec2, WidgetText, vec2};

use crate::app::analysis::job::Job;
use crate::app::services::Services;
use crate::app::widgets::icon::{ICON_SIZE, Icon, icon_button_enabled};
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

/// All kinds of jobs in the order of the list, each with the job in progress, if there is one.
fn jobs(services: &Services, ui: &Ui) -> [(&'static str, Option<Entry>); 12] {
    let of_fit = |p: &crate::fit::Progress| p.iteration as f64 / p.expected.max(1) as f64;
    let state = &services.state;
    let fit = state.fitting.job.as_ref();
    let profile = state.fitting.profile.job.as_ref();
    let identification = state.identification.job.as_ref();
    let table = calibrate::running(ui);
    let diagnosis = state.diagnosing.running.as_ref();
    let trial = state.diagnosing.trial.making.as_ref();
    let (a, b, c) = ("fit", "profile", "identification");
    let (d, e, f) = ("fit to Table A.1", "diagnosis", "sealed trial");
    let (g, sensing) = ("sensitivity", state.sensing.job());
    let exploring = &state.exploring;
    let explored = |name, job: Option<&Job<f64, ()>>| {
        let entry = job.and_then(|job| Entry::of(name, job, |share| *share));
        (name, entry)
    };
    [
        (a, fit.and_then(|job| Entry::of(a, job, of_fit))),
        (b, profile.and_then(|(_, job)| Entry::of(b, job, of_fit))),
        (
            c,
            identification.and_then(|(_, job)| Entry::of(c, job, of_fit)),
        ),
        (
            d,
            (table.as_ref()).and_then(|job| Entry::of(d, job, |(share, _)| *share)),
        ),
        (
            e,
            diagnosis.and_then(|running| Entry::of(e, &running.job, |p| p.done)),
        ),
        (f, trial.and_then(|job| Entry::of(f, job, |()| 0.0))),
        (g, sensing.and_then(|job| Entry::of(g, job, |share| *share))),
        explored("map", exploring.map.run.job()),
        explored("orbit diagram", exploring.orbit.run.job()),
        explored("basins", exploring.basins.run.job()),
        explored("robustness", exploring.robust.map.job()),
        explored("robust waveform", exploring.robust.search.job()),
    ]
}

/// What was drawn in the last frame.
#[derive(Debug, Clone)]
struct Shown {
    names: Vec<&'static str>,
    place: Rect,
}

/// Draws them. Returns how many there are.
pub(super) fn show(services: &Services, ui: &mut Ui) -> usize {
    let jobs = jobs(services, ui);
    let count = jobs.iter().filter(|(_, entry)| entry.is_some()).count();
    let key = Id::unique("jobs shown");
    if count == 0 {
        ui.data_mut(|data| data.remove::<Shown>(key));
        return 0;
    }
    let pointer = ui.input(|input| input.pointer.hover_pos());
    let before: Option<Shown> = ui.data(|data| data.get_temp(key));
    let pointed_at = before.filter(|b| pointer.is_some_and(|pos| b.place.contains(pos)));
    let kept = pointed_at.map_or_else(Vec::new, |before| before.names);
    let mut names = Vec::new();
    let list = ui.horizontal(|ui| {
        for (name, entry) in jobs {
            if entry.is_none() && !kept.contains(&name) {
                continue;
            }
            names.push(name);
            // By its own name a button is not taken for the one that was pressed in its place.
            ui.push_id(("job", name), |ui| match entry {
                Some(entry) => entry.show(ui),
                None => empty_place(ui, name),
            });
        }
    });
    let place = list.response.rect;
    ui.data_mut(|data| data.insert_temp(key, Shown { names, place }));
    count
}

impl Entry {
    /// Draws it.
    fn show(self, ui: &mut Ui) {
        ui.separator();
        ui.spinner();
        label(ui, self.name, &self.text());
        let name = format!("cancel {}", self.name);
        let button = icon_button_enabled(ui, Icon::Remove, &name, !self.is_cancelled);
        if button.on_hover_text("Stop it").clicked() {
            (self.cancel)();
        }
    }
}

/// The place of a job that has ended.
fn empty_place(ui: &mut Ui, name: &str) {
    ui.separator();
    ui.allocate_space(Vec2::splat(ui.spacing().interact_size.y));
    label(ui, name, &format!("{name} ended"));
    ui.allocate_space(Vec2::splat(ICON_SIZE));
}

/// Draws a text of a job, as wide as the longest of them.
fn label(ui: &mut Ui, name: &str, text: &str) {
    let width_of = |what: &str| {
        let text = WidgetText::from(format!("{name} {what}"));
        let wrap = Some(TextWrapMode::Extend);
        let galley = text.into_galley(ui, wrap, f32::INFINITY, TextStyle::Body);
        galley.size().x.ceil()
    };
    let widths = ["100 %", "stops", "ended"].map(width_of);
    let size = vec2(
        widths.into_iter().fold(0.0, f32::max),
        ui.spacing().interact_size.y,
    );
    let layout = Layout::left_to_right(Align::Center);
    ui.allocate_ui_with_layout(size, layout, |ui| {
        ui.set_min_size(size);
        ui.label(text);
    });
}
