//! One attempt at a trial: what it conceals is drawn, the recordings are made, and the
//! whole is sealed.

use std::sync::Arc;

use super::size::Bench;
use super::{Case, Mix, Recordings, Settings, TrialError};
use crate::recording::Recording;
use crate::trial::concealed::concealed_effects::{CATALOGUE, Choice, OUTSIDE, choose};
use crate::trial::concealed::law::Law;
use crate::trial::device::reference_device::excitations;
use crate::trial::hybrid::RunError;
use crate::trial::instrument::{StructureKind, device, instruments};
use crate::trial::rng::Dice;
use crate::trial::truth::{Class, ConcealedEffect, Envelope, RecordingNote, Truth};
use crate::trial::voltage::voltage;

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
    pub(crate) fn attempt(
        seed: u64,
        attempt: u64,
        settings: &Settings,
    ) -> Result<Option<Parts>, RunError> {
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
        // A ground that gives way rebounds by its own law: no other shows beside it.
        if ["compliant_ground", "velocity_restitution"]
            .iter()
            .all(|id| ids.iter().any(|i| i == id))
        {
            return Ok(None);
        }
        let mut hidden: Vec<(Choice, f64)> = Vec::new();
        for id in &ids {
            let low = if class == Class::One { 0.5 } else { 3.0 };
            let target = dice.log_between(low, 30.0);
            let Some(choice) = choose(id, &plain, &mut dice) else {
                return Ok(None);
            };
            hidden.push(if settings.realistic {
                let size = bench.visibility(&choice.law)?;
                (choice, size)
            } else {
                bench.sized(choice, target)?
            });
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
}

type Columns = (Vec<f64>, Vec<f64>, Vec<f64>, Option<Vec<f64>>);

/// A trial before it is sealed.
pub(crate) struct Parts {
    truth: Truth,
    columns: Vec<Columns>,
}

impl Parts {
    pub(crate) fn seal(self) -> Result<Case, TrialError> {
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
