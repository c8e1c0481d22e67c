//! What is asked of a map.

use super::axis::{Axis, AxisOf};
use super::error::MapError;
use crate::explore::measures::MeasureId;
use crate::explore::steady_state::SteadyOptions;
use crate::explore::waveform;
use crate::model::Model;
use crate::model::drive::Waveform;

/// Memory that a map may take \[bytes\]; a tenth of what a small computer has.
const MEMORY_LIMIT: u128 = 512 << 20;
/// What a point takes beside its values \[bytes\]: state, category, its batch on the way, and the text
/// of a hole's reason.
const BYTES_BESIDE_VALUES: u128 = 320;
/// Copies of a point's values: in the result, and in a batch on the way.
const COPIES_OF_VALUES: u128 = 2;
/// Longest that a point is followed \[s of device time\]: 200 periods of 2 Hz.
const POINT_DEVICE_SECONDS: f64 = 100.0;
/// Steps that a point may take however little it advances: some tenths of a second of work.
const POINT_STEPS_AT_ONCE: u64 = 100_000;

/// Where the response of each point begins.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum MapStart {
    /// The model's initial state; the drive is switched on at its phase 0.
    #[default]
    Rest,
    /// Displacement \[m\] and velocity [m/s] of the mass, switched on at a phase from 0 to below 1.
    Point {
        /// Displacement \[m\].
        displacement: f64,
        /// Velocity [m/s].
        velocity: f64,
        /// Phase of the drive.
        switched_on: f64,
    },
}

/// Which points are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Refinement {
    /// All; those where the regime changes first.
    #[default]
    Everywhere,
    /// A coarse lattice, and finer where the regime changes; the others stay filled.
    WhereRegimeChanges,
}

/// A map that is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct MapRequest {
    /// The device.
    pub model: Model,
    /// The drive; axes change its numbers.
    pub drive: Waveform,
    /// One or two axes.
    pub axes: Vec<Axis>,
    /// What is measured.
    pub measures: Vec<MeasureId>,
    /// Where responses begin.
    pub start: MapStart,
    /// Which points are solved.
    pub refinement: Refinement,
    /// How steady states are searched.
    pub options: SteadyOptions,
    /// Longest that one point is followed \[s of device time\]; it is a hole then.
    pub point_device_seconds: f64,
}

impl MapRequest {
    /// With usual choices: from rest, everywhere, accuracy of a map.
    #[must_use]
    pub fn new(model: Model, drive: Waveform, axes: Vec<Axis>, measures: Vec<MeasureId>) -> Self {
        let mut options = SteadyOptions::for_maps(&model);
        options.multipliers = measures.contains(&MeasureId::LargestMultiplier);
        options.simulator.max_steps_at_once = POINT_STEPS_AT_ONCE;
        Self {
            model,
            drive,
            axes,
            measures,
            start: MapStart::Rest,
            refinement: Refinement::Everywhere,
            options,
            point_device_seconds: POINT_DEVICE_SECONDS,
        }
    }

    /// Points along each axis; 1 along the second of a single axis.
    #[must_use]
    pub fn shape(&self) -> (usize, usize) {
        let along = |k: usize| self.axes.get(k).map_or(1, |axis| axis.count);
        (along(0), along(1))
    }

    /// Number of points; [`Self::check`] says whether they fit.
    #[must_use]
    pub fn points(&self) -> usize {
        let (first, second) = self.shape();
        first.saturating_mul(second)
    }

    /// Index along each axis of a point; the first axis counts fastest.
    #[must_use]
    pub fn place(&self, index: usize) -> (usize, usize) {
        let (first, _) = self.shape();
        (index % first.max(1), index / first.max(1))
    }

    /// Values of the axes at a point, as many as there are axes.
    #[must_use]
    pub fn values_at(&self, index: usize) -> Vec<f64> {
        let (i, j) = self.place(index);
        let axes = self.axes.iter().zip([i, j]);
        axes.map(|(axis, at)| axis.value(at)).collect()
    }

    /// Device and drive of a point.
    ///
    /// # Errors
    /// Why there is none, as a text: the drive or the model refuses a value.
    pub fn setting(&self, index: usize) -> Result<(Model, Waveform), String> {
        let values = self.values_at(index);
        let mut model = self.model.clone();
        for (axis, value) in self.axes.iter().zip(&values) {
            if axis.of == AxisOf::Model {
                model.set(&axis.id, *value).map_err(|e| e.to_string())?;
            }
        }
        Ok((model, self.drive_at(&values)?))
    }

    /// The drive for values of the axes.
    pub(super) fn drive_at(&self, values: &[f64]) -> Result<Waveform, String> {
        let own = self.axes.iter().zip(values);
        let own = own.filter(|(axis, _)| axis.of == AxisOf::Drive);
        let mut own: Vec<(&Axis, f64)> = own.map(|(axis, value)| (axis, *value)).collect();
        let set = |own: &[(&Axis, f64)]| {
            own.iter()
                .try_fold(self.drive.clone(), |drive, (axis, value)| {
                    waveform::set(&drive, &axis.id, *value)
                })
        };
        let in_order = set(&own);
        // One number may only fit once the other is set.
        let set = in_order.or_else(|error| {
            own.reverse();
            set(&own).map_err(|_| error)
        });
        set.map_err(|error| error.to_string())
    }

    /// Checks all that can be refused before a point is computed.
    ///
    /// # Errors
    /// [`MapError`].
    pub fn check(&self) -> Result<(), MapError> {
        self.check_for(self.points_exactly())
    }

    /// [`Self::check`] where only so many points are computed at a time.
    ///
    /// # Errors
    /// [`MapError`].
    pub fn check_for(&self, points: u128) -> Result<(), MapError> {
        self.check_axes()?;
        self.check_measures()?;
        self.options
            .check()
            .map_err(|error| MapError::Setup(error.to_string()))?;
        if self.point_device_seconds.is_nan() || self.point_device_seconds <= 0.0 {
            return Err(MapError::Setup(format!(
                "{} s of device time a point is no time; give more than 0 s",
                self.point_device_seconds
            )));
        }
        let values = 8 * COPIES_OF_VALUES * self.measures.len() as u128;
        let needed = points.saturating_mul(values + BYTES_BESIDE_VALUES);
        if needed > MEMORY_LIMIT || self.points_exactly() > usize::MAX as u128 {
            return Err(MapError::TooLarge {
                points,
                needed: needed >> 20,
                allowed: MEMORY_LIMIT >> 20,
            });
        }
        Ok(())
    }

    /// Number of points, however many.
    fn points_exactly(&self) -> u128 {
        let counts = self.axes.iter().map(|axis| axis.count as u128);
        counts.fold(1, u128::saturating_mul)
    }

    fn check_axes(&self) -> Result<(), MapError> {
        match self.axes.as_slice() {
            [] => {
                return Err(MapError::Axes(
                    "there is no axis; choose one or two".to_owned(),
                ));
            }
            [_] => {}
            [a, b] if a.id == b.id => {
                return Err(MapError::Axes(format!(
                    "both axes are {}; choose two different ones",
                    a.id
                )));
            }
            [_, _] => {}
            more => {
                return Err(MapError::Axes(format!(
                    "{} axes are more than 2; hold the others",
                    more.len()
                )));
            }
        }
        self.axes.iter().try_for_each(Axis::check)?;
        for axis in &self.axes {
            let found = Axis::offered(&axis.id, (&self.model, &self.drive), axis.count)?;
            if found.of != axis.of {
                return Err(MapError::Axis {
                    id: axis.id.clone(),
                    reason: "drive and model have been taken for one another".to_owned(),
                });
            }
        }
        Ok(())
    }

    fn check_measures(&self) -> Result<(), MapError> {
        if self.measures.is_empty() {
            return Err(MapError::Measures(
                "no measure is asked for; choose at least one".to_owned(),
            ));
        }
        for (k, measure) in self.measures.iter().enumerate() {
            if self.measures[..k].contains(measure) {
                return Err(MapError::Measures(format!(
                    "{} is asked for twice; name it once",
                    measure.spec().id
                )));
            }
        }
        if self.model.has_ground {
            return Ok(());
        }
        let ids = |of: &mut dyn Iterator<Item = MeasureId>| {
            of.map(|m| m.spec().id).collect::<Vec<_>>().join(", ")
        };
        let needing = ids(&mut self.measures.iter().copied().filter(|m| needs_ground(*m)));
        if needing.is_empty() {
            return Ok(());
        }
        let all = crate::explore::measures::MEASURES
            .iter()
            .map(|row| row.measure);
        Err(MapError::NoGround {
            model: self.model.name.clone(),
            measures: needing,
            others: ids(&mut all.filter(|m| !needs_ground(*m))),
        })
    }
}

/// Whether a measure means nothing without a ground.
fn needs_ground(measure: MeasureId) -> bool {
    use MeasureId as M;
    match measure {
        M::Regime
        | M::ContactShare
        | M::ContactDuration
        | M::Bounces
        | M::FirstImpactSpeed
        | M::LargestImpactSpeed
        | M::MeanGroundForce
        | M::PullOffForce
        | M::ImpactLoss
        | M::FilmLoss
        | M::Margin => true,
        M::Multiple
        | M::Peak
        | M::EnergyLost
        | M::StructureLoss
        | M::DriveWork
        | M::LargestMultiplier => false,
    }
}
