//! LeCroy ASCII traces: `LECROYWS3024,10000,Waveform`, `Segments,n,SegmentSize,m`, one line
//! `#i,trigger time,since segment 1` a segment, then `Time,Ampl` and the rows of all segments. The
//! amplitude is in volts; where times begin again, the next segment begins.

use super::{Head, ScopeHeader};

pub(super) fn read(head: &Head) -> Option<ScopeHeader> {
    let first = head.lines.first()?.trim_ascii();
    if !first.to_ascii_uppercase().starts_with(b"LECROY") {
        return None;
    }
    let (line, names) = head.named("Time")?;
    let cells = names
        .iter()
        .enumerate()
        .map(|(i, name)| match i {
            0 => "Time [s]".to_owned(),
            _ if name.eq_ignore_ascii_case("Ampl") => "Ampl [V]".to_owned(),
            _ => name.clone(),
        })
        .collect();
    Some(ScopeHeader::new("LeCroy", cells, line))
}
