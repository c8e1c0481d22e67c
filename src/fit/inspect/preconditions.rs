//! Preconditions of a fit, checked before any long computation: channels, ranges, noise, units,
//! whether the recordings can be of one device, and whether there is contact.

use std::sync::Arc;

use super::channel_noise::noise_of;
use super::connections::check_connections;
use super::motion::sampling_doubts;
use super::plausible_units::{check_columns, check_level};
use super::recording_summary::{RecordingSummary, summarize};
use super::same_device::{check_ring_frequency, rest_height_doubt};
use crate::fit::error::FitError;
use crate::fit::options::{FitOptions, Part};
use crate::fit::problem::parameter_space::Space;
use crate::fit::thresholds::{
    MAX_CLIPPED_SHARE, MAX_EXTREME_RUN, MAX_LEVEL_DIFFERENCE, MAX_LEVEL_DIFFERENCE_IN_A_FIT,
    MIN_DRIVE_VOLTAGE, MIN_LEVEL_DIFFERENCE_SHARE, MIN_SAMPLES, MIN_VOLTAGE_SYMMETRY,
    NOISELESS_SHARE, SATURATED_SHARE, SATURATED_SHARE_IN_NOISE,
};
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::model::unit::format_quantity;
use crate::recording::instrument_faults::{FaultKind, InstrumentFault};
use crate::recording::level::estimate_contact_level;
use crate::recording::noise::{NoiseError, estimate_noise};
use crate::recording::{Channel, Recording, extremes};

/// Checks parts and options against each other.
///
/// # Errors
/// [`FitError`] with one clear sentence.
pub fn check(
    model: &Model,
    parts: &[Part],
    summaries: &[RecordingSummary],
    options: &FitOptions,
) -> Result<(), FitError> {
    Space::new(model, &options.free)?;
    check_each(model, parts)?;
    check_summaries(model, parts, summaries, options)
}

/// What [`check`] found, unless the cause is that a channel is connected wrongly: that is said in
/// its place.
///
/// # Errors
/// `checked`, or [`FitError::Connection`].
pub(crate) fn or_connections(
    checked: Result<(), FitError>,
    model: &Model,
    parts: &[Part],
) -> Result<(), FitError> {
    let may_follow = matches!(
        checked,
        Ok(())
            | Err(FitError::Saturated { .. }
                | FitError::NoContact { .. }
                | FitError::DifferentDevices { .. })
    );
    if may_follow {
        check_connections(model, parts)?;
    }
    checked
}

/// What [`check`] asks of each part by itself.
///
/// # Errors
/// [`FitError`] with one clear sentence.
pub(crate) fn check_each(model: &Model, parts: &[Part]) -> Result<(), FitError> {
    if parts.is_empty() {
        return Err(FitError::NoRecording);
    }
    parts.iter().try_for_each(|part| check_part(model, part))
}

/// What [`check`] asks of all parts together.
///
/// # Errors
/// [`FitError`] with one clear sentence.
pub(crate) fn check_summaries(
    model: &Model,
    parts: &[Part],
    summaries: &[RecordingSummary],
    options: &FitOptions,
) -> Result<(), FitError> {
    let needs: Vec<&str> = ["dp", "alpha", "Ca", "Ca0", "Cs", "gp"]
        .into_iter()
        .filter(|id| options.free.iter().any(|f| f.eq_ignore_ascii_case(id)))
        .collect();
    if model.has_ground && !needs.is_empty() && summaries.iter().all(|f| f.level.is_err()) {
        let reason = summaries
            .iter()
            .find_map(|f| f.level.clone().err())
            .unwrap_or_default();
        return Err(FitError::NoContact {
            parameters: needs.join(", "),
            reason,
        });
    }
    same_device(parts, summaries, MAX_LEVEL_DIFFERENCE)
}

/// Checks what a fit of the free parameters needs beyond [`check`]: the recordings differ and are
/// of one device, a driven device has a moving voltage, and the ground is where the model allows
/// it. Returns sentences on what is doubtful.
///
/// # Errors
/// [`FitError`] with one clear sentence.
pub fn check_fit(
    model: &Model,
    (train, summaries): (&[Part], &[RecordingSummary]),
    held_out: &[Part],
    options: &FitOptions,
) -> Result<Vec<String>, FitError> {
    let all: Vec<Part> = train.iter().chain(held_out).cloned().collect();
    for (i, a) in all.iter().enumerate() {
        if let Some(b) = all[..i].iter().find(|b| overlap(a, b)) {
            return Err(FitError::DuplicateRecording {
                recording: a.recording.name.clone(),
                other: b.recording.name.clone(),
            });
        }
    }
    if model.piezo.is_some() {
        all.iter().try_for_each(cut_drive)?;
    }
    let free = |id: &str| options.free.iter().any(|f| f.eq_ignore_ascii_case(id));
    if model.piezo.is_some() && free("eta") && train.iter().all(is_still) {
        return Err(FitError::ConstantDrive {
            recording: train[0].recording.name.clone(),
        });
    }
    if model.has_ground && free("dp") {
        check_level(model, train, summaries)?;
        let p = &model.parameters;
        for (part, summary) in train.iter().zip(summaries) {
            let Ok(level) = summary.level else { continue };
            let write = |v: f64| format_quantity(v, "m", 4);
            if !free("gp") && -level >= p[ParameterId::Gp] {
                return Err(FitError::GroundBeyondFilm {
                    recording: part.recording.name.clone(),
                    level: write(level),
                    gp: write(p[ParameterId::Gp]),
                });
            }
        }
    }
    let summaries = summarize(model, &all);
    let ring = one_device(model, &all, &summaries)?;
    Ok(ring
        .into_iter()
        .chain(sampling_doubts(model, &all))
        .chain(rest_height_doubt(&all, &summaries))
        .collect())
}

/// Checks that ground level and ring frequency belong to one device. Returns a sentence if the ring
/// is doubtful.
///
/// # Errors
/// [`FitError::DifferentDevices`].
pub(crate) fn one_device(
    model: &Model,
    parts: &[Part],
    summaries: &[RecordingSummary],
) -> Result<Option<String>, FitError> {
    same_device(parts, summaries, MAX_LEVEL_DIFFERENCE_IN_A_FIT)?;
    check_ring_frequency(model, parts, summaries)
}

/// Whether two parts share samples, or hold the same samples under two names.
fn overlap(a: &Part, b: &Part) -> bool {
    let (r, s) = (&a.recording, &b.recording);
    let same = |x: Option<&[f64]>, y: Option<&[f64]>| match (x, y) {
        (Some(x), Some(y)) => {
            x.len() == y.len() && x.iter().zip(y).all(|(x, y)| x.to_bits() == y.to_bits())
        }
        (x, y) => x.is_none() && y.is_none(),
    };
    let one = Arc::ptr_eq(r, s)
        || (same(Some(&r.time), Some(&s.time))
            && same(Some(&r.proof_mass), Some(&s.proof_mass))
            && same(r.voltage.as_deref(), s.voltage.as_deref())
            && same(r.cantilever.as_deref(), s.cantilever.as_deref()));
    one && a.samples.start < b.samples.end && b.samples.start < a.samples.end
}

/// Whether the voltage of a part does not move.
fn is_still(part: &Part) -> bool {
    let volts = part.recording.voltage.as_deref();
    volts.is_some_and(|v| {
        let (low, high) = extremes(&v[part.samples.clone()]);
        high - low < MIN_DRIVE_VOLTAGE
    })
}

fn check_part(model: &Model, part: &Part) -> Result<(), FitError> {
    let r = &part.recording;
    let xp = &r.proof_mass[part.samples.clone()];
    let finite = xp.iter().filter(|x| x.is_finite()).count();
    if finite < MIN_SAMPLES {
        return Err(FitError::TooShort {
            recording: r.name.clone(),
            samples: finite,
            needed: MIN_SAMPLES,
        });
    }
    let (low, high) = extremes(xp);
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
    check_columns(model, part)?;
    let channels = [Channel::ProofMass, Channel::Cantilever];
    for channel in channels
        .into_iter()
        .take(1 + usize::from(model.has_cantilever))
    {
        if let Err(error @ NoiseError::TooShort { .. }) = noise_of(r, channel) {
            return Err(FitError::Noise {
                recording: r.name.clone(),
                channel: channel.symbol(),
                reason: error.to_string(),
            });
        }
    }
    saturated(r, part, Channel::ProofMass)?;
    if model.has_ground {
        ceiling(part)?;
    }
    if model.has_cantilever {
        if let Some(xc) = r.cantilever.as_deref() {
            let (low, high) = extremes(&xc[part.samples.clone()]);
            if high <= low {
                return Err(FitError::ConstantCantilever {
                    recording: r.name.clone(),
                });
            }
        }
        saturated(r, part, Channel::Cantilever)?;
    }
    Ok(())
}

/// Samples at the end of a reading's range are left out, unless they are many. Where noise does not
/// tell them from a rest, a reading that stays exactly at its extreme, again and again, has hit
/// that end. A mass at rest on the ground does so too, but at a level with noise.
fn saturated(r: &Recording, part: &Part, channel: Channel) -> Result<(), FitError> {
    let Some(values) = r.channel(channel).map(|v| &v[part.samples.clone()]) else {
        return Ok(());
    };
    let (low, high) = extremes(values);
    let mut faults = r.instrument_faults().faults.iter();
    let clipped = |f: &&InstrumentFault| f.kind == FaultKind::Clipping && f.channel == channel;
    if let Some(fault) = faults
        .find(clipped)
        .filter(|f| f.share() > MAX_CLIPPED_SHARE)
    {
        return Err(FitError::Saturated {
            recording: r.name.clone(),
            channel: channel.symbol(),
            which: if fault.size > low {
                "highest"
            } else {
                "lowest"
            },
            value: format_quantity(fault.size, "m", 4),
            percent: 100.0 * fault.share(),
        });
    }
    // A noiseless simulation also rests exactly; then only the upper end is checked.
    let noiseless = is_noiseless(r, channel, (low, high));
    let stepped = noise_of(r, channel).is_ok_and(|n| n.quantised);
    let most = if noiseless || stepped {
        SATURATED_SHARE
    } else {
        SATURATED_SHARE_IN_NOISE
    };
    for (which, extreme) in [("highest", high), ("lowest", low)] {
        // The same holds where a step of the reading is coarser than its noise.
        if which == "lowest" && (noiseless || stepped) {
            continue;
        }
        if let Some(share) = stuck(values, extreme, most) {
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

/// A mass that stops suddenly at its highest point and stays there has left the range of the
/// sensor, with or without noise: at the top there is no ground.
fn ceiling(part: &Part) -> Result<(), FitError> {
    let r = &part.recording;
    let down: Vec<f64> = r.proof_mass.iter().map(|x| -x).collect();
    let noise = noise_of(r, Channel::ProofMass).ok();
    let Ok(level) = estimate_contact_level(r.axis(), None, &down, noise) else {
        return Ok(());
    };
    let near = 4.0 * noise.map_or(0.0, |n| n.sigma);
    let at = down.iter().filter(|x| (**x - level).abs() <= near).count();
    Err(FitError::Saturated {
        recording: r.name.clone(),
        channel: Channel::ProofMass.symbol(),
        which: "highest",
        value: format_quantity(-level, "m", 4),
        percent: 100.0 * at as f64 / down.len() as f64,
    })
}

/// Share of the samples at an extreme value, if it is above `most` and the reading stays there.
fn stuck(values: &[f64], extreme: f64, most: f64) -> Option<f64> {
    let at = values.iter().filter(|v| **v == extreme).count();
    let mut longest = 0;
    let mut run = 0;
    for v in values {
        run = if *v == extreme { run + 1 } else { 0 };
        longest = longest.max(run);
    }
    let share = at as f64 / values.len() as f64;
    (share > most && longest > MAX_EXTREME_RUN).then_some(share)
}

/// A voltage may rest at its extremes, as a square does. If it rests at one and swings beyond the
/// mirror value on the other side, it was clipped.
fn cut_drive(part: &Part) -> Result<(), FitError> {
    let r = &part.recording;
    let Some(values) = r.voltage.as_deref().map(|v| &v[part.samples.clone()]) else {
        return Ok(());
    };
    let (low, high) = extremes(values);
    for (which, extreme, other) in [("highest", high, low), ("lowest", low, high)] {
        let beyond = extreme * other < 0.0 && extreme.abs() < MIN_VOLTAGE_SYMMETRY * other.abs();
        if beyond
            && stuck(values, other, SATURATED_SHARE).is_none()
            && let Some(share) = stuck(values, extreme, SATURATED_SHARE)
        {
            return Err(FitError::Saturated {
                recording: r.name.clone(),
                channel: "V",
                which,
                value: format_quantity(extreme, "V", 4),
                percent: 100.0 * share,
            });
        }
    }
    Ok(())
}

/// Whether a reading between the extremes `low` and `high` has no noise. Samples at the extremes
/// are excluded: at the end of a range they have none however noisy the others are. The noise found
/// without them must be white, or it is motion.
fn is_noiseless(r: &Recording, channel: Channel, (low, high): (f64, f64)) -> bool {
    let least = NOISELESS_SHARE * (high - low);
    if !noise_of(r, channel).is_ok_and(|n| n.sigma < least) {
        return false;
    }
    let mut between = r.channel(channel).unwrap_or_default().to_vec();
    for v in &mut between {
        if *v == low || *v == high {
            *v = f64::NAN;
        }
    }
    !estimate_noise(r.axis(), &between).is_ok_and(|n| n.white && n.sigma >= least)
}

/// Recordings of one device have the ground at one height, apart from the sensor's zero: `apart`
/// \[m\], or a share of the travel where that is more.
fn same_device(parts: &[Part], summaries: &[RecordingSummary], apart: f64) -> Result<(), FitError> {
    let mut known = parts.iter().zip(summaries).filter_map(|(p, f)| {
        let level = f.level.clone().ok()?;
        Some((p, level))
    });
    let Some((first, reference)) = known.next() else {
        return Ok(());
    };
    let travel = |part: &Part| {
        let (low, high) = extremes(&part.recording.proof_mass);
        (high - low).max(0.0)
    };
    for (part, level) in known {
        let share = MIN_LEVEL_DIFFERENCE_SHARE * travel(part).min(travel(first));
        if (level - reference).abs() > apart.max(share) {
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

#[cfg(test)]
#[path = "preconditions_tests.rs"]
mod tests;
