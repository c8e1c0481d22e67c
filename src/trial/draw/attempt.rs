//! One attempt at a trial: what it conceals is drawn, the recordings are made, and the
//! whole is sealed.

use std::sync::Arc;

use super::size::TrialSetup;
use super::{Case, Mix, Recordings, Settings, TrialError};
use crate::recording::Recording;
use crate::trial::concealed::concealed_effects::{Choice, OUTSIDE, choose, drawn_effects};
use crate::trial::concealed::law::Law;
use crate::trial::device::reference_device::excitations;
use crate::trial::hybrid::RunError;
use crate::trial::instrument::{StructureKind, device, instruments};
use crate::trial::rng::TrialRng;
use crate::trial::truth::{Class, ConcealedEffect, Envelope, RecordingNote, Truth};
use crate::trial::voltage::voltage;

/// Ids to conceal, their targets, and the class.
fn conceal(mix: &Mix, rng: &mut TrialRng) -> (Class, Vec<String>) {
    let lot = rng.between(0.0, 1.0);
    let class = match mix {
        Mix::Only(class) => *class,
        Mix::Effect(id) if id.starts_with("outside_") => Class::Outside,
        Mix::Effect(_) => Class::One,
        Mix::Standard if lot < 0.25 => Class::Nothing,
        Mix::Standard if lot < 0.75 => Class::One,
        Mix::Standard if lot < 0.9 => Class::Two,
        Mix::Standard => Class::Outside,
    };
    let drawn: Vec<&str> = drawn_effects().collect();
    let shown = drawn.len();
    let ids = match (mix, class) {
        (Mix::Effect(id), _) => vec![id.clone()],
        (_, Class::Nothing) => Vec::new(),
        (_, Class::One) => vec![drawn[rng.below(shown)].to_owned()],
        (_, Class::Two) => {
            let first = rng.below(shown);
            let second = (first + 1 + rng.below(shown - 1)) % shown;
            vec![drawn[first].to_owned(), drawn[second].to_owned()]
        }
        (_, Class::Outside) => vec![OUTSIDE[rng.below(OUTSIDE.len())].to_owned()],
    };
    (class, ids)
}

/// Draws a law for each id and brings it to a size over the smallest visible; `None` if an id
/// has no law for this device.
fn draw_hidden(
    setup: &TrialSetup<'_>,
    ids: &[String],
    class: Class,
    settings: &Settings,
    rng: &mut TrialRng,
) -> Result<Option<Vec<(Choice, f64)>>, RunError> {
    let mut hidden: Vec<(Choice, f64)> = Vec::new();
    for id in ids {
        let low = if class == Class::One { 0.5 } else { 3.0 };
        let target = rng.log_between(low, 30.0);
        let Some(choice) = choose(id, setup.plain, rng) else {
            return Ok(None);
        };
        hidden.push(if settings.realistic {
            let size = setup.visibility(&choice.law)?;
            (choice, size)
        } else {
            setup.sized(choice, target)?
        });
    }
    Ok(Some(hidden))
}

/// Draws what must not be named, in some of the trials that conceal nothing: an effect too
/// small to be seen, or one that the baseline absorbs.
fn draw_decoys(
    setup: &TrialSetup<'_>,
    class: Class,
    rng: &mut TrialRng,
) -> Result<Vec<(Choice, f64)>, RunError> {
    if !(class == Class::Nothing && rng.happens(0.4)) {
        return Ok(Vec::new());
    }
    let decoy = if rng.happens(0.5) {
        choose("gravity", setup.plain, rng)
    } else {
        // As elastic as the gas of the room is at this gap.
        choose("film_spring", setup.plain, rng).map(|mut film| {
            film.law = Law::Film {
                tau: rng.log_between(1.0e-6, 2e-6),
                power: 0,
            };
            film.formulation = "gas of the room";
            film
        })
    };
    let Some(decoy) = decoy else {
        return Ok(Vec::new());
    };
    let size = setup.visibility(&decoy.law)?;
    // One that could be seen is no decoy. A weight is absorbed by zero, gap,
    // ground and adhesion; only the linear bound sees it.
    if size < 0.5 || decoy.id == "gravity" {
        Ok(vec![(decoy, size)])
    } else {
        Ok(Vec::new())
    }
}

/// The readings of every recording: time, voltage, proof mass, cantilever.
fn read_motions(
    setup: &TrialSetup<'_>,
    laws: &[&Law],
    settings: &Settings,
    noise_seed: u64,
) -> Result<Vec<Columns>, RunError> {
    let instruments = setup.instruments;
    let mut columns = Vec::with_capacity(setup.excitations.len());
    for number in 0..setup.excitations.len() {
        let motion = setup.motion(laws, number)?;
        let [mut xp, mut xc] = [motion.run.proof_mass, motion.run.cantilever];
        let [zero_p, zero_c] = instruments.zeros[number];
        let mut noise_p = TrialRng::new(noise_seed, 2 * number as u64);
        let mut noise_c = TrialRng::new(noise_seed, 2 * number as u64 + 1);
        instruments.read(&mut xp, instruments.scale_p, zero_p, &mut noise_p);
        instruments.read(&mut xc, instruments.scale_c, zero_c, &mut noise_c);
        let time: Vec<f64> = (0..xp.len()).map(|i| i as f64 / settings.rate).collect();
        // The recorder shows what the source gives, not what the piezo sees.
        let v = time.iter().map(|t| voltage(&motion.pieces, *t)).collect();
        columns.push((time, v, xp, settings.cantilever.then_some(xc)));
    }
    Ok(columns)
}

impl Case {
    pub(crate) fn attempt(
        seed: u64,
        attempt: u64,
        settings: &Settings,
    ) -> Result<Option<Parts>, RunError> {
        let mut rng = TrialRng::new(seed, 16 * attempt);
        let drawn = if rng.happens(0.5) {
            StructureKind::Beam
        } else {
            StructureKind::Lumped
        };
        let structure = settings.structure.unwrap_or(drawn);
        let excitations = excitations();
        let Some((plain, parameters)) = device(structure, &mut rng) else {
            return Ok(None);
        };
        let instruments = instruments(
            settings.rate,
            settings.noise,
            settings.cantilever,
            excitations.len(),
            &mut rng,
        );
        let setup = TrialSetup {
            plain: &plain,
            instruments: &instruments,
            excitations: &excitations,
        };
        let (class, ids) = conceal(&settings.mix, &mut rng);
        // A ground that gives way rebounds by its own law: no other shows together with it.
        if ["compliant_ground", "velocity_restitution"]
            .iter()
            .all(|id| ids.iter().any(|i| i == id))
        {
            return Ok(None);
        }
        let Some(hidden) = draw_hidden(&setup, &ids, class, settings, &mut rng)? else {
            return Ok(None);
        };
        let decoys = draw_decoys(&setup, class, &mut rng)?;
        let laws: Vec<&Law> = hidden.iter().chain(&decoys).map(|(c, _)| &c.law).collect();
        let columns = read_motions(&setup, &laws, settings, rng.seed())?;
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
