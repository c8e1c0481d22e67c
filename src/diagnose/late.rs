//! A late reading or a late drive: in flight the two look alike. Where the mass bounces they
//! do not: a lag of the reading rounds the kink of the motion off, one of the drive leaves it.

use super::bench::{Bench, Fitted, Side, taken_over};
use super::events::around_events;
use super::options::DiagnoseError;
use crate::fit::prepare::Prepared;
use crate::fit::robust::Huber;
use crate::fit::segment::{JointKind, Segment};
use crate::fit::solve::{Point, residuals_at, settle};
use crate::fit::timeline::Kind;

/// The two.
const ALIKE: [&str; 2] = ["sensor_lag", "amplifier_lag"];
/// Residuals beyond this many standard deviations count in proportion.
const LOSS: Huber = Huber(4.0);
/// Steps of a stretch from where the other model has it.
const STEPS: usize = 8;
/// Mean square of the residuals from which a stretch is misread.
const POOR: f64 = 1.4;
/// Most events and edges of the drive in a stretch: where more happen, either fit may lose its
/// way among them.
const MANY: usize = 3;
/// No stretch counts for more than this.
const CAP: f64 = 30.0;
/// Nor does one tell anything by less than this.
const TELLING: f64 = 8.0;
/// Fall of all together from which they tell.
const LEAST: f64 = 40.0;
/// Fewest that must: one or two may have been misread.
const SOME: usize = 3;
/// Share of those telling that may tell the contrary.
const AGAINST: f64 = 0.2;

/// Whether `a` and `b` are the two that look alike in flight.
pub fn looks_like(a: &str, b: &str) -> bool {
    twin(a) == Some(b)
}

/// The one of the two that `id` is not, if it is one of them.
pub fn twin(id: &str) -> Option<&'static str> {
    let [a, b] = ALIKE;
    match id {
        _ if id == a => Some(b),
        _ if id == b => Some(a),
        _ => None,
    }
}

/// Which of two fits the stretches around bounces tell for, and by how much less they cost
/// with it: above 0 it is `b`, below `a`, each a fit to the recordings fitted and that to those
/// kept out. `None` where they do not tell, or not with one voice.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn told(
    bench: &Bench,
    a: (&Fitted, Option<&Fitted>),
    b: (&Fitted, Option<&Fitted>),
) -> Result<Option<f64>, DiagnoseError> {
    let mut falls = of_side(bench, &bench.train, a.0, b.0)?;
    if let (Some(side), Some(a), Some(b)) = (&bench.held_out, a.1, b.1) {
        falls.extend(of_side(bench, side, a, b)?);
    }
    log::debug!("around bounces: {falls:.0?}");
    Ok(verdict(&falls))
}

/// What the falls of single stretches say together.
fn verdict(falls: &[f64]) -> Option<f64> {
    let sum: f64 = falls.iter().map(|fall| fall.clamp(-CAP, CAP)).sum();
    let telling = falls.iter().filter(|fall| fall.abs() > TELLING);
    let against = telling.clone().filter(|fall| **fall * sum < 0.0).count();
    let one_voice = against as f64 <= AGAINST * telling.clone().count() as f64;
    let some = telling.count() >= SOME;
    (sum.abs() > LEAST && some && one_voice).then_some(sum)
}

/// By how much less each stretch around bounces costs with `b` than with `a`, where one of
/// them comes near it.
fn of_side(bench: &Bench, side: &Side, a: &Fitted, b: &Fitted) -> Result<Vec<f64>, DiagnoseError> {
    let (a, b) = (
        around_events(bench, side, a)?,
        around_events(bench, side, b)?,
    );
    // Each may have lost its way in a stretch where the other has not.
    let (of_a, of_b) = (costs(&a, &b.1)?, costs(&b, &a.1)?);
    let own = a.1.segments.iter().zip(of_a);
    let pairs = own
        .filter(|(s, _)| bounces(s))
        .filter_map(|(segment, of_a)| {
            let k = b.1.segments.iter().position(|s| same(s, segment))?;
            let rows = a.0.problem.rows(segment).len();
            let near = of_a.min(of_b[k]) < POOR * rows as f64;
            near.then_some(of_a - of_b[k])
        });
    Ok(pairs.collect())
}

fn same(a: &Segment, b: &Segment) -> bool {
    (a.recording, &a.samples, a.joints.len()) == (b.recording, &b.samples, b.joints.len())
}

/// Whether the mass bounces in a stretch, and little else happens in it.
fn bounces(segment: &Segment) -> bool {
    let bounce = |k: &JointKind| matches!(k, JointKind::Event(Kind::Bounce { .. }));
    segment.joints.len() <= MANY && segment.joints.iter().any(|j| bounce(&j.what))
}

/// Cost of each stretch around bounces, from where it is and from where `other` has it,
/// whichever is less.
fn costs((prepared, point): &(Prepared, Point), other: &Point) -> Result<Vec<f64>, DiagnoseError> {
    let mut segments = point.segments.clone();
    for segment in &mut segments {
        if let Some(there) = other.segments.iter().find(|s| same(s, segment)) {
            segment.locals.clone_from(&there.locals);
        }
    }
    let problem = &prepared.problem;
    let asked = |(segment, used): (&Segment, &bool)| *used && bounces(segment);
    let asked: Vec<bool> = segments.iter().zip(&point.used).map(asked).collect();
    let there = settle(problem, &point.x, &segments, &asked, LOSS, STEPS)?;
    let simulator = problem.simulator(&point.x)?;
    let of = |point: &Point| -> Result<Vec<f64>, DiagnoseError> {
        let all = residuals_at(problem, point, |i, _| asked[i])?;
        let one = |(segment, r): (&Segment, Option<Vec<f64>>)| {
            r.map_or(f64::INFINITY, |r| {
                let cost: f64 = r.iter().map(|r| LOSS.cost(*r)).sum();
                cost + taken_over(problem, &simulator, segment)
            })
        };
        Ok(point.segments.iter().zip(all).map(one).collect())
    };
    let pairs = of(point)?.into_iter().zip(of(&there)?);
    Ok(pairs.map(|(a, b)| a.min(b)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench::with_effect;
    use crate::diagnose::made::{self, QUIET};
    use crate::model::Model;
    use crate::model::effects::{ActiveEffect, find};
    use crate::model::preset::Preset;

    #[test]
    fn bounces_tell_only_with_one_voice() {
        assert_eq!(verdict(&[]), None);
        assert_eq!(verdict(&[1.0, -2.0, 7.0, 3.0]), None);
        assert_eq!(verdict(&[25.0, 20.0, 500.0, -1.0]), Some(74.0));
        // Two may have been misread.
        assert_eq!(verdict(&[25.0, 3.0, 500.0, -1.0]), None);
        assert_eq!(
            verdict(&[-25.0, -20.0, -15.0, -9.0, -12.0, 9.0]),
            Some(-72.0)
        );
        assert_eq!(verdict(&[25.0, 20.0, 30.0, -20.0]), None);
    }

    #[test]
    fn only_lags_of_the_reading_and_of_the_drive_look_alike() {
        assert!(looks_like("sensor_lag", "amplifier_lag"));
        assert!(looks_like("amplifier_lag", "sensor_lag"));
        assert!(!looks_like("sensor_lag", "sensor_lag"));
        assert_eq!(twin("sensor_lag"), Some("amplifier_lag"));
        assert_eq!(twin("piezo_creep"), None);
        assert!(!looks_like("sensor_lag", "piezo_creep"));
    }

    /// The paper's device with value `which` of the effect `id`, all its others zero.
    fn with(id: &str, which: usize, value: f64) -> Model {
        let mut effect = ActiveEffect::new(find(id).unwrap());
        effect.values.iter_mut().for_each(|v| *v = 0.0);
        effect.values[which] = value;
        with_effect(&Preset::embedded("paper").unwrap().model, effect)
    }

    /// Two recordings of square waves, of a device with what is `concealed`.
    fn bench_of(concealed: &Model) -> Bench {
        let drives = [("square:40Hz:8V", 0.06), ("square:300Hz:8V", 0.05)];
        made::bench_of(concealed, &drives, 25e3, 50e-9)
    }

    /// What the bounces tell of a device with the lag `concealed`: below 0 that it is the
    /// reading's, above 0 the drive's.
    fn asked(concealed: &str) -> Option<f64> {
        let with = |id: &str| with(id, 0, 25e-6);
        let bench = bench_of(&with(concealed));
        let fit = |id: &str| bench.baseline(&with(id), &QUIET).unwrap();
        let (sensor, amplifier) = (fit("sensor_lag"), fit("amplifier_lag"));
        told(&bench, (&sensor, None), (&amplifier, None)).unwrap()
    }

    #[test]
    fn bounces_tell_a_late_reading_from_a_late_drive() {
        let late_readings = asked("sensor_lag").unwrap();
        assert!(late_readings < -LEAST, "{late_readings}");
        let late_drive = asked("amplifier_lag").unwrap();
        assert!(late_drive > LEAST, "{late_drive}");
    }

    #[test]
    fn a_delay_that_begins_far_off_is_found() {
        let delayed = |by: f64| with("sensor_lag", 1, by);
        let bench = bench_of(&delayed(100e-6));
        // The clocks have taken all of it.
        let known = bench.baseline(&Preset::embedded("paper").unwrap().model, &QUIET);
        let known = known.unwrap();
        let free = ["sensor_lag.delay".to_owned()];
        // Three times what two clocks leave that are known to 5 us each.
        let room = 3.0 * 5e-6 / f64::sqrt(2.0);
        let fit = bench.fit(&delayed(300e-6), &free, &[], &known, 10, &QUIET);
        let found = fit.unwrap().model.get(&free[0]).unwrap();
        assert!((found - 100e-6).abs() < room, "{found}");
    }
}
