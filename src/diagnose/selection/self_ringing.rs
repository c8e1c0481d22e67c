//! One more mode beside a further one: a structure has them without end, and where one shows
//! the next may leave enough to look like something else, a lag above all. And what is none,
//! for it rings by itself.

use super::evaluate::with_freedoms;
use super::forward::{Stand, Trial, Weighed};
use crate::diagnose::comparison::significance::{HELD_GAIN, TRAIN_GAIN};
use crate::diagnose::data::side::Side;
use crate::diagnose::discrepancy::impact_ring::{Blows, Struck};
use crate::diagnose::discrepancy::residual_spectrum;
use crate::diagnose::discrepancy::residual_spectrum::{BESIDE, Ring};
use crate::diagnose::hypotheses::extra_mode::{
    ALIKE, DECISIVE, TOLD, near_mode, struck_near, told_by,
};
use crate::diagnose::hypotheses::propose::Hypothesis;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError, simulated};
use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::shooting::workspace::Bench;
use crate::model::effects::ActiveEffect;
use crate::model::effects::extra_mode::{EFFECT, OF_ONE};
use crate::sim::error::SimError;

/// Significance of a hump from which it is worth a look: whether it is a mode, its fit tells.
const NOTICED: f64 = 3.0;
/// Most places that are looked at: each takes a fit.
const MOST: usize = 2;
/// Frequencies of neighbouring bending modes, quick ones, one over the other.
const NEXT: f64 = 2.0;
/// The shapes of a mode come after its frequency and damping.
const SHAPES: usize = 2;
/// Factor of the shapes of a mode that nothing moves: what it is moved by goes as its square.
const STILL: f64 = 1e-3;
/// Falls of chi2 by a ring of a known frequency that begins with impacts and jumps of the drive, on
/// both sides, from which it is moved by them.
const IN_STEP: (f64, f64) = (20.0, 12.0);
/// Least share of what a mode brings that such a ring must bring: of something else that rings,
/// a smaller part is in step by chance.
const LEAST_SHARE: f64 = 0.05;
/// Least share of what a mode brings that must go if nothing moves it: all else it brings by how
/// it begins in each stretch, which is free.
const LEAST_MOTION: f64 = 0.02;
/// How far off that frequency may be, as a share.
const NEAR: f64 = 0.03;
/// Share of what a mode that rings by itself brings from which a vibration of the base is as good,
/// which has no beginnings of its own.
const STEADY: f64 = 0.6;
/// Steps of the fit with such a mode.
const STEPS: usize = 8;
/// Its shape at first, as a share of that of the mode that is known: enough for a direction.
const FIRST: f64 = 0.01;

/// The hypothesis `known`, a further mode as fitted, with one more of which `fitted`, of the
/// recordings of `side`, leaves a hump, or that rings in step with what sets it off; `None` if it
/// leaves none.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub fn one_more(
    side: &Side,
    known: Hypothesis,
    fitted: &Fitted,
) -> Result<Option<Hypothesis>, SimError> {
    let blows = Blows::new(side, fitted)?;
    let told = |ring: Struck| (ring.gain, told_by(&ring, &fitted.model));
    let hump = residual_spectrum::find(fitted)?.filter(|r| r.significance > NOTICED);
    let (_, quickest) = EFFECT.parameters[OF_ONE].range;
    let signs = Signs {
        rate: residual_spectrum::slowest_rate(fitted).unwrap_or(f64::INFINITY),
        hump,
        outstanding: blows.outstanding(quickest).map(told),
        near: &|frequency| struck_near(&blows, frequency).map(told),
    };
    Ok(beside(known, &signs))
}

/// A line about one more mode beside a further one, if there is one.
pub fn beside_it(effect: &ActiveEffect) -> Option<String> {
    let f = frequency_beside(effect)?;
    Some(format!(
        "one more mode goes with it, at {:.1} kHz; its coupling to the drive is hardly told apart from its shapes, and is kept as it was first found",
        1e-3 * f
    ))
}

/// Frequency of one more mode \[Hz\].
fn frequency_beside(effect: &ActiveEffect) -> Option<f64> {
    (*effect.spec == EFFECT && effect.bears(OF_ONE)).then(|| effect.values[OF_ONE])
}

/// Frequency of a further mode that nothing moves \[Hz\], if `trial`, a fit with one more effect
/// than `stand` has, is of one. What drives and strikes a device moves its modes; what rings by
/// itself begins anew in each stretch, and passes for a mode whose motion at its start is free.
/// From the proof mass alone that is hardly told, and not asked.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn rings_by_itself(
    bench: &Bench,
    stand: &Stand,
    trial: &Trial,
    control: &DiagnoseControl<'_>,
) -> Result<Option<f64>, DiagnoseError> {
    let fitted = &trial.train;
    let data = &fitted.problem.data;
    let alone = data.iter().any(|d| d.recording.cantilever.is_none());
    if alone || *trial.hypothesis.start.spec != EFFECT || control.cancelled() {
        return Ok(None);
    }
    let effect = fitted.model.effects.iter().find(|e| *e.spec == EFFECT);
    let Some(frequency) = effect.map(|e| e.values[0]) else {
        return Ok(None);
    };
    if in_step(bench, stand, trial, frequency)? {
        return Ok(None);
    }
    let mut still = fitted.model.clone();
    let mut shapes = Vec::new();
    for effect in still.effects.iter_mut().filter(|e| *e.spec == EFFECT) {
        let all = effect.spec.parameters.iter().zip(&mut effect.values);
        for (i, (parameter, value)) in all.enumerate() {
            if i % OF_ONE >= SHAPES {
                *value *= STILL;
                shapes.push(format!("{}.{}", EFFECT.id, parameter.id));
            }
        }
    }
    let (mut free, bounds) = with_freedoms(stand, &trial.hypothesis);
    free.retain(|id| !shapes.contains(id));
    let sketch = bench.sketch(&still, &free, &bounds, fitted, control);
    // What rings by itself goes on as it did: where it does not, all stretches need not be asked.
    if let Ok(sketch) = &sketch
        && sketch.is_lost_beside(fitted)
    {
        return Ok(None);
    }
    let unmoved = sketch.and_then(|sketch| bench.complete(sketch, STEPS, control));
    // What cannot be simulated says nothing against the mode.
    let Some(unmoved) = simulated(unmoved)? else {
        return Ok(None);
    };
    let by_motion = unmoved.cost - fitted.cost;
    log::debug!("that the modes are moved brings {by_motion:.1}");
    let least = TRAIN_GAIN.max(LEAST_MOTION * trial.gain);
    Ok((by_motion < least).then_some(frequency))
}

/// The vibration of the base among what was `weighed`, if chance does not do as well.
pub fn vibration(weighed: &[Weighed]) -> Option<Trial> {
    let own = weighed.iter().find(|w| w.spec.id == "base_vibration")?;
    let held = |t: &Trial| t.held_out.is_none() || t.held_gain > HELD_GAIN;
    let trial = own.trial.as_ref();
    trial.filter(|t| held(t) && !t.by_chance()).cloned()
}

/// Whether the `vibration` of the base does as well as `ringing`, a mode that rings by itself.
pub fn as_well(vibration: &Trial, ringing: &Trial) -> bool {
    vibration.worth() > STEADY * ringing.worth()
}

/// Whether a ring at `frequency` \[Hz\] that begins with impacts and jumps of the drive is in what
/// `stand` leaves, on both sides, and is not too small a part of what `trial` brings beyond it.
fn in_step(bench: &Bench, stand: &Stand, trial: &Trial, frequency: f64) -> Result<bool, SimError> {
    let near = |side: &Side, fitted: &Fitted| -> Result<f64, SimError> {
        let ring = Blows::new(side, fitted)?.near(frequency, NEAR * frequency);
        Ok(ring.map_or(0.0, |ring| ring.gain))
    };
    let train = near(&bench.train, &stand.train)?;
    let held_out = match (&bench.held_out, &stand.held_out) {
        (Some(side), Some(fitted)) => Some(near(side, fitted)?),
        _ => None,
    };
    log::debug!(
        "in step with blows {train:.1} of {:.1}, kept out {held_out:?} of {:.1}",
        trial.gain,
        trial.held_gain
    );
    Ok(train > IN_STEP.0.max(LEAST_SHARE * trial.gain)
        && held_out.is_none_or(|gain| gain > IN_STEP.1.max(LEAST_SHARE * trial.held_gain)))
}

/// What a ring in step with what sets it off brings, and the mode it is of.
type Told = (f64, [f64; OF_ONE]);

/// Signs of one more mode.
struct Signs<'a> {
    /// At which the recordings are sampled \[Hz\].
    rate: f64,
    hump: Option<Ring>,
    /// The ring in step that stands out.
    outstanding: Option<Told>,
    /// The one near a frequency \[Hz\].
    near: &'a dyn Fn(f64) -> Option<Told>,
}

/// `known` with one more mode, of which there are those signs.
fn beside(known: Hypothesis, signs: &Signs<'_>) -> Option<Hypothesis> {
    let spec = known.start.spec;
    let (f, (_, quickest)) = (known.start.values[0], spec.parameters[OF_ONE].range);
    // From the proof mass alone nothing is seen of the cantilever.
    let size = known.start.values[2].abs().max(known.start.values[3].abs());
    let read = |hump: &Ring| {
        let (p, c) = hump.shape;
        let all = std::iter::once(hump.frequency).chain(hump.mirrors());
        let one = move |place| {
            // Its shape goes into the readings times what it is driven by, impacts and film apart.
            let read = [place, 0.02, FIRST * size * c, FIRST * size * p, size];
            (signs.near)(place).unwrap_or((0.0, read))
        };
        all.map(one).collect()
    };
    let mut places: Vec<Told> = signs.hump.as_ref().map_or(Vec::new(), read);
    places.extend(signs.outstanding);
    let apart = |other: f64| other > BESIDE * f || BESIDE * other < f;
    places.retain(|place| apart(place.1[0]) && place.1[0] < quickest);
    // Where one frequency is read as several, modes are most likely neighbours.
    let unlikely = |own: &Told| (own.1[0] / (NEXT * f)).ln().abs();
    places.sort_by(|a, b| unlikely(a).total_cmp(&unlikely(b)));
    // But the phase in which it begins tells them apart.
    let best = places.iter().map(|p| p.0).fold(0.0, f64::max);
    if best > DECISIVE {
        places.retain(|place| place.0 > TOLD * best);
        places.sort_by(|a, b| b.0.total_cmp(&a.0));
    }
    // One that stands out may be the hump's as well.
    places.dedup_by(|a, b| (a.1[0] / b.1[0]).ln().abs() < ALIKE);
    let at = |(_, own): Told| {
        let mut start = known.start.clone();
        start.values[OF_ONE..].copy_from_slice(&own);
        let mut bounds = known.bounds.clone();
        bounds.extend(near_mode(spec, [5, 6], own[0], signs.rate));
        (start, bounds)
    };
    let mut all = places.into_iter().take(MOST).map(at);
    let (start, bounds) = all.next()?;
    Some(Hypothesis {
        start,
        bounds,
        others: all.collect(),
        ..known
    })
}

#[cfg(test)]
mod tests {
    use super::super::self_ringing::*;
    use crate::model::effects::find;

    const RATE: f64 = 50e3;

    fn known(f: f64) -> Hypothesis {
        let start = ActiveEffect {
            spec: &EFFECT,
            values: vec![f, 0.02, -6e4, 3e3, 5e4, f, 0.01, 0.0, 0.0, 0.0],
        };
        Hypothesis {
            bounds: near_mode(start.spec, [0, 1], f, RATE).to_vec(),
            free: vec!["extra_mode.f".to_owned()],
            start,
            others: Vec::new(),
            full: None,
            shape: Vec::new(),
            promise: 0.0,
            searched: false,
            series: false,
            told_by: None,
        }
    }

    fn hump(frequency: f64) -> Ring {
        Ring {
            frequency,
            rate: RATE,
            shape: (0.1, 0.995),
            significance: 10.0,
            gain: 100.0,
        }
    }

    /// A mode at `f` \[Hz\] with one more, of which a hump alone tells.
    fn read(f: f64, there: f64) -> Option<Hypothesis> {
        beside(known(f), &told(Some(hump(there)), None, &|_| None))
    }

    fn told(
        hump: Option<Ring>,
        outstanding: Option<Told>,
        near: &dyn Fn(f64) -> Option<Told>,
    ) -> Signs<'_> {
        Signs {
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
        assert_eq!(both.others.len(), MOST - 1);
        assert_eq!(f2(&both.others[0].0), 60.8e3);
        // Each keeps to its place, and the mode that is known to its own.
        for bounds in [&both.bounds, &both.others[0].1] {
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
        let seen = Ring {
            shape,
            ..hump(10.8e3)
        };
        let both = beside(known, &told(Some(seen), None, &|_| None));
        let both = both.unwrap().start;
        assert!(frequency_beside(&both).is_some());
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
            let struck = |f: f64| match f {
                60.8e3 => Some(at(far, f)),
                39.2e3 => Some(at(near, f)),
                _ => None,
            };
            let signs = told(Some(hump(10.8e3)), None, &struck);
            beside(known(19.2e3), &signs).unwrap()
        };
        let far = with(500.0, 100.0);
        assert_eq!(far.start.values[OF_ONE..], at(0.0, 60.8e3).1);
        assert!(far.others.is_empty());
        // Where both may be, what brings more comes first; where little tells, the neighbour.
        let both = with(500.0, 300.0);
        assert_eq!(both.start.values[OF_ONE], 60.8e3);
        assert_eq!(both.others[0].0.values[OF_ONE], 39.2e3);
        assert_eq!(with(40.0, 20.0).start.values[OF_ONE], 39.2e3);
    }

    #[test]
    fn one_that_stands_out_needs_no_hump() {
        let out = (160.0, [38.5e3, 0.008, -6e4, 3e3, -7e4]);
        let alone = told(None, Some(out), &|_| None);
        let alone = beside(known(19.2e3), &alone).unwrap();
        assert_eq!(alone.start.values[OF_ONE..], out.1);
        assert!(alone.others.is_empty());
        // It may be the hump's.
        let struck = |f: f64| (f == 39.2e3).then_some((150.0, [38.6e3, 0.008, -6e4, 3e3, -7e4]));
        let both = told(Some(hump(10.8e3)), Some(out), &struck);
        assert!(beside(known(19.2e3), &both).unwrap().others.is_empty());
        // The mode that is known is none beside it.
        let same = told(None, Some((160.0, [19.0e3; OF_ONE])), &|_| None);
        assert!(beside(known(19.2e3), &same).is_none());
        assert!(beside(known(19.2e3), &told(None, None, &|_| None)).is_none());
    }

    #[test]
    fn what_is_not_there_is_not_told() {
        let one = known(19.2e3).start;
        assert_eq!(beside_it(&one), None);
        let two = read(19.2e3, 10.8e3).unwrap().start;
        assert!(beside_it(&two).unwrap().contains("39.2 kHz"));
        let other = ActiveEffect::new(find("hysteresis_memory").unwrap());
        assert!(beside_it(&other).is_none());
    }
}
