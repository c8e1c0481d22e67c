//! A diagnosis with its progress on standard error.

use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use super::{interrupt, terminal};
use crate::diagnose::force_balance::{ForceBalance, force_balance};
use crate::diagnose::{
    DiagnoseControl, DiagnoseError, DiagnoseOptions, DiagnoseProgress, Diagnosis, diagnose,
};
use crate::fit::Part;
use crate::fit::solve::budget::{Ending, within_budget};
use crate::model::Model;
use crate::model::unit::{format_quantity, time_left};

/// Runs a diagnosis with its progress: on a terminal one line that changes, otherwise a line for
/// each stage. Ctrl-C ends it with what has been found so far.
///
/// # Errors
/// Those of the diagnosis.
pub fn watched(
    model: &Model,
    (train, held_out): (&[Part], &[Part]),
    options: &DiagnoseOptions,
) -> Result<Diagnosis, DiagnoseError> {
    let last = Mutex::new("");
    let progress = |p: &DiagnoseProgress| {
        // A panic in another thread while it wrote a line leaves the text usable.
        let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
        terminal::progress(&line(p), *last != p.stage);
        *last = p.stage;
    };
    let control = DiagnoseControl {
        cancel: interrupt::flag(),
        progress: &progress,
    };
    let answer = diagnose(model, train, held_out, options, &control);
    terminal::end_of_progress();
    answer
}

/// Runs the force balance alone. Ctrl-C or the end of the time allowed, which is said, end it with what
/// has been found so far.
///
/// # Errors
/// Those of the diagnosis.
pub fn watched_force_balance(
    model: &Model,
    sides: (&[Part], &[Part]),
    options: &DiagnoseOptions,
) -> Result<Option<ForceBalance>, DiagnoseError> {
    let work = |stop: &AtomicBool| {
        let control = DiagnoseControl {
            cancel: stop,
            progress: &|_| {},
        };
        force_balance(model, sides, options, &control)
    };
    let (found, ending) = within_budget(options.budget, interrupt::flag(), work);
    if let Some(time) = options.budget.filter(|_| ending == Ending::OutOfTime) {
        let time = format_quantity(time.as_secs_f64(), "s", 3);
        terminal::warning(format!(
            "the time of {time} was used up: these are the effects found so far"
        ));
    }
    found
}

fn line(p: &DiagnoseProgress) -> String {
    let detail = match p.detail.as_str() {
        // The stage says this already.
        "" | "re-tuning" => String::new(),
        detail => format!(" ({detail})"),
    };
    let whole_seconds = Duration::from_secs(p.remaining.as_secs_f64().ceil() as u64);
    format!(
        "{:3.0} % {}{detail}{}",
        100.0 * p.done,
        p.stage_text(),
        time_left(whole_seconds)
    )
}

#[cfg(test)]
mod tests {
    use super::super::watch::*;

    #[test]
    fn progress_is_one_line() {
        let p = DiagnoseProgress {
            stage: "naming",
            detail: "quadratic_drag".into(),
            done: 0.421,
            remaining: Duration::from_millis(6300),
        };
        assert_eq!(
            line(&p),
            " 42 % Comparing effects (quadratic_drag), about 7 s left"
        );
    }
}
