//! A mass on a spring, a pendulum, a free mass.

use std::f64::consts::{PI, TAU};

use super::beam::device::format_mass;
use super::error::{DesignError, not_negative, positive};
use super::ranges::round_number;
use super::setting::{Designed, Parts, Setting};
use crate::model::effects::{ActiveEffect, nonlinear_stiffness, weight};
use crate::model::ground::{BounceRule, StickSpeed};
use crate::model::parameter::ParameterId;
use crate::model::preset::known_value::KnownValue;
use crate::model::structure::Mode;
use crate::model::unit::{Coordinate, format_quantity};

/// Standard error of gravity that was not given, as a share: g on earth differs by up to 0.3 % from
/// standard gravity.
const GRAVITY_ERROR: f64 = 0.005;

/// One mass on a spring, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct MassOnSpring {
    /// Moving mass \[kg\].
    pub mass: f64,
    /// Stiffness \[N/m\].
    pub stiffness: f64,
    /// Displacement at t = 0 \[m\].
    pub start: Option<f64>,
}

impl MassOnSpring {
    /// The device.
    ///
    /// # Errors
    /// [`DesignError`] naming the value at fault.
    pub fn device(&self, setting: &Setting) -> Result<Designed, DesignError> {
        let mass = positive("m", self.mass, "kg")?;
        let stiffness = positive("k", self.stiffness, "N/m")?;
        let mut notes = setting.damping_notes(1);
        let start = self.start.map(|x0| (ParameterId::X0, x0));
        if start.is_none() && setting.force_per_volt.is_none() {
            notes.push(
                "Neither a drive nor a displacement at the start (x0) was given: it stays at rest."
                    .to_owned(),
            );
        }
        let phi = 1.0 / mass.sqrt();
        setting.device(Parts {
            about: format!(
                "a mass of {} on a spring of {}",
                format_mass(mass),
                format_quantity(stiffness, "N/m", 4)
            ),
            modes: vec![Mode {
                frequency: (stiffness / mass).sqrt() / TAU,
                zeta: setting.zeta(0),
                phi_c: 0.0,
                phi_p: phi,
                phi_drive: if setting.force_per_volt.is_some() {
                    phi
                } else {
                    0.0
                },
            }],
            proof_mass: mass,
            has_cantilever: false,
            coordinate: Coordinate::Length,
            drive: None,
            bounce: BounceRule::PullOff,
            start: start.into_iter().collect(),
            notes,
        })
    }
}

/// A pendulum, read by its angle \[rad\].
#[derive(Debug, Clone, PartialEq)]
pub struct Pendulum {
    /// Distance of the centre of mass from the pivot \[m\].
    pub arm: f64,
    /// Mass \[kg\].
    pub mass: f64,
    /// Moment of inertia about the pivot [kg m^2]; `m arm^2` for a mass on a thread.
    pub inertia: Option<f64>,
    /// Gravity [m/s^2].
    pub gravity: f64,
    /// Angle at t = 0 \[rad\].
    pub start: f64,
}

impl Pendulum {
    /// The device: `J a'' + 2 zeta w J a' + m g l sin(a) = 0`, the sine by the sine form of the effect
    /// `cubic_stiffness` over one radian.
    ///
    /// # Errors
    /// [`DesignError`] naming the value at fault.
    pub fn device(&self, setting: &Setting) -> Result<Designed, DesignError> {
        let arm = positive("L", self.arm, "m")?;
        let mass = positive("m", self.mass, "kg")?;
        let gravity = positive("g", self.gravity, "m/s^2")?;
        let inertia = match self.inertia {
            Some(inertia) => positive("inertia", inertia, "kg m^2")?,
            None => mass * arm * arm,
        };
        if self.start.is_nan() || self.start.abs() > PI {
            let reason = format!("must lie between -pi and pi rad, not {} rad", self.start);
            return Err(DesignError::value("angle", reason));
        }
        if setting.ground.is_some() || setting.force_per_volt.is_some() {
            return Err(DesignError::value(
                "pendulum",
                "a pendulum has neither ground nor drive here; use a mass on a spring for those",
            ));
        }
        if inertia < mass * arm * arm * (1.0 - 1e-9) {
            let reason = format!(
                "must be at least m L^2 = {:.4e} kg m^2, not {inertia:.4e} kg m^2",
                mass * arm * arm
            );
            return Err(DesignError::value("inertia", reason));
        }
        let stiffness = mass * gravity * arm;
        let mut notes = setting.damping_notes(1);
        notes.push("Angles are in rad: x0, offsets and readings; forces are moments [N m], masses moments of inertia [kg m^2].".to_owned());
        if self.start == 0.0 {
            notes.push("No angle at the start was given: it hangs still.".to_owned());
        }
        let mut made = setting.device(Parts {
            about: format!(
                "a pendulum of {} in gravity of {}, read by its angle",
                format_quantity(arm, "m", 4),
                format_quantity(gravity, "m/s^2", 4)
            ),
            modes: vec![Mode {
                frequency: (stiffness / inertia).sqrt() / TAU,
                zeta: setting.zeta(0),
                phi_c: 0.0,
                phi_p: 1.0 / inertia.sqrt(),
                phi_drive: 0.0,
            }],
            proof_mass: inertia,
            has_cantilever: false,
            coordinate: Coordinate::Angle,
            drive: None,
            bounce: BounceRule::PullOff,
            start: vec![(ParameterId::X0, self.start)],
            notes,
        })?;
        let mut sine = ActiveEffect::new(nonlinear_stiffness());
        sine.set("k3", -stiffness / 6.0);
        sine.set("k5", 0.0);
        sine.set("l", 1.0);
        made.preset.model.effects.push(sine);
        made.preset.model.check()?;
        Ok(made)
    }
}

/// A free mass under gravity, with or without a ground.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeMass {
    /// Mass \[kg\].
    pub mass: f64,
    /// Height at t = 0 above the zero of the reading \[m\].
    pub height: f64,
    /// Speed at t = 0, up positive [m/s].
    pub speed: f64,
    /// Gravity [m/s^2]; `None` for standard gravity, known to half a percent.
    pub gravity: Option<f64>,
}

impl FreeMass {
    /// The device. On a ground it rebounds by restitution: the paper's rule would make it stick.
    ///
    /// # Errors
    /// [`DesignError`] naming the value at fault.
    pub fn device(&self, setting: &Setting) -> Result<Designed, DesignError> {
        let mass = positive("m", self.mass, "kg")?;
        let gravity = not_negative("g", self.gravity.unwrap_or(9.80665), "m/s^2")?;
        if setting.force_per_volt.is_some() {
            return Err(DesignError::value("force", "a free mass has no drive here"));
        }
        let bounce = match setting.ground {
            Some(_) => BounceRule::Restitution(StickSpeed::default()),
            None => BounceRule::PullOff,
        };
        let mut made = setting.device(Parts {
            about: format!("a free mass of {}", format_mass(mass)),
            modes: vec![Mode {
                frequency: 0.0,
                zeta: 0.0,
                phi_c: 0.0,
                phi_p: 1.0 / mass.sqrt(),
                phi_drive: 0.0,
            }],
            proof_mass: mass,
            has_cantilever: false,
            coordinate: Coordinate::Length,
            drive: None,
            bounce,
            start: vec![
                (ParameterId::X0, self.height),
                (ParameterId::V0, self.speed),
            ],
            notes: Vec::new(),
        })?;
        if gravity > 0.0 {
            let mut own = ActiveEffect::new(weight());
            own.set("g", gravity);
            made.preset.model.effects.push(own);
            if self.gravity.is_none() {
                let known = (gravity, GRAVITY_ERROR * gravity);
                let known =
                    KnownValue::new(&made.preset.model, &format!("{}.g", weight().id), known)?;
                made.preset.known.push(known);
                made.notes
                    .push("g was not given: standard gravity is taken, known to 0.5 %.".to_owned());
            }
            // It falls from its start to the ground, and bounces for a while.
            let drop = self.height + setting.ground.map_or(self.height.abs(), |g| g.distance);
            let fall = (2.0 * drop.abs() / gravity).sqrt();
            if fall > 0.0 {
                made.preset.duration = round_number(8.0 * fall);
            }
        }
        made.preset.model.check()?;
        Ok(made)
    }
}
