//! Decimates long series for drawing. Levels of blocks of growing length hold the minimum
//! and maximum of every block. Drawing any part then costs its pixels, not its samples, and
//! no spike is lost.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::recording::{GAP_FACTOR, median_interval};

/// Samples in a block of the first level.
const BLOCK_SAMPLES: usize = 16;
/// Blocks of one level in a block of the next.
const BLOCKS_PER_LEVEL: usize = 8;
/// A point that breaks the line.
const LINE_BREAK: [f64; 2] = [f64::NAN, f64::NAN];

/// Least and greatest value of some samples; `low > high` if there is no number.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Extent {
    low: f64,
    high: f64,
}

impl Extent {
    const EMPTY: Self = Self {
        low: f64::INFINITY,
        high: f64::NEG_INFINITY,
    };

    /// Includes a sample; one that is not finite is ignored.
    fn add(&mut self, value: f64) {
        if value.abs() <= f64::MAX {
            self.low = if value < self.low { value } else { self.low };
            self.high = if value > self.high { value } else { self.high };
        }
    }

    fn merge(&mut self, other: Self) {
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
    }

    fn of(values: &[f64]) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for &value in values {
            // A comparison with NaN is false.
            low = if value < low { value } else { low };
            high = if value > high { value } else { high };
        }
        if low > f64::NEG_INFINITY && high < f64::INFINITY {
            return Self { low, high };
        }
        // Rare: the infinities are removed.
        let mut extent = Self::EMPTY;
        values.iter().for_each(|&value| extent.add(value));
        extent
    }

    fn union(blocks: &[Self]) -> Self {
        let mut extent = Self::EMPTY;
        blocks.iter().for_each(|&block| extent.merge(block));
        extent
    }

    fn known(self) -> Option<(f64, f64)> {
        (self.low <= self.high).then_some((self.low, self.high))
    }
}

/// The instants of the samples.
#[derive(Debug, Clone)]
enum Times {
    /// Sample `i` at `t0 + i dt`.
    Even { t0: f64, dt: f64 },
    /// The time of each sample, and the smallest step that breaks the line.
    Listed { times: Arc<[f64]>, gap: f64 },
}

/// A series with the extents of its blocks. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Pyramid {
    times: Times,
    values: Arc<[f64]>,
    levels: Arc<[Vec<Extent>]>,
}

impl Default for Pyramid {
    /// Without samples.
    fn default() -> Self {
        Self::new(0.0, 1.0, &[])
    }
}

impl Pyramid {
    /// The series `values[i]` at `t0 + i dt` \[s\]. NaN breaks the line. Without a positive `dt`
    /// only the first sample is used.
    pub fn new(t0: f64, dt: f64, values: &[f64]) -> Self {
        let usable = t0.is_finite() && dt.is_finite() && dt > 0.0;
        let (dt, count) = if usable {
            (dt, values.len())
        } else {
            (1.0, usize::from(t0.is_finite() && !values.is_empty()))
        };
        Self::build(Times::Even { t0, dt }, &values[..count])
    }

    /// The series `values[i]` at increasing `times[i]` \[s\], as long as the shorter of the
    /// two. The line is broken where samples are missing.
    pub fn xy(times: &[f64], values: &[f64]) -> Self {
        let count = times.len().min(values.len());
        let gap = GAP_FACTOR * median_interval(&times[..count]);
        let gap = if gap.is_finite() { gap } else { f64::INFINITY };
        Self::listed(times, values, gap)
    }

    /// The same for samples with nothing missing between them, however far apart.
    pub fn unbroken(times: &[f64], values: &[f64]) -> Self {
        Self::listed(times, values, f64::INFINITY)
    }

    fn listed(times: &[f64], values: &[f64], gap: f64) -> Self {
        let count = times.len().min(values.len());
        let times = Times::Listed {
            times: times[..count].into(),
            gap,
        };
        Self::build(times, &values[..count])
    }

    fn build(times: Times, values: &[f64]) -> Self {
        let mut levels: Vec<Vec<Extent>> = Vec::new();
        if values.len() > BLOCK_SAMPLES {
            // Each piece has a whole number of blocks and is long enough for a thread.
            let pieces = values.par_chunks(4096 * BLOCK_SAMPLES);
            levels.push(
                pieces
                    .flat_map_iter(|piece| piece.chunks(BLOCK_SAMPLES).map(Extent::of))
                    .collect(),
            );
        }
        while let Some(last) = levels.last().filter(|level| level.len() > BLOCKS_PER_LEVEL) {
            let next = last.chunks(BLOCKS_PER_LEVEL).map(Extent::union).collect();
            levels.push(next);
        }
        Self {
            times,
            values: values.into(),
            levels: levels.into(),
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Time of sample `i` \[s\]; past the end, that of the last sample.
    fn time(&self, i: usize) -> f64 {
        match &self.times {
            Times::Even { t0, dt } => t0 + i as f64 * dt,
            Times::Listed { times, .. } => {
                let last = times.len().saturating_sub(1);
                times.get(i.min(last)).copied().unwrap_or(f64::NAN)
            }
        }
    }

    /// First sample at or after `t` \[s\]; the number of samples if there is none.
    fn at_or_after(&self, t: f64) -> usize {
        match &self.times {
            Times::Even { t0, dt } => {
                // A small tolerance, because t0 + n dt is rarely exact in binary.
                let position = ((t - t0) / dt - 1e-9).ceil();
                (position.max(0.0) as usize).min(self.len())
            }
            Times::Listed { times, .. } => first_from(times, t),
        }
    }

    /// Whether the line is broken between samples `i` and `i + 1`.
    fn is_gap(&self, i: usize) -> bool {
        match &self.times {
            Times::Even { .. } => false,
            Times::Listed { gap, .. } => self.time(i + 1) - self.time(i) > *gap,
        }
    }

    /// First and last time \[s\].
    pub fn span(&self) -> Option<(f64, f64)> {
        let last = self.len().checked_sub(1)?;
        Some((self.time(0), self.time(last)))
    }

    /// Extent of the samples in `range`, in O(log n).
    fn extent(&self, range: Range<usize>) -> Extent {
        let Range { start, end } = range;
        let Some(first) = self.levels.first() else {
            return Extent::of(&self.values[start..end]);
        };
        if end - start <= 2 * BLOCK_SAMPLES {
            return Extent::of(&self.values[start..end]);
        }
        let (mut from, mut to) = (start.div_ceil(BLOCK_SAMPLES), end / BLOCK_SAMPLES);
        let mut extent = Extent::of(&self.values[start..from * BLOCK_SAMPLES]);
        extent.merge(Extent::of(&self.values[to * BLOCK_SAMPLES..end]));
        let mut level = first;
        for next in &self.levels[1..] {
            if to - from <= 2 * BLOCKS_PER_LEVEL {
                break;
            }
            let (inner_from, inner_to) = (from.div_ceil(BLOCKS_PER_LEVEL), to / BLOCKS_PER_LEVEL);
            extent.merge(Extent::union(&level[from..inner_from * BLOCKS_PER_LEVEL]));
            extent.merge(Extent::union(&level[inner_to * BLOCKS_PER_LEVEL..to]));
            (from, to, level) = (inner_from, inner_to, next);
        }
        extent.merge(Extent::union(&level[from..to]));
        extent
    }

    /// Value at `t` \[s\] by linear interpolation; `None` outside, in a gap or next to NaN.
    pub fn value_at(&self, t: f64) -> Option<f64> {
        let last = self.len().checked_sub(1)?;
        let after = self.at_or_after(t);
        if after > last || t.is_nan() {
            return None;
        }
        let right = self.values[after];
        let step = self.time(after) - t;
        if after == 0 || step <= 0.0 {
            // Before the first sample only within rounding.
            let near = step <= 1e-9 * (self.time(last) - self.time(0)).max(1e-9);
            return right.is_finite().then_some(right).filter(|_| near);
        }
        if self.is_gap(after - 1) {
            return None;
        }
        let left = self.values[after - 1];
        let whole = self.time(after) - self.time(after - 1);
        let value = right + (left - right) * (step / whole);
        value.is_finite().then_some(value)
    }

    /// Minimum and maximum of the line from `t_min` to `t_max` \[s\].
    pub fn value_range(&self, t_min: f64, t_max: f64) -> Option<(f64, f64)> {
        let from = self.at_or_after(t_min);
        let to = self.at_or_after(t_max).max(from);
        let mut extent = self.extent(from..to);
        for t in [t_min, t_max] {
            if let Some(value) = self.value_at(t) {
                extent.add(value);
            }
        }
        extent.known()
    }

    /// Minimum and maximum of all samples.
    pub fn extremes(&self) -> Option<(f64, f64)> {
        self.extent(0..self.len()).known()
    }

    /// The line from `t_min` to `t_max` \[s\] for `pixels` columns, as `[time, value]`. Few
    /// samples are given as they are; of many, each column has its first, minimum, maximum
    /// and last point. `[NaN, NaN]` breaks the line. One sample beyond each end is included,
    /// so that the line reaches the edge of the picture.
    pub fn draw(&self, t_min: f64, t_max: f64, pixels: usize) -> Vec<[f64; 2]> {
        let valid = t_min <= t_max && pixels > 0 && !self.is_empty();
        if !valid {
            return Vec::new();
        }
        let from = self.at_or_after(t_min).saturating_sub(1);
        let to = (self.at_or_after(t_max) + 1).min(self.len());
        if to <= from {
            return Vec::new();
        }
        let mut line = Line::default();
        if to - from <= 2 * pixels {
            for i in from..to {
                if i > from && self.is_gap(i - 1) {
                    line.stop();
                }
                line.point(self.time(i), self.values[i]);
            }
            return line.points;
        }
        let width = (t_max - t_min) / pixels as f64;
        let mut start = from;
        for column in 0..=pixels {
            // The last column includes samples beyond the end.
            let end = if column == pixels {
                to
            } else {
                self.at_or_after(t_min + (column + 1) as f64 * width)
                    .min(to)
            };
            if end <= start {
                continue;
            }
            if start > from && self.is_gap(start - 1) {
                line.stop();
            }
            self.column(start..end, &mut line);
            start = end;
        }
        line.points
    }

    fn column(&self, range: Range<usize>, line: &mut Line) {
        let (first, last) = (range.start, range.end - 1);
        let Some((low, high)) = self.extent(range).known() else {
            line.stop();
            return;
        };
        let (a, b) = (self.values[first], self.values[last]);
        let middle = 0.5 * (self.time(first) + self.time(last));
        let (early, late) = if a > b { (high, low) } else { (low, high) };
        if a.is_finite() {
            line.point(self.time(first), a);
        }
        for value in [early, late] {
            if value != a && value != b {
                line.point(middle, value);
            }
        }
        if b.is_finite() && last > first {
            line.point(self.time(last), b);
        }
    }
}

/// Index of the first of the increasing `times` at or after `t`; their number if there is
/// none. It first tries where the index would be for uniform times: a binary search through
/// a million times costs twenty cache misses for each column of a picture.
fn first_from(times: &[f64], t: f64) -> usize {
    let (Some(first), Some(last)) = (times.first(), times.last()) else {
        return 0;
    };
    if t.is_nan() || t <= *first {
        return 0;
    }
    if t > *last {
        return times.len();
    }
    let guess = ((t - first) / (last - first) * (times.len() - 1) as f64) as usize;
    let mut reach = 4;
    loop {
        let from = guess.saturating_sub(reach);
        let to = (guess + reach).min(times.len() - 1);
        if (from == 0 || times[from] < t) && times[to] >= t {
            return from + times[from..=to].partition_point(|&time| time < t);
        }
        reach *= 4;
    }
}

/// The points of a line so far, with breaks between them and never at an end.
#[derive(Default)]
struct Line {
    points: Vec<[f64; 2]>,
    broken: bool,
}

impl Line {
    fn stop(&mut self) {
        self.broken = !self.points.is_empty();
    }

    fn point(&mut self, time: f64, value: f64) {
        if !value.is_finite() {
            self.stop();
            return;
        }
        if std::mem::take(&mut self.broken) {
            self.points.push(LINE_BREAK);
        }
        self.points.push([time, value]);
    }
}
