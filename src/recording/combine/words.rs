//! What was found of a lag, in words.

use super::overlay::Overlay;
use crate::model::drive::DriveReading;
use crate::model::unit::format_quantity;
use crate::recording::{Channel, Recording};

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
