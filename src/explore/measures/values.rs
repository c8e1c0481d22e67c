//! Values of measures.

use super::catalogue::{Basis, MeasureId};
use super::contact;
use super::margin::Margin;
use super::regime::Regime;
use crate::explore::steady_state::{ResponseKind, SteadyError, SteadyResponse, SteadySolver};
use crate::model::drive::Waveform;
use crate::sim::Integrals;

/// Energies over one period of the drive, mean over the cycle \[J\].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EnergyBalance {
    /// Work of the drive.
    pub drive_work: f64,
    /// Work of effects' forces, and of a vibrating base.
    pub effect_work: f64,
    /// Lost in impacts on a rigid ground.
    pub impacts: f64,
    /// Lost in the film.
    pub film: f64,
    /// Lost in the damping of the modes.
    pub structure: f64,
    /// Lost in friction.
    pub friction: f64,
    /// Lost in a compliant ground.
    pub ground: f64,
}

impl EnergyBalance {
    /// From a response and its integrals.
    #[must_use]
    pub fn of(response: &SteadyResponse, integrals: &Integrals) -> Self {
        let each = |energy: f64| energy / response.cycle.periods.max(1) as f64;
        Self {
            drive_work: each(integrals.drive_work),
            effect_work: each(integrals.effect_work),
            impacts: each(contact::impact_loss(&response.cycle)),
            film: each(integrals.film_loss),
            structure: each(integrals.structure_loss),
            friction: each(integrals.friction_loss),
            ground: each(integrals.ground_loss),
        }
    }

    /// All losses.
    #[must_use]
    pub fn lost(&self) -> f64 {
        self.impacts + self.film + self.structure + self.friction + self.ground
    }

    /// What is left of work less losses, as a share of the larger; 0 in a steady state.
    #[must_use]
    pub fn imbalance(&self) -> f64 {
        let (work, lost) = (self.drive_work + self.effect_work, self.lost());
        let size = work.abs().max(lost.abs());
        if size > 0.0 {
            (work - lost) / size
        } else {
            0.0
        }
    }
}

/// Values of `measures` for a response, in their order; `None` where there is none, such as an impact
/// speed without contact. The cycle is simulated once more if one of them rests on integrals.
///
/// # Errors
/// Those of that simulation.
pub fn measure(
    solver: &mut SteadySolver,
    drive: &Waveform,
    response: &SteadyResponse,
    measures: &[MeasureId],
) -> Result<Vec<Option<f64>>, SteadyError> {
    let needed = measures.iter().any(|m| m.spec().basis == Basis::Integrals);
    let integrals = if needed {
        Some(solver.integrals(drive, response)?)
    } else {
        None
    };
    let all = measures.iter();
    Ok(all
        .map(|measure| value(*measure, response, integrals.as_ref()))
        .collect())
}

/// Value of a measure; `None` where there is none, and without the integrals that it rests on.
#[must_use]
pub fn value(
    measure: MeasureId,
    response: &SteadyResponse,
    integrals: Option<&Integrals>,
) -> Option<f64> {
    use MeasureId as M;
    let cycle = &response.cycle;
    let periods = cycle.periods.max(1) as f64;
    let energies = || integrals.map(|i| EnergyBalance::of(response, i));
    let finite = |value: f64| value.is_finite().then_some(value);
    match measure {
        M::Regime => Some(f64::from(Regime::of(response).code())),
        M::Multiple => match response.kind {
            ResponseKind::Periodic { multiple } => Some(multiple as f64),
            ResponseKind::NotPeriodic(_) => None,
        },
        M::ContactShare => Some(contact::contact_time(cycle) / cycle.duration),
        M::ContactDuration => {
            let contacts = contact::sticks(cycle) as f64;
            (contacts > 0.0).then(|| contact::contact_time(cycle) / contacts)
        }
        M::Bounces => Some(contact::bounces(cycle) as f64 / periods),
        M::Peak => finite(cycle.span()),
        M::FirstImpactSpeed => contact::first_impact_speed(cycle),
        M::LargestImpactSpeed => contact::largest_impact_speed(cycle),
        M::MeanGroundForce => {
            integrals.map(|i| (i.ground_impulse + contact::impact_impulse(cycle)) / cycle.duration)
        }
        M::PullOffForce => contact::pull_off_force(cycle),
        M::EnergyLost => energies().map(|e| e.lost()),
        M::ImpactLoss => Some(contact::impact_loss(cycle) / periods),
        M::FilmLoss => energies().map(|e| e.film),
        M::StructureLoss => energies().map(|e| e.structure),
        M::DriveWork => energies().map(|e| e.drive_work),
        M::Margin => finite(Margin::of(response).distance),
        M::LargestMultiplier => response.stability.largest_modulus(),
    }
}
