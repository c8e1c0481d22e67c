//! Rohde & Schwarz RTB, RTM, RTA: one header row, `in s,C1 in V,C2 in V`.

use super::{Head, ScopeHeader};

pub(super) fn read(head: &Head) -> Option<ScopeHeader> {
    let (line, names) = head.named("in s")?;
    let cells = names
        .iter()
        .enumerate()
        .filter(|(i, name)| *i == 0 || !name.trim().is_empty())
        .map(|(i, name)| match i {
            0 => "time [s]".to_owned(),
            _ => match name.rsplit_once(" in ") {
                Some((channel, unit)) => format!("{} [{}]", channel.trim(), unit.trim()),
                None => name.clone(),
            },
        })
        .collect();
    Some(ScopeHeader::new("Rohde & Schwarz", cells, line))
}
