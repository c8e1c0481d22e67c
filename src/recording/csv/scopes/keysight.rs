//! Keysight and Agilent InfiniiVision: two header rows, `x-axis,1,2` and `second,Volt,Volt`. Infiniium:
//! a block of `Name:,value` with `XOrg`, `XInc`, `X Units`, `Y Units`, and a line `Data:` before the
//! numbers (Infiniium programmer's guide, "CSV file header").

use super::{Head, ScopeHeader, with_units};
use crate::recording::csv::settings::SampleClock;

pub(super) fn read(head: &Head) -> Option<ScopeHeader> {
    infinii_vision(head).or_else(|| infiniium(head))
}

fn infinii_vision(head: &Head) -> Option<ScopeHeader> {
    let (line, mut names) = head.named("x-axis")?;
    let units = head.cells(line + 1);
    if !units.first()?.to_lowercase().starts_with("second") {
        return None;
    }
    *names.first_mut()? = "time".to_owned();
    for name in names.iter_mut().skip(1).filter(|n| !n.trim().is_empty()) {
        *name = name.trim().to_owned();
    }
    let cells = with_units(&names, &units);
    Some(ScopeHeader::new("Keysight InfiniiVision", cells, line + 1))
}

fn infiniium(head: &Head) -> Option<ScopeHeader> {
    let interval = head.number("XInc")?;
    let start = head.number("XOrg").unwrap_or(0.0);
    let units = head.values("Y Units")?;
    let (line, _) = head.named("Data").or_else(|| head.named("XY Data"))?;
    let first = head.cells(line + 1);
    let filled = first.iter().filter(|c| !c.trim().is_empty()).count();
    let channels = units.iter().filter(|u| !u.trim().is_empty()).count().max(1);
    let mut names: Vec<String> = (1..=channels).map(|i| format!("Channel {i}")).collect();
    let mut own = units;
    let has_times = filled > channels;
    if has_times {
        names.insert(0, "time".to_owned());
        own.insert(0, "s".to_owned());
    }
    let header = ScopeHeader::new("Keysight Infiniium", with_units(&names, &own), line);
    Some(ScopeHeader {
        clock: (!has_times && interval > 0.0).then_some(SampleClock { start, interval }),
        ..header
    })
}
