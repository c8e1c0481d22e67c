//! What makes a fit senseless, said before anything is computed.

use super::error::FitError;
use super::options::FitOptions;
use super::prepare::{Findings, Part};
use super::space::Space;
use crate::model::Model;
use crate::model::unit::format_quantity;
use crate::recording::{Channel, Recording};

/// Fewest samples to fit to.
const LEAST: usize = 20;
/// Share of the samples at one extreme value that is called saturated, as long as they
/// come in runs.
const STUCK: f64 = 0.02;
/// Longest run at the extreme that a quantised reading may show, in samples.
const RUN: usize = 20;
/// Levels of the ground farther apart than this are of different devices \[m\].
const APART: f64 = 15e-6;

/// Checks parts and options against each other.
///
/// # Errors
/// [`FitError`] with one clear sentence.
pub fn check(
    model: &Model,
    parts: &[Part],
    findings: &[Findings],
    options: &FitOptions,
) -> Result<(), FitError> {
    Space::new(model, &options.free)?;
    if parts.is_empty() {
        return Err(FitError::NoRecording);
    }
    for part in parts {
        check_part(model, part)?;
    }
    let needs: Vec<&str> = ["dp", "alpha", "Ca", "Ca0", "Cs", "gp"]
        .into_iter()
        .filter(|id| options.free.iter().any(|f| f.eq_ignore_ascii_case(id)))
        .collect();
    if model.has_ground && !needs.is_empty() && findings.iter().all(|f| f.level.is_err()) {
        let reason = findings
            .iter()
            .find_map(|f| f.level.clone().err())
            .unwrap_or_default();
        return Err(FitError::NoContact {
            parameters: needs.join(", "),
            reason,
        });
    }
    same_device(parts, findings)
}

fn check_part(model: &Model, part: &Part) -> Result<(), FitError> {
    let r = &part.recording;
    let xp = &r.proof_mass[part.samples.clone()];
    let finite = xp.iter().filter(|x| x.is_finite()).count();
    if finite < LEAST {
        return Err(FitError::TooShort {
            recording: r.name.clone(),
            samples: finite,
            needed: LEAST,
        });
    }
    let (low, high) = span(xp);
    if high <= low {
        return Err(FitError::Constant {
            recording: r.name.clone(),
        });
    }
    if model.piezo.is_some() && r.drive_table().is_none() {
        return Err(FitError::NoDrive {
            recording: r.name.clone(),
        });
    }
    saturated(r, part, Channel::ProofMass)?;
    if model.has_cantilever {
        saturated(r, part, Channel::Cantilever)?;
    }
    Ok(())
}

fn span(values: &[f64]) -> (f64, f64) {
    values
        .iter()
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
            (l.min(*v), h.max(*v))
        })
}

/// A reading that stays exactly at its extreme, time and again, has hit the end of its
/// range. A mass that rests on the ground does so too, but at a level with noise.
fn saturated(r: &Recording, part: &Part, channel: Channel) -> Result<(), FitError> {
    let Some(values) = r.channel(channel).map(|v| &v[part.samples.clone()]) else {
        return Ok(());
    };
    let (low, high) = span(values);
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted.dedup();
    // A noiseless simulation rests exactly too: there the other values are all different
    // as well, and the extreme is met suddenly; only the upper end is judged then.
    let noiseless = crate::recording::noise::recording_noise(r, channel)
        .is_ok_and(|n| n.sigma < 1e-6 * (high - low));
    for (which, extreme) in [("highest", high), ("lowest", low)] {
        if which == "lowest" && noiseless {
            continue;
        }
        let at = values.iter().filter(|v| **v == extreme).count();
        let mut longest = 0;
        let mut run = 0;
        for v in values {
            run = if *v == extreme { run + 1 } else { 0 };
            longest = longest.max(run);
        }
        let share = at as f64 / values.len() as f64;
        if share > STUCK && longest > RUN {
            return Err(FitError::Saturated {
                recording: r.name.clone(),
                channel: channel.symbol(),
                which,
                value: format_quantity(extreme, "m", 4),
                percent: 100.0 * share,
            });
        }
    }
    Ok(())
}

/// Recordings of one device have the ground at one height, apart from the sensor's zero.
fn same_device(parts: &[Part], findings: &[Findings]) -> Result<(), FitError> {
    let mut known = parts.iter().zip(findings).filter_map(|(p, f)| {
        let level = f.level.clone().ok()?;
        Some((p, level))
    });
    let Some((first, reference)) = known.next() else {
        return Ok(());
    };
    for (part, level) in known {
        if (level - reference).abs() > APART {
            let write = |v| format_quantity(v, "m", 3);
            return Err(FitError::DifferentDevices {
                recording: part.recording.name.clone(),
                other: first.recording.name.clone(),
                evidence: format!(
                    "its ground lies at {}, the other's at {}",
                    write(level),
                    write(reference)
                ),
            });
        }
    }
    Ok(())
}
