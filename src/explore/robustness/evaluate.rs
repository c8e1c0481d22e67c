//! One drive on each member of an ensemble.

use super::ensemble::{Ensemble, Member};
use super::error::RobustnessError;
use super::result::{MemberAnswer, Robustness, summed_up};
use super::wish::Wish;
use crate::explore::map::{MapRequest, PointFault, PointSolver};
use crate::explore::measures::{MeasureId, Regime};
use crate::model::Model;
use crate::model::drive::Waveform;

/// What an ensemble around `model` says of one drive. `request` gives start, options and bounds; its axes do not
/// count.
///
/// # Errors
/// [`RobustnessError`] of ensemble or wish; `Ok(None)` if `go_on` says no.
pub fn evaluate(
    request: &MapRequest,
    (model, drive): (&Model, &Waveform),
    ensemble: &Ensemble,
    wish: &Wish,
    go_on: &dyn Fn() -> bool,
) -> Result<Option<Robustness>, RobustnessError> {
    ensemble.check(model)?;
    wish.check()?;
    let members = ensemble.draw()?;
    let case = Cases {
        request,
        ensemble,
        members: &members,
        wish,
    };
    let all = case.answer(&[(model.clone(), drive.clone())], go_on);
    Ok(all.and_then(|answers| answers.into_iter().next()))
}

/// Cases that share an ensemble and a wish.
pub(super) struct Cases<'a> {
    pub request: &'a MapRequest,
    pub ensemble: &'a Ensemble,
    pub members: &'a [Member],
    pub wish: &'a Wish,
}

impl Cases<'_> {
    /// For each device and drive what the ensemble says; `None` if `go_on` says no. Member after
    /// member, so that neighbours of one device share what is prepared for it.
    pub fn answer(
        &self,
        cases: &[(Model, Waveform)],
        go_on: &dyn Fn() -> bool,
    ) -> Option<Vec<Robustness>> {
        let mut solver = PointSolver::new(self.request);
        let mut answers = vec![Vec::with_capacity(self.members.len()); cases.len()];
        for member in self.members {
            for ((model, drive), own) in cases.iter().zip(&mut answers) {
                own.push(
                    match self.member(&mut solver, member, (model, drive), go_on) {
                        Ok(answer) => Ok(answer),
                        Err(PointFault::Hole(reason)) => Err(reason),
                        Err(PointFault::Cancelled) => return None,
                    },
                );
            }
        }
        let deviations = self.members.iter().map(|m| m.deviations.as_slice());
        let deviations: Vec<&[f64]> = deviations.collect();
        let (ids, measures) = (self.ensemble.ids(), self.measures());
        let all = answers.iter();
        Some(
            all.map(|own| summed_up(own, &deviations, &ids, &measures))
                .collect(),
        )
    }

    fn measures(&self) -> Vec<MeasureId> {
        let all = self.request.measures.iter().copied();
        all.filter(|measure| *measure != MeasureId::Regime)
            .collect()
    }

    fn member(
        &self,
        solver: &mut PointSolver<'_>,
        member: &Member,
        (model, drive): (&Model, &Waveform),
        go_on: &dyn Fn() -> bool,
    ) -> Result<MemberAnswer, PointFault> {
        let device = self.ensemble.device(model, member);
        solver.take_model(device.map_err(PointFault::Hole)?)?;
        let response = solver.solve(drive, go_on)?;
        Ok(MemberAnswer {
            regime: Regime::of(&response),
            shortfall: self.wish.shortfall(&response),
            values: solver.measure(drive, &response, &self.measures())?,
        })
    }
}
