//! The device of the paper's table and the excitations of a trial.

use super::Device;
use super::beam::Beam;
use super::laws::{Adhesion, Film, Gain, Ground, Restitution};
use super::structure::{Mode, Structure};
use crate::trial::voltage::Waveform;

/// Static motion of the mass \[m\] per unit of `gc`.
pub const STATIC_PER_GC: f64 = 16.5e-6;

/// The two modes of the table.
#[must_use]
pub fn table_modes() -> [Mode; 2] {
    let mode = |frequency, zeta, phi_c, phi_p| Mode {
        frequency,
        zeta,
        phi_c,
        phi_p,
        drive: phi_c,
        base: 0.0,
    };
    [
        mode(623.0, 0.0262, 13381.005, 50145.332),
        mode(6424.0, 0.0257, 74486.762, -12923.177),
    ]
}

/// The device with the values of the table, on the given structure.
#[must_use]
pub fn table_device(structure: Structure) -> Device {
    Device {
        structure,
        eta: 3.819e-7,
        cs: 1.747e-21,
        gp: 70e-6,
        dp: 58e-6,
        alpha: 0.378,
        ca: 1.7e-6,
        ca0: 2.743e-8,
        friction: 0.0,
        ground_rise: 0.0,
        rise_time: f64::INFINITY,
        ground: Ground::Rigid,
        restitution: Restitution::Constant,
        adhesion: Adhesion::Line,
        film: Film::Viscous,
        gain: Gain::Branches,
        terms: Vec::new(),
    }
}

/// The default beam with four modes. Its drive is scaled to the static motion of the tabulated
/// device. It is never `None` for this beam.
#[must_use]
pub fn table_beam() -> Option<Structure> {
    let modes = Beam::default().modes(4, &[0.0262, 0.0257, 0.02, 0.02])?;
    let mut structure = Structure::modal(&modes);
    let (xp, _) = structure.static_gain()?;
    structure.scale_drive(STATIC_PER_GC / 3.819e-7 / xp);
    Some(structure)
}

/// One recording to be made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Excitation {
    /// The voltage.
    pub waveform: Waveform,
    /// Duration \[s\].
    pub duration: f64,
    /// Whether it is a held-out recording.
    pub held_out: bool,
}

/// The five recordings to fit and the four held-out ones.
#[must_use]
pub fn excitations() -> Vec<Excitation> {
    let ramped = |frequency, amplitude, lambda| Waveform::Ramped {
        frequency,
        amplitude,
        lambda,
    };
    let square = |frequency, amplitude| Waveform::Square {
        frequency,
        amplitude,
    };
    let sine = |frequency, amplitude| Waveform::Sine {
        frequency,
        amplitude,
    };
    let list = [
        (ramped(5.0, 8.0, 0.25), 0.4, false),
        (square(15.0, 8.0), 0.2, false),
        (sine(50.0, 8.0), 0.12, false),
        (square(50.0, 6.0), 0.12, false),
        (square(300.0, 6.0), 0.05, false),
        (ramped(10.0, 8.0, 0.15), 0.3, true),
        (sine(15.0, 8.0), 0.2, true),
        (square(40.0, 7.0), 0.15, true),
        (square(300.0, 8.0), 0.05, true),
    ];
    list.map(|(waveform, duration, held_out)| Excitation {
        waveform,
        duration,
        held_out,
    })
    .into()
}
