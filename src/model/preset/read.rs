//! The parts of a preset from its text, each checked.

use std::collections::BTreeMap;

use super::error::{PresetError, Source};
use super::file::File;
use super::known_value::KnownValue;
use crate::model::Model;
use crate::model::effects;
use crate::model::effects::ActiveEffect;
use crate::model::ground::{BounceRule, StickSpeed};
use crate::model::parameter::{ParameterId, Parameters};
use crate::model::piezo::Piezo;
use crate::model::structure::Mode;
use crate::model::unit::Coordinate;

pub(super) fn read_modes(source: &Source<'_>, read: &File) -> Result<Vec<Mode>, PresetError> {
    let mut modes = Vec::with_capacity(read.mode.len());
    for (i, entry) in read.mode.iter().enumerate() {
        let fail = |key: &str, reason: &str| source.invalid("mode", i, key, reason.to_owned());
        for (key, value) in [("mass", entry.mass), ("stiffness", entry.stiffness)] {
            if let Some(value) = value
                && !(value.is_finite() && value >= 0.0)
            {
                return Err(fail(key, "must be a finite number and not negative"));
            }
        }
        if entry.mass == Some(0.0) {
            return Err(fail("mass", "must be above 0 kg"));
        }
        let (phi_p, frequency) = match (entry.mass, entry.stiffness, entry.phi_p) {
            (Some(mass), Some(stiffness), None) => (
                1.0 / mass.sqrt(),
                Some((stiffness / mass).sqrt() / std::f64::consts::TAU),
            ),
            (None, None, Some(phi_p)) => (phi_p, entry.frequency),
            _ => {
                return Err(fail(
                    "phi_p",
                    "give a mode either phi_p (and phi_c), or mass and stiffness",
                ));
            }
        };
        let phi_c = entry.phi_c.unwrap_or(0.0);
        modes.push(Mode {
            // The first two are set from the parameters, if those name them.
            frequency: frequency.unwrap_or(if i == 0 { 623.0 } else { 6424.0 }),
            zeta: entry.zeta.unwrap_or(0.0),
            phi_c,
            phi_p,
            phi_drive: entry.phi_drive.unwrap_or(phi_c),
        });
        if i >= 2 && (frequency.is_none() || entry.zeta.is_none()) {
            return Err(fail(
                "frequency",
                "a third or further mode needs its frequency and zeta here",
            ));
        }
    }
    Ok(modes)
}

/// The drive, if there is one: `gain` for both directions of the voltage, or `rising` and
/// `falling`. Higher powers that are not given are zero.
pub(super) fn read_piezo(source: &Source<'_>, read: &File) -> Result<Option<Piezo>, PresetError> {
    let Some(entry) = &read.piezo else {
        return Ok(None);
    };
    let fail = |key: &str, reason: String| source.invalid("piezo", 0, key, reason);
    let polynomial = |key: &str, given: &[f64]| {
        let mut all = [0.0; 4];
        if given.is_empty() || given.len() > all.len() {
            let reason = format!(
                "{} coefficients; give one to {}, the constant first",
                given.len(),
                all.len()
            );
            return Err(fail(key, reason));
        }
        if given.iter().any(|c| !c.is_finite()) {
            return Err(fail(
                key,
                "the coefficients must be finite numbers".to_owned(),
            ));
        }
        all.iter_mut().zip(given).for_each(|(to, c)| *to = *c);
        Ok(all)
    };
    match (&entry.gain, &entry.rising, &entry.falling) {
        (Some(gain), None, None) => Ok(Some(Piezo::without_hysteresis(polynomial("gain", gain)?))),
        (None, Some(rising), Some(falling)) => Ok(Some(Piezo {
            rising: polynomial("rising", rising)?,
            falling: polynomial("falling", falling)?,
        })),
        (Some(_), ..) => Err(fail(
            "gain",
            "give either gain, for both directions of the voltage, or rising and falling"
                .to_owned(),
        )),
        (None, Some(_), None) => Err(fail(
            "rising",
            "falling is missing; for a drive without hysteresis write gain instead".to_owned(),
        )),
        (None, None, Some(_)) => Err(fail(
            "falling",
            "rising is missing; for a drive without hysteresis write gain instead".to_owned(),
        )),
        (None, None, None) => Err(fail(
            "gain",
            "give gain, or rising and falling, or leave [piezo] out".to_owned(),
        )),
    }
}

/// What the coordinates of the device are.
pub(super) fn read_coordinate(source: &Source<'_>, read: &File) -> Result<Coordinate, PresetError> {
    match read.device.coordinate.as_deref() {
        None => Ok(Coordinate::Length),
        Some(text) => Coordinate::find(text).ok_or_else(|| {
            let reason = format!("{text:?} is no coordinate; there are length, angle");
            source.invalid("device", 0, "coordinate", reason)
        }),
    }
}

/// The rule by which the mass bounces. Keys of it that do not go with the others are refused: they
/// would have no effect.
pub(super) fn read_bounce(source: &Source<'_>, read: &File) -> Result<BounceRule, PresetError> {
    let device = &read.device;
    let fail = |key: &str, reason: String| Err(source.invalid("device", 0, key, reason));
    let stick = [
        ("stick_speed", device.stick_speed),
        ("adhesion_reach", device.adhesion_reach),
    ];
    let given = stick.iter().find(|(_, value)| value.is_some());
    if let Some(bounce) = device.bounce.as_deref()
        && !device.ground
    {
        return fail(
            "bounce",
            format!("a device without a ground has no rule {bounce:?}; leave it out"),
        );
    }
    match device.bounce.as_deref() {
        None | Some("pull-off") => match given {
            None => Ok(BounceRule::PullOff),
            Some((key, _)) => fail(
                key,
                format!("{key} belongs to bounce = \"restitution\", which is not set"),
            ),
        },
        Some("restitution") => match (device.stick_speed, device.adhesion_reach) {
            (None, None) => Ok(BounceRule::Restitution(StickSpeed::default())),
            (Some(speed), None) => Ok(BounceRule::Restitution(StickSpeed::Given(speed))),
            (None, Some(reach)) => Ok(BounceRule::Restitution(StickSpeed::AdhesionOver(reach))),
            (Some(_), Some(_)) => fail(
                "adhesion_reach",
                "give either stick_speed or adhesion_reach, not both".to_owned(),
            ),
        },
        Some(other) => fail(
            "bounce",
            format!("{other:?} is no rule; there are pull-off, restitution"),
        ),
    }
}

pub(super) fn read_parameters(
    source: &Source<'_>,
    read: &File,
    modes: &[Mode],
) -> Result<Parameters, PresetError> {
    let mut parameters = Parameters::default();
    for (mode, id) in modes.iter().zip([ParameterId::F1, ParameterId::F2]) {
        parameters.set(id, mode.frequency);
    }
    for (key, value) in &read.parameters {
        let id = known_parameter(source, "parameters", key)?;
        parameters.set(id, *value);
    }
    Ok(parameters)
}

fn known_parameter(
    source: &Source<'_>,
    section: &str,
    key: &str,
) -> Result<ParameterId, PresetError> {
    ParameterId::from_id(key).ok_or_else(|| {
        let known: Vec<&str> = ParameterId::ALL.iter().map(|p| p.spec().id).collect();
        let reason = format!("there is no such parameter; there are {}", known.join(", "));
        source.invalid(section, 0, key, reason)
    })
}

pub(super) fn read_ranges(
    source: &Source<'_>,
    read: &File,
) -> Result<BTreeMap<ParameterId, (f64, f64)>, PresetError> {
    let mut ranges = BTreeMap::new();
    for (key, &(low, high)) in &read.ranges {
        let id = known_parameter(source, "ranges", key)?;
        let spec = id.spec();
        let positive = spec.scale == crate::model::parameter::Scale::Linear || low > 0.0;
        let inside = spec.refusal(low).is_none() && spec.refusal(high).is_none();
        if !(low < high && positive && inside) {
            let reason = format!("[{low}, {high}] is no range for {}", spec.id);
            return Err(source.invalid("ranges", 0, key, reason));
        }
        ranges.insert(id, (low, high));
    }
    Ok(ranges)
}

pub(super) fn read_known(
    source: &Source<'_>,
    read: &File,
    model: &Model,
) -> Result<Vec<KnownValue>, PresetError> {
    let mut known: Vec<KnownValue> = Vec::new();
    for (key, &value) in &read.known {
        let fail = |reason: String| {
            // One line at the beginning, or a section of its own.
            if source.has_section("known") {
                source.invalid("known", 0, key, reason)
            } else {
                source.invalid("", 0, "known", format!("{key}: {reason}"))
            }
        };
        let one = KnownValue::new(model, key, value).map_err(|error| fail(error.reason))?;
        if known.iter().any(|other| other.id == one.id) {
            return Err(fail("it is given twice".to_owned()));
        }
        known.push(one);
    }
    // Sorted as they are written, by their whole ids.
    known.sort_by(|a, b| a.id.cmp(&b.id));
    Ok(known)
}

pub(super) fn read_effects(
    source: &Source<'_>,
    read: &File,
) -> Result<Vec<ActiveEffect>, PresetError> {
    let mut active = Vec::new();
    for (id, values) in &read.effects {
        let section = format!("effects.{id}");
        let spec = effects::find(id).ok_or_else(|| {
            let known: Vec<&str> = effects::CATALOGUE.iter().map(|e| e.id).collect();
            let reason = format!("there is no such effect; there are {}", known.join(", "));
            source.invalid(&section, 0, id, reason)
        })?;
        let mut effect = ActiveEffect::new(spec);
        for (key, value) in values {
            if !effect.set(key, *value) {
                let known: Vec<&str> = spec.parameters.iter().map(|p| p.id).collect();
                let reason = format!("{id} has no such parameter; it has {}", known.join(", "));
                return Err(source.invalid(&section, 0, key, reason));
            }
        }
        active.push(effect);
    }
    Ok(active)
}
