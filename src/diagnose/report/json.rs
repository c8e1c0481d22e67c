//! A diagnosis as a value for programs. The form is fixed: other programs read it.

use serde_json::{Map, Value, json};

use crate::diagnose::diagnosis::{BeforeAfter, Diagnosis, Distance, NamedEffect};

/// The diagnosis in the form that `diagnose --json` writes: times in seconds, forces in
/// nN, distances in um, parameters in SI; numbers that are not finite become `null`.
pub fn json(diagnosis: &Diagnosis) -> Value {
    let effects: Vec<Value> = diagnosis.named.iter().map(effect).collect();
    let candidates: Vec<Value> = diagnosis
        .candidates
        .iter()
        .map(|c| {
            json!({
                "id": c.id,
                "probability": c.probability,
                "held_out_chi2": c.held_out_chi2,
            })
        })
        .collect();
    let mismatch: Vec<Value> = diagnosis
        .mismatch
        .iter()
        .map(|m| {
            json!({
                "recording": m.recording,
                "start_s": m.start,
                "end_s": m.end,
                "channel": m.channel,
                "regime": m.regime,
                "share": m.share,
            })
        })
        .collect();
    let remaining = diagnosis.remaining.as_ref().map(
        |left| json!({ "share": left.share, "regime": left.regime, "depends_on": left.depends_on }),
    );
    let next = diagnosis.next_experiment.as_ref().map(|next| {
        json!({
            "drive": next.drive,
            "separates": [next.separates.0, next.separates.1],
        })
    });
    json!({
        "verdict": diagnosis.verdict,
        "remaining": remaining,
        "effects": effects,
        "candidates": candidates,
        "mismatch": mismatch,
        "fit": {
            "noise_um": 1e6 * diagnosis.noise,
            "train": before_after(&diagnosis.train),
            "held_out": before_after(&diagnosis.held_out),
        },
        "next_experiment": next,
    })
}

fn effect(named: &NamedEffect) -> Value {
    let mut parameters = Map::new();
    for p in &named.parameters {
        let value = json!({ "value": p.value, "std_error": p.std_error, "unit": p.unit });
        parameters.insert(p.id.clone(), value);
    }
    json!({
        "id": named.id,
        "name": named.name,
        "probability": named.probability,
        "size_nN": 1e9 * named.size,
        "parameters": parameters,
    })
}

fn before_after(both: &BeforeAfter) -> Value {
    let of = |d: &Distance| json!({ "rms_um": 1e6 * d.rms, "chi2": d.chi2 });
    json!({ "before": of(&both.before), "after": of(&both.after) })
}
