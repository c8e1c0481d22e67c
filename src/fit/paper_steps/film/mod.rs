//! Step 4, film (fig. 9): the decay of the ring after break-off, with the gas film and
//! without, and `Cs` and `gp` by which the two agree with the data.
//!
//! Only the rings are fitted to, a bounded number of them. The mass is held to the ground,
//! released at a free instant and followed up to its next touch, so neither the adhesion nor
//! earlier bounces matter. The fit without film is one of the starts of the fit with film, and
//! both are compared on the same rings.

mod ring_fits;
pub(crate) mod rings;

use serde::{Deserialize, Serialize};

use self::ring_fits::{GAP_COORDINATE, RingFits, STRENGTH_COORDINATE, film_starts};
use self::rings::{rings_of, simulated_rings};
use super::StepError;
use crate::fit::error::FitError;
use crate::fit::options::{FitOptions, Part};
use crate::fit::problem::prepare::Prepared;
use crate::fit::solve::levenberg_marquardt::Control;
use crate::fit::solve::point::Point;
use crate::fit::thresholds::MAX_RING_NOISE_RATIO;
use crate::fit::uncertainty::fit_result::{FitResult, Misfit, misfits, uncertainty};
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::model::unit::counted;
use crate::sim::SimError;

/// One curve of the figure, after one release.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
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
#[derive(Debug, Clone, Serialize, Deserialize)]
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

impl Film {
    /// Whether the rings are followed with the film.
    pub fn follows_rings(&self) -> bool {
        noise_ratio(&self.with_film) < MAX_RING_NOISE_RATIO
    }
}

/// How many times the noise a misfit is.
fn noise_ratio(misfit: &Misfit) -> f64 {
    misfit.rms / misfit.noise.max(f64::MIN_POSITIVE)
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

/// Fits the rings without the film and with it.
fn compare(
    model: &Model,
    sound: &Model,
    prepared: &Prepared,
    options: &FitOptions,
    control: &Control<'_>,
) -> Result<Film, FitError> {
    let space = &prepared.problem.space;
    let mut fits = RingFits::new(prepared, options.iterations, control);
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

/// Says what the rings allow to be concluded from the misfit that is `left`.
fn add_remarks(fit: &mut FitResult, left: &Misfit, better: bool, break_offs: usize) {
    let off = noise_ratio(left);
    let follows = off < MAX_RING_NOISE_RATIO;
    if !better && follows {
        fit.remarks = vec![
            "these recordings show no film: the rings are followed as well without one".to_owned(),
        ];
    }
    if !follows {
        fit.remarks.push(format!(
            "the rings are not followed: the error is {off:.0} times the noise{}. The rest of the device is wrong, or these are recordings of several devices. Fit the whole device first; until then Cs and gp are not reliable",
            if better { "" } else { ", with a film as without one" }
        ));
    }
    let from = counted(break_offs, "break-off");
    fit.remarks.push(format!("from {from}"));
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
