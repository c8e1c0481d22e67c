//! How many steps a run may take for its time.

use crate::sim::device::Device;
use crate::sim::error::Options;

/// Steps beyond those at once for each second of device time \[1/s\]: some 50 times as many as the paper's
/// device takes.
const STEPS_PER_SECOND: f64 = 1e6;
/// Steps for each step of full length that the device's own modes need.
const STEPS_PER_LONGEST_STEP: f64 = 4.0;
/// Rounds of a step in which forces and motion come to agree; one of more rounds counts as more
/// than one step.
const ROUNDS_PER_STEP: u32 = 4;
/// Steps for each piece of the drive.
pub const STEPS_PER_PIECE: f64 = 64.0;

/// How many more steps a run may take before it must have advanced: what it is given with time
/// passes and steps use up (a leaky bucket). A motion too fast or too stiff to follow would else
/// take all of the steps for nothing.
#[derive(Debug, Clone, Copy)]
pub struct Pace {
    /// Steps that may be taken at once, and how many of them are left.
    at_once: f64,
    left: f64,
    /// Steps given for each second of device time \[1/s\].
    per_second: f64,
    /// Pieces of the drive so far.
    pub pieces: u64,
    /// Time at which the latest were given \[s\].
    since: f64,
}

impl Pace {
    /// `own_step`: the longest step that follows the device's own motion \[s\].
    fn new(at_once: u64, own_step: f64) -> Self {
        Self {
            at_once: at_once as f64,
            left: at_once as f64,
            per_second: STEPS_PER_SECOND + STEPS_PER_LONGEST_STEP / own_step,
            pieces: 0,
            since: 0.0,
        }
    }

    /// Of a device at time `t` \[s\].
    pub fn of(device: &Device, options: &Options, t: f64) -> Self {
        let [own, _] = device.longest_steps_to_read();
        let limit = options.longest_step.unwrap_or(f64::INFINITY);
        Self {
            since: t,
            ..Self::new(options.max_steps_at_once, own.min(limit))
        }
    }

    /// Follows a change of the longest step.
    pub fn limit(&mut self, device: &Device, options: &Options) {
        self.per_second = Self::of(device, options, self.since).per_second;
    }

    /// Gives what a new piece of the drive may need.
    pub fn enter_piece(&mut self) {
        self.left += STEPS_PER_PIECE;
        self.pieces += 1;
    }

    /// Takes what a step of so many rounds costs beyond one.
    pub fn spend(&mut self, rounds: u32) {
        self.left -= f64::from(rounds.saturating_sub(1) / ROUNDS_PER_STEP);
    }

    /// Takes one step at `t` \[s\]; false where none is left.
    pub fn allows(&mut self, t: f64) -> bool {
        let given = self.per_second * (t - self.since);
        self.since = t;
        self.left = (self.left + given).min(self.at_once.max(self.left)) - 1.0;
        self.left >= 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::super::pace::*;

    /// Steps of `h` \[s\] until a pace gives up, at most `most`.
    fn steps_allowed(pace: &mut Pace, h: f64, most: u64) -> u64 {
        let start = pace.since;
        let mut taken = 0;
        while taken < most && pace.allows(start + taken as f64 * h) {
            taken += 1;
        }
        taken
    }

    #[test]
    fn short_steps_are_few_and_long_ones_without_end() {
        let mut pace = Pace::new(1000, 1e-4);
        assert_eq!(steps_allowed(&mut pace, 1e-5, 100_000), 100_000);
        // Nothing was saved up for hard times beyond what there is at once.
        let taken = steps_allowed(&mut pace, 1e-12, u64::MAX);
        assert!((990..1100).contains(&taken), "{taken}");
        // A device of a fast mode may take as many as that needs.
        assert_eq!(
            steps_allowed(&mut Pace::new(1000, 1e-6), 5e-7, 100_000),
            100_000
        );
        // Pieces of the drive bring their own.
        let mut pace = Pace::new(1000, 1e-4);
        let many = (0..30_000).all(|_| {
            pace.enter_piece();
            pace.allows(0.0)
        });
        assert!(many);
    }
}
