//! Devices with closed forms, for tests.

use crate::model::Model;
use crate::model::effects::{self, ActiveEffect};
use crate::model::parameter::ParameterId as P;
use crate::model::piezo::Piezo;
use crate::model::preset::Preset;

/// Force of the drive \[N/V\] on [`linear`].
pub const FORCE_PER_VOLT: f64 = 0.01;

/// A mass on a spring with damping ratio `zeta` under a force of [`FORCE_PER_VOLT`] times the voltage.
pub fn linear(zeta: f64) -> Model {
    let mut model = Preset::embedded("oscillator").unwrap().model;
    let straight = [0.0, 1.0, 0.0, 0.0];
    model.piezo = Some(Piezo {
        rising: straight,
        falling: straight,
    });
    model.modes[0].phi_drive = model.modes[0].phi_p;
    model.parameters.set(P::Eta, FORCE_PER_VOLT);
    model.parameters.set(P::Zeta1, zeta);
    model.parameters.set(P::X0, 0.0);
    model
}

/// Its natural frequency \[Hz\].
pub fn natural_frequency(model: &Model) -> f64 {
    model.parameters[P::F1]
}

/// Its mass \[kg\].
pub fn mass(model: &Model) -> f64 {
    model.modes[0].phi_p.powi(-2)
}

/// Amplitude of its response \[m\] to a sine of `frequency` \[Hz\] and `voltage` \[V\].
pub fn amplitude(model: &Model, frequency: f64, voltage: f64) -> f64 {
    let w = std::f64::consts::TAU * natural_frequency(model);
    let drive = std::f64::consts::TAU * frequency;
    let zeta = model.parameters[P::Zeta1];
    let force = model.parameters[P::Eta] * voltage / mass(model);
    force / (w * w - drive * drive).hypot(2.0 * zeta * w * drive)
}

/// [`linear`] with a spring that hardens: at a response of amplitude `size` \[m\] the squared natural
/// frequency is larger by a share `shift` (harmonic balance).
pub fn hardening(zeta: f64, size: f64, shift: f64) -> Model {
    let mut model = linear(zeta);
    let stiffness = mass(&model) * (std::f64::consts::TAU * natural_frequency(&model)).powi(2);
    let mut effect = ActiveEffect::new(effects::find("cubic_stiffness").unwrap());
    assert!(effect.set("k3", 4.0 / 3.0 * shift * stiffness / size.powi(2)));
    model.effects.push(effect);
    model
}
