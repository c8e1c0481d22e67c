//! Hypotheses of further modes: from a peak in the spectrum of the residuals, or from a ring in
//! them that is in phase with its excitation. One more mode may be added to a further one, because
//! a structure has infinitely many.

use crate::diagnose::comparison::hypothesis::Hypothesis;
use crate::diagnose::comparison::trial::ModelState;
use crate::diagnose::discrepancy::impact_ring::{ImpactExcitations, MODE_NUMBERS, PhaseLockedRing};
use crate::diagnose::discrepancy::residual_spectrum;
use crate::diagnose::options::DiagnoseError;
use crate::diagnose::shooting::fitted::Bound;
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::thresholds::{
    FOUND_MODE_MIN_SCORE, MODE_ALIAS_DECIDED_GAIN, MODE_ALIAS_MIN_SHARE, MODE_RING_MIN_GAIN,
    PEAK_MIN_SIGNIFICANCE, SAME_MODE_FREQUENCY_SHARE,
};
use crate::model::Model;
use crate::model::effects::{ActiveEffect, EffectSpec, own_ids};

/// Motion of a further mode at the mass, as a share of that of all modes.
const HIDDEN_MODE_SHARE: f64 = 0.06;

/// How far above the highest known mode a further one is searched for, as a factor; in any case as far
/// as the samples show. The next bending modes of a beam are at 2.8 and 5.5 times its second.
const FREQUENCY_REACH: f64 = 6.2;

/// Bounds of a mode's frequency, relative to where it was found.
const FREQUENCY_BOUND_FACTORS: (f64, f64) = (0.9, 1.1);

/// The hypothesis of a further mode, if there is a sign of one.
///
/// # Errors
/// [`DiagnoseError`] if the model cannot be simulated.
pub fn extra_mode_hypothesis(
    workspace: &Workspace,
    state: &ModelState,
    spec: &'static EffectSpec,
) -> Result<Option<Hypothesis>, DiagnoseError> {
    let model = &state.train.model;
    let excitations = ImpactExcitations::new(&workspace.train, &state.train)?;
    let peak = residual_spectrum::strongest_peak(&state.train)?
        .filter(|ring| ring.significance > PEAK_MIN_SIGNIFICANCE);
    // A mass-normalised shape is of the order of the structure's own, but an unnoticed mode
    // hardly moves the mass.
    let usual = model.structure().mobility().sqrt();
    // A second mode is searched for once this one is established.
    let with = |own: [f64; 5]| ActiveEffect {
        spec,
        values: own
            .into_iter()
            .chain([own[0], 0.01, 0.0, 0.0, 0.0])
            .collect(),
    };
    let rate = residual_spectrum::slowest_rate(&state.train).unwrap_or(f64::INFINITY);
    let band = excitations.band();
    let near = |f: f64| mode_bounds(spec, [0, 1], f, (rate, band.lowest)).to_vec();
    let in_step = |ring: &PhaseLockedRing| (with(mode_of_ring(ring, model)), near(ring.frequency));
    // By aliasing, the true frequency may be higher.
    let quickest = highest_searched(model, rate, FREQUENCY_REACH);
    let mut places = Vec::new();
    if let Some(peak) = &peak {
        let (p, c) = peak.shape;
        let size = usual * (HIDDEN_MODE_SHARE / p.abs().max(HIDDEN_MODE_SHARE));
        let all = std::iter::once(peak.frequency).chain(peak.aliases());
        let place = |f: f64| match ring_near(&excitations, f) {
            Some(ring) => (ring.gain, in_step(&ring)),
            None => (0.0, (with([f, 0.01, size * c, size * p, 0.0]), near(f))),
        };
        places.extend(all.filter(|f| *f < quickest).map(place));
    }
    let in_phase = excitations.strongest(quickest);
    let known = |ring: &PhaseLockedRing| {
        let mut all = places.iter();
        all.any(|(_, (start, _))| {
            (start.values[0] / ring.frequency).ln().abs() < SAME_MODE_FREQUENCY_SHARE
        })
    };
    if let Some(ring) = in_phase.as_ref().filter(|ring| !known(ring)) {
        places.push((ring.gain, in_step(ring)));
    }
    places.sort_by(|a, b| b.0.total_cmp(&a.0));
    let best = places.first().map_or(0.0, |place| place.0);
    if best > MODE_ALIAS_DECIDED_GAIN {
        places.retain(|place| place.0 > MODE_ALIAS_MIN_SHARE * best);
    }
    let gain = peak
        .map(|h| h.gain)
        .into_iter()
        .chain(in_phase.map(|s| s.gain));
    let gain = gain.fold(0.0, f64::max);
    let mut places = places.into_iter().map(|place| place.1);
    let Some((start, bounds)) = places.next() else {
        return Ok(None);
    };
    Ok(Some(Hypothesis {
        start,
        alternative_starts: places.collect(),
        free: own_ids(spec, &[0, 1, 2, 3, 4]),
        cold_start: None,
        shape: own_ids(spec, &[5, 6, 7, 8]),
        bounds,
        predicted_gain: gain.max(FOUND_MODE_MIN_SCORE),
        look_elsewhere: false,
        sequential_time: false,
        estimated_on_held_out: None,
    }))
}

/// Highest frequency at which a further mode of `model` is searched for \[Hz\] in recordings sampled at
/// `rate` \[Hz\]: `reach` times that of its highest mode, and all that the samples show.
pub fn highest_searched(model: &Model, rate: f64, reach: f64) -> f64 {
    let structure = model.structure();
    let known = structure.modes.iter().map(|m| m.frequency);
    let highest = known.fold(0.0, f64::max);
    (reach * highest).max(0.5 * rate)
}

/// The ring near `frequency` \[Hz\] that is in phase with `excitations`, if there is one.
pub fn ring_near(excitations: &ImpactExcitations, frequency: f64) -> Option<PhaseLockedRing> {
    let ring = excitations.best_near(frequency, excitations.band().spacing);
    ring.filter(|ring| ring.gain > MODE_RING_MIN_GAIN)
}

/// Frequency, damping ratio and shapes of a further mode of `model` that rings like `ring`.
pub fn mode_of_ring(ring: &PhaseLockedRing, model: &Model) -> [f64; MODE_NUMBERS] {
    ring.mode(
        model,
        HIDDEN_MODE_SHARE * model.structure().mobility().sqrt(),
    )
}

/// Bounds of the frequency and damping ratio, the parameters `which` of `spec`, of a mode near `f`
/// \[Hz\] in recordings sampled at `rate` \[Hz\] and searched from `lowest` \[Hz\] on. A mode that is
/// free to become slow and overdamped could imitate any force, and so could one that appears slow
/// by aliasing.
pub fn mode_bounds(
    spec: &EffectSpec,
    which: [usize; 2],
    f: f64,
    (rate, lowest): (f64, f64),
) -> [Bound; 2] {
    let (mut low, mut high) = (FREQUENCY_BOUND_FACTORS.0 * f, FREQUENCY_BOUND_FACTORS.1 * f);
    let turns = (f / rate).round() * rate;
    if turns > 0.0 {
        let slow = FREQUENCY_BOUND_FACTORS.0 * lowest;
        if f < turns {
            high = high.min(turns - slow).max(f);
        } else {
            low = low.max(turns + slow).min(f);
        }
    }
    let bounds = [(low, high), (1e-4, 0.1)];
    let mut ids = own_ids(spec, &which).into_iter();
    bounds.map(|bound| (ids.next().unwrap_or_default(), bound))
}

#[cfg(test)]
mod tests {
    use super::super::extra_mode::*;
    use crate::model::effects::extra_mode::EFFECT;

    #[test]
    fn the_search_reaches_as_far_as_modes_and_samples_go() {
        use crate::model::preset::Preset;

        let model = |name: &str| Preset::embedded(name).unwrap().model;
        let paper = highest_searched(&model("paper"), 50e3, FREQUENCY_REACH);
        assert!((paper - 6.2 * 6424.0).abs() < 1.0, "{paper}");
        // A spring of 1.37 Hz and a free mass, read at 100 Hz: up to the Nyquist frequency.
        for name in ["oscillator", "faller"] {
            assert_eq!(highest_searched(&model(name), 100.0, FREQUENCY_REACH), 50.0);
        }
    }

    #[test]
    fn a_mode_does_not_move_to_where_its_alias_is_slow() {
        let frequencies = |f: f64, rate: f64, (low, high): (f64, f64)| {
            let found = mode_bounds(&EFFECT, [0, 1], f, (rate, 1500.0))[0].1;
            let off = (found.0 - low).abs().max((found.1 - high).abs());
            assert!(off < 1e-6, "{f}: {found:?}");
        };
        frequencies(7e3, 50e3, (6.3e3, 7.7e3));
        frequencies(7e3, f64::INFINITY, (6.3e3, 7.7e3));
        // Read as 1.5 kHz; 0.63 kHz would be the first mode of the device.
        frequencies(48.5e3, 50e3, (43.65e3, 48.65e3));
        frequencies(26.5e3, 25e3, (26.35e3, 29.15e3));
        frequencies(60e3, 50e3, (54e3, 66e3));
    }
}
