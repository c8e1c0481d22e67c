//! Tektronix. TDS1000 and TDS2000: `F0001CH1.CSV`, a preamble in the first three columns beside the
//! numbers in the fourth (time) and fifth. DPO, MSO, TBS: a block of `Name,value` lines above
//! `TIME,CH1,CH2`, with `Vertical Units,V,V`.

use super::{Head, ScopeHeader, number, with_units};

pub(super) fn read(head: &Head) -> Option<ScopeHeader> {
    beside(head).or_else(|| above(head))
}

fn beside(head: &Head) -> Option<ScopeHeader> {
    let (line, cells) = head.named("Record Length")?;
    // The first row of numbers stands in the first line of the preamble.
    number(cells.get(3)?)?;
    number(cells.get(4)?)?;
    if line != 0 {
        return None;
    }
    let text = |name: &str| {
        let values = head.values(name)?;
        values
            .first()
            .map(|v| v.trim().to_owned())
            .filter(|v| !v.is_empty())
    };
    let source = text("Source").unwrap_or_else(|| "CH1".to_owned());
    let vertical = text("Vertical Units").unwrap_or_else(|| "V".to_owned());
    let horizontal = text("Horizontal Units").unwrap_or_else(|| "s".to_owned());
    let names: Vec<String> = [
        "preamble name",
        "preamble setting",
        "preamble unit",
        &format!("Time [{horizontal}]"),
        &format!("{source} [{vertical}]"),
    ]
    .map(str::to_owned)
    .to_vec();
    // No line is the header alone.
    Some(ScopeHeader {
        last_line: usize::MAX,
        ..ScopeHeader::new("Tektronix TDS", names, 0)
    })
}

fn above(head: &Head) -> Option<ScopeHeader> {
    let (line, names) = head.named("TIME")?;
    let vertical = head.values("Vertical Units")?;
    head.named("Model")
        .or_else(|| head.named("Sample Interval"))?;
    let horizontal = head.values("Horizontal Units").unwrap_or_default();
    let horizontal = horizontal.first().map_or("s", |u| u.trim()).to_lowercase();
    let units: Vec<String> = std::iter::once(horizontal).chain(vertical).collect();
    Some(ScopeHeader::new(
        "Tektronix",
        with_units(&names, &units),
        line,
    ))
}
