//! Whether recordings can be of one device, without a fit: the ring frequency in flight, and the
//! height above the ground at which the mass rests at a given voltage.

use std::sync::Arc;

use super::recording_summary::RecordingSummary;
use crate::fit::error::FitError;
use crate::fit::options::Part;
use crate::fit::thresholds::{
    DOUBTFUL_FREQUENCY_SHARE, FREQUENCY_DIFFERENCE_SIGMAS, OTHER_DEVICE_FREQUENCY_SHARE,
    REST_HEIGHT_TOLERANCE, RING_SEARCH_FACTOR, SAME_VOLTAGE_SHARE,
};
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::model::unit::format_quantity;
use crate::recording::rest_positions::rest_positions;
use crate::recording::ring::{Ring, ring_in};

/// The ring of the mass in the flights of a part's recording, searched for around `f1` \[Hz\].
fn ring_of(part: &Part, summary: &RecordingSummary, f1: f64) -> Option<Ring> {
    let r = &part.recording;
    let (from, to) = r.span();
    let mut flights = Vec::new();
    let mut begin = from;
    for contact in &summary.events(r).contacts {
        flights.push((begin, contact.start));
        begin = contact.end;
    }
    flights.push((begin, to));
    ring_in(
        r,
        &flights,
        summary.noise.0,
        (f1 / RING_SEARCH_FACTOR, f1 * RING_SEARCH_FACTOR),
    )
}

/// Checks that the mass rings at one frequency in all parts that show a ring. Sentences on
/// what is doubtful, where it may still be one device.
///
/// # Errors
/// [`FitError::DifferentDevices`] if the frequencies are far apart.
pub fn check_ring_frequency(
    model: &Model,
    parts: &[Part],
    summaries: &[RecordingSummary],
) -> Result<Option<String>, FitError> {
    let f1 = model.parameters[ParameterId::F1];
    if !model.uses(ParameterId::F1) || f1.is_nan() || f1 <= 0.0 || !of_several(parts) {
        return Ok(None);
    }
    // Two parts of one recording are of one device.
    let again = |i: usize| {
        let own = &parts[i].recording;
        parts[..i].iter().any(|p| Arc::ptr_eq(&p.recording, own))
    };
    let mut rings: Vec<(&Part, Ring)> = parts
        .iter()
        .zip(summaries)
        .enumerate()
        .filter(|(i, _)| !again(*i))
        .map(|(_, both)| both)
        .filter_map(|(part, found)| Some((part, ring_of(part, found, f1)?)))
        .collect();
    rings.sort_by(|a, b| a.1.frequency.total_cmp(&b.1.frequency));
    let (Some((slow, a)), Some((fast, b))) = (rings.first(), rings.last()) else {
        return Ok(None);
    };
    log::debug!("rings from {a:?} to {b:?}");
    let apart = b.frequency - a.frequency;
    if apart <= FREQUENCY_DIFFERENCE_SIGMAS * a.error.hypot(b.error)
        || apart <= DOUBTFUL_FREQUENCY_SHARE * a.frequency
    {
        return Ok(None);
    }
    let (slow, fast) = (&slow.recording.name, &fast.recording.name);
    let write = |ring: &Ring| format_quantity(ring.frequency, "Hz", 4);
    if apart > OTHER_DEVICE_FREQUENCY_SHARE * a.frequency {
        return Err(FitError::DifferentDevices {
            recording: fast.clone(),
            other: slow.clone(),
            evidence: format!(
                "in flight it rings at {}, the other at {}",
                write(b),
                write(a)
            ),
        });
    }
    Ok(Some(format!(
        "in flight the mass rings at {} in {slow} and at {} in {fast}: they may be of different devices, or the spring is not linear",
        write(a),
        write(b)
    )))
}

/// A sentence on the two parts in which the mass comes to rest at the most different
/// heights above the ground, at the same voltage.
pub fn rest_height_doubt(parts: &[Part], summaries: &[RecordingSummary]) -> Option<String> {
    if !of_several(parts) {
        return None;
    }
    let mut all = Vec::new();
    for (part, found) in parts.iter().zip(summaries) {
        let r = &part.recording;
        if let Ok(level) = found.level {
            let own = rest_positions(r, &found.as_moved(r), level, found.noise.0);
            all.extend(own.into_iter().map(|rest| (part, rest)));
        }
    }
    let mut most = 1.0;
    let mut out = None;
    for (i, (a, x)) in all.iter().enumerate() {
        for (b, y) in &all[..i] {
            let same = (x.voltage - y.voltage).abs() <= SAME_VOLTAGE_SHARE * x.voltage.abs();
            let limit = REST_HEIGHT_TOLERANCE
                .1
                .max(REST_HEIGHT_TOLERANCE.0 * x.height.max(y.height));
            let apart = (x.height - y.height).abs() / limit;
            if same && apart > most && !Arc::ptr_eq(&a.recording, &b.recording) {
                most = apart;
                let write = |height| format_quantity(height, "m", 4);
                out = Some(format!(
                    "at {} the mass comes to rest {} above the ground in {} and {} above it in {}: they may be of different devices, or the ground was moved",
                    format_quantity(x.voltage, "V", 3),
                    write(y.height),
                    b.recording.name,
                    write(x.height),
                    a.recording.name
                ));
            }
        }
    }
    out
}

/// Whether the parts are of more than one recording.
fn of_several(parts: &[Part]) -> bool {
    parts
        .iter()
        .any(|p| !Arc::ptr_eq(&p.recording, &parts[0].recording))
}

#[cfg(test)]
mod tests {
    use super::super::recording_summary::summarize;
    use super::super::same_device::*;
    use crate::fit::tests::{made, off, paper, part};

    /// Two recordings: of the device of the preset, and of one with other parameters.
    fn pair(changes: &[(&str, f64)]) -> (Vec<Part>, Vec<RecordingSummary>) {
        let parts = vec![
            part(made(&paper(), "square:10Hz:8V", 0.2, 1)),
            part(made(&off(paper(), changes), "square:8Hz:8V", 0.2, 2)),
        ];
        let summaries = summarize(&paper(), &parts);
        (parts, summaries)
    }

    #[test]
    fn other_frequencies_are_of_other_devices() {
        let (parts, summaries) = pair(&[("f1", 1.25)]);
        let error = check_ring_frequency(&paper(), &parts, &summaries).unwrap_err();
        let text = error.to_string();
        assert!(
            text.contains("square:10Hz:8V") && text.contains("rings at"),
            "{text}"
        );
        let (parts, summaries) = pair(&[("f1", 1.06)]);
        let doubt = check_ring_frequency(&paper(), &parts, &summaries).unwrap();
        assert!(doubt.is_some_and(|text| text.contains("may be of different")));
    }

    #[test]
    fn another_ground_level_shows_in_the_height_of_rest() {
        let (parts, summaries) = pair(&[("dp", 53.0 / 58.0)]);
        let doubt = rest_height_doubt(&parts, &summaries);
        assert!(doubt.is_some_and(|text| text.contains("at -8 V")));
        assert_eq!(check_ring_frequency(&paper(), &parts, &summaries), Ok(None));
    }

    #[test]
    fn recordings_of_one_device_raise_no_doubt() {
        // Damping, film and adhesion are not what makes a device another one here.
        let (parts, summaries) = pair(&[("Cs", 2.0), ("alpha", 1.3)]);
        assert_eq!(check_ring_frequency(&paper(), &parts, &summaries), Ok(None));
        assert_eq!(rest_height_doubt(&parts, &summaries), None);
        let (first, second) = Part::split(Arc::clone(&parts[0].recording));
        let halves = [first, second];
        assert!(!of_several(&halves));
        assert_eq!(
            check_ring_frequency(&paper(), &halves, &summarize(&paper(), &halves)),
            Ok(None)
        );
    }
}
