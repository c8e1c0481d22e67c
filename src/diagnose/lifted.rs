//! Recordings whose ground, as it was read, lies higher than that of the others: the mass may have
//! come to rest over it without touching it. Each recording has a zero of its own, so that a wrong
//! level hides in that, and only the flights before and after tell.

use super::bench::Fitted;
use super::explain::Stand;
use super::scan::{Linear, Scan};
use super::search::{BEFORE, always, find_step, promise_of};
use crate::sim::SimError;

/// Fall of chi2 by a higher ground in one recording from which it lies higher, if a ground that
/// steps does not bring as much more.
const HIGHER: f64 = 40.0;

/// Those of either side of `stand`.
///
/// # Errors
/// [`SimError`] if a model makes no sense.
pub fn lifted(stand: &Stand) -> Result<(Vec<usize>, Vec<usize>), SimError> {
    let held_out = stand.held_out.as_ref();
    Ok((
        of(&stand.train, 0)?,
        held_out.map_or(Ok(Vec::new()), |fitted| {
            of(fitted, fitted.problem.space.len())
        })?,
    ))
}

/// Those of a fit, of which the first `locked` unknowns stay as they are.
fn of(fitted: &Fitted, locked: usize) -> Result<Vec<usize>, SimError> {
    let segments = &fitted.point.segments;
    let stays = |k: usize| {
        let own = segments.iter().zip(&fitted.point.used);
        own.filter(|(s, used)| **used && s.starts_held && s.recording == k)
            .count()
    };
    let mut asked: Vec<usize> = (0..fitted.problem.data.len()).collect();
    asked.retain(|k| stays(*k) >= BEFORE);
    if asked.is_empty() {
        return Ok(asked);
    }
    let linear = Linear::new(fitted)?;
    let products = linear.products(&fitted.model, &[always()])?;
    let Some(base) = Scan::gather(&linear, &products, 1).base_without(locked) else {
        return Ok(Vec::new());
    };
    let steps = find_step(&linear, &fitted.model, &always(), &[])?;
    let step = steps.iter().fold(0.0f64, |most, s| most.max(s.gain));
    let n = linear.problem().unknowns();
    asked.retain(|&k| {
        let own = products.iter().filter(|p| {
            let segment = &segments[p.segment];
            segment.starts_held && segment.recording == k
        });
        let promise = promise_of(&base, n, own);
        promise.is_some_and(|p| p.theta > 0.0 && p.gain > HIGHER.max(step - HIGHER))
    });
    Ok(asked)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::made::{QUIET, bench, parts_of, stepping};

    /// Which of three recordings lie higher where the ground of the second and the third is as
    /// given: by how much, and since when.
    fn higher(second: (f64, f64), third: (f64, f64)) -> Vec<usize> {
        let on = |(by, since): (f64, f64), drive: &str, duration: f64| {
            let drives = [(drive, duration)];
            parts_of(&stepping(by, since), &drives, 25e3, 150e-9)
        };
        let plain = (0.0, -1e9);
        let parts = [
            on(plain, "square:40Hz:8V", 0.1),
            on(second, "square:15Hz:8V", 0.3),
            on(third, "sine:50Hz:8V", 0.1),
        ];
        let fit = bench(&parts.concat()).baseline(&stepping(plain.0, plain.1), &QUIET);
        of(&fit.unwrap(), 0).unwrap()
    }

    #[test]
    fn the_recording_with_a_higher_ground_is_found() {
        const ALWAYS: f64 = -1e9;
        let by = 0.25e-6;
        assert!(higher((0.0, ALWAYS), (0.0, ALWAYS)).is_empty());
        assert_eq!(higher((0.0, ALWAYS), (by, ALWAYS)), [2]);
        // It lies higher in part of one: it steps.
        assert!(higher((by, 0.15), (0.0, ALWAYS)).is_empty());
    }
}
