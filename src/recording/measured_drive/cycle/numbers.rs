//! The free numbers of a cycle, and how its voltage depends on them.
//!
//! In this order: the time from one repetition to the next; the instant of each knot in a repetition
//! in the middle of the samples, where it hangs least on that time; the offset, if the second half
//! of a period is the first turned over; and the voltages of knots. Voltages that are equal by the
//! shape of the waveform (the two ends of a level, the two sides of a corner) are one number.

use super::open_numbers::{Numbers, STEP, VoltageGroups};
use super::waveform::Cycle;
use crate::recording::measured_drive::knots::Knot;

/// Most numbers that the voltage between two knots depends on: step, two times, offset, two
/// voltages.
const MOST_NUMBERS_OF_LINE: usize = 6;
/// A voltage and how it changes with the numbers (a number may come twice).
#[derive(Debug, Clone, Copy)]
pub struct Dependence {
    /// \[V\]
    pub voltage: f64,
    entries: [(usize, f64); MOST_NUMBERS_OF_LINE],
    count: usize,
}

impl Dependence {
    /// Number and derivative.
    pub fn entries(&self) -> &[(usize, f64)] {
        &self.entries[..self.count]
    }

    fn push(&mut self, number: usize, derivative: f64) {
        if derivative != 0.0 {
            self.entries[self.count] = (number, derivative);
            self.count += 1;
        }
    }
}

impl Numbers {
    /// The numbers of `cycle`; the knots' instants count in the repetition around `middle` \[s\].
    pub fn of(cycle: &Cycle, middle: f64) -> Self {
        let knots = cycle.knots.len();
        let (groups, voltages) = groups_of(cycle);
        Self {
            knots,
            mirrored: cycle.mirrored,
            groups,
            voltages,
            turn: ((middle - cycle.knots[0].time) / cycle.step()).round(),
        }
    }

    /// Value of number `k` in `cycle`.
    pub fn value(&self, cycle: &Cycle, k: usize) -> f64 {
        if k == STEP {
            return cycle.step();
        }
        if k <= self.knots {
            return cycle.knots[k - 1].time + self.turn * cycle.step();
        }
        if Some(k) == self.offset() {
            return cycle.offset;
        }
        let own = k - self.first_voltage();
        self.groups
            .iter()
            .zip(&cycle.knots)
            .flat_map(|(group, knot)| group.iter().zip([knot.before, knot.after]))
            .find_map(|(group, volts)| {
                let (number, sign) = (*group)?;
                (number == own).then_some(sign * volts)
            })
            .unwrap_or(0.0)
    }

    /// `cycle` with its numbers changed.
    pub fn moved(&self, cycle: &Cycle, change: &[f64]) -> Cycle {
        let mut moved = cycle.clone();
        moved.period += cycle.factor() * change[STEP];
        moved.offset += self.offset().map_or(0.0, |k| change[k]);
        let voltages: Vec<f64> = (self.first_voltage()..self.len())
            .map(|k| self.value(cycle, k) + change[k])
            .collect();
        for (j, (knot, groups)) in moved.knots.iter_mut().zip(&self.groups).enumerate() {
            let late = change[self.time(j)] - self.turn * change[STEP];
            knot.time += late;
            knot.bounds = (knot.bounds.0 + late, knot.bounds.1 + late);
            // From the number itself, so that equal voltages stay equal to the last bit.
            let value = |group: Option<(usize, f64)>| group.map_or(0.0, |(g, s)| s * voltages[g]);
            (knot.before, knot.after) = (value(groups[0]), value(groups[1]));
        }
        moved
    }

    /// Gives a voltage to the last bit: a sum with its change is off by one.
    pub fn set_voltage(&self, cycle: &mut Cycle, k: usize, value: f64) {
        if Some(k) == self.offset() {
            cycle.offset = value;
        }
        for (knot, groups) in cycle.knots.iter_mut().zip(&self.groups) {
            for (group, volts) in groups.iter().zip([&mut knot.before, &mut knot.after]) {
                if let Some((group, sign)) = group
                    && self.first_voltage() + group == k
                {
                    *volts = sign * value;
                }
            }
        }
    }

    /// The voltage at `t` between knot `k` of `cycle`, which is `a`, and the next, `b`.
    pub fn dependence(&self, k: i64, a: &Knot, b: &Knot, t: f64) -> Dependence {
        let share = ((t - a.time) / (b.time - a.time)).clamp(0.0, 1.0);
        let rise = b.before - a.after;
        let slope = rise / (b.time - a.time);
        let mut of = Dependence {
            voltage: a.after + share * rise,
            entries: [(0, 0.0); MOST_NUMBERS_OF_LINE],
            count: 0,
        };
        let count = self.knots as i64;
        let mut step = 0.0;
        for (k, weight, side) in [(k, 1.0 - share, 1), (k + 1, share, 0)] {
            let (turn, j) = (k.div_euclid(count), k.rem_euclid(count) as usize);
            let late = -slope * weight;
            of.push(self.time(j), late);
            step += (turn as f64 - self.turn) * late;
            let turned = self.mirrored && turn.rem_euclid(2) == 1;
            if let Some((group, sign)) = self.groups[j][side] {
                let sign = if turned { -sign } else { sign };
                of.push(self.first_voltage() + group, sign * weight);
            }
        }
        of.push(STEP, step);
        if let Some(offset) = self.offset() {
            of.push(offset, 1.0);
        }
        of
    }
}

impl Cycle {
    /// The same with its freedoms at `values`, as many as there are.
    pub fn changed(&self, values: &[f64]) -> Self {
        let Some(spread) = &self.spread else {
            return self.clone();
        };
        let changed = spread.numbers.moved(self, &spread.change(values));
        if changed.is_ordered() {
            changed
        } else {
            self.clone()
        }
    }
}

/// Groups of voltages that are equal but for the sign, and how many there are.
fn groups_of(cycle: &Cycle) -> (Vec<VoltageGroups>, usize) {
    let count = cycle.knots.len();
    // Voltage before knot k is node 2k, after it 2k + 1.
    let mut equal: Vec<Vec<(usize, f64)>> = vec![Vec::new(); 2 * count];
    let mut tie = |a: usize, b: usize, sign: f64| {
        equal[a].push((b, sign));
        equal[b].push((a, sign));
    };
    for (k, knot) in cycle.knots.iter().enumerate() {
        if !knot.jumps() {
            tie(2 * k, 2 * k + 1, 1.0);
        }
        let next = (k + 1) % count;
        let sign = if cycle.mirrored && next == 0 {
            -1.0
        } else {
            1.0
        };
        if knot.after == sign * cycle.knots[next].before {
            tie(2 * k + 1, 2 * next, sign);
        }
    }
    let mut of_node: Vec<Option<(usize, f64)>> = vec![None; 2 * count];
    let mut groups = 0;
    let mut is_seen = vec![false; 2 * count];
    for start in 0..2 * count {
        if is_seen[start] {
            continue;
        }
        let mut members = vec![(start, 1.0)];
        is_seen[start] = true;
        let mut is_zero = false;
        let mut next = 0;
        while let Some(&(node, sign)) = members.get(next) {
            next += 1;
            for &(other, tie) in &equal[node] {
                if !is_seen[other] {
                    is_seen[other] = true;
                    members.push((other, sign * tie));
                } else if members.iter().any(|m| *m == (other, -sign * tie)) {
                    // Equal to its own negative.
                    is_zero = true;
                }
            }
        }
        if !is_zero {
            for (node, sign) in members {
                of_node[node] = Some((groups, sign));
            }
            groups += 1;
        }
    }
    let pairs = of_node.chunks_exact(2).map(|pair| [pair[0], pair[1]]);
    (pairs.collect(), groups)
}
