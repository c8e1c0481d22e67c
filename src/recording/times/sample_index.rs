//! Which tick of an even clock each row belongs to.

use std::ops::Range;

/// Rows numbered by the ticks of an even clock. After a gap the clock may have been stopped, so
/// that numbers begin again: a run.
#[derive(Debug)]
pub(in crate::recording) struct SampleIndex {
    /// Tick of each row within its run; `None` if each row is one tick and there is one run.
    ticks: Option<Vec<u32>>,
    /// First row of each run.
    starts: Vec<usize>,
    rows: usize,
}

impl SampleIndex {
    /// Each row is one tick.
    pub(in crate::recording) fn by_row(rows: usize) -> Self {
        Self {
            ticks: None,
            starts: vec![0],
            rows,
        }
    }

    /// Steps of `time` in whole intervals, so that lost rows count; steps of more than `gap`
    /// \[s\] begin a run. `median` is the median step \[s\]. `None` if the steps say no number
    /// of intervals.
    pub(in crate::recording) fn by_steps(time: &[f64], median: f64, gap: f64) -> Option<Self> {
        let steps = || time.windows(2).map(|w| w[1] - w[0]);
        // The median of rounded times is a rounded interval; a mean is not.
        let (count, all) = steps()
            .filter(|s| (0.5 * median..1.5 * median).contains(s))
            .fold((0usize, 0.0), |(n, sum), s| (n + 1, sum + s));
        let interval = all / count as f64;
        if !(interval.is_finite() && interval > 0.0) {
            return None;
        }
        let mut ticks = Vec::with_capacity(time.len());
        let mut starts = vec![0];
        let mut tick = 0u32;
        ticks.push(tick);
        for (i, step) in steps().enumerate() {
            if step > gap {
                starts.push(i + 1);
                tick = 0;
            } else {
                tick = tick.checked_add(((step / interval).round() as u32).max(1))?;
            }
            ticks.push(tick);
        }
        Some(Self {
            ticks: Some(ticks),
            starts,
            rows: time.len(),
        })
    }

    /// Whether each row is one tick and there is one run.
    pub(in crate::recording) fn counts_rows(&self) -> bool {
        let ticks = |ticks: &Vec<u32>| ticks.iter().enumerate().all(|(i, t)| *t as usize == i);
        self.starts.len() == 1 && self.ticks.as_ref().is_none_or(ticks)
    }

    /// The rows of each run.
    pub(in crate::recording) fn runs(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        let ends = self.starts.iter().skip(1).copied().chain([self.rows]);
        self.starts.iter().zip(ends).map(|(start, end)| *start..end)
    }

    /// Tick of a row in its run.
    #[inline]
    pub(in crate::recording) fn tick(&self, row: usize) -> u64 {
        match &self.ticks {
            Some(ticks) => u64::from(ticks[row]),
            None => row as u64,
        }
    }

    /// Mean interval over all runs \[s\]: time inside them over their ticks.
    pub(in crate::recording) fn mean_interval(&self, time: &[f64]) -> f64 {
        let (span, ticks) = self.runs().fold((0.0, 0.0), |(span, ticks), run| {
            let last = run.end - 1;
            (
                span + (time[last] - time[run.start]),
                ticks + self.tick(last) as f64,
            )
        });
        span / ticks
    }
}
