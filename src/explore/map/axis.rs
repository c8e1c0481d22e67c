//! One axis: which number varies, from where to where, in how many points.

use super::error::MapError;
use crate::explore::waveform;
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::model::parameter::{ParameterId, Scale};

/// Fewest points of an axis.
const FEWEST_POINTS: usize = 2;

/// Parameters that change readings and no motion.
const OF_THE_INSTRUMENT: [ParameterId; 3] = [
    ParameterId::OffsetP,
    ParameterId::OffsetC,
    ParameterId::Noise,
];

/// What an axis varies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AxisOf {
    /// A number of the drive.
    Drive,
    /// A parameter of the model, or of an active effect.
    Model,
}

/// An axis. All values are SI, or as [`waveform::parameters`] says (phases in degrees).
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Id: `frequency`, `h1`, `Cs`, `effect.parameter`.
    pub id: String,
    /// What people read.
    pub name: String,
    /// Unit; empty for plain numbers.
    pub unit: String,
    /// Whether it belongs to drive or model.
    pub of: AxisOf,
    /// First value.
    pub from: f64,
    /// Last value.
    pub to: f64,
    /// Number of values, with both ends.
    pub count: usize,
    /// Equal ratios instead of equal differences.
    pub is_logarithmic: bool,
}

/// What is known of a number that can be an axis.
struct Known {
    id: String,
    name: String,
    unit: String,
    of: AxisOf,
    range: (f64, f64),
    is_logarithmic: bool,
}

impl Axis {
    /// An axis of `count` equal steps for a number of device and drive, by what people type.
    ///
    /// # Errors
    /// [`MapError::UnknownAxis`] with the ids there are, or as [`Self::check`].
    pub fn new(
        id: &str,
        (model, drive): (&Model, &Waveform),
        (from, to): (f64, f64),
        count: usize,
    ) -> Result<Self, MapError> {
        let mut axis = Self::offered(id, (model, drive), count)?;
        (axis.from, axis.to, axis.is_logarithmic) = (from, to, false);
        axis.check()?;
        Ok(axis)
    }

    /// The axis that is offered for a number: its usual range and scale.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn offered(
        id: &str,
        (model, drive): (&Model, &Waveform),
        count: usize,
    ) -> Result<Self, MapError> {
        let all = known(model, drive);
        let short = match id.trim() {
            "f" => "frequency",
            "V" => "amplitude",
            other => other,
        };
        let exact = all.iter().find(|k| k.id == short);
        let found = exact.or_else(|| all.iter().find(|k| k.id.eq_ignore_ascii_case(short)));
        let Some(found) = found else {
            let ids = |of| {
                let own = all.iter().filter(|k| k.of == of).map(|k| k.id.as_str());
                let own: Vec<&str> = own.collect();
                if own.is_empty() {
                    "none".to_owned()
                } else {
                    own.join(", ")
                }
            };
            return Err(MapError::UnknownAxis {
                id: id.to_owned(),
                drive: drive.to_string(),
                of_drive: ids(AxisOf::Drive),
                of_model: ids(AxisOf::Model),
            });
        };
        let axis = Self {
            id: found.id.clone(),
            name: found.name.clone(),
            unit: found.unit.clone(),
            of: found.of,
            from: found.range.0,
            to: found.range.1,
            count,
            is_logarithmic: found.is_logarithmic && found.range.0 > 0.0,
        };
        axis.check()?;
        Ok(axis)
    }

    /// All ids that can be an axis, those of the drive first.
    #[must_use]
    pub fn ids(model: &Model, drive: &Waveform) -> Vec<String> {
        known(model, drive).into_iter().map(|k| k.id).collect()
    }

    /// Checks range and number of points.
    ///
    /// # Errors
    /// [`MapError::Axis`].
    pub fn check(&self) -> Result<(), MapError> {
        let refuse = |reason: String| {
            Err(MapError::Axis {
                id: self.id.clone(),
                reason,
            })
        };
        let (from, to) = (self.from, self.to);
        if !(from.is_finite() && to.is_finite()) {
            return refuse(format!("{from} to {to} is no range of finite numbers"));
        }
        if self.count < FEWEST_POINTS {
            return refuse(format!(
                "{} is no axis; give at least {FEWEST_POINTS} points, or hold the value",
                crate::model::unit::counted(self.count, "point")
            ));
        }
        if from == to {
            return refuse(format!(
                "the range is empty: both ends are {from}; choose two values, or hold it"
            ));
        }
        if self.is_logarithmic && !(from > 0.0 && to > 0.0) {
            return refuse(format!(
                "a logarithmic axis from {from} to {to} is impossible; both ends must be above 0"
            ));
        }
        Ok(())
    }

    /// Value of a point, from 0; the ends are met exactly, and each machine computes the same bits.
    #[must_use]
    pub fn value(&self, index: usize) -> f64 {
        let last = self.count.saturating_sub(1);
        if index == 0 || last == 0 {
            return self.from;
        }
        if index >= last {
            return self.to;
        }
        let share = index as f64 / last as f64;
        if self.is_logarithmic {
            self.from * libm::pow(self.to / self.from, share)
        } else {
            self.from + (self.to - self.from) * share
        }
    }

    /// Position of a value on the axis: 0 at the first, `count - 1` at the last point.
    #[must_use]
    pub fn position(&self, value: f64) -> f64 {
        let share = if self.is_logarithmic {
            (value / self.from).ln() / (self.to / self.from).ln()
        } else {
            (value - self.from) / (self.to - self.from)
        };
        share * self.count.saturating_sub(1) as f64
    }
}

/// Everything that can be varied.
fn known(model: &Model, drive: &Waveform) -> Vec<Known> {
    let of_drive = waveform::parameters(drive).into_iter().map(|p| Known {
        id: p.id,
        name: p.name,
        unit: p.unit.to_owned(),
        of: AxisOf::Drive,
        range: p.range,
        is_logarithmic: p.is_logarithmic,
    });
    let acts = |id: &ParameterId| model.uses(*id) && !OF_THE_INSTRUMENT.contains(id);
    let own = ParameterId::ALL.into_iter().filter(acts);
    let of_model = own.map(|id| {
        let spec = id.spec();
        Known {
            id: spec.id.to_owned(),
            name: spec.name.to_owned(),
            unit: spec.unit.to_owned(),
            of: AxisOf::Model,
            range: spec.range,
            is_logarithmic: spec.scale == Scale::Log,
        }
    });
    let of_effects = model.effects.iter().flat_map(|effect| {
        let all = effect.spec.parameters.iter();
        all.map(|p| Known {
            id: format!("{}.{}", effect.spec.id, p.id),
            name: format!("{} of {}", p.name, effect.spec.name),
            unit: p.unit.to_owned(),
            of: AxisOf::Model,
            range: p.range,
            is_logarithmic: p.scale == Scale::Log,
        })
    });
    of_drive.chain(of_model).chain(of_effects).collect()
}
