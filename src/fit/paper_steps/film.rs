//! Step 4, film (fig. 9): the decay of the ring after break-off, with the gas film and
//! without, and `Cs` and `gp` by which the two agree with the data.
//!
//! Only the rings are fitted to, a bounded number of them. The mass is held to the ground,
//! released at a free instant and followed up to its next touch, so neither the adhesion nor
//! earlier bounces matter. The fit without film is one of the starts of the fit with film, and
//! both are compared on the same rings.

use super::break_off::{break_offs, ring_problem};
use super::{StepError, counted};
use crate::fit::contact_readings::check_readable as readable;
use crate::fit::error::FitError;
use crate::fit::inspect::recording_summary::summarize;
use crate::fit::options::{FitOptions, Part};
use crate::fit::problem::huber::Huber;
use crate::fit::problem::parameter_space::Space;
use crate::fit::problem::prepare::Prepared;
use crate::fit::residual::residual_rows::Encounter;
use crate::fit::residual::simulate_segment::simulate_segment;
use crate::fit::solve::levenberg_marquardt::{Clock, Control, Plan, improve};
use crate::fit::solve::point::{Point, settle};
use crate::fit::thresholds::{MAX_RING_NOISE_RATIO, MIN_STAY_TIME};
use crate::fit::uncertainty::fit_result::{FitResult, Misfit, misfits, uncertainty};
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::sim::{SimError, Stretcher};

/// Free parameters, in the order of the coordinates below.
const FREE_PARAMETERS: [&str; 2] = ["Cs", "gp"];
/// Coordinate of the film's strength at contact.
const STRENGTH_COORDINATE: usize = 0;
/// Coordinate of its thickness there.
const GAP_COORDINATE: usize = 1;
/// Thicknesses of the film at contact, as shares of `dp`, that the fit without film goes
/// on with.
const START_GAP_SHARES: [f64; 3] = [0.15, 0.05, 0.5];
/// Damping by the film at contact at first, as a share of the slowest mode's frequency.
const START_DAMPING_SHARE: f64 = 0.1;
/// Loss at the start: hardly robust, because everything is far off.
const START_LOSS: Huber = Huber(1e3);
/// Rounds in which each ring's own unknowns are found at first.
const START_SETTLE_ROUNDS: usize = 6;

/// One curve of the figure, after one release.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Decay {
    /// Times after the release \[s\].
    pub time: Vec<f64>,
    /// The recording, its zero where the model's is \[m\].
    pub measured: Vec<f64>,
    /// Simulated with the film \[m\].
    pub with_film: Vec<f64>,
    /// And without \[m\].
    pub without_film: Vec<f64>,
}

/// The film.
#[derive(Debug, Clone)]
pub struct Film {
    /// The fit of `Cs` and `gp`.
    pub fit: FitResult,
    /// Misfit of the rings with the film, and without; never larger with it.
    pub with_film: Misfit,
    /// See [`Self::with_film`].
    pub without_film: Misfit,
    /// Film coefficient at the contact gap, `Cs / (gp - dp)^3` \[N s/m\].
    pub at_contact: f64,
    /// How many rings were fitted to.
    pub break_offs: usize,
    /// The ring to which the film matters most.
    pub decay: Option<Decay>,
}

/// Fits `Cs` and `gp` with the rest of the device as in `model`, and leaves the film out
/// for comparison.
///
/// # Errors
/// [`StepError::Unsuited`] if no stay on the ground ends in a ring that can be read,
/// [`StepError::Fit`] if the recordings cannot be used at all.
pub fn film(
    model: &Model,
    parts: &[Part],
    options: &FitOptions,
    control: &Control<'_>,
) -> Result<Film, StepError> {
    let rings = rings_of(model, parts, options)?;
    Ok(compare(
        model,
        &rings.sound,
        &rings.prepared,
        &rings.options,
        control,
    )?)
}

/// The prepared problem of the step.
pub(crate) struct Rings {
    /// The model with a film that has a thickness.
    sound: Model,
    /// What the fit may do.
    options: FitOptions,
    /// One segment for each ring.
    prepared: Prepared,
}

impl Rings {
    /// Names of the recordings that show one.
    pub(crate) fn recordings(&self) -> Vec<String> {
        let problem = &self.prepared.problem;
        let segments = self.prepared.segments.iter();
        let mut names: Vec<String> = segments
            .map(|s| problem.data[s.recording].recording.name.clone())
            .collect();
        names.dedup();
        names
    }
}

/// The rings that can be fitted to.
///
/// # Errors
/// Those of [`film`], except for what only the fit can show.
pub(crate) fn rings_of(
    model: &Model,
    parts: &[Part],
    options: &FitOptions,
) -> Result<Rings, StepError> {
    check(model)?;
    let mut sound = model.clone();
    let dp = sound.parameters[ParameterId::Dp];
    if sound.parameters[ParameterId::Gp] <= dp {
        // The film's thickness is searched from its own starts, so a bad one does not matter.
        sound.parameters.set(ParameterId::Gp, 1.2 * dp);
    }
    sound.check().map_err(FitError::from)?;
    let options = FitOptions {
        free: FREE_PARAMETERS.map(str::to_owned).to_vec(),
        ..options.clone()
    };
    let findings = summarize(&sound, parts);
    readable(&sound, parts, &findings, &options)?;
    let none = || {
        let names: Vec<&str> = parts.iter().map(|p| p.recording.name.as_str()).collect();
        StepError::Unsuited {
            recording: names.join(", "),
            reason: format!(
                "no break-off found: no stay on the ground of {:.1} ms or more ends in half a period of free ring",
                1e3 * MIN_STAY_TIME
            ),
            remedy: "record a 5 Hz ramped square of 8 V, with touch, break-off and the ring after it",
        }
    };
    let found = break_offs(&sound, parts, &findings);
    if found.is_empty() {
        return Err(none());
    }
    let space = Space::new(&sound, &options.free)?;
    let prepared = ring_problem(&sound, &space, &found, &findings, &options)?;
    if prepared.segments.is_empty() {
        return Err(none());
    }
    Ok(Rings {
        sound,
        options,
        prepared,
    })
}

/// Fits the rings without the film and with it.
fn compare(
    model: &Model,
    sound: &Model,
    prepared: &Prepared,
    options: &FitOptions,
    control: &Control<'_>,
) -> Result<Film, FitError> {
    let space = &prepared.problem.space;
    let starts = START_GAP_SHARES.len() + 2;
    let mut fits = RingFits {
        prepared,
        iterations: options.iterations,
        control,
        clock: Clock::new(starts * options.iterations.min(10)),
    };
    let mut x = space.coordinates(sound);
    x.extend_from_slice(&prepared.nuisances);
    let raw = Point::unfitted(x.clone(), &prepared.segments);
    let mut none = x.clone();
    none[STRENGTH_COORDINATE] = space.entries[STRENGTH_COORDINATE].low;
    let mut without = fits.without_film(&none, &raw)?;
    let (mut without_film, _) = misfits(prepared, &without)?;

    let firsts = film_starts(sound, &x, &raw, &without);
    let best = fits.best_with_film(firsts, (without.clone(), without_film.clone()))?;
    let (mut point, mut left, mut better) = best;
    // The fit with film may have found better initial states of the rings: they serve the fit
    // without film, too.
    if better && !control.cancelled() {
        let mut there = point.x.clone();
        there[STRENGTH_COORDINATE] = none[STRENGTH_COORDINATE];
        let again = fits.without_film(&there, &point)?;
        let (misfit, _) = misfits(prepared, &again)?;
        if misfit.rms < without_film.rms {
            (without, without_film) = (again, misfit);
        }
        if without_film.rms <= left.rms {
            (point, left) = (without.clone(), without_film.clone());
            better = false;
        }
    }
    let mut fit = uncertainty(model, prepared, &point, left.chi2)?;
    if better && fit.parameters[GAP_COORDINATE].std_error.is_infinite() {
        // A thickness that the rings do not determine has wandered: it goes back to its start.
        let mut back = point.x.clone();
        back[GAP_COORDINATE] = x[GAP_COORDINATE];
        let back = fits.begin(&back, &point)?;
        let (misfit, _) = misfits(prepared, &back)?;
        if misfit.rms <= without_film.rms {
            (point, left) = (back, misfit);
            fit = uncertainty(model, prepared, &point, left.chi2)?;
        }
    }
    let break_offs = prepared.segments.len();
    add_remarks(&mut fit, &left, better, break_offs);
    fit.train = misfits(prepared, &point)?;
    fit.cancelled = control.cancelled();
    let p = &fit.model.parameters;
    let gap = p[ParameterId::Gp] - p[ParameterId::Dp];
    Ok(Film {
        at_contact: p[ParameterId::Cs] / gap.powi(3),
        with_film: left,
        without_film,
        break_offs,
        decay: most_affected_ring(prepared, &point, &without)?,
        fit,
    })
}

/// Fits of the same rings, with the film and without.
struct RingFits<'a> {
    prepared: &'a Prepared,
    /// Most iterations of each fit.
    iterations: usize,
    control: &'a Control<'a>,
    clock: Clock,
}

impl RingFits<'_> {
    /// The point at unknowns `x`, the rings' initial states fitted from those of `from`.
    fn begin(&self, x: &[f64], from: &Point) -> Result<Point, SimError> {
        settle(
            &self.prepared.problem,
            x,
            &from.segments,
            &from.used,
            START_LOSS,
            START_SETTLE_ROUNDS,
        )
    }

    /// The best fit with the film as in `x`, which is to be none.
    fn without_film(&mut self, x: &[f64], from: &Point) -> Result<Point, FitError> {
        let bare = Plan {
            stage: "without film",
            iterations: self.iterations,
            locked: &[STRENGTH_COORDINATE, GAP_COORDINATE],
            enough: 1e-6,
        };
        let begun = self.begin(x, from)?;
        let problem = &self.prepared.problem;
        Ok(improve(
            problem,
            begun,
            &bare,
            self.control,
            &mut self.clock,
        )?)
    }

    /// The best of `best` and of the fits from `firsts`, and whether it is one of the latter.
    fn best_with_film(
        &mut self,
        firsts: Vec<(Vec<f64>, &Point)>,
        mut best: (Point, Misfit),
    ) -> Result<(Point, Misfit, bool), FitError> {
        let problem = &self.prepared.problem;
        let all = Plan {
            stage: "with film",
            iterations: self.iterations,
            locked: &[],
            enough: 1e-6,
        };
        let mut better = false;
        for (mut there, from) in firsts {
            if self.control.cancelled() {
                break;
            }
            for (x, e) in there.iter_mut().zip(&problem.space.entries) {
                *x = x.clamp(e.low, e.high);
            }
            let begun = self.begin(&there, from)?;
            let point = improve(problem, begun, &all, self.control, &mut self.clock)?;
            let (left, _) = misfits(self.prepared, &point)?;
            if left.rms < best.1.rms {
                best = (point, left);
                better = true;
            }
        }
        Ok((best.0, best.1, better))
    }
}

/// Starts of the fit with film: the model's own film at unknowns `x`, and weak ones of several
/// thicknesses that go on from the fit `without`.
fn film_starts<'a>(
    sound: &Model,
    x: &[f64],
    raw: &'a Point,
    without: &'a Point,
) -> Vec<(Vec<f64>, &'a Point)> {
    let mut firsts = vec![(x.to_vec(), raw)];
    let weak = weak_film_coordinate(sound);
    for share in START_GAP_SHARES {
        let mut there = without.x.clone();
        there[STRENGTH_COORDINATE] = weak;
        there[GAP_COORDINATE] = (share * sound.parameters[ParameterId::Dp]).ln();
        firsts.push((there, without));
    }
    firsts
}

/// Says what the rings allow to be concluded from the misfit that is `left`.
fn add_remarks(fit: &mut FitResult, left: &Misfit, better: bool, break_offs: usize) {
    let off = left.rms / left.noise.max(f64::MIN_POSITIVE);
    let follows = off < MAX_RING_NOISE_RATIO;
    if !better && follows {
        fit.remarks = vec![
            "these recordings show no film: the rings are followed as well without one".to_owned(),
        ];
    }
    if !follows {
        fit.remarks.push(format!(
            "the rings are not followed: the error is {off:.0} times the noise{}. The rest of the device is wrong, or these are recordings of several devices. Fit the whole device first, without `--step`; until then Cs and gp mean little",
            if better { "" } else { ", with a film as without one" }
        ));
    }
    let from = counted(break_offs, "break-off", "break-offs");
    fit.remarks.push(format!("from {from}"));
}

/// Coordinate of a film that hardly damps.
fn weak_film_coordinate(model: &Model) -> f64 {
    let structure = model.structure();
    let modes = structure.modes.iter().map(|m| m.omega());
    let slowest = modes.fold(f64::INFINITY, f64::min).max(1.0);
    (START_DAMPING_SHARE * slowest / structure.mobility()).ln()
}

/// The ring to which the film matters most, at both points.
fn most_affected_ring(
    prepared: &Prepared,
    with: &Point,
    without: &Point,
) -> Result<Option<Decay>, SimError> {
    let (with, without) = (
        simulated_rings(prepared, with)?,
        simulated_rings(prepared, without)?,
    );
    let mut shown: Option<(f64, Decay)> = None;
    for (a, b) in with.into_iter().zip(without) {
        let (Some(a), Some(b)) = (a, b) else { continue };
        let matters = a.2.iter().zip(&b.2).map(|(a, b)| (a - b).abs());
        let matters = matters.fold(0.0, f64::max);
        if shown.as_ref().is_none_or(|s| matters > s.0) {
            let kept: Vec<usize> = (0..a.0.len())
                .filter(|&i| a.0[i] >= 0.0 && a.1[i].is_finite())
                .collect();
            let pick = |values: &[f64]| kept.iter().map(|&i| values[i]).collect();
            let decay = Decay {
                time: pick(&a.0),
                measured: pick(&a.1),
                with_film: pick(&a.2),
                without_film: pick(&b.2),
            };
            shown = Some((matters, decay));
        }
    }
    Ok(shown.map(|s| s.1))
}

/// Times after the release, the reading without the rig's own, and the simulation.
type Ring = (Vec<f64>, Vec<f64>, Vec<f64>);

/// Each segment at a point; `None` where it cannot be simulated.
fn simulated_rings(prepared: &Prepared, point: &Point) -> Result<Vec<Option<Ring>>, SimError> {
    let problem = &prepared.problem;
    let simulator = problem.simulator(&point.x)?;
    let states = problem.states(&point.x, &simulator, &point.segments);
    let mut stretcher = Stretcher::new(&simulator);
    let each = point.segments.iter().zip(&states);
    let ring = each.map(|(segment, states)| {
        let setting = problem.setting(segment, states);
        let rig = problem.nuisances_of(&point.x, segment.recording);
        let done =
            simulate_segment(segment, &setting, &mut stretcher, &rig, &segment.locals).ok()?;
        let release = done.encounters.iter().find_map(|e| match e {
            Encounter::PullOff(Some(pull)) => Some(pull.time - rig.skew),
            _ => None,
        })?;
        let recording = setting.recording;
        let samples = segment.samples.clone();
        let time = recording.time[samples.clone()].iter();
        let read = recording.proof_mass[samples].iter();
        Some((
            time.map(|t| t - release).collect(),
            read.map(|x| (x - rig.offset_p) / rig.scale_p).collect(),
            done.xp,
        ))
    });
    Ok(ring.collect())
}

/// Whether a model has what the step is about.
///
/// # Errors
/// [`StepError::Device`] if it has no ground.
pub fn check(model: &Model) -> Result<(), StepError> {
    if model.has_ground {
        return Ok(());
    }
    Err(StepError::Device {
        device: model.name.clone(),
        what: "ground",
        step: "the film",
    })
}
