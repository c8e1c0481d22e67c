//! One more mode in addition to a further one: a structure has infinitely many, and where one
//! shows, the next may leave enough to imitate another effect, a lag above all.

use super::extra_mode::{highest_searched, mode_bounds, mode_of_ring, ring_near};
use crate::diagnose::comparison::hypothesis::Hypothesis;
use crate::diagnose::data::side::Split;
use crate::diagnose::discrepancy::impact_ring::{ImpactExcitations, MODE_NUMBERS, PhaseLockedRing};
use crate::diagnose::discrepancy::residual_spectrum;
use crate::diagnose::discrepancy::residual_spectrum::SpectralPeak;
use crate::diagnose::findings::Evidence;
use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::thresholds::{
    KNOWN_MODE_FREQUENCY_RATIO, MODE_ALIAS_DECIDED_GAIN, MODE_ALIAS_MIN_SHARE,
    SAME_MODE_FREQUENCY_SHARE, SECOND_MODE_PEAK_MIN_SIGNIFICANCE,
};
use crate::model::effects::ActiveEffect;
use crate::sim::error::SimError;

/// Most frequencies that are tried for a second mode: each needs a fit.
pub(crate) const MAX_SECOND_MODE_STARTS: usize = 2;

/// Frequency ratio of neighbouring high bending modes.
pub(crate) const NEXT_MODE_RATIO: f64 = 2.0;

/// How far above the highest known mode of the device a second further mode is searched for, as a
/// factor; in any case as far as the samples show.
const SECOND_FREQUENCY_REACH: f64 = 15.6;

/// Initial shape of a second mode relative to that of the known one: enough for a direction.
pub(crate) const INITIAL_SHAPE_SHARE: f64 = 0.01;

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
    let spec = known.start.spec;
    if spec.facts.modes.is_none() {
        return Ok(None);
    }
    let excitations = ImpactExcitations::new(side, fitted)?;
    let mode = |ring: PhaseLockedRing| (ring.gain, mode_of_ring(&ring, &fitted.model));
    let peak = residual_spectrum::strongest_peak(fitted)?
        .filter(|r| r.significance > SECOND_MODE_PEAK_MIN_SIGNIFICANCE);
    let rate = residual_spectrum::slowest_rate(fitted).unwrap_or(f64::INFINITY);
    let quickest = highest_searched(&fitted.model, rate, SECOND_FREQUENCY_REACH);
    let signs = SecondModeSigns {
        rate,
        band: (excitations.band().lowest, quickest),
        peak,
        outstanding: excitations.strongest(quickest).map(mode),
        near: &|frequency| ring_near(&excitations, frequency).map(mode),
    };
    Ok(add_second_mode(known, &signs))
}

/// A second mode as evidence, if there is one.
pub fn second_mode_evidence(effect: &ActiveEffect) -> Option<Evidence> {
    let frequency = second_mode_frequency(effect)?;
    Some(Evidence::SecondMode { frequency })
}

/// Frequency of one more mode \[Hz\].
pub(crate) fn second_mode_frequency(effect: &ActiveEffect) -> Option<f64> {
    let layout = effect.spec.facts.modes?;
    let second = layout.per_mode + layout.frequency;
    effect.bears(second).then(|| effect.values[second])
}

/// Gain of a ring in phase with its excitation, and the parameters of its mode.
pub(crate) type RingMode = (f64, [f64; MODE_NUMBERS]);

/// Signs of one more mode.
pub(crate) struct SecondModeSigns<'a> {
    /// Sampling rate of the recordings \[Hz\].
    rate: f64,
    /// Lowest and highest frequency that are searched \[Hz\].
    band: (f64, f64),
    peak: Option<SpectralPeak>,
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
    let layout = spec.facts.modes?;
    // A mode begins with its frequency and damping ratio.
    let second = layout.per_mode + layout.frequency;
    let own = &known.start.values;
    let (f, (lowest, quickest)) = (own[layout.frequency], signs.band);
    // From the proof mass alone the cantilever's shape is unknown.
    let shapes = &own[layout.first_shape..layout.first_shape + 2];
    let size = shapes.iter().fold(0.0f64, |size, s| size.max(s.abs()));
    let read = |peak: &SpectralPeak| {
        let (p, c) = peak.shape;
        let all = std::iter::once(peak.frequency).chain(peak.aliases());
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
    let mut places: Vec<RingMode> = signs.peak.as_ref().map_or(Vec::new(), read);
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
        start.values[layout.per_mode..].copy_from_slice(&own);
        let mut bounds = known.bounds.clone();
        let limits = (signs.rate, lowest);
        bounds.extend(mode_bounds(spec, [second, second + 1], own[0], limits));
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
    use super::super::second_mode::*;
    use crate::diagnose::discrepancy::residual_spectrum::SpectralPeak;
    use crate::diagnose::hypotheses::extra_mode::mode_bounds;
    use crate::model::effects::extra_mode::{EFFECT, OF_ONE};
    use crate::model::effects::find;

    const SAMPLING_RATE: f64 = 50e3;
    const BAND: (f64, f64) = (1.5e3, 100e3);

    fn known(f: f64) -> Hypothesis {
        let start = ActiveEffect {
            spec: &EFFECT,
            values: vec![f, 0.02, -6e4, 3e3, 5e4, f, 0.01, 0.0, 0.0, 0.0],
        };
        Hypothesis {
            bounds: mode_bounds(start.spec, [0, 1], f, (SAMPLING_RATE, BAND.0)).to_vec(),
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

    fn peak(frequency: f64) -> SpectralPeak {
        SpectralPeak {
            frequency,
            rate: SAMPLING_RATE,
            shape: (0.1, 0.995),
            significance: 10.0,
            gain: 100.0,
        }
    }

    /// A mode at `f` \[Hz\] with one more, of which only a peak is a sign.
    fn read(f: f64, there: f64) -> Option<Hypothesis> {
        add_second_mode(known(f), &signs(Some(peak(there)), None, &|_| None))
    }

    fn signs(
        peak: Option<SpectralPeak>,
        outstanding: Option<RingMode>,
        near: &dyn Fn(f64) -> Option<RingMode>,
    ) -> SecondModeSigns<'_> {
        SecondModeSigns {
            rate: SAMPLING_RATE,
            band: BAND,
            peak,
            outstanding,
            near,
        }
    }

    #[test]
    fn a_neighbouring_mode_is_tried_first() {
        let both = read(19.2e3, 10.8e3).unwrap();
        let f2 = |effect: &ActiveEffect| effect.values[OF_ONE];
        assert_eq!(f2(&both.start), 39.2e3);
        assert_eq!(both.alternative_starts.len(), MAX_SECOND_MODE_STARTS - 1);
        assert_eq!(f2(&both.alternative_starts[0].0), 60.8e3);
        // Each has bounds of its own, and so has the known mode.
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
    fn from_the_proof_mass_alone_a_second_mode_is_driven() {
        let mut known = known(19.2e3);
        known.start.values[2] = 0.0;
        let shape = (1.0, 0.0);
        let seen = SpectralPeak {
            shape,
            ..peak(10.8e3)
        };
        let both = add_second_mode(known, &signs(Some(seen), None, &|_| None));
        let both = both.unwrap().start;
        assert!(second_mode_frequency(&both).is_some());
        assert!(both.values[9] != 0.0, "nothing drives it");
    }

    #[test]
    fn a_peak_next_to_the_known_mode_is_tried_at_its_aliases() {
        let both = read(10.5e3, 10.8e3).unwrap();
        assert_eq!(both.start.values[OF_ONE], 39.2e3);
    }

    #[test]
    fn the_phase_at_excitation_identifies_the_alias() {
        let at = |gain: f64, place: f64| (gain, [place, 0.008, -3e4, 2e3, -7e4]);
        let with = |far: f64, near: f64| {
            let in_phase = |f: f64| match f {
                60.8e3 => Some(at(far, f)),
                39.2e3 => Some(at(near, f)),
                _ => None,
            };
            let found = signs(Some(peak(10.8e3)), None, &in_phase);
            add_second_mode(known(19.2e3), &found).unwrap()
        };
        let far = with(500.0, 100.0);
        assert_eq!(far.start.values[OF_ONE..], at(0.0, 60.8e3).1);
        assert!(far.alternative_starts.is_empty());
        // If both are possible, the larger gain comes first; without a decisive gain, the neighbour.
        let both = with(500.0, 300.0);
        assert_eq!(both.start.values[OF_ONE], 60.8e3);
        assert_eq!(both.alternative_starts[0].0.values[OF_ONE], 39.2e3);
        assert_eq!(with(40.0, 20.0).start.values[OF_ONE], 39.2e3);
    }

    #[test]
    fn an_outstanding_ring_needs_no_peak() {
        let out = (160.0, [38.5e3, 0.008, -6e4, 3e3, -7e4]);
        let alone = signs(None, Some(out), &|_| None);
        let alone = add_second_mode(known(19.2e3), &alone).unwrap();
        assert_eq!(alone.start.values[OF_ONE..], out.1);
        assert!(alone.alternative_starts.is_empty());
        // It may belong to the peak.
        let in_phase = |f: f64| (f == 39.2e3).then_some((150.0, [38.6e3, 0.008, -6e4, 3e3, -7e4]));
        let both = signs(Some(peak(10.8e3)), Some(out), &in_phase);
        assert!(
            add_second_mode(known(19.2e3), &both)
                .unwrap()
                .alternative_starts
                .is_empty()
        );
        // The known mode does not count as another.
        let same = signs(None, Some((160.0, [19.0e3; OF_ONE])), &|_| None);
        assert!(add_second_mode(known(19.2e3), &same).is_none());
        assert!(add_second_mode(known(19.2e3), &signs(None, None, &|_| None)).is_none());
    }

    #[test]
    fn a_second_mode_is_reported_only_if_present() {
        let one = known(19.2e3).start;
        assert_eq!(second_mode_evidence(&one), None);
        let two = read(19.2e3, 10.8e3).unwrap().start;
        let frequency = 39.2e3;
        assert_eq!(
            second_mode_evidence(&two),
            Some(Evidence::SecondMode { frequency })
        );
        let other = ActiveEffect::new(find("hysteresis_memory").unwrap());
        assert!(second_mode_evidence(&other).is_none());
    }
}
