//! Text of `validate --suspects`: the ranking of effects and the experiment to do next.

use std::io::Write;

use crate::diagnose::answer::next_experiment::experiment;
use crate::fit::table_a1::rank_effects::EffectRanking;
use crate::model::unit::format_quantity;

/// Largest voltage of the table \[V\].
const MAX_TABLE_VOLTAGE: f64 = 8.0;
/// Noise of the proposed recording \[m\].
const RECORDING_NOISE: f64 = 20e-9;

/// The ranking, for people.
pub fn summary(out: &mut dyn Write, ranking: &EffectRanking) -> anyhow::Result<()> {
    if ranking.cancelled {
        writeln!(out, "Cancelled: not all effects were tried.")?;
    }
    writeln!(
        out,
        "Effects, each fitted together with these parameters (robust sum of squares over the table, {:.1} without an effect):",
        ranking.cost
    )?;
    for s in &ranking.list {
        let value = format_quantity(s.value, s.unit, 3);
        write!(
            out,
            "  {:22} {:4} = {value:14} sum {:5.1}, peaks {:2.0} %, contacts {:2.0} %",
            s.id,
            s.strength,
            s.cost,
            100.0 * s.after.peak,
            100.0 * s.after.contact
        )?;
        match s.gain() {
            Some((mean, error)) => writeln!(
                out,
                "; at a held-out frequency {} by {:.1} +- {error:.1}",
                if mean > 0.0 { "better" } else { "worse" },
                mean.abs()
            )?,
            None => writeln!(out)?,
        }
    }
    let supported: Vec<&str> = ranking
        .list
        .iter()
        .filter(|s| s.is_supported())
        .map(|s| s.id)
        .collect();
    let checked = ranking.list.iter().any(|s| s.gain().is_some());
    if checked {
        match supported[..] {
            [] => writeln!(
                out,
                "None of them improves the held-out frequencies by twice its error: the table does not determine what is missing."
            )?,
            [one] => writeln!(out, "Only {one} improves the held-out frequencies.")?,
            _ => writeln!(
                out,
                "{} improve the held-out frequencies: the table does not distinguish them.",
                supported.join(", ")
            )?,
        }
    }
    if let Some((a, b)) = ranking.pair()
        && let Some(next) = experiment(
            (&a.model, a.id),
            (&b.model, b.id),
            MAX_TABLE_VOLTAGE,
            RECORDING_NOISE,
        )
    {
        writeln!(
            out,
            "A recording that would distinguish {} and {}: --drive {} (they differ by {:.0} of chi2 in 0.2 s of the proof mass alone, read to {:.0} nm at 20 kHz).",
            next.separates.0,
            next.separates.1,
            next.drive,
            next.expected,
            1e9 * RECORDING_NOISE
        )?;
    }
    writeln!(
        out,
        "Not tried: further modes and vibrations, because peaks, contacts and bounces do not determine their frequencies; a compliant ground and a compressible film, because they act for microseconds.\n"
    )?;
    Ok(())
}
