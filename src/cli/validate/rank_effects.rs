//! What `validate --suspects` says.

use std::io::Write;

use crate::diagnose::answer::next_experiment::experiment;
use crate::fit::table_a1::rank_effects::EffectRanking;
use crate::model::unit::format_quantity;

/// Largest voltage of the table \[V\].
const MAX_TABLE_VOLTAGE: f64 = 8.0;
/// Noise of a recording that would separate two suspects \[m\].
const RECORDING_NOISE: f64 = 20e-9;

/// What the suspects came to, for people.
pub fn summary(out: &mut dyn Write, asked: &EffectRanking) -> anyhow::Result<()> {
    if asked.cancelled {
        writeln!(out, "Cancelled: not all suspects were asked.")?;
    }
    writeln!(
        out,
        "Suspects, each fitted beside these parameters (sum of the rows' robust squares, {:.1} without):",
        asked.cost
    )?;
    for s in &asked.list {
        let value = format_quantity(s.value, s.unit, 3);
        let line = |error: f64| format!("{:5.1}", error);
        write!(
            out,
            "  {:22} {:4} = {value:14} sum {}, peaks {:2.0} %, contacts {:2.0} %",
            s.id,
            s.strength,
            line(s.cost),
            100.0 * s.after.peak,
            100.0 * s.after.contact
        )?;
        match s.gain() {
            Some((mean, error)) => writeln!(
                out,
                "; at a frequency left out {} by {:.1} +- {error:.1}",
                if mean > 0.0 { "nearer" } else { "farther off" },
                mean.abs()
            )?,
            None => writeln!(out)?,
        }
    }
    let told: Vec<&str> = asked
        .list
        .iter()
        .filter(|s| s.told())
        .map(|s| s.id)
        .collect();
    let checked = asked.list.iter().any(|s| s.gain().is_some());
    if checked {
        match told[..] {
            [] => writeln!(
                out,
                "None of them brings the frequencies that it was not shown nearer by twice its error: the table does not tell what is missing."
            )?,
            [one] => writeln!(
                out,
                "{one} alone brings the frequencies that it was not shown nearer."
            )?,
            _ => writeln!(
                out,
                "{} bring the frequencies that they were not shown nearer: the table does not tell them apart.",
                told.join(", ")
            )?,
        }
    }
    if let Some((a, b)) = asked.pair()
        && let Some(next) = experiment(
            (&a.model, a.id),
            (&b.model, b.id),
            MAX_TABLE_VOLTAGE,
            RECORDING_NOISE,
        )
    {
        writeln!(
            out,
            "A recording that would separate {} and {}: --drive {} (they differ by {:.0} of chi2 in 0.2 s of the proof mass alone, read to {:.0} nm at 20 kHz).",
            next.separates.0,
            next.separates.1,
            next.drive,
            next.expected,
            1e9 * RECORDING_NOISE
        )?;
    }
    writeln!(
        out,
        "Further modes and vibrations were not asked, as peaks, contacts and bounces do not hold their frequencies; nor a ground that gives way and a compressible film.\n"
    )?;
    Ok(())
}
