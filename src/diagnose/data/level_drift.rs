//! A drift of the sensor's zero as shown by the level of the ground: the law `a (1 - exp(-t/tau))
//! + b t` with the fewest terms that describes it.

use nalgebra::{DMatrix, DVector};

use crate::diagnose::thresholds::{
    COMMON_DRIFT_MAX_MISS, DRIFT_LAW_MAX_MISS, LARGE_DRIFT_NOISE_UNITS,
};
use crate::model::effects::{ActiveEffect, EffectSpec, own_ids, zero_course};
use crate::recording::extremes;
use crate::recording::level_change::LevelDrift;

/// Times at which a drift is sampled.
const COURSE_SAMPLES: usize = 60;
/// Shortest and longest time constants that are tried, as shares of the longest recording, and
/// their number.
const TIME_CONSTANT_GRID: (f64, f64, usize) = (0.02, 5.0, 120);

/// A drift that began more than this many recording lengths ago is indistinguishable from a line.
const MAX_START_IN_LENGTHS: f64 = 3.0;

/// Parameters `a`, `tau`, `b` of the law `a (1 - exp(-t/tau)) + b t`, and its rms error \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
struct Law {
    values: [f64; 3],
    off: f64,
}

/// A sampled drift: times \[s\] and levels \[m\].
type Course = Vec<(f64, f64)>;

/// The drift that `drifts` of the level show, with the ids of its fitted parameters. `None` if it
/// is too small to mislead a fit without it; smaller drifts are found from such a fit. The noise
/// of a sample \[m\] is given for the finest and the coarsest recording.
pub fn drift_from_levels(
    drifts: &[LevelDrift],
    (finest, coarsest): (f64, f64),
) -> Option<(ActiveEffect, Vec<String>)> {
    let spec = zero_course()?;
    let courses: Vec<Course> = drifts.iter().map(sample_course).collect();
    let range = |course: &Course| {
        let levels: Vec<f64> = course.iter().map(|c| c.1).collect();
        let (low, high) = extremes(&levels);
        high - low
    };
    let most = courses.iter().map(range).fold(0.0, f64::max);
    if most < LARGE_DRIFT_NOISE_UNITS * coarsest {
        return None;
    }
    let (law, free) = simplest_law(&courses, finest)?;
    if law.off > COMMON_DRIFT_MAX_MISS * most {
        return None;
    }
    let effect = ActiveEffect {
        spec,
        values: law.values.to_vec(),
    };
    log::debug!("read from the level: {:?}", effect.values);
    Some((effect, own_ids(spec, free)))
}

/// Ids of parameters that a drift may have besides those fitted in it: a constant rate, where it
/// only settles.
pub fn shape_parameters(spec: &EffectSpec, free: &[String]) -> Vec<String> {
    if free.len() == 2 {
        own_ids(spec, &[2])
    } else {
        Vec::new()
    }
}

/// Samples a drift from the first contact that shows it to the last.
fn sample_course(drift: &LevelDrift) -> Course {
    let (begin, end) = drift.shown();
    let at = |i: usize| {
        let t = begin + (end - begin) * i as f64 / (COURSE_SAMPLES - 1) as f64;
        (t, drift.rise_at(t))
    };
    (0..COURSE_SAMPLES).map(at).collect()
}

/// The law with the fewest terms whose error is small in all courses, and the indices of its
/// parameters.
fn simplest_law(courses: &[Course], noise: f64) -> Option<(Law, &'static [usize])> {
    let times = |course: &Course| (course[0].0, course[course.len() - 1].0);
    let length = courses.iter().map(times).map(|(from, to)| to - from);
    let longest = length.fold(0.0, f64::max);
    // The law's time starts at zero.
    let mut since = courses.iter().map(|c| times(c).0);
    let long_ago = |t: f64| !(0.0..MAX_START_IN_LENGTHS * longest).contains(&t);
    let tau = |i: usize| {
        let (low, high, count) = TIME_CONSTANT_GRID;
        longest * low * (high / low).powf(i as f64 / (count - 1) as f64)
    };
    let best = |laws: &mut dyn Iterator<Item = Law>| laws.min_by(|a, b| a.off.total_cmp(&b.off));
    let line = fit_law(courses, longest, (false, true))?;
    if line.off < DRIFT_LAW_MAX_MISS * noise || since.any(long_ago) {
        return Some((line, &[2]));
    }
    let settling = best(
        &mut (0..TIME_CONSTANT_GRID.2).filter_map(|i| fit_law(courses, tau(i), (true, false))),
    )?;
    let both = best(
        &mut (0..TIME_CONSTANT_GRID.2).filter_map(|i| fit_law(courses, tau(i), (true, true))),
    )?;
    Some(if settling.off < DRIFT_LAW_MAX_MISS * noise {
        (settling, &[0, 1])
    } else {
        (both, &[0, 1, 2])
    })
}

/// The least-squares law for a given time constant, with either or both of its terms. Each course
/// has a level of its own.
fn fit_law(courses: &[Course], tau: f64, (settles, steady): (bool, bool)) -> Option<Law> {
    let parts = |t: f64| [-(-t / tau).exp_m1(), t];
    let mut rows = Vec::new();
    for course in courses {
        let n = course.len() as f64;
        let mean = |f: &dyn Fn(&(f64, f64)) -> f64| course.iter().map(f).sum::<f64>() / n;
        let (a, b) = (mean(&|c| parts(c.0)[0]), mean(&|c| parts(c.0)[1]));
        let level = mean(&|c| c.1);
        rows.extend(course.iter().map(|(t, x)| {
            let [own_a, own_b] = parts(*t);
            ([own_a - a, own_b - b], x - level)
        }));
    }
    let which: &[usize] = match (settles, steady) {
        (true, true) => &[0, 1],
        (true, false) => &[0],
        _ => &[1],
    };
    let matrix = DMatrix::from_fn(rows.len(), which.len(), |i, k| rows[i].0[which[k]]);
    let levels = DVector::from_fn(rows.len(), |i, _| rows[i].1);
    let found = (matrix.transpose() * &matrix)
        .cholesky()?
        .solve(&(matrix.transpose() * &levels));
    let off = (&matrix * &found - levels).norm() / (rows.len() as f64).sqrt();
    let mut values = [0.0, tau, 0.0];
    for (k, &i) in which.iter().enumerate() {
        values[2 * i] = found[k];
    }
    off.is_finite().then_some(Law { values, off })
}

#[cfg(test)]
mod tests {
    use super::super::level_drift::*;

    fn courses(of: impl Fn(f64) -> f64) -> Vec<Course> {
        // A recording and a short one, with other zeros.
        let one = |end: f64, zero: f64| {
            let times = (1..=COURSE_SAMPLES).map(|i| end * i as f64 / COURSE_SAMPLES as f64);
            times.map(|t| (t, zero + of(t))).collect()
        };
        vec![one(0.4, 3e-6), one(0.05, -1e-6)]
    }

    #[test]
    fn the_law_has_no_more_terms_than_the_drift_shows() {
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 0.05;
        let (Law { values, .. }, free) = simplest_law(&courses(|t| -2e-5 * t), 2e-8).unwrap();
        assert!(free == [2] && near(values[2], -2e-5), "{values:?}");
        let settles = |t: f64| 4e-6 * (1.0 - (-t / 0.06).exp());
        let (Law { values, .. }, free) = simplest_law(&courses(settles), 2e-8).unwrap();
        assert!(free == [0, 1] && near(values[0], 4e-6), "{values:?}");
        assert!((values[1] / 0.06 - 1.0).abs() < 0.1, "{values:?}");
        let slows = |t: f64| 8e-6 * (t / 0.03).ln_1p();
        let (Law { values, .. }, free) = simplest_law(&courses(slows), 2e-8).unwrap();
        assert!(free == [0, 1, 2] && values[0] > 0.0 && values[2] > 0.0);
        assert_eq!(simplest_law(&[], 2e-8), None);
    }
}
