//! Time and voltage in two columns, exact to the last bit.

use std::fmt::Write;

use super::Period;

/// Fewest and most samples: two make a step, a million is the memory of large generators.
pub(super) const SAMPLE_COUNTS: (usize, usize) = (2, 1_000_000);

pub(super) fn text(period: &Period, has_header: bool) -> String {
    let mut text = String::new();
    if has_header {
        text.push_str("t [s],V [V]\n");
    }
    let rate = period.frequency * period.voltage.len() as f64;
    for (i, voltage) in period.voltage.iter().enumerate() {
        // Writing to a string does not fail.
        let _ = writeln!(text, "{:e},{voltage}", i as f64 / rate);
    }
    text
}
