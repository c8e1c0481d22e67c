//! Probes of named effects: whether what passes for one effect is another. Dry friction must be
//! the same at all heights, a base vibration must not push harder the farther the mass is
//! deflected, and a force of the mass's displacement must not follow the cantilever's. Each probe
//! is a generic force tested at the fit with the effect.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::diagnose::score_test::basis_forces::{hat, numeric_parameter, window_grid};
use crate::diagnose::score_test::linearized::Linearized;
use crate::diagnose::score_test::scan::ScoreScan;
use crate::diagnose::score_test::state_range::state_ranges;
use crate::diagnose::shooting::fitted::Fitted;
use crate::model::effects::{Action, ActiveEffect, EffectSpec, Kinematics, Need};
use crate::sim::SimError;

/// Windows of height in which friction is probed.
const HEIGHT_WINDOWS: usize = 7;
/// Size of the friction probes, as a share of the fitted friction.
const FRICTION_PROBE_SHARE: f64 = 0.1;
/// Speed over which a probe changes sign with the motion, as a share of the largest. Without a
/// jump it needs no events.
const TURNOVER_SPEED_SHARE: f64 = 0.02;
/// Such shares for probes that are the same at all heights: friction that depends on the speed.
const SPEED_PROBE_SHARES: [f64; 2] = [TURNOVER_SPEED_SHARE, 0.2];
/// Half width of a window that contains every height \[m\].
const UNBOUNDED_WIDTH: f64 = 1e6;
/// Size of the stiffness probe's force at the greatest height, as a share of the vibration's.
const STIFFNESS_PROBE_SHARE: f64 = 0.1;
/// Force of the product probe at the greatest height \[N\].
const PRODUCT_PROBE_FORCE: f64 = 1e-10;

static FRICTION_AT_HEIGHT: EffectSpec = EffectSpec {
    id: "friction_at_height",
    name: "friction at a height",
    sentence: "A friction that is there only in a window of height.",
    law: "F = -fc hat((xp - middle) / width) tanh(xp' / v0)",
    needs: Need::Nothing,
    source: "",
    parameters: &[
        numeric_parameter("fc"),
        numeric_parameter("middle"),
        numeric_parameter("width"),
        numeric_parameter("v0"),
    ],
    build: |values, _| {
        Box::new(FrictionAtHeight {
            force: values[0],
            middle: values[1],
            width: values[2],
            turns: values[3],
        })
    },
    ..EffectSpec::DEFAULT
};

#[derive(Debug)]
struct FrictionAtHeight {
    force: f64,
    middle: f64,
    width: f64,
    turns: f64,
}

impl Action for FrictionAtHeight {
    fn does_nothing(&self) -> bool {
        self.force == 0.0
    }

    fn force_on_proof_mass(&self, at: &Kinematics, _z: &[f64]) -> f64 {
        -self.force * hat(at.xp, self.middle, self.width) * (at.vp / self.turns).tanh()
    }
}

/// Fall of chi2 that friction depending on the height would bring in addition to the fitted dry
/// friction and one depending on the speed, less its expectation by chance; 0 without dry
/// friction.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub fn friction_at_height_gain(fitted: &Fitted) -> Result<f64, SimError> {
    let model = &fitted.model;
    let force = |e: &ActiveEffect| e.spec.facts.friction_force.map(|i| e.values[i]);
    let named = model.effects.iter().find_map(force);
    let (heights, (low, high), _) = state_ranges(fitted);
    let windows = window_grid(heights, HEIGHT_WINDOWS);
    let fastest = low.abs().max(high.abs());
    let Some((named, (middles, width))) = named.zip(windows).filter(|_| fastest > 0.0) else {
        return Ok(0.0);
    };
    let probe = |middle: f64, width: f64, turns: f64| ActiveEffect {
        spec: &FRICTION_AT_HEIGHT,
        values: vec![FRICTION_PROBE_SHARE * named, middle, width, turns * fastest],
    };
    let of_speed = SPEED_PROBE_SHARES
        .iter()
        .map(|turns| probe(0.0, UNBOUNDED_WIDTH, *turns));
    let at_heights = middles
        .into_iter()
        .map(|m| probe(m, width, TURNOVER_SPEED_SHARE));
    let probes: Vec<ActiveEffect> = of_speed.chain(at_heights).collect();
    let linear = Linearized::new(fitted)?;
    let scan = ScoreScan::of_effects(&linear, model, &probes)?;
    let all: Vec<usize> = (0..probes.len()).collect();
    let gain = |which: &[usize]| {
        let joint = scan.joint(which);
        joint.map_or(0.0, |joint| joint.gain - joint.rank as f64)
    };
    Ok(gain(&all) - gain(&all[..SPEED_PROBE_SHARES.len()]))
}

static SWINGING_STIFFNESS: EffectSpec = EffectSpec {
    id: "swinging_stiffness",
    name: "stiffness that comes and goes",
    sentence: "A stiffness that swings steadily.",
    law: "F = k sin(2 pi f t + phase) xp",
    needs: Need::Nothing,
    source: "",
    parameters: &[
        numeric_parameter("k"),
        numeric_parameter("f"),
        numeric_parameter("phase"),
    ],
    build: |values, _| {
        Box::new(SwingingStiffness {
            stiffness: values[0],
            frequency: values[1],
            phase: values[2],
        })
    },
    ..EffectSpec::DEFAULT
};

#[derive(Debug)]
struct SwingingStiffness {
    stiffness: f64,
    frequency: f64,
    phase: f64,
}

impl Action for SwingingStiffness {
    fn does_nothing(&self) -> bool {
        self.stiffness == 0.0
    }

    fn force_on_proof_mass(&self, at: &Kinematics, _z: &[f64]) -> f64 {
        let turns = (self.frequency * at.t).fract();
        self.stiffness * (TAU * turns + self.phase).sin() * at.xp
    }
}

/// Fall of chi2 that a stiffness oscillating at the frequency of the fitted base vibration would
/// bring; 0 without one.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub fn swinging_stiffness_gain(fitted: &Fitted) -> Result<f64, SimError> {
    let model = &fitted.model;
    let named = model.effects.iter().find(|e| e.spec.is_base_sinusoid());
    let ((low, high), ..) = state_ranges(fitted);
    let reach = low.abs().max(high.abs());
    let Some(vibration) = named.filter(|_| reach > 0.0) else {
        return Ok(0.0);
    };
    let force = vibration.values[0] / model.structure().mobility();
    let probe = |phase| ActiveEffect {
        spec: &SWINGING_STIFFNESS,
        values: vec![
            STIFFNESS_PROBE_SHARE * force / reach,
            vibration.values[1],
            phase,
        ],
    };
    let linear = Linearized::new(fitted)?;
    let scan = ScoreScan::of_effects(&linear, model, &[probe(0.0), probe(FRAC_PI_2)])?;
    Ok(scan.joint(&[0, 1]).map_or(0.0, |joint| joint.gain))
}

static DISPLACEMENT_PRODUCT: EffectSpec = EffectSpec {
    id: "force_by_product",
    name: "force by both displacements",
    sentence: "A force that goes with the product of both displacements.",
    law: "F = -k xp xc",
    needs: Need::Nothing,
    source: "",
    parameters: &[numeric_parameter("k")],
    build: |values, _| {
        Box::new(DisplacementProduct {
            stiffness: values[0],
        })
    },
    ..EffectSpec::DEFAULT
};

#[derive(Debug)]
struct DisplacementProduct {
    stiffness: f64,
}

impl Action for DisplacementProduct {
    fn does_nothing(&self) -> bool {
        self.stiffness == 0.0
    }

    fn force_on_proof_mass(&self, at: &Kinematics, _z: &[f64]) -> f64 {
        -self.stiffness * at.xp * at.xc
    }
}

/// Fall of chi2 that a force proportional to the product of both displacements would bring at a
/// fit; 0 for a device whose mass does not move.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub fn displacement_product_gain(fitted: &Fitted) -> Result<f64, SimError> {
    let ((low, high), ..) = state_ranges(fitted);
    let reach = low.abs().max(high.abs());
    if reach.is_nan() || reach <= 0.0 || !fitted.model.has_cantilever {
        return Ok(0.0);
    }
    let probe = ActiveEffect {
        spec: &DISPLACEMENT_PRODUCT,
        values: vec![PRODUCT_PROBE_FORCE / (reach * reach)],
    };
    let linear = Linearized::new(fitted)?;
    let scan = ScoreScan::of_effects(&linear, &fitted.model, &[probe])?;
    Ok(scan.joint(&[0]).map_or(0.0, |joint| joint.gain))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::probes::*;
    use crate::diagnose::options::DiagnoseOptions;
    use crate::diagnose::shooting::workspace::Workspace;
    use crate::diagnose::test_support;
    use crate::diagnose::test_support::QUIET;
    use crate::fit::Part;
    use crate::model::effects::find;
    use crate::model::preset::Preset;
    use crate::model::with_effect;
    use crate::recording::Recording;

    /// What friction at heights would bring in addition to dry friction fitted to recordings
    /// of a device with `concealed`, as a share of what that brings.
    fn gain_share_with_dry_friction(concealed: ActiveEffect) -> f64 {
        let dry = ActiveEffect {
            spec: find("dry_friction").unwrap(),
            values: vec![1e-8],
        };
        let free = ["dry_friction.fc".to_owned()];
        let drives = [("square:40Hz:8V", 0.06)];
        test_support::gain_share(concealed, &drives, (dry, &free), friction_at_height_gain)
    }

    #[test]
    fn without_dry_friction_its_probe_has_no_gain() {
        let paper = Preset::embedded("paper").unwrap().model;
        let workspace =
            test_support::workspace_of(&paper, &[("square:40Hz:8V", 0.06)], 25e3, 20e-9);
        let base = workspace.baseline(&paper, &QUIET).unwrap();
        assert_eq!(friction_at_height_gain(&base).unwrap(), 0.0);
    }

    #[test]
    fn friction_limited_to_some_heights_is_distinguished_from_dry_friction() {
        let dry = gain_share_with_dry_friction(ActiveEffect {
            spec: find("dry_friction").unwrap(),
            values: vec![2e-8],
        });
        assert!(dry < 0.01, "{dry}");
        let above = gain_share_with_dry_friction(ActiveEffect {
            spec: &FRICTION_AT_HEIGHT,
            values: vec![4e-8, 5e-5, 4e-5, 1e-3],
        });
        assert!(above > 0.05, "{above}");
    }

    /// A mass on a spring that rings while `force(t, x)` acts on a unit of its mass, small
    /// steps of a symplectic rule.
    fn ring(force: &dyn Fn(f64, f64) -> f64, seed: u64) -> Part {
        let mut dice = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { (0..12).map(|_| dice.random_range(-0.5..0.5)).sum() };
        let (omega, zeta, h): (f64, f64, f64) = (8.6, 2e-3, 1e-4);
        let (mut x, mut v, mut t) = (0.1 + 0.01 * normal(), 0.0, 0.0);
        let (mut time, mut seen) = (Vec::new(), Vec::new());
        for step in 0..600_000 {
            if step % 100 == 0 {
                time.push(t);
                seen.push(x + 1e-4 * normal());
            }
            let a =
                |t: f64, x: f64, v: f64| force(t, x) - omega * omega * x - 2.0 * zeta * omega * v;
            let half = v + 0.5 * h * a(t, x, v);
            x += h * half;
            t += h;
            v = half + 0.5 * h * a(t, x, half);
        }
        let name = format!("ring {seed}");
        Part::whole(Arc::new(
            Recording::new(name, time, None, seen, None).unwrap(),
        ))
    }

    /// What an oscillating stiffness would bring in addition to a fitted vibration of 3.1 Hz.
    fn gain_with_base_vibration(force: &dyn Fn(f64, f64) -> f64) -> f64 {
        let model = Preset::embedded("oscillator").unwrap().model;
        let train = [ring(force, 1), ring(force, 2)];
        let workspace = Workspace::new(&model, &train, &[], &DiagnoseOptions::default()).unwrap();
        let base = workspace.baseline(&model, &QUIET).unwrap();
        assert_eq!(swinging_stiffness_gain(&base).unwrap(), 0.0);
        let vibration = ActiveEffect {
            spec: find("base_vibration").unwrap(),
            values: vec![0.05, 3.1, 0.4],
        };
        let start = with_effect(&base.model, vibration);
        let free = ["base_vibration.a", "base_vibration.phase"].map(str::to_owned);
        let fitted = workspace.fit(&start, &free, &[], &base, 12, &QUIET);
        swinging_stiffness_gain(&fitted.unwrap()).unwrap()
    }

    #[test]
    fn an_oscillating_stiffness_is_distinguished_from_a_base_vibration() {
        let swing = |t: f64| (TAU * 3.1 * t + 0.4).sin();
        let vibration = gain_with_base_vibration(&|t, _| -0.05 * swing(t));
        assert!(vibration < 15.0, "{vibration}");
        let stiffness = gain_with_base_vibration(&|t, x| -0.8 * swing(t) * (x + 0.06));
        assert!(stiffness > 100.0, "{stiffness}");
    }

    /// What a force of the product would bring in addition to the stiffness fitted to
    /// recordings of a device with `concealed`, as a share of what that brings.
    fn gain_share_with_stiffness(concealed: ActiveEffect) -> f64 {
        let stiffness = ActiveEffect {
            spec: find("cubic_stiffness").unwrap(),
            values: vec![1e4, 0.0, 0.0],
        };
        let free = ["k3", "k5"].map(|k| format!("cubic_stiffness.{k}"));
        let drives = [("square:40Hz:8V", 0.06), ("sine:50Hz:8V", 0.06)];
        test_support::gain_share(
            concealed,
            &drives,
            (stiffness, &free),
            displacement_product_gain,
        )
    }

    #[test]
    fn a_force_of_the_product_of_displacements_is_distinguished_from_a_stiffness() {
        let stiffness = gain_share_with_stiffness(ActiveEffect {
            spec: find("cubic_stiffness").unwrap(),
            values: vec![2e4, 0.0, 0.0],
        });
        assert!(stiffness < 0.01, "{stiffness}");
        let product = gain_share_with_stiffness(ActiveEffect {
            spec: &DISPLACEMENT_PRODUCT,
            values: vec![1.0],
        });
        assert!(product > 0.05, "{product}");
    }
}
