//! One period drawn by handles.

use std::sync::Arc;

use super::error::WaveformError;
use super::from_waveform::drawn_drive;
use super::limits::{DriveLimits, Excess, excesses};
use crate::model::drive::{Burst, Cycle, Handle, Handles, Interpolation, PeriodicDrive, Waveform};

/// Handles nearer to one another than this share of a period are a step.
const STEP_GAP: f64 = 1e-6;

/// Where handles come to rest.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SnapGrid {
    /// Steps as a share of the period; `None` is any time.
    pub time: Option<f64>,
    /// Steps \[V\]; `None` is any voltage.
    pub voltage: Option<f64>,
}

impl SnapGrid {
    /// The nearest point of the grid.
    #[must_use]
    pub fn snapped(&self, handle: Handle) -> Handle {
        let snap = |value: f64, step: Option<f64>| match step {
            Some(step) if step > 0.0 && step.is_finite() => (value / step).round() * step,
            _ => value,
        };
        Handle {
            time: snap(handle.time, self.time),
            voltage: snap(handle.voltage, self.voltage),
        }
    }
}

/// A drive whose period is drawn. Handles stay in order of time; two at one time are a step.
#[derive(Debug, Clone, PartialEq)]
pub struct EditableWaveform {
    /// What a person calls it.
    pub name: String,
    /// Periods per second \[Hz\].
    pub frequency: f64,
    /// Added to the handles \[V\].
    pub offset: f64,
    /// How far it is ahead \[deg\].
    pub phase: f64,
    /// Bursts; `None` is no pause.
    pub burst: Option<Burst>,
    /// Where handles come to rest.
    pub grid: SnapGrid,
    /// What it should not exceed.
    pub limits: DriveLimits,
    handles: Handles,
}

impl EditableWaveform {
    /// A period drawn by `handles`, repeated with `frequency` \[Hz\].
    #[must_use]
    pub fn new(name: impl Into<String>, handles: Handles, frequency: f64) -> Self {
        Self {
            name: name.into(),
            frequency,
            offset: 0.0,
            phase: 0.0,
            burst: None,
            grid: SnapGrid::default(),
            limits: DriveLimits::default(),
            handles,
        }
    }

    /// A standard waveform with handles: exact for straight lines and steps; a sine has about
    /// `per_period` handles joined smoothly. Offset, phase and bursts stay what they are.
    ///
    /// # Errors
    /// [`WaveformError::NoPeriod`] for a drive that does not repeat; [`WaveformError::Drive`] if
    /// it has too many corners.
    pub fn from_waveform(waveform: &Waveform, per_period: usize) -> Result<Self, WaveformError> {
        let (drive, handles) = drawn_drive(waveform, per_period)?;
        Ok(Self {
            offset: drive.offset,
            phase: drive.phase,
            burst: drive.burst,
            ..Self::new("drawn", handles, drive.frequency)
        })
    }

    /// The handles in order of time.
    pub fn handles(&self) -> &[Handle] {
        self.handles.points()
    }

    /// What leads from handle to handle.
    pub fn interpolation(&self) -> Interpolation {
        self.handles.interpolation()
    }

    /// The drive as a person would set it.
    #[must_use]
    pub fn drive(&self) -> PeriodicDrive {
        PeriodicDrive {
            cycle: Cycle::Drawn(Arc::new(self.handles.clone())),
            frequency: self.frequency,
            offset: self.offset,
            phase: self.phase,
            burst: self.burst,
        }
    }

    /// The drive for the simulator.
    ///
    /// # Errors
    /// [`WaveformError::Drive`] naming the value that is out of range.
    pub fn waveform(&self) -> Result<Waveform, WaveformError> {
        Ok(self.drive().waveform()?)
    }

    /// Where the drive goes beyond [`EditableWaveform::limits`].
    ///
    /// # Errors
    /// As [`EditableWaveform::waveform`].
    pub fn excesses(&self) -> Result<Vec<Excess>, WaveformError> {
        excesses(&self.waveform()?, &self.limits)
    }

    /// Joins the handles in another way.
    ///
    /// # Errors
    /// Never for handles that were valid; kept for the type of [`Handles::new`].
    pub fn set_interpolation(&mut self, kind: Interpolation) -> Result<(), WaveformError> {
        self.handles = Handles::new(self.handles().to_vec(), kind)?;
        Ok(())
    }

    /// Adds a handle near a point, on the grid; returns its number.
    ///
    /// # Errors
    /// [`WaveformError::Drive`] if there are two at that time already, or too many.
    pub fn insert(&mut self, point: Handle) -> Result<usize, WaveformError> {
        let mut new = self.grid.snapped(point);
        new.time = new.time.clamp(0.0, 1.0);
        let mut points = self.handles().to_vec();
        let index = points.partition_point(|p| p.time <= new.time);
        let near = [index.checked_sub(1), Some(index)];
        let near = near.into_iter().flatten().filter_map(|i| points.get(i));
        if let Some(at) = near.map(|p| p.time).find(|t| is_step(*t, new.time)) {
            new.time = at;
        }
        let index = points.partition_point(|p| p.time <= new.time);
        points.insert(index, new);
        self.handles = Handles::new(points, self.interpolation())?;
        Ok(index)
    }

    /// Moves a handle near a point, on the grid, between its neighbours; returns where it came
    /// to rest. Where its time would make three at one time it moves up and down only.
    ///
    /// # Errors
    /// [`WaveformError::Handle`] if there is no such handle; [`WaveformError::Drive`] for a
    /// voltage that no drive has.
    pub fn move_to(&mut self, index: usize, point: Handle) -> Result<Handle, WaveformError> {
        let mut points = self.handles().to_vec();
        let Some(&old) = points.get(index) else {
            return Err(self.no_handle(index));
        };
        let low = index.checked_sub(1).map_or(0.0, |i| points[i].time);
        let high = points.get(index + 1).map_or(1.0, |p| p.time);
        let mut new = self.grid.snapped(point);
        // A time that is no number leaves the handle where it is.
        new.time = if new.time.is_nan() {
            old.time
        } else {
            new.time
        }
        .clamp(low, high);
        for end in [low, high] {
            if is_step(new.time, end) {
                new.time = end;
            }
        }
        points[index] = new;
        let kind = self.interpolation();
        let moved = Handles::new(points.clone(), kind).or_else(|_| {
            points[index].time = old.time;
            Handles::new(points.clone(), kind)
        });
        self.handles = moved?;
        Ok(self.handles()[index])
    }

    /// Takes a handle away.
    ///
    /// # Errors
    /// [`WaveformError::Handle`] if there is no such handle, or no other.
    pub fn remove(&mut self, index: usize) -> Result<Handle, WaveformError> {
        let mut points = self.handles().to_vec();
        if index >= points.len() {
            return Err(self.no_handle(index));
        }
        if points.len() == 1 {
            return Err(WaveformError::Handle(
                "the last handle stays; a period needs one, or choose the drive \"rest\""
                    .to_owned(),
            ));
        }
        let gone = points.remove(index);
        self.handles = Handles::new(points, self.interpolation())?;
        Ok(gone)
    }

    fn no_handle(&self, index: usize) -> WaveformError {
        WaveformError::Handle(format!(
            "there is no handle {}; the period has {}",
            index + 1,
            self.handles().len()
        ))
    }
}

fn is_step(a: f64, b: f64) -> bool {
    (a - b).abs() < STEP_GAP
}
