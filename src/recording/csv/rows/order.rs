//! The order of rows in time: newest first, counters that begin again, a clock that was started again,
//! rows that stand elsewhere.

use std::ops::Range;

use crate::recording::median_interval;

/// Fewest rows of a recording that stands before or after another one in a file.
const MIN_TRIAL_ROWS: usize = 8;
/// A clock that falls back to within this share of what it had counted was started again.
const RESTART_SHARE: f64 = 0.1;
/// Share of the steps that go back where the rows are newest first.
const MIN_REVERSED_SHARE: f64 = 0.9;
/// Counts at which counters begin again, as powers of two.
const COUNTER_BITS: [i32; 7] = [8, 10, 12, 16, 24, 31, 32];
/// How near the time after a change of its unit is to the one expected, as a share of it.
const UNIT_CHANGE_TOLERANCE: f64 = 0.02;

/// What the order of the rows shows.
#[derive(Debug, Clone, Default, PartialEq)]
pub(in crate::recording::csv) struct Order {
    /// Whether the rows are newest first.
    pub reversed: bool,
    /// Rows at which a counter begins again, with its period \[s\].
    pub wraps: Vec<(usize, f64)>,
    /// Rows of each recording; one if the clock was not started again.
    pub parts: Vec<Range<usize>>,
    /// First row in another unit of time.
    pub unit_change: Option<usize>,
}

/// How times count.
#[derive(Debug, Clone, Copy)]
pub(in crate::recording::csv) struct Counting {
    /// The instant in the file of time 0 \[s\].
    pub origin: f64,
    /// The file's unit \[s\].
    pub unit: f64,
    /// Whether it is a clock of the day.
    pub is_clock: bool,
}

/// Looks at times \[s\]; NaN where there is none.
pub(in crate::recording::csv) fn analyse(time: &[f64], counting: Counting) -> Order {
    let mut order = Order {
        parts: std::iter::once(0..time.len()).collect(),
        ..Order::default()
    };
    if time.windows(2).all(|w| w[1] > w[0]) {
        return order;
    }
    let rows: Vec<usize> = (0..time.len()).filter(|i| time[*i].is_finite()).collect();
    let known: Vec<f64> = rows.iter().map(|i| time[*i]).collect();
    let back = known.windows(2).filter(|w| w[1] < w[0]).count();
    if back == 0 || known.len() < 3 {
        return order;
    }
    if back as f64 >= MIN_REVERSED_SHARE * (known.len() - 1) as f64 {
        order.reversed = true;
        return order;
    }
    let forward: Vec<f64> = known
        .windows(2)
        .map(|w| w[1] - w[0])
        .filter(|s| *s > 0.0)
        .collect();
    let steps: Vec<f64> = forward
        .iter()
        .scan(0.0, |t, step| {
            *t += step;
            Some(*t)
        })
        .collect();
    let step = median_interval(&steps);
    let mut starts = vec![0usize];
    let mut added = 0.0;
    for k in 1..known.len() {
        let (before, now) = (known[k - 1], known[k]);
        if now >= before {
            continue;
        }
        if let Some(period) = wrap_period(before, now, step, counting) {
            order.wraps.push((rows[k], period));
            added += period;
            continue;
        }
        let begin = starts.last().copied().unwrap_or(0);
        let own_step = k.checked_sub(2).map_or(step, |i| before - known[i]);
        if changes_unit(before, now, own_step, counting) {
            order.unit_change.get_or_insert(rows[k]);
            continue;
        }
        let (elapsed, since) = (before - known[begin], now - known[begin]);
        let long = k - begin >= MIN_TRIAL_ROWS && added == 0.0;
        // One stamp that is too small is no new start: the next is where it was.
        let ahead = &known[k..(k + MIN_TRIAL_ROWS).min(known.len())];
        let goes_on = ahead.len() >= MIN_TRIAL_ROWS
            && ahead.iter().all(|t| *t < before + step)
            && ahead.windows(2).all(|w| w[1] >= w[0]);
        if long && goes_on && since.abs() <= RESTART_SHARE * elapsed {
            starts.push(k);
        }
    }
    if starts.len() > 1 {
        let first_rows: Vec<usize> = starts
            .iter()
            .map(|k| if *k == 0 { 0 } else { rows[*k] })
            .collect();
        let ends = first_rows.iter().skip(1).copied().chain([time.len()]);
        order.parts = first_rows
            .iter()
            .copied()
            .zip(ends)
            .map(|(a, b)| a..b)
            .collect();
    }
    order
}

/// The period of a counter that goes from `before` to `now` in about one `step`.
fn wrap_period(before: f64, now: f64, step: f64, counting: Counting) -> Option<f64> {
    let fall = before - now + step;
    let counters = COUNTER_BITS
        .iter()
        .map(|bits| 2f64.powi(*bits) * counting.unit);
    let days = counting.is_clock.then_some(86_400.0);
    let mut periods = counters.chain(days);
    // A counter is below its period everywhere.
    let (high, low) = (counting.origin + before, counting.origin + now);
    periods.find(|period| {
        (fall - period).abs() <= 2.0 * step
            && high < period + step
            && low < 0.1 * period
            && high > 0.9 * period
    })
}

/// Whether the number after `before` is the next time in a unit a thousand or a million times as large.
fn changes_unit(before: f64, now: f64, step: f64, counting: Counting) -> bool {
    let (before, now) = (counting.origin + before, counting.origin + now);
    let expected = before + step;
    now > 0.0
        && [1e3, 1e6]
            .iter()
            .any(|factor| (now * factor - expected).abs() <= UNIT_CHANGE_TOLERANCE * expected)
}

/// The rows in the order of their times, where some that do not follow the others lie between them;
/// with the number of rows that move. `None` if none does.
pub(in crate::recording::csv) fn sorted(time: &[f64]) -> Option<(Vec<usize>, usize)> {
    if time.windows(2).all(|w| w[1] >= w[0]) {
        return None;
    }
    let forward = crate::recording::assemble::forward_rows(time);
    let kept = || (0..time.len()).filter(|i| forward.keep[*i]);
    let (first, last) = (time[kept().next()?], time[kept().next_back()?]);
    // A row outside of the others is a wrong stamp, not a row that stands elsewhere.
    let known: Vec<f64> = kept().map(|i| time[i]).collect();
    let inside = |i: &usize| {
        let is_new = known.binary_search_by(|t| t.total_cmp(&time[*i])).is_err();
        time[*i] > first && time[*i] < last && is_new
    };
    let moved: Vec<usize> = (0..time.len())
        .filter(|i| !forward.keep[*i] && time[*i].is_finite())
        .filter(inside)
        .collect();
    if moved.is_empty() || 2 * moved.len() > time.len() {
        return None;
    }
    // The others stay behind the row that they follow, to be left out.
    let mut is_moved = vec![false; time.len()];
    moved.iter().for_each(|i| is_moved[*i] = true);
    let mut behind = f64::NEG_INFINITY;
    let key: Vec<(f64, bool)> = (0..time.len())
        .map(|i| {
            let stands = forward.keep[i];
            if stands {
                behind = time[i];
            }
            match stands || is_moved[i] {
                true => (time[i], false),
                false => (behind, true),
            }
        })
        .collect();
    let mut order: Vec<usize> = (0..time.len()).collect();
    order.sort_by(|a, b| {
        let ((t, other), (u, own)) = (key[*a], key[*b]);
        t.total_cmp(&u).then(other.cmp(&own)).then(a.cmp(b))
    });
    Some((order, moved.len()))
}

#[cfg(test)]
mod tests {
    use super::super::order::*;

    const PLAIN: Counting = Counting {
        origin: 0.0,
        unit: 1e-3,
        is_clock: false,
    };

    fn even(rows: usize) -> Vec<f64> {
        (0..rows).map(|i| i as f64 * 1e-3).collect()
    }

    #[test]
    fn newest_first_and_started_again() {
        let mut time = even(50);
        time.reverse();
        assert!(analyse(&time, PLAIN).reversed);
        let mut time = even(50);
        time.extend(even(40));
        assert_eq!(analyse(&time, PLAIN).parts, [0..50, 50..90]);
        // A header between the two, and one wrong stamp.
        let mut time = even(50);
        time[20] = 0.0;
        time.push(f64::NAN);
        time.extend(even(40));
        assert_eq!(analyse(&time, PLAIN).parts, [0..51, 51..91]);
        assert_eq!(analyse(&even(9), PLAIN).parts.len(), 1);
    }

    #[test]
    fn counters_begin_again() {
        let time: Vec<f64> = (0..100)
            .map(|i| f64::from((65_000 + 20 * i) % 65_536) * 1e-6)
            .collect();
        let counting = Counting {
            unit: 1e-6,
            ..PLAIN
        };
        let order = analyse(&time, counting);
        assert_eq!(order.wraps.len(), 1);
        assert!((order.wraps[0].1 - 65_536e-6).abs() < 1e-12);
        assert_eq!(order.parts.len(), 1);
        let midnight: Vec<f64> = (0..100)
            .map(|i| (86_399.0 + 0.1 * f64::from(i)) % 86_400.0)
            .collect();
        let counting = Counting {
            unit: 1.0,
            is_clock: true,
            ..PLAIN
        };
        assert_eq!(analyse(&midnight, counting).wraps, [(10, 86_400.0)]);
    }

    #[test]
    fn units_change_between_rows() {
        let time: Vec<f64> = (0..4)
            .map(|i| 0.25 * f64::from(i))
            .chain((4..40).map(|i| 0.25e-3 * f64::from(i)))
            .collect();
        assert_eq!(analyse(&time, PLAIN).unit_change, Some(4));
    }

    #[test]
    fn rows_that_stand_elsewhere_are_sorted_in() {
        let mut time = even(50);
        time[20..30].reverse();
        let (order, moved) = sorted(&time).unwrap();
        assert_eq!(moved, 9);
        assert!(order.windows(2).all(|w| time[w[1]] > time[w[0]]));
        // A wrong stamp stays where it is.
        let mut time = even(50);
        time[20] = 9.0;
        assert_eq!(sorted(&time), None);
    }
}
