//! The free numbers of a cycle as they are counted, and what the samples leave open of them.

use crate::recording::measured_drive::thresholds::NOISE_REACH_SIGMAS;

/// Index of the time from one repetition to the next.
pub const STEP: usize = 0;

/// Number of the group of equal voltages, and its sign, of a knot's voltage before and after; `None`
/// for zero.
pub type VoltageGroups = [Option<(usize, f64)>; 2];

/// Which number is what.
#[derive(Debug, Clone, PartialEq)]
pub struct Numbers {
    /// Knots of a repetition.
    pub(super) knots: usize,
    pub(super) mirrored: bool,
    /// Number of the group of equal voltages, and its sign, of each knot's voltage before and after;
    /// `None` for zero.
    pub(super) groups: Vec<VoltageGroups>,
    /// Voltages that are free.
    pub(super) voltages: usize,
    /// Repetition in which the knots' instants count.
    pub(super) turn: f64,
}

impl Numbers {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.first_voltage() + self.voltages
    }

    /// Index of the instant of knot `j`.
    pub fn time(&self, j: usize) -> usize {
        1 + j
    }

    /// Index of the offset, if there is one.
    pub fn offset(&self) -> Option<usize> {
        self.mirrored.then_some(1 + self.knots)
    }

    pub(super) fn first_voltage(&self) -> usize {
        1 + self.knots + usize::from(self.mirrored)
    }

    /// Indices of the offset and the voltages.
    pub fn voltages(&self) -> std::ops::Range<usize> {
        1 + self.knots..self.len()
    }

    /// Repetition in which the knots' instants count.
    pub fn turn(&self) -> f64 {
        self.turn
    }
}

/// What is open of a cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    /// The numbers that change.
    pub numbers: Numbers,
    /// Changes of all numbers by one standard deviation, those that move the voltage most first.
    pub directions: Vec<Vec<f64>>,
    /// Most standard deviations by which each may be off.
    pub most: f64,
    /// Whether the period is a setting, which bounds jumps more closely than the directions say.
    pub is_period_set: bool,
}

impl Spread {
    /// How far knot `j` in repetition `turn` may be from its instant, its voltages and the period off
    /// with it \[s\].
    pub fn reach_at(&self, j: usize, turn: f64) -> f64 {
        let far = turn - self.numbers.turn();
        let off = |d: &Vec<f64>| d[self.numbers.time(j)] + far * d[STEP];
        let squares: f64 = self.directions.iter().map(|d| off(d).powi(2)).sum();
        self.most.min(NOISE_REACH_SIGMAS) * squares.sqrt()
    }

    /// The change of all numbers by so many standard deviations of each direction.
    pub fn change(&self, values: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; self.numbers.len()];
        for (direction, value) in self.directions.iter().zip(values) {
            for (sum, change) in all.iter_mut().zip(direction) {
                *sum += value * change;
            }
        }
        all
    }
}
