//! Units of functions: by their label, or by the units of the file, dataset 164.

use super::super::lines::Lines;
use super::function::Header;

/// Dataset 164: what the numbers of a unit are divided by to be SI.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Units {
    description: String,
    length: f64,
    force: f64,
}

/// Reads the two records that matter; `None` if they are not as they should be.
pub(super) fn read_units(lines: &mut Lines) -> Option<Units> {
    let first = String::from_utf8_lossy(lines.next()?).into_owned();
    let second = String::from_utf8_lossy(lines.next()?).replace(['D', 'd'], "E");
    let mut factors = second.split_whitespace().map(str::parse::<f64>);
    let mut factor = || factors.next()?.ok().filter(|f| f.is_finite() && *f > 0.0);
    let (length, force) = (factor()?, factor()?);
    let description = first.chars().skip(10).take(20).collect::<String>();
    Some(Units {
        description: description.trim().to_owned(),
        length,
        force,
    })
}

/// The unit of a function's ordinate. A label is the unit as it is; without one the file's units
/// (164) give SI, and without those SI is the format's rule. Notes what was scaled or supposed.
pub(super) fn apply(
    header: &Header,
    units: Option<&Units>,
    values: &mut [f64],
) -> (Option<String>, Option<String>) {
    if !header.ordinate_unit.is_empty() {
        return (Some(header.ordinate_unit.clone()), None);
    }
    // Specific data types of dataset 58, record 9.
    let (unit, factor) = match header.ordinate_type {
        8 => ("m", units.map(|units| units.length)),
        11 => ("m/s", units.map(|units| units.length)),
        12 => ("m/s^2", units.map(|units| units.length)),
        9 | 13 => ("N", units.map(|units| units.force)),
        _ => return (None, None),
    };
    let name = header.name();
    let note = match (factor, units) {
        (Some(factor), Some(units)) if factor != 1.0 => {
            values.iter_mut().for_each(|v| *v /= factor);
            format!(
                "\"{name}\" was divided by {factor} to be in {unit}: the file's units are \"{}\".",
                units.description
            )
        }
        (Some(_), Some(_)) => return (Some(unit.to_owned()), None),
        _ => format!("\"{name}\" has no unit in the file; SI ({unit}) is the format's rule."),
    };
    (Some(unit.to_owned()), Some(note))
}
