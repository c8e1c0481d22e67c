//! A sampling rate or interval in the lines before the rows.

use super::units::unit_shift;
use crate::model::unit::unit_factor;
use crate::recording::csv::settings::SampleClock;

/// Names of a rate and of an interval, without spaces and signs. Longest first.
const RATES: [&str; 10] = [
    "samplingfrequency",
    "samplefrequency",
    "samplingrate",
    "samplerate",
    "abtastrate",
    "acquisitionrate",
    "framerate",
    "samplefreq",
    "fs",
    "rate",
];
const INTERVALS: [&str; 15] = [
    "samplinginterval",
    "sampleinterval",
    "samplingperiod",
    "sampleperiod",
    "samplingtime",
    "sampletime",
    "timeinterval",
    "timestep",
    "xincrement",
    "increment",
    "sampling",
    "xinc",
    "deltat",
    "deltax",
    "dt",
];

/// The sampling clock that one of `lines` names: `Sample rate: 4000 Hz`, `dt = 20us`,
/// `Sampling Interval,2.5e-4,s`.
pub(in crate::recording::csv) fn find(lines: &[String]) -> Option<SampleClock> {
    lines.iter().find_map(|line| clock_of(line))
}

fn clock_of(line: &str) -> Option<SampleClock> {
    let lower = line.to_lowercase();
    let start = lower.find(|c: char| c.is_ascii_digit())?;
    let mut name: String = lower
        .get(..start)?
        .chars()
        .filter(|c| c.is_alphabetic())
        .collect();
    let rest = line.get(start..)?;
    let is_number = |c: char| c.is_ascii_digit() || matches!(c, '.' | 'e' | 'E' | '+' | '-');
    let end = rest.find(|c: char| !is_number(c)).unwrap_or(rest.len());
    let number: f64 = rest.get(..end)?.trim_end_matches(['e', 'E']).parse().ok()?;
    let unit = rest.get(end..)?;
    let unit = unit.trim_matches(|c: char| !c.is_alphanumeric() && c != '/' && c != '\u{b5}');
    let unit = unit
        .split([',', ';', '\t', ' ', ')', ']'])
        .next()
        .unwrap_or_default();
    // "Sample rate (Hz): 4000": the unit stands before the number.
    let bracketed = line
        .get(..start)
        .and_then(|before| before.rsplit_once(['(', '[']))
        .and_then(|(_, inner)| inner.split([')', ']']).next());
    if let Some(inner) = bracketed {
        let letters: String = inner
            .to_lowercase()
            .chars()
            .filter(|c| c.is_alphabetic())
            .collect();
        if let Some(short) = name.strip_suffix(&letters) {
            name = short.to_owned();
        }
    }
    let unit = if unit.is_empty() {
        bracketed.unwrap_or_default()
    } else {
        unit
    };
    let is_named = |names: &[&str]| {
        names
            .iter()
            .any(|n| name == *n || (n.len() > 4 && name.ends_with(n)))
    };
    let interval = if is_named(&RATES) {
        let per_second = ["Sa/s", "S/s", "samples/s", "fps", "SPS", "sps"];
        let factor = per_second
            .iter()
            .find_map(|word| unit.strip_suffix(word))
            .map_or_else(
                || hertz(unit),
                |prefix| unit_factor(&format!("{prefix}m"), "m"),
            )?;
        1.0 / (number * factor)
    } else if is_named(&INTERVALS) {
        number * 10f64.powi(unit_shift(unit, "s")?)
    } else {
        return None;
    };
    let clock = SampleClock {
        start: 0.0,
        interval,
    };
    (interval.is_finite() && interval > 0.0).then_some(clock)
}

fn hertz(unit: &str) -> Option<f64> {
    let lower = unit.to_lowercase();
    match lower.as_str() {
        "" | "hz" | "1/s" => Some(1.0),
        "khz" => Some(1e3),
        "mhz" => Some(1e6),
        "ghz" => Some(1e9),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::header_clock::*;

    #[test]
    fn rates_and_intervals_are_found() {
        for (line, interval) in [
            ("Sample rate: 4000 Hz", 250e-6),
            ("Sampling frequency 4 kHz", 250e-6),
            ("Fs = 4000", 250e-6),
            ("dt=20us", 20e-6),
            ("Sample Interval,2.5e-04,s", 250e-6),
            ("Sample rate (kHz): 4", 250e-6),
            ("Rate: 4 kS/s", 250e-6),
            ("Abtastrate; 50000; Hz", 20e-6),
        ] {
            let found = find(&[line.to_owned()]).unwrap_or_else(|| panic!("{line}"));
            assert!(
                (found.interval / interval - 1.0).abs() < 1e-12,
                "{line}: {found:?}"
            );
        }
        for line in [
            "Drive frequency 15 Hz",
            "Model,TDS2014C",
            "Bandwidth: 20 kHz",
            "dt = 5 kg",
        ] {
            assert_eq!(find(&[line.to_owned()]), None, "{line}");
        }
    }
}
