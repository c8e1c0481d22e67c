//! How far a growing answer is, and the buttons that stop it and begin it again.

use eframe::egui::{Button, Ui};

use super::fields::remark;
use crate::app::analysis::explore::run::{Grown, Run};
use crate::app::widgets::job_progress::progress_bar;
use crate::model::unit::format_quantity;

/// What a person asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Asked {
    Nothing,
    Stop,
    Again,
}

/// Draws it; `done` says how much is there.
pub fn show<Q, A>(
    ui: &mut Ui,
    run: &Run<Q, A>,
    is_stopped: bool,
    done: impl Fn(&Grown<A>) -> String,
) -> Asked
where
    Q: PartialEq + Send + Sync + 'static,
    A: Send + 'static,
{
    let mut asked = Asked::Nothing;
    let is_running = run.job().is_some();
    ui.horizontal(|ui| {
        let can_stop = run.job().is_some_and(|job| !job.is_cancelled());
        let stop = ui.add_enabled(can_stop, Button::new("Cancel"));
        if stop.on_hover_text("Stop; what is done stays").clicked() {
            asked = Asked::Stop;
        }
        let again = ui.add_enabled(!is_running, Button::new("Compute again"));
        if again.on_hover_text("Compute everything anew").clicked() {
            asked = Asked::Again;
        }
    });
    let Some(growing) = run.growing() else {
        return asked;
    };
    let grown = growing.lock();
    let text = done(&grown);
    if is_running {
        progress_bar(ui, grown.share as f32, text);
    } else {
        let time = format_quantity(grown.last_after.as_secs_f64(), "s", 3);
        let first = grown.first_after.map_or_else(String::new, |first| {
            let first = format_quantity(first.as_secs_f64(), "s", 2);
            format!("; the first after {first}")
        });
        let state = if is_stopped { "stopped: " } else { "" };
        remark(ui, &format!("{state}{text} in {time}{first}"));
    }
    asked
}
