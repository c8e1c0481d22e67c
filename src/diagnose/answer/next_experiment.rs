//! The recording that would tell two models apart.

use rayon::prelude::*;

use crate::diagnose::comparison::trial::SelectionResult;
use crate::diagnose::diagnosis::{NamedEffect, NextExperiment};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::sim::{Options, Trace, simulate};

/// Length of the trial runs \[s\].
const DURATION: f64 = 0.2;
/// Samples per second.
const RATE: f64 = 20e3;
/// Events of two runs this far apart are no longer the same ones \[s\].
const APART: f64 = 1e-4;

/// The drive within `volts` for which `a` and `b` differ most, in units of `noise` \[m\];
/// what happens after their events part does not count.
pub fn experiment(
    (a, name_a): (&Model, &str),
    (b, name_b): (&Model, &str),
    volts: f64,
    noise: f64,
) -> Option<NextExperiment> {
    a.piezo?;
    // To a hundredth of a volt, as one would set it.
    let full = (100.0 * volts).floor() / 100.0;
    let low = (60.0 * volts).floor() / 100.0;
    let drives = [
        format!("ramped:5Hz:{full}V:0.25"),
        format!("ramped:10Hz:{full}V:0.1"),
        format!("square:15Hz:{full}V"),
        format!("square:40Hz:{full}V"),
        format!("square:300Hz:{full}V"),
        format!("square:100Hz:{low}V"),
        format!("sine:15Hz:{full}V"),
        format!("sine:50Hz:{full}V"),
        format!("sine:50Hz:{low}V"),
        format!("triangle:20Hz:{full}V"),
        format!("chirp:20Hz:300Hz:{low}V"),
    ];
    let weigh = |text: &String| -> Option<(String, f64)> {
        let drive: Waveform = Waveform::parse(text, DURATION).ok()?;
        let options = Options {
            rate: RATE,
            ..Options::default()
        };
        let run = |m: &Model| simulate(m, &drive, DURATION, &options).ok();
        let (ta, tb) = (run(a)?, run(b)?);
        Some((text.clone(), difference(&ta, &tb, noise)))
    };
    let found: Vec<(String, f64)> = drives.par_iter().filter_map(weigh).collect();
    let best = found.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(NextExperiment {
        drive: best.0,
        separates: (name_a.to_owned(), name_b.to_owned()),
        expected: best.1,
    })
}

fn difference(a: &Trace, b: &Trace, noise: f64) -> f64 {
    let pairs = a.events.iter().zip(&b.events);
    let parted = pairs
        .filter(|(a, b)| a.kind != b.kind || (a.time - b.time).abs() > APART)
        .map(|(a, b)| a.time.min(b.time))
        .next()
        .unwrap_or(DURATION);
    let n = ((parted * RATE) as usize)
        .min(a.proof_mass.len())
        .min(b.proof_mass.len());
    let square = |i: usize| ((a.proof_mass[i] - b.proof_mass[i]) / noise).powi(2);
    (0..n).map(square).sum()
}

/// The recording that would tell the best name from the next.
pub fn next(
    found: &SelectionResult,
    named: &[NamedEffect],
    volts: f64,
    noise: f64,
    bare: &Model,
) -> Option<crate::diagnose::diagnosis::NextExperiment> {
    let mut trials: Vec<_> = found
        .weighed
        .iter()
        .filter_map(|w| w.trial.as_ref().map(|t| (w.spec.id, t)))
        .filter(|(_, t)| t.gain > 0.0)
        .collect();
    trials.sort_by(|a, b| b.1.worth().total_cmp(&a.1.worth()));
    let whole = |m: &Model| {
        let mut m = m.clone();
        for (id, value) in bare.parameters.iter() {
            use crate::model::parameter::ParameterId as P;
            if matches!(id, P::Alpha | P::Ca | P::Ca0) {
                m.parameters.set(id, value);
            }
        }
        m
    };
    match (trials.first(), trials.get(1)) {
        (Some(a), Some(b))
            if named.is_empty() || found.stand.named.iter().any(|n| n.spec.id == a.0) =>
        {
            let (ma, mb) = (whole(&a.1.train.model), whole(&b.1.train.model));
            experiment((&ma, a.0), (&mb, b.0), volts, noise)
        }
        (Some(a), None) => experiment(
            (&whole(&a.1.train.model), a.0),
            (bare, "nothing"),
            volts,
            noise,
        ),
        _ => None,
    }
}
