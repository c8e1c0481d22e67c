//! All feet over their common cycle.

use super::FOOT_COUNTS;
use super::contact::{Bar, Foot, SAME_INSTANT};
use super::error::GaitError;

/// Most periods of the drive in a common cycle: five feet with cycles of 3, 4 and 5 fit.
const MAX_COMMON_PERIODS: u64 = 60;

/// A part of the common cycle with as many feet down throughout.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Support {
    /// Begin, as a share of the common cycle.
    pub start: f64,
    /// End.
    pub end: f64,
    /// Feet that are down.
    pub feet: usize,
}

/// Which feet are down when.
#[derive(Debug, Clone, PartialEq)]
pub struct Gait {
    /// Names of the feet.
    pub names: Vec<String>,
    /// Delays of the feet, as shares of the drive's period.
    pub delays: Vec<f64>,
    /// Length of the common cycle \[s\].
    pub cycle: f64,
    /// Periods of the drive in it.
    pub periods: u64,
    /// The contacts of each foot, one row a foot.
    pub bars: Vec<Vec<Bar>>,
    /// How many feet are down, from 0 to 1 without gaps.
    pub support: Vec<Support>,
    /// Share of the time that each foot is down.
    pub duty_factors: Vec<f64>,
    /// Share of the time with exactly k feet down, k from 0 to the number of feet.
    pub shares: Vec<f64>,
}

impl Gait {
    /// The gait of feet under a drive of `period` \[s\]. Feet with cycles of several periods are
    /// drawn over the shortest time in which all repeat.
    ///
    /// # Errors
    /// [`GaitError`] naming the foot and what is wrong with it.
    pub fn new(feet: &[Foot], period: f64) -> Result<Self, GaitError> {
        let found = feet.len();
        if !(FOOT_COUNTS.0..=FOOT_COUNTS.1).contains(&found) {
            return Err(GaitError::Count { found });
        }
        if !(period.is_finite() && period > 0.0) {
            return Err(GaitError::Period(period));
        }
        let mut periods = 1;
        let mut own = Vec::with_capacity(found);
        for foot in feet {
            let count = foot.periods(period)?;
            own.push(count);
            // Checked after each foot, so that the product stays small.
            periods = common_multiple(periods, count)?;
        }
        let bars: Vec<Vec<Bar>> = feet
            .iter()
            .zip(&own)
            .map(|(foot, own)| foot.bars(*own, periods))
            .collect();
        let support = support_of(&bars);
        let mut shares = vec![0.0; found + 1];
        for part in &support {
            shares[part.feet] += part.end - part.start;
        }
        // A sum of none would be -0.
        let duty = |bars: &Vec<Bar>| bars.iter().fold(0.0, |sum, bar| sum + bar.end - bar.start);
        Ok(Self {
            names: feet.iter().map(|foot| foot.name.clone()).collect(),
            delays: feet.iter().map(|foot| foot.delay).collect(),
            cycle: period * periods as f64,
            periods,
            duty_factors: bars.iter().map(duty).collect(),
            bars,
            support,
            shares,
        })
    }

    /// Share of the time with fewer than `feet` down: 0 for none, 1 for more than there are.
    pub fn share_with_fewer_than(&self, feet: usize) -> f64 {
        let count = feet.min(self.shares.len());
        self.shares[..count].iter().sum()
    }
}

/// The shortest time in which both repeat, in periods.
fn common_multiple(a: u64, b: u64) -> Result<u64, GaitError> {
    let (mut high, mut low) = (a, b);
    while low > 0 {
        (high, low) = (low, high % low);
    }
    let periods = (a / high).saturating_mul(b);
    if periods > MAX_COMMON_PERIODS {
        let most = MAX_COMMON_PERIODS;
        return Err(GaitError::CommonCycle { periods, most });
    }
    Ok(periods)
}

/// How many feet are down over the cycle.
fn support_of(bars: &[Vec<Bar>]) -> Vec<Support> {
    let mut edges: Vec<(f64, i32)> = Vec::new();
    for bar in bars.iter().flatten() {
        edges.push((bar.start, 1));
        edges.push((bar.end, -1));
    }
    edges.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut support: Vec<Support> = Vec::new();
    let (mut start, mut down) = (0.0, 0i32);
    let mut close = |start: &mut f64, end: f64, down: i32| {
        if end - *start <= SAME_INSTANT {
            return;
        }
        let feet = usize::try_from(down).unwrap_or(0);
        match support.last_mut() {
            // What lies between two equal parts was shorter than rounding.
            Some(last) if last.feet == feet => last.end = end,
            _ => support.push(Support {
                start: *start,
                end,
                feet,
            }),
        }
        *start = end;
    };
    for (at, change) in edges {
        close(&mut start, at, down);
        down += change;
    }
    close(&mut start, 1.0, down);
    support
}
