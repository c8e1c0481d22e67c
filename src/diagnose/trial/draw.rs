//! Drawing a trial: device, rig, what is concealed and at which size, recordings.

use super::bench::{Excitation, excitations};
use super::device::{Device, TOLERANCE};
use super::dice::Dice;
use super::hybrid::{Run, RunError, run};
use super::law::Law;
use super::menu::{CATALOGUE, Choice, OUTSIDE, choose};
use super::rig::{Instruments, StructureKind, device, instruments};
use super::truth::{Class, ConcealedEffect, Envelope, RecordingNote, Truth};
use super::visibility::{JUST_VISIBLE, Made, deviations};
use super::voltage::{Piece, pieces, voltage};
use crate::recording::Recording;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use thiserror::Error;

/// Devices that are drawn before a seed is given up.
const ATTEMPTS: u64 = 12;

/// Why there is no trial.
#[derive(Debug, Error)]
pub enum TrialError {
    /// No device of this seed could be followed.
    #[error("seed {seed}: no trial device could be followed ({last}); use another seed")]
    NoDevice {
        /// The seed.
        seed: u64,
        /// What stopped the last one.
        last: String,
    },
    /// An effect was asked for that is not on the menu.
    #[error(
        "\"{0}\" cannot be concealed; name an effect of the catalogue or one that begins with outside_"
    )]
    UnknownEffect(String),
    /// The noise or the rate make no sense.
    #[error("{what} = {value:e} cannot be used; {remedy}")]
    Setting {
        /// Which setting.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What would be right.
        remedy: &'static str,
    },
    /// The voltages of recordings could not be exchanged.
    #[error("the voltage of {recording} cannot be given to another recording: {reason}")]
    Shuffle {
        /// The recording whose voltage it is.
        recording: String,
        /// Why not.
        reason: String,
    },
    /// The truth could not be written.
    #[error("the truth cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A file could not be written.
    #[error("cannot write {path}: {reason}; check the folder and the disk")]
    Write {
        /// Which file.
        path: String,
        /// Why.
        reason: String,
    },
}

/// What trials are drawn from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mix {
    /// A quarter nothing, half one effect, the rest two or outside the catalogue.
    Standard,
    /// Always this class.
    Only(Class),
    /// Always this one effect.
    Effect(String),
}

/// How trials are made.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The kind of device; drawn if `None`.
    pub structure: Option<StructureKind>,
    /// Whether the cantilever is read beside the proof mass.
    pub cantilever: bool,
    /// Rms of the noise \[m\].
    pub noise: f64,
    /// Samples per second.
    pub rate: f64,
    /// What is concealed.
    pub mix: Mix,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            structure: Some(StructureKind::Lumped),
            cantilever: true,
            noise: 20e-9,
            rate: 50e3,
            mix: Mix::Standard,
        }
    }
}

/// The recordings of a trial, and nothing else.
#[derive(Debug, Clone)]
pub struct Recordings {
    /// To fit.
    pub train: Vec<Arc<Recording>>,
    /// Kept out.
    pub held_out: Vec<Arc<Recording>>,
}

/// A trial: recordings, and the envelope with what they conceal.
#[derive(Debug, Clone)]
pub struct Case {
    recordings: Recordings,
    envelope: Envelope,
}

/// Standard deviation of what is known of the shift between voltage and readings \[s\].
const CLOCKS: f64 = 5e-6;

/// A device with its laws and rig, as recordings are made of it.
struct Bench<'a> {
    plain: &'a Device,
    instruments: &'a Instruments,
    excitations: &'a [Excitation],
}

/// One motion with what is needed to judge it.
struct Motion {
    run: Run,
    plain: Device,
    pieces: Vec<Piece>,
    /// Sample times in the motion's clock.
    times: Vec<f64>,
}

impl Bench<'_> {
    /// The motion of recording `number`, read by instruments without scale, zero and
    /// noise.
    fn motion(&self, laws: &[&Law], number: usize) -> Result<Motion, RunError> {
        let e = &self.excitations[number];
        let rate = self.instruments.rate;
        let count = (e.duration * rate).round() as usize + 1;
        let clock = |i: usize| i as f64 / rate;
        let late: f64 = laws.iter().map(|law| law.delay()).sum();
        let times: Vec<f64> = (0..count)
            .map(|i| clock(i) - self.instruments.skew)
            .collect();
        let read_at: Vec<f64> = times.iter().map(|t| t - late).collect();
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
    fn visibility(&self, law: &Law) -> Result<f64, RunError> {
        // A pure delay is a shift of the clocks and nothing else: it shows by as much as it
        // exceeds what these may be apart. The linear bound would see it in every jump.
        if law.delay() > 0.0 {
            return Ok(law.delay() / CLOCKS / JUST_VISIBLE);
        }
        let fitted = (0..self.excitations.len()).filter(|i| !self.excitations[*i].held_out);
        let motions = fitted
            .map(|i| self.motion(&[law], i))
            .collect::<Result<Vec<_>, _>>()?;
        let made: Vec<Made<'_>> = motions
            .iter()
            .map(|m| Made {
                run: &m.run,
                plain: &m.plain,
                pieces: &m.pieces,
                times: &m.times,
            })
            .collect();
        Ok(deviations(&made, self.instruments)? / JUST_VISIBLE)
    }

    /// Brings a choice near `target` times the smallest visible, within what is
    /// realistic; returns it with the size it really has.
    fn sized(&self, choice: Choice, target: f64) -> Result<(Choice, f64), RunError> {
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
    let bench = Bench {
        plain,
        instruments,
        excitations: &excitations(),
    };
    bench.visibility(law)
}

/// Ids to conceal, their targets, and the class.
fn conceal(mix: &Mix, dice: &mut Dice) -> (Class, Vec<String>) {
    let lot = dice.between(0.0, 1.0);
    let class = match mix {
        Mix::Only(class) => *class,
        Mix::Effect(id) if id.starts_with("outside_") => Class::Outside,
        Mix::Effect(_) => Class::One,
        Mix::Standard if lot < 0.25 => Class::Nothing,
        Mix::Standard if lot < 0.75 => Class::One,
        Mix::Standard if lot < 0.9 => Class::Two,
        Mix::Standard => Class::Outside,
    };
    // A constant weight goes into the zero: it is a decoy only.
    let shown = CATALOGUE.len() - 1;
    let ids = match (mix, class) {
        (Mix::Effect(id), _) => vec![id.clone()],
        (_, Class::Nothing) => Vec::new(),
        (_, Class::One) => vec![CATALOGUE[dice.below(shown)].to_owned()],
        (_, Class::Two) => {
            let first = dice.below(shown);
            let second = (first + 1 + dice.below(shown - 1)) % shown;
            vec![CATALOGUE[first].to_owned(), CATALOGUE[second].to_owned()]
        }
        (_, Class::Outside) => vec![OUTSIDE[dice.below(OUTSIDE.len())].to_owned()],
    };
    (class, ids)
}

impl Case {
    /// Draws the trial of `seed`.
    ///
    /// # Errors
    /// [`TrialError`] if the settings make no sense or no device can be followed.
    pub fn draw(seed: u64, settings: &Settings) -> Result<Self, TrialError> {
        let bad = |what, value, remedy| {
            Err(TrialError::Setting {
                what,
                value,
                remedy,
            })
        };
        if !(settings.noise > 0.0 && settings.noise < 1e-5) {
            return bad("noise", settings.noise, "give metres above 0, below 10 um");
        }
        if !(1e3..=1e7).contains(&settings.rate) {
            return bad("rate", settings.rate, "give 1 kHz to 10 MHz");
        }
        if let Mix::Effect(id) = &settings.mix
            && !CATALOGUE.contains(&id.as_str())
            && !OUTSIDE.contains(&id.as_str())
        {
            return Err(TrialError::UnknownEffect(id.clone()));
        }
        let mut last = String::from("the structure is singular");
        for attempt in 0..ATTEMPTS {
            match Self::attempt(seed, attempt, settings) {
                Ok(Some(parts)) => return parts.seal(),
                Ok(None) => {}
                Err(error) => last = error.to_string(),
            }
        }
        Err(TrialError::NoDevice { seed, last })
    }

    fn attempt(seed: u64, attempt: u64, settings: &Settings) -> Result<Option<Parts>, RunError> {
        let mut dice = Dice::new(seed, 16 * attempt);
        let drawn = if dice.chance(0.5) {
            StructureKind::Beam
        } else {
            StructureKind::Lumped
        };
        let structure = settings.structure.unwrap_or(drawn);
        let excitations = excitations();
        let Some((plain, parameters)) = device(structure, &mut dice) else {
            return Ok(None);
        };
        let instruments = instruments(
            settings.rate,
            settings.noise,
            settings.cantilever,
            excitations.len(),
            &mut dice,
        );
        let bench = Bench {
            plain: &plain,
            instruments: &instruments,
            excitations: &excitations,
        };
        let (class, ids) = conceal(&settings.mix, &mut dice);
        let mut hidden: Vec<(Choice, f64)> = Vec::new();
        for id in &ids {
            let low = if class == Class::One { 0.5 } else { 3.0 };
            let target = dice.log_between(low, 30.0);
            let Some(choice) = choose(id, &plain, &mut dice) else {
                return Ok(None);
            };
            hidden.push(bench.sized(choice, target)?);
        }
        let mut decoys: Vec<(Choice, f64)> = Vec::new();
        if class == Class::Nothing && dice.chance(0.4) {
            let decoy = if dice.chance(0.5) {
                choose("gravity", &plain, &mut dice)
            } else {
                // As elastic as the gas of the room is at this gap.
                choose("film_spring", &plain, &mut dice).map(|mut film| {
                    film.law = Law::Film {
                        tau: dice.log_between(1.0e-6, 2e-6),
                        power: 0,
                    };
                    film.formulation = "gas of the room";
                    film
                })
            };
            if let Some(decoy) = decoy {
                let size = bench.visibility(&decoy.law)?;
                // One that could be seen is no decoy. A weight is absorbed by zero, gap,
                // ground and adhesion; only the linear bound sees it.
                if size < 0.5 || decoy.id == "gravity" {
                    decoys.push((decoy, size));
                }
            }
        }
        let laws: Vec<&Law> = hidden.iter().chain(&decoys).map(|(c, _)| &c.law).collect();
        let noise_seed = dice.seed();
        let mut columns = Vec::with_capacity(excitations.len());
        for number in 0..excitations.len() {
            let motion = bench.motion(&laws, number)?;
            let [mut xp, mut xc] = [motion.run.proof_mass, motion.run.cantilever];
            let [zero_p, zero_c] = instruments.zeros[number];
            let mut noise_p = Dice::new(noise_seed, 2 * number as u64);
            let mut noise_c = Dice::new(noise_seed, 2 * number as u64 + 1);
            instruments.read(&mut xp, instruments.scale_p, zero_p, &mut noise_p);
            instruments.read(&mut xc, instruments.scale_c, zero_c, &mut noise_c);
            let time: Vec<f64> = (0..xp.len()).map(|i| i as f64 / settings.rate).collect();
            // The recorder shows what the source gives, not what the piezo sees.
            let v = time.iter().map(|t| voltage(&motion.pieces, *t)).collect();
            columns.push((time, v, xp, settings.cantilever.then_some(xc)));
        }
        let note = |(choice, size): &(Choice, f64)| ConcealedEffect {
            id: choice.id.clone(),
            formulation: choice.formulation.to_owned(),
            times_smallest_visible: *size,
            size_nn: choice.law.size(&plain).map(|f| 1e9 * f),
            law: serde_json::to_value(&choice.law).unwrap_or_default(),
        };
        let notes = excitations
            .iter()
            .map(|e| RecordingNote {
                name: e.waveform.text().replace(':', " "),
                drive: e.waveform.text(),
                duration: e.duration,
                held_out: e.held_out,
            })
            .collect();
        Ok(Some(Parts {
            truth: Truth {
                format: 1,
                seed,
                class,
                structure,
                device: parameters,
                effects: hidden.iter().map(note).collect(),
                decoys: decoys.iter().map(note).collect(),
                recordings: notes,
                instruments: instruments.clone(),
            },
            columns,
        }))
    }

    /// The recordings alone: what a diagnosis is given.
    #[must_use]
    pub fn recordings(&self) -> &Recordings {
        &self.recordings
    }

    /// SHA-256 of the truth file.
    #[must_use]
    pub fn seal(&self) -> &str {
        self.envelope.seal()
    }

    /// The truth: opens the trial.
    #[must_use]
    pub fn truth(&self) -> &Truth {
        self.envelope.peek()
    }

    /// Recordings and envelope apart, so that the truth can be kept elsewhere.
    #[must_use]
    pub fn into_parts(self) -> (Recordings, Envelope) {
        (self.recordings, self.envelope)
    }
}

type Columns = (Vec<f64>, Vec<f64>, Vec<f64>, Option<Vec<f64>>);

/// A trial before it is sealed.
struct Parts {
    truth: Truth,
    columns: Vec<Columns>,
}

impl Parts {
    fn seal(self) -> Result<Case, TrialError> {
        let mut recordings = Recordings {
            train: Vec::new(),
            held_out: Vec::new(),
        };
        for (note, (t, v, xp, xc)) in self.truth.recordings.iter().zip(self.columns) {
            let recording = Recording::new(&note.name, t, Some(v), xp, xc).map_err(|error| {
                TrialError::NoDevice {
                    seed: self.truth.seed,
                    last: error.to_string(),
                }
            })?;
            let group = if note.held_out {
                &mut recordings.held_out
            } else {
                &mut recordings.train
            };
            group.push(Arc::new(recording));
        }
        Ok(Case {
            recordings,
            envelope: Envelope::close(self.truth)?,
        })
    }
}
