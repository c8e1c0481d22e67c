//! A voltage of straight lines: levels with edges, ramps, triangles, tables of few points.
//!
//! The samples are cut at jumps. Between them the longest runs that one line follows are found by
//! doubling; where two runs meet, the corner is the intersection of their lines.

use super::samples::Samples;

/// A jump is so much steeper than the intervals before and after it.
const JUMP_STEEPNESS: f64 = 4.0;
/// A jump is larger than this many times what the error of a sample explains.
const MIN_JUMP_REACHES: f64 = 1.5;
/// Fewest samples a line takes on average, or the samples are no lines.
const MIN_SAMPLES_PER_LINE: usize = 8;
/// Rounds in which corners and lines are improved in turn.
const CORNER_ROUNDS: usize = 8;
/// A change of all corners by less than this many sampling intervals ends them.
const CORNERS_CONVERGED: f64 = 1e-3;
/// Rounds after which spurious corners are no longer looked for.
const MERGE_ROUNDS: usize = 3;
/// A line with a slope of less than this many standard deviations is a level.
const FLAT_SIGMAS: f64 = 3.5;
/// Standard deviations between which each of thousands of corners lies.
pub const CORNER_SIGMAS: f64 = 5.5;

/// A straight line through samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Where `value` holds, the middle of its samples \[s\].
    pub at: f64,
    /// Voltage there \[V\].
    pub value: f64,
    /// Slope \[V/s\].
    pub slope: f64,
    /// Standard deviation of `value` \[V\]; half a step of a coarse digitiser on a level.
    pub value_sigma: f64,
    /// Standard deviation of `slope` \[V/s\].
    pub slope_sigma: f64,
}

impl Line {
    /// Voltage \[V\] at `t` \[s\].
    pub fn voltage(&self, t: f64) -> f64 {
        self.value + self.slope * (t - self.at)
    }

    /// Standard deviation \[V\] of the voltage at `t` \[s\].
    pub fn sigma(&self, t: f64) -> f64 {
        self.value_sigma.hypot(self.slope_sigma * (t - self.at))
    }
}

/// Where one line ends and the next begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Best time \[s\].
    pub time: f64,
    /// Earliest time \[s\].
    pub low: f64,
    /// Latest time \[s\].
    pub high: f64,
    /// Whether the voltage jumps there; else it has a corner.
    pub jumps: bool,
}

/// Lines joined at nodes, one line more than nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct Lines {
    /// The lines in order of time.
    pub lines: Vec<Line>,
    /// Where they meet, increasing in time.
    pub nodes: Vec<Node>,
}

/// Two neighbouring samples, or three, between which the voltage jumps.
#[derive(Debug, Clone, Copy)]
struct Jump {
    /// Last sample before.
    last: usize,
    /// First sample after.
    first: usize,
}

/// The lines that `samples` follow; `None` if they are not lines.
pub fn find_lines(samples: &Samples<'_>) -> Option<Lines> {
    let most = samples.len() / MIN_SAMPLES_PER_LINE + 1;
    let jumps = find_jumps(samples);
    if jumps.len() > most {
        return None;
    }
    let mut found = Lines {
        lines: Vec::new(),
        nodes: Vec::new(),
    };
    let mut from = 0;
    for k in 0..=jumps.len() {
        let end = jumps.get(k).map_or(samples.len(), |j| j.last + 1);
        let (lines, corners) = lines_of(samples, from, end, most)?;
        found.nodes.extend(corners);
        found.lines.extend(lines);
        if found.lines.len() > most {
            return None;
        }
        if let Some(jump) = jumps.get(k) {
            // The level after the jump is known only from what follows.
            found.nodes.push(jump.node(samples));
            from = jump.first;
        }
    }
    refine_double_jumps(samples, &jumps, &mut found);
    samples.are(cursor(&found)).then_some(found)
}

/// The voltage of `lines`, fast for times in increasing order.
pub fn cursor(lines: &Lines) -> impl Fn(f64) -> f64 {
    let at = std::cell::Cell::new(0usize);
    move |t| {
        let mut i = at.get();
        if i > 0 && lines.nodes[i - 1].time > t {
            i = 0;
        }
        while lines.nodes.get(i).is_some_and(|node| node.time <= t) {
            i += 1;
        }
        at.set(i);
        lines.lines[i].voltage(t)
    }
}

fn find_jumps(samples: &Samples<'_>) -> Vec<Jump> {
    let (v, n) = (samples.volts, samples.len());
    let least = MIN_JUMP_REACHES * 2.0 * samples.reach();
    let rise = |i: isize| {
        if i < 0 || i + 1 >= n as isize {
            // Nothing tells a jump at the end of the samples from the start of a ramp.
            f64::INFINITY
        } else {
            v[i as usize + 1] - v[i as usize]
        }
    };
    let steep = |whole: f64, before: f64, after: f64| {
        // The neighbours' noise must not make a steep slope a jump.
        whole.abs() > least + JUMP_STEEPNESS * before.abs().max(after.abs())
    };
    let mut jumps = Vec::new();
    let mut i = 0;
    while i + 1 < n {
        let k = i as isize;
        let one = rise(k);
        if one.abs() > 0.3 * least {
            if steep(one, rise(k - 1), rise(k + 1)) {
                jumps.push(Jump {
                    last: i,
                    first: i + 1,
                });
                i += 1;
                continue;
            }
            // A sample that was taken during the jump.
            let two = one + rise(k + 1);
            if i + 2 < n && one * rise(k + 1) > 0.0 && steep(two, rise(k - 1), rise(k + 2)) {
                jumps.push(Jump {
                    last: i,
                    first: i + 2,
                });
                i += 2;
                continue;
            }
        }
        i += 1;
    }
    jumps
}

impl Jump {
    fn node(&self, samples: &Samples<'_>) -> Node {
        let (low, high) = (samples.time[self.last], samples.time[self.first]);
        Node {
            time: 0.5 * (low + high),
            low,
            high,
            jumps: true,
        }
    }
}

/// A sample taken during a jump tells where between its neighbours it was: an averaging digitiser
/// weighs the levels before and after, a fast ramp is half way at its middle.
fn refine_double_jumps(samples: &Samples<'_>, jumps: &[Jump], found: &mut Lines) {
    let mut of_jump = jumps.iter();
    for k in 0..found.nodes.len() {
        if !found.nodes[k].jumps {
            continue;
        }
        let Some(jump) = of_jump.next() else { return };
        if jump.first == jump.last + 2 {
            let t = samples.time[jump.last + 1];
            let before = found.lines[k].voltage(t);
            let after = found.lines[k + 1].voltage(t);
            let share = ((after - samples.volts[jump.last + 1]) / (after - before)).clamp(0.0, 1.0);
            let node = &mut found.nodes[k];
            node.time = t + (share - 0.5) * 0.5 * (node.high - node.low);
        }
    }
}

/// The lines of the samples `from..end` without jumps, and the corners between them. `None` beyond
/// `most` lines.
fn lines_of(
    samples: &Samples<'_>,
    from: usize,
    end: usize,
    most: usize,
) -> Option<(Vec<Line>, Vec<Node>)> {
    let mut starts = vec![from];
    let mut at = from;
    loop {
        let to = longest_line(samples, at, end);
        if to >= end {
            break;
        }
        starts.push(to);
        at = to;
        if starts.len() > most {
            return None;
        }
    }
    // Corners as boundaries in time, improved by the lines beside them.
    let interval = samples.interval;
    let mut corners: Vec<f64> = starts[1..]
        .iter()
        .map(|&i| samples.time[i] - 0.5 * interval)
        .collect();
    let mut lines = Vec::new();
    for round in 0..CORNER_ROUNDS {
        lines = between(samples, from, end, &corners);
        if round < MERGE_ROUNDS {
            merge(samples, from, end, &mut corners, &mut lines);
        }
        let mut moved = 0.0f64;
        for k in 0..corners.len() {
            let (a, b) = (&lines[k], &lines[k + 1]);
            let turn = a.slope - b.slope;
            let meet = a.at + (b.value - a.value - b.slope * (b.at - a.at)) / turn;
            let low = if k == 0 {
                samples.time[from]
            } else {
                corners[k - 1]
            };
            let high = corners.get(k + 1).copied().unwrap_or(samples.time[end - 1]);
            if meet.is_finite() && meet > low && meet < high {
                moved = moved.max((corners[k] - meet).abs());
                corners[k] = meet;
            }
        }
        if round >= MERGE_ROUNDS && moved < CORNERS_CONVERGED * interval {
            break;
        }
    }
    let nodes = corners
        .iter()
        .enumerate()
        .map(|(k, &time)| {
            let (a, b) = (&lines[k], &lines[k + 1]);
            let turn = (a.slope - b.slope).abs();
            let sigma = a.sigma(time).hypot(b.sigma(time)) / turn;
            // Two levels do not intersect: they meet where the runs of samples do.
            let reach = if sigma.is_finite() {
                (CORNER_SIGMAS * sigma).max(1e-12)
            } else {
                2.0 * interval
            };
            Node {
                time,
                low: time - reach,
                high: time + reach,
                jumps: false,
            }
        })
        .collect();
    Some((lines, nodes))
}

/// Removes corners across which one line follows the samples of both.
fn merge(
    samples: &Samples<'_>,
    from: usize,
    end: usize,
    corners: &mut Vec<f64>,
    lines: &mut Vec<Line>,
) {
    let mut k = 0;
    let index = |t: f64| samples.time.partition_point(|&s| s < t).clamp(from, end);
    while k < corners.len() {
        let a = if k == 0 { from } else { index(corners[k - 1]) };
        let b = corners.get(k + 1).map_or(end, |&t| index(t));
        if b <= a + 2 {
            k += 1;
            continue;
        }
        let one = line_through(samples, a, b);
        if samples.part(a, b).are(|t| one.voltage(t)) {
            corners.remove(k);
            lines[k] = one;
            lines.remove(k + 1);
        } else {
            k += 1;
        }
    }
}

/// The line of each stretch between corners, from the samples clearly inside.
fn between(samples: &Samples<'_>, from: usize, end: usize, corners: &[f64]) -> Vec<Line> {
    let index = |t: f64| samples.time.partition_point(|&s| s < t).clamp(from, end);
    (0..=corners.len())
        .map(|k| {
            let mut a = if k == 0 { from } else { index(corners[k - 1]) };
            let mut b = corners.get(k).map_or(end, |&t| index(t));
            // The samples next to a corner may be on its other side.
            if b > a + 6 {
                a += usize::from(k > 0);
                b -= usize::from(k < corners.len());
            }
            if b < a + 2 {
                a = a.min(end.saturating_sub(2).max(from));
                b = (a + 2).min(end);
            }
            line_through(samples, a, b)
        })
        .collect()
}

/// The end (excluded) of the longest run from `from` on, below `end`, that one line follows.
fn longest_line(samples: &Samples<'_>, from: usize, end: usize) -> usize {
    let follows = |to: usize| {
        let line = line_through(samples, from, to);
        let reach = samples.reach();
        (from..to).all(|i| (samples.volts[i] - line.voltage(samples.time[i])).abs() <= reach)
    };
    let mut good = (from + 2).min(end);
    let mut size = 4;
    let mut bad = loop {
        let to = (from + size).min(end);
        if to <= good {
            return end;
        }
        if !follows(to) {
            break to;
        }
        good = to;
        size *= 2;
    };
    while bad > good + 1 {
        let middle = good + (bad - good) / 2;
        if follows(middle) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    good
}

/// The line of least squares through the samples `from..to`; a level if it does not rise.
pub fn line_through(samples: &Samples<'_>, from: usize, to: usize) -> Line {
    let (time, volts) = (&samples.time[from..to], &samples.volts[from..to]);
    let n = time.len() as f64;
    let (t0, v0) = (time[0], volts[0]);
    let (mut st, mut sv) = (0.0, 0.0);
    for (t, v) in time.iter().zip(volts) {
        st += t - t0;
        sv += v - v0;
    }
    let (mt, mv) = (st / n, sv / n);
    let (mut tt, mut tv) = (0.0, 0.0);
    for (t, v) in time.iter().zip(volts) {
        let u = t - t0 - mt;
        tt += u * u;
        tv += u * (v - v0 - mv);
    }
    let slope_sigma = if tt > 0.0 {
        samples.sigma / tt.sqrt()
    } else {
        f64::INFINITY
    };
    let slope = if tt > 0.0 { tv / tt } else { 0.0 };
    let level = slope.abs() <= FLAT_SIGMAS * slope_sigma
        || slope.abs() * (time[time.len() - 1] - t0) < 0.5 * samples.quantum;
    let mut value_sigma = samples.sigma / n.sqrt();
    if level && samples.quantum > 0.0 {
        value_sigma = value_sigma.max(samples.quantum / 12f64.sqrt());
    }
    Line {
        at: t0 + mt,
        value: v0 + mv,
        slope: if level { 0.0 } else { slope },
        value_sigma,
        slope_sigma: if level { 0.0 } else { slope_sigma },
    }
}

/// The ranges of samples between jumps.
pub fn jump_blocks(samples: &Samples<'_>) -> Vec<std::ops::Range<usize>> {
    let mut from = 0;
    let mut blocks = Vec::new();
    for jump in find_jumps(samples) {
        blocks.push(from..jump.last + 1);
        from = jump.first;
    }
    blocks.push(from..samples.len());
    blocks
}
