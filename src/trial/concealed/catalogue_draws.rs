//! Draws of the catalogue's effects, each in formulations of the trial's own.

use super::drawn::{Drawn, strength, term};
use super::hidden_forces::Term;
use super::law::{Drift, Law};
use crate::trial::device::structure::Mode;
use crate::trial::device::{Adhesion, Device, Ground, Restitution};
use crate::trial::rng::TrialRng;
use crate::trial::voltage::Amplifier;

/// The amplifier: an RC low-pass, a ladder of two, or a bounded slew rate.
pub(super) fn amplifier_lag(_: &Device, _: bool, rng: &mut TrialRng) -> Drawn {
    let (tau, room) = strength(rng, 1e-5, 4e-4);
    Some(match rng.below(3) {
        0 => {
            let law = Amplifier::Ladder {
                first: tau,
                second: 0.0,
            };
            ("one resistor and capacitor", room, Law::Amplifier(law))
        }
        1 => {
            let law = Amplifier::Ladder {
                first: 0.8 * tau,
                second: 0.2 * tau,
            };
            ("ladder of two", room, Law::Amplifier(law))
        }
        _ => {
            // As long for a step of 16 V as the lag takes to settle.
            let law = Amplifier::Slew {
                rate: 8.0 / tau,
                lag: 5e-6,
            };
            ("bounded slew rate", room, Law::Amplifier(law))
        }
    })
}

/// Creep of the piezo in Kelvin-Voigt elements.
pub(super) fn piezo_creep(_: &Device, other: bool, rng: &mut TrialRng) -> Drawn {
    let (c, room) = strength(rng, 5e-3, 0.3);
    let tau = rng.log_between(3e-3, 0.2);
    Some(if other {
        let one = Term::Creep {
            compliance: [c, 0.0, 0.0],
            tau: [tau, 1.0, 1.0],
        };
        term("one Kelvin-Voigt element", room, one)
    } else {
        let chain = Term::Creep {
            compliance: [c / 3.0; 3],
            tau: [tau / 4.0, tau, tau * 4.0],
        };
        term("chain of three Kelvin-Voigt elements", room, chain)
    })
}

/// A Preisach sum of relays.
pub(super) fn hysteresis_memory(_: &Device, _: bool, rng: &mut TrialRng) -> Drawn {
    let law = Law::Relays {
        coercive: rng.between(0.8, 2.2),
        spread: rng.between(0.7, 1.5),
        reach: rng.between(3.0, 6.0),
        height: rng.between(1.0, 2.4),
        blend: 1.0,
    };
    Some(("Preisach sum of relays", 1.0, law))
}

/// A plate capacitor between mass and ground.
pub(super) fn electrostatic(device: &Device, other: bool, rng: &mut TrialRng) -> Drawn {
    let (share, room) = strength(rng, 0.1, 1.0);
    let capacitor = Term::Capacitor {
        area: share * 9e-8,
        gap: device.dp + rng.between(8e-6, 40e-6),
        fringe: if other { 65e-6 } else { f64::INFINITY },
    };
    let name = if other {
        "plate with fringe field"
    } else {
        "parallel plate"
    };
    Some(term(name, room, capacitor))
}

/// A further mode of the structure.
pub(super) fn extra_mode(device: &Device, other: bool, rng: &mut TrialRng) -> Drawn {
    let (share, room) = strength(rng, 1e-3, 3e-2);
    let frequency = if other {
        rng.between(15e3, 20e3)
    } else {
        rng.between(2e3, 14e3)
    };
    let w = std::f64::consts::TAU * frequency;
    let (xp, _) = device.structure.static_gain()?;
    // phi_p drive / w^2 = share xp, shared evenly between both.
    let root = (share * xp).sqrt() * w;
    let skew = rng.log_between(0.5, 2.0);
    let mode = Mode {
        frequency,
        zeta: rng.log_between(3e-3, 2e-2),
        phi_p: root * skew,
        phi_c: root * skew * rng.sign() * rng.log_between(0.4, 2.5),
        drive: root / skew * rng.sign(),
        base: 0.0,
    };
    let name = if other { "third bending" } else { "torsion" };
    Some((name, room, Law::Mode(mode)))
}

/// A spring that hardens or softens.
pub(super) fn cubic_stiffness(_: &Device, _: bool, rng: &mut TrialRng) -> Drawn {
    let (k3, room) = strength(rng, 2e3, 1e5);
    let law = Term::Hardening {
        k3: k3 * rng.sign(),
        limit: rng.between(150e-6, 400e-6),
    };
    Some(term("hardening that levels off", room, law))
}

/// Drag of a wake.
pub(super) fn quadratic_drag(_: &Device, _: bool, rng: &mut TrialRng) -> Drawn {
    let (cd, room) = strength(rng, 2e-8, 1e-6);
    let v0 = rng.log_between(1e-4, 1e-2);
    Some(term(
        "wake with a viscous onset",
        room,
        Term::Drag { cd, v0 },
    ))
}

/// Coulomb friction.
pub(super) fn dry_friction(_: &Device, _: bool, rng: &mut TrialRng) -> Drawn {
    let (f, room) = strength(rng, 5e-10, 3e-8);
    Some(("Coulomb with jamming", room, Law::Friction(f)))
}

/// Elasticity of the gas film.
pub(super) fn film_spring(_: &Device, other: bool, rng: &mut TrialRng) -> Drawn {
    let (tau, room) = strength(rng, 1e-5, 1e-3);
    let power = if other { 0 } else { 2 };
    let name = if other {
        "constant time"
    } else {
        "time grows as the gap closes"
    };
    Some((name, room, Law::Film { tau, power }))
}

/// Attraction by the ground.
pub(super) fn long_range_attraction(_: &Device, other: bool, rng: &mut TrialRng) -> Drawn {
    let (a, room) = strength(rng, 4e-9, 1e-7);
    let h0 = rng.log_between(0.3e-6, 6e-6);
    Some(if other {
        term("patch charges", room, Term::PatchAttraction { a, h0 })
    } else {
        let power = 2 + rng.below(2) as i32;
        term(
            "power of the height",
            room,
            Term::PowerAttraction { a, h0, power },
        )
    })
}

/// Adhesion that no longer grows in proportion to contact time.
pub(super) fn adhesion_saturation(_: &Device, other: bool, rng: &mut TrialRng) -> Drawn {
    let rise = rng.log_between(20e-9, 300e-9);
    let tau = rng.log_between(5e-4, 2e-2);
    Some(if other {
        let law = Adhesion::Stretched {
            blend: 1.0,
            rise,
            tau,
            beta: rng.between(0.7, 1.0),
        };
        ("stretched exponential", 1.0, Law::Adhesion(law))
    } else {
        let law = Adhesion::Logarithm {
            blend: 1.0,
            rise: 0.2 * rise,
            tau: 0.1 * tau,
        };
        ("logarithm of time", 1.0, Law::Adhesion(law))
    })
}

/// Restitution that falls with the speed of approach.
pub(super) fn velocity_restitution(_: &Device, other: bool, rng: &mut TrialRng) -> Drawn {
    let v0 = rng.log_between(0.05, 0.3);
    Some(if other {
        let law = Restitution::Plastic { blend: 1.0, v0 };
        ("plastic, v^(-1/4)", 1.0, Law::Restitution(law))
    } else {
        let (c, room) = strength(rng, 0.2, 1.2);
        let law = Restitution::Viscoelastic { c, v0 };
        ("viscoelastic, v^(1/5)", room, Law::Restitution(law))
    })
}

/// A ground that yields; the strength is its compliance.
pub(super) fn compliant_ground(device: &Device, other: bool, rng: &mut TrialRng) -> Drawn {
    // Strength is compliance.
    let (soft, room) = strength(rng, 2e-3, 0.05);
    // Mass that the ground feels, and the damping ratio for the restitution.
    let mass = 1.0 / device.structure.mobility;
    let loss = -device.alpha.ln();
    let zeta = loss / loss.hypot(std::f64::consts::PI);
    Some(if other {
        let stiffness = 1.0 / soft;
        let damping = 2.0 * zeta * (stiffness * mass).sqrt();
        let law = Ground::Bonded { stiffness, damping };
        ("Kelvin-Voigt bond that tears", room, Law::Ground(law))
    } else {
        // As stiff as the linear one at 0.2 um.
        let stiffness = 1.0 / soft / 2e-7f64.sqrt();
        let damping = 5.0f64.sqrt() * zeta * (stiffness * mass).sqrt();
        let law = Ground::Hertz { stiffness, damping };
        ("Hertz with Tsuji damping", room, Law::Ground(law))
    })
}

/// A step of the ground, once or in every recording.
pub(super) fn gap_step(_: &Device, other: bool, rng: &mut TrialRng) -> Drawn {
    let (rise, room) = strength(rng, 2e-7, 5e-6);
    let once_in = (!other).then(|| rng.below(5));
    let law = Law::GapStep {
        rise: rise * rng.sign(),
        time: rng.between(0.02, 0.1),
        once_in,
    };
    let name = if other {
        "in every recording"
    } else {
        "once in the series"
    };
    Some((name, room, law))
}

/// A sinusoidal vibration of the base.
pub(super) fn base_vibration(_: &Device, _: bool, rng: &mut TrialRng) -> Drawn {
    let (a, room) = strength(rng, 0.1, 50.0);
    let frequency = match rng.below(3) {
        0 => 50.0,
        1 => rng.log_between(10.0, 200.0),
        _ => rng.log_between(200.0, 2000.0),
    };
    let phase = rng.between(0.0, std::f64::consts::TAU);
    let base = Term::Base {
        a,
        frequency,
        phase,
    };
    Some(term("sinusoid", room, base))
}

/// Drift of the sensors' zero.
pub(super) fn zero_drift(_: &Device, _: bool, rng: &mut TrialRng) -> Drawn {
    let (amplitude, room) = strength(rng, 2e-7, 1e-5);
    let (course, name) = match rng.below(3) {
        0 => (Drift::Line(0.4), "line"),
        1 => (
            Drift::Exponential(rng.log_between(0.03, 0.3)),
            "exponential",
        ),
        _ => (Drift::Logarithm(rng.log_between(0.01, 0.1)), "logarithm"),
    };
    let amplitude = amplitude * rng.sign();
    Some((name, room, Law::Drift { amplitude, course }))
}

/// A sensor with a lag or a pure delay.
pub(super) fn sensor_lag(_: &Device, other: bool, rng: &mut TrialRng) -> Drawn {
    let (tau, room) = strength(rng, 1.2e-5, 1e-4);
    Some(if other {
        ("pure delay", room, Law::Delay(tau))
    } else {
        term("first order", room, Term::SensorLag { tau })
    })
}

/// The weight of the mass.
pub(super) fn gravity(_: &Device, _: bool, _: &mut TrialRng) -> Drawn {
    Some(term("weight", 1.0, Term::Weight { force: 3.4e-9 }))
}
