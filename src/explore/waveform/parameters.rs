//! The numbers of a drive that a map, a sweep or a search can vary: one table for any periodic
//! waveform.

use std::sync::Arc;

use super::error::{WaveformError, named};
use crate::model::drive::{Cycle, Handles, PeriodicDrive, Waveform};

/// Frequencies between which a map is offered \[Hz\]: the paper's 5 to 100 Hz with room on
/// both sides.
const FREQUENCY_RANGE: (f64, f64) = (1.0, 1000.0);
/// Voltages between which a map is offered \[V\]: the paper's 8 V with some room.
const VOLTAGE_LIMIT: f64 = 10.0;
/// A turn of the phase \[deg\].
const FULL_TURN: f64 = 360.0;

/// Which number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WaveformQuantity {
    /// Periods per second \[Hz\].
    Frequency,
    /// Amplitude \[V\]; of a drawn period the largest voltage of a handle, and all are scaled.
    Amplitude,
    /// Offset \[V\].
    Offset,
    /// Share of the period that a ramp takes.
    Lambda,
    /// Share of the period that the voltage is high.
    Duty,
    /// Share of the period that the voltage rises.
    Asymmetry,
    /// How far the drive is ahead \[deg\].
    Phase,
    /// Voltage of a handle \[V\], by its index from 0.
    HandleVoltage(usize),
    /// Time of a handle as a share of the period, by its index from 0.
    HandleTime(usize),
}

/// A number of a drive, with what is to be known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct WaveformParameter {
    /// What people type: `frequency`, `amplitude`, `offset`, `lambda`, `duty`, `asymmetry`,
    /// `phase`, `h1`, `t1` ...; `f` and `V` also stand for the first two.
    pub id: String,
    /// What people read.
    pub name: String,
    /// SI unit; empty for shares.
    pub unit: &'static str,
    /// Range that is offered; [`set`] takes more where the drive does.
    pub range: (f64, f64),
    /// Whether its axis is logarithmic.
    pub is_logarithmic: bool,
    /// Which number it is.
    pub quantity: WaveformQuantity,
}

impl WaveformParameter {
    fn new(
        quantity: WaveformQuantity,
        (id, name): (impl Into<String>, impl Into<String>),
        unit: &'static str,
        range: (f64, f64),
    ) -> Self {
        Self {
            id: id.into(),
            name: name.into(),
            unit,
            range,
            is_logarithmic: quantity == WaveformQuantity::Frequency,
            quantity,
        }
    }

    /// Its value in a drive; `None` if the drive has no such number.
    pub fn get(&self, waveform: &Waveform) -> Option<f64> {
        value_of(&PeriodicDrive::of(waveform)?, self.quantity)
    }

    /// The drive with another value of it.
    ///
    /// # Errors
    /// As [`set`].
    pub fn set(&self, waveform: &Waveform, value: f64) -> Result<Waveform, WaveformError> {
        set(waveform, &self.id, value)
    }
}

/// All numbers of a drive; none for rest, chirps and tables.
#[must_use]
pub fn parameters(waveform: &Waveform) -> Vec<WaveformParameter> {
    use WaveformParameter as Parameter;
    use WaveformQuantity as Q;
    let Some(drive) = PeriodicDrive::of(waveform) else {
        return Vec::new();
    };
    let voltages = (-VOLTAGE_LIMIT, VOLTAGE_LIMIT);
    let mut all = vec![
        Parameter::new(
            Q::Frequency,
            ("frequency", "drive frequency"),
            "Hz",
            FREQUENCY_RANGE,
        ),
        Parameter::new(
            Q::Amplitude,
            ("amplitude", "drive amplitude"),
            "V",
            (0.0, VOLTAGE_LIMIT),
        ),
        Parameter::new(Q::Offset, ("offset", "drive offset"), "V", voltages),
    ];
    match &drive.cycle {
        Cycle::Sine { .. } => {}
        Cycle::Square { .. } => {
            all.push(Parameter::new(
                Q::Duty,
                ("duty", "share of the period high"),
                "",
                (0.0, 1.0),
            ));
        }
        Cycle::Triangle { .. } => {
            let names = ("asymmetry", "share of the period rising");
            all.push(Parameter::new(Q::Asymmetry, names, "", (0.0, 1.0)));
        }
        &Cycle::Ramped { lambda, duty, .. } => {
            let longest = duty.min(1.0 - duty);
            all.push(Parameter::new(
                Q::Lambda,
                ("lambda", "ramp share"),
                "",
                (0.0, longest),
            ));
            let names = ("duty", "share of the period high");
            all.push(Parameter::new(Q::Duty, names, "", (lambda, 1.0 - lambda)));
        }
        Cycle::Drawn(handles) => {
            let points = handles.points();
            for (i, _) in points.iter().enumerate() {
                let names = (
                    format!("h{}", i + 1),
                    format!("voltage of handle {}", i + 1),
                );
                all.push(Parameter::new(Q::HandleVoltage(i), names, "V", voltages));
            }
            for (i, _) in points.iter().enumerate() {
                let names = (format!("t{}", i + 1), format!("time of handle {}", i + 1));
                all.push(Parameter::new(
                    Q::HandleTime(i),
                    names,
                    "",
                    between_neighbours(handles, i),
                ));
            }
        }
    }
    let turns = drive.burst.map_or(1.0, |burst| f64::from(burst.of));
    all.push(Parameter::new(
        Q::Phase,
        ("phase", "drive phase"),
        "deg",
        (0.0, FULL_TURN * turns),
    ));
    all
}

/// The value of a number of a drive by its id; `None` if the drive has no such number.
pub fn get(waveform: &Waveform, id: &str) -> Option<f64> {
    find(waveform, id)?.get(waveform)
}

/// The drive with another value of a number; all others stay.
///
/// # Errors
/// [`WaveformError::NoParameter`] if the drive has no such number, [`WaveformError::Drive`] or
/// [`WaveformError::Handle`] if it cannot take this value.
pub fn set(waveform: &Waveform, id: &str, value: f64) -> Result<Waveform, WaveformError> {
    let (Some(parameter), Some(mut drive)) = (find(waveform, id), PeriodicDrive::of(waveform))
    else {
        let known: Vec<String> = parameters(waveform).into_iter().map(|p| p.id).collect();
        return Err(WaveformError::NoParameter {
            drive: named(waveform),
            id: id.to_owned(),
            known: if known.is_empty() {
                "none; take a periodic waveform".to_owned()
            } else {
                known.join(", ")
            },
        });
    };
    match (parameter.quantity, &mut drive.cycle) {
        (WaveformQuantity::Frequency, _) => drive.frequency = value,
        (WaveformQuantity::Offset, _) => drive.offset = value,
        (WaveformQuantity::Phase, _) => drive.phase = value,
        (WaveformQuantity::Amplitude, cycle) => *cycle = cycle.with_amplitude(value)?,
        (WaveformQuantity::Lambda, Cycle::Ramped { lambda, .. }) => *lambda = value,
        (WaveformQuantity::Duty, Cycle::Square { duty, .. } | Cycle::Ramped { duty, .. }) => {
            *duty = value;
        }
        (WaveformQuantity::Asymmetry, Cycle::Triangle { asymmetry, .. }) => *asymmetry = value,
        (WaveformQuantity::HandleVoltage(i), Cycle::Drawn(handles)) => {
            *handles = with_handle(handles, i, None, Some(value))?;
        }
        (WaveformQuantity::HandleTime(i), Cycle::Drawn(handles)) => {
            *handles = with_handle(handles, i, Some(value), None)?;
        }
        // The table lists for each cycle what it has.
        _ => {}
    }
    Ok(drive.waveform()?)
}

fn find(waveform: &Waveform, id: &str) -> Option<WaveformParameter> {
    let id = match id {
        "f" => "frequency",
        "V" => "amplitude",
        other => other,
    };
    parameters(waveform).into_iter().find(|p| p.id == id)
}

fn value_of(drive: &PeriodicDrive, quantity: WaveformQuantity) -> Option<f64> {
    Some(match (quantity, &drive.cycle) {
        (WaveformQuantity::Frequency, _) => drive.frequency,
        (WaveformQuantity::Amplitude, cycle) => cycle.amplitude(),
        (WaveformQuantity::Offset, _) => drive.offset,
        (WaveformQuantity::Phase, _) => drive.phase,
        (WaveformQuantity::Lambda, Cycle::Ramped { lambda, .. }) => *lambda,
        (WaveformQuantity::Duty, Cycle::Square { duty, .. } | Cycle::Ramped { duty, .. }) => *duty,
        (WaveformQuantity::Asymmetry, Cycle::Triangle { asymmetry, .. }) => *asymmetry,
        (WaveformQuantity::HandleVoltage(i), Cycle::Drawn(handles)) => {
            handles.points().get(i)?.voltage
        }
        (WaveformQuantity::HandleTime(i), Cycle::Drawn(handles)) => handles.points().get(i)?.time,
        _ => return None,
    })
}

/// The times between which a handle can move.
fn between_neighbours(handles: &Handles, index: usize) -> (f64, f64) {
    let points = handles.points();
    let low = index.checked_sub(1).map_or(0.0, |i| points[i].time);
    (low, points.get(index + 1).map_or(1.0, |p| p.time))
}

/// One handle elsewhere.
fn with_handle(
    handles: &Handles,
    index: usize,
    time: Option<f64>,
    voltage: Option<f64>,
) -> Result<Arc<Handles>, WaveformError> {
    let mut points = handles.points().to_vec();
    if let Some(time) = time {
        let (low, high) = between_neighbours(handles, index);
        if !(low..=high).contains(&time) {
            return Err(WaveformError::Handle(format!(
                "t{} = {time} is outside {low} .. {high}, the times of its neighbours",
                index + 1
            )));
        }
        points[index].time = time;
    }
    points[index].voltage = voltage.unwrap_or(points[index].voltage);
    Ok(Arc::new(Handles::new(points, handles.interpolation())?))
}
