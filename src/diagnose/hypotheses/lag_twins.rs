//! Lag of the sensor or of the amplifier: in flight the two look alike. At impacts they do not: a
//! lag of the sensor rounds the kink of the motion, a lag of the drive leaves it sharp.

use crate::diagnose::contact::event_readings::around_events;
use crate::diagnose::options::DiagnoseError;
use crate::diagnose::shooting::fitted::{Fitted, first_reading_correction};
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::thresholds::{
    LAG_TWINS_MAX_CHI2, LAG_TWINS_MAX_CONTRARY, LAG_TWINS_MIN_GAIN, LAG_TWINS_MIN_VOTE,
    LAG_TWINS_MIN_VOTES,
};
use crate::fit::problem::Problem;
use crate::fit::problem::huber::Huber;
use crate::fit::problem::prepare::Prepared;
use crate::fit::segment::event_sequence::GroundEvent;
use crate::fit::segment::{JointKind, Segment};
use crate::fit::solve::point::{Point, residuals_at, settle};
use crate::model::effects::twin_in_flight;

/// Residuals beyond this many standard deviations count linearly.
const IMPACT_LOSS: Huber = Huber(4.0);
/// Iterations of a segment from where the other model has it.
const LOCAL_FIT_STEPS: usize = 8;

/// Most events and edges of the drive in a segment: with more, either fit may go astray.
const MAX_JOINTS: usize = 3;
/// Id of the parameter that flight hardly determines.
const DRIVE_SHARE_ID: &str = "drive_p";
/// Step of the search to either side, in its coordinate.
const SEARCH_STEP: f64 = 0.1;
/// Number of those steps.
const SEARCH_STEPS: i32 = 5;
/// Step at which the search ends.
const SEARCH_TOLERANCE: f64 = 2e-3;
/// Largest chi2 per value of a segment in that search.
const MAX_SEARCH_CHI2: f64 = 20.0;
/// Largest contribution of a segment to the comparison.
const MAX_SEGMENT_FALL: f64 = 30.0;

/// Whether `a` and `b` are the two that look alike in flight.
pub fn are_lag_twins(a: &str, b: &str) -> bool {
    twin(a) == Some(b)
}

/// The other one of the two, if `id` is one of them.
pub fn twin(id: &str) -> Option<&'static str> {
    twin_in_flight(id).map(|twin| twin.id)
}

/// Compares two fits by the segments around bounces and landings: a positive fall of chi2 favours
/// `b`, a negative one `a`. Each is a fit to the fitted recordings and that to the held-out ones.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn compare_around_impacts(
    workspace: &Workspace,
    a: (&Fitted, Option<&Fitted>),
    b: (&Fitted, Option<&Fitted>),
) -> Result<ImpactComparison, DiagnoseError> {
    let (a, b) = (
        with_best_drive_share(impact_segments(workspace, a)?)?,
        with_best_drive_share(impact_segments(workspace, b)?)?,
    );
    let mut falls = Vec::new();
    for (a, b) in a.iter().zip(&b) {
        falls.extend(cost_falls(a, b)?);
    }
    log::debug!("around bounces: {falls:.0?}");
    Ok(combine_falls(&falls))
}

/// Result of the comparison around impacts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImpactComparison {
    /// Fall of chi2 from the first to the second fit.
    pub fall: f64,
    /// Whether it is decisive and the segments agree.
    pub sure: bool,
}

/// Short segments around impacts of one split, with their fit.
type ImpactSegments = (Prepared, Point);

/// Those of both splits.
fn impact_segments(
    workspace: &Workspace,
    (train, held_out): (&Fitted, Option<&Fitted>),
) -> Result<Vec<ImpactSegments>, DiagnoseError> {
    let mut all = vec![around_events(workspace, &workspace.train, train)?];
    if let (Some(side), Some(fitted)) = (&workspace.held_out, held_out) {
        all.push(around_events(workspace, side, fitted)?);
    }
    Ok(all)
}

/// The same with the drive shared between the modes as fits the bounces best. In flight a further
/// mode may move alike by a strong drive on a small shape or a weak one on a large shape; only its
/// excitation by impacts distinguishes them.
fn with_best_drive_share(all: Vec<ImpactSegments>) -> Result<Vec<ImpactSegments>, DiagnoseError> {
    let place = |(prepared, _): &ImpactSegments| prepared.problem.space.position(DRIVE_SHARE_ID);
    let places: Option<Vec<usize>> = all.iter().map(place).collect();
    let Some(places) = places else {
        return Ok(all);
    };
    // Each from the best segments found so far.
    let from = |points: &[Point], away: f64| -> Result<(f64, Vec<Point>), DiagnoseError> {
        let own = all.iter().zip(points).zip(&places);
        let (mut sum, mut points) = (0.0, Vec::with_capacity(all.len()));
        for (((prepared, _), point), k) in own {
            let problem = &prepared.problem;
            let mut x = point.x.clone();
            x[*k] += away;
            let asked = eligible_segments(point, has_bounce);
            let point = settle(
                problem,
                &x,
                &point.segments,
                &asked,
                IMPACT_LOSS,
                LOCAL_FIT_STEPS,
            )?;
            let costs = costs_at(problem, &point, &asked)?;
            let own = costs.into_iter().zip(&point.segments).zip(&asked);
            for ((cost, segment), _) in own.filter(|(_, asked)| **asked) {
                sum += cost.min(MAX_SEARCH_CHI2 * problem.rows(segment).len() as f64);
            }
            points.push(point);
        }
        Ok((sum, points))
    };
    let begun: Vec<Point> = all.iter().map(|(_, point)| point.clone()).collect();
    let lower = |a: (f64, Vec<Point>), b: (f64, Vec<Point>)| if b.0 < a.0 { b } else { a };
    let mut best = from(&begun, 0.0)?;
    let first = best.0;
    // Segments may settle elsewhere, so the whole range is scanned first.
    for k in 1..=SEARCH_STEPS {
        let away = f64::from(k) * SEARCH_STEP;
        best = lower(lower(best, from(&begun, away)?), from(&begun, -away)?);
    }
    let mut step = 0.5 * SEARCH_STEP;
    while step > SEARCH_TOLERANCE {
        let both = [from(&best.1, step)?, from(&best.1, -step)?];
        best = both.into_iter().fold(best, lower);
        step *= 0.5;
    }
    log::debug!(
        "{first:.0} around bounces, {:.0} with another {DRIVE_SHARE_ID}",
        best.0
    );
    let own = all.into_iter().zip(best.1);
    let moved = own.map(|((prepared, point), mut there)| {
        there.used = point.used;
        (prepared, there)
    });
    Ok(moved.collect())
}

/// The segments that are used and satisfy `tells`.
fn eligible_segments(point: &Point, tells: fn(&Segment) -> bool) -> Vec<bool> {
    let all = point.segments.iter().zip(&point.used);
    all.map(|(segment, used)| *used && tells(segment)).collect()
}

/// Combines the falls of single segments.
fn combine_falls(falls: &[f64]) -> ImpactComparison {
    let fall: f64 = falls
        .iter()
        .map(|fall| fall.clamp(-MAX_SEGMENT_FALL, MAX_SEGMENT_FALL))
        .sum();
    let telling = falls.iter().filter(|fall| fall.abs() > LAG_TWINS_MIN_VOTE);
    let against = telling.clone().filter(|own| **own * fall < 0.0).count();
    let one_voice = against as f64 <= LAG_TWINS_MAX_CONTRARY * telling.clone().count() as f64;
    let some = telling.count() >= LAG_TWINS_MIN_VOTES;
    let sure = fall.abs() > LAG_TWINS_MIN_GAIN && some && one_voice;
    ImpactComparison { fall, sure }
}

/// Fall of each segment's cost around impacts from `a` to `b`, where one of them describes it.
fn cost_falls(a: &ImpactSegments, b: &ImpactSegments) -> Result<Vec<f64>, DiagnoseError> {
    // Either may have gone astray in a segment where the other has not.
    let (of_a, of_b) = (impact_costs(a, &b.1)?, impact_costs(b, &a.1)?);
    let own = a.1.segments.iter().zip(of_a);
    let pairs = own
        .filter(|(s, _)| has_impact(s))
        .filter_map(|(segment, of_a)| {
            let k = b.1.segments.iter().position(|s| same_segment(s, segment))?;
            let rows = a.0.problem.rows(segment).len();
            let near = of_a.min(of_b[k]) < LAG_TWINS_MAX_CHI2 * rows as f64;
            near.then_some(of_a - of_b[k])
        });
    Ok(pairs.collect())
}

fn same_segment(a: &Segment, b: &Segment) -> bool {
    (a.recording, &a.samples, a.joints.len()) == (b.recording, &b.samples, b.joints.len())
}

/// Whether the mass bounces in a segment, and little else happens in it.
fn has_bounce(segment: &Segment) -> bool {
    has_event(segment, |kind| matches!(kind, GroundEvent::Bounce { .. }))
}

/// The same, or lands.
fn has_impact(segment: &Segment) -> bool {
    has_event(segment, |kind| {
        matches!(kind, GroundEvent::Bounce { .. } | GroundEvent::Touch)
    })
}

/// Whether an event of the wanted kind happens in a segment, and little else.
fn has_event(segment: &Segment, wanted: fn(&GroundEvent) -> bool) -> bool {
    let event = |k: &JointKind| matches!(k, JointKind::Event(kind) if wanted(kind));
    segment.joints.len() <= MAX_JOINTS && segment.joints.iter().any(|j| event(&j.what))
}

/// Cost of each segment with an impact, from its own initial state or from that of `other`,
/// whichever is less.
fn impact_costs(
    (prepared, point): &ImpactSegments,
    other: &Point,
) -> Result<Vec<f64>, DiagnoseError> {
    let mut segments = point.segments.clone();
    for segment in &mut segments {
        if let Some(there) = other.segments.iter().find(|s| same_segment(s, segment)) {
            segment.locals.clone_from(&there.locals);
        }
    }
    let problem = &prepared.problem;
    let asked = eligible_segments(point, has_impact);
    let settled = |segments: &[Segment]| {
        settle(
            problem,
            &point.x,
            segments,
            &asked,
            IMPACT_LOSS,
            LOCAL_FIT_STEPS,
        )
    };
    let here = costs_at(problem, &settled(&point.segments)?, &asked)?;
    let there = costs_at(problem, &settled(&segments)?, &asked)?;
    Ok(here.into_iter().zip(there).map(|(a, b)| a.min(b)).collect())
}

/// Cost of each of the `asked` segments; infinite for the others.
fn costs_at(problem: &Problem, point: &Point, asked: &[bool]) -> Result<Vec<f64>, DiagnoseError> {
    let simulator = problem.simulator(&point.x)?;
    let all = residuals_at(problem, point, |i, _| asked[i])?;
    let one = |(segment, r): (&Segment, Option<Vec<f64>>)| {
        r.map_or(f64::INFINITY, |r| {
            let cost: f64 = r.iter().map(|r| IMPACT_LOSS.cost(*r)).sum();
            cost + first_reading_correction(problem, &simulator, segment)
        })
    };
    Ok(point.segments.iter().zip(all).map(one).collect())
}

#[cfg(test)]
mod tests {
    use super::super::lag_twins::*;
    use crate::diagnose::test_support;
    use crate::diagnose::test_support::QUIET;
    use crate::model::Model;
    use crate::model::effects::{ActiveEffect, find};
    use crate::model::preset::Preset;
    use crate::model::with_effect;

    #[test]
    fn bounces_decide_only_if_they_agree() {
        let check = |falls: &[f64], fall: f64, sure: bool| {
            assert_eq!(combine_falls(falls), ImpactComparison { fall, sure });
        };
        check(&[], 0.0, false);
        check(&[1.0, -2.0, 7.0, 3.0], 9.0, false);
        check(&[25.0, 20.0, 500.0, -1.0], 74.0, true);
        // Two may have been misread.
        check(&[25.0, 3.0, 500.0, -1.0], 57.0, false);
        check(&[-25.0, -20.0, -15.0, -9.0, -12.0, 9.0], -72.0, true);
        check(&[25.0, 20.0, 30.0, -20.0], 55.0, false);
    }

    #[test]
    fn only_lags_of_sensor_and_amplifier_are_twins() {
        assert!(are_lag_twins("sensor_lag", "amplifier_lag"));
        assert!(are_lag_twins("amplifier_lag", "sensor_lag"));
        assert!(!are_lag_twins("sensor_lag", "sensor_lag"));
        assert_eq!(twin("sensor_lag"), Some("amplifier_lag"));
        assert_eq!(twin("piezo_creep"), None);
        assert!(!are_lag_twins("sensor_lag", "piezo_creep"));
    }

    /// The paper's device with value `which` of the effect `id`, all its others zero.
    fn with(id: &str, which: usize, value: f64) -> Model {
        let mut effect = ActiveEffect::new(find(id).unwrap());
        effect.values.iter_mut().for_each(|v| *v = 0.0);
        effect.values[which] = value;
        with_effect(&Preset::embedded("paper").unwrap().model, effect)
    }

    /// Two recordings of square waves, of a device with what is `concealed`.
    fn workspace_with(concealed: &Model) -> Workspace {
        let drives = [("square:40Hz:8V", 0.06), ("square:300Hz:8V", 0.05)];
        test_support::workspace_of(concealed, &drives, 25e3, 50e-9)
    }

    /// Fall of chi2 around the bounces of a device with the lag `concealed`: below 0 that it is the
    /// reading's, above 0 the drive's.
    fn fall_around_impacts(concealed: &str) -> Option<f64> {
        let with = |id: &str| with(id, 0, 25e-6);
        let workspace = workspace_with(&with(concealed));
        let fit = |id: &str| workspace.baseline(&with(id), &QUIET).unwrap();
        let (sensor, amplifier) = (fit("sensor_lag"), fit("amplifier_lag"));
        let compared =
            compare_around_impacts(&workspace, (&sensor, None), (&amplifier, None)).unwrap();
        compared.sure.then_some(compared.fall)
    }

    #[test]
    fn bounces_distinguish_a_sensor_lag_from_an_amplifier_lag() {
        let late_readings = fall_around_impacts("sensor_lag").unwrap();
        assert!(late_readings < -LAG_TWINS_MIN_GAIN, "{late_readings}");
        let late_drive = fall_around_impacts("amplifier_lag").unwrap();
        assert!(late_drive > LAG_TWINS_MIN_GAIN, "{late_drive}");
    }

    #[test]
    fn bounces_determine_how_the_drive_is_shared() {
        let paper = Preset::embedded("paper").unwrap().model;
        let workspace = workspace_with(&paper);
        let fit = workspace.baseline(&paper, &QUIET).unwrap();
        let place =
            |all: &[ImpactSegments]| all[0].0.problem.space.position(DRIVE_SHARE_ID).unwrap();
        let mut all = impact_segments(&workspace, (&fit, None)).unwrap();
        let k = place(&all);
        let right = all[0].1.x[k];
        all[0].1.x[k] += 0.3;
        let found = with_best_drive_share(all).unwrap()[0].1.x[k];
        assert!((found - right).abs() < 0.05, "{found} {right}");
    }

    #[test]
    fn a_delay_is_found_from_a_distant_start() {
        let delayed = |by: f64| with("sensor_lag", 1, by);
        let workspace = workspace_with(&delayed(100e-6));
        // The clocks have taken all of it.
        let known = workspace.baseline(&Preset::embedded("paper").unwrap().model, &QUIET);
        let known = known.unwrap();
        let free = ["sensor_lag.delay".to_owned()];
        // Three times what two clocks leave that are known to 5 us each.
        let room = 3.0 * 5e-6 / f64::sqrt(2.0);
        let fit = workspace.fit(&delayed(300e-6), &free, &[], &known, 10, &QUIET);
        let found = fit.unwrap().model.get(&free[0]).unwrap();
        assert!((found - 100e-6).abs() < room, "{found}");
    }
}
