//! Recordings that a lesson makes: to be fitted by hand, or with a concealed effect.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sha2::{Digest, Sha256};

use super::lesson::{Candidate, Concealed, HandFit, Level};
use super::run::{Run, Scene};
use crate::model::effects::{ActiveEffect, find};
use crate::model::sensor::gaussian;
use crate::model::with_effect;
use crate::sim::SimError;

/// A fit whose error is at most this many times the noise is as good as the data allow.
const FULL_SCORE_MISFIT: f64 = 1.1;
/// A fit whose error is this many times the noise earns nothing.
const NO_SCORE_MISFIT: f64 = 30.0;
/// Bytes of the seal that are shown as digits.
const SEAL_BYTES: usize = 8;

/// A made recording of the proof mass.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Target {
    /// Time of the first reading \[s\].
    pub t0: f64,
    /// Interval of the readings \[s\].
    pub dt: f64,
    /// Readings \[m\].
    pub readings: Vec<f64>,
    /// Standard deviation of their noise \[m\].
    pub noise: f64,
}

impl Target {
    fn of(run: &Run, noise: f64, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let readings = run.trace.proof_mass.iter();
        let readings = readings.map(|x| x + noise * gaussian(&mut rng));
        Self {
            t0: run.trace.t0,
            dt: run.trace.dt,
            readings: readings.collect(),
            noise,
        }
    }

    /// Simulated less recorded reading, one for each that both have \[m\].
    pub fn residual(&self, run: &Run) -> Vec<f64> {
        let pairs = run.trace.proof_mass.iter().zip(&self.readings);
        pairs.map(|(simulated, read)| simulated - read).collect()
    }

    /// Rms of the residual in units of the noise; about 1 is as good as the data allow.
    pub fn misfit(&self, run: &Run) -> f64 {
        let residual = self.residual(run);
        let sum: f64 = residual.iter().map(|r| r * r).sum();
        (sum / residual.len().max(1) as f64).sqrt() / self.noise
    }
}

/// Score of a fit by hand, 0 to 1, by the logarithm of its misfit: a tenth of the error is worth the
/// same at every stage.
pub fn fit_score(misfit: f64) -> f64 {
    let share = (NO_SCORE_MISFIT / misfit).ln() / (NO_SCORE_MISFIT / FULL_SCORE_MISFIT).ln();
    if share.is_finite() {
        share.clamp(0.0, 1.0)
    } else {
        0.0
    }
}

impl HandFit {
    /// The recording of a scene with the true values.
    ///
    /// # Errors
    /// [`SimError`].
    pub fn target(
        &self,
        scene: &Scene,
        seed: u64,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Option<Target>, SimError> {
        let mut true_scene = scene.clone();
        for (id, value) in &self.truth {
            true_scene.set_control(id, *value);
        }
        let run = true_scene.run(go_on)?;
        Ok(run.map(|run| Target::of(&run, self.noise, seed)))
    }
}

/// A round of the game: what is concealed, sealed before it is guessed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Round {
    /// Number of the level, from 0.
    pub level: usize,
    /// What is concealed: number of the candidate, from 0.
    concealed: usize,
    /// Seed of draw and noise.
    pub seed: u64,
    /// First digits of the SHA-256 of seed and name.
    pub seal: String,
}

fn seal_of(seed: u64, name: &str) -> String {
    let digest = Sha256::digest(format!("{seed} {name}").as_bytes());
    let digits = digest.iter().take(SEAL_BYTES);
    digits.map(|byte| format!("{byte:02x}")).collect()
}

impl Concealed {
    /// Draws a round of a level; `None` for a level that there is not.
    pub fn draw(&self, level: usize, seed: u64) -> Option<Round> {
        let candidates = &self.levels.get(level)?.candidates;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let concealed = rng.random_range(0..candidates.len());
        Some(Round {
            level,
            concealed,
            seed,
            seal: seal_of(seed, &candidates.get(concealed)?.name),
        })
    }

    /// The level of a round.
    pub fn level(&self, round: &Round) -> Option<&Level> {
        self.levels.get(round.level)
    }

    /// What a round conceals.
    pub fn opened(&self, round: &Round) -> Option<&Candidate> {
        self.level(round)?.candidates.get(round.concealed)
    }

    /// Whether a guess, the number of a candidate from 0, is right.
    pub fn is_right(round: &Round, guess: usize) -> bool {
        round.concealed == guess
    }

    /// Whether the seal of a round is that of what it conceals.
    pub fn seal_holds(&self, round: &Round) -> bool {
        self.opened(round)
            .is_some_and(|opened| seal_of(round.seed, &opened.name) == round.seal)
    }

    /// The recording of a round.
    ///
    /// # Errors
    /// [`SimError`].
    pub fn target(
        &self,
        scene: &Scene,
        round: &Round,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Option<Target>, SimError> {
        let mut concealing = scene.clone();
        if let Some(candidate) = self.opened(round)
            && let Some(effect) = candidate.active()
        {
            concealing.preset.model = with_effect(&scene.preset.model, effect);
        }
        let run = concealing.run(go_on)?;
        Ok(run.map(|run| Target::of(&run, self.noise, round.seed)))
    }
}

impl Candidate {
    /// The effect with its values; `None` for nothing.
    pub fn active(&self) -> Option<ActiveEffect> {
        let mut effect = ActiveEffect::new(find(self.effect.as_ref()?)?);
        for (id, value) in &self.values {
            effect.set(id, *value);
        }
        Some(effect)
    }
}
