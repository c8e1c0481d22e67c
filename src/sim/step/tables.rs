//! Propagators for every step length that a run takes.

// The indices are those of the method's matrices; iterators would hide them.
#![allow(clippy::needless_range_loop)]

use std::sync::OnceLock;

use nalgebra::DMatrix;

use crate::sim::device::Device;
use crate::sim::error::Options;
use crate::sim::linear::{DecayPropagator, Oscillator, Propagator};
use crate::sim::nodes::S;

/// Finest step is the longest over 2 to this power.
pub(in crate::sim) const LEVELS: usize = 48;

/// A short piece of the drive does not make a step shorter than this \[s\]: over a shorter step
/// the velocity is lost to rounding in the differences of displacements.
const MIN_STEP: f64 = 1e-9;

/// Propagators of all oscillators and decays for one step length.
#[derive(Debug, Clone)]
pub(in crate::sim) struct Table {
    pub h: f64,
    pub(super) modes: Vec<Propagator>,
    pub(super) decays: Vec<DecayPropagator>,
    /// Proof mass per force on it and per drive force: `[displacement, velocity]`.
    pub(super) p_from_p: [[[f64; S]; S - 1]; 2],
    pub(super) p_from_d: [[[f64; S]; S - 1]; 2],
    /// Maps the velocities that the points after the first would have without damping between
    /// modes to those with it, row-major by `[point][mode]`; empty if there is no such damping.
    pub(super) damped: Vec<f64>,
}

/// Tables for halved and halved again step lengths, made when first needed, and shared
/// by all threads that simulate the same device.
#[derive(Debug, Clone)]
pub(in crate::sim) struct Tables {
    oscillators: Vec<Oscillator>,
    rates: Vec<f64>,
    phi_p: Vec<f64>,
    phi_d: Vec<f64>,
    /// Damping between modes, row-major; empty if there is none.
    cross_damping: Vec<f64>,
    lengths: [f64; LEVELS],
    levels: Vec<OnceLock<Box<Table>>>,
}

impl Tables {
    pub fn new(
        longest: f64,
        oscillators: &[Oscillator],
        rates: &[f64],
        phi_p: &[f64],
        phi_d: &[f64],
    ) -> Self {
        Self {
            lengths: std::array::from_fn(|level| longest * 0.5f64.powi(level as i32)),
            oscillators: oscillators.to_vec(),
            rates: rates.to_vec(),
            phi_p: phi_p.to_vec(),
            phi_d: phi_d.to_vec(),
            cross_damping: Vec::new(),
            levels: vec![OnceLock::new(); LEVELS],
        }
    }

    /// The same of modes that are damped by each other's velocities, so much by row and column
    /// \[1/s\].
    pub fn damped_by(mut self, cross_damping: &[f64]) -> Self {
        if cross_damping.iter().any(|c| *c != 0.0) {
            self.cross_damping = cross_damping.to_vec();
        }
        self
    }

    /// Takes over what `other` has computed if it is for the same motion.
    pub fn adopt(&mut self, other: &mut Self) {
        let same = self.oscillators == other.oscillators
            && self.rates == other.rates
            && self.phi_p == other.phi_p
            && self.phi_d == other.phi_d
            && self.cross_damping == other.cross_damping
            && self.lengths == other.lengths;
        if same {
            std::mem::swap(&mut self.levels, &mut other.levels);
        }
    }

    /// Step length of a level \[s\].
    pub fn length(&self, level: usize) -> f64 {
        self.lengths[level]
    }

    /// First level whose step does not reach far beyond what is `remaining` \[s\].
    pub fn covering(&self, remaining: f64) -> usize {
        let longest = self.length(0);
        if remaining >= longest {
            return 0;
        }
        let halvings = (longest / remaining.max(MIN_STEP)).log2().floor();
        halvings.clamp(0.0, (LEVELS - 1) as f64) as usize
    }

    /// First level whose step is no longer than `most` \[s\].
    pub fn within(&self, most: f64) -> usize {
        let within = self.lengths.iter().position(|length| *length <= most);
        within.unwrap_or(LEVELS - 1)
    }

    pub(super) fn get(&self, level: usize) -> &Table {
        let h = self.length(level);
        let (oscillators, rates) = (&self.oscillators, &self.rates);
        let (phi_p, phi_d) = (&self.phi_p, &self.phi_d);
        self.levels[level].get_or_init(|| {
            let modes: Vec<Propagator> =
                oscillators.iter().map(|&o| Propagator::new(o, h)).collect();
            let map = |of: &dyn Fn(&Propagator) -> [[f64; S]; S - 1], phi: &[f64]| {
                let mut sum = [[0.0; S]; S - 1];
                for (i, mode) in modes.iter().enumerate() {
                    let part = of(mode);
                    for k in 0..S - 1 {
                        for j in 0..S {
                            sum[k][j] += phi_p[i] * phi[i] * part[k][j];
                        }
                    }
                }
                sum
            };
            let both = |phi: &[f64]| [map(&|m| m.displacement, phi), map(&|m| m.velocity, phi)];
            Box::new(Table {
                h,
                p_from_p: both(phi_p),
                p_from_d: both(phi_d),
                damped: damped(&modes, &self.cross_damping),
                decays: rates.iter().map(|&r| DecayPropagator::new(r, h)).collect(),
                modes,
            })
        })
    }
}

/// Tables of flight and of the held phase; `structure` holds the longest steps that follow
/// the structure's motion in each \[s\].
pub(in crate::sim) fn phase_tables(
    device: &Device,
    options: &Options,
    structure: [f64; 2],
) -> [Tables; 2] {
    let [flight, held] = structure.map(|structure| {
        let by_itself = if structure.is_finite() {
            structure
        } else {
            64.0 / options.rate
        };
        let limit = options.longest_step.unwrap_or(f64::INFINITY);
        options.fixed_step.unwrap_or(by_itself.min(limit))
    });
    let none = vec![0.0; device.held_modes.len()];
    [
        Tables::new(
            flight,
            &device.flight,
            &device.rates,
            &device.phi_p,
            &device.phi_d,
        ),
        Tables::new(held, &device.held_modes, &device.rates, &none, &none)
            .damped_by(&device.held.cross_damping),
    ]
}

/// See [`Table::damped`].
fn damped(modes: &[Propagator], cross_damping: &[f64]) -> Vec<f64> {
    let m = modes.len();
    if cross_damping.is_empty() {
        return Vec::new();
    }
    let n = (S - 1) * m;
    let per_velocity = DMatrix::from_fn(n, n, |to, from| {
        let ((k, i), (j, l)) = ((to / m, to % m), (from / m, from % m));
        f64::from(u8::from(to == from)) + modes[i].velocity[k][j + 1] * cross_damping[i * m + l]
    });
    // Over so long a step that damping between modes outweighs all there is none.
    let inverse = per_velocity
        .try_inverse()
        .unwrap_or_else(|| DMatrix::from_element(n, n, f64::NAN));
    inverse.transpose().as_slice().to_vec()
}
