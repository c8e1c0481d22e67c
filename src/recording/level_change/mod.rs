//! A ground whose level changes in the course of a recording, from data alone.

mod drift;
mod step;

pub use drift::{LevelDrift, find_level_drift};
pub use step::{LevelStep, find_level_step};

/// How the level changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LevelChange {
    /// Once.
    Step(LevelStep),
    /// All the time.
    Drift(LevelDrift),
}

impl LevelChange {
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
