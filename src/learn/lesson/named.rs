//! What a file names, looked up on the device of a scene: presets, pictures, effects, parameters,
//! controls, measures and units.

use std::collections::BTreeMap;

use toml::Spanned;

use super::LessonPicture;
use super::error::{LessonError, Source};
use super::file::{ControlEntry, Quantity};
use crate::learn::controls::{Control, drive_ids, value_of_drive};
use crate::learn::measures;
use crate::learn::run::Scene;
use crate::learn::text::Text;
use crate::model::effects::{ActiveEffect, CATALOGUE, find};
use crate::model::parameter::ParameterId;
use crate::model::preset::{EMBEDDED, Preset};
use crate::model::unit::parse_quantity;

pub(super) fn preset_names() -> String {
    let names: Vec<&str> = EMBEDDED.iter().map(|(name, _)| *name).collect();
    names.join(", ")
}

pub(super) fn preset(source: &Source<'_>, name: &Spanned<String>) -> Result<Preset, LessonError> {
    Preset::embedded(name.get_ref()).ok_or_else(|| {
        let reason = format!(
            "there is no preset \"{}\"; write one of {}",
            name.get_ref(),
            preset_names()
        );
        source.fault(name.span().start, reason)
    })
}

pub(super) fn picture(
    source: &Source<'_>,
    name: &Spanned<String>,
) -> Result<LessonPicture, LessonError> {
    let known = LessonPicture::ALL.iter();
    let found = known
        .clone()
        .find(|picture| picture.name() == name.get_ref());
    found.copied().ok_or_else(|| {
        let names: Vec<&str> = known.map(|picture| picture.name()).collect();
        let reason = format!(
            "there is no picture \"{}\"; write some of {}",
            name.get_ref(),
            names.join(", ")
        );
        source.fault(name.span().start, reason)
    })
}

/// An effect of the catalogue with values.
pub(super) fn effect_with(
    source: &Source<'_>,
    scene: &Scene,
    (id, at): (&str, usize),
    values: &BTreeMap<String, Spanned<Quantity>>,
) -> Result<ActiveEffect, LessonError> {
    let Some(spec) = find(id) else {
        let known: Vec<&str> = CATALOGUE.iter().map(|e| e.id).collect();
        let reason = format!(
            "there is no effect \"{id}\"; write one of {}",
            known.join(", ")
        );
        return Err(source.fault(at, reason));
    };
    if !scene.preset.model.allows(spec) {
        let reason = format!("{} can do nothing on this device; take another", spec.name);
        return Err(source.fault(at, reason));
    }
    let mut effect = ActiveEffect::new(spec);
    for (own, value) in values {
        let at = value.span().start;
        let Some(parameter) = spec.parameters.iter().find(|p| p.id == own) else {
            let known: Vec<&str> = spec.parameters.iter().map(|p| p.id).collect();
            let reason = format!(
                "{id} has no parameter \"{own}\"; it has {}",
                known.join(", ")
            );
            return Err(source.fault(at, reason));
        };
        let unit = scene.preset.model.coordinate.unit(parameter.unit);
        let number = quantity(source, value, unit)?;
        if let Some(reason) = parameter.refusal(number) {
            return Err(source.fault(at, reason));
        }
        effect.set(own, number);
    }
    Ok(effect)
}

/// The value of a parameter of a scene, in its unit.
pub(super) fn parameter_value(
    source: &Source<'_>,
    scene: &Scene,
    id: &str,
    value: &Spanned<Quantity>,
) -> Result<f64, LessonError> {
    let unit = scene.preset.model.unit_of(id).unwrap_or_default();
    quantity(source, value, unit)
}

/// Sets a parameter of a scene that its device uses.
pub(super) fn set(
    source: &Source<'_>,
    scene: &mut Scene,
    (id, at): (&str, usize),
    value: f64,
) -> Result<(), LessonError> {
    let model = &mut scene.preset.model;
    if let Some(parameter) = ParameterId::from_id(id).filter(|p| !model.uses(*p)) {
        let reason = format!(
            "{} has no bearing on this device; leave it out",
            parameter.spec().id
        );
        return Err(source.fault(at, reason));
    }
    let set = model.set(id, value);
    set.map_err(|error| source.fault(at, error.to_string()))
}

/// A quantity in SI units.
pub(super) fn quantity(
    source: &Source<'_>,
    value: &Spanned<Quantity>,
    unit: &str,
) -> Result<f64, LessonError> {
    let at = value.span().start;
    let number = match value.get_ref() {
        Quantity::Number(number) => *number,
        Quantity::Text(text) => {
            parse_quantity(text, unit).map_err(|error| source.fault(at, error.to_string()))?
        }
    };
    if number.is_finite() {
        Ok(number)
    } else {
        Err(source.fault(at, "the number is not finite; write a finite one"))
    }
}

/// A range of quantities, the lower one first.
pub(super) fn range(
    source: &Source<'_>,
    (low, high): (&Quantity, &Quantity),
    unit: &str,
    at: usize,
) -> Result<(f64, f64), LessonError> {
    let read = |value: &Quantity| quantity(source, &Spanned::new(at..at, value.clone()), unit);
    let (low, high) = (read(low)?, read(high)?);
    if low < high {
        return Ok((low, high));
    }
    Err(source.fault(at, "a range is two numbers, the lower one first"))
}

/// The controls that a task names; each must be there to move.
pub(super) fn controls(
    source: &Source<'_>,
    scene: &Scene,
    entries: &[Spanned<ControlEntry>],
) -> Result<Vec<Control>, LessonError> {
    let read = entries.iter().map(|entry| {
        let at = entry.span().start;
        let mut control = match entry.get_ref() {
            ControlEntry::Id(id) => Control {
                id: id.clone(),
                range: None,
            },
            ControlEntry::Ranged(ranged) => {
                let unit = Control {
                    id: ranged.id.clone(),
                    range: None,
                };
                let unit = unit.spec(scene).map_or("", |spec| spec.unit);
                let (low, high) = &ranged.range;
                Control {
                    id: ranged.id.clone(),
                    range: Some(range(source, (low, high), unit, at)?),
                }
            }
        };
        // Ids are read in any case.
        if let Some(parameter) = ParameterId::from_id(&control.id) {
            parameter.spec().id.clone_into(&mut control.id);
        }
        match control.spec(scene) {
            Some(_) => Ok(control),
            None => Err(source.fault(at, missing_control(scene, &control.id))),
        }
    });
    read.collect()
}

fn missing_control(scene: &Scene, id: &str) -> String {
    let model = &scene.preset.model;
    let used = ParameterId::ALL.into_iter().filter(|p| model.uses(*p));
    let mut known: Vec<String> = used.map(|p| p.spec().id.to_owned()).collect();
    known.extend(model.effect_ids());
    known.extend(drive_ids().into_iter().map(str::to_owned));
    format!(
        "this step has no control \"{id}\"; write one of {}",
        known.join(", ")
    )
}

/// The same, at least one.
pub(super) fn some_controls(
    source: &Source<'_>,
    scene: &Scene,
    entries: &[Spanned<ControlEntry>],
    at: usize,
) -> Result<Vec<Control>, LessonError> {
    let found = controls(source, scene, entries)?;
    if found.is_empty() {
        let reason = "no control is named; write for example controls = [\"alpha\"]";
        return Err(source.fault(at, reason));
    }
    Ok(found)
}

/// A text whose names exist on the device of a scene.
pub(super) fn text_of(
    source: &Source<'_>,
    scene: &Scene,
    text: &Spanned<String>,
) -> Result<Text, LessonError> {
    let at = text.span().start;
    let read = Text::parse(text.get_ref()).map_err(|error| source.text_fault(at, &error))?;
    read.each_name(&mut |id| check_name(source, scene, id, at))?;
    Ok(read)
}

/// A name in an expression must be a parameter of the device or a measure.
pub(super) fn check_name(
    source: &Source<'_>,
    scene: &Scene,
    id: &str,
    at: usize,
) -> Result<(), LessonError> {
    let is_of_drive = value_of_drive(&scene.drive, id).is_some();
    if is_of_drive || scene.preset.model.get(id).is_some() || measures::find(id).is_some() {
        return Ok(());
    }
    let reason = format!(
        "there is no parameter and no measure \"{id}\"; measures are {}",
        measures::names()
    );
    Err(source.fault(at, reason))
}
