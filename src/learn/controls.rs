//! What a pupil may move: parameters, parameters of effects, and the drive.

use super::run::Scene;
use crate::model::drive::{Cycle, PeriodicDrive, Waveform};
use crate::model::parameter::{ParameterId, ParameterSpec, Rank, Scale};

/// Frequencies and voltages that a lesson's slider can reach \[Hz\], \[V\].
const FREQUENCY_RANGE: (f64, f64) = (1.0, 2000.0);
const AMPLITUDE_RANGE: (f64, f64) = (0.0, 10.0);

const FREQUENCY_SPEC: ParameterSpec = ParameterSpec {
    id: "drive.frequency",
    symbol: "f",
    name: "drive frequency",
    unit: "Hz",
    default: 15.0,
    range: FREQUENCY_RANGE,
    limits: (1e-6, 1e6),
    scale: Scale::Log,
    rank: Rank::Secondary,
    meaning: "periods per second of the drive voltage",
    equation: "",
};

const AMPLITUDE_SPEC: ParameterSpec = ParameterSpec {
    id: "drive.amplitude",
    symbol: "A",
    name: "drive amplitude",
    unit: "V",
    default: 8.0,
    range: AMPLITUDE_RANGE,
    limits: (0.0, 1e4),
    scale: Scale::Linear,
    rank: Rank::Secondary,
    meaning: "peak voltage",
    equation: "",
};

const DUTY_SPEC: ParameterSpec = ParameterSpec {
    id: "drive.duty",
    symbol: "duty",
    name: "share of the period that the voltage is high",
    unit: "",
    default: 0.5,
    range: (0.05, 0.95),
    limits: (0.01, 0.99),
    scale: Scale::Linear,
    rank: Rank::Secondary,
    meaning: "share of the period that the voltage is high",
    equation: "",
};

/// A control that a pupil may move.
#[derive(Debug, Clone, PartialEq)]
pub struct Control {
    /// Id of a parameter, as `effect.parameter` for one of an effect; `drive.frequency`,
    /// `drive.amplitude` and `drive.duty` for the drive.
    pub id: String,
    /// Range of its slider \[SI\], if it is not the device's.
    pub range: Option<(f64, f64)>,
}

/// Value of a drive by the id of its control; `None` if it has no such value.
pub fn value_of_drive(drive: &Waveform, id: &str) -> Option<f64> {
    drive_value(drive, drive_control(id)?.0)
}

/// SI unit of a control of drives.
pub fn drive_unit(id: &str) -> Option<&'static str> {
    Some(drive_control(id)?.1.unit)
}

/// Ids of the controls of drives.
pub fn drive_ids() -> Vec<&'static str> {
    DRIVE_SPECS.iter().map(|(_, spec)| spec.id).collect()
}

impl Control {
    /// Its slider on the device of a scene, in the unit of its readings; `None` if the scene has no
    /// such thing to move.
    pub fn spec(&self, scene: &Scene) -> Option<ParameterSpec> {
        let model = &scene.preset.model;
        let mut spec = match self.id.as_str() {
            id if drive_control(id).is_some() => {
                let (which, spec) = drive_control(id)?;
                drive_value(&scene.drive, which)?;
                spec
            }
            id => match ParameterId::from_id(id) {
                Some(parameter) if model.uses(parameter) => {
                    let mut spec = *parameter.spec();
                    if let Some(range) = scene.preset.ranges.get(&parameter) {
                        spec.range = *range;
                    }
                    spec
                }
                Some(_) => return None,
                None => {
                    let (effect, own) = id.split_once('.')?;
                    let mut active = model.effects.iter();
                    let active = active.find(|e| e.spec.id == effect)?;
                    *active.spec.parameters.iter().find(|p| p.id == own)?
                }
            },
        };
        spec.unit = model.coordinate.unit(spec.unit);
        if let Some(range) = self.range {
            spec.range = range;
            if range.0 <= 0.0 {
                spec.scale = Scale::Linear;
            }
        }
        Some(spec)
    }
}

impl Scene {
    /// Value of a control \[SI\]; `None` if the scene has no such thing to move.
    pub fn control_value(&self, id: &str) -> Option<f64> {
        match drive_control(id) {
            Some((which, _)) => drive_value(&self.drive, which),
            None => self.preset.model.get(id),
        }
    }

    /// Moves a control. What the scene does not have stays.
    pub fn set_control(&mut self, id: &str, value: f64) {
        match drive_control(id) {
            Some((which, _)) => self.drive = with_drive_value(&self.drive, which, value),
            // A control was checked when the lesson was read.
            None => drop(self.preset.model.set(id, value)),
        }
    }

    /// Moves the mass to a reading at the beginning, at rest \[m\]: as far as the ground allows.
    pub fn pull_to(&mut self, reading: f64) {
        /// Share of the way to the ground that is left.
        const GROUND_CLEARANCE: f64 = 1e-3;
        let parameters = &mut self.preset.model.parameters;
        let mut displacement = reading - parameters[ParameterId::OffsetP];
        if self.preset.model.has_ground {
            let dp = parameters[ParameterId::Dp];
            displacement = displacement.max(-dp * (1.0 - GROUND_CLEARANCE));
        }
        parameters.set(ParameterId::X0, displacement);
        parameters.set(ParameterId::V0, 0.0);
    }
}

/// The value of a drive that a control moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum DriveValue {
    Frequency,
    Amplitude,
    Duty,
}

/// The controls of drives, with what they move.
const DRIVE_SPECS: [(DriveValue, ParameterSpec); 3] = [
    (DriveValue::Frequency, FREQUENCY_SPEC),
    (DriveValue::Amplitude, AMPLITUDE_SPEC),
    (DriveValue::Duty, DUTY_SPEC),
];

fn drive_control(id: &str) -> Option<(DriveValue, ParameterSpec)> {
    DRIVE_SPECS.into_iter().find(|(_, spec)| spec.id == id)
}

/// The value of a drive, if it has one.
fn drive_value(drive: &Waveform, which: DriveValue) -> Option<f64> {
    let drive = PeriodicDrive::of(drive)?;
    match (which, &drive.cycle) {
        (DriveValue::Frequency, _) => Some(drive.frequency),
        (DriveValue::Amplitude, cycle) => Some(cycle.amplitude()),
        (DriveValue::Duty, Cycle::Square { duty, .. } | Cycle::Ramped { duty, .. }) => Some(*duty),
        (DriveValue::Duty, _) => None,
    }
}

/// The drive with another value; as it was if that would be none.
fn with_drive_value(drive: &Waveform, which: DriveValue, value: f64) -> Waveform {
    let changed = PeriodicDrive::of(drive).and_then(|mut periodic| {
        match which {
            DriveValue::Frequency => periodic.frequency = value,
            DriveValue::Amplitude => periodic.cycle = periodic.cycle.with_amplitude(value).ok()?,
            DriveValue::Duty => match &mut periodic.cycle {
                Cycle::Square { duty, .. } | Cycle::Ramped { duty, .. } => *duty = value,
                _ => return None,
            },
        }
        periodic.waveform().ok()
    });
    changed.unwrap_or_else(|| drive.clone())
}
