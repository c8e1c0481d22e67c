//! Draws a trial from a seed: its rig, then as many devices as it takes until one can be followed.

use super::actuator_attempt::attempt_actuator;
use super::case::{Case, TrialError};
use super::one_mode_attempt::attempt_one_mode;
use super::parts::Parts;
use super::settings::{Mix, RigChoice, Settings};
use crate::trial::concealed::concealed_effects::{CATALOGUE, OUTSIDE};
use crate::trial::instrument::Imperfections;
use crate::trial::rig::{ActuatorRig, Maker, RigSpec};
use crate::trial::rigs::{self, RIGS};
use crate::trial::rng::TrialRng;
use crate::trial::truth::Class;

/// Devices that are drawn before a seed is given up.
const MAX_ATTEMPTS: u64 = 12;
/// Streams of random numbers of each attempt; the first is that of device and effect.
const STREAMS_OF_ATTEMPT: u64 = 16;
/// The stream of a rig's own numbers.
const RIG_STREAM: u64 = 8;
/// The stream of other units.
const UNITS_STREAM: u64 = 9;

impl Case {
    /// Draws the trial of `seed`.
    ///
    /// # Errors
    /// [`TrialError`] if the settings make no sense or no device can be followed.
    pub fn draw(seed: u64, settings: &Settings) -> Result<Self, TrialError> {
        check(settings)?;
        let rig = rig_of(seed, settings)?;
        let mut last = String::from("the structure is singular");
        for attempt in 0..MAX_ATTEMPTS {
            match make(rig, seed, attempt, settings) {
                Ok(Some(parts)) => return parts.seal(),
                Ok(None) => {}
                Err(error) => last = error,
            }
        }
        Err(TrialError::NoDevice { seed, last })
    }
}

fn check(settings: &Settings) -> Result<(), TrialError> {
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
    if let Some((low, high)) = settings.sizes
        && !(low > 0.0 && low <= high && high <= 1e3)
    {
        return Err(TrialError::Sizes { low, high });
    }
    if let Mix::Effect(id) = &settings.mix
        && !of_actuators().contains(&id.as_str())
        && !RIGS.iter().any(|rig| can_conceal(rig, &settings.mix))
    {
        return Err(TrialError::UnknownEffect(id.clone()));
    }
    Ok(())
}

/// All that an impact actuator can conceal.
fn of_actuators() -> Vec<&'static str> {
    CATALOGUE.iter().chain(&OUTSIDE).copied().collect()
}

fn can_conceal(rig: &RigSpec, mix: &Mix) -> bool {
    match mix {
        Mix::Only(Class::Two) => rig.conceals_two(),
        Mix::Standard | Mix::Only(_) => true,
        Mix::Effect(id) => rig.conceals(id, &of_actuators()),
    }
}

/// The rig of a seed; `None` for that of the settings' own numbers.
fn rig_of(seed: u64, settings: &Settings) -> Result<Option<&'static RigSpec>, TrialError> {
    match &settings.rig {
        RigChoice::OfSettings => match &settings.mix {
            Mix::Effect(id) if !of_actuators().contains(&id.as_str()) => {
                Err(TrialError::UnknownEffect(id.clone()))
            }
            _ => Ok(None),
        },
        RigChoice::Named(name) => {
            let Some(rig) = rigs::find(name) else {
                return Err(TrialError::UnknownRig {
                    name: name.clone(),
                    known: RIGS.map(|rig| rig.id).join(", "),
                });
            };
            if can_conceal(rig, &settings.mix) {
                Ok(Some(rig))
            } else {
                Err(not_in_rig(rig, &settings.mix))
            }
        }
        RigChoice::Each => {
            let able: Vec<&'static RigSpec> = RIGS
                .into_iter()
                .filter(|rig| can_conceal(rig, &settings.mix))
                .collect();
            // `check` has seen that there is one.
            let next = seed.checked_rem(able.len() as u64).unwrap_or(0) as usize;
            Ok(able.get(next).copied())
        }
    }
}

fn not_in_rig(rig: &RigSpec, mix: &Mix) -> TrialError {
    let what = match mix {
        Mix::Effect(id) => id.clone(),
        _ => "two effects".to_owned(),
    };
    let instead = match rig.maker {
        Maker::OneMode(one) => [one.effects, one.outside].concat().join(", "),
        _ => "none, one, two, outside and the effects of the catalogue".to_owned(),
    };
    TrialError::NotInRig {
        rig: rig.id.to_owned(),
        what,
        instead,
    }
}

/// One attempt; `None` if its draws do not go together.
fn make(
    rig: Option<&'static RigSpec>,
    seed: u64,
    attempt: u64,
    settings: &Settings,
) -> Result<Option<Parts>, String> {
    let stream = |number: u64| TrialRng::new(seed, STREAMS_OF_ATTEMPT * attempt + number);
    let mut parts = match rig.map(|rig| rig.maker) {
        None => {
            let own = ActuatorRig {
                structure: settings.structure,
                cantilever: settings.cantilever,
                noise: settings.noise,
                rate: settings.rate,
                skew_stretch: 1.0,
                imperfections: Imperfections::default(),
            };
            attempt_actuator(seed, &own, settings, stream(0), stream(RIG_STREAM))
        }
        Some(Maker::Actuator(draw)) => {
            let mut own = stream(RIG_STREAM);
            let drawn = draw(&mut own);
            attempt_actuator(seed, &drawn, settings, stream(0), own)
        }
        Some(Maker::OneMode(one)) => {
            let apparatus = (one.draw)(&mut stream(RIG_STREAM));
            return Ok(attempt_one_mode(seed, one, apparatus, settings, stream(0))
                .map(|parts| named(parts, rig)));
        }
        Some(Maker::InOtherUnits(of, draw)) => {
            let mut own = stream(UNITS_STREAM);
            let able: Vec<&'static RigSpec> = (of.iter().copied())
                .filter(|rig| can_conceal(rig, &settings.mix))
                .collect();
            let base = able.get(own.below(able.len())).copied();
            let units = draw(&mut own);
            return match make(base, seed, attempt, settings)? {
                Some(parts) => (parts.in_other_units(units))
                    .map(|parts| Some(named(parts, rig)))
                    .map_err(|error| error.to_string()),
                None => Ok(None),
            };
        }
    }
    .map_err(|error| error.to_string())?;
    parts = parts.map(|parts| named(parts, rig));
    Ok(parts)
}

/// The parts with the name of their rig in the truth.
fn named(mut parts: Parts, rig: Option<&'static RigSpec>) -> Parts {
    parts.truth.rig = rig.map(|rig| rig.id.to_owned());
    parts
}
