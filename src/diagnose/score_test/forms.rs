//! The catalogue as directions of the score test: for each effect some forms, each a direction in
//! which the simulation would move, with the parameters that are free when it is fitted.

use crate::fit::problem::STEP;
use crate::fit::problem::parameter_space::linear_unit;
use crate::model::Model;
use crate::model::effects::{ActiveEffect, CATALOGUE, EffectSpec, own_ids};
use crate::model::parameter::ParameterId;

/// Shortest lag that a fit may reach, as a share of that of its form.
pub const MIN_LAG_SHARE: f64 = 0.3;
/// Shortest time constant of an amplifier that is considered \[s\].
pub const MIN_TIME_CONSTANT: f64 = 1e-6;

/// Least distance of the electrodes at contact \[m\].
const MIN_ELECTRODE_GAP: f64 = 2e-6;

/// One effect at one choice of its nonlinear constants.
#[derive(Debug, Clone, PartialEq)]
pub struct CatalogueDirection {
    /// The effect.
    pub spec: &'static EffectSpec,
    /// Values of its parameters, small enough for it to act in proportion.
    pub values: Vec<f64>,
    /// Index of its strength parameter.
    pub strength: usize,
    /// Whether the strength may be negative.
    pub signed: bool,
    /// Indices of the fitted parameters.
    pub free: Vec<usize>,
    /// Smallest sensible value of the constants other than the strength.
    pub min_constant: f64,
    /// Initial values and fitted parameters where the law is too strong for any model without
    /// it, if they differ.
    pub cold_start: Option<(Vec<f64>, Vec<usize>)>,
    /// Indices of parameters that shape the law, fitted in addition once the effect is
    /// established.
    pub shape: &'static [usize],
}

impl CatalogueDirection {
    /// The effect at `theta` times the form's strength, kept within its limits.
    pub fn effect(&self, theta: f64) -> ActiveEffect {
        let mut values = self.values.clone();
        let (low, high) = self.spec.parameters[self.strength].limits;
        values[self.strength] = (values[self.strength] * theta).clamp(low, high);
        ActiveEffect {
            spec: self.spec,
            values,
        }
    }

    /// Whether the strength is a latency.
    pub fn is_lag(&self) -> bool {
        matches!(self.spec.parameters[self.strength].unit, "s" | "s/V")
    }

    /// Least strength that a fit may reach. Below it an effect of one sign is nothing, and a
    /// lag, whose response is quadratic after a shift of the clocks is projected out, needs a
    /// shorter form.
    pub fn min_strength(&self) -> f64 {
        if self.signed {
            f64::NEG_INFINITY
        } else {
            let share = if self.is_lag() { MIN_LAG_SHARE } else { 1e-4 };
            share * self.values[self.strength]
        }
    }

    /// Id of the strength, as `effect.parameter`.
    pub fn strength_id(&self) -> String {
        format!(
            "{}.{}",
            self.spec.id, self.spec.parameters[self.strength].id
        )
    }

    /// Ids of the fitted parameters, as `effect.parameter`.
    pub fn free_ids(&self) -> Vec<String> {
        own_ids(self.spec, &self.free)
    }
}

/// Ids of the slew-rate parameters of a lag `spec`, which shape its law.
pub fn pace_parameters(spec: &EffectSpec) -> Vec<String> {
    let all = spec.parameters.iter().enumerate();
    let paces = all.filter(|(_, p)| p.unit == "s/V").map(|(i, _)| i);
    own_ids(spec, &paces.collect::<Vec<_>>())
}

/// Scales of a device's motion, by which hypotheses are sized.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// Largest displacement \[m\].
    pub length: f64,
    /// Typical speed \[m/s\].
    pub speed: f64,
    /// Typical force \[N\].
    pub force: f64,
    /// Time between samples \[s\].
    pub interval: f64,
}

impl Scale {
    /// Of `model`, moving over `length` \[m\] and read every `interval` \[s\].
    pub fn new(model: &Model, length: f64, interval: f64) -> Self {
        /// Acceleration of a mass without a spring \[m/s^2\].
        const FALL: f64 = 9.81;
        let structure = model.structure();
        let mass = 1.0 / structure.mobility();
        let springs = structure.modes.iter().filter(|m| m.frequency > 0.0);
        let compliance: f64 = springs.clone().map(|m| (m.phi_p / m.omega()).powi(2)).sum();
        let slowest = springs.map(|m| m.omega()).fold(f64::INFINITY, f64::min);
        if compliance > 0.0 {
            Self {
                length,
                speed: slowest * length,
                force: length / compliance,
                interval,
            }
        } else {
            Self {
                length,
                speed: (FALL * length).sqrt(),
                force: mass * FALL,
                interval,
            }
        }
    }

    /// Whether an iteration's step of the quintic stiffness, in units of its range, is small
    /// where the device moves. For a device that moves by centimetres it is not.
    fn resolves_quintic(&self, spec: &EffectSpec) -> bool {
        let step = STEP * linear_unit(&spec.parameters[1]);
        step * self.length.powi(5) < 1e-3 * self.force
    }
}

/// Forms of all effects that the linear score test can evaluate on this device. Further modes,
/// vibrations and contact laws are searched for separately.
pub fn catalogue_directions(model: &Model, scale: &Scale) -> Vec<CatalogueDirection> {
    let mut out = Vec::new();
    for spec in CATALOGUE.iter().copied() {
        let mut add = |values: &[f64], strength, signed, free: &[usize]| {
            out.push(CatalogueDirection {
                spec,
                values: values.to_vec(),
                strength,
                signed,
                free: free.to_vec(),
                // The electrodes are apart even where the mass touches the ground.
                min_constant: if spec.id == "electrostatic" {
                    model.parameters[ParameterId::Dp] + MIN_ELECTRODE_GAP
                } else {
                    0.0
                },
                // A device has either the branches or the loops: between them there is
                // nothing. At zero the past would not show which way to go.
                cold_start: (spec.id == "hysteresis_memory").then(|| {
                    let parameters = spec.parameters.iter();
                    let mut values: Vec<f64> = parameters.map(|p| p.default).collect();
                    values[8] = 1e-3;
                    (values, vec![1, 3, 4, 5, 6, 7, 8, 9, 10])
                }),
                shape: match spec.id {
                    "hysteresis_memory" => &[3, 4, 5, 6, 7, 9, 10],
                    "cubic_stiffness" if scale.resolves_quintic(spec) => &[1],
                    "long_range_attraction" => &[2],
                    "amplifier_lag" if strength == 0 => &[1],
                    "amplifier_lag" => &[0],
                    "piezo_creep" => &[2, 3],
                    "zero_drift" if strength == 0 => &[2],
                    _ => &[],
                },
            });
        };
        let dp = model.parameters[ParameterId::Dp];
        let driven = model.piezo.is_some();
        let ground = model.has_ground;
        let sprung = model.parameters[ParameterId::F1] > 0.0;
        match spec.id {
            "amplifier_lag" if driven => {
                for tau in [MIN_TIME_CONSTANT, 3e-6, 1e-5, 5e-5, 2e-4] {
                    add(&[tau, 0.0], 0, false, &[0]);
                }
                for pace in [1e-6, 5e-6, 2e-5] {
                    add(&[0.0, pace], 1, false, &[1]);
                }
            }
            "piezo_creep" if driven => {
                for tau in [2e-3, 8e-3, 30e-3, 0.12, 0.5] {
                    add(&[0.02, tau, 0.0, tau], 0, false, &[0, 1]);
                }
            }
            "hysteresis_memory" if driven => {
                // Relays of all widths, as in the branches, and narrow ones that
                // are evenly distributed.
                for width in [0.5, 1.2] {
                    for (q, k, b1) in [(0.0, 0.0, 1.0), (0.4, 3.0, 0.0), (0.7, 6.0, 0.0)] {
                        let values = [0.2, width, 8.0, q, k, b1, 0.0, 0.0, 0.0, 0.0, 0.0];
                        add(&values, 0, false, &[0, 1]);
                    }
                }
            }
            "electrostatic" if driven && ground => {
                for above in [6e-6, 15e-6, 35e-6, 100e-6] {
                    add(&[9e-9, dp + above], 0, false, &[0, 1]);
                }
            }
            "cubic_stiffness" if sprung => {
                let k3 = 1e-3 * scale.force / scale.length.powi(3);
                add(&[k3, 0.0], 0, true, &[0]);
            }
            "quadratic_drag" => add(&[1e-3 * scale.force / scale.speed.powi(2)], 0, false, &[0]),
            "dry_friction" => add(&[1e-3 * scale.force], 0, false, &[0]),
            "film_spring" if ground => {
                for tau in [1.6e-6, 8e-6, 4e-5, 2e-4] {
                    add(&[tau, 0.0], 0, false, &[0]);
                }
                for tau in [1.6e-6, 8e-6, 4e-5, 2e-4, 1e-3] {
                    add(&[tau, 2.0], 0, false, &[0]);
                }
            }
            "long_range_attraction" if ground => {
                for (reach, power) in [0.6e-6, 2e-6, 6e-6].map(|r| [(r, 2.0), (r, 3.0)]).concat() {
                    add(&[3e-9, reach, power], 0, false, &[0, 1]);
                }
            }
            "zero_drift" => {
                for tau in [0.02, 0.1] {
                    add(&[3e-3 * scale.length, tau, 0.0], 0, true, &[0, 1]);
                }
                add(&[0.0, 0.1, 0.02 * scale.length], 2, true, &[2]);
            }
            "sensor_lag" => {
                // With a shift of the clocks projected out, a lag acts
                // quadratically.
                for share in [0.1, 0.25, 0.6, 2.0] {
                    add(&[share * scale.interval, 0.0], 0, false, &[0]);
                }
                for share in [0.05, 0.25] {
                    add(&[0.0, share * scale.interval], 1, false, &[1]);
                }
            }
            "gravity" if !sprung => {
                add(&[1.0], 0, true, &[0]);
            }
            _ => {}
        }
    }
    out
}
