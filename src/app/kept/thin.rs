//! A long answer for a file: the residuals of single samples are thinned to the lowest and the
//! highest of each stretch, as curves are drawn. All other numbers stay whole.

use std::borrow::Cow;

use crate::app::analysis::diagnosis_answer::Answer;
use crate::diagnose::diagnosis::Strip;

/// Most samples of residuals in a file, before and after together: with them an answer takes
/// some 2 MB. The example has 80,000 and takes 0.8 MB.
pub(super) const MAX_KEPT_SAMPLES: usize = 200_000;

/// The answer with as many samples as a file takes.
pub(super) fn thinned(answer: &Answer) -> Cow<'_, Answer> {
    let strips = &answer.diagnosis.strips;
    let count = |s: &Strip| s.samples_before.len() + s.samples_after.len();
    let all: usize = strips.iter().map(count).sum();
    if all <= MAX_KEPT_SAMPLES {
        return Cow::Borrowed(answer);
    }
    // Two samples remain of each stretch.
    let stretch = 2 * all.div_ceil(MAX_KEPT_SAMPLES);
    let mut answer = answer.clone();
    answer.is_thinned = true;
    for strip in &mut answer.diagnosis.strips {
        for samples in [&mut strip.samples_before, &mut strip.samples_after] {
            *samples = extremes(samples, stretch);
        }
    }
    Cow::Owned(answer)
}

/// The lowest and the highest of each `stretch` of points, in order; a gap stays a gap.
fn extremes(points: &[[f64; 2]], stretch: usize) -> Vec<[f64; 2]> {
    let pick = |points: &[[f64; 2]]| {
        let known = || (0..points.len()).filter(|&i| points[i][1].is_finite());
        let value = |i: &usize| points[*i][1];
        let low = known().min_by(|a, b| value(a).total_cmp(&value(b)));
        let high = known().max_by(|a, b| value(a).total_cmp(&value(b)));
        match low.zip(high) {
            Some((low, high)) => vec![points[low.min(high)], points[low.max(high)]],
            None => vec![points[0]],
        }
    };
    points.chunks(stretch).flat_map(pick).collect()
}

#[cfg(test)]
mod tests {
    use super::super::thin::*;

    #[test]
    fn peaks_and_gaps_remain() {
        let mut points: Vec<[f64; 2]> = (0..1000).map(|i| [f64::from(i), 0.0]).collect();
        points[503][1] = 7.0;
        points[501][1] = -3.0;
        for point in &mut points[700..800] {
            point[1] = f64::NAN;
        }
        let thin = extremes(&points, 10);
        assert_eq!(thin.len(), 2 * 90 + 10);
        assert!(thin.contains(&[503.0, 7.0]) && thin.contains(&[501.0, -3.0]));
        assert!(thin.iter().any(|p| p[1].is_nan()));
        assert!(thin.is_sorted_by(|a, b| a[0] <= b[0]));
    }
}
