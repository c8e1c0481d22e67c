//! The effects' extra states over the pieces of a drive, and the sensor's readings, which
//! may be among them.

use super::{Attached, Device};
use crate::model::drive::Segment;
use crate::model::effects::Kinematics;
use crate::model::sensor::Point;

impl Device {
    /// Brings the effects' memories up to date where a piece of the drive ends.
    pub fn end_piece(&self, piece: &Segment, t: f64, z: &mut [f64]) {
        if self.effects.is_empty() {
            return;
        }
        let mut at = Kinematics {
            t,
            voltage: piece.shape.voltage(t),
            ..Kinematics::default()
        };
        self.drive_force(&mut at, piece.branch, z);
        let film = self.film_voltage(&at, z);
        for e in &self.effects {
            let own = &mut z[e.first..e.first + e.count];
            e.action.end_piece(&at, film, own);
        }
    }

    /// The piece of a drive's segment that begins at `t` over which no effect's law breaks.
    pub fn piece(&self, segment: Segment, t: f64, z: &[f64]) -> Segment {
        let mut piece = self.effects.iter().fold(segment, |piece, e| {
            e.action.piece(piece, t, &z[e.first..e.first + e.count])
        });
        // Time goes on whatever an effect says.
        if piece.end <= t {
            piece.end = segment.end.min(t + 1e-12 * (1.0 + t.abs()));
        }
        piece
    }

    /// Inputs of the extra states.
    pub fn state_inputs(&self, at: &Kinematics, z: &[f64], inputs: &mut [f64]) {
        for e in &self.effects {
            let own = e.first..e.first + e.count;
            e.action.state_inputs(at, &z[own.clone()], &mut inputs[own]);
        }
    }

    /// Share of its rate at which each extra state goes here, if that is not all of it, as
    /// calls of `of` with the state's number.
    pub fn paces(&self, at: &Kinematics, mut of: impl FnMut(usize, f64)) {
        for e in self.effects.iter().filter(|e| e.lasts) {
            let pace = e.action.pace(at);
            (e.first..e.first + e.count).for_each(|i| of(i, pace));
        }
    }

    /// Extra states as if everything had stood at `at` for long.
    pub fn settled_states(&self, at: &Kinematics) -> Vec<f64> {
        let mut z = vec![0.0; self.rates.len()];
        let mut input = vec![0.0; z.len()];
        // States that feed on others settle one after the other.
        for _ in 0..3 {
            self.state_inputs(at, &z, &mut input);
            for ((z, u), rate) in z.iter_mut().zip(&input).zip(&self.rates) {
                *z = if *rate > 0.0 { u / rate } else { 0.0 };
            }
            for e in &self.effects {
                e.action.settle(at, &mut z[e.first..e.first + e.count]);
            }
        }
        z
    }

    /// Extra states taken over from `other`, whose are `z`; those of effects that it has
    /// not are as in `settled`.
    pub fn adopt_states(&self, other: &Self, z: &[f64], mut settled: Vec<f64>) -> Vec<f64> {
        for own in &self.effects {
            let same = |e: &&Attached| e.id == own.id && e.count == own.count;
            if let Some(theirs) = other.effects.iter().find(same) {
                settled[own.first..own.first + own.count]
                    .copy_from_slice(&z[theirs.first..theirs.first + theirs.count]);
            }
        }
        settled
    }

    /// The sensor's reading of a point that is at `x` \[m\] at time `t`.
    #[inline]
    pub fn reading(&self, x: f64, point: Point, t: f64, z: &[f64]) -> f64 {
        self.apparent(x, point, t, z)
            + match point {
                Point::ProofMass => self.sensor.offset_p,
                Point::Cantilever => self.sensor.offset_c,
            }
    }

    /// The reading without the sensor's constant offset.
    #[inline]
    pub fn apparent(&self, x: f64, point: Point, t: f64, z: &[f64]) -> f64 {
        self.effects.iter().fold(x, |x, e| {
            e.action
                .reading(x, point, t, &z[e.first..e.first + e.count])
        })
    }

    /// Those of the extra states that [`Self::apparent`] goes by.
    pub fn shown_states(&self) -> impl Iterator<Item = usize> {
        let shown = self.effects.iter().filter(|e| e.action.acts_on_readings());
        shown.flat_map(|e| e.first..e.first + e.count)
    }

    /// Rate at which the slowest extra state forgets [1/s]; infinite if there is none.
    pub fn slowest_rate(&self) -> f64 {
        let all = self.effects.iter();
        all.fold(f64::INFINITY, |a, e| a.min(self.forgets(e)))
    }

    /// Rate at which the slowest of an effect's states forgets [1/s].
    fn forgets(&self, e: &Attached) -> f64 {
        let own = self.rates[e.first..e.first + e.count].iter();
        own.fold(f64::INFINITY, |a, &rate| a.min(rate)) / e.action.lasting()
    }

    /// Whether the states of an effect, other than readings, feel the motion.
    fn feels(e: &Attached) -> bool {
        !e.action.reads_states() && e.action.states_feel_motion()
    }

    /// Rate at which the slowest of those extra states forgets that feel the motion and are no
    /// readings [1/s]; `None` if there is none.
    pub fn feeling_rate(&self) -> Option<f64> {
        let feeling = self.effects.iter().filter(|e| Self::feels(e));
        feeling.map(|e| self.forgets(e)).reduce(f64::min)
    }

    /// Rate of the fastest extra state that is no reading [1/s], 0 if there is none; of all, or
    /// of those that do not feel the motion.
    pub fn fastest_rate(&self, of_all: bool) -> f64 {
        let asked = |e: &&Attached| !e.action.reads_states() && (of_all || !Self::feels(e));
        let own = |e: &Attached| self.rates[e.first..e.first + e.count].iter();
        let all = self.effects.iter().filter(asked).flat_map(own);
        all.fold(0.0, |a, &rate| a.max(rate))
    }

    /// Where the extra states stand that are the readings of proof mass and cantilever.
    pub fn reading_states(&self) -> Option<usize> {
        let lagged = |e: &&Attached| e.count > 0 && e.action.reads_states();
        self.effects.iter().find(lagged).map(|e| e.first)
    }

    /// Time by which all readings are late \[s\].
    pub fn reading_delay(&self) -> f64 {
        self.effects
            .iter()
            .map(|e| e.action.reading_delay())
            .sum::<f64>()
            .max(0.0)
    }
}
