//! The hypothesis of a further mode: by a hump in the spectrum of what is left, or by a ring in it
//! that is in step with what sets it off.

use super::propose::{Hypothesis, PROMISING};
use crate::diagnose::discrepancy::impact_ring::{Blows, Struck};
use crate::diagnose::discrepancy::residual_spectrum;
use crate::diagnose::discrepancy::residual_spectrum::LOWEST;
use crate::diagnose::options::DiagnoseError;
use crate::diagnose::score_test::forms::own_ids;
use crate::diagnose::selection::forward::Stand;
use crate::diagnose::shooting::workspace::{Bench, Bound};
use crate::model::Model;
use crate::model::effects::{ActiveEffect, EffectSpec};

/// Share of a further mode's motion at the mass, of that of all modes.
const UNNOTICED: f64 = 0.06;
/// Fall of chi2 by a ring that is in step with what sets it off from which it tells the mode.
const IN_STEP: f64 = 15.0;
/// The same from which it tells where it is, if it is read at several frequencies.
pub const DECISIVE: f64 = 60.0;
/// Share of the best one's fall below which another frequency is not where it is.
pub const TOLD: f64 = 0.5;
/// How far the frequency of a mode may move from where it was found, as shares of it.
const NEAR: (f64, f64) = (0.9, 1.1);
/// Frequencies that are apart by less than this share are one.
pub const ALIKE: f64 = 0.03;

/// The hypothesis of a further mode, if there is a sign of one.
///
/// # Errors
/// [`DiagnoseError`] if the model cannot be simulated.
pub fn further(
    bench: &Bench,
    stand: &Stand,
    spec: &'static EffectSpec,
) -> Result<Option<Hypothesis>, DiagnoseError> {
    let model = &stand.train.model;
    let blows = Blows::new(&bench.train, &stand.train)?;
    let hump = residual_spectrum::find(&stand.train)?
        .filter(|ring| ring.significance > residual_spectrum::HUMP);
    // A mass-normalised shape is of the order of the structure's own; but a mode that
    // has gone unnoticed hardly moves the mass.
    let usual = model.structure().mobility().sqrt();
    // One more is looked for where this one has shown up.
    let with = |own: [f64; 5]| ActiveEffect {
        spec,
        values: own
            .into_iter()
            .chain([own[0], 0.01, 0.0, 0.0, 0.0])
            .collect(),
    };
    let rate = residual_spectrum::slowest_rate(&stand.train).unwrap_or(f64::INFINITY);
    let near = |f: f64| near_mode(spec, [0, 1], f, rate).to_vec();
    let in_step = |ring: &Struck| (with(told_by(ring, model)), near(ring.frequency));
    // Between the samples it may have swung further.
    let (_, quickest) = spec.parameters[0].range;
    let mut places = Vec::new();
    if let Some(hump) = &hump {
        let (p, c) = hump.shape;
        let size = usual * (UNNOTICED / p.abs().max(UNNOTICED));
        let all = std::iter::once(hump.frequency).chain(hump.mirrors());
        let place = |f: f64| match struck_near(&blows, f) {
            Some(ring) => (ring.gain, in_step(&ring)),
            None => (0.0, (with([f, 0.01, size * c, size * p, 0.0]), near(f))),
        };
        places.extend(all.filter(|f| *f < quickest).map(place));
    }
    let struck = blows.outstanding(quickest);
    let known = |ring: &Struck| {
        let mut all = places.iter();
        all.any(|(_, (start, _))| (start.values[0] / ring.frequency).ln().abs() < ALIKE)
    };
    if let Some(ring) = struck.as_ref().filter(|ring| !known(ring)) {
        places.push((ring.gain, in_step(ring)));
    }
    places.sort_by(|a, b| b.0.total_cmp(&a.0));
    let best = places.first().map_or(0.0, |place| place.0);
    if best > DECISIVE {
        places.retain(|place| place.0 > TOLD * best);
    }
    let gain = hump
        .map(|h| h.gain)
        .into_iter()
        .chain(struck.map(|s| s.gain));
    let gain = gain.fold(0.0, f64::max);
    let mut places = places.into_iter().map(|place| place.1);
    let Some((start, bounds)) = places.next() else {
        return Ok(None);
    };
    Ok(Some(Hypothesis {
        start,
        others: places.collect(),
        free: own_ids(spec, &[0, 1, 2, 3, 4]),
        full: None,
        shape: own_ids(spec, &[5, 6, 7, 8]),
        bounds,
        promise: gain.max(2.0 * PROMISING),
        searched: false,
        series: false,
        told_by: None,
    }))
}

/// The ring near `frequency` \[Hz\] that is in step with `blows`, if one is.
pub fn struck_near(blows: &Blows, frequency: f64) -> Option<Struck> {
    let ring = blows.near(frequency, residual_spectrum::SPACING);
    ring.filter(|ring| ring.gain > IN_STEP)
}

/// Frequency, damping and shapes of a further mode of `model` that rings like `ring`.
pub fn told_by(ring: &Struck, model: &Model) -> [f64; 5] {
    ring.mode(model, UNNOTICED * model.structure().mobility().sqrt())
}

/// Bounds of a mode near `f` \[Hz\] whose frequency and damping are those parameters of `spec`, of
/// recordings sampled at `rate` \[Hz\]: one that is free to be slow and dead would pass for any
/// other force, and so would one that is read as slow.
pub fn near_mode(spec: &EffectSpec, which: [usize; 2], f: f64, rate: f64) -> [Bound; 2] {
    let (mut low, mut high) = (NEAR.0 * f, NEAR.1 * f);
    let turns = (f / rate).round() * rate;
    if turns > 0.0 {
        let slow = NEAR.0 * LOWEST;
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
    fn a_mode_does_not_move_to_where_it_is_read_as_slow() {
        let frequencies = |f: f64, rate: f64, (low, high): (f64, f64)| {
            let found = near_mode(&EFFECT, [0, 1], f, rate)[0].1;
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
