//! Hypotheses of further modes: from a peak in the spectrum of the residuals, or from a ring in
//! them that is in phase with its excitation. One more mode may be added to a further one, because
//! a structure has infinitely many.

use crate::diagnose::comparison::hypothesis::Hypothesis;
use crate::diagnose::comparison::trial::ModelState;
use crate::diagnose::data::side::Split;
use crate::diagnose::discrepancy::impact_ring::{ImpactExcitations, PhaseLockedRing};
use crate::diagnose::discrepancy::residual_spectrum;
use crate::diagnose::discrepancy::residual_spectrum::{MIN_FREQUENCY, SpectralPeak};
use crate::diagnose::options::DiagnoseError;
use crate::diagnose::shooting::fitted::{Bound, Fitted};
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::thresholds::{
    KNOWN_MODE_FREQUENCY_RATIO, MODE_ALIAS_DECIDED_GAIN, MODE_ALIAS_MIN_SHARE, MODE_RING_MIN_GAIN,
    REFIT_MIN_SCORE, SAME_MODE_FREQUENCY_SHARE, SELF_RINGING_MIN_SIGNIFICANCE,
};
use crate::model::Model;
use crate::model::effects::extra_mode::{EFFECT, OF_ONE};
use crate::model::effects::{ActiveEffect, EffectSpec, own_ids};
use crate::sim::SimError;

/// Motion of a further mode at the mass, as a share of that of all modes.
const HIDDEN_MODE_SHARE: f64 = 0.06;

/// Bounds of a mode's frequency, relative to where it was found.
const FREQUENCY_BOUND_FACTORS: (f64, f64) = (0.9, 1.1);

/// Most frequencies that are tried for a second mode: each needs a fit.
const MAX_SECOND_MODE_STARTS: usize = 2;
/// Frequency ratio of neighbouring high bending modes.
const NEXT_MODE_RATIO: f64 = 2.0;
/// Initial shape of a second mode relative to that of the known one: enough for a direction.
const INITIAL_SHAPE_SHARE: f64 = 0.01;

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
    let hump = residual_spectrum::strongest_peak(&state.train)?
        .filter(|ring| ring.significance > crate::diagnose::thresholds::PEAK_MIN_SIGNIFICANCE);
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
    let near = |f: f64| mode_bounds(spec, [0, 1], f, rate).to_vec();
    let in_step = |ring: &PhaseLockedRing| (with(mode_of_ring(ring, model)), near(ring.frequency));
    // By aliasing, the true frequency may be higher.
    let (_, quickest) = spec.parameters[0].range;
    let mut places = Vec::new();
    if let Some(hump) = &hump {
        let (p, c) = hump.shape;
        let size = usual * (HIDDEN_MODE_SHARE / p.abs().max(HIDDEN_MODE_SHARE));
        let all = std::iter::once(hump.frequency).chain(hump.aliases());
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
    let gain = hump
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
        predicted_gain: gain.max(2.0 * REFIT_MIN_SCORE),
        look_elsewhere: false,
        sequential_time: false,
        estimated_on_held_out: None,
    }))
}

/// The ring near `frequency` \[Hz\] that is in phase with `excitations`, if there is one.
pub fn ring_near(excitations: &ImpactExcitations, frequency: f64) -> Option<PhaseLockedRing> {
    let ring = excitations.best_near(frequency, residual_spectrum::FREQUENCY_SPACING);
    ring.filter(|ring| ring.gain > MODE_RING_MIN_GAIN)
}

/// Frequency, damping ratio and shapes of a further mode of `model` that rings like `ring`.
pub fn mode_of_ring(ring: &PhaseLockedRing, model: &Model) -> [f64; 5] {
    ring.mode(
        model,
        HIDDEN_MODE_SHARE * model.structure().mobility().sqrt(),
    )
}

/// Bounds of the frequency and damping ratio, the parameters `which` of `spec`, of a mode near `f`
/// \[Hz\] in recordings sampled at `rate` \[Hz\]. A mode that is free to become slow and
/// overdamped could imitate any force, and so could one that appears slow by aliasing.
pub fn mode_bounds(spec: &EffectSpec, which: [usize; 2], f: f64, rate: f64) -> [Bound; 2] {
    let (mut low, mut high) = (FREQUENCY_BOUND_FACTORS.0 * f, FREQUENCY_BOUND_FACTORS.1 * f);
    let turns = (f / rate).round() * rate;
    if turns > 0.0 {
        let slow = FREQUENCY_BOUND_FACTORS.0 * MIN_FREQUENCY;
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

/// The hypothesis `known`, a fitted further mode, with one more mode for which `fitted`, a fit to
/// the recordings of `side`, leaves a peak or a ring in phase with its excitation; `None` if it
/// leaves none.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub fn with_second_mode(
    side: &Split,
    known: Hypothesis,
    fitted: &Fitted,
) -> Result<Option<Hypothesis>, SimError> {
    let excitations = ImpactExcitations::new(side, fitted)?;
    let mode = |ring: PhaseLockedRing| (ring.gain, mode_of_ring(&ring, &fitted.model));
    let hump = residual_spectrum::strongest_peak(fitted)?
        .filter(|r| r.significance > SELF_RINGING_MIN_SIGNIFICANCE);
    let (_, quickest) = EFFECT.parameters[OF_ONE].range;
    let signs = SecondModeSigns {
        rate: residual_spectrum::slowest_rate(fitted).unwrap_or(f64::INFINITY),
        hump,
        outstanding: excitations.strongest(quickest).map(mode),
        near: &|frequency| ring_near(&excitations, frequency).map(mode),
    };
    Ok(add_second_mode(known, &signs))
}

/// A remark on one more mode, if there is one.
pub fn second_mode_remark(effect: &ActiveEffect) -> Option<String> {
    let f = second_mode_frequency(effect)?;
    Some(format!(
        "one more mode goes with it, at {:.1} kHz; its coupling to the drive is hardly told apart from its shapes, and is kept as it was first found",
        1e-3 * f
    ))
}

/// Frequency of one more mode \[Hz\].
pub(crate) fn second_mode_frequency(effect: &ActiveEffect) -> Option<f64> {
    (*effect.spec == EFFECT && effect.bears(OF_ONE)).then(|| effect.values[OF_ONE])
}

/// Gain of a ring in phase with its excitation, and the parameters of its mode.
pub(crate) type RingMode = (f64, [f64; OF_ONE]);

/// Signs of one more mode.
pub(crate) struct SecondModeSigns<'a> {
    /// Sampling rate of the recordings \[Hz\].
    rate: f64,
    hump: Option<SpectralPeak>,
    /// The ring in phase that stands out.
    outstanding: Option<RingMode>,
    /// The ring near a frequency \[Hz\].
    near: &'a dyn Fn(f64) -> Option<RingMode>,
}

/// `known` with one more mode according to `signs`.
pub(crate) fn add_second_mode(
    known: Hypothesis,
    signs: &SecondModeSigns<'_>,
) -> Option<Hypothesis> {
    let spec = known.start.spec;
    let (f, (_, quickest)) = (known.start.values[0], spec.parameters[OF_ONE].range);
    // From the proof mass alone the cantilever's shape is unknown.
    let size = known.start.values[2].abs().max(known.start.values[3].abs());
    let read = |hump: &SpectralPeak| {
        let (p, c) = hump.shape;
        let all = std::iter::once(hump.frequency).chain(hump.aliases());
        let one = move |place| {
            // Apart from impacts and film, the readings show its shape times its
            // coupling to the drive.
            let read = [
                place,
                0.02,
                INITIAL_SHAPE_SHARE * size * c,
                INITIAL_SHAPE_SHARE * size * p,
                size,
            ];
            (signs.near)(place).unwrap_or((0.0, read))
        };
        all.map(one).collect()
    };
    let mut places: Vec<RingMode> = signs.hump.as_ref().map_or(Vec::new(), read);
    places.extend(signs.outstanding);
    let apart = |other: f64| {
        other > KNOWN_MODE_FREQUENCY_RATIO * f || KNOWN_MODE_FREQUENCY_RATIO * other < f
    };
    places.retain(|place| apart(place.1[0]) && place.1[0] < quickest);
    // Of several aliases, a neighbouring mode is the most likely.
    let unlikely = |own: &RingMode| (own.1[0] / (NEXT_MODE_RATIO * f)).ln().abs();
    places.sort_by(|a, b| unlikely(a).total_cmp(&unlikely(b)));
    // The phase at excitation distinguishes them.
    let best = places.iter().map(|p| p.0).fold(0.0, f64::max);
    if best > MODE_ALIAS_DECIDED_GAIN {
        places.retain(|place| place.0 > MODE_ALIAS_MIN_SHARE * best);
        places.sort_by(|a, b| b.0.total_cmp(&a.0));
    }
    // The outstanding ring may belong to the same peak.
    places.dedup_by(|a, b| (a.1[0] / b.1[0]).ln().abs() < SAME_MODE_FREQUENCY_SHARE);
    let at = |(_, own): RingMode| {
        let mut start = known.start.clone();
        start.values[OF_ONE..].copy_from_slice(&own);
        let mut bounds = known.bounds.clone();
        bounds.extend(mode_bounds(spec, [5, 6], own[0], signs.rate));
        (start, bounds)
    };
    let mut all = places.into_iter().take(MAX_SECOND_MODE_STARTS).map(at);
    let (start, bounds) = all.next()?;
    Some(Hypothesis {
        start,
        bounds,
        alternative_starts: all.collect(),
        ..known
    })
}

#[cfg(test)]
mod tests {
    use super::super::extra_mode::*;
    use crate::model::effects::extra_mode::EFFECT;

    #[test]
    fn a_mode_does_not_move_to_where_it_is_read_as_slow() {
        let frequencies = |f: f64, rate: f64, (low, high): (f64, f64)| {
            let found = mode_bounds(&EFFECT, [0, 1], f, rate)[0].1;
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

#[cfg(test)]
mod neighbour_tests {
    use super::*;
    use crate::diagnose::discrepancy::residual_spectrum::SpectralPeak;
    use crate::model::effects::find;

    const RATE: f64 = 50e3;

    fn known(f: f64) -> Hypothesis {
        let start = ActiveEffect {
            spec: &EFFECT,
            values: vec![f, 0.02, -6e4, 3e3, 5e4, f, 0.01, 0.0, 0.0, 0.0],
        };
        Hypothesis {
            bounds: mode_bounds(start.spec, [0, 1], f, RATE).to_vec(),
            free: vec!["extra_mode.f".to_owned()],
            start,
            alternative_starts: Vec::new(),
            cold_start: None,
            shape: Vec::new(),
            predicted_gain: 0.0,
            look_elsewhere: false,
            sequential_time: false,
            estimated_on_held_out: None,
        }
    }

    fn hump(frequency: f64) -> SpectralPeak {
        SpectralPeak {
            frequency,
            rate: RATE,
            shape: (0.1, 0.995),
            significance: 10.0,
            gain: 100.0,
        }
    }

    /// A mode at `f` \[Hz\] with one more, of which a hump alone tells.
    fn read(f: f64, there: f64) -> Option<Hypothesis> {
        add_second_mode(known(f), &signs(Some(hump(there)), None, &|_| None))
    }

    fn signs(
        hump: Option<SpectralPeak>,
        outstanding: Option<RingMode>,
        near: &dyn Fn(f64) -> Option<RingMode>,
    ) -> SecondModeSigns<'_> {
        SecondModeSigns {
            rate: RATE,
            hump,
            outstanding,
            near,
        }
    }

    #[test]
    fn a_neighbour_is_looked_for_first() {
        let both = read(19.2e3, 10.8e3).unwrap();
        let f2 = |effect: &ActiveEffect| effect.values[OF_ONE];
        assert_eq!(f2(&both.start), 39.2e3);
        assert_eq!(both.alternative_starts.len(), MAX_SECOND_MODE_STARTS - 1);
        assert_eq!(f2(&both.alternative_starts[0].0), 60.8e3);
        // Each keeps to its place, and the mode that is known to its own.
        for bounds in [&both.bounds, &both.alternative_starts[0].1] {
            assert_eq!(bounds.len(), 4);
            assert_eq!(bounds[0].1, (0.9 * 19.2e3, 1.1 * 19.2e3));
        }
        assert_eq!(both.bounds[2].0, "extra_mode.f2");
        assert_eq!(
            both.start.values[..OF_ONE],
            known(19.2e3).start.values[..OF_ONE]
        );
    }

    #[test]
    fn from_the_proof_mass_alone_it_has_a_shape_there() {
        let mut known = known(19.2e3);
        known.start.values[2] = 0.0;
        let shape = (1.0, 0.0);
        let seen = SpectralPeak {
            shape,
            ..hump(10.8e3)
        };
        let both = add_second_mode(known, &signs(Some(seen), None, &|_| None));
        let both = both.unwrap().start;
        assert!(second_mode_frequency(&both).is_some());
        assert!(both.values[9] != 0.0, "nothing drives it");
    }

    #[test]
    fn what_stands_beside_the_known_mode_is_looked_for_at_its_mirrors() {
        let both = read(10.5e3, 10.8e3).unwrap();
        assert_eq!(both.start.values[OF_ONE], 39.2e3);
    }

    #[test]
    fn the_phase_in_which_it_begins_tells_where_it_is() {
        let at = |gain: f64, place: f64| (gain, [place, 0.008, -3e4, 2e3, -7e4]);
        let with = |far: f64, near: f64| {
            let in_phase = |f: f64| match f {
                60.8e3 => Some(at(far, f)),
                39.2e3 => Some(at(near, f)),
                _ => None,
            };
            let found = signs(Some(hump(10.8e3)), None, &in_phase);
            add_second_mode(known(19.2e3), &found).unwrap()
        };
        let far = with(500.0, 100.0);
        assert_eq!(far.start.values[OF_ONE..], at(0.0, 60.8e3).1);
        assert!(far.alternative_starts.is_empty());
        // Where both may be, what brings more comes first; where little tells, the neighbour.
        let both = with(500.0, 300.0);
        assert_eq!(both.start.values[OF_ONE], 60.8e3);
        assert_eq!(both.alternative_starts[0].0.values[OF_ONE], 39.2e3);
        assert_eq!(with(40.0, 20.0).start.values[OF_ONE], 39.2e3);
    }

    #[test]
    fn one_that_stands_out_needs_no_hump() {
        let out = (160.0, [38.5e3, 0.008, -6e4, 3e3, -7e4]);
        let alone = signs(None, Some(out), &|_| None);
        let alone = add_second_mode(known(19.2e3), &alone).unwrap();
        assert_eq!(alone.start.values[OF_ONE..], out.1);
        assert!(alone.alternative_starts.is_empty());
        // It may be the hump's.
        let in_phase = |f: f64| (f == 39.2e3).then_some((150.0, [38.6e3, 0.008, -6e4, 3e3, -7e4]));
        let both = signs(Some(hump(10.8e3)), Some(out), &in_phase);
        assert!(
            add_second_mode(known(19.2e3), &both)
                .unwrap()
                .alternative_starts
                .is_empty()
        );
        // The mode that is known is none beside it.
        let same = signs(None, Some((160.0, [19.0e3; OF_ONE])), &|_| None);
        assert!(add_second_mode(known(19.2e3), &same).is_none());
        assert!(add_second_mode(known(19.2e3), &signs(None, None, &|_| None)).is_none());
    }

    #[test]
    fn what_is_not_there_is_not_told() {
        let one = known(19.2e3).start;
        assert_eq!(second_mode_remark(&one), None);
        let two = read(19.2e3, 10.8e3).unwrap().start;
        assert!(second_mode_remark(&two).unwrap().contains("39.2 kHz"));
        let other = ActiveEffect::new(find("hysteresis_memory").unwrap());
        assert!(second_mode_remark(&other).is_none());
    }
}
