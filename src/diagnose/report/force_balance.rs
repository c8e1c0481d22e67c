//! A force balance as text and as a value for programs.

use serde_json::{Map, Value, json};

use super::words;
use crate::diagnose::diagnosis::Estimate;
use crate::diagnose::force_balance::{BalanceChi2, BalancedEffect, ForceBalance};

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
    out
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
        "candidates": found
            .candidates
            .iter()
            .map(|c| json!({ "id": c.id, "held_out_chi2": c.held_out_per_row }))
            .collect::<Vec<_>>(),
    })
}
