//! How large an effect is: its largest force over the recordings.

use crate::diagnose::comparison::trial::SelectionResult;
use crate::diagnose::diagnosis::ForceCurve;
use crate::diagnose::discrepancy::missing_force::SINCE_CONTACT;
use crate::diagnose::discrepancy::residual_map::Sample;
use crate::model::Model;
use crate::model::effects::{Action, ActiveEffect, Kinematics, Surroundings};
use crate::recording::quantile_in_place;

/// What an effect does on the device of `model`.
pub(crate) fn action(effect: &ActiveEffect, model: &Model) -> Box<dyn Action> {
    let structure = model.structure();
    (effect.spec.build)(
        &effect.values,
        &Surroundings {
            structure: &structure,
            parameters: &model.parameters,
            piezo: model.piezo,
        },
    )
}

fn force(action: &dyn Action, s: &Sample, model: &Model, z: &[f64]) -> f64 {
    let at = Kinematics {
        t: s.time,
        xp: s.xp,
        vp: s.vp,
        voltage: s.voltage,
        ..Kinematics::default()
    };
    let mass = 1.0 / model.structure().mobility();
    action.force_on_proof_mass(&at, z)
        - action.friction(s.xp) * s.vp.signum()
        - mass * action.base_acceleration(s.time)
}

/// Largest force of an effect over the samples \[N\], the 99 % quantile; NaN if it is no force, or
/// one that depends on more than a single instant.
pub fn of(effect: &ActiveEffect, model: &Model, samples: &[Sample]) -> f64 {
    if let Some(largest) = effect.spec.facts.largest_force {
        return largest(&effect.values, &model.parameters);
    }
    let action = action(effect, model);
    let z = vec![0.0; action.state_rates().len()];
    let forces = samples.iter().map(|s| force(&*action, s, model, &z).abs());
    let mut forces: Vec<f64> = forces.filter(|f| f.is_finite()).collect();
    let largest = quantile_in_place(&mut forces, 0.99);
    if largest > 0.0 { largest } else { f64::NAN }
}

/// Mean force of the named effects in the bins of a curve \[N\]; empty if none is a force, or if the
/// curve is of forces that are constant over a segment.
pub fn law_on(curve: &ForceCurve, found: &SelectionResult, samples: &[Sample]) -> Vec<f64> {
    let model = &found.state.train.model;
    let named: Vec<Box<dyn Action>> = found
        .state
        .named
        .iter()
        .filter_map(|n| model.effects.iter().find(|e| e.spec == n.spec))
        .map(|e| action(e, model))
        .filter(|a| a.state_rates().is_empty())
        .collect();
    if named.is_empty() || curve.at.len() < 2 || curve.against == SINCE_CONTACT {
        return Vec::new();
    }
    let width = curve.at[1] - curve.at[0];
    let mut sums = vec![(0.0, 0usize); curve.at.len()];
    for s in samples {
        let u = match curve.against {
            "xp" => s.xp,
            "xp'" => s.vp,
            _ => s.voltage,
        };
        let bin = ((u - curve.at[0]) / width).round();
        if bin >= 0.0 && (bin as usize) < sums.len() {
            let total: f64 = named.iter().map(|a| force(&**a, s, model, &[])).sum();
            if total.is_finite() {
                let bin = &mut sums[bin as usize];
                bin.0 += total;
                bin.1 += 1;
            }
        }
    }
    let all: Vec<f64> = sums
        .into_iter()
        .map(|(sum, n)| if n > 0 { sum / n as f64 } else { f64::NAN })
        .collect();
    if all.iter().any(|f| f.is_finite() && *f != 0.0) {
        all
    } else {
        Vec::new()
    }
}
