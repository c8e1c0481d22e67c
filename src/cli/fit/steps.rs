//! `fit --step`: the paper's identification, one step at a time.

use std::path::Path;
use std::sync::Arc;

use serde_json::{Value, json};

use super::result;
use crate::cli::output::Results;
use crate::cli::terminal;
use crate::fit::modal::{Estimate, ModalFit, Quality};
use crate::fit::paper_steps::adhesion::Adhesion;
use crate::fit::paper_steps::drive::{BranchFit, DriveFit};
use crate::fit::paper_steps::film::Film;
use crate::fit::paper_steps::guide::{Allowance, Guidance, Step, guide};
use crate::fit::paper_steps::model_distance_warning;
use crate::fit::paper_steps::outcome::{StepResult, take};
use crate::fit::paper_steps::restitution::Restitution;
use crate::fit::paper_steps::sensitivity::{Sensitivity, TABLE_2_ROWS, ZERO_SHIFT};
use crate::fit::{Control, FitError, FitOptions, FitResult, whole_device};
use crate::model::Model;
use crate::model::preset::known_value::with_error;
use crate::model::unit::{counted, format_quantity};
use crate::recording::Recording;

/// What `--step` takes.
pub const STEP_NAMES: [&str; 7] = [
    "guide",
    "modal",
    "drive",
    "restitution",
    "adhesion",
    "film",
    "sensitivity",
];

/// How the whole device is fitted before a step.
const FIT_WHOLE_DEVICE: &str = "On the command line: impactscope fit RECORDING... --out device.toml, then --preset device.toml with each step.";

/// What to do before the steps where the device is far from the recordings: ever more is freed, and
/// where that is not enough, physics is missing.
fn fit_first(model: &Model) -> String {
    format!(
        "Fit the whole device first. {FIT_WHOLE_DEVICE}\nIf it is still as far off after that, free its frequencies and shape too: --preset device.toml --free {}\nIf that does not help either, the device lacks something: impactscope diagnose RECORDING...\n",
        whole_device(model).join(",")
    )
}

/// The input of a step.
pub struct StepInputs<'a> {
    /// The device as identified so far.
    pub model: &'a Model,
    /// The recordings.
    pub recordings: &'a [Arc<Recording>],
    /// Options of the fits within a step.
    pub options: &'a FitOptions,
    /// Progress and cancel.
    pub control: &'a Control<'a>,
}

/// Whether a step finds values of a device's parameters.
pub fn finds_values(name: &str) -> bool {
    Step::find(name).is_some_and(Step::finds_values)
}

/// Takes a step. `results` take the summary and, for `json_file`, the numbers. Returns what was
/// found; `None` for the guide.
///
/// # Errors
/// Those of the step.
pub fn run(
    name: &str,
    inputs: &StepInputs<'_>,
    json_file: Option<&Path>,
    results: &mut Results,
) -> anyhow::Result<Option<StepResult>> {
    let StepInputs {
        model,
        recordings,
        options,
        control,
    } = *inputs;
    let found = Step::find(name).map(|step| take(step, model, recordings, None, options, control));
    terminal::end_of_progress();
    let found = found.transpose()?;
    let (text, value) = match &found {
        None => {
            let found = guide(model, recordings, options, control);
            terminal::end_of_progress();
            if control.cancelled() {
                // A cancelled check is no reason against a step.
                return Err(FitError::Cancelled.into());
            }
            guided(model, &found)
        }
        Some(StepResult::Modal(found)) => modal(found),
        Some(StepResult::Drive(found)) => drive(found),
        Some(StepResult::Restitution(found)) => bounces(found),
        Some(StepResult::Adhesion(found)) => pull_off(found),
        Some(StepResult::Film(found)) => damping(found),
        Some(StepResult::Sensitivity(found)) => twice(found),
    };
    results.say(&text);
    if let Some(path) = json_file {
        results.add_json(path, &value);
    }
    Ok(found)
}

type Outcome = (String, Value);

/// The lines that warn of a model that is `off` from what was read; empty if it is not.
fn distance_warning(off: f64) -> String {
    model_distance_warning(off).map_or_else(String::new, |warning| {
        format!("{warning}\n{FIT_WHOLE_DEVICE}\n")
    })
}

fn guided(model: &Model, found: &Guidance) -> Outcome {
    let allowances = &found.allowances;
    let mut text = String::from("Steps of the identification, in the paper's order:\n");
    for Allowance { step, by } in allowances {
        match by {
            Ok(names) => {
                text += &format!(
                    "  yes  {}\n       with {}\n",
                    step.title(),
                    names.join(", ")
                );
            }
            Err(missing) => {
                text += &format!("  no   {}\n       {}\n", step.title(), missing.reason);
                if let Some(record) = missing.record {
                    text += &format!("       record {record}\n");
                }
            }
        }
    }
    if let Some(sampled) = &found.sampled {
        text += &format!("{sampled}\n");
    }
    if let Some(first) = &found.first {
        text += &format!(
            "{first} When it is nearer, steps marked \"no\" may become possible with the same recordings.\n{}",
            fit_first(model)
        );
    } else if let Some(Allowance { step, .. }) = allowances.iter().find(|a| a.by.is_ok()) {
        text += &format!(
            "Begin with --step {} and the recordings named there",
            step.id()
        );
        text += if step.finds_values() {
            "; --out device.toml keeps what it finds for the next step, --preset device.toml.\n"
        } else {
            ".\n"
        };
        let unread = |a: &Allowance| a.by.as_ref().is_err_and(|m| m.may_be_the_device);
        if allowances.iter().any(unread) {
            text += &format!(
                "Steps marked \"no\" may become possible with the same recordings. {}",
                fit_first(model)
            );
        }
    }
    let steps: Vec<Value> = allowances
        .iter()
        .map(|a| match &a.by {
            Ok(names) => json!({ "step": a.step.id(), "allowed": true, "recordings": names }),
            Err(missing) => json!({
                "step": a.step.id(), "allowed": false,
                "reason": missing.reason, "record": missing.record,
            }),
        })
        .collect();
    let sampled = found
        .sampled
        .map(|s| json!({ "segments": s.picked, "of": s.all }));
    (
        text,
        json!({ "steps": steps, "first": found.first, "sampled": sampled }),
    )
}

fn modal(fit: &ModalFit) -> Outcome {
    let mut text = format!(
        "Modes from {} to {}, {} of {} samples used, input {}\n",
        format_quantity(fit.band.0, "Hz", 3),
        format_quantity(fit.band.1, "Hz", 3),
        fit.samples.0,
        fit.samples.0 + fit.samples.1,
        if fit.piezo.is_some() {
            "gc(V, V')"
        } else {
            "V"
        }
    );
    let pair = |e: Estimate, unit: &str| with_error(e.value, e.std_error, unit);
    for (i, mode) in fit.modes.iter().enumerate() {
        let quality = match mode.quality {
            Quality::Identified => "",
            Quality::Weak => "  (seen, not determined)",
            Quality::OutsideBand => "  (outside the swept band)",
        };
        text += &format!(
            "  mode {}: f = {}, zeta = {:.5} +- {:.1e}{quality}\n",
            i + 1,
            pair(mode.frequency, "Hz"),
            mode.zeta.value,
            mode.zeta.std_error
        );
        for (shape, name) in [
            (mode.shape.and_then(|s| s.phi_c), "phi_c"),
            (mode.shape.map(|s| s.phi_p), "phi_p"),
        ] {
            if let Some(e) = shape {
                text += &format!(
                    "       {name} = {:.2} +- {:.2} kg^-1/2\n",
                    e.value, e.std_error
                );
            }
        }
        for (circle, name) in mode.circles.iter().zip(["xp", "xc"]) {
            if let Some(circle) = circle {
                text += &format!(
                    "       circle fit of {name}: {}, zeta = {:.5}, scatter {:.1} %\n",
                    with_error(circle.frequency.0, circle.frequency.1, "Hz"),
                    circle.zeta.0,
                    100.0 * circle.scatter
                );
            }
        }
    }
    for remark in &fit.remarks {
        text += &format!("{remark}\n");
    }
    if !fit.follows_sweep() {
        text += "These modes do not follow the sweep; do not give them to a device.\n";
    }
    let value = serde_json::to_value(fit).unwrap_or(Value::Null);
    (text, value)
}

fn drive(fit: &DriveFit) -> Outcome {
    let describe = |name: &str, branch: &BranchFit| {
        let terms: Vec<String> = branch
            .coefficients
            .iter()
            .zip(&branch.errors)
            .enumerate()
            .filter(|(_, (c, _))| **c != 0.0)
            .map(|(power, (c, e))| format!("    V^{power}: {c:.5} +- {e:.1e}\n"))
            .collect();
        format!(
            "  {name}, measured from {:.2} to {:.2} V, scatter {:.4}:\n{}",
            branch.seen.0,
            branch.seen.1,
            branch.scatter,
            terms.concat()
        )
    };
    let [low, high] = fit
        .open_ends
        .map(|(volts, gap)| format!("{gap:+.4} at {volts:.2} V"));
    let text = format!(
        "Drive: gc(V) in units of eta, from {} blocks of slow motion\n{}{}  gap between the rising and the falling branch at the ends of the measured range, in units of eta: {low} and {high} (0 where the loop closes)\n",
        fit.points.len(),
        describe("rising", &fit.rising),
        describe("falling", &fit.falling),
    );
    let branch = |b: &BranchFit| json!({ "coefficients": b.coefficients, "std_errors": b.errors, "seen_V": [b.seen.0, b.seen.1], "scatter": b.scatter });
    let ends = fit
        .open_ends
        .map(|(volts, gap)| json!({ "V": volts, "gap": gap }));
    (
        text,
        json!({ "rising": branch(&fit.rising), "falling": branch(&fit.falling), "open_ends": ends }),
    )
}

fn bounces(found: &Restitution) -> Outcome {
    let mut text =
        String::from("Restitution, bounce by bounce:\n  t [ms]      v- [mm/s]  v+ [mm/s]  ratio\n");
    for b in &found.bounces {
        text += &format!(
            "  {:9.3}  {:9.1}  {:9.1}  {:.4} +- {:.4}\n",
            1e3 * b.time,
            -1e3 * b.approach,
            1e3 * b.departure,
            b.ratio,
            b.error
        );
    }
    text += &format!(
        "alpha = {:.4} +- {:.4}, scatter {:.4} over {}\nratio ~ speed^-n with n = {:.3} +- {:.3}: p = {:.3} for a constant ratio\n",
        found.mean,
        found.error,
        found.scatter,
        counted(found.bounces.len(), "bounce"),
        found.exponent.0,
        found.exponent.1,
        found.constant,
    );
    if found.aside.count() > 0 {
        text += &format!("{}\n", found.aside);
    }
    text += &distance_warning(found.off);
    (
        text,
        json!({
            "alpha": { "value": found.mean, "std_error": found.error, "scatter": found.scatter },
            "exponent": { "value": found.exponent.0, "std_error": found.exponent.1, "p_constant": found.constant },
            "set_aside": found.aside.count(), "off": found.off,
            "bounces": found.bounces.iter().map(|b| json!([b.time, -b.approach, b.departure, b.ratio, b.error])).collect::<Vec<_>>(),
        }),
    )
}

fn pull_off(found: &Adhesion) -> Outcome {
    let mut text =
        String::from("Adhesion: pull-off force at each release\n  contact [ms]  force [nN]\n");
    for r in &found.releases {
        text += &format!(
            "  {:12.3}  {:8.2} +- {:.2}\n",
            1e3 * r.contact,
            1e9 * r.force,
            1e9 * r.error
        );
    }
    for sentence in found.set_aside() {
        text += &format!("set aside: {sentence}\n");
    }
    let (at, half) = found.band(found.line.center);
    text += &format!(
        "Ca  = {} +- {}\nCa0 = {} +- {}\n95 % band at {:.1} ms: {} +- {}\n",
        format_quantity(found.rate.0, "N/s", 4),
        format_quantity(found.rate.1, "N/s", 2),
        format_quantity(found.start.0, "N", 4),
        format_quantity(found.start.1, "N", 2),
        1e3 * found.line.center,
        format_quantity(at, "N", 4),
        format_quantity(half, "N", 2),
    );
    text += &distance_warning(found.off);
    (
        text,
        json!({
            "Ca": { "value": found.rate.0, "std_error": found.rate.1, "unit": "N/s" },
            "Ca0": { "value": found.start.0, "std_error": found.start.1, "unit": "N" },
            "scatter": found.line.scatter,
            "releases": found.releases.iter().map(|r| json!([r.contact, r.force, r.error])).collect::<Vec<_>>(),
            "set_aside": found.aside.iter().map(|(r, why)| json!([r.contact, r.force, r.error, why.id()])).collect::<Vec<_>>(),
            "unread": found.unread, "off": found.off,
        }),
    )
}

fn damping(found: &Film) -> Outcome {
    let mut text = String::from("Film: Cs and gp fitted, the rest of the device held\n");
    for p in &found.fit.parameters {
        text += &format!(
            "  {} = {} +- {}\n",
            p.id,
            format_quantity(p.value, p.unit, 4),
            result::error(p.std_error, p.unit)
        );
    }
    text += &format!(
        "  Cs / (gp - dp)^3 = {}\nrms with the film {}, without {}; noise {}\n",
        format_quantity(found.at_contact, "N s/m", 4),
        format_quantity(found.with_film.rms, "m", 3),
        format_quantity(found.without_film.rms, "m", 3),
        format_quantity(found.with_film.noise, "m", 2),
    );
    for remark in &found.fit.remarks {
        text += &format!("{remark}\n");
    }
    if !found.follows_rings() {
        text += &format!("{FIT_WHOLE_DEVICE}\n");
    }
    let parameters: Vec<Value> = found
        .fit
        .parameters
        .iter()
        .map(|p| json!({ "id": p.id, "value": p.value, "std_error": p.std_error, "unit": p.unit }))
        .collect();
    (
        text,
        json!({
            "parameters": parameters, "at_contact": found.at_contact,
            "rms_with_film": found.with_film.rms, "rms_without_film": found.without_film.rms,
        }),
    )
}

fn twice(both: &Sensitivity) -> Outcome {
    let mut text = format!(
        "Sensitivity (Table 2): identified with the zero position as it is, and {} higher above the ground\n  {:6} {:>30} {:>30}\n",
        format_quantity(ZERO_SHIFT, "m", 3),
        "",
        "original",
        "altered"
    );
    let mut rows = serde_json::Map::new();
    for id in TABLE_2_ROWS {
        let spec = id.spec();
        let column = |fit: &FitResult| {
            let fitted = fit.parameters.iter().find(|p| p.id == spec.id);
            (fit.model.parameters[id], fitted.map(|p| p.std_error))
        };
        let write = |(value, error): (f64, Option<f64>)| {
            let value = format_quantity(value, spec.unit, 4);
            // A parameter that was not free has no error.
            error.map_or(format!("{value} (fixed)"), |error| {
                format!("{value} +- {}", result::error(error, spec.unit))
            })
        };
        let (a, b) = (column(&both.original), column(&both.altered));
        text += &format!("  {:6} {:>30} {:>30}\n", spec.id, write(a), write(b));
        rows.insert(
            spec.id.to_owned(),
            json!({
                "original": a.0, "original_std_error": a.1,
                "altered": b.0, "altered_std_error": b.1, "unit": spec.unit,
            }),
        );
    }
    text += "The drive is shifted accordingly; gp is measured from the zero position and moves with it.\n";
    text.extend(both.verdict().map(|sentence| sentence + "\n"));
    text += &format!(
        "rms {} and {}\n",
        format_quantity(both.original.train.0.rms, "m", 3),
        format_quantity(both.altered.train.0.rms, "m", 3)
    );
    (text, Value::Object(rows))
}
