//! Steps of the ground's level: the best of very many times is found from the products of a few
//! directions.

use nalgebra::DVector;

use crate::diagnose::score_test::linearized::{Linearized, SegmentGram};
use crate::diagnose::score_test::scan::{NuisanceProjector, ScoreGain, ScoreScan};
use crate::diagnose::thresholds::LEVEL_MIN_STAYS;
use crate::model::Model;
use crate::model::effects::{ActiveEffect, level_step};
use crate::sim::SimError;

/// Height of the step that is tested \[m\].
pub const PROBE_RISE: f64 = 1e-7;

/// A ground that is higher by [`PROBE_RISE`] all the time.
///
/// # Panics
/// If the catalogue has no step of the ground.
pub(crate) fn raised_ground() -> ActiveEffect {
    let spec = level_step().expect("the catalogue has it");
    ActiveEffect {
        spec,
        values: vec![PROBE_RISE, -1e9],
    }
}

/// A step of the ground's level, and its gain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelStep {
    /// Height, in units of [`PROBE_RISE`].
    pub height: f64,
    /// Time \[s\]: in each recording, or in the sequence of all.
    pub time: f64,
    /// Start of the last contact before that \[s\]. Between the two the time is not
    /// determined.
    pub since: f64,
    /// Whether it happens once in the sequence of recordings.
    pub sequential_time: bool,
    /// Fall of chi2.
    pub gain: f64,
}

/// Searches for a step of the ground's level, at the same time in each recording and once in the
/// sequence, where `epochs` are the recordings' start times in it \[s\]; the best of either. The
/// first `locked` unknowns stay fixed.
///
/// # Errors
/// [`SimError`] if a model makes no sense.
pub fn find_level_steps(
    linear: &Linearized<'_>,
    model: &Model,
    locked: usize,
    epochs: &[f64],
) -> Result<Vec<LevelStep>, SimError> {
    let products = linear.segment_grams(model, &[raised_ground()])?;
    let whole = ScoreScan::assemble(linear, &products, 1);
    let Some(base) = whole.projector_with_locked(locked) else {
        return Ok(Vec::new());
    };
    let n = linear.problem().unknowns();
    let segments = &linear.point().segments;
    let begin = |p: &SegmentGram, lies: bool| {
        let s = &segments[p.segment];
        let time = &linear.problem().data[s.recording].recording.time;
        let since = s.since.filter(|_| lies);
        since.unwrap_or(time[s.samples.start]) - 0.5 * s.interval
    };
    let held: Vec<&SegmentGram> = products
        .iter()
        .filter(|p| segments[p.segment].starts_held)
        .collect();
    let gain_of = |on: &dyn Fn(&SegmentGram) -> bool| {
        gain_in_segments(&base, n, held.iter().copied().filter(|p| on(p)))
    };
    let mut best: [Option<LevelStep>; 2] = [None, None];
    // A mass at rest on the ground may follow it, or stay where it is until it lifts off.
    let ways = [(false, false), (false, true), (true, false), (true, true)];
    for (i, at) in held.iter().enumerate() {
        let k = segments[at.segment].recording;
        // A contact that was cut into segments begins once.
        let goes_on = i > 0 && {
            let [before, now] = [held[i - 1], at].map(|p| &segments[p.segment]);
            before.recording == now.recording && before.since.is_some() && before.since == now.since
        };
        for (sequential_time, lies) in ways.into_iter().filter(|(_, lies)| !(*lies && goes_on)) {
            let t0 = begin(at, lies);
            let later = |p: &SegmentGram| {
                let r = segments[p.segment].recording;
                match sequential_time {
                    true => r > k || (r == k && begin(p, lies) >= t0),
                    false => begin(p, lies) >= t0,
                }
            };
            // Without contacts before it, there is no step.
            let before = || held.iter().filter(|p| !later(p));
            if before().count() < LEVEL_MIN_STAYS {
                continue;
            }
            let Some(p) = gain_of(&later) else {
                continue;
            };
            let best = &mut best[usize::from(sequential_time)];
            if best.is_none_or(|b| p.gain > b.gain) {
                let epoch = |k: usize| {
                    epochs
                        .get(k)
                        .copied()
                        .filter(|_| sequential_time)
                        .unwrap_or(0.0)
                };
                let in_series =
                    |p: &SegmentGram| epoch(segments[p.segment].recording) + begin(p, lies);
                *best = Some(LevelStep {
                    height: p.theta,
                    time: in_series(at),
                    since: before()
                        .map(|p| in_series(p))
                        .fold(f64::NEG_INFINITY, f64::max),
                    sequential_time,
                    gain: p.gain,
                });
            }
        }
    }
    Ok(best.into_iter().flatten().collect())
}

/// Score of a direction that acts in some segments only, with `n` unknowns in all.
fn gain_in_segments<'a>(
    base: &NuisanceProjector,
    n: usize,
    some: impl Iterator<Item = &'a SegmentGram>,
) -> Option<ScoreGain> {
    let (mut cross, mut own, mut slope) = (DVector::zeros(n), 0.0, 0.0);
    for p in some {
        for (i, &c) in p.columns.iter().enumerate() {
            cross[c] += p.cross[(i, 0)];
        }
        own += p.gram[(0, 0)];
        slope += p.slope[0];
    }
    base.predicted_gain(&cross, own, slope)
}

/// Score of another level of the ground in one `recording`, in units of [`PROBE_RISE`], from
/// `products` with [`raised_ground`].
pub fn level_gain(
    linear: &Linearized<'_>,
    base: &NuisanceProjector,
    products: &[SegmentGram],
    recording: usize,
) -> Option<ScoreGain> {
    let stays = products.iter().filter(|p| {
        let segment = &linear.point().segments[p.segment];
        segment.starts_held && segment.recording == recording
    });
    gain_in_segments(base, linear.problem().unknowns(), stays)
}

/// Score of another level of the ground in the first recording of `linear` with enough contacts,
/// the model's parameters fixed: the index of that recording and the score, in units of
/// [`PROBE_RISE`].
///
/// # Errors
/// [`SimError`] if a model makes no sense.
pub fn first_level_gain(
    linear: &Linearized<'_>,
    model: &Model,
) -> Result<Option<(usize, ScoreGain)>, SimError> {
    let products = linear.segment_grams(model, &[raised_ground()])?;
    let segments = &linear.point().segments;
    let count = |k: usize| {
        let own = products.iter().map(|p| &segments[p.segment]);
        own.filter(|s| s.recording == k && s.starts_held).count()
    };
    let recordings = 0..linear.problem().data.len();
    let Some(first) = recordings
        .into_iter()
        .find(|&k| count(k) >= LEVEL_MIN_STAYS)
    else {
        return Ok(None);
    };
    let whole = ScoreScan::assemble(linear, &products, 1);
    let base = whole.projector_with_locked(linear.problem().space.len());
    let score = base.and_then(|base| level_gain(linear, &base, &products, first));
    Ok(score.map(|score| (first, score)))
}

#[cfg(test)]
mod tests {
    use super::super::level_step::*;
    use crate::diagnose::test_support::{QUIET, stepping, workspace_of};

    #[test]
    fn a_step_under_a_resting_mass_shows_at_the_next_contact() {
        const STEP_HEIGHT: f64 = -1e-6;
        let workspace_on =
            |ground: &Model| workspace_of(ground, &[("square:40Hz:8V", 0.1)], 50e3, 20e-9);
        // The motion repeats in each period; a ground without a step shows its timing.
        let plain = workspace_on(&stepping(0.0, 0.0));
        let mut landed: Vec<f64> = plain
            .train
            .segments()
            .iter()
            .filter_map(|s| s.since)
            .collect();
        landed.dedup();
        let third = landed.iter().position(|t| *t > 0.05).unwrap();
        let (lies, flies) = (landed[third - 1] + 2e-3, landed[third] - 1e-3);
        let workspace = workspace_on(&stepping(STEP_HEIGHT, flies));
        let fit = |model: &Model| workspace.fit_cold_start(model, &[], &[], &QUIET).unwrap();
        // Under a resting mass, which keeps its level until it has lifted off, the step shows late.
        for time in [flies, lies] {
            let per_value = fit(&stepping(STEP_HEIGHT, time)).per_value();
            assert!(per_value < 1.1, "{time}: {per_value}");
        }
        let without = fit(&stepping(0.0, 0.0));
        assert!(without.per_value() > 2.0, "{}", without.per_value());
        let linear = Linearized::new(&without).unwrap();
        let found = find_level_steps(&linear, &without.model, 0, &workspace.epochs()).unwrap();
        let best = found
            .iter()
            .max_by(|a, b| a.gain.total_cmp(&b.gain))
            .unwrap();
        assert!(best.since < flies && flies < best.time, "{best:?}");
        assert!(
            (PROBE_RISE * best.height / STEP_HEIGHT - 1.0).abs() < 0.3,
            "{best:?}"
        );
    }
}
