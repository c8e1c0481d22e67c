//! Contacts that were overlooked: a segment read as one flight descends and rises again between
//! two of its samples.

use crate::fit::problem::Problem;
use crate::fit::segment::Segment;
use crate::fit::solve::point::Point;
use crate::sim::StretchSimulator;

/// Height over the ground up to which a lagging reading may turn, in units of the longest distance
/// between two samples.
const MAX_TURNING_HEIGHT: f64 = 2.0;
/// Samples before the lowest one that a lagging reading may already show as contact \[samples\].
const PRE_CONTACT_SAMPLES: usize = 6;
/// Fewest samples that show whether a segment was flight \[samples\].
const MIN_FLIGHT_SAMPLES: usize = 16;

/// Lowest sample of a flight segment from its sample `from` on, and its height over the ground in
/// units of the longest distance between two samples.
fn lowest_point(
    problem: &Problem,
    point: &Point,
    simulator: &StretchSimulator,
    (i, from): (usize, usize),
) -> Option<(usize, f64)> {
    let segment = &point.segments[i];
    let data = &problem.data[segment.recording];
    let xp = &data.recording.proof_mass[segment.samples.clone()];
    let steps = xp.windows(2).map(|w| (w[1] - w[0]).abs());
    let travel = steps.fold(0.0, f64::max);
    let all = xp.iter().copied().enumerate().skip(from);
    let finite = all.filter(|(_, x)| x.is_finite());
    let (at, lowest) = finite.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let level = simulator.ground_level(data.recording.time[segment.samples.start] + data.epoch);
    let offset = problem.nuisances_of(&point.x, segment.recording).offset_p;
    Some((at, (lowest - offset - level) / travel))
}

/// Whether a flight segment descends and rises again so low that the mass may have touched the
/// ground between two samples.
pub(crate) fn may_have_touched(
    problem: &Problem,
    point: &Point,
    simulator: &StretchSimulator,
    i: usize,
) -> bool {
    let segment = &point.segments[i];
    let inside = |at: usize| at >= 2 && at + 2 < segment.samples.len();
    let low = |(at, height): (usize, f64)| height < 1.0 && inside(at);
    !segment.starts_held && lowest_point(problem, point, simulator, (i, 0)).is_some_and(low)
}

/// A flight segment up to its lowest point after the last jump of the drive, if the mass may have
/// touched the ground there. The reading may lag.
pub(crate) fn flight_before_contact(
    problem: &Problem,
    point: &Point,
    simulator: &StretchSimulator,
    i: usize,
) -> Option<Segment> {
    let mut flown = point.segments[i].clone();
    let time = &problem.data[flown.recording].recording.time;
    let last = flown.joints.last()?.time;
    let after = time[flown.samples.clone()].partition_point(|t| *t <= last);
    let (at, height) = lowest_point(problem, point, simulator, (i, after))?;
    flown.samples.end = flown.samples.start + at.saturating_sub(PRE_CONTACT_SAMPLES).max(after);
    (height < MAX_TURNING_HEIGHT && flown.samples.len() >= MIN_FLIGHT_SAMPLES).then_some(flown)
}

#[cfg(test)]
mod tests {
    use super::super::misread_segments::reassign_misread_segments;
    use crate::diagnose::test_support;
    use crate::diagnose::test_support::QUIET;
    use crate::fit::segment::Segment;
    use crate::model::preset::Preset;

    /// Samples between two flights with a bounce between them.
    const MAX_GAP_SAMPLES: usize = 6;

    #[test]
    fn overlooked_contacts_are_set_aside_even_if_most_flights_with_a_jump_have_one() {
        let device = Preset::embedded("paper").unwrap().model;
        let drives = [("ramped:10Hz:8V:0.15", 0.2), ("square:300Hz:8V", 0.05)];
        let workspace = test_support::workspace_of(&device, &drives, 50e3, 20e-9);
        let fitted = workspace.baseline(&device, &QUIET).unwrap();
        let (problem, mut point) = (fitted.problem, fitted.point);
        let flies = |s: &Segment| !s.starts_held;
        let mut merged = Vec::new();
        for i in 1..point.segments.len() {
            let (first, second) = (&point.segments[i - 1], &point.segments[i]);
            let near = second.recording == first.recording
                && second.samples.start <= first.samples.end + MAX_GAP_SAMPLES;
            if near && flies(first) && flies(second) && first.has_jump() && !second.has_jump() {
                // It ends so soon after that it is not seen to go up again.
                let end = second.samples.start + 1;
                point.segments[i - 1].samples.end = end;
                point.used[i - 1] = true;
                merged.push(i - 1);
            }
        }
        let jumps = point.segments.iter().filter(|s| flies(s) && s.has_jump());
        println!("{} of {} with a jump", merged.len(), jumps.clone().count());
        assert!(2 * merged.len() > jumps.count());
        let first = point.segments.clone();
        reassign_misread_segments(&problem, &mut point, &first).unwrap();
        let left = merged.iter().filter(|i| point.used[**i]).count();
        assert_eq!(left, 0, "of {}", merged.len());
    }
}
