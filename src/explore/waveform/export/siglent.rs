//! Siglent's CSV of an arbitrary waveform.
//!
//! Lines `data length`, `frequency` \[Hz\], `amp` (peak to peak, V), `offset` \[V\] and `phase`
//! \[deg\], each with a comma and its value, seven empty lines, the headings `xpos,value`, then
//! time \[s\] and voltage \[V\] of each sample. This is the CSV of Siglent's EasyWave, in the form
//! in which public programs write it for an SDG1032X (GitHub:
//! LuizFernandoOliveira/SIGLENT-data-converter, "mandatory header"). The generator rounds
//! `(value - offset) / (amp / 2)` to its 14 or 16 bits. Not tried on an instrument.

use std::fmt::Write;

use super::Period;

/// Fewest and most samples: the memory of an SDG1000X holds 16 kpts.
pub(super) const SAMPLE_COUNTS: (usize, usize) = (2, 16_384);

/// Lines between the values and the headings.
const EMPTY_LINES: usize = 7;

pub(super) fn text(period: &Period) -> Result<String, String> {
    let (low, high) = period.range();
    if high <= low {
        return Err(format!(
            "{low} V throughout is no waveform; set this voltage as DC at the generator"
        ));
    }
    let (count, frequency) = (period.voltage.len(), period.frequency);
    let mut text = format!(
        "data length,{count}\nfrequency,{frequency}\namp,{:.9}\noffset,{:.9}\nphase,0.000000000\n",
        high - low,
        0.5 * (high + low)
    );
    text.push_str(&",\n".repeat(EMPTY_LINES));
    text.push_str("xpos,value\n");
    for (i, voltage) in period.voltage.iter().enumerate() {
        let time = i as f64 / (count as f64 * frequency);
        // Writing to a string does not fail.
        let _ = writeln!(text, "{time:.6E},{voltage:.9}");
    }
    Ok(text)
}
