//! A further mode that is too weak for a spectral peak of its own shows as a ring in phase with
//! its excitation. Each impact excites it in proportion to the jump of the mass's velocity, each
//! jump of the drive in proportion to its force. The phase is known in every segment, so that few
//! parameters describe the ring in all of them.

use std::f64::consts::TAU;

use nalgebra::{Complex, Matrix2, SymmetricEigen, Vector2};
use rayon::prelude::*;

use super::excitations::{Kicks, kicks_of, ring_course};
use super::residual_spectrum;
use super::residual_spectrum::{SearchBand, SegmentResiduals};
use crate::diagnose::data::side::Split;
use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::thresholds::{RING_MIN_CONTRAST, RING_MIN_GAIN};
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::sim::SimError;

/// Damping ratios that are tried.
const DAMPING_GRID: [f64; 3] = [0.003, 0.008, 0.02];
/// Spacing of the frequencies that are tried, in units of the damping ratio: half of what is
/// indistinguishable.
const FREQUENCY_STEP: f64 = 1.2;

/// Quantile of the gains over frequency that counts as typical.
const TYPICAL_QUANTILE: f64 = 0.8;
/// Most turns from one sample to the next.
const MAX_TURNS_PER_SAMPLE: f64 = 1.7;
/// Least share of the proof mass in a shape: an impact on it must have excited the mode.
const MIN_PROOF_MASS_SHARE: f64 = 0.02;

/// Numbers that describe a mode: frequency, damping ratio, shapes at cantilever and proof mass,
/// and coupling to the drive.
pub const MODE_NUMBERS: usize = 5;

/// A ring in phase with its excitation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhaseLockedRing {
    /// Frequency \[Hz\].
    pub frequency: f64,
    /// Damping ratio.
    pub zeta: f64,
    /// Fall of chi2 if it were removed.
    pub gain: f64,
    /// Amplitude at proof mass and cantilever \[m\] that an impact excites, per change of
    /// velocity \[m/s\].
    pub by_impact: [f64; 2],
    /// Amplitude at both \[m\] that a jump of the drive excites, per change of its gain.
    pub by_jump: [f64; 2],
}

impl PhaseLockedRing {
    /// Frequency \[Hz\], damping ratio, shapes at cantilever and proof mass and coupling to
    /// the drive \[kg^-1/2\] of the mode of `model` that rings like this. If impacts do not
    /// determine its shape at the mass, that is `usual`.
    pub fn mode(&self, model: &Model, usual: f64) -> [f64; MODE_NUMBERS] {
        let omega = TAU * self.frequency;
        let mass = 1.0 / model.structure().mobility();
        let [blow, jump] = [self.by_impact, self.by_jump].map(Vector2::from);
        let eta = model.parameters[ParameterId::Eta];
        // Both amplitudes are the mode's shape times its coupling to the excitation.
        let swings = mass * omega * blow.norm() > eta * jump.norm();
        let shape = if swings { blow } else { jump };
        let shape = shape / shape.norm().max(1e-300);
        let at_mass =
            if shape.x < 0.0 { -1.0 } else { 1.0 } * shape.x.abs().max(MIN_PROOF_MASS_SHARE);
        let square = omega * blow.dot(&shape) / (mass * at_mass);
        let size = if square.abs() > 0.0 {
            square.abs().sqrt()
        } else {
            usual / at_mass.abs()
        };
        let drive = jump.dot(&shape) * omega * omega / (eta * size).max(1e-300);
        [
            self.frequency,
            self.zeta,
            size * shape.y,
            size * at_mass,
            drive,
        ]
    }
}

/// Residuals of a fit, and what may have excited rings in them.
pub struct ImpactExcitations {
    residuals: Vec<SegmentResiduals>,
    band: SearchBand,
    kicks: Vec<Kicks>,
    /// Noise of both readings \[m\].
    noise: [f64; 2],
}

impl ImpactExcitations {
    /// Residuals of `fitted`, a fit to the recordings of `side`, with their excitations.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense.
    pub fn new(side: &Split, fitted: &Fitted) -> Result<Self, SimError> {
        let data = &fitted.problem.data;
        let residuals = residual_spectrum::flight_residuals(fitted)?;
        Ok(Self {
            kicks: kicks_of(side, fitted),
            band: SearchBand::of(fitted, &residuals),
            residuals,
            noise: data
                .first()
                .map_or([0.0; 2], |d| [d.sigmas.xp, d.sigmas.xc]),
        })
    }

    /// The frequencies that are searched.
    pub fn band(&self) -> SearchBand {
        self.band
    }

    /// The ring up to `quickest` \[Hz\] that stands out, if any. Its phase also identifies
    /// rings above the Nyquist frequency.
    pub fn strongest(&self, quickest: f64) -> Option<PhaseLockedRing> {
        let rates = self.residuals.iter().map(|own| 1.0 / own.interval);
        let rate = rates.fold(f64::INFINITY, f64::min);
        let highest = quickest.min(MAX_TURNS_PER_SAMPLE * rate);
        let lowest = self.band.lowest;
        if !(highest > lowest && highest.is_finite()) {
            return None;
        }
        let mut all = self.scan(lowest, highest);
        // Slow motion appears here too, by aliasing.
        all.retain(|p| (p.frequency - rate * (p.frequency / rate).round()).abs() > lowest);
        let best = *all.iter().max_by(|a, b| a.gain.total_cmp(&b.gain))?;
        all.retain(|p| p.zeta == best.zeta);
        let mut gains: Vec<f64> = all.iter().map(|p| p.gain).collect();
        let usual = crate::recording::quantile_in_place(&mut gains, TYPICAL_QUANTILE);
        log::debug!("{best:?} where {usual:.1} is usual");
        (best.gain > RING_MIN_GAIN && best.gain > RING_MIN_CONTRAST * usual).then_some(best)
    }

    /// The ring with the largest gain within `reach` of `frequency` \[Hz\].
    pub fn best_near(&self, frequency: f64, reach: f64) -> Option<PhaseLockedRing> {
        let (low, high) = ((frequency - reach).max(0.1 * frequency), frequency + reach);
        let all = self.scan(low, high).into_iter();
        all.max_by(|a, b| a.gain.total_cmp(&b.gain))
    }

    /// Rings on a grid between those frequencies \[Hz\].
    fn scan(&self, low: f64, high: f64) -> Vec<PhaseLockedRing> {
        let tried = DAMPING_GRID.iter().flat_map(|&zeta| {
            let count = ((high / low).ln() / (FREQUENCY_STEP * zeta))
                .ceil()
                .max(0.0) as usize;
            // Evenly spaced in the logarithm.
            let count = count.max(1);
            (0..=count).map(move |k| (low * (high / low).powf(k as f64 / count as f64), zeta))
        });
        let tried: Vec<(f64, f64)> = tried.collect();
        tried
            .into_par_iter()
            .filter_map(|(frequency, zeta)| self.fit_ring(frequency, zeta))
            .collect()
    }

    /// The ring of that frequency \[Hz\] and damping ratio by linear least squares; `None` if
    /// it is not determined.
    fn fit_ring(&self, frequency: f64, zeta: f64) -> Option<PhaseLockedRing> {
        let omega = TAU * frequency;
        let rate = Complex::new(-zeta * omega, omega * (1.0 - zeta * zeta).sqrt());
        let mut normal = [Matrix2::zeros(); 2];
        let mut slopes = [Vector2::zeros(); 2];
        for own in &self.residuals {
            let [impacts, jumps] = &self.kicks[own.recording];
            // An impact changes the velocity, a jump of the drive the rest position.
            let mut by_impacts: Vec<f64> = ring_course(own, impacts, rate).map(|c| c.im).collect();
            let mut driven: Vec<f64> = ring_course(own, jumps, rate).map(|c| -c.re).collect();
            own.colour.whiten(&mut by_impacts);
            own.colour.whiten(&mut driven);
            let rows = || {
                by_impacts
                    .iter()
                    .zip(&driven)
                    .map(|(a, b)| Vector2::new(*a, *b))
            };
            let squares: Matrix2<f64> = rows().map(|row| row * row.transpose()).sum();
            for (channel, values) in own.channels.iter().enumerate() {
                // With missing samples the two do not match.
                if values.len() != by_impacts.len() {
                    continue;
                }
                normal[channel] += squares;
                slopes[channel] += rows()
                    .zip(values)
                    .map(|(row, r)| row * *r)
                    .sum::<Vector2<f64>>();
            }
        }
        // Both readings share in it in the same ratio, whatever excited it.
        let roots = normal.map(|normal| {
            let eigen = SymmetricEigen::new(normal);
            let least = 1e-9 * eigen.eigenvalues.amax();
            let root = |v: f64| if v > least { v.powf(-0.5) } else { 0.0 };
            eigen.eigenvectors * Matrix2::from_diagonal(&eigen.eigenvalues.map(root))
        });
        let each = [0, 1].map(|i| roots[i].tr_mul(&slopes[i]));
        let shared = SymmetricEigen::new(Matrix2::from_fn(|i, j| each[i].dot(&each[j])));
        let top = shared.eigenvalues.imax();
        let gain = shared.eigenvalues[top];
        let shape = shared.eigenvectors.column(top);
        let common = each[0] * shape[0] + each[1] * shape[1];
        let theta = [0, 1].map(|i| roots[i] * common * shape[i] * self.noise[i]);
        gain.is_finite().then_some(PhaseLockedRing {
            frequency,
            zeta,
            gain,
            by_impact: theta.map(|t| t.x),
            by_jump: theta.map(|t| t.y),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::excitations::Kick;
    use super::super::impact_ring::*;
    use crate::fit::residual::coloured_noise::Colour;
    use crate::model::preset::Preset;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const SAMPLING_RATE: f64 = 50e3;
    const READING_NOISE: f64 = 20e-9;

    /// Segments of 4 ms far apart, each starting shortly after an impact and with a jump of the
    /// drive in its middle. In them rings a mode with the parameters `own` of
    /// [`PhaseLockedRing::mode`], in phase with its excitation or `out_of_phase`.
    fn excited_ring(own: [f64; 5], out_of_phase: bool) -> ImpactExcitations {
        let [frequency, zeta, phi_c, phi_p, drive] = own;
        let model = Preset::embedded("paper").unwrap().model;
        let mass = 1.0 / model.structure().mobility();
        let eta = model.parameters[ParameterId::Eta];
        let mut dice = ChaCha8Rng::seed_from_u64(5);
        let omega = TAU * frequency;
        let rate = Complex::new(-zeta * omega, omega * (1.0 - zeta * zeta).sqrt());
        let (mut left, mut kicks) = (Vec::new(), [Vec::new(), Vec::new()]);
        for k in 0..40 {
            let start = 0.1 * f64::from(k);
            let blow = Kick {
                time: start - dice.random_range(1e-4..2e-4),
                size: dice.random_range(0.1..0.5),
            };
            let jump = Kick {
                time: start + dice.random_range(2.0e-3..2.1e-3),
                size: if k % 2 == 0 { 9.7 } else { -9.7 },
            };
            let turned = Complex::from_polar(
                1.0,
                if out_of_phase {
                    2.4 * f64::from(k)
                } else {
                    0.0
                },
            );
            let ring = |i: usize| {
                let at = start + i as f64 / SAMPLING_RATE;
                let since = |kick: &Kick| (rate * (at - kick.time)).exp() * turned;
                let driven = if at > jump.time {
                    -drive * eta / omega.powi(2) * jump.size * since(&jump).re
                } else {
                    0.0
                };
                phi_p * mass / omega * blow.size * since(&blow).im + driven
            };
            let mut channel = |shape: f64| -> Vec<f64> {
                let mut noise = || -> f64 { (0..12).map(|_| dice.random_range(-0.5..0.5)).sum() };
                (0..200)
                    .map(|i| shape * ring(i) / READING_NOISE + noise())
                    .collect()
            };
            left.push(SegmentResiduals {
                channels: [channel(phi_p), channel(phi_c)],
                recording: 0,
                start,
                interval: 1.0 / SAMPLING_RATE,
                colour: Colour::WHITE,
            });
            kicks[0].push(blow);
            kicks[1].push(jump);
        }
        ImpactExcitations {
            residuals: left,
            band: SearchBand {
                lowest: 1500.0,
                spacing: 100.0,
            },
            kicks: vec![kicks],
            noise: [READING_NOISE; 2],
        }
    }

    #[test]
    fn noise_contains_no_ring_in_phase() {
        assert_eq!(
            excited_ring([7e3, 0.01, 0.0, 0.0, 0.0], false).strongest(40e3),
            None
        );
    }

    #[test]
    fn a_ring_in_phase_is_found_with_its_mode() {
        let own = [7123.0, 0.006, -4000.0, 3500.0, -2500.0];
        let ring = excited_ring(own, false)
            .strongest(40e3)
            .expect("it stands out");
        assert!((ring.frequency / own[0] - 1.0).abs() < own[1], "{ring:?}");
        let model = Preset::embedded("paper").unwrap().model;
        let mode = ring.mode(&model, 0.0);
        // A sign of all three shapes is free.
        for (found, own) in mode[2..].iter().zip(&own[2..]) {
            assert!((found / own - 1.0).abs() < 0.35, "{mode:?}");
        }
    }

    #[test]
    fn an_aliased_ring_is_distinguished_from_its_alias() {
        let own = [41e3, 0.006, -9000.0, 9000.0, -2500.0];
        let ring = excited_ring(own, false);
        let gain = |f: f64| ring.best_near(f, 100.0).map_or(0.0, |ring| ring.gain);
        assert!(gain(own[0]) > 4.0 * gain(SAMPLING_RATE - own[0]));
    }

    #[test]
    fn a_ring_out_of_phase_has_little_gain() {
        let own = [7123.0, 0.006, -4000.0, 3500.0, -2500.0];
        let gain = |out_of_phase: bool| {
            let ring = excited_ring(own, out_of_phase).best_near(own[0], 50.0);
            ring.expect("a spectrum").gain
        };
        assert!(
            gain(true) < 0.2 * gain(false),
            "{} {}",
            gain(true),
            gain(false)
        );
    }
}
