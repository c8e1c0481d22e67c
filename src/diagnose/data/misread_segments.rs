//! Segments that were misread, found by comparing them with a fit: those that are far off where
//! the others are not, and held ones in which the mass is in fact in the air.

use rayon::prelude::*;

use super::missed_contacts::{flight_before_contact, may_have_touched};
use super::robust_loss::{LEAST_SQUARES, ROBUST_LOSS};
use crate::diagnose::thresholds::{
    AIRBORNE_MAX_CHI2, AIRBORNE_MIN_COST_DROP, ALIKE_AIRBORNE_MIN_COST_DROP, HELD_SUSPECT_EXCESS,
    MISREAD_MIN_RMS_RATIO,
};
use crate::fit::problem::Problem;
use crate::fit::segment::{Joint, Segment, state_units};
use crate::fit::solve::point::Point;
use crate::recording::quantile_in_place;
use crate::sim::{SimError, StretchSimulator, StretchState};

/// This many clear cases in a recording make other segments of it likely ones.
const MIN_HOVERING_SEGMENTS: usize = 2;

/// Heights above the ground that may be mistaken for contact, in standard deviations of the noise.
const UNRESOLVED_HEIGHT_IN_NOISE: f64 = 6.0;
/// Quantile of the residuals of segments with a jump of the drive that counts as typical.
const TYPICAL_JUMP_QUANTILE: f64 = 0.5;
/// Fewest such segments from which a typical residual is taken.
const MIN_JUMP_SEGMENTS: usize = 5;
/// Most iterations of a segment's own fit.
const LOCAL_FIT_STEPS: usize = 8;

/// Handles segments that are far off where the others are not. Each is fitted again from its first
/// guess, and set aside if that does not help, for then an event in it was overlooked. Returns
/// whether anything changed.
pub fn reassign_misread_segments(
    problem: &Problem,
    point: &mut Point,
    first: &[Segment],
) -> Result<bool, SimError> {
    let simulator = problem.simulator(&point.x)?;
    let states = problem.states(&point.x, &simulator, &point.segments);
    let fit = |i: usize, start: Vec<f64>, huber, rounds| {
        let segment = &point.segments[i];
        let nuisances = problem.nuisances_of(&point.x, segment.recording);
        let refined = problem.refine(
            segment, &states[i], &simulator, &nuisances, start, huber, rounds,
        );
        (refined.locals, refined.cost)
    };
    let rows: Vec<usize> = point
        .segments
        .iter()
        .map(|s| problem.rows(s).len())
        .collect();
    let per_row = |i: usize, cost: f64| (cost / rows[i].max(1) as f64).sqrt();
    let mut now: Vec<(Vec<f64>, f64)> = (0..point.segments.len())
        .into_par_iter()
        .map(|i| fit(i, point.segments[i].locals.clone(), ROBUST_LOSS, 1))
        .collect();
    let of_used = |now: &[(Vec<f64>, f64)]| -> Vec<(f64, usize)> {
        let used = (0..now.len()).filter(|&i| point.used[i]);
        used.map(|i| (per_row(i, now[i].1), rows[i])).collect()
    };
    let mut costs: Vec<f64> = of_used(&now).into_iter().map(|(cost, _)| cost).collect();
    costs.retain(|cost| cost.is_finite());
    let typical = quantile_in_place(&mut costs, 0.5).max(1.0);
    let off: Vec<usize> = (0..now.len())
        .filter(|&i| point.used[i] && per_row(i, now[i].1) > MISREAD_MIN_RMS_RATIO * typical)
        .collect();
    let fresh: Vec<(Vec<f64>, f64)> = off
        .par_iter()
        .map(|&i| {
            let guess = initial_guess(&first[i], &point.segments[i]);
            let (loose, _) = fit(i, guess.to_vec(), LEAST_SQUARES, 8);
            fit(i, loose, ROBUST_LOSS, 8)
        })
        .collect();
    let mut changed = false;
    for (&i, better) in off.iter().zip(fresh) {
        if better.1 < now[i].1 {
            now[i] = better;
            changed = true;
        }
    }
    // Misread are only those that a new start does not improve, and only where most others
    // fit.
    let usual = typical_residual(of_used(&now));
    let jumps = |i: usize| !point.segments[i].starts_held && point.segments[i].has_jump();
    let with_jump = (0..now.len()).filter(|&i| point.used[i] && jumps(i));
    let with_jump = typical_jump_residual(with_jump.map(|i| per_row(i, now[i].1)).collect(), usual);
    let misread: Vec<usize> = (0..now.len())
        .into_par_iter()
        .filter(|&i| point.used[i])
        .filter(|&i| {
            let usual = if jumps(i) { with_jump } else { usual };
            // A bounce between two samples leaves a few samples far off, which the
            // robust loss tolerates.
            let whole = || per_row(i, fit(i, now[i].0.clone(), LEAST_SQUARES, 0).1);
            let graze = || whole() > MISREAD_MIN_RMS_RATIO * usual;
            // The effect of a jump shows from the jump on, an overlooked contact at
            // the lowest point.
            let touched = || {
                let start = now[i].0.clone();
                let flight = || flight_residual(problem, point, (&simulator, &states[i]), i, start);
                let flown = jumps(i).then(flight)??;
                let limit = MISREAD_MIN_RMS_RATIO * MISREAD_MIN_RMS_RATIO * flown.max(1.0);
                Some(flown < MISREAD_MIN_RMS_RATIO && whole() > limit)
            };
            per_row(i, now[i].1) > MISREAD_MIN_RMS_RATIO * usual
                || (may_have_touched(problem, point, &simulator, i) && graze())
                || touched() == Some(true)
        })
        .collect();
    for &i in &off {
        point.segments[i].locals.clone_from(&now[i].0);
    }
    for &i in &misread {
        point.used[i] = false;
    }
    let above = hovering_segments(problem, point, &simulator, &states);
    for &i in &above {
        point.used[i] = false;
    }
    Ok(changed || !misread.is_empty() || !above.is_empty())
}

/// Root-mean-square residual of segment `i` before its lowest point after the last jump of the
/// drive, fitted from `start`; `None` if it stays clear of the ground.
fn flight_residual(
    problem: &Problem,
    point: &Point,
    (simulator, state): (&StretchSimulator, &[f64]),
    i: usize,
    start: Vec<f64>,
) -> Option<f64> {
    let flown = flight_before_contact(problem, point, simulator, i)?;
    let nuisances = problem.nuisances_of(&point.x, flown.recording);
    let (loss, steps) = (ROBUST_LOSS, LOCAL_FIT_STEPS);
    let refined = problem.refine(&flown, state, simulator, &nuisances, start, loss, steps);
    Some((refined.cost / problem.rows(&flown).len().max(1) as f64).sqrt())
}

/// Initial values of a segment's own unknowns: the first guess, unless that belongs to a model
/// with other modes.
pub fn initial_guess<'a>(first: &'a Segment, now: &'a Segment) -> &'a [f64] {
    if first.locals.len() == now.locals.len() {
        &first.locals
    } else {
        &now.locals
    }
}

/// The root-mean-square residual that nine in ten do not exceed, at least that of noise: nine in
/// ten of the segments or of their rows, whichever is less. Neither the many short segments
/// between the hops of a landing nor a few long ones must count as typical where they were
/// misread.
fn typical_residual(mut of_segments: Vec<(f64, usize)>) -> f64 {
    of_segments.retain(|(cost, _)| cost.is_finite());
    of_segments.sort_by(|a, b| a.0.total_cmp(&b.0));
    let nine_in_ten = |share: &dyn Fn(usize) -> usize| {
        let all: usize = of_segments.iter().map(|(_, rows)| share(*rows)).sum();
        let mut passed = 0;
        let found = of_segments.iter().find(|(_, rows)| {
            passed += share(*rows);
            10 * passed >= 9 * all
        });
        found.map_or(1.0, |(cost, _)| cost.max(1.0))
    };
    nine_in_ten(&|rows| rows).min(nine_in_ten(&|_| 1))
}

/// The typical residual of segments with a jump of the drive, where `usual` is that of all
/// segments. If most of them are far off, the cause is a lag of the drive or of the reading rather
/// than misreading.
fn typical_jump_residual(mut costs: Vec<f64>, usual: f64) -> f64 {
    costs.retain(|cost| cost.is_finite());
    if costs.len() < MIN_JUMP_SEGMENTS {
        return usual;
    }
    quantile_in_place(&mut costs, TYPICAL_JUMP_QUANTILE).max(usual)
}

/// Held segments in which the mass is off the ground by less than the noise shows in one sample:
/// as flight, slightly above the ground, they fit far better. Where a recording has several such
/// segments, a smaller improvement is enough for others.
fn hovering_segments(
    problem: &Problem,
    point: &Point,
    simulator: &StretchSimulator,
    states: &[Vec<f64>],
) -> Vec<usize> {
    // The gain if it is flight, and whether the fit is good then.
    let one = |i: usize| -> Option<(usize, f64, bool)> {
        let held = &point.segments[i];
        let data = &problem.data[held.recording];
        let nuisances = problem.nuisances_of(&point.x, held.recording);
        let cost = |segment: &Segment, rounds| {
            let start = segment.locals.clone();
            problem.refine(
                segment,
                &states[i],
                simulator,
                &nuisances,
                start,
                ROBUST_LOSS,
                rounds,
            )
        };
        let rows = problem.rows(held).len() as f64;
        let on_ground = cost(held, 1).cost;
        if on_ground < rows + HELD_SUSPECT_EXCESS {
            return None;
        }
        let level = simulator.ground_level(data.recording.time[held.samples.start] + data.epoch);
        let flying = as_flight(held, simulator, level, data.sigmas.xp);
        let in_air = cost(&flying, LOCAL_FIT_STEPS);
        let modes = simulator.modes();
        let q: Vec<f64> = (0..modes)
            .map(|k| flying.value(&in_air.locals, k))
            .collect();
        let (phi_p, _) = simulator.flight_shapes();
        let height = q.iter().zip(phi_p).map(|(q, p)| q * p).sum::<f64>() - level;
        let near = height > 0.0 && height < UNRESOLVED_HEIGHT_IN_NOISE * data.sigmas.xp;
        near.then_some((
            i,
            on_ground - in_air.cost,
            in_air.cost < AIRBORNE_MAX_CHI2 * rows,
        ))
    };
    let held = (0..point.segments.len()).into_par_iter();
    let nearly: Vec<(usize, f64, bool)> = held
        .filter(|&i| point.used[i] && point.segments[i].starts_held)
        .filter_map(one)
        .collect();
    let of = |i: usize| point.segments[i].recording;
    let surely: Vec<usize> = nearly
        .iter()
        .filter(|(_, gain, well)| *gain > AIRBORNE_MIN_COST_DROP && *well)
        .map(|(i, ..)| *i)
        .collect();
    nearly
        .iter()
        .filter(|(i, gain, _)| {
            let alike = surely.iter().filter(|&&k| of(k) == of(*i)).count();
            surely.contains(i)
                || (alike >= MIN_HOVERING_SEGMENTS && *gain > ALIKE_AIRBORNE_MIN_COST_DROP)
        })
        .map(|(i, ..)| *i)
        .collect()
}

/// State at the start of a segment, and how many of its unknowns the state takes.
pub(crate) fn start_state(segment: &Segment) -> (StretchState, usize) {
    let joints: usize = segment.joints.iter().map(Joint::unknowns).sum();
    let own = segment.locals.len() - joints;
    let value = |i: usize| segment.value(&segment.locals, i);
    let state = StretchState {
        q: (0..own / 2).map(value).collect(),
        v: (own / 2..own).map(value).collect(),
        z: Vec::new(),
    };
    (state, own)
}

/// A held segment described as flight from the same state.
fn as_flight(held: &Segment, simulator: &StretchSimulator, level: f64, noise: f64) -> Segment {
    let (mut state, own) = start_state(held);
    simulator.lift(level, &mut state);
    let span = held.samples.len().saturating_sub(1) as f64 * held.interval;
    let mut units = state_units(simulator, false, noise, span);
    let start = state.q.iter().chain(&state.v);
    let mut locals: Vec<f64> = start.zip(&units).map(|(x, unit)| x / unit).collect();
    units.extend_from_slice(&held.units[own..]);
    locals.extend_from_slice(&held.locals[own..]);
    Segment {
        starts_held: false,
        since: None,
        settled: false,
        locals,
        units,
        ..held.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::super::misread_segments::*;
    use crate::fit::segment::JointKind;
    use crate::fit::segment::voltage_track::{Edge, Track};
    use crate::model::drive::Waveform;
    use crate::model::preset::Preset;
    use crate::recording::Recording;

    /// A segment with unknowns `locals` and nothing in it.
    fn of(locals: &[f64]) -> Segment {
        Segment {
            recording: 0,
            samples: 0..1,
            starts_held: false,
            since: None,
            settled: false,
            joints: Vec::new(),
            pieces: Vec::new(),
            locals: locals.to_vec(),
            units: vec![1.0; locals.len()],
            velocity_unit: 1.0,
            interval: 1.0,
        }
    }

    #[test]
    fn a_guess_for_other_modes_is_ignored() {
        let now = of(&[1.0, 2.0]);
        assert_eq!(initial_guess(&of(&[3.0, 4.0]), &now), [3.0, 4.0]);
        assert_eq!(initial_guess(&of(&[3.0]), &now), [1.0, 2.0]);
    }

    #[test]
    fn a_smooth_drive_has_no_jumps() {
        let stretch = |drive: &str| {
            let waveform = Waveform::parse(drive, 0.2).unwrap();
            let time: Vec<f64> = (0..10_000).map(|i| f64::from(i) / 50e3).collect();
            let volts = time.iter().map(|&t| waveform.voltage(t)).collect();
            let xp = time.clone();
            let recording = Recording::new("drive", time, Some(volts), xp, None).unwrap();
            let model = Preset::embedded("paper").unwrap().model;
            let track = Track::new(&model, &recording, 0.0).unwrap();
            let joint = |edge: &Edge| Joint {
                time: edge.time,
                reach: edge.reach,
                sigma: edge.sigma,
                what: JointKind::Edge(edge.piece),
            };
            Segment {
                joints: track.edges.iter().map(joint).collect(),
                pieces: track.pieces,
                ..of(&[])
            }
        };
        assert!(stretch("square:15Hz:8V").has_jump());
        let turns = stretch("sine:50Hz:8V");
        assert!(turns.joints.len() > 15 && !turns.has_jump());
    }

    #[test]
    fn an_effect_of_most_jumps_is_not_a_misreading() {
        assert_eq!(
            typical_jump_residual(vec![3.2, 3.4, 3.0, 3.1, 1.0], 1.1),
            3.1
        );
        // Few of them may all be misread, and so may be the lesser part.
        assert_eq!(typical_jump_residual(vec![3.2, 3.4, 3.0], 1.1), 1.1);
        assert_eq!(
            typical_jump_residual(vec![3.2, 3.4, 1.0, 1.0, 0.9], 1.1),
            1.1
        );
        let lost = vec![f64::INFINITY, f64::NAN, 1.0, 1.0, 1.0];
        assert_eq!(typical_jump_residual(lost, 1.1), 1.1);
    }

    #[test]
    fn many_short_segments_far_off_do_not_count_as_typical() {
        // A third of the segments, a twentieth of the rows.
        let mut all: Vec<(f64, usize)> = vec![(1.1, 300); 20];
        all.extend(vec![(80.0, 30); 10]);
        assert_eq!(typical_residual(all.clone()), 1.1);
        // And the other way round.
        let mut few: Vec<(f64, usize)> = vec![(1.2, 30); 40];
        few.extend(vec![(9.0, 600); 3]);
        assert_eq!(typical_residual(few), 1.2);
        // Where most of the data is far off, that is usual.
        all.extend(vec![(7.0, 300); 20]);
        assert_eq!(typical_residual(all), 7.0);
        assert_eq!(typical_residual(Vec::new()), 1.0);
        assert_eq!(typical_residual(vec![(0.6, 10), (f64::INFINITY, 5)]), 1.0);
    }
}
