//! The last refinement, with the film and the clocks, and the result with its errors.

use std::sync::Arc;

use super::error::ModalError;
use super::frequency_domain::circle::circle_fit;
use super::frequency_domain::search::worst_local_excess;
use super::frequency_domain::spectra::{ResponsePoint, Spectra, block_length, spectra};
use super::remarks::{Identification, remark_on_mode};
use super::result::{IdentifiedMode, ModalFit, ModalOptions, Quality};
use super::search::{misfit, report};
use super::shapes::{Estimate, Residues, drives_the_point, eta_of, same_mode};
use super::sweeps::{first_spectra, readings};
use super::thresholds::{
    BAND_MARGIN_WIDTHS, MAX_DAMPING_ERROR, MAX_FREQUENCY_ERROR, MIN_RESIDUE_Z,
};
use super::time_domain::data::{Data, Stretch};
use super::time_domain::kernel::Pole;
use super::time_domain::least_squares::{
    Covariance, Effort, Setup, Solution, covariance, refine, residuals, sigma_of, solve_linear,
};
use crate::fit::solve::levenberg_marquardt::Control;
use crate::model::Model;
use crate::model::film::SqueezeFilm;
use crate::model::parameter::ParameterId;
use crate::recording::Recording;

/// What the last refinement takes: its end is far within a standard error of the least squares.
const LAST_EFFORT: Effort = Effort {
    iterations: 40,
    least_gain: 1e-3,
};
/// Rounds in which the film's share follows the shapes; each is off by the film's share of the damping
/// of the last.
const FILM_ROUNDS: usize = 4;
/// Lines of the final responses over the half-width of the lightest mode.
const LINES_PER_WIDTH: f64 = 6.0;
/// Points of a response beyond the resonances, by factors of this.
const THINNED_STEP: f64 = 1.004;
/// Half-widths around a mode in which all lines are kept.
const KEPT_WIDTHS: f64 = 6.0;

/// What the last steps work on.
pub(super) struct Work<'a> {
    pub(super) model: &'a Model,
    pub(super) options: &'a ModalOptions,
    pub(super) data: Data,
    pub(super) band: (f64, f64),
    pub(super) noise: [Option<f64>; 2],
    pub(super) film_shares: Vec<f64>,
}

impl Work<'_> {
    fn has_film(&self) -> bool {
        let model = self.model;
        self.options.film
            && model.has_ground
            && model.parameters[ParameterId::Cs] > 0.0
            && self.data.piezo.is_some()
    }

    /// The last refinement, with skew and film.
    pub(super) fn finish(
        &mut self,
        start: Solution,
        control: &Control<'_>,
    ) -> Result<Solution, ModalError> {
        let cancelled = || control.cancelled();
        let mut found = start;
        let rounds = if self.has_film() { FILM_ROUNDS } else { 1 };
        for round in 0..rounds {
            report(
                control,
                "damping of the modes",
                (round, rounds),
                misfit(&found.linear, self.noise),
            );
            if self.has_film() {
                let offset = mean_offset(&found, self.data.stretches.len());
                let film = SqueezeFilm::new(&self.model.parameters);
                self.data.refresh_film(film, offset);
                self.film_shares = self.shares(&found);
            }
            let shares = self.film_shares.clone();
            let skew = self.options.free_skew;
            let refined = refine(
                &mut self.data,
                &found.poles,
                &shares,
                skew,
                LAST_EFFORT,
                &cancelled,
            );
            if control.cancelled() {
                return Err(ModalError::Cancelled);
            }
            found = refined.ok_or_else(|| ModalError::Singular {
                reason: "two of the modes have become one".to_owned(),
            })?;
        }
        let mut order: Vec<usize> = (0..found.poles.len()).collect();
        order.sort_by(|&a, &b| found.poles[a].omega.total_cmp(&found.poles[b].omega));
        let poles: Vec<Pole> = order.iter().map(|&i| found.poles[i]).collect();
        let shares = order
            .iter()
            .filter_map(|&i| self.film_shares.get(i).copied());
        self.film_shares = shares.collect();
        let setup = Setup {
            poles: &poles,
            film_shares: &self.film_shares,
        };
        let linear = solve_linear(&setup, &self.data).ok_or_else(|| ModalError::Singular {
            reason: "two of the modes have become one".to_owned(),
        })?;
        Ok(Solution { poles, linear })
    }

    /// Film force per input that acts on each mode with its residue: `phi_p / (phi_drive eta)`.
    fn shares(&self, found: &Solution) -> Vec<f64> {
        let Some(covariance) = covariance(&self.data, found, &self.film_shares, false) else {
            return vec![0.0; found.poles.len()];
        };
        let residues = self.residues(found, &covariance, &[]);
        let eta = self.eta(&residues);
        residues
            .iter()
            .zip(&found.poles)
            .map(|(r, pole)| {
                let shape = r.shape(eta, self.known(pole).as_ref());
                let share = shape.map_or(0.0, |s| s.phi_p.value / (s.phi_drive * eta));
                if share.is_finite() { share } else { 0.0 }
            })
            .collect()
    }

    fn residues(
        &self,
        found: &Solution,
        covariance: &Covariance,
        inflation: &[f64],
    ) -> Vec<Residues> {
        let of = |r: usize| {
            let inflation = inflation.get(r).copied().unwrap_or(1.0);
            Residues::of(found, covariance, r, inflation)
        };
        (0..found.poles.len()).map(of).collect()
    }

    /// `eta` of the shapes.
    fn eta(&self, residues: &[Residues]) -> f64 {
        let of_device = match self.model.piezo {
            Some(_) => self.model.parameters[ParameterId::Eta],
            None => 1.0,
        };
        let all: Vec<&Residues> = residues.iter().collect();
        eta_of(self.options.normalisation, &all, of_device)
            .filter(|eta| *eta > 0.0 && eta.is_finite())
            .unwrap_or(if of_device > 0.0 { of_device } else { 1.0 })
    }

    /// What of the device's own mode is needed: where the cantilever is not recorded its shape, and
    /// where the drive is no force on its point the coupling.
    fn known(&self, pole: &Pole) -> Option<crate::model::structure::Mode> {
        let frequency = pole.omega / std::f64::consts::TAU;
        let (_, own) = same_mode(self.model, frequency)?;
        let has_cantilever = self.data.stretches.iter().any(|s| s.readings[1].is_some());
        let needed = !has_cantilever || !drives_the_point(self.model);
        let usable = own.phi_p != 0.0 && own.phi_drive != 0.0;
        (needed && usable && self.model.piezo.is_some()).then_some(own)
    }

    /// The result with errors, circles and remarks.
    pub(super) fn result(
        &self,
        found: &Solution,
        sweeps: &[Arc<Recording>],
        mut remarks: Vec<String>,
    ) -> Result<ModalFit, ModalError> {
        let free_skew = self.options.free_skew;
        let covariance =
            covariance(&self.data, found, &self.film_shares, free_skew).ok_or_else(|| {
                ModalError::Singular {
                    reason: "their errors cannot be computed".to_owned(),
                }
            })?;
        let left = first_spectra(&self.data, &residuals(&self.data, found, &self.film_shares));
        let poles = found.poles.iter();
        let inflation: Vec<f64> = poles.map(|pole| worst_local_excess(&left, *pole)).collect();
        let residues = self.residues(found, &covariance, &inflation);
        let eta = self.eta(&residues);
        let (responses, resolution) = self.responses(found);
        let error = |i: usize, k: f64| (k * covariance.matrix[(i, i)]).max(0.0).sqrt();
        let mut modes = Vec::with_capacity(residues.len());
        for (r, own) in residues.iter().enumerate() {
            let pole = found.poles[r];
            let frequency = pole.omega / std::f64::consts::TAU;
            let mut mode = IdentifiedMode {
                frequency: Estimate {
                    value: frequency,
                    std_error: frequency * error(2 * r, inflation[r]),
                },
                zeta: Estimate {
                    value: pole.zeta,
                    std_error: pole.zeta * error(2 * r + 1, inflation[r]),
                },
                static_gain: own.static_gain,
                ratio: own.ratio(),
                shape: own.shape(eta, self.known(&pole).as_ref()),
                quality: Quality::Identified,
                circles: [0, 1].map(|c: usize| circle_fit(&responses[c], frequency, pole.zeta)),
            };
            mode.quality = quality(&mode, self.band);
            remarks.extend(remark_on_mode(&mode));
            modes.push(mode);
        }
        let residual = [0, 1].map(|c: usize| {
            let at = covariance.shared_at[c]? + found.poles.len();
            Some(Estimate {
                value: found.linear.shared[c].as_ref()?[found.poles.len()],
                std_error: error(at, 1.0),
            })
        });
        let sigma = sigma_of(&found.linear);
        let misfit = [0, 1].map(|c: usize| (found.linear.rows[c] > 0).then_some(sigma[c]));
        let of = Identification {
            model: self.model,
            normalisation: self.options.normalisation,
            piezo: self.data.piezo,
            has_film: self.has_film(),
        };
        remarks.extend(super::remarks::remarks(&of, &modes, self.noise, misfit));
        let used: usize = self.data.stretches.iter().map(Stretch::samples).sum();
        let skew_at = 2 * found.poles.len();
        let mut fit = ModalFit {
            recordings: sweeps.iter().map(|r| r.name.clone()).collect(),
            piezo: self.data.piezo,
            band: self.band,
            modes,
            residual,
            eta,
            normalisation: self.options.normalisation,
            skew: free_skew.then(|| Estimate {
                value: self.data.skew,
                std_error: error(skew_at, 1.0),
            }),
            film: self.has_film(),
            noise: self.noise,
            misfit,
            responses,
            resolution,
            samples: (used, self.data.samples - used.min(self.data.samples)),
            remarks,
        };
        fit.remark_on_device(self.model);
        Ok(fit)
    }

    /// The measured responses, fine enough for the lightest mode.
    fn responses(&self, found: &Solution) -> ([Vec<ResponsePoint>; 2], (f64, usize)) {
        let width = |p: &Pole| p.zeta * p.omega / std::f64::consts::TAU;
        let narrowest = found.poles.iter().map(width).fold(f64::INFINITY, f64::min);
        let length = block_length(&self.data, narrowest / LINES_PER_WIDTH);
        let all = spectra(
            &self.data,
            &readings(&self.data),
            length,
            self.data.piezo.is_none(),
        );
        let resolution = all
            .iter()
            .flatten()
            .next()
            .map_or((0.0, 0), |s| (s.resolution, s.blocks));
        let thinned = all.map(|s| s.map_or_else(Vec::new, |s| self.thinned(&s, found)));
        (thinned, resolution)
    }

    /// All lines near the modes, and some between.
    fn thinned(&self, spectra: &Spectra, found: &Solution) -> Vec<ResponsePoint> {
        let (low, high) = self.band;
        let mut next = low;
        let near = |f: f64| {
            found.poles.iter().any(|p| {
                let own = p.omega / std::f64::consts::TAU;
                (f - own).abs() < KEPT_WIDTHS * p.zeta * own
            })
        };
        let mut points = Vec::new();
        for k in 1..spectra.input.len() {
            let f = k as f64 * spectra.resolution;
            if f < low || f > high || (f < next && !near(f)) {
                continue;
            }
            next = next.max(f * THINNED_STEP);
            points.extend(spectra.at(k));
        }
        points
    }
}

/// Mean offset of the proof mass's reading over the stretches \[m\].
fn mean_offset(found: &Solution, stretches: usize) -> f64 {
    let own = found.linear.locals.iter().take(stretches);
    let offsets: Vec<f64> = own
        .filter_map(|l| l[0].as_ref().and_then(|v| v.iter().next_back().copied()))
        .collect();
    offsets.iter().sum::<f64>() / offsets.len().max(1) as f64
}

fn quality(mode: &IdentifiedMode, (low, high): (f64, f64)) -> Quality {
    let f = mode.frequency.value;
    let margin = BAND_MARGIN_WIDTHS * mode.zeta.value * f;
    if f < low - margin || f > high + margin {
        return Quality::OutsideBand;
    }
    let strongest = mode
        .static_gain
        .iter()
        .flatten()
        .map(|g| g.value.abs() / g.std_error)
        .fold(0.0, f64::max);
    let is_determined = mode.frequency.std_error <= MAX_FREQUENCY_ERROR * f
        && mode.zeta.std_error <= MAX_DAMPING_ERROR * mode.zeta.value
        && strongest >= MIN_RESIDUE_Z
        && mode.shape.is_some();
    if is_determined {
        Quality::Identified
    } else {
        Quality::Weak
    }
}
