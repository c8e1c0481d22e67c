//! Forces without a law: each acts only in a window of one quantity. Tested like effects, they
//! measure the missing force point by point, whatever its law, and show whether anything is
//! missing at all.

use crate::model::effects::{Action, ActiveEffect, EffectSpec, Kinematics, Need};
use crate::model::parameter::{ParameterSpec, Rank, Scale};

/// The quantity that a force is resolved against.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Against {
    /// Height of the proof mass.
    Height,
    /// Its velocity.
    Velocity,
    /// The voltage.
    Voltage,
    /// Velocity, but proportional to it: damping in a window of height.
    DampingAtHeight,
    /// Velocity, proportional to it, in a window of the voltage.
    DampingAtVoltage,
    /// Height, proportional to it, in a window of the voltage.
    StiffnessAtVoltage,
    /// Force of the drive in a window of the voltage.
    Drive,
}

impl Against {
    /// All.
    pub const ALL: [Self; 7] = [
        Self::Height,
        Self::Velocity,
        Self::Voltage,
        Self::DampingAtHeight,
        Self::DampingAtVoltage,
        Self::StiffnessAtVoltage,
        Self::Drive,
    ];

    /// As a parameter's value.
    pub(crate) fn number(self) -> f64 {
        Self::ALL.iter().position(|a| *a == self).unwrap_or(0) as f64
    }

    /// From a parameter's value; `None` below zero.
    pub(crate) fn of(number: f64) -> Option<Self> {
        let last = Self::ALL.len() - 1;
        (number >= 0.0).then(|| Self::ALL[(number as usize).min(last)])
    }

    /// Symbol of the quantity.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Height | Self::DampingAtHeight => "xp",
            Self::Velocity => "xp'",
            _ => "V",
        }
    }

    /// SI unit of the quantity.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Height | Self::DampingAtHeight => "m",
            Self::Velocity => "m/s",
            _ => "V",
        }
    }
}

/// No limits in practice.
const UNLIMITED: (f64, f64) = (-1e300, 1e300);

/// A numeric parameter of a force without a law.
pub(crate) const fn numeric_parameter(id: &'static str) -> ParameterSpec {
    ParameterSpec {
        id,
        symbol: id,
        name: id,
        unit: "",
        default: 0.0,
        range: (-1.0, 1.0),
        limits: UNLIMITED,
        scale: Scale::Linear,
        rank: Rank::Advanced,
        meaning: "of a force without a name",
        equation: "F = size hat((u - middle) / width)",
    }
}

static SPEC: EffectSpec = EffectSpec {
    id: "unnamed_force",
    name: "force without a name",
    sentence: "A force that is there only in a window of one quantity.",
    law: "F = size hat((u - middle) / width)",
    needs: Need::Nothing,
    source: "",
    parameters: &[
        numeric_parameter("against"),
        numeric_parameter("middle"),
        numeric_parameter("width"),
        numeric_parameter("size"),
    ],
    build: |values, _| {
        Box::new(Window {
            against: Against::of(values[0]).unwrap_or(Against::Height),
            middle: values[1],
            width: values[2],
            size: values[3],
        })
    },
    ..EffectSpec::DEFAULT
};

/// A force of `size` at `middle` of the quantity, falling to zero at a distance of `width`. Its
/// unit is that of `against`: \[N\], a damping \[N s/m\], a stiffness \[N/m\], or that of `gc`.
pub fn window(against: Against, middle: f64, width: f64, size: f64) -> ActiveEffect {
    ActiveEffect {
        spec: &SPEC,
        values: vec![against.number(), middle, width, size],
    }
}

#[derive(Debug)]
struct Window {
    against: Against,
    middle: f64,
    width: f64,
    size: f64,
}

impl Window {
    fn at(&self, u: f64) -> f64 {
        self.size * hat(u, self.middle, self.width)
    }
}

/// Centres of `count` overlapping windows over a range, and their half width; `None` for an empty
/// range.
pub(crate) fn window_grid((low, high): (f64, f64), count: usize) -> Option<(Vec<f64>, f64)> {
    // A device without a drive has no voltage to speak of.
    if high.is_nan() || high <= low {
        return None;
    }
    let width = (high - low) / (count - 1) as f64;
    Some(((0..count).map(|i| low + i as f64 * width).collect(), width))
}

/// A window: 1 at `middle`, falling to 0 at a distance of `width` as `cos^2(pi d / 2)`. It is
/// smooth, so that the simulation needs no breaks.
pub(crate) fn hat(u: f64, middle: f64, width: f64) -> f64 {
    let d = ((u - middle) / width).abs();
    if d < 1.0 {
        (0.5 * std::f64::consts::PI * d).cos().powi(2)
    } else {
        0.0
    }
}

impl Action for Window {
    fn does_nothing(&self) -> bool {
        self.size == 0.0
    }

    fn force_on_proof_mass(&self, at: &Kinematics, _z: &[f64]) -> f64 {
        match self.against {
            Against::Height => self.at(at.xp),
            Against::Velocity => self.at(at.vp),
            Against::Voltage => self.at(at.voltage),
            Against::DampingAtHeight => self.at(at.xp) * at.vp,
            Against::DampingAtVoltage => self.at(at.voltage) * at.vp,
            Against::StiffnessAtVoltage => self.at(at.voltage) * at.xp,
            Against::Drive => 0.0,
        }
    }

    fn drive_gain(&self, gain: f64, at: &Kinematics, _z: &[f64]) -> f64 {
        match self.against {
            Against::Drive => gain + self.at(at.voltage),
            _ => gain,
        }
    }
}
