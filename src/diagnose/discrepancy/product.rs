//! Whether what passes for a force over the displacement of the mass is one: a force that goes with
//! both displacements follows the cantilever's own motion as well.

use crate::diagnose::score_test::basis_forces::number;
use crate::diagnose::score_test::linearized::Linearized;
use crate::diagnose::score_test::scan::ScoreScan;
use crate::diagnose::score_test::state_range::spans;
use crate::diagnose::shooting::fitted::Fitted;
use crate::model::effects::{Action, ActiveEffect, EffectSpec, Kinematics, Need};
use crate::sim::SimError;

/// Force of the probe at the greatest height \[N\].
const FORCE: f64 = 1e-10;

static SPEC: EffectSpec = EffectSpec {
    id: "force_by_product",
    name: "force by both displacements",
    sentence: "A force that goes with the product of both displacements.",
    law: "F = -k xp xc",
    needs: Need::Nothing,
    source: "",
    parameters: &[number("k")],
    build: |values, _| {
        Box::new(Product {
            stiffness: values[0],
        })
    },
    ..EffectSpec::DEFAULT
};

#[derive(Debug)]
struct Product {
    stiffness: f64,
}

impl Action for Product {
    fn does_nothing(&self) -> bool {
        self.stiffness == 0.0
    }

    fn force_on_proof_mass(&self, at: &Kinematics, _z: &[f64]) -> f64 {
        -self.stiffness * at.xp * at.xc
    }
}

/// Fall of chi2 that a force by the product of both displacements would bring at a fit; 0 for a
/// device whose mass does not move.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub fn gain(fitted: &Fitted) -> Result<f64, SimError> {
    let ((low, high), ..) = spans(fitted);
    let reach = low.abs().max(high.abs());
    if reach.is_nan() || reach <= 0.0 || !fitted.model.has_cantilever {
        return Ok(0.0);
    }
    let probe = ActiveEffect {
        spec: &SPEC,
        values: vec![FORCE / (reach * reach)],
    };
    let linear = Linearized::new(fitted)?;
    let scan = ScoreScan::of(&linear, &fitted.model, &[probe])?;
    Ok(scan.joint(&[0]).map_or(0.0, |joint| joint.gain))
}

#[cfg(test)]
mod tests {
    use super::super::product::*;
    use crate::diagnose::test_support;
    use crate::model::effects::find;

    /// What a force by the product would bring beside the stiffness fitted to recordings of a
    /// device with `concealed`, as a share of what that brings.
    fn beside_a_stiffness(concealed: ActiveEffect) -> f64 {
        let stiffness = ActiveEffect {
            spec: find("cubic_stiffness").unwrap(),
            values: vec![1e4, 0.0],
        };
        let free = ["k3", "k5"].map(|k| format!("cubic_stiffness.{k}"));
        let drives = [("square:40Hz:8V", 0.06), ("sine:50Hz:8V", 0.06)];
        test_support::share_beside(concealed, &drives, (stiffness, &free), gain)
    }

    #[test]
    fn a_force_by_both_displacements_shows_beside_a_stiffness_that_is_none() {
        let stiffness = beside_a_stiffness(ActiveEffect {
            spec: find("cubic_stiffness").unwrap(),
            values: vec![2e4, 0.0],
        });
        assert!(stiffness < 0.01, "{stiffness}");
        let product = beside_a_stiffness(ActiveEffect {
            spec: &SPEC,
            values: vec![1.0],
        });
        assert!(product > 0.05, "{product}");
    }
}
