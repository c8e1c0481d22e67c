//! The search for a robust waveform: what it may change, how far it is, and the best few.

use eframe::egui::{Button, Frame, Label, RichText, Ui};

use crate::app::analysis::explore::drawing::from_drive;
use crate::app::analysis::explore::robust::{SearchView, search_question, searchable};
use crate::app::analysis::explore::source::drive_of;
use crate::app::flows::open_case;
use crate::app::setup::explore::ExplorePanel;
use crate::app::state::State;
use crate::app::widgets::job_progress::{cancel_button, progress_bar};
use crate::app::widgets::text::{heading, small};
use crate::app::workspaces::explore::fields::{Row, refusal, remark, within};
use crate::explore::robustness::FoundWaveform;
use crate::model::drive::Waveform;

/// Sizes of a search.
const POPULATIONS: (f64, f64) = (6.0, 500.0);
const GENERATION_COUNTS: (f64, f64) = (1.0, 1000.0);

/// What was pressed at a waveform that was found.
enum Taken {
    Edit(Waveform),
    Tune(Waveform),
}

/// Draws it.
pub(super) fn show(ui: &mut Ui, state: &mut State) {
    heading(ui, "Find a robust waveform");
    let Ok(drive) = drive_of(&state.setup, state.setup.explore.robustness.source) else {
        return;
    };
    numbers(ui, state, &drive);
    sizes(ui, state);
    start(ui, state, &drive);
    let Some(growing) = state.exploring.robust.search.growing().cloned() else {
        remark(
            ui,
            "The limits of voltage and slew are those of the Waveform panel.",
        );
        return;
    };
    let view: SearchView = growing.lock().answer.clone();
    let Some(result) = &view.result else {
        return;
    };
    let start = result.start.as_ref().map_or_else(
        || "impossible".to_owned(),
        |start| format!("{:.0} %", 100.0 * start.probability),
    );
    let beyond = if result.start_is_within_limits {
        ""
    } else {
        ", beyond the limits"
    };
    let ended = if result.is_cancelled {
        ", stopped early"
    } else {
        ""
    };
    let tried = result.tried;
    remark(
        ui,
        &format!(
            "{tried} waveforms tried{ended}. The start: {start}{beyond}. Checked with devices that the search did not see:"
        ),
    );
    if result.best.is_empty() {
        refusal(
            ui,
            "None is within the limits; widen them, or search more numbers.",
        );
    }
    let mut taken = None;
    for (i, found) in result.best.iter().enumerate() {
        taken = best(ui, i, found).or(taken);
    }
    match taken {
        None => {}
        Some(Taken::Tune(drive)) => open_case::open(state, None, drive),
        Some(Taken::Edit(drive)) => edit(state, &drive),
    }
}

/// Puts a waveform that was found into the editor.
fn edit(state: &mut State, drive: &Waveform) {
    match from_drive(drive, &state.setup.explore.drawn) {
        Ok(drawn) => {
            state.setup.explore.drawn = drawn;
            state.exploring.drawing.selected = None;
            state.view.explore_panel = ExplorePanel::Waveform;
        }
        Err(error) => state.exploring.drawing.refusal = Some(error.to_string()),
    }
}

/// Which numbers of the drive are searched.
fn numbers(ui: &mut Ui, state: &mut State, drive: &Waveform) {
    let held = &mut state.setup.explore.robustness.held;
    ui.label(small("It may change:"));
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        for (id, name) in searchable(drive) {
            let is_on = !held.contains(&id);
            let button = ui.selectable_label(is_on, small(&id));
            if button.on_hover_text(name).clicked() {
                if is_on {
                    held.insert(id);
                } else {
                    held.remove(&id);
                }
            }
        }
    });
}

fn sizes(ui: &mut Ui, state: &mut State) {
    let choices = &mut state.setup.explore.robustness;
    let rows = [
        (
            "waveforms of a generation",
            "Waveforms",
            "How many waveforms are tried at a time",
            &mut choices.population,
            POPULATIONS,
        ),
        (
            "generations of the search",
            "Generations",
            "How often they are improved",
            &mut choices.generations,
            GENERATION_COUNTS,
        ),
    ];
    for (label, name, help, value, (low, high)) in rows {
        let row = Row {
            label,
            name,
            help,
            value: *value as f64,
            unit: "",
        };
        if let Some(new) = row.show(ui, |v| within(v, low, high, "it")) {
            *value = new.round() as usize;
        }
    }
}

/// The button that begins the search, and its progress.
fn start(ui: &mut Ui, state: &mut State, drive: &Waveform) {
    let is_running = state.exploring.robust.search.job().is_some();
    ui.horizontal(|ui| {
        let button = ui.add_enabled(!is_running, Button::new("Search"));
        let help = "Look for the waveform that keeps the wanted response with the highest \
                    probability";
        if button.on_hover_text(help).clicked() {
            let limits = state.setup.explore.drawn.limits;
            let of = (&state.setup.preset.model, drive);
            let fit = state.fitting.result.as_deref();
            let question = search_question(&state.setup.explore.robustness, fit, limits, of);
            state.exploring.robust.start_search(question, ui.ctx());
        }
        if let Some(job) = state.exploring.robust.search.job() {
            cancel_button(ui, job, "Stop, and check the best so far");
        }
    });
    let search = &state.exploring.robust.search;
    if let Some(error) = &search.error {
        refusal(ui, &format!("No search: {error}."));
    }
    if search.job().is_some()
        && let Some(growing) = search.growing()
    {
        let grown = growing.lock();
        let text = grown.answer.progress.as_ref().map_or_else(
            || "first generation".to_owned(),
            |p| {
                let best = 100.0 * p.probability;
                format!("{} of {}, best {best:.0} %", p.generation, p.generations)
            },
        );
        progress_bar(ui, grown.share as f32, text);
    }
}

/// One of the best.
fn best(ui: &mut Ui, i: usize, found: &FoundWaveform) -> Option<Taken> {
    let mut taken = None;
    Frame::group(ui.style()).inner_margin(5).show(ui, |ui| {
        ui.set_width(ui.available_width());
        let title = format!(
            "{}. {:.0} % \u{b1} {:.0} % ({:+.0} points)",
            i + 1,
            100.0 * found.fresh.probability,
            100.0 * found.fresh.std_error(),
            100.0 * found.gain
        );
        ui.label(RichText::new(title).strong()).on_hover_text(
            "Probability over devices that the search did not see, and the gain over the start",
        );
        let drive = small(found.drive.to_string()).monospace();
        ui.add(Label::new(drive).wrap())
            .on_hover_text("The waveform as the command line takes it");
        ui.add(Label::new(small(&found.why)).wrap());
        ui.horizontal(|ui| {
            let edit = ui.small_button("Edit it");
            if edit
                .on_hover_text("Put it into the Waveform panel; it can be undone")
                .clicked()
            {
                taken = Some(Taken::Edit(found.drive.clone()));
            }
            let tune = ui.small_button("Use in Tune");
            if tune
                .on_hover_text("Make it the drive of the Tune workspace; it can be undone")
                .clicked()
            {
                taken = Some(Taken::Tune(found.drive.clone()));
            }
        });
    });
    taken
}
