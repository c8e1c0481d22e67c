//! A prediction dragged with the pointer: the points of a curve, or a mark.

use eframe::egui::Ui;

use crate::app::analysis::learning::OpenStep;
use crate::app::plots::frame::time_plot::Reply;
use crate::learn::lesson::{MarkAxis, Task};

/// Moves what is predicted to where the pointer is.
pub(super) fn edit(ui: &Ui, open: &mut OpenStep, reply: &Reply) {
    let response = &reply.response;
    let is_down = response.is_pointer_button_down_on() || response.dragged();
    let Some(pointer) = response.interact_pointer_pos().filter(|_| is_down) else {
        return;
    };
    let frame = response.rect;
    let share = f64::from((pointer.x - frame.left()) / frame.width()).clamp(0.0, 1.0);
    let time = reply.window.0 + share * (reply.window.1 - reply.window.0);
    let up = f64::from((frame.bottom() - pointer.y) / frame.height());
    let value = reply.values.0 + up * (reply.values.1 - reply.values.0);
    let Some(step) = open.lesson.steps.get(open.index) else {
        return;
    };
    match &step.task {
        Task::Mark(mark) => match mark.axis {
            MarkAxis::Displacement => open.draft.set_mark(mark, value),
            MarkAxis::Time => open.draft.set_mark(mark, time),
            MarkAxis::Own => {}
        },
        Task::Curve(task) => {
            // A stroke of the pen moves every point that it passes.
            let last = task.points.saturating_sub(1);
            let nearest = (share * last as f64).round() as usize;
            let before = ui.input(|input| pointer - input.pointer.delta());
            let from = f64::from((before.x - frame.left()) / frame.width()).clamp(0.0, 1.0);
            let first = (from * last as f64).round() as usize;
            for i in first.min(nearest)..=first.max(nearest) {
                open.draft.set_point(task, i, value);
            }
            open.draft.point = nearest;
        }
        _ => {}
    }
}
