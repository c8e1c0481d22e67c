//! What an average and its trials are, and what was found of a lag, in sentences.

use super::misfit::{AveragedTrial, Laid};
use super::overlay::Overlay;
use crate::model::drive::DriveReading;
use crate::model::unit::{counted, format_quantity};
use crate::recording::{Channel, Recording};

/// Rates and lengths that differ by more than this share are said.
const MIN_SAID_SHARE: f64 = 0.001;

/// What differs between the trials, what was done about it, and how they spread.
pub(super) fn said(
    reference: &Recording,
    laid: &[Laid],
    trials: &[AveragedTrial],
    mean: &Recording,
    match_zeros: bool,
) -> Vec<String> {
    let used = trials.iter().filter(|trial| trial.is_used).count();
    let (first, last) = mean.span();
    let mut said = vec![format!(
        "the mean of {used} trials on the clock of {}, {} from {} to {}, where all of them are",
        reference.name,
        counted(mean.len(), "row"),
        format_quantity(first, "s", 6),
        format_quantity(last, "s", 6)
    )];
    for (i, (trial, own)) in laid.iter().zip(trials).enumerate() {
        said.extend(of_trial(reference, i + 1, trial, own, match_zeros));
    }
    let overlays = || laid.iter().filter_map(|trial| trial.overlay.as_ref());
    let by_voltage = overlays().find(|o| o.by == Some(Channel::Voltage));
    said.extend(by_voltage.and_then(|overlay| period_in_words(reference, overlay)));
    for channel in Channel::ALL {
        let has = |trial: &Laid| trial.recording.channel(channel).is_some();
        let with = laid.iter().filter(|t| t.is_used && has(t)).count();
        if with > 0 && with < used {
            said.push(format!(
                "{} was recorded in {with} of the {used} trials and is left out",
                channel.symbol()
            ));
        }
    }
    said.extend(spread(mean));
    said
}

/// What one trial differs in from the first, and whether it belongs.
fn of_trial(
    reference: &Recording,
    number: usize,
    trial: &Laid,
    own: &AveragedTrial,
    match_zeros: bool,
) -> Vec<String> {
    let mut said = Vec::new();
    if let Some(misfit) = &own.misfit {
        let fate = if own.is_used {
            "it is in the average all the same; leave it out with --leave-out-misfits, or choose the trials"
        } else {
            "it is left out"
        };
        said.push(format!(
            "trial {number} ({}) does not belong to the others: {}; {fate}",
            own.name,
            misfit.words()
        ));
    }
    let overlay = trial.overlay.as_ref().filter(|_| own.is_used);
    let Some(overlay) = overlay else { return said };
    let recording = trial.recording;
    if !std::ptr::eq(recording, reference) {
        let lag = lag_in_words(reference, recording, overlay);
        said.push(format!("trial {number}: {lag}"));
        said.extend(clock_in_words(recording, overlay));
    }
    let differs = |a: f64, b: f64| (a / b - 1.0).abs() > MIN_SAID_SHARE;
    if differs(recording.sampling_rate(), reference.sampling_rate()) {
        said.push(format!(
            "trial {number} was sampled at {}, the others' clock runs at {}",
            format_quantity(recording.sampling_rate(), "Hz", 6),
            format_quantity(reference.sampling_rate(), "Hz", 6)
        ));
    }
    if differs(recording.duration(), reference.duration()) {
        said.push(format!(
            "trial {number} is {} long, {} is {}",
            format_quantity(recording.duration(), "s", 6),
            reference.name,
            format_quantity(reference.duration(), "s", 6)
        ));
    }
    if let (Some(zero), Some(rms)) = (own.zero, own.rms)
        && zero.abs() > 0.5 * rms
    {
        let what = if match_zeros {
            "was made that of the first"
        } else {
            "is averaged with the others"
        };
        said.push(format!(
            "the zero of xp in trial {number} lies {} {} that of {}; it {what}",
            format_quantity(zero.abs(), "m", 3),
            if zero < 0.0 { "below" } else { "above" },
            if match_zeros {
                "the first"
            } else {
                "the average"
            },
        ));
    }
    said
}

/// How the trials spread.
fn spread(mean: &Recording) -> Option<String> {
    let spread = mean.spread.as_ref()?;
    let one = |channel: Channel| {
        let write = |value: f64| format_quantity(value, channel.base_unit(), 3);
        let deviation = spread.mean_deviation(channel)?;
        let noise = spread.noise_of_average(channel)?;
        Some(format!(
            "{} by {} rms (noise of the average {})",
            channel.symbol(),
            write(deviation),
            write(noise)
        ))
    };
    let all: Vec<String> = Channel::ALL.into_iter().filter_map(one).collect();
    (!all.is_empty()).then(|| format!("the trials differ in {}", all.join(", in ")))
}

/// The lag, and what it was found by.
pub(super) fn lag_in_words(reference: &Recording, other: &Recording, overlay: &Overlay) -> String {
    let lag = format_quantity(overlay.lag.abs(), "s", 6);
    let moved = if overlay.lag < 0.0 {
        "earlier"
    } else {
        "later"
    };
    let samples = overlay.lag / reference.interval();
    let how = match overlay.by {
        None => "as given".to_owned(),
        Some(channel) => format!(
            "by their {} (correlation {:.5})",
            match channel {
                Channel::Voltage => "voltages",
                _ => "motion",
            },
            overlay.correlation
        ),
    };
    format!(
        "{} is laid over {} {lag} {moved} ({samples:.2} samples), {how}",
        other.name, reference.name
    )
}

/// That one clock runs faster, if it does.
pub(super) fn clock_in_words(other: &Recording, overlay: &Overlay) -> Option<String> {
    let difference = overlay.clock_difference?;
    let (way, off) = if difference > 0.0 {
        ("faster", difference * other.duration())
    } else {
        ("slower", -difference * other.duration())
    };
    Some(format!(
        "the clock of {} runs {:.1} ppm {way}, {} over its length; this is not taken out",
        other.name,
        1e6 * difference.abs(),
        format_quantity(off, "s", 3)
    ))
}

/// That a voltage that repeats gives the lag up to whole periods.
pub(super) fn period_in_words(reference: &Recording, overlay: &Overlay) -> Option<String> {
    if overlay.by != Some(Channel::Voltage) {
        return None;
    }
    let drive = reference.drive(DriveReading::Recognised)?.ok()?;
    let period = drive.period()?;
    (2.0 * period < reference.duration()).then(|| {
        format!(
            "the voltage repeats every {}: the lag is known up to whole periods, and the shortest is taken; where the motion has not settled, give --lag",
            format_quantity(period, "s", 4)
        )
    })
}
