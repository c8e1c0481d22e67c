//! Touches of the ground that were overlooked: a stretch that was read as one flight goes down and
//! up again between two of its samples.

use crate::fit::problem::Problem;
use crate::fit::segment::Segment;
use crate::fit::solve::Point;
use crate::sim::StretchSimulator;

/// Ways between samples over the ground up to which a reading that lags may turn.
const LATE: f64 = 2.0;
/// Samples before the lowest one that may be of a touch already: of a reading that lags.
const BEFORE: usize = 6;
/// Fewest samples of a stretch that tell whether it was flown.
const LEAST: usize = 16;

/// Where a stretch of flight is lowest from sample `from` of it on, and how high that is over the
/// ground, in units of the longest way between two of its samples.
fn lowest(
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

/// Whether a stretch of flight comes down and goes up again so low that the mass may have
/// touched the ground between two of its samples.
pub(super) fn grazes(
    problem: &Problem,
    point: &Point,
    simulator: &StretchSimulator,
    i: usize,
) -> bool {
    let segment = &point.segments[i];
    let inside = |at: usize| at >= 2 && at + 2 < segment.samples.len();
    let low = |(at, height): (usize, f64)| height < 1.0 && inside(at);
    !segment.starts_held && lowest(problem, point, simulator, (i, 0)).is_some_and(low)
}

/// A stretch of flight up to where it comes so low after the drive's last jump that the mass may
/// have touched the ground, by a reading that may lag.
pub(super) fn until_lowest(
    problem: &Problem,
    point: &Point,
    simulator: &StretchSimulator,
    i: usize,
) -> Option<Segment> {
    let mut flown = point.segments[i].clone();
    let time = &problem.data[flown.recording].recording.time;
    let last = flown.joints.last()?.time;
    let after = time[flown.samples.clone()].partition_point(|t| *t <= last);
    let (at, height) = lowest(problem, point, simulator, (i, after))?;
    flown.samples.end = flown.samples.start + at.saturating_sub(BEFORE).max(after);
    (height < LATE && flown.samples.len() >= LEAST).then_some(flown)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::diagnose::made::{self, QUIET};
    use crate::fit::Part;
    use crate::model::effects::{ActiveEffect, find};
    use crate::model::preset::Preset;

    /// A reading that lags turns above the ground where the mass hits it fast.
    #[test]
    fn touches_that_a_lag_hides_are_set_aside() {
        let mut lag = ActiveEffect::new(find("sensor_lag").unwrap());
        lag.values = vec![15e-6, 0.0];
        let mut device = Preset::embedded("paper").unwrap().model;
        device.effects.push(lag);
        let drives = [
            ("ramped:10Hz:8V:0.15", 0.2),
            ("sine:50Hz:8V", 0.1),
            ("square:300Hz:8V", 0.05),
        ];
        let mut parts = made::parts_of(&device, &drives, 50e3, 20e-9);
        for part in &mut parts {
            let mut recording = (*part.recording).clone();
            recording.cantilever = None;
            *part = Part::whole(Arc::new(recording));
        }
        let bench = made::bench(&parts);
        let model = Preset::embedded("paper").unwrap().model;
        let fitted = bench.baseline(&model, &QUIET).unwrap();
        let (per_value, aside) = (fitted.per_value(), fitted.aside());
        println!("{per_value:.3} per value, {:.1} % set aside", 100.0 * aside);
        assert!(per_value < 1.5, "{per_value}");
    }
}
