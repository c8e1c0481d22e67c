//! Rigol. DS1000Z: `X,CH1,CH2,Start,Increment,` above `Sequence,Volt,Volt,-1e-1,2.5e-4`; the first
//! column counts samples. MSO5000, DS2000, DHO: `Time(s),CH1V,CH2V,t0 =-1.2e-3,tInc = 2e-7,` with or
//! without the times.

use super::{Head, ScopeHeader, number, with_units};
use crate::recording::csv::settings::SampleClock;

pub(super) fn read(head: &Head) -> Option<ScopeHeader> {
    sequence(head).or_else(|| named_increment(head))
}

fn sequence(head: &Head) -> Option<ScopeHeader> {
    let (line, names) = ["X", "Time"]
        .iter()
        .filter_map(|name| head.named(name))
        .find(|(_, cells)| cells.iter().any(|c| c.eq_ignore_ascii_case("Increment")))?;
    let values = head.cells(line + 1);
    let value = |name: &str| {
        let at = names.iter().position(|c| c.eq_ignore_ascii_case(name))?;
        number(values.get(at)?)
    };
    let (start, interval) = (value("Start")?, value("Increment")?);
    let channels = names
        .iter()
        .position(|c| c.eq_ignore_ascii_case("Start"))
        .unwrap_or(names.len());
    let mut own: Vec<String> = names.iter().take(channels).cloned().collect();
    let counts = values.first()?.eq_ignore_ascii_case("Sequence");
    let mut units: Vec<String> = values.iter().take(channels).cloned().collect();
    *own.first_mut()? = if counts { "Sample" } else { "time" }.to_owned();
    *units.first_mut()? = if counts { "" } else { "s" }.to_owned();
    let header = ScopeHeader::new("Rigol", with_units(&own, &units), line + 1);
    Some(ScopeHeader {
        clock: (counts && interval > 0.0).then_some(SampleClock { start, interval }),
        ..header
    })
}

fn named_increment(head: &Head) -> Option<ScopeHeader> {
    let line = head.lines.iter().take(4).position(|line| {
        let text = String::from_utf8_lossy(line).to_lowercase();
        text.contains("tinc") && text.contains("t0")
    })?;
    let cells = head.cells(line);
    let value = |name: &str| {
        let cell = cells.iter().find(|c| c.trim().starts_with(name))?;
        number(cell.split_once('=')?.1.trim().trim_end_matches('s'))
    };
    let (start, interval) = (value("t0")?, value("tInc")?);
    let named = cells.iter().take_while(|c| !c.trim().starts_with('t'));
    // "CH1V": the channel and its unit.
    let mut own: Vec<String> = named
        .map(|cell| match cell.trim().strip_suffix('V') {
            Some(channel) if channel.starts_with("CH") => format!("{channel} [V]"),
            _ => cell.trim().to_owned(),
        })
        .collect();
    let numbers = head.cells(line + 1);
    let has_times = own
        .first()
        .is_some_and(|c| c.to_lowercase().starts_with("time"));
    let empty = numbers.first().is_some_and(|c| c.trim().is_empty());
    if has_times && empty {
        *own.first_mut()? = "unused".to_owned();
    }
    let needs_clock = (!has_times || empty) && interval > 0.0;
    Some(ScopeHeader {
        clock: needs_clock.then_some(SampleClock { start, interval }),
        ..ScopeHeader::new("Rigol", own, line)
    })
}
