//! The recording that would distinguish two models best.

use rayon::prelude::*;

use crate::diagnose::comparison::trial::SelectionResult;
use crate::diagnose::diagnosis::{NamedEffect, NextExperiment};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::sim::{Options, Trace, simulate};

/// Length of the simulated recordings \[s\].
const RUN_DURATION: f64 = NextExperiment::DURATION;
/// Samples per second.
const RUN_SAMPLING_RATE: f64 = 20e3;
/// Events of two runs farther apart than this are different ones \[s\].
const SAME_EVENT_MAX_GAP: f64 = 1e-4;

/// The drive within `volts` for which `a` and `b` differ most, in units of `noise` \[m\]. Only the time
/// up to their first different event counts: after it, small causes have large effects.
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
    let difference_for = |text: &String| -> Option<(String, f64)> {
        let drive: Waveform = Waveform::parse(text, RUN_DURATION).ok()?;
        let options = Options {
            rate: RUN_SAMPLING_RATE,
            ..Options::default()
        };
        let run = |m: &Model| simulate(m, &drive, RUN_DURATION, &options).ok();
        let (ta, tb) = (run(a)?, run(b)?);
        Some((text.clone(), difference(&ta, &tb, noise)))
    };
    let found: Vec<(String, f64)> = drives.par_iter().filter_map(difference_for).collect();
    let best = found.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(NextExperiment {
        drive: best.0,
        separates: (name_a.to_owned(), name_b.to_owned()),
        expected: best.1,
    })
}

fn difference(a: &Trace, b: &Trace, noise: f64) -> f64 {
    let pairs = a.events.iter().zip(&b.events);
    let diverged = pairs
        .filter(|(a, b)| a.kind != b.kind || (a.time - b.time).abs() > SAME_EVENT_MAX_GAP)
        .map(|(a, b)| a.time.min(b.time))
        .next()
        .unwrap_or(RUN_DURATION);
    let n = ((diverged * RUN_SAMPLING_RATE) as usize)
        .min(a.proof_mass.len())
        .min(b.proof_mass.len());
    let square = |i: usize| ((a.proof_mass[i] - b.proof_mass[i]) / noise).powi(2);
    (0..n).map(square).sum()
}

/// The recording that would distinguish the two best effects, or the best one from nothing.
pub fn next_experiment(
    found: &SelectionResult,
    named: &[NamedEffect],
    volts: f64,
    noise: f64,
    bare: &Model,
) -> Option<NextExperiment> {
    let mut fits: Vec<_> = found
        .scores
        .iter()
        .filter_map(|w| w.fit.as_ref().map(|t| (w.spec.id, t)))
        .filter(|(_, t)| t.gain > 0.0)
        .collect();
    fits.sort_by(|a, b| b.1.worth().total_cmp(&a.1.worth()));
    let with_contact_parameters = |m: &Model| {
        let mut m = m.clone();
        for (id, value) in bare.parameters.iter() {
            use crate::model::parameter::ParameterId as P;
            if matches!(id, P::Alpha | P::Ca | P::Ca0) {
                m.parameters.set(id, value);
            }
        }
        m
    };
    match (fits.first(), fits.get(1)) {
        (Some(a), Some(b))
            if named.is_empty() || found.state.named.iter().any(|n| n.spec.id == a.0) =>
        {
            let (ma, mb) = (
                with_contact_parameters(&a.1.train.model),
                with_contact_parameters(&b.1.train.model),
            );
            experiment((&ma, a.0), (&mb, b.0), volts, noise)
        }
        (Some(a), None) => experiment(
            (&with_contact_parameters(&a.1.train.model), a.0),
            (bare, "nothing"),
            volts,
            noise,
        ),
        _ => None,
    }
}
