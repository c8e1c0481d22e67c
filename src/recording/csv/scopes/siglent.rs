//! Siglent SDS: lines `Name,value` with `Vertical Units,CH1:V,CH2:V`, then `Source,CH1,CH2` above
//! `Second,Volt,Volt` (or `Second,Value`).

use super::{Head, ScopeHeader, with_units};

pub(super) fn read(head: &Head) -> Option<ScopeHeader> {
    let (line, below) = head.named("Second")?;
    let (source_line, mut names) = head.named("Source")?;
    if source_line + 1 != line {
        return None;
    }
    let vertical = head.values("Vertical Units").unwrap_or_default();
    *names.first_mut()? = "time".to_owned();
    let units: Vec<String> = below
        .iter()
        .enumerate()
        .map(|(i, unit)| {
            if i == 0 {
                return "s".to_owned();
            }
            if !unit.eq_ignore_ascii_case("Value") {
                return unit.clone();
            }
            let own = vertical.get(i - 1).map_or("", |u| u.trim());
            own.rsplit(':').next().unwrap_or(own).to_owned()
        })
        .collect();
    Some(ScopeHeader::new(
        "Siglent",
        with_units(&names, &units),
        line,
    ))
}
