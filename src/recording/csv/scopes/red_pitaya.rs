//! Red Pitaya, export of the oscilloscope application: `Time[ms], IN1, IN2` with a blank after each comma.
//! IN1 and IN2 carry no unit: some versions write volts, some divisions of the screen
//! (github.com/RedPitaya/RedPitaya, issue 116), so that their unit must be asked for. The same versions change
//! the unit of the times from row to row, which the reader of rows finds.

use super::{Head, ScopeHeader};

/// Inputs of the largest board, with the letters of its mathematical channel.
const INPUTS: [&str; 6] = ["in1", "in2", "in3", "in4", "math", "out1"];

pub(super) fn read(head: &Head) -> Option<ScopeHeader> {
    let cells = head.cells(0);
    let (time, channels) = cells.split_first()?;
    let time = time.trim();
    let (name, rest) = time.split_at(time.find(['[', '(', ' ']).unwrap_or(time.len()));
    if !["t", "time"].contains(&name.to_lowercase().as_str()) {
        return None;
    }
    let is_input = |cell: &String| {
        let name = cell.split(['[', '(', ' ']).find(|part| !part.is_empty());
        name.is_some_and(|name| INPUTS.contains(&name.trim().to_lowercase().as_str()))
    };
    if channels.is_empty() || !channels.iter().all(is_input) {
        return None;
    }
    let unit = rest.trim().trim_matches(['[', ']', '(', ')']).trim();
    let time = if unit.is_empty() {
        "Time".to_owned()
    } else {
        format!("Time [{unit}]")
    };
    let channels = channels.iter().map(|cell| cell.trim().to_owned());
    let cells = std::iter::once(time).chain(channels).collect();
    Some(ScopeHeader::new("Red Pitaya", cells, 0))
}
