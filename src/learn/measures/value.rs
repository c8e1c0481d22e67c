//! What a name in an expression stands for in a run: a parameter, a value of the drive, or a measure.

use super::motion::{
    NO_ARRIVAL, NO_CONTACT, NO_PERIOD, NO_SAMPLES, amplitude, arrivals, loop_width, maximum,
    rebound_height, releases, shares,
};
use super::table::{Kind, find, names};
use crate::learn::controls;
use crate::learn::expression::ExpressionError;
use crate::learn::run::Run;
use crate::model::parameter::ParameterId;

impl Run {
    /// Value of a parameter of its device or of a measure \[SI\].
    ///
    /// # Errors
    /// A name that is neither, or a measure that this run does not have.
    pub fn value(&self, id: &str, nth: Option<usize>) -> Result<f64, ExpressionError> {
        if let (Some(value), None) = (self.model.get(id), nth) {
            return Ok(value);
        }
        if let (Some(value), None) = (controls::value_of_drive(&self.drive, id), nth) {
            return Ok(value);
        }
        value(self, id, nth)
    }

    /// SI unit of a parameter or measure; `None` if there is none of that name.
    pub fn unit_of(&self, id: &str) -> Option<&'static str> {
        self.model
            .unit_of(id)
            .or_else(|| controls::drive_unit(id))
            .or_else(|| find(id).map(|spec| self.model.coordinate.unit(spec.unit)))
    }
}

/// Value of a measure of a run \[SI\]; of the first occurrence if none is named.
///
/// # Errors
/// [`ExpressionError`]: none of that name, or the run does not have it.
fn value(run: &Run, id: &str, nth: Option<usize>) -> Result<f64, ExpressionError> {
    let unknown = || ExpressionError::Unknown {
        name: id.to_owned(),
        known: names(),
    };
    let spec = find(id).ok_or_else(unknown)?;
    if nth.is_some() && !spec.is_counted {
        return Err(unknown());
    }
    let found = of_run(run, spec.kind, nth.unwrap_or(1) - 1);
    found.map_err(|why| ExpressionError::Missing {
        name: id.to_owned(),
        which: nth.map_or_else(String::new, |n| format!(" number {n}")),
        why,
    })
}

fn of_run(run: &Run, kind: Kind, n: usize) -> Result<f64, &'static str> {
    let trace = &*run.trace;
    let energies = run.energies.last();
    let arrival = || arrivals(trace).nth(n).ok_or(NO_ARRIVAL);
    let range = || crate::recording::extremes(&trace.proof_mass);
    Ok(match kind {
        Kind::Impacts => arrivals(trace).count() as f64,
        Kind::Contacts => trace.contacts.len() as f64,
        Kind::ArrivalTime => arrival()?.time,
        Kind::ImpactSpeed => arrival()?.velocity_before.abs(),
        Kind::ReboundSpeed => arrival()?.velocity_after.abs(),
        Kind::ReboundHeight => rebound_height(trace, n)?,
        Kind::ContactTime => releases(trace).nth(n).ok_or(NO_CONTACT)?.contact_duration,
        Kind::LongestContact => {
            let all = releases(trace).map(|event| event.contact_duration);
            all.reduce(f64::max).ok_or(NO_CONTACT)?
        }
        Kind::ReleaseForce => releases(trace).nth(n).ok_or(NO_CONTACT)?.pull_off_force,
        Kind::FilmForce => {
            let forces = trace.forces.as_ref().ok_or(NO_SAMPLES)?;
            forces
                .film
                .iter()
                .fold(0.0, |most: f64, f| most.max(f.abs()))
        }
        Kind::Highest => range().1,
        Kind::Lowest => range().0,
        Kind::PeakToPeak => range().1 - range().0,
        Kind::EndDisplacement => *trace.proof_mass.last().ok_or(NO_SAMPLES)?,
        Kind::Amplitude => amplitude(run),
        Kind::Maximum => maximum(trace, n)?.1,
        Kind::MaximumTime => maximum(trace, n)?.0,
        Kind::SwingTime => maximum(trace, n + 1)?.0 - maximum(trace, n)?.0,
        Kind::LoopWidth => loop_width(run)?,
        Kind::ContactShare => shares(run)?.0,
        Kind::BothUpShare => shares(run)?.1,
        Kind::FilmLoss => energies.film,
        Kind::BounceLoss => energies.bounces,
        Kind::StickingLoss => energies.sticking,
        Kind::DampingLoss => energies.damping,
        Kind::DriveWork => energies.drive_work,
        Kind::Period => run.period.ok_or(NO_PERIOD)?,
        Kind::Duration => run.duration,
        Kind::ProofMass => run.model.proof_mass,
        Kind::FirstFrequency => 1.0 / (maximum(trace, 1)?.0 - maximum(trace, 0)?.0),
        Kind::StaticGap => {
            run.model.parameters[ParameterId::Gp] - run.model.parameters[ParameterId::Dp]
        }
    })
}
