//! Times that are those of an even clock but for the rounding of their digits.
//!
//! The clock is a line `a + k dt` through the intervals that the rounding leaves for each time.
//! Whether there is one is decided exactly: for each slope the intercepts that are left are the
//! space between the upper hull of the lower ends and the lower hull of the upper ends, and that
//! space is a concave function of the slope (J. O'Rourke, Comm. ACM 24, 1981).

use super::rounding::{Precision, Printed, Rounding};
use super::sample_index::SampleIndex;
use super::short_number::Interval;

/// Fewest rows from which a clock is inferred. Below, chance may put rounded times on a line.
const MIN_CLOCK_ROWS: usize = 16;
/// A change of a time by less than this share of the sampling interval is no change: between samples
/// a reading moves ten thousand times as much, more than a 12-bit recorder resolves.
pub(super) const NEGLIGIBLE_CHANGE_SHARE: f64 = 1e-4;
/// Largest relative uncertainty of the interval with which a line is the clock: digits that leave
/// more prove nothing.
const MAX_INTERVAL_UNCERTAINTY: f64 = 0.01;
/// Corners of all hulls above which the search is given up, so that work stays bounded. Rounded
/// even times have some hundreds.
const MAX_HULL_CORNERS: usize = 400_000;
/// Halvings of an interval of slopes: to the last bit of an `f64`.
const SLOPE_HALVINGS: usize = 60;

/// Even times in place of those in the file.
#[derive(Debug, Clone)]
pub(in crate::recording) struct EvenTimes {
    /// The times \[s\], counted like those in the file.
    pub time: Vec<f64>,
    /// What was added to the first time of the file \[s\]; all of `time` is counted from there.
    pub first_shift: f64,
    /// The sampling interval \[s\].
    pub interval: f64,
    /// Rows whose time changes by more than [`NEGLIGIBLE_CHANGE_SHARE`].
    pub changed: usize,
    /// The first of them.
    pub first_changed: usize,
    /// Largest change of a time \[s\].
    pub largest_change: f64,
}

/// What the times say of the clock.
#[derive(Debug, Clone)]
pub(in crate::recording) enum Evenness {
    /// The times are those of an even clock as they stand.
    Even,
    /// They are within the rounding.
    Rounded(EvenTimes, Precision),
    /// They are not.
    Uneven,
}

/// Judges times \[s\] that do not decrease. `start` is the instant in the file of `time` = 0
/// \[s\]: what was stored in single precision may be the sum.
pub(in crate::recording) fn even_grid(
    time: &[f64],
    start: f64,
    printed: Printed,
    index: &SampleIndex,
) -> Evenness {
    let (Some(first), Some(last)) = (time.first(), time.last()) else {
        return Evenness::Uneven;
    };
    let mean = index.mean_interval(time);
    if !(mean > 0.0 && mean.is_finite()) {
        return Evenness::Uneven;
    }
    let even = |i: usize| (time[i] - first - index.tick(i) as f64 * mean).abs();
    if index.counts_rows() && (0..time.len()).all(|i| even(i) <= NEGLIGIBLE_CHANGE_SHARE * mean) {
        return Evenness::Even;
    }
    if time.len() < MIN_CLOCK_ROWS {
        return Evenness::Uneven;
    }
    let largest = first.abs().max(last.abs());
    // A line between ends that are each within their rounding.
    let furthest = index
        .runs()
        .flat_map(|run| {
            let begin = time[run.start];
            run.map(move |i| (time[i] - begin - index.tick(i) as f64 * mean).abs())
        })
        .fold(0.0, f64::max);
    let hypotheses = [
        (Precision::Digits, 0.0),
        (Precision::Single, 0.0),
        (Precision::Single, start),
    ];
    let different = if start == 0.0 { 2 } else { 3 };
    for (precision, from) in hypotheses.into_iter().take(different) {
        let rounding = Rounding::new(precision, from, printed, largest, start);
        // With one run the mean line is off by at most the rounding of its ends.
        let widest = rounding.half_width(*first).max(rounding.half_width(*last));
        if index.counts_rows() && furthest > 2.001 * widest {
            continue;
        }
        let Some(times) = Clock::search(time, index, mean, &|i| rounding.half_width(time[i]))
        else {
            continue;
        };
        if !rounding.explains(time) {
            continue;
        }
        return if times.largest_change <= NEGLIGIBLE_CHANGE_SHARE * times.interval {
            Evenness::Even
        } else {
            Evenness::Rounded(times, precision)
        };
    }
    Evenness::Uneven
}

/// A corner of a hull: tick, and distance from the mean line \[s\].
type Corner = (f64, f64);

/// The intercepts that the rounding leaves in one run.
struct Corridor {
    rows: std::ops::Range<usize>,
    /// Lower hull of the upper ends.
    upper: Vec<Corner>,
    /// Upper hull of the lower ends.
    lower: Vec<Corner>,
}

impl Corridor {
    /// The intercepts `(least, largest)` \[s\] at a slope that is `slope` above the mean \[s\]; none are
    /// left if the first is the larger.
    fn intercepts(&self, slope: f64) -> (f64, f64) {
        let at = |(tick, distance): &Corner| distance - slope * tick;
        let lowest = self.lower.iter().map(at).fold(f64::NEG_INFINITY, f64::max);
        let highest = self.upper.iter().map(at).fold(f64::INFINITY, f64::min);
        (lowest, highest)
    }
}

/// Puts `corner` on a hull whose corners turn one way: `side` is 1 for a lower hull, -1 for an
/// upper one.
fn push_corner(hull: &mut Vec<Corner>, corner: Corner, side: f64) {
    while let [.., a, b] = hull[..] {
        let turn = (b.0 - a.0) * (corner.1 - a.1) - (b.1 - a.1) * (corner.0 - a.0);
        if side * turn > 0.0 {
            break;
        }
        hull.pop();
    }
    hull.push(corner);
}

/// The search for an even clock.
struct Clock {
    corridors: Vec<Corridor>,
}

impl Clock {
    /// Even times through all rounding intervals, if there are any.
    fn search(
        time: &[f64],
        index: &SampleIndex,
        mean: f64,
        half_width: &dyn Fn(usize) -> f64,
    ) -> Option<EvenTimes> {
        let mut corners = 0;
        let mut corridors = Vec::new();
        let (mut widest, mut longest) = (0.0f64, 1.0f64);
        for rows in index.runs() {
            let begin = time[rows.start];
            let (mut upper, mut lower) = (Vec::new(), Vec::new());
            for i in rows.clone() {
                let tick = index.tick(i) as f64;
                let distance = (-tick).mul_add(mean, time[i] - begin);
                let half = half_width(i);
                widest = widest.max(half);
                longest = longest.max(tick);
                push_corner(&mut upper, (tick, distance + half), 1.0);
                push_corner(&mut lower, (tick, distance - half), -1.0);
            }
            corners += upper.len() + lower.len();
            if corners > MAX_HULL_CORNERS {
                return None;
            }
            corridors.push(Corridor { rows, upper, lower });
        }
        let clock = Self { corridors };
        let (low, high) = clock.slopes(widest, longest)?;
        let (low, high) = (mean + low, mean + high);
        if !(low > 0.0 && high - low <= MAX_INTERVAL_UNCERTAINTY * low) {
            return None;
        }
        clock.times(time, index, mean, Interval::within(low, high))
    }

    /// Space that a slope leaves in the narrowest corridor \[s\]; negative if it leaves none.
    fn space(&self, slope: f64) -> f64 {
        let space = |corridor: &Corridor| {
            let (low, high) = corridor.intercepts(slope);
            high - low
        };
        self.corridors
            .iter()
            .map(space)
            .fold(f64::INFINITY, f64::min)
    }

    /// All slopes above the mean that leave space \[s\], from the least to the largest. `widest` is
    /// the largest half of a rounding interval, `longest` the ticks of the longest run.
    fn slopes(&self, widest: f64, longest: f64) -> Option<(f64, f64)> {
        // In the longest run a line within the rounding is this near to that of its ends.
        let run = self.corridors.iter().max_by(|a, b| {
            let ticks = |c: &Corridor| c.upper.last().map_or(0.0, |corner| corner.0);
            ticks(a).total_cmp(&ticks(b))
        })?;
        let last = run.upper.last()?;
        let near = (last.1 - widest) / longest;
        let reach = 4.0 * widest / longest;
        let (mut low, mut high) = (near - reach, near + reach);
        // Concave: the third that is lower does not hold the top.
        for _ in 0..3 * SLOPE_HALVINGS {
            let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            let (at_a, at_b) = (self.space(a), self.space(b));
            if at_a >= 0.0 || at_b >= 0.0 {
                let inside = if at_a >= at_b { a } else { b };
                let edge = |outside: f64| self.edge(inside, outside);
                return Some((edge(near - reach), edge(near + reach)));
            }
            if at_a < at_b {
                low = a;
            } else {
                high = b;
            }
        }
        None
    }

    /// The last slope that leaves space between `inside`, which does, and `outside`.
    fn edge(&self, mut inside: f64, mut outside: f64) -> f64 {
        for _ in 0..SLOPE_HALVINGS {
            let middle = 0.5 * (inside + outside);
            if self.space(middle) >= 0.0 {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        inside
    }

    /// The times of the clock. Where the rounding leaves a choice of the first instant of a run, it
    /// is the one in the file, or the nearest to it.
    fn times(
        &self,
        time: &[f64],
        index: &SampleIndex,
        mean: f64,
        interval: Interval,
    ) -> Option<EvenTimes> {
        let seconds = interval.seconds();
        let first = *time.first()?;
        let mut builder = Builder::new(time, seconds);
        for corridor in &self.corridors {
            let (low, high) = corridor.intercepts(seconds - mean);
            let shift = if low <= high {
                0.0f64.clamp(low, high)
            } else {
                0.5 * (low + high)
            };
            let begin = time[corridor.rows.start] - first;
            for i in corridor.rows.clone() {
                builder.push(begin, shift, interval.times(index.tick(i)));
            }
        }
        builder.finish()
    }
}

/// Even times, as they are compared with those of the file one after the other.
pub(super) struct Builder<'a> {
    from: &'a [f64],
    negligible: f64,
    first_shift: Option<f64>,
    times: EvenTimes,
}

impl<'a> Builder<'a> {
    /// For times that replace `from`, every `interval` \[s\].
    pub(super) fn new(from: &'a [f64], interval: f64) -> Self {
        Self {
            from,
            negligible: NEGLIGIBLE_CHANGE_SHARE * interval,
            first_shift: None,
            times: EvenTimes {
                time: Vec::with_capacity(from.len()),
                first_shift: 0.0,
                interval,
                changed: 0,
                first_changed: 0,
                largest_change: 0.0,
            },
        }
    }

    /// The next time: of a run that begins `begin` after the first row by the file, and `shift`
    /// later by the clock, after `elapsed` \[s\].
    pub(super) fn push(&mut self, begin: f64, shift: f64, elapsed: f64) {
        let first_shift = *self.first_shift.get_or_insert(shift);
        let times = &mut self.times;
        let row = times.time.len();
        // The first run adds nothing to whole intervals, so that they are rounded once.
        let new = self.from[0] + ((begin + (shift - first_shift)) + elapsed);
        let change = (new + first_shift - self.from[row]).abs();
        if change > self.negligible {
            if times.changed == 0 {
                times.first_changed = row;
            }
            times.changed += 1;
        }
        times.largest_change = times.largest_change.max(change);
        times.time.push(new);
    }

    /// The times, if they increase.
    pub(super) fn finish(mut self) -> Option<EvenTimes> {
        self.times.first_shift = self.first_shift.unwrap_or(0.0);
        let increasing = self.times.time.windows(2).all(|w| w[1] > w[0]);
        increasing.then_some(self.times)
    }
}
