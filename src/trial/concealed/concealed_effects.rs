//! What can be concealed: the catalogue's effects in formulations of the trial's own,
//! and laws that the catalogue does not have. Sizes are those of this device.

use super::hidden_forces::Term;
use super::law::{Drift, Law};
use crate::trial::device::structure::Mode;
use crate::trial::device::{Adhesion, Device, Ground, Restitution};
use crate::trial::rng::Dice;
use crate::trial::voltage::Amplifier;

/// Ids of the catalogue.
pub const CATALOGUE: [&str; 18] = [
    "amplifier_lag",
    "piezo_creep",
    "hysteresis_memory",
    "electrostatic",
    "extra_mode",
    "cubic_stiffness",
    "quadratic_drag",
    "dry_friction",
    "film_spring",
    "long_range_attraction",
    "adhesion_saturation",
    "velocity_restitution",
    "compliant_ground",
    "gap_step",
    "base_vibration",
    "zero_drift",
    "sensor_lag",
    "gravity",
];

/// Laws outside the catalogue.
pub const OUTSIDE: [&str; 9] = [
    "outside_voltage_damping",
    "outside_pumped_stiffness",
    "outside_bilinear_spring",
    "outside_gain_walk",
    "outside_dead_zone",
    "outside_load_friction",
    "outside_bursts",
    "outside_negative_damping",
    "outside_product_force",
];

/// A law with its name and the room for its strength.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// Id in the catalogue, or one of [`OUTSIDE`].
    pub id: String,
    /// Which formulation of it.
    pub formulation: &'static str,
    /// The law as drawn.
    pub law: Law,
    /// How many times stronger it may become and stay realistic.
    pub most: f64,
}

/// Draws the effect `id` for a device at a realistic size; `None` for an unknown id.
#[must_use]
pub fn choose(id: &str, device: &Device, dice: &mut Dice) -> Option<Choice> {
    let term = |formulation, most, term| (formulation, most, Law::Term(term));
    let other = dice.chance(0.5);
    // Strength within [low, high], and the room above it.
    let strength = |dice: &mut Dice, low: f64, high: f64| {
        let value = dice.log_between(low, high);
        (value, high / value)
    };
    let (formulation, most, law) = match id {
        "amplifier_lag" => {
            let (tau, room) = strength(dice, 1e-5, 4e-4);
            match dice.below(3) {
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
            }
        }
        "piezo_creep" => {
            let (c, room) = strength(dice, 5e-3, 0.3);
            let tau = dice.log_between(3e-3, 0.2);
            if other {
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
            }
        }
        "hysteresis_memory" => {
            let law = Law::Relays {
                coercive: dice.between(0.8, 2.2),
                spread: dice.between(0.7, 1.5),
                reach: dice.between(3.0, 6.0),
                height: dice.between(1.0, 2.4),
                blend: 1.0,
            };
            ("Preisach sum of relays", 1.0, law)
        }
        "electrostatic" => {
            let (share, room) = strength(dice, 0.1, 1.0);
            let capacitor = Term::Capacitor {
                area: share * 9e-8,
                gap: device.dp + dice.between(8e-6, 40e-6),
                fringe: if other { 65e-6 } else { f64::INFINITY },
            };
            let name = if other {
                "plate with fringe field"
            } else {
                "parallel plate"
            };
            term(name, room, capacitor)
        }
        "extra_mode" => {
            let (share, room) = strength(dice, 1e-3, 3e-2);
            let frequency = if other {
                dice.between(15e3, 20e3)
            } else {
                dice.between(2e3, 14e3)
            };
            let w = std::f64::consts::TAU * frequency;
            let (xp, _) = device.structure.static_gain()?;
            // phi_p drive / w^2 = share xp, shared evenly between both.
            let root = (share * xp).sqrt() * w;
            let skew = dice.log_between(0.5, 2.0);
            let mode = Mode {
                frequency,
                zeta: dice.log_between(3e-3, 2e-2),
                phi_p: root * skew,
                phi_c: root * skew * dice.sign() * dice.log_between(0.4, 2.5),
                drive: root / skew * dice.sign(),
                base: 0.0,
            };
            let name = if other { "third bending" } else { "torsion" };
            (name, room, Law::Mode(mode))
        }
        "cubic_stiffness" => {
            let (k3, room) = strength(dice, 2e3, 1e5);
            let law = Term::Hardening {
                k3: k3 * dice.sign(),
                limit: dice.between(150e-6, 400e-6),
            };
            term("hardening that levels off", room, law)
        }
        "quadratic_drag" => {
            let (cd, room) = strength(dice, 2e-8, 1e-6);
            let v0 = dice.log_between(1e-4, 1e-2);
            term("wake with a viscous onset", room, Term::Drag { cd, v0 })
        }
        "dry_friction" => {
            let (f, room) = strength(dice, 5e-10, 3e-8);
            ("Coulomb with jamming", room, Law::Friction(f))
        }
        "film_spring" => {
            let (tau, room) = strength(dice, 1e-5, 1e-3);
            let power = if other { 0 } else { 2 };
            let name = if other {
                "constant time"
            } else {
                "time grows as the gap closes"
            };
            (name, room, Law::Film { tau, power })
        }
        "long_range_attraction" => {
            let (a, room) = strength(dice, 4e-9, 1e-7);
            let h0 = dice.log_between(0.3e-6, 6e-6);
            if other {
                term("patch charges", room, Term::PatchAttraction { a, h0 })
            } else {
                let power = 2 + dice.below(2) as i32;
                term(
                    "power of the height",
                    room,
                    Term::PowerAttraction { a, h0, power },
                )
            }
        }
        "adhesion_saturation" => {
            let rise = dice.log_between(20e-9, 300e-9);
            let tau = dice.log_between(5e-4, 2e-2);
            if other {
                let law = Adhesion::Stretched {
                    blend: 1.0,
                    rise,
                    tau,
                    beta: dice.between(0.7, 1.0),
                };
                ("stretched exponential", 1.0, Law::Adhesion(law))
            } else {
                let law = Adhesion::Logarithm {
                    blend: 1.0,
                    rise: 0.2 * rise,
                    tau: 0.1 * tau,
                };
                ("logarithm of time", 1.0, Law::Adhesion(law))
            }
        }
        "velocity_restitution" => {
            let v0 = dice.log_between(0.05, 0.3);
            if other {
                let law = Restitution::Plastic { blend: 1.0, v0 };
                ("plastic, v^(-1/4)", 1.0, Law::Restitution(law))
            } else {
                let (c, room) = strength(dice, 0.2, 1.2);
                let law = Restitution::Viscoelastic { c, v0 };
                ("viscoelastic, v^(1/5)", room, Law::Restitution(law))
            }
        }
        "compliant_ground" => {
            // Strength is compliance.
            let (soft, room) = strength(dice, 2e-3, 0.05);
            // Mass that the ground feels, and the damping ratio for the restitution.
            let mass = 1.0 / device.structure.mobility;
            let loss = -device.alpha.ln();
            let zeta = loss / loss.hypot(std::f64::consts::PI);
            if other {
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
            }
        }
        "gap_step" => {
            let (rise, room) = strength(dice, 2e-7, 5e-6);
            let once_in = (!other).then(|| dice.below(5));
            let law = Law::GapStep {
                rise: rise * dice.sign(),
                time: dice.between(0.02, 0.1),
                once_in,
            };
            let name = if other {
                "in every recording"
            } else {
                "once in the series"
            };
            (name, room, law)
        }
        "base_vibration" => {
            let (a, room) = strength(dice, 0.1, 50.0);
            let frequency = match dice.below(3) {
                0 => 50.0,
                1 => dice.log_between(10.0, 200.0),
                _ => dice.log_between(200.0, 2000.0),
            };
            let phase = dice.between(0.0, std::f64::consts::TAU);
            let base = Term::Base {
                a,
                frequency,
                phase,
            };
            term("sinusoid", room, base)
        }
        "zero_drift" => {
            let (amplitude, room) = strength(dice, 2e-7, 1e-5);
            let (course, name) = match dice.below(3) {
                0 => (Drift::Line(0.4), "line"),
                1 => (
                    Drift::Exponential(dice.log_between(0.03, 0.3)),
                    "exponential",
                ),
                _ => (Drift::Logarithm(dice.log_between(0.01, 0.1)), "logarithm"),
            };
            let amplitude = amplitude * dice.sign();
            (name, room, Law::Drift { amplitude, course })
        }
        "sensor_lag" => {
            let (tau, room) = strength(dice, 1.2e-5, 1e-4);
            if other {
                ("pure delay", room, Law::Delay(tau))
            } else {
                term("first order", room, Term::SensorLag { tau })
            }
        }
        "gravity" => term("weight", 1.0, Term::Weight { force: 3.4e-9 }),
        "outside_voltage_damping" => {
            let (c, room) = strength(dice, 1e-9, 1e-7);
            let c = c * dice.sign();
            term(
                "force by velocity times voltage",
                room,
                Term::VoltageDamping { c },
            )
        }
        "outside_pumped_stiffness" => {
            let (k, room) = strength(dice, 2e-5, 1e-3);
            let frequency = dice.log_between(80.0, 1500.0);
            term(
                "stiffness that comes and goes",
                room,
                Term::Pumped { k, frequency },
            )
        }
        "outside_bilinear_spring" => {
            let (k, room) = strength(dice, 1e-5, 3e-3);
            let from = dice.between(5e-6, 30e-6);
            let k = k * dice.sign();
            term(
                "second spring beyond a point",
                room,
                Term::Bilinear { k, from },
            )
        }
        "outside_gain_walk" => {
            let (rate, room) = strength(dice, 5e-3, 0.1);
            let seed = dice.seed();
            (
                "random walk of the drive gain",
                room,
                Law::Wander { rate, seed },
            )
        }
        "outside_dead_zone" => {
            let (width, room) = strength(dice, 0.05, 1.0);
            ("dead zone around zero volts", room, Law::DeadZone(width))
        }
        "outside_load_friction" => {
            let (k, room) = strength(dice, 2e-5, 2e-3);
            let v0 = dice.log_between(1e-3, 1e-2);
            term("friction by load", room, Term::LoadFriction { k, v0 })
        }
        "outside_bursts" => {
            let (a, room) = strength(dice, 5e-9, 1e-7);
            let law = Law::Bursts {
                a,
                frequency: dice.log_between(200.0, 4000.0),
                tau: dice.log_between(2e-4, 2e-3),
                per_second: dice.between(20.0, 80.0),
                seed: dice.seed(),
            };
            ("bursts at random times", room, law)
        }
        "outside_negative_damping" => {
            let (c, room) = strength(dice, 1e-9, 3e-8);
            let law = Term::Swing {
                c,
                at: dice.between(-30e-6, 40e-6),
                width: dice.between(5e-6, 20e-6),
            };
            term("negative damping around a position", room, law)
        }
        "outside_product_force" => {
            let (k, room) = strength(dice, 1.0, 60.0);
            let k = k * dice.sign();
            term("product of both displacements", room, Term::Product { k })
        }
        _ => return None,
    };
    Some(Choice {
        id: id.to_owned(),
        formulation,
        law,
        most: most.max(1.0),
    })
}
