//! Draws of laws that the catalogue does not have.

use super::drawn::{Drawn, strength, term};
use super::hidden_forces::Term;
use super::law::Law;
use crate::trial::device::Device;
use crate::trial::rng::TrialRng;

/// A force by velocity times voltage.
pub(super) fn voltage_damping(_: &Device, _: bool, rng: &mut TrialRng) -> Drawn {
    let (c, room) = strength(rng, 1e-9, 1e-7);
    let c = c * rng.sign();
    Some(term(
        "force by velocity times voltage",
        room,
        Term::VoltageDamping { c },
    ))
}

/// A stiffness that oscillates in time.
pub(super) fn pumped_stiffness(_: &Device, _: bool, rng: &mut TrialRng) -> Drawn {
    let (k, room) = strength(rng, 2e-5, 1e-3);
    let frequency = rng.log_between(80.0, 1500.0);
    Some(term(
        "stiffness that comes and goes",
        room,
        Term::Pumped { k, frequency },
    ))
}

/// A second spring beyond a point.
pub(super) fn bilinear_spring(_: &Device, _: bool, rng: &mut TrialRng) -> Drawn {
    let (k, room) = strength(rng, 1e-5, 3e-3);
    let from = rng.between(5e-6, 30e-6);
    let k = k * rng.sign();
    Some(term(
        "second spring beyond a point",
        room,
        Term::Bilinear { k, from },
    ))
}

/// A gain of the drive that wanders.
pub(super) fn gain_walk(_: &Device, _: bool, rng: &mut TrialRng) -> Drawn {
    let (rate, room) = strength(rng, 5e-3, 0.1);
    let seed = rng.seed();
    Some((
        "random walk of the drive gain",
        room,
        Law::Wander { rate, seed },
    ))
}

/// A dead zone of the drive around zero volts.
pub(super) fn dead_zone(_: &Device, _: bool, rng: &mut TrialRng) -> Drawn {
    let (width, room) = strength(rng, 0.05, 1.0);
    Some(("dead zone around zero volts", room, Law::DeadZone(width)))
}

/// Friction in proportion to the load.
pub(super) fn load_friction(_: &Device, _: bool, rng: &mut TrialRng) -> Drawn {
    let (k, room) = strength(rng, 2e-5, 2e-3);
    let v0 = rng.log_between(1e-3, 1e-2);
    Some(term("friction by load", room, Term::LoadFriction { k, v0 }))
}

/// Bursts of a ringing force.
pub(super) fn bursts(_: &Device, _: bool, rng: &mut TrialRng) -> Drawn {
    let (a, room) = strength(rng, 5e-9, 1e-7);
    let law = Law::Bursts {
        a,
        frequency: rng.log_between(200.0, 4000.0),
        tau: rng.log_between(2e-4, 2e-3),
        per_second: rng.between(20.0, 80.0),
        seed: rng.seed(),
    };
    Some(("bursts at random times", room, law))
}

/// Negative damping around a position.
pub(super) fn negative_damping(_: &Device, _: bool, rng: &mut TrialRng) -> Drawn {
    let (c, room) = strength(rng, 1e-9, 3e-8);
    let law = Term::Swing {
        c,
        at: rng.between(-30e-6, 40e-6),
        width: rng.between(5e-6, 20e-6),
    };
    Some(term("negative damping around a position", room, law))
}

/// A force by the product of both displacements.
pub(super) fn product_force(_: &Device, _: bool, rng: &mut TrialRng) -> Drawn {
    let (k, room) = strength(rng, 1.0, 60.0);
    let k = k * rng.sign();
    Some(term(
        "product of both displacements",
        room,
        Term::Product { k },
    ))
}
