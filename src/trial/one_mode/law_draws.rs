//! Draws of the laws of one-mode devices, as strong as is realistic; they are weakened afterwards.

use super::apparatus::Apparatus;
use super::law::OneModeLaw;
use crate::trial::rng::TrialRng;

/// Quadratic drag.
pub const QUADRATIC_DRAG: &str = "quadratic_drag";
/// Dry friction.
pub const DRY_FRICTION: &str = "dry_friction";
/// Friction in proportion to the deflection.
pub const LOAD_FRICTION: &str = "load_friction";
/// A stiffness that is alike on both sides but not linear.
pub const CUBIC_STIFFNESS: &str = "cubic_stiffness";
/// A stiffness that differs to both sides.
pub const EVEN_STIFFNESS: &str = "even_stiffness";
/// The sine of the angle.
pub const SINE_STIFFNESS: &str = "sine_stiffness";
/// Outside the catalogue: negative damping around a position.
pub const NEGATIVE_DAMPING: &str = "outside_negative_damping";
/// Outside the catalogue: a stiffness that comes and goes.
pub const PUMPED_STIFFNESS: &str = "outside_pumped_stiffness";
/// Outside the catalogue: gusts at random times.
pub const GUSTS: &str = "outside_bursts";

/// Names that say the same as `id`: a cubic with a quintic term is the series of a sine.
#[must_use]
pub fn same_as(id: &str) -> &'static [&'static str] {
    match id {
        SINE_STIFFNESS => &[CUBIC_STIFFNESS],
        _ => &[],
    }
}

/// Whether two laws bend the force against displacement alike, so that they cannot be told apart.
#[must_use]
pub fn are_alike(a: &str, b: &str) -> bool {
    same_as(a).contains(&b) || same_as(b).contains(&a)
}

/// A law with its formulation, as strong as is realistic for this device; `None` for an unknown id.
#[must_use]
pub fn draw(
    id: &str,
    apparatus: &Apparatus,
    rng: &mut TrialRng,
) -> Option<(&'static str, OneModeLaw)> {
    let (reach, omega) = (apparatus.amplitude(), apparatus.omega());
    let falls = apparatus.device.gravity > 0.0;
    let law = match id {
        // A ball of the lightest kind reaches its final speed within some metres.
        QUADRATIC_DRAG => OneModeLaw::QuadraticDrag {
            c: if falls { 0.3 } else { 0.5 / reach },
        },
        // A swing ends after some ten turns.
        DRY_FRICTION => OneModeLaw::DryFriction {
            a: 0.05 * omega * omega * reach,
        },
        // As much of the energy of each turn as a damping ratio of 1.6 %.
        LOAD_FRICTION => OneModeLaw::LoadFriction {
            m: 0.05 * omega * omega,
        },
        CUBIC_STIFFNESS => OneModeLaw::CubicStiffness {
            k: 0.4 * rng.sign() * (omega / reach).powi(2),
        },
        EVEN_STIFFNESS => OneModeLaw::EvenStiffness {
            k: 0.3 * rng.sign() * omega * omega / reach,
        },
        SINE_STIFFNESS => OneModeLaw::SineStiffness {
            b: if apparatus.swings { 1.0 } else { 1.2 / reach },
            omega,
        },
        // Never so strong that a swing would grow.
        NEGATIVE_DAMPING => OneModeLaw::NegativeDamping {
            c: 1.8 * apparatus.device.zeta * omega,
            at: 0.3 * reach * rng.between(-1.0, 1.0),
            width: reach * rng.between(0.1, 0.4),
        },
        PUMPED_STIFFNESS => OneModeLaw::PumpedStiffness {
            k: 0.1 * omega * omega,
            frequency: apparatus.device.frequency * rng.between(0.15, 0.8),
        },
        GUSTS => gusts(apparatus, rng),
        _ => return None,
    };
    let formulation = match id {
        QUADRATIC_DRAG => "square of the velocity",
        DRY_FRICTION => "Coulomb with a hold at rest",
        LOAD_FRICTION => "friction in proportion to the deflection",
        CUBIC_STIFFNESS => "third power of the displacement",
        EVEN_STIFFNESS => "second power of the displacement",
        SINE_STIFFNESS => "sine of the displacement",
        NEGATIVE_DAMPING => "negative damping around a position",
        PUMPED_STIFFNESS => "stiffness that comes and goes",
        _ => "gusts at random times",
    };
    Some((formulation, law))
}

/// Gusts of some tenth of a run, one in a fall, more in a swing.
fn gusts(apparatus: &Apparatus, rng: &mut TrialRng) -> OneModeLaw {
    let device = &apparatus.device;
    let longest = apparatus.runs.iter().map(|r| r.duration);
    let longest = longest.fold(0.0, f64::max);
    let (a, tau, count) = if device.gravity > 0.0 {
        (0.3 * device.gravity, 0.06 * longest, 1)
    } else {
        let strongest = 0.2 * apparatus.omega().powi(2) * apparatus.amplitude();
        (strongest, rng.between(0.1, 0.4) / device.frequency, 5)
    };
    let begins = apparatus
        .runs
        .iter()
        .map(|run| {
            (0..count)
                .map(|_| run.duration * rng.between(0.1, 0.8))
                .collect()
        })
        .collect();
    OneModeLaw::Gusts { a, tau, begins }
}
