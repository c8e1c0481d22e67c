//! Whether what passes for dry friction is one: friction that grows with the load rubs at some
//! heights more than at others.

use crate::diagnose::score_test::basis_forces::{hat, number, side_by_side};
use crate::diagnose::score_test::linearized::Linearized;
use crate::diagnose::score_test::scan::ScoreScan;
use crate::diagnose::score_test::state_range::spans;
use crate::diagnose::shooting::fitted::Fitted;
use crate::model::effects::{Action, ActiveEffect, EffectSpec, Kinematics, Need};
use crate::sim::SimError;

/// Windows of height.
const WINDOWS: usize = 7;
/// Share of the friction that the probe has.
const SMALL: f64 = 0.1;
/// Speed over which a probe turns with the motion, as a share of the largest: one without a jump
/// needs no events.
const TURNS: f64 = 0.02;
/// Such shares of probes that are the same at all heights: a friction that goes with the speed.
const OF_SPEED: [f64; 2] = [TURNS, 0.2];
/// Half width of a window that no height leaves \[m\].
const EVERYWHERE: f64 = 1e6;

static SPEC: EffectSpec = EffectSpec {
    id: "friction_at_height",
    name: "friction at a height",
    sentence: "A friction that is there only in a window of height.",
    law: "F = -fc hat((xp - middle) / width) tanh(xp' / v0)",
    needs: Need::Nothing,
    source: "",
    parameters: &[
        number("fc"),
        number("middle"),
        number("width"),
        number("v0"),
    ],
    build: |values, _| {
        Box::new(Rubs {
            force: values[0],
            middle: values[1],
            width: values[2],
            turns: values[3],
        })
    },
    ..EffectSpec::DEFAULT
};

#[derive(Debug)]
struct Rubs {
    force: f64,
    middle: f64,
    width: f64,
    turns: f64,
}

impl Action for Rubs {
    fn does_nothing(&self) -> bool {
        self.force == 0.0
    }

    fn force_on_proof_mass(&self, at: &Kinematics, _z: &[f64]) -> f64 {
        -self.force * hat(at.xp, self.middle, self.width) * (at.vp / self.turns).tanh()
    }
}

/// Fall of chi2 that friction would bring that goes with the height, beside the dry friction in
/// the fitted model and one that goes with the speed, less what chance would bring; 0 without dry
/// friction.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub fn gain(fitted: &Fitted) -> Result<f64, SimError> {
    let model = &fitted.model;
    let force = |e: &ActiveEffect| e.spec.facts.friction_force.map(|i| e.values[i]);
    let named = model.effects.iter().find_map(force);
    let (heights, (low, high), _) = spans(fitted);
    let windows = side_by_side(heights, WINDOWS);
    let fastest = low.abs().max(high.abs());
    let Some((named, (middles, width))) = named.zip(windows).filter(|_| fastest > 0.0) else {
        return Ok(0.0);
    };
    let probe = |middle: f64, width: f64, turns: f64| ActiveEffect {
        spec: &SPEC,
        values: vec![SMALL * named, middle, width, turns * fastest],
    };
    let of_speed = OF_SPEED.iter().map(|turns| probe(0.0, EVERYWHERE, *turns));
    let at_heights = middles.into_iter().map(|m| probe(m, width, TURNS));
    let probes: Vec<ActiveEffect> = of_speed.chain(at_heights).collect();
    let linear = Linearized::new(fitted)?;
    let scan = ScoreScan::of(&linear, model, &probes)?;
    let all: Vec<usize> = (0..probes.len()).collect();
    let gain = |which: &[usize]| {
        let joint = scan.joint(which);
        joint.map_or(0.0, |joint| joint.gain - joint.rank as f64)
    };
    Ok(gain(&all) - gain(&all[..OF_SPEED.len()]))
}

#[cfg(test)]
mod tests {
    use super::super::probes::*;
    use crate::diagnose::test_support;
    use crate::diagnose::test_support::QUIET;
    use crate::model::effects::find;
    use crate::model::preset::Preset;

    /// What friction at heights would bring beside the dry friction fitted to recordings of a
    /// device with `concealed`, as a share of what that brings.
    fn beside_dry_friction(concealed: ActiveEffect) -> f64 {
        let dry = ActiveEffect {
            spec: find("dry_friction").unwrap(),
            values: vec![1e-8],
        };
        let free = ["dry_friction.fc".to_owned()];
        let drives = [("square:40Hz:8V", 0.06)];
        test_support::share_beside(concealed, &drives, (dry, &free), gain)
    }

    #[test]
    fn without_dry_friction_there_is_nothing_beside_it() {
        let paper = Preset::embedded("paper").unwrap().model;
        let workspace = test_support::bench_of(&paper, &[("square:40Hz:8V", 0.06)], 25e3, 20e-9);
        let base = workspace.baseline(&paper, &QUIET).unwrap();
        assert_eq!(gain(&base).unwrap(), 0.0);
    }

    #[test]
    fn friction_at_heights_shows_beside_dry_friction_where_it_is_not_everywhere() {
        let dry = beside_dry_friction(ActiveEffect {
            spec: find("dry_friction").unwrap(),
            values: vec![2e-8],
        });
        assert!(dry < 0.01, "{dry}");
        let above = beside_dry_friction(ActiveEffect {
            spec: &SPEC,
            values: vec![4e-8, 5e-5, 4e-5, 1e-3],
        });
        assert!(above > 0.05, "{above}");
    }
}
