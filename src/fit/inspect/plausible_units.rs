//! Plausibility of what was read: units of the columns, and cells that are no readings.

use super::recording_summary::RecordingSummary;
use crate::fit::error::FitError;
use crate::fit::options::Part;
use crate::fit::thresholds::{
    KNOWN_VOLTAGE, MAX_SPIKE_SHARE, MAX_SPIKES, MIN_DRIVE_VOLTAGE, MIN_RECORDED_PERIODS,
    MIN_SAMPLES_PER_PERIOD, OTHER_UNIT_FACTOR, SPIKE_FACTOR,
};
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::model::unit::{format_number, format_quantity};
use crate::recording::{Channel, extremes, quantile_in_place};

/// A ground level hundreds of times above or below the device's was read in another unit.
///
/// # Errors
/// [`FitError::OtherUnit`].
pub fn check_level(
    model: &Model,
    parts: &[Part],
    summaries: &[RecordingSummary],
) -> Result<(), FitError> {
    let dp = model.parameters[ParameterId::Dp];
    for (part, summary) in parts.iter().zip(summaries) {
        let Ok(level) = summary.level else { continue };
        let ratio = -level / dp;
        if ratio > OTHER_UNIT_FACTOR || (ratio > 0.0 && ratio < 1.0 / OTHER_UNIT_FACTOR) {
            let write = |v: f64| format_quantity(v, "m", 4);
            return Err(FitError::OtherUnit {
                recording: part.recording.name.clone(),
                level: write(level),
                dp: write(dp),
            });
        }
    }
    Ok(())
}

/// Checks the columns of a part for spikes, and time and voltage for implausible units.
///
/// # Errors
/// [`FitError::Spike`], [`FitError::OtherVoltage`] or [`FitError::OtherTime`].
pub fn check_columns(model: &Model, part: &Part) -> Result<(), FitError> {
    let r = &part.recording;
    for channel in [Channel::ProofMass, Channel::Cantilever, Channel::Voltage] {
        if let Some(values) = r.channel(channel) {
            check_spikes(part, channel, &values[part.samples.clone()])?;
        }
    }
    check_time(model, part)?;
    check_voltage(model, part)
}

fn check_time(model: &Model, part: &Part) -> Result<(), FitError> {
    let r = &part.recording;
    let f1 = model.parameters[ParameterId::F1];
    if !model.uses(ParameterId::F1) || f1.is_nan() || f1 <= 0.0 {
        return Ok(());
    }
    let rate = r.sampling_rate();
    let long = r.time[part.samples.end - 1] - r.time[part.samples.start];
    let what = if rate < MIN_SAMPLES_PER_PERIOD * f1 {
        format!("has {} samples a second", format_number(rate, 3))
    } else if long * f1 < MIN_RECORDED_PERIODS {
        format!("lasts {}", format_quantity(long, "s", 3))
    } else {
        return Ok(());
    };
    Err(FitError::OtherTime {
        recording: r.name.clone(),
        what,
        f1: format_quantity(f1, "Hz", 4),
    })
}

fn check_voltage(model: &Model, part: &Part) -> Result<(), FitError> {
    let r = &part.recording;
    let Some(volts) = r.voltage.as_deref().filter(|_| model.piezo.is_some()) else {
        return Ok(());
    };
    let (low, high) = extremes(&volts[part.samples.clone()]);
    let most = high.max(-low);
    let possible = KNOWN_VOLTAGE / OTHER_UNIT_FACTOR..=KNOWN_VOLTAGE * OTHER_UNIT_FACTOR;
    if !possible.contains(&most) && high - low > MIN_DRIVE_VOLTAGE {
        return Err(FitError::OtherVoltage {
            recording: r.name.clone(),
            most: format_quantity(most, "V", 3),
        });
    }
    Ok(())
}

/// A few cells far beyond all others are spikes. Short pulses are not: they have many samples as
/// far out.
fn check_spikes(part: &Part, channel: Channel, values: &[f64]) -> Result<(), FitError> {
    let mut finite: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    if finite.len() < 2 * MAX_SPIKES {
        return Ok(());
    }
    let middle = quantile_in_place(&mut finite, 0.5);
    finite.iter_mut().for_each(|v| *v = (*v - middle).abs());
    finite.sort_unstable_by(f64::total_cmp);
    let cells = MAX_SPIKES.max((MAX_SPIKE_SHARE * finite.len() as f64) as usize);
    let far = SPIKE_FACTOR * finite[finite.len() - 1 - cells];
    let least = if channel == Channel::Voltage {
        OTHER_UNIT_FACTOR * KNOWN_VOLTAGE
    } else {
        0.0
    };
    let out = |v: &f64| far > 0.0 && (*v - middle).abs() > far.max(least);
    let Some(at) = values.iter().position(out) else {
        return Ok(());
    };
    let r = &part.recording;
    Err(FitError::Spike {
        recording: r.name.clone(),
        channel: channel.symbol(),
        value: format_quantity(values[at], channel.base_unit(), 3),
        time: format_quantity(r.time[part.samples.start + at], "s", 6),
    })
}

#[cfg(test)]
mod tests {
    use super::super::plausible_units::*;
    use crate::fit::tests::{made, paper, part};
    use crate::recording::Recording;

    /// A recording with its columns of time, V and xp changed.
    fn changed(change: impl Fn(&mut Vec<f64>, &mut Vec<f64>, &mut Vec<f64>)) -> Part {
        let r = made(&paper(), "square:50Hz:6V", 0.03, 1);
        let (mut time, mut volts, mut xp) = (r.time, r.voltage.unwrap(), r.proof_mass);
        change(&mut time, &mut volts, &mut xp);
        part(Recording::new("changed", time, Some(volts), xp, r.cantilever).unwrap())
    }

    #[test]
    fn wrong_units_and_spikes_are_named() {
        let says = |part: Part, words: &str| {
            let error = check_columns(&paper(), &part).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        };
        let scale = |values: &mut Vec<f64>, by: f64| values.iter_mut().for_each(|v| *v *= by);
        let slow = changed(|t, _, _| scale(t, 1e3));
        says(
            slow,
            "has 50 samples a second, but the device rings at f1 = 623 Hz",
        );
        says(changed(|t, _, _| scale(t, 1e-3)), "lasts 30 µs");
        says(changed(|_, v, _| scale(v, 1e3)), "the voltage reaches 6 kV");
        says(
            changed(|_, v, _| scale(v, 1e-3)),
            "the voltage reaches 6 mV",
        );
        // A spike of few samples is left out; these are more.
        let wild = changed(|_, _, xp| xp[700..705].fill(1e30));
        says(wild, "t = 14 ms");
        says(changed(|_, v, _| v[3..8].fill(-1e9)), "V reads -1 GV");
        check_columns(&paper(), &changed(|_, _, xp| xp[700] = 1e30)).unwrap();
    }

    #[test]
    fn a_plausible_recording_passes() {
        check_columns(&paper(), &changed(|_, _, _| {})).unwrap();
        // Short pulses over a long rest are far out, and still readings.
        let pulses = changed(|_, v, xp| {
            for (i, (v, x)) in v.iter_mut().zip(xp).enumerate() {
                let rest = 1e-9 * ((i * i) as f64).sin();
                let pulse = i % 1000 < 12;
                *v = if pulse { 8.0 } else { 1e6 * rest };
                *x = if pulse { 1e-4 } else { rest };
            }
        });
        check_columns(&paper(), &pulses).unwrap();
        // A constant drive is reported elsewhere.
        let still = changed(|_, v, _| v.iter_mut().for_each(|v| *v = 0.0));
        check_columns(&paper(), &still).unwrap();
    }
}
