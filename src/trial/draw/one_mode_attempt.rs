//! One attempt at a trial of a one-mode device.

use super::concealed_ids::{conceal, target_size};
use super::parts::{Columns, Parts};
use super::settings::Settings;
use crate::trial::instrument::{Imperfections, Instruments};
use crate::trial::one_mode::apparatus::{Apparatus, OneModeRig};
use crate::trial::one_mode::law::OneModeLaw;
use crate::trial::one_mode::law_draws::{SINE_STIFFNESS, are_alike, draw, same_as};
use crate::trial::one_mode::motion::motion;
use crate::trial::one_mode::size::Bound;
use crate::trial::rng::TrialRng;
use crate::trial::truth::{ConcealedEffect, DeviceTruth, FORMAT, RecordingNote, Truth};

/// Largest swing of a pendulum \[rad\], and the smallest that is drawn.
const SWINGS: (f64, f64) = (0.02, 1.3);
/// How often the swing of a pendulum is brought nearer the size asked for.
const MAX_SWING_SEARCHES: usize = 4;

/// A law with what the truth says of it.
struct Hidden {
    id: String,
    formulation: &'static str,
    law: OneModeLaw,
    size: f64,
}

/// The apparatus whose swings make the sine as large as `target`; `None` if it cannot be followed.
fn swung(apparatus: Apparatus, target: f64, rng: &TrialRng) -> Option<Apparatus> {
    let mut apparatus = apparatus;
    for _ in 0..MAX_SWING_SEARCHES {
        let (_, law) = draw(SINE_STIFFNESS, &apparatus, &mut rng.clone())?;
        let size = 1.0 / Bound::new(&apparatus)?.just_visible(&law)?;
        // Its trace grows with the third power of the swing.
        let reach = apparatus.amplitude();
        let wish = reach * (target / size).cbrt();
        apparatus = apparatus.with_swings(wish.clamp(SWINGS.0, SWINGS.1) / reach);
    }
    Some(apparatus)
}

/// Draws the laws, each brought to its size.
fn hide(
    apparatus: &mut Apparatus,
    ids: &[String],
    targets: &[f64],
    rng: &mut TrialRng,
) -> Option<Vec<Hidden>> {
    let sine = ids.iter().position(|id| id == SINE_STIFFNESS);
    if let Some(which) = sine.filter(|_| apparatus.swings) {
        *apparatus = swung(apparatus.clone(), targets[which], rng)?;
    }
    let mut hidden = Vec::with_capacity(ids.len());
    if ids.is_empty() {
        return Some(hidden);
    }
    let bound = Bound::new(apparatus)?;
    for (id, target) in ids.iter().zip(targets) {
        let (formulation, law) = draw(id, apparatus, rng)?;
        let visible = bound.just_visible(&law)?;
        // Not stronger than is realistic; the swing has decided of a pendulum's sine.
        let factor = if apparatus.swings && id == SINE_STIFFNESS {
            1.0
        } else {
            (target * visible).min(1.0)
        };
        hidden.push(Hidden {
            id: id.clone(),
            formulation,
            law: law.scaled(factor),
            size: factor / visible,
        });
    }
    Some(hidden)
}

/// The recordings, with noise from `noise_seed`.
fn read_runs(
    apparatus: &Apparatus,
    instruments: &Instruments,
    laws: &[&OneModeLaw],
    noise_seed: u64,
) -> Option<Vec<Columns>> {
    let mut all = Vec::with_capacity(apparatus.runs.len());
    for (number, run) in apparatus.runs.iter().enumerate() {
        let time = apparatus.times(run);
        let mut x = motion(apparatus, laws, number, &time)?;
        let mut noise = TrialRng::new(noise_seed, number as u64);
        let [zero, _] = instruments.zeros[number];
        instruments.read(&mut x, instruments.scale_p, zero, &mut noise);
        instruments.round(&mut x);
        all.push(Columns {
            time,
            voltage: None,
            proof_mass: x,
            cantilever: None,
        });
    }
    Some(all)
}

/// One attempt; `None` if the draws do not go together, or a run cannot be followed.
pub(super) fn attempt_one_mode(
    seed: u64,
    rig: &OneModeRig,
    apparatus: Apparatus,
    settings: &Settings,
    mut rng: TrialRng,
) -> Option<Parts> {
    let mut apparatus = apparatus;
    let (class, ids) = conceal(&settings.mix, rig.effects, rig.outside, &mut rng);
    if let [a, b] = ids.as_slice()
        && are_alike(a, b)
    {
        return None;
    }
    let targets: Vec<f64> = (ids.iter())
        .map(|_| target_size(settings, class, &mut rng))
        .collect();
    let hidden = hide(&mut apparatus, &ids, &targets, &mut rng)?;
    let reading = apparatus.reading;
    let instruments = Instruments {
        rate: reading.rate,
        noise: reading.noise,
        coloured_share: 0.0,
        coloured_time: 1.0 / reading.rate,
        skew: 0.0,
        scale_p: reading.scale,
        scale_c: 1.0,
        zeros: vec![[reading.zero, 0.0]; apparatus.runs.len()],
        cantilever: false,
        reading_step: reading.step,
        scale_errors: Vec::new(),
        imperfections: Imperfections::default(),
    };
    let laws: Vec<&OneModeLaw> = hidden.iter().map(|h| &h.law).collect();
    let columns = read_runs(&apparatus, &instruments, &laws, rng.seed())?;
    let reach = apparatus.amplitude();
    let fall = (2.0 * apparatus.device.gravity * reach).sqrt();
    let speed = fall.max(apparatus.omega() * reach);
    let force = |law: &OneModeLaw| 1e9 * apparatus.device.mass * law.size(reach, speed);
    let effects = hidden
        .iter()
        .map(|h| ConcealedEffect {
            id: h.id.clone(),
            formulation: h.formulation.to_owned(),
            times_smallest_visible: h.size,
            size_nn: Some(force(&h.law)),
            law: serde_json::to_value(&h.law).unwrap_or_default(),
            same_as: same_as(&h.id).iter().map(|id| (*id).to_owned()).collect(),
        })
        .collect();
    let recordings = (apparatus.runs.iter().enumerate())
        .map(|(i, run)| RecordingNote {
            name: format!("run {}", i + 1),
            drive: "rest".to_owned(),
            duration: run.duration,
            held_out: run.held_out,
        })
        .collect();
    Some(Parts {
        truth: Truth {
            format: FORMAT,
            seed,
            rig: None,
            units: None,
            class,
            structure: None,
            device: DeviceTruth::OneMode(apparatus.device),
            instruments,
            effects,
            decoys: Vec::new(),
            recordings,
        },
        columns,
        preset: Some(apparatus.preset()),
    })
}
