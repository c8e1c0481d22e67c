//! The catalogue as directions of the score test: for each effect some forms, each a direction in
//! which the simulation would move, with the parameters that are free when it is fitted.

use crate::diagnose::shooting::fitted::Bound;
use crate::fit::problem::COORDINATE_STEP;
use crate::fit::problem::parameter_space::linear_unit;
use crate::model::Model;
use crate::model::effects::{ActiveEffect, CATALOGUE, EffectSpec, FoundBy, Motion, Start, own_ids};
use crate::model::parameter::ParameterId;

/// Factor by which constants may leave the range that was tried.
pub const CONSTANT_BOUND_FACTOR: f64 = 3.0;

/// Shortest lag that a fit may reach, as a share of that of its form.
pub const MIN_LAG_SHARE: f64 = 0.3;

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

    /// Bounds of fitted parameters, from `all` forms of the effect. A slow effect that may become
    /// quick would imitate another, and an attraction that reaches farther than the mass moves a
    /// spring: constants stay near the range that was tried.
    pub fn bounds(&self, all: &[Self]) -> Vec<Bound> {
        let id = |i: usize| format!("{}.{}", self.spec.id, self.spec.parameters[i].id);
        let mut bounds = Vec::new();
        if !self.signed {
            bounds.push((self.strength_id(), (self.min_strength(), f64::INFINITY)));
        }
        let own = |i: usize| {
            let same = all.iter().filter(|f| f.spec == self.spec);
            same.map(move |f| f.values[i]).filter(|v| *v > 0.0)
        };
        for &i in self.free.iter().filter(|i| **i != self.strength) {
            let low = own(i).fold(f64::INFINITY, f64::min) / CONSTANT_BOUND_FACTOR;
            let low = low.max(self.min_constant);
            let high = own(i).fold(0.0, f64::max) * CONSTANT_BOUND_FACTOR;
            if low < high {
                bounds.push((id(i), (low, high)));
            }
        }
        let searched = self.spec.search.bounds.iter();
        bounds.extend(searched.map(|(i, bound)| (id(*i), *bound)));
        bounds
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
        const GRAVITY: f64 = 9.81;
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
                speed: (GRAVITY * length).sqrt(),
                force: mass * GRAVITY,
                interval,
            }
        }
    }

    /// With what `model` has, for the first guesses of effects.
    fn motion(&self, model: &Model) -> Motion {
        Motion {
            is_driven: model.piezo.is_some(),
            has_ground: model.has_ground,
            is_sprung: model.parameters[ParameterId::F1] > 0.0,
            contact_distance: model.parameters[ParameterId::Dp],
            length: self.length,
            speed: self.speed,
            force: self.force,
            interval: self.interval,
        }
    }

    /// Whether a step of the first shape parameter, which a fit makes in units of its range, is
    /// small where the device moves: on one that moves by centimetres a high power of the
    /// displacement is not.
    fn has_small_shape_step(&self, spec: &EffectSpec, start: &Start) -> bool {
        let force = |shape_force: f64| {
            let step = COORDINATE_STEP * linear_unit(&spec.parameters[start.shape[0]]);
            step * shape_force
        };
        let force = start.shape_force.map(force);
        force.is_none_or(|force| force < 1e-3 * self.force)
    }
}

/// Forms of all effects that the linear score test can evaluate on this device. Further modes,
/// vibrations and contact laws are searched for separately.
pub fn catalogue_directions(model: &Model, scale: &Scale) -> Vec<CatalogueDirection> {
    let motion = scale.motion(model);
    let mut out = Vec::new();
    for spec in CATALOGUE.iter().copied() {
        let search = &spec.search;
        let FoundBy::Starts(starts) = search.found_by else {
            continue;
        };
        out.extend(starts(&motion).into_iter().map(|start| CatalogueDirection {
            spec,
            strength: start.strength,
            signed: start.signed,
            free: start.free.to_vec(),
            min_constant: (search.least_constant)(&motion),
            cold_start: search.cold_start.map(|cold| {
                let mut effect = ActiveEffect::new(spec);
                for (i, value) in cold.set {
                    effect.values[*i] = *value;
                }
                (effect.values, cold.free.to_vec())
            }),
            shape: if scale.has_small_shape_step(spec, &start) {
                start.shape
            } else {
                &[]
            },
            values: start.values,
        }));
    }
    out
}
