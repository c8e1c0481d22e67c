//! One attempt at a trial of an impact actuator: what it conceals is drawn, and the recordings are
//! made.

use super::concealed_ids::{conceal, target_size};
use super::parts::{Columns, Parts};
use super::settings::Settings;
use super::size::TrialSetup;
use crate::trial::concealed::concealed_effects::{Choice, OUTSIDE, choose, drawn_effects, same_as};
use crate::trial::concealed::law::Law;
use crate::trial::device::reference_device::excitations;
use crate::trial::hybrid::RunError;
use crate::trial::instrument::{StructureKind, device, instruments};
use crate::trial::rig::ActuatorRig;
use crate::trial::rng::TrialRng;
use crate::trial::truth::{Class, ConcealedEffect, DeviceTruth, FORMAT, RecordingNote, Truth};
use crate::trial::voltage::voltage;

/// Streams of the noise of a recording: proof mass, cantilever, voltage, written times, and the walks
/// of both zeros. The first two alternate, the others begin here.
const FURTHER_STREAMS: u64 = 1000;

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
        let target = target_size(settings, class, rng);
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

/// What the recorder shows of every recording.
fn read_motions(
    setup: &TrialSetup<'_>,
    laws: &[&Law],
    noise_seed: u64,
) -> Result<Vec<Columns>, RunError> {
    let instruments = setup.instruments;
    let mut all = Vec::with_capacity(setup.excitations.len());
    for number in 0..setup.excitations.len() {
        let motion = setup.motion(laws, number)?;
        let [mut xp, mut xc] = [motion.run.proof_mass, motion.run.cantilever];
        let [zero_p, zero_c] = instruments.zeros[number];
        let [scale_p, scale_c] = instruments.scales(number);
        let mut noise_p = TrialRng::new(noise_seed, 2 * number as u64);
        let mut noise_c = TrialRng::new(noise_seed, 2 * number as u64 + 1);
        let further =
            |which: u64| TrialRng::new(noise_seed, FURTHER_STREAMS + 4 * number as u64 + which);
        instruments.read(&mut xp, scale_p, zero_p, &mut noise_p);
        instruments.read(&mut xc, scale_c, zero_c, &mut noise_c);
        instruments.walk(&mut xp, &mut further(0));
        instruments.walk(&mut xc, &mut further(1));
        instruments.round(&mut xp);
        let time = instruments.stamps(xp.len(), &mut further(2));
        // The recorder shows what the source gives, not what the piezo sees.
        let mut v: Vec<f64> = (0..xp.len())
            .map(|i| voltage(&motion.pieces, instruments.instant(i)))
            .collect();
        instruments.read_voltage(&mut v, &mut further(3));
        all.push(Columns {
            time,
            voltage: Some(v),
            proof_mass: xp,
            cantilever: instruments.cantilever.then_some(xc),
        });
    }
    Ok(all)
}

/// One attempt; `rng` draws device and effect, `own` what is special to the rig. `None` if the draws
/// do not go together.
///
/// # Errors
/// [`RunError`] if the device cannot be followed.
pub(super) fn attempt_actuator(
    seed: u64,
    rig: &ActuatorRig,
    settings: &Settings,
    mut rng: TrialRng,
    mut own: TrialRng,
) -> Result<Option<Parts>, RunError> {
    let drawn = if rng.happens(0.5) {
        StructureKind::Beam
    } else {
        StructureKind::Lumped
    };
    let structure = rig.structure.unwrap_or(drawn);
    let excitations = excitations();
    let Some((plain, parameters)) = device(structure, &mut rng) else {
        return Ok(None);
    };
    let usual = instruments(
        rig.rate,
        rig.noise,
        rig.cantilever,
        excitations.len(),
        &mut rng,
    );
    let instruments = usual.with(rig.imperfections, rig.skew_stretch, &mut own);
    let setup = TrialSetup {
        plain: &plain,
        instruments: &instruments,
        excitations: &excitations,
    };
    let effects: Vec<&str> = drawn_effects().collect();
    let (class, ids) = conceal(&settings.mix, &effects, &OUTSIDE, &mut rng);
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
    let columns = read_motions(&setup, &laws, rng.seed())?;
    let note = |(choice, size): &(Choice, f64)| ConcealedEffect {
        id: choice.id.clone(),
        formulation: choice.formulation.to_owned(),
        times_smallest_visible: *size,
        size_nn: choice.law.size(&plain).map(|f| 1e9 * f),
        law: serde_json::to_value(&choice.law).unwrap_or_default(),
        same_as: (same_as(&choice.id).iter())
            .map(|id| (*id).to_owned())
            .collect(),
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
            format: FORMAT,
            seed,
            rig: None,
            units: None,
            class,
            structure: Some(structure),
            device: DeviceTruth::Actuator(parameters),
            effects: hidden.iter().map(note).collect(),
            decoys: decoys.iter().map(note).collect(),
            recordings: notes,
            instruments: instruments.clone(),
        },
        columns,
        preset: None,
    }))
}
