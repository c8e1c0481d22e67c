//! A force balance as text and as a value for programs.

use serde_json::{Map, Value, json};

use super::words;
use crate::diagnose::diagnosis::{BalanceCurve, Estimate};
use crate::diagnose::force_balance::{BalanceChi2, BalancedEffect, ForceBalance};
use crate::model::unit::prefix_for;

/// Effects that are listed with what each alone would bring.
const LISTED_CANDIDATES: usize = 6;

/// The balance in sentences; `None` where no flight was long enough for one.
pub fn text(found: Option<&ForceBalance>) -> String {
    let Some(found) = found else {
        return "No flight is long enough for a force balance.\n".to_owned();
    };
    let mut out = String::new();
    let per_row = |chi2: &BalanceChi2| {
        let held = chi2.held_out_per_row();
        let own = format!("{:.2} on fitted recordings", chi2.train_per_row());
        if held.is_finite() {
            format!("{own}, {held:.2} on held-out ones")
        } else {
            own
        }
    };
    out += "Force balance in flight, mean square in units of the noise (1: nothing is missing)\n";
    out += &format!("  as the model is: {}\n", per_row(&found.before));
    if found.candidates.is_empty() {
        out += "No effect of the catalogue was compared.\n";
    } else if found.effects.is_empty() {
        out += "No effect of the catalogue brings more than chance.\n";
    } else {
        out += &format!("  with what follows: {}\n", per_row(&found.after));
    }
    for e in &found.effects {
        out += &format!("{}: {}\n", e.effect.spec.name, parameters(e).join(", "));
    }
    if !found.candidates.is_empty() {
        out += "Each alone, mean square on held-out recordings\n";
    }
    for c in found.candidates.iter().take(LISTED_CANDIDATES) {
        out += &format!("  {:<24} {:.2}\n", c.id, c.held_out_per_row);
    }
    if let Some(strongest) = found.forces.strongest() {
        out += &curve_text(strongest);
    }
    out
}

/// The curve as a table.
fn curve_text(c: &BalanceCurve) -> String {
    let curve = &c.curve;
    let mut out = format!("{}\n{}\n", curve_sentence(c), absorbed_sentence(c));
    let largest = |values: &[f64]| values.iter().fold(0.0f64, |a, v| a.max(v.abs()));
    let unit = |size: f64, base: &'static str| {
        let (prefix, factor) = prefix_for(size, base);
        (format!("{prefix}{base}"), factor)
    };
    let (x_unit, x) = unit(largest(&curve.at), curve.unit);
    let (f_unit, f) = unit(largest(&curve.force), "N");
    let has_law = !curve.law.is_empty();
    let law = if has_law {
        "  of the effects found"
    } else {
        ""
    };
    let head = format!("{} [{x_unit}]", curve.against);
    out += &format!("  {head:>12}  missing force [{f_unit}]{law}\n");
    for i in 0..curve.at.len() {
        let both = format!(
            "{:.3} \u{b1} {:.3}",
            curve.force[i] / f,
            curve.std_error[i] / f
        );
        out += &format!("  {:>12.3}  {both:>18}", curve.at[i] / x);
        if has_law {
            out += &format!("  {:>20.3}", curve.law[i] / f);
        }
        out.push('\n');
    }
    out
}

/// What one sees in a curve, in a sentence.
pub fn curve_sentence(c: &BalanceCurve) -> String {
    /// Gain of a curve, in ones of chance, below which it says nothing at all.
    const CHANCE_FACTOR: f64 = 4.0;
    let symbol = c.curve.against;
    let fitted = format!(
        "chi2 falls by {} on fitted recordings, by chance {}",
        words::gain(c.gain.0),
        c.by_chance
    );
    if c.is_significant {
        format!("A force over {symbol} is missing in flight: {fitted}.")
    } else if c.gain.0 < CHANCE_FACTOR * c.by_chance as f64 {
        format!("No force over {symbol} is seen to be missing in flight: {fitted}.")
    } else {
        format!(
            "A force over {symbol} alone is not confirmed: {fitted}; on held-out ones {}.",
            words::gain(c.gain.1)
        )
    }
}

/// What the recordings do not determine of a curve, in a sentence.
pub fn absorbed_sentence(c: &BalanceCurve) -> &'static str {
    match (c.absorbed.constant, c.absorbed.slope) {
        (true, true) => "Drawn without its mean and its slope, which re-tuning absorbs.",
        (true, false) => "Drawn without its mean, which the zeros of the recordings absorb.",
        (false, true) => "Drawn without its slope, which re-tuning absorbs.",
        (false, false) => "The whole force: re-tuning absorbs nothing of it.",
    }
}

/// The fitted parameters of an effect with their standard errors.
fn parameters(e: &BalancedEffect) -> Vec<String> {
    let both = e.free.iter().zip(&e.errors);
    let one = |(&i, error): (&usize, &f64)| {
        let spec = &e.effect.spec.parameters[i];
        let estimate = Estimate {
            id: spec.id.to_owned(),
            value: e.effect.values[i],
            std_error: *error,
            unit: spec.unit,
        };
        format!("{} = {}", spec.symbol, words::with_error(&estimate))
    };
    both.map(one).collect()
}

/// A curve as a value, SI.
fn curve(c: &BalanceCurve) -> Value {
    json!({
        "against": c.quantity,
        "unit": c.curve.unit,
        "at": c.curve.at,
        "force": c.curve.force,
        "std_error": c.curve.std_error,
        "law": c.curve.law,
        "without": { "constant": c.absorbed.constant, "slope": c.absorbed.slope },
        "gain": { "train": c.gain.0, "held_out": c.gain.1, "by_chance": c.by_chance },
        "significant": c.is_significant,
    })
}

/// The balance as a value, SI; `null` where there is none. Numbers that are not finite become `null`.
pub fn json(found: Option<&ForceBalance>) -> Value {
    let Some(found) = found else {
        return Value::Null;
    };
    let chi2 =
        |c: &BalanceChi2| json!({ "train": c.train_per_row(), "held_out": c.held_out_per_row() });
    let effect = |e: &BalancedEffect| {
        let mut parameters = Map::new();
        for (&i, error) in e.free.iter().zip(&e.errors) {
            let spec = &e.effect.spec.parameters[i];
            let value = json!({
                "value": e.effect.values[i],
                "std_error": error,
                "unit": spec.unit,
            });
            parameters.insert(spec.id.to_owned(), value);
        }
        json!({ "id": e.effect.spec.id, "name": e.effect.spec.name, "parameters": parameters })
    };
    json!({
        "chi2": { "before": chi2(&found.before), "after": chi2(&found.after) },
        "effects": found.effects.iter().map(effect).collect::<Vec<_>>(),
        "strongest_curve": found.forces.strongest().map(curve),
        "curves": {
            "before": found.forces.before.iter().map(curve).collect::<Vec<_>>(),
            "after": found.forces.after.iter().map(curve).collect::<Vec<_>>(),
        },
        "candidates": found
            .candidates
            .iter()
            .map(|c| json!({ "id": c.id, "held_out_chi2": c.held_out_per_row }))
            .collect::<Vec<_>>(),
    })
}
