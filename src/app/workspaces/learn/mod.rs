//! The Learn workspace: lessons on the left, the device and its plots in the middle, the step with
//! its question on the right.

mod curve;
mod exploring;
mod list;
mod question;
mod sheet;
mod words;

use eframe::egui::{CentralPanel, Id, Panel, Ui};

use crate::app::analysis::learning::{OpenStep, Phase};
use crate::app::plots::device::DeviceLook;
use crate::app::plots::stage::{Overlay, Predicted, Stage};
use crate::app::state::State;
use crate::learn::lesson::{LessonPicture, Task};

/// Width of the list of lessons \[points\].
const LIST_WIDTH: f32 = 208.0;
/// Share of the window for the text of a step, and its bounds \[points\].
const SHEET_SHARE: f32 = 0.30;
const SHEET_WIDTHS: (f32, f32) = (300.0, 460.0);

/// Draws the workspace.
pub fn show(ui: &mut Ui, state: &mut State) {
    state.learning.open_some();
    let width = ui.available_width();
    Panel::left("lessons")
        .resizable(false)
        .exact_size(LIST_WIDTH)
        .show(ui, |ui| list::show(ui, state));
    let sheet_width = (SHEET_SHARE * width).clamp(SHEET_WIDTHS.0, SHEET_WIDTHS.1);
    Panel::right("step")
        .resizable(false)
        .exact_size(sheet_width)
        .show(ui, |ui| sheet::show(ui, state));
    CentralPanel::default().show(ui, |ui| {
        if let Some(open) = &mut state.learning.open {
            pictures(ui, open);
        }
    });
    let wall = ui.input(|input| f64::from(input.unstable_dt));
    let is_still = state.view.less_motion;
    state.learning.update(ui.ctx(), wall, is_still);
}

/// The pictures of the open step, or why there are none.
fn pictures(ui: &mut Ui, open: &mut OpenStep) {
    if let Some(problem) = &open.problem {
        let color = crate::app::widgets::text::error_color(ui);
        ui.colored_label(color, format!("This cannot be simulated: {problem}"));
    }
    let Some(result) = open.result().cloned() else {
        if open.problem.is_none() {
            ui.weak("The run is being computed.");
        }
        return;
    };
    let Some(step) = open.step() else {
        return;
    };
    let is_predicting = open.phase == Phase::Predicting;
    let overlay = Overlay {
        predicted: predicted(open, &step.task),
        simulated: match &step.task {
            Task::Mark(mark) if open.phase == Phase::Seen => mark.simulated(&result.run).ok(),
            _ => None,
        },
    };
    let stage = Stage {
        scene: &open.scene,
        result: &result,
        time: if is_predicting {
            0.0
        } else {
            open.playback.time
        },
        pictures: &with_trajectory(&step.pictures, &step.task),
        look: DeviceLook::default(),
        overlay,
        holds_scale: matches!(step.task, Task::Explore(_)),
        name: "lesson",
    };
    let alt = result.written.alt.clone();
    let output = stage.show(ui);
    // The pictures say what they show; the lesson says what there is to see.
    let whole = ui.min_rect();
    let described = ui.interact(
        whole,
        Id::unique("what is to be seen"),
        eframe::egui::Sense::hover(),
    );
    described
        .widget_info(|| eframe::egui::WidgetInfo::labeled(eframe::egui::Role::Image, true, &alt));
    if let (true, Some(reply)) = (is_predicting, &output.trajectory) {
        curve::edit(ui, open, reply);
    }
}

/// The pictures of a step; those that a prediction is drawn on are always there.
fn with_trajectory(pictures: &[LessonPicture], task: &Task) -> Vec<LessonPicture> {
    let mut all = pictures.to_vec();
    let is_needed = matches!(task, Task::Curve(_) | Task::Fit(_) | Task::Concealed(_));
    if is_needed && !all.contains(&LessonPicture::Trajectory) {
        all.push(LessonPicture::Trajectory);
    }
    all
}

fn predicted<'a>(open: &'a OpenStep, task: &'a Task) -> Option<Predicted<'a>> {
    match task {
        Task::Mark(mark) => Some(Predicted::Mark(mark, open.draft.mark)),
        Task::Curve(curve) => Some(Predicted::Curve {
            points: &open.draft.curve,
            range: curve.range,
            selected: (open.phase == Phase::Predicting).then_some(open.draft.point),
        }),
        _ => None,
    }
}
