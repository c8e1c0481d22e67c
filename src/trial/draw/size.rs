//! Motions of a device with laws and instruments, and how large a law is over the smallest
//! visible.

use crate::trial::concealed::concealed_effects::Choice;
use crate::trial::concealed::law::Law;
use crate::trial::device::reference_device::{Excitation, excitations};
use crate::trial::device::{Device, TOLERANCE};
use crate::trial::hybrid::{Run, RunError, run};
use crate::trial::instrument::Instruments;
use crate::trial::visibility::{CaseRun, JUST_VISIBLE, deviations};
use crate::trial::voltage::{Piece, pieces};

/// Standard deviation of the shift between voltage and readings, as known beforehand \[s\].
const CLOCK_SKEW_SIGMA: f64 = 5e-6;

/// A device with its laws and instruments, as recordings are made of it.
pub(crate) struct TrialSetup<'a> {
    pub(crate) plain: &'a Device,
    pub(crate) instruments: &'a Instruments,
    pub(crate) excitations: &'a [Excitation],
}

/// One motion with what is needed to judge it.
pub(crate) struct Motion {
    pub(crate) run: Run,
    plain: Device,
    pub(crate) pieces: Vec<Piece>,
    /// Sample times in the motion's clock.
    times: Vec<f64>,
}

impl TrialSetup<'_> {
    /// The motion of recording `number`, read by instruments without scale, zero and
    /// noise.
    pub(crate) fn motion(&self, laws: &[&Law], number: usize) -> Result<Motion, RunError> {
        let e = &self.excitations[number];
        let count = (e.duration * self.instruments.rate).round() as usize + 1;
        let delay: f64 = laws.iter().map(|law| law.delay()).sum();
        let times: Vec<f64> = (0..count)
            .map(|i| self.instruments.instant(i) - self.instruments.skew)
            .collect();
        let read_at: Vec<f64> = times.iter().map(|t| t - delay).collect();
        let plain_pieces = pieces(&e.waveform, e.duration);
        let mut driven = plain_pieces.clone();
        let mut device = self.plain.clone();
        for law in laws {
            law.install(&mut device, number, e.duration);
            driven = law.alter_drive(driven);
        }
        for law in laws {
            law.note_history(&mut driven);
        }
        let end = e.duration + 1e-4;
        let mut run = run(&device, &driven, end, &read_at, TOLERANCE)?;
        for (i, t) in times.iter().enumerate() {
            let zero: f64 = laws.iter().map(|law| law.zero(*t)).sum();
            run.proof_mass[i] += zero;
            run.cantilever[i] += zero;
        }
        Ok(Motion {
            run,
            plain: self.plain.clone(),
            pieces: plain_pieces,
            times,
        })
    }

    /// Size of a law over the smallest visible, from the recordings that are fitted.
    pub(crate) fn visibility(&self, law: &Law) -> Result<f64, RunError> {
        // A pure delay is a shift of the clocks and nothing else: it shows by as much as it
        // exceeds what these may be apart. The linear bound would see it in every jump.
        if law.delay() > 0.0 {
            return Ok(law.delay() / CLOCK_SKEW_SIGMA / JUST_VISIBLE);
        }
        let fitted = (0..self.excitations.len()).filter(|i| !self.excitations[*i].held_out);
        let walk = self.instruments.imperfections.zero_walk;
        let hidden = self.against_walk(law, walk);
        let motions = fitted
            .map(|i| self.motion(&[law], i))
            .collect::<Result<Vec<_>, _>>()?;
        let made: Vec<CaseRun<'_>> = motions
            .iter()
            .map(|m| CaseRun {
                run: &m.run,
                plain: &m.plain,
                pieces: &m.pieces,
                times: &m.times,
            })
            .collect();
        let size = deviations(&made, self.instruments)? / JUST_VISIBLE;
        Ok(size.min(hidden.unwrap_or(size)))
    }

    /// Size of a drift where the zero walks at random by itself, `walk` \[m/s^(1/2)\]: the drift
    /// shows by as much as it exceeds what the zero walks in the same time, which the bound does not
    /// know. `None` for other laws and zeros that stay.
    fn against_walk(&self, law: &Law, walk: f64) -> Option<f64> {
        if walk == 0.0 || !matches!(law, Law::Drift { .. }) {
            return None;
        }
        let fitted = self.excitations.iter().filter(|e| !e.held_out);
        let energy: f64 = fitted
            .map(|e| (law.zero(e.duration) / (walk * e.duration.sqrt())).powi(2))
            .sum();
        Some(energy.sqrt() / JUST_VISIBLE)
    }

    /// Brings a choice near `target` times the smallest visible, within what is
    /// realistic; returns it with the size it really has.
    pub(crate) fn sized(&self, choice: Choice, target: f64) -> Result<(Choice, f64), RunError> {
        let mut choice = choice;
        let mut size = self.visibility(&choice.law)?;
        // A compliant ground decides otherwise than the rigid one whether a touch holds,
        // however stiff it is: hardening it makes it slower, not invisible.
        let tries = if matches!(choice.law, Law::Ground(_)) {
            0
        } else {
            2
        };
        for _ in 0..tries {
            let wish = target / size.max(1e-6);
            if (0.6..1.7).contains(&wish) {
                break;
            }
            let factor = wish.clamp(0.02, choice.most);
            if (factor - 1.0).abs() < 0.01 {
                break;
            }
            choice.law = choice.law.scaled(factor);
            choice.most = (choice.most / factor).max(1.0);
            size = self.visibility(&choice.law)?;
        }
        Ok((choice, size))
    }
}

/// Size of a law over the smallest visible on the recordings of a trial.
///
/// # Errors
/// [`RunError`] if the device cannot be followed.
pub fn visibility(plain: &Device, instruments: &Instruments, law: &Law) -> Result<f64, RunError> {
    let setup = TrialSetup {
        plain,
        instruments,
        excitations: &excitations(),
    };
    setup.visibility(law)
}

#[cfg(test)]
mod tests {
    use super::super::size::*;
    use crate::trial::concealed::hidden_forces::Term;
    use crate::trial::instrument;
    use crate::trial::instrument::StructureKind;
    use crate::trial::rng::TrialRng;

    /// A beam and what it is read by.
    fn beam() -> (Device, Instruments) {
        let (plain, _) = instrument::device(StructureKind::Beam, &mut TrialRng::new(5, 0)).unwrap();
        let instruments = instrument::instruments(50e3, 20e-9, true, 9, &mut TrialRng::new(5, 1));
        (plain, instruments)
    }

    /// By how many standard deviations a change of a beam shows in a square wave.
    fn shows(change: impl Fn(&mut Device)) -> f64 {
        let (plain, instruments) = beam();
        let mut changed = plain.clone();
        change(&mut changed);
        let setup = TrialSetup {
            plain: &changed,
            instruments: &instruments,
            excitations: &excitations(),
        };
        let motion = setup.motion(&[], 1).unwrap();
        let made = CaseRun {
            run: &motion.run,
            plain: &plain,
            pieces: &motion.pieces,
            times: &motion.times,
        };
        deviations(&[made], &instruments).unwrap()
    }

    #[test]
    fn shapes_of_the_beams_modes_are_free_parameters() {
        let none = shows(|_| {});
        assert!(none < 0.1, "{none}");
        for mode in 0..4 {
            let driven = shows(|d| d.structure.push_drive[mode] *= 1.01);
            let seen = shows(|d| d.structure.read_c[mode] *= 1.01);
            let damped = shows(|d| d.structure.damping[mode][mode] *= 1.02);
            println!("{mode}: {driven:.2} {seen:.2} {damped:.2}");
            assert!(driven.max(seen).max(damped) < 2.0);
        }
        // Creep is no matter of shapes.
        let (plain, instruments) = beam();
        let law = Law::Term(Term::Creep {
            compliance: [0.01, 0.0, 0.0],
            tau: [0.03, 1.0, 1.0],
        });
        let creep = visibility(&plain, &instruments, &law).unwrap();
        assert!(creep > 1.0, "{creep}");
    }
}
