//! Recordings that no physics can explain: each with the voltage of another.

use std::sync::Arc;

use super::draw::{Recordings, TrialError};
use crate::recording::Recording;

impl Recordings {
    /// The same motions, each with the voltage of the next recording, over again where
    /// that one is shorter. A diagnosis of them must name nothing.
    ///
    /// # Errors
    /// [`TrialError::Shuffle`] if a recording has no voltage.
    pub fn with_voltages_exchanged(&self) -> Result<Self, TrialError> {
        let all: Vec<&Arc<Recording>> = self.train.iter().chain(&self.held_out).collect();
        let exchanged = |k: usize| -> Result<Arc<Recording>, TrialError> {
            let motion = all[k];
            let drive = &all[(k + 1) % all.len()];
            let refused = |reason: String| TrialError::Shuffle {
                recording: drive.name.clone(),
                reason,
            };
            let voltage = drive
                .voltage
                .as_ref()
                .ok_or_else(|| refused("it has no voltage".to_owned()))?;
            let other = (0..motion.len()).map(|i| voltage[i % voltage.len()]);
            Recording::new(
                &motion.name,
                motion.time.clone(),
                Some(other.collect()),
                motion.proof_mass.clone(),
                motion.cantilever.clone(),
            )
            .map(Arc::new)
            .map_err(|error| refused(error.to_string()))
        };
        let fitted = self.train.len();
        Ok(Self {
            train: (0..fitted).map(exchanged).collect::<Result<_, _>>()?,
            held_out: (fitted..all.len())
                .map(exchanged)
                .collect::<Result<_, _>>()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::draw::{Case, Settings};

    #[test]
    fn motions_stay_and_voltages_move_on() {
        let settings = Settings {
            rate: 2e3,
            ..Settings::default()
        };
        let plain = Case::draw(2, &settings).unwrap().into_parts().0;
        let other = plain.with_voltages_exchanged().unwrap();
        assert_eq!((other.train.len(), other.held_out.len()), (5, 4));
        assert_eq!(plain.train[0].proof_mass, other.train[0].proof_mass);
        let next = plain.train[1].voltage.as_ref().unwrap();
        let got = other.train[0].voltage.as_ref().unwrap();
        assert_eq!(got[..next.len()], next[..]);
        assert_eq!(got[next.len()], next[0]);
        let last = other.held_out[3].voltage.as_ref().unwrap();
        assert_eq!(
            last[..],
            plain.train[0].voltage.as_ref().unwrap()[..last.len()]
        );
    }
}
