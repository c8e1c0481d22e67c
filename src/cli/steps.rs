//! `fit --step`: the paper's identification, one step at a time.

use std::path::Path;
use std::sync::Arc;

use serde_json::{Value, json};

use super::output;
use crate::fit::readings::{Readings, readings};
use crate::fit::steps::adhesion::adhesion;
use crate::fit::steps::drive::{BranchFit, fit_drive};
use crate::fit::steps::film::film;
use crate::fit::steps::guide::{Allowance, Step, guide};
use crate::fit::steps::restitution::restitution;
use crate::fit::steps::sensitivity::{ROWS, SHIFT, sensitivity};
use crate::fit::{Control, FitOptions, Part};
use crate::model::Model;
use crate::model::unit::format_quantity;
use crate::recording::Recording;

/// What `--step` takes.
pub const NAMES: [&str; 6] = [
    "guide",
    "drive",
    "restitution",
    "adhesion",
    "film",
    "sensitivity",
];

/// Everything that a step works with.
pub struct Bench<'a> {
    /// The device as identified so far.
    pub model: &'a Model,
    /// The recordings.
    pub recordings: &'a [Arc<Recording>],
    /// What the fits within a step may do.
    pub options: &'a FitOptions,
    /// Progress and cancel.
    pub control: &'a Control<'a>,
}

impl Bench<'_> {
    fn names(&self) -> String {
        let names: Vec<&str> = self.recordings.iter().map(|r| r.name.as_str()).collect();
        names.join(", ")
    }

    fn parts(&self) -> Vec<Part> {
        self.recordings.iter().cloned().map(Part::whole).collect()
    }

    fn readings(&self) -> anyhow::Result<Readings> {
        Ok(readings(
            self.model,
            &self.parts(),
            self.options,
            self.control,
        )?)
    }
}

/// Takes a step; the summary goes to standard output, the numbers to `json_file`.
///
/// # Errors
/// Those of the step.
pub fn run(name: &str, bench: &Bench<'_>, json_file: Option<&Path>) -> anyhow::Result<()> {
    let (text, value) = match Step::ALL.into_iter().find(|step| step.id() == name) {
        None => guided(bench),
        Some(Step::Drive) => drive(bench)?,
        Some(Step::Restitution) => bounces(bench)?,
        Some(Step::Adhesion) => pull_off(bench)?,
        Some(Step::Film) => damping(bench)?,
        Some(Step::Sensitivity) => twice(bench)?,
    };
    if json_file != Some(Path::new("-")) {
        output::to_stdout(|out| Ok(out.write_all(text.as_bytes())?))?;
    }
    match json_file {
        Some(path) => output::json(path, &value),
        None => Ok(()),
    }
}

type Outcome = (String, Value);

fn guided(bench: &Bench<'_>) -> Outcome {
    let found = guide(bench.model, bench.recordings, bench.options, bench.control);
    let allowances = found.allowances;
    let mut text = String::from("Steps of the identification, in the paper's order:\n");
    for Allowance { step, by } in &allowances {
        match by {
            Ok(names) => {
                text += &format!(
                    "  yes  {}\n       with {}\n",
                    step.title(),
                    names.join(", ")
                );
            }
            Err(reason) => {
                text += &format!(
                    "  no   {}\n       {reason}\n       record {}\n",
                    step.title(),
                    step.recipe()
                );
            }
        }
    }
    if let Some(next) = allowances.iter().find(|a| a.by.is_ok()) {
        text += &format!("Begin with: fit --step {} ...\n", next.step.id());
    }
    let steps: Vec<Value> = allowances
        .iter()
        .map(|a| match &a.by {
            Ok(names) => json!({ "step": a.step.id(), "allowed": true, "recordings": names }),
            Err(reason) => json!({
                "step": a.step.id(), "allowed": false, "reason": reason, "record": a.step.recipe(),
            }),
        })
        .collect();
    (text, json!({ "steps": steps }))
}

fn drive(bench: &Bench<'_>) -> anyhow::Result<Outcome> {
    let recordings: Vec<&Recording> = bench.recordings.iter().map(Arc::as_ref).collect();
    let fit = fit_drive(bench.model, &recordings)?;
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
            "  {name}, seen from {:.2} to {:.2} V, scatter {:.4}:\n{}",
            branch.seen.0,
            branch.seen.1,
            branch.scatter,
            terms.concat()
        )
    };
    let text = format!(
        "Drive: gc(V) in units of eta, from {} blocks of slow motion\n{}{}  gaps between the branches at the ends: {:.3} and {:.3}\n",
        fit.points.len(),
        describe("rising", &fit.rising),
        describe("falling", &fit.falling),
        fit.open_ends[0],
        fit.open_ends[1],
    );
    let branch = |b: &BranchFit| json!({ "coefficients": b.coefficients, "std_errors": b.errors, "seen_V": [b.seen.0, b.seen.1], "scatter": b.scatter });
    Ok((
        text,
        json!({ "rising": branch(&fit.rising), "falling": branch(&fit.falling), "open_ends": fit.open_ends }),
    ))
}

fn bounces(bench: &Bench<'_>) -> anyhow::Result<Outcome> {
    let found = restitution(&bench.names(), &bench.readings()?)?;
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
        "alpha = {:.4} +- {:.4}, scatter {:.4} over {} bounces\nratio ~ speed^-n with n = {:.3} +- {:.3}: p = {:.3} if it is constant\n",
        found.mean,
        found.error,
        found.scatter,
        found.bounces.len(),
        found.exponent.0,
        found.exponent.1,
        found.constant,
    );
    if found.aside.count() > 0 {
        text += &format!("{}\n", found.aside);
    }
    Ok((
        text,
        json!({
            "alpha": { "value": found.mean, "std_error": found.error, "scatter": found.scatter },
            "exponent": { "value": found.exponent.0, "std_error": found.exponent.1, "p_constant": found.constant },
            "set_aside": found.aside.count(),
            "bounces": found.bounces.iter().map(|b| json!([b.time, -b.approach, b.departure, b.ratio, b.error])).collect::<Vec<_>>(),
        }),
    ))
}

fn pull_off(bench: &Bench<'_>) -> anyhow::Result<Outcome> {
    let found = adhesion(&bench.names(), &bench.readings()?)?;
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
    Ok((
        text,
        json!({
            "Ca": { "value": found.rate.0, "std_error": found.rate.1, "unit": "N/s" },
            "Ca0": { "value": found.start.0, "std_error": found.start.1, "unit": "N" },
            "scatter": found.line.scatter,
            "releases": found.releases.iter().map(|r| json!([r.contact, r.force, r.error])).collect::<Vec<_>>(),
            "set_aside": found.aside.iter().map(|(r, why)| json!([r.contact, r.force, r.error, why.id()])).collect::<Vec<_>>(),
            "unread": found.unread,
        }),
    ))
}

fn damping(bench: &Bench<'_>) -> anyhow::Result<Outcome> {
    crate::fit::steps::film::check(bench.model)?;
    let found = film(bench.model, &bench.parts(), bench.options, bench.control)?;
    let mut text = String::from("Film: fitted with the rest of the device as it is\n");
    for p in &found.fit.parameters {
        text += &format!(
            "  {} = {} +- {}\n",
            p.id,
            format_quantity(p.value, p.unit, 4),
            format_quantity(p.std_error, p.unit, 2)
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
    let parameters: Vec<Value> = found
        .fit
        .parameters
        .iter()
        .map(|p| json!({ "id": p.id, "value": p.value, "std_error": p.std_error, "unit": p.unit }))
        .collect();
    Ok((
        text,
        json!({
            "parameters": parameters, "at_contact": found.at_contact,
            "rms_with_film": found.with_film.rms, "rms_without_film": found.without_film.rms,
        }),
    ))
}

fn twice(bench: &Bench<'_>) -> anyhow::Result<Outcome> {
    let both = sensitivity(bench.model, &bench.parts(), bench.options, bench.control)?;
    let mut text = format!(
        "Sensitivity (Table 2): identified with the zero position as it is, and {} higher above the ground\n  {:6} {:>26} {:>26}\n",
        format_quantity(SHIFT, "m", 3),
        "",
        "original",
        "altered"
    );
    let mut rows = serde_json::Map::new();
    for id in ROWS {
        let spec = id.spec();
        let (a, b) = (
            both.original.model.parameters[id],
            both.altered.model.parameters[id],
        );
        text += &format!(
            "  {:6} {:>26} {:>26}\n",
            spec.id,
            format_quantity(a, spec.unit, 4),
            format_quantity(b, spec.unit, 4)
        );
        rows.insert(
            spec.id.to_owned(),
            json!({ "original": a, "altered": b, "unit": spec.unit }),
        );
    }
    text +=
        "The drive's gain is shifted by as much; gp is counted from the zero and moves with it.\n";
    text += &format!(
        "rms {} and {}\n",
        format_quantity(both.original.train.0.rms, "m", 3),
        format_quantity(both.altered.train.0.rms, "m", 3)
    );
    Ok((text, Value::Object(rows)))
}
