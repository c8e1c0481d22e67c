//! A ground whose level changes in the course of a recording, from data alone.

pub(crate) mod drift;
pub(crate) mod step;

pub use self::drift::{LevelDrift, find_level_drift};
pub use self::step::{LevelStep, find_level_step};

/// Length of the blocks in which rests are looked for \[s\].
const BLOCK_LENGTH: f64 = 4e-4;
/// Fewest samples of a block.
const MIN_BLOCK_SAMPLES: usize = 16;

/// Samples of a block, one every `interval` \[s\].
fn block_size(interval: f64) -> usize {
    ((BLOCK_LENGTH / interval) as usize).max(MIN_BLOCK_SAMPLES)
}

/// Whether the scatter of `n` samples about a course agrees with their noise `sigma`: the variance
/// may exceed it by twice its standard error at so few samples.
fn quiet(spread: f64, sigma: f64, n: f64) -> bool {
    spread < sigma * (1.0 + 4.0 / (2.0 * n).sqrt())
}

/// How the level changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LevelChange {
    /// Once.
    Step(LevelStep),
    /// All the time.
    Drift(LevelDrift),
}

impl LevelChange {
    /// The drift, if it is one.
    #[must_use]
    pub fn drift(self) -> Option<LevelDrift> {
        match self {
            LevelChange::Drift(drift) => Some(drift),
            LevelChange::Step(_) => None,
        }
    }

    /// `xp` \[m\] at `time` \[s\] with the change taken out.
    #[must_use]
    pub fn taken_out(&self, time: &[f64], xp: &[f64]) -> Vec<f64> {
        let pairs = time.iter().zip(xp);
        pairs.map(|(t, x)| x - self.rise_at(*t)).collect()
    }

    /// By how much the level is higher at `t` \[s\] than at the beginning \[m\].
    fn rise_at(&self, t: f64) -> f64 {
        match self {
            LevelChange::Step(step) if t < step.time => 0.0,
            LevelChange::Step(step) => step.rise,
            LevelChange::Drift(drift) => drift.rise_at(t),
        }
    }
}
