//! The identification, step by step.

use std::sync::Arc;
use std::time::Duration;

use super::error::ModalError;
use super::frequency_domain::circle::circle_fit;
use super::frequency_domain::search::{candidates, local_excess};
use super::frequency_domain::spectra::{ResponsePoint, Spectra, block_length, spectra};
use super::result::{IdentifiedMode, InputChoice, ModalFit, ModalOptions, Quality};
use super::shapes::{Estimate, Normalisation, Residues, drives_the_point, eta_of, same_mode};
use super::thresholds::{
    BAND_MARGIN_WIDTHS, CLEAR_OF_GROUND, MAX_CIRCLE_DAMPING_DIFFERENCE,
    MAX_CIRCLE_FREQUENCY_DIFFERENCE, MAX_DAMPING_ERROR, MAX_FREQUENCY_ERROR, MAX_MISFIT_RATIO,
    MAX_ZETA, MIN_BAND_RATIO, MIN_DRIVEN_FILL, MIN_DRIVEN_LINES, MIN_DRIVEN_SHARE, MIN_MODE_GAIN,
    MIN_RESIDUE_Z, MIN_STRETCH_PERIODS,
};
use super::time_domain::data::{Data, Stretch};
use super::time_domain::kernel::Pole;
use super::time_domain::least_squares::{
    Covariance, Setup, Solution, covariance, gain, refine, residuals, sigma_of, solve_linear,
};
use crate::fit::solve::levenberg_marquardt::{Control, Progress};
use crate::model::Model;
use crate::model::film::SqueezeFilm;
use crate::model::parameter::ParameterId;
use crate::model::unit::{counted, format_quantity};
use crate::recording::{Channel, Recording};

/// Share of the longest stretch that a block of the first spectra has.
const FIRST_BLOCK_SHARE: f64 = 0.25;
/// Starts that are tried for each further mode.
const STARTS: usize = 3;
/// Iterations for a start, and for the end.
const ITERATIONS: (usize, usize) = (15, 40);
/// Rounds in which the film's share follows the shapes; each is off by the film's share of the damping
/// of the last.
const FILM_ROUNDS: usize = 4;
/// Lines of the final responses over the half-width of the lightest mode.
const LINES_PER_WIDTH: f64 = 6.0;
/// Two poles are the same up to this share of their width.
const SAME_POLE_SHARE: f64 = 0.1;
/// Points of a response beyond the resonances, by factors of this.
const THINNED_STEP: f64 = 1.004;
/// Half-widths around a mode in which all lines are kept.
const KEPT_WIDTHS: f64 = 6.0;

/// Whether a recording's voltage goes over a band of frequencies: its turns are many, and not evenly
/// apart.
#[must_use]
pub fn is_sweep(recording: &Recording) -> bool {
    let Some(Ok(drive)) = recording.own_drive() else {
        return false;
    };
    let mut turns: Vec<f64> = Vec::new();
    for pair in drive.pieces.windows(2) {
        if pair[0].branch != pair[1].branch {
            turns.push(pair[1].start);
        }
    }
    let mut apart: Vec<f64> = turns.windows(2).map(|w| w[1] - w[0]).collect();
    if apart.len() < MIN_DRIVEN_LINES {
        return false;
    }
    apart.sort_by(f64::total_cmp);
    let at = |share: f64| apart[((apart.len() - 1) as f64 * share) as usize];
    at(0.9) > MIN_BAND_RATIO * at(0.1)
}

/// Names of the recordings that are sweeps in which the mass stays clear of the ground of `model`.
#[must_use]
pub fn sweeps_clear_of_ground(model: &Model, recordings: &[Arc<Recording>]) -> Vec<String> {
    let dp = model.parameters[ParameterId::Dp];
    let is_clear = |r: &Recording| {
        let lowest = r.proof_mass.iter().copied().fold(f64::INFINITY, f64::min);
        !model.has_ground || lowest > -CLEAR_OF_GROUND * dp
    };
    let all = recordings.iter().filter(|r| is_clear(r) && is_sweep(r));
    all.map(|r| r.name.clone()).collect()
}

/// Identifies the modes of a device from swept sines; recordings that are none are left aside. `model`
/// gives the drive's branches, the gas film, and `eta`.
///
/// # Errors
/// [`ModalError`] with one clear sentence.
pub fn identify(
    model: &Model,
    recordings: &[Arc<Recording>],
    options: &ModalOptions,
    control: &Control<'_>,
) -> Result<ModalFit, ModalError> {
    let (sweeps, mut remarks) = sweeps_of(recordings)?;
    let piezo = model
        .piezo
        .filter(|_| options.input == InputChoice::Automatic);
    let mut data = Data::new(model, &sweeps, piezo)?;
    let band = driven_band(&data, &sweeps)?;
    data.drop_short(MIN_STRETCH_PERIODS / band.0);
    if data.stretches.is_empty() {
        return Err(ModalError::NoSweep {
            recording: names(&sweeps),
            reason: "the mass touches the ground in every few periods".to_owned(),
        });
    }
    if data.left_out > 0 {
        remarks.push(format!(
            "{:.1} % of the samples are left out: the mass touches the ground there, or between two touches is free for too short.",
            100.0 * data.left_out as f64 / data.samples as f64
        ));
    }
    let mut found = find_modes(&mut data, band, options, control)?;
    let mut work = Work {
        model,
        options,
        data,
        band,
        film_shares: Vec::new(),
    };
    found = work.finish(found, control)?;
    work.result(&found, &sweeps, remarks)
}

fn names(recordings: &[Arc<Recording>]) -> String {
    let names: Vec<&str> = recordings.iter().map(|r| r.name.as_str()).collect();
    names.join(", ")
}

/// The recordings that are sweeps, and a remark on the others.
fn sweeps_of(
    recordings: &[Arc<Recording>],
) -> Result<(Vec<Arc<Recording>>, Vec<String>), ModalError> {
    if recordings.is_empty() {
        return Err(ModalError::NoRecording);
    }
    if let Some(mute) = recordings.iter().find(|r| r.own_drive().is_none()) {
        return Err(ModalError::NoVoltage {
            recording: mute.name.clone(),
        });
    }
    let (sweeps, others): (Vec<_>, Vec<_>) = recordings.iter().cloned().partition(|r| is_sweep(r));
    if sweeps.is_empty() {
        return Err(ModalError::NoSweep {
            recording: names(recordings),
            reason: "the voltage is no swept sine".to_owned(),
        });
    }
    let aside =
        (!others.is_empty()).then(|| format!("No swept sine, so not used: {}.", names(&others)));
    Ok((sweeps, aside.into_iter().collect()))
}

/// The band of frequencies that the input drives \[Hz\].
fn driven_band(data: &Data, sweeps: &[Arc<Recording>]) -> Result<(f64, f64), ModalError> {
    let fail = |reason: String| ModalError::NoSweep {
        recording: names(sweeps),
        reason,
    };
    // The voltage tells the band: the jumps of the branches drive all frequencies a little.
    let mut by_voltage = data.clone();
    by_voltage.piezo = None;
    let found = first_spectra(&by_voltage, &readings(data));
    let spectra = found
        .iter()
        .flatten()
        .find(|s| s.blocks > 0)
        .ok_or_else(|| {
            fail("there is no uninterrupted stretch to take a spectrum of".to_owned())
        })?;
    let lines = spectra.driven(MIN_DRIVEN_SHARE);
    let (Some(first), Some(last)) = (lines.first(), lines.last()) else {
        return Err(fail("the voltage is constant".to_owned()));
    };
    let band = (
        *first as f64 * spectra.resolution,
        *last as f64 * spectra.resolution,
    );
    let fill = lines.len() as f64 / (last - first + 1) as f64;
    if lines.len() < MIN_DRIVEN_LINES || band.1 < MIN_BAND_RATIO * band.0 || fill < MIN_DRIVEN_FILL
    {
        return Err(fail(format!(
            "the voltage drives only {} from {} to {}",
            counted(lines.len(), "frequency line"),
            format_quantity(band.0, "Hz", 3),
            format_quantity(band.1, "Hz", 3)
        )));
    }
    Ok(band)
}

fn readings(data: &Data) -> Vec<[Option<Vec<f64>>; 2]> {
    data.stretches.iter().map(|s| s.readings.clone()).collect()
}

fn first_spectra(data: &Data, readings: &[[Option<Vec<f64>>; 2]]) -> [Option<Spectra>; 2] {
    let longest = data
        .stretches
        .iter()
        .map(Stretch::samples)
        .max()
        .unwrap_or(0);
    let resolution = 1.0 / (FIRST_BLOCK_SHARE * longest.max(1) as f64 * data.interval);
    spectra(data, readings, block_length(data, resolution), false)
}

fn report(control: &Control<'_>, stage: &'static str, modes: usize, most: usize) {
    (control.progress)(&Progress {
        stage,
        iteration: modes,
        expected: most,
        misfit: 0.0,
        values: Vec::new(),
        remaining: Duration::ZERO,
        doubts: Arc::from(Vec::new()),
    });
}

/// Adds modes one by one, as long as each gains more than chance would.
fn find_modes(
    data: &mut Data,
    band: (f64, f64),
    options: &ModalOptions,
    control: &Control<'_>,
) -> Result<Solution, ModalError> {
    let singular = || ModalError::Singular {
        reason: "the readings hold too few samples".to_owned(),
    };
    let empty = Setup {
        poles: &[],
        film_shares: &[],
    };
    let linear = solve_linear(&empty, data).ok_or_else(singular)?;
    let mut found = Solution {
        poles: Vec::new(),
        linear,
    };
    while found.poles.len() < options.max_modes {
        report(
            control,
            "modes of the sweep",
            found.poles.len(),
            options.max_modes,
        );
        let left = first_spectra(data, &residuals(data, &found, &[]));
        let mut best: Option<Solution> = None;
        for candidate in candidates(&left, band, STARTS) {
            let mut poles = found.poles.clone();
            poles.push(candidate.pole);
            let cancelled = || control.cancelled();
            let trial = refine(data, &poles, &[], false, ITERATIONS.0, &cancelled);
            if control.cancelled() {
                return Err(ModalError::Cancelled);
            }
            let is_better = |t: &Solution| {
                is_mode_of_its_own(t)
                    && best
                        .as_ref()
                        .is_none_or(|b| gain(&b.linear, &t.linear) > 0.0)
            };
            if let Some(trial) = trial.filter(is_better) {
                best = Some(trial);
            }
        }
        let Some(best) = best.filter(|b| is_significant(data, &found, b)) else {
            break;
        };
        found = best;
    }
    if found.poles.is_empty() {
        return Err(ModalError::NoMode {
            from: format_quantity(band.0, "Hz", 3),
            to: format_quantity(band.1, "Hz", 3),
        });
    }
    Ok(found)
}

/// Whether the last pole is a resonance, and none of the others again.
fn is_mode_of_its_own(found: &Solution) -> bool {
    let Some((new, others)) = found.poles.split_last() else {
        return false;
    };
    let is_double = |other: &Pole| {
        let width = SAME_POLE_SHARE * new.zeta.min(other.zeta);
        (new.omega / other.omega).ln().abs() < width
            && (new.zeta / other.zeta).ln().abs() < SAME_POLE_SHARE
    };
    !found.poles.iter().any(|p| p.zeta > MAX_ZETA) && !others.iter().any(is_double)
}

/// Whether the last pole of `better` gains more than chance.
fn is_significant(data: &Data, worse: &Solution, better: &Solution) -> bool {
    let Some(new) = better.poles.last() else {
        return false;
    };
    let readings = better.linear.rows.iter().filter(|r| **r > 0).count();
    let unknowns = 2 + readings * (1 + 2 * data.stretches.len());
    // Noise of one colour counts by what it has at the resonance.
    let left = first_spectra(data, &residuals(data, better, &[]));
    let excess = left
        .iter()
        .flatten()
        .map(|s| local_excess(s, *new))
        .fold(1.0, f64::max);
    gain(&worse.linear, &better.linear) / excess > MIN_MODE_GAIN + unknowns as f64
}

/// What the last steps work on.
struct Work<'a> {
    model: &'a Model,
    options: &'a ModalOptions,
    data: Data,
    band: (f64, f64),
    film_shares: Vec<f64>,
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
    fn finish(&mut self, start: Solution, control: &Control<'_>) -> Result<Solution, ModalError> {
        let cancelled = || control.cancelled();
        let mut found = start;
        let rounds = if self.has_film() { FILM_ROUNDS } else { 1 };
        for round in 0..rounds {
            report(control, "damping of the modes", round, rounds);
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
                ITERATIONS.1,
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
    fn result(
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
        let inflation: Vec<f64> = found
            .poles
            .iter()
            .map(|pole| {
                left.iter()
                    .flatten()
                    .map(|s| local_excess(s, *pole))
                    .fold(1.0, f64::max)
            })
            .collect();
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
        let noise = noise_of(sweeps);
        remarks.extend(self.remarks(&modes, noise, misfit));
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
            noise,
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

    /// Remarks on the whole.
    fn remarks(
        &self,
        modes: &[IdentifiedMode],
        noise: [Option<f64>; 2],
        misfit: [Option<f64>; 2],
    ) -> Vec<String> {
        let mut remarks = Vec::new();
        for ((noise, misfit), name) in noise.into_iter().zip(misfit).zip(["xp", "xc"]) {
            if let (Some(noise), Some(misfit)) = (noise, misfit)
                && misfit > MAX_MISFIT_RATIO * noise
            {
                remarks.push(format!(
                    "The modes leave {} of {name}, {:.1} times its noise of {}: the device is not linear there, or the input is not what is assumed.",
                    format_quantity(misfit, "m", 3),
                    misfit / noise,
                    format_quantity(noise, "m", 3)
                ));
            }
        }
        let has_cantilever = modes.iter().any(|m| m.static_gain[1].is_some());
        if self.model.piezo.is_none() && matches!(self.options.normalisation, Normalisation::Eta) {
            remarks.push("The device has no drive yet, so eta is taken as 1 N/V, and the scale of the shapes is arbitrary: give a known modal mass or stiffness.".to_owned());
        }
        if self.data.piezo.is_none() {
            remarks.push("The input is the voltage itself: the gain of the drive is in the shapes, and hysteresis would be misfit.".to_owned());
        }
        if !has_cantilever {
            remarks.push("xc was not recorded: only the product of the shapes at both points is measured. phi_p is that of the device where it has the mode, and the coupling to the drive follows.".to_owned());
        } else if matches!(self.options.normalisation, Normalisation::Eta) {
            remarks.push("The scale of the shapes is that of eta: a drive twice as strong on a device twice as heavy moves the same. A known mass or stiffness would tell it.".to_owned());
        } else if !drives_the_point(self.model) && self.model.piezo.is_some() {
            remarks.push("The drive's coupling to each mode is that of the device; its shapes follow from it.".to_owned());
        }
        let reversed = modes
            .iter()
            .filter_map(|m| m.static_gain[1])
            .any(|g| g.value < 0.0);
        if reversed && self.data.piezo.is_some() && drives_the_point(self.model) {
            remarks.push("A mode moves the cantilever against the drive: check the signs of V and xc, and whether xc is read where the drive acts.".to_owned());
        }
        let film = self.has_film();
        if self.model.has_ground && self.model.parameters[ParameterId::Cs] > 0.0 {
            remarks.push(if film {
                "The damping by the gas film (Cs, gp) is taken out: zeta is that of the structure."
                    .to_owned()
            } else {
                "The damping ratios contain that by the gas film.".to_owned()
            });
        }
        if !self.model.effects.is_empty() {
            remarks.push("Effects of the device are not considered in this step.".to_owned());
        }
        remarks
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

fn noise_of(sweeps: &[Arc<Recording>]) -> [Option<f64>; 2] {
    [Channel::ProofMass, Channel::Cantilever].map(|channel| {
        let all = sweeps.iter().filter_map(|r| r.noise(channel));
        all.map(|n| n.sigma).reduce(f64::max)
    })
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

fn remark_on_mode(mode: &IdentifiedMode) -> Vec<String> {
    let f = mode.frequency.value;
    let at = format_quantity(f, "Hz", 4);
    let mut remarks = Vec::new();
    match mode.quality {
        Quality::Identified => {}
        Quality::Weak => remarks.push(format!(
            "A mode near {at} is seen but too weakly excited to be determined: frequency +- {:.2} %, damping +- {:.0} %. It is not given to the device.",
            100.0 * mode.frequency.std_error / f,
            100.0 * mode.zeta.std_error / mode.zeta.value
        )),
        Quality::OutsideBand => remarks.push(format!(
            "A resonance near {at}, outside the swept band, stands for what the modes there add. It is not given to the device."
        )),
    }
    // The circle of the reading on which it is clearest.
    let clearest = mode
        .circles
        .iter()
        .flatten()
        .min_by(|a, b| a.scatter.total_cmp(&b.scatter));
    if let (Some(circle), Quality::Identified) = (clearest, mode.quality) {
        let frequency = (circle.frequency.0 / f - 1.0).abs();
        let damping = (circle.zeta.0 / mode.zeta.value - 1.0).abs();
        if frequency > MAX_CIRCLE_FREQUENCY_DIFFERENCE || damping > MAX_CIRCLE_DAMPING_DIFFERENCE {
            remarks.push(format!(
                "The circle fit of the mode at {at} differs: {} and zeta {:.4} for {:.4}. Close modes, or damping by the film, move it.",
                format_quantity(circle.frequency.0, "Hz", 5),
                circle.zeta.0,
                mode.zeta.value
            ));
        }
    }
    remarks
}
