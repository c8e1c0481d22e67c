//! Gaits as tables of delays.
//!
//! Feet are counted from the front to the rear, left before right: left front, right front, left
//! of the second row, ... The names are those of animal locomotion (McNeill Alexander, Principles
//! of Animal Locomotion, 2003, ch. 7; the tripod and the wave of insects: D. M. Wilson, Annu. Rev.
//! Entomol. 11, 103 (1966)).

use super::FOOT_COUNTS;
use super::error::GaitError;

/// A gait.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GaitPreset {
    /// All at once.
    InPhase,
    /// The left feet, then the right ones.
    Alternating,
    /// Each foot with those diagonally beside it: the trot of four feet, the tripod of six.
    Tripod,
    /// One after another, from the rear to the front, first one side, then the other, evenly
    /// spaced.
    Wave,
}

impl GaitPreset {
    /// All, in the order in which they are offered.
    pub const ALL: [Self; 4] = [Self::InPhase, Self::Alternating, Self::Tripod, Self::Wave];

    /// What a person reads, for as many `feet`: the diagonal pairs are the trot of four and the tripod of six.
    #[must_use]
    pub fn label(self, feet: usize) -> &'static str {
        match self {
            Self::InPhase => "in phase",
            Self::Alternating => "alternating",
            Self::Tripod if feet >= 5 => "tripod",
            Self::Tripod if feet == 4 => "trot",
            Self::Tripod => "diagonal",
            Self::Wave => "wave",
        }
    }

    /// The delay of each foot as a share of the drive's period, 0 to below 1.
    ///
    /// # Errors
    /// [`GaitError::Count`] for other than 2 to 6 feet.
    pub fn delays(self, feet: usize) -> Result<Vec<f64>, GaitError> {
        if !(FOOT_COUNTS.0..=FOOT_COUNTS.1).contains(&feet) {
            return Err(GaitError::Count { found: feet });
        }
        let is_left = |foot: usize| foot.is_multiple_of(2);
        let half = |is_late: bool| if is_late { 0.5 } else { 0.0 };
        // Left feet from the rear to the front, then the right ones.
        let in_turn: Vec<usize> = (0..feet)
            .rev()
            .filter(|&f| is_left(f))
            .chain((0..feet).rev().filter(|&f| !is_left(f)))
            .collect();
        let turn = |foot| in_turn.iter().position(|&f| f == foot).unwrap_or(0);
        let delay = |foot: usize| match self {
            Self::InPhase => 0.0,
            Self::Alternating => half(!is_left(foot)),
            Self::Tripod => half((foot / 2 + foot) % 2 == 1),
            Self::Wave => turn(foot) as f64 / feet as f64,
        };
        Ok((0..feet).map(delay).collect())
    }
}
