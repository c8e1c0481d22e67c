//! Propagators for every step length that a run takes.

// The indices are those of the method's matrices; iterators would hide them.
#![allow(clippy::needless_range_loop)]

use std::sync::OnceLock;

use crate::sim::linear::{DecayPropagator, Oscillator, Propagator};
use crate::sim::nodes::S;

/// Finest step is the longest over 2 to this power.
pub(in crate::sim) const LEVELS: usize = 48;

/// Steps are not chosen shorter than this \[s\] because a piece of the drive is: with the
/// differences of displacements over a shorter one, their slope is lost to rounding.
const SHORTEST: f64 = 1e-9;

/// Propagators of all oscillators and decays for one step length.
#[derive(Debug, Clone)]
pub(in crate::sim) struct Table {
    pub h: f64,
    pub(super) modes: Vec<Propagator>,
    pub(super) decays: Vec<DecayPropagator>,
    /// Proof mass per force on it and per drive force: `[displacement, velocity]`.
    pub(super) p_from_p: [[[f64; S]; S - 1]; 2],
    pub(super) p_from_d: [[[f64; S]; S - 1]; 2],
}

/// Tables for halved and halved again step lengths, made when first needed, and shared
/// by all threads that simulate the same device.
#[derive(Debug, Clone)]
pub(in crate::sim) struct Tables {
    oscillators: Vec<Oscillator>,
    rates: Vec<f64>,
    phi_p: Vec<f64>,
    phi_d: Vec<f64>,
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
            levels: vec![OnceLock::new(); LEVELS],
        }
    }

    /// Step length of a level [s].
    pub fn length(&self, level: usize) -> f64 {
        self.lengths[level]
    }

    /// First level whose step does not reach far beyond what is `remaining` \[s\].
    pub fn covering(&self, remaining: f64) -> usize {
        let longest = self.length(0);
        if remaining >= longest {
            return 0;
        }
        let halvings = (longest / remaining.max(SHORTEST)).log2().floor();
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
                decays: rates.iter().map(|&r| DecayPropagator::new(r, h)).collect(),
                modes,
            })
        })
    }
}
