//! Digilent WaveForms: lines `#Digilent WaveForms Oscilloscope Acquisition`, `#Sample rate: 100000Hz`,
//! `#Samples: 8192`, then `Time (s),Channel 1 (V),Channel 2 (V)`. Times may be switched off; the rate in the
//! comments then says them.

use super::{Head, ScopeHeader, number};
use crate::recording::csv::settings::SampleClock;

/// Lines of the head in which the header is looked for.
const MAX_HEADER_LINES: usize = 60;

pub(super) fn read(head: &Head) -> Option<ScopeHeader> {
    let title = head.lines.first()?.trim_ascii();
    if !title.starts_with(b"#Digilent WaveForms") {
        return None;
    }
    let is_comment = |line: &[u8]| line.is_empty() || line.starts_with(b"#");
    let mut lines = head.lines.iter().take(MAX_HEADER_LINES);
    let line = lines.position(|line| !is_comment(line.trim_ascii()))?;
    let cells = head.cells(line);
    let first = cells.first()?.trim();
    if number(first).is_some() {
        return None;
    }
    let has_times = first.to_lowercase().starts_with("time");
    let clock = if has_times { None } else { Some(clock(head)?) };
    Some(ScopeHeader {
        clock,
        ..ScopeHeader::new("Digilent WaveForms", cells, line)
    })
}

/// The clock that `#Sample rate: 100kHz` says.
fn clock(head: &Head) -> Option<SampleClock> {
    let rate = head.lines.iter().find_map(|line| {
        let text = String::from_utf8_lossy(line).to_lowercase();
        let value = text.strip_prefix("#sample rate:")?.trim().to_owned();
        crate::model::unit::parse_quantity(value.trim_end_matches("hz"), "")
            .ok()
            .or_else(|| rate_with_prefix(&value))
    })?;
    (rate > 0.0).then(|| SampleClock {
        start: 0.0,
        interval: 1.0 / rate,
    })
}

/// `100khz` or `1.5mhz`: megahertz, for a recorder of millihertz has no such header.
fn rate_with_prefix(value: &str) -> Option<f64> {
    let text = value.strip_suffix("hz")?.trim();
    let (text, factor) = match text.as_bytes().last()? {
        b'k' => (text.strip_suffix('k')?, 1e3),
        b'm' => (text.strip_suffix('m')?, 1e6),
        b'g' => (text.strip_suffix('g')?, 1e9),
        _ => (text, 1.0),
    };
    number(text).map(|rate| rate * factor)
}
