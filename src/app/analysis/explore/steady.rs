//! The steady response under a drive, with its measures and one cycle to draw.

use std::sync::Arc;

use super::latest::Answers;
use crate::explore::measures::{MEASURES, Margin, MeasureId, Regime, measure};
use crate::explore::steady_state::{
    Start, SteadyError, SteadyOptions, SteadyResponse, SteadySolver,
};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::sim::{Options, SimError, Trace};

/// Samples of a period that are drawn.
const SAMPLES_PER_PERIOD: usize = 800;

/// A device under a drive.
#[derive(Debug, Clone, PartialEq)]
pub struct SteadyQuestion {
    /// The device.
    pub model: Arc<Model>,
    /// Its drive.
    pub drive: Waveform,
}

/// A steady response as panels show it.
#[derive(Debug, Clone)]
pub struct SteadyView {
    /// The response.
    pub response: SteadyResponse,
    /// How it taps the ground.
    pub regime: Regime,
    /// Values of all measures, in the order of [`MEASURES`].
    pub values: Vec<Option<f64>>,
    /// Distance to the next regime.
    pub margin: Margin,
    /// One cycle; times from its start \[s\].
    pub trace: Trace,
}

impl SteadyView {
    /// Value of a measure, if the response has it.
    #[must_use]
    pub fn value(&self, measure: MeasureId) -> Option<f64> {
        self.values.get(measure as usize).copied().flatten()
    }

    /// The response of a device that is switched on from rest; `solver` is that of its model.
    ///
    /// # Errors
    /// [`SteadyError`].
    pub fn compute(
        solver: &mut SteadySolver,
        (model, drive): (&Model, &Waveform),
        go_on: impl FnMut() -> bool,
    ) -> Result<Self, SteadyError> {
        let response = solver.solve_while(drive, Start::Rest, go_on)?;
        let all = MEASURES.map(|row| row.measure);
        let values = measure(solver, drive, &response, &all)?;
        let trace = solver.trace(model, drive, &response, SAMPLES_PER_PERIOD)?;
        Ok(Self {
            regime: Regime::of(&response),
            margin: Margin::of(&response),
            values,
            trace,
            response,
        })
    }
}

/// A run of `duration` \[s\] that begins in the steady response, with phase 0 of the drive at t = 0.
/// `None` if `go_on` said no.
///
/// # Errors
/// [`SimError`]; [`SimError::Options`] for a drive that has no steady response.
pub fn steady_run(
    (model, drive): (&Model, &Waveform),
    duration: f64,
    options: &Options,
    go_on: impl FnMut() -> bool,
) -> Result<Option<Trace>, SimError> {
    let steady = SteadyOptions {
        simulator: *options,
        multipliers: false,
        chaos_periods: 0,
        ..SteadyOptions::default()
    };
    let found = SteadySolver::new(model, steady).and_then(|mut solver| {
        let mut response = solver.solve_while(drive, Start::Rest, go_on)?;
        // The state at a strobe, gone on from for as long as is asked.
        response.cycle.duration = duration;
        let samples = (options.rate * response.period).round().max(1.0) as usize;
        solver.trace(model, drive, &response, samples)
    });
    match found {
        Ok(trace) => Ok(Some(trace)),
        Err(SteadyError::Cancelled) => Ok(None),
        Err(SteadyError::Simulation(error)) => Err(error),
        Err(other) => Err(SimError::Options {
            what: "steady state",
            reason: format!("{other}; or show the run from rest"),
        }),
    }
}

/// The worker behind a [`super::latest::Latest`].
#[derive(Default)]
pub struct SteadyWork {
    prepared: Option<(Arc<Model>, SteadySolver)>,
}

impl SteadyWork {
    /// The solver for `model`; what was prepared is kept where the structure is the same.
    fn solver(&mut self, model: &Arc<Model>) -> Result<&mut SteadySolver, SteadyError> {
        let solver = match self.prepared.take() {
            Some((same, solver)) if same == *model => solver,
            Some((_, mut solver)) => match solver.set_model(model) {
                Ok(()) => solver,
                // Another structure.
                Err(_) => SteadySolver::new(model, SteadyOptions::default())?,
            },
            None => SteadySolver::new(model, SteadyOptions::default())?,
        };
        let (_, solver) = self.prepared.insert((Arc::clone(model), solver));
        Ok(solver)
    }
}

impl Answers for SteadyWork {
    type Question = SteadyQuestion;
    type Answer = SteadyView;
    const NAME: &'static str = "steady response";

    fn answer(
        &mut self,
        question: &SteadyQuestion,
        go_on: &dyn Fn() -> bool,
    ) -> Result<SteadyView, String> {
        let (model, drive) = (&question.model, &question.drive);
        // Model first: a solver for the wrong one would fail less clearly.
        model.check().map_err(|error| error.to_string())?;
        let solver = self.solver(model).map_err(|error| error.to_string())?;
        SteadyView::compute(solver, (model, drive), go_on).map_err(|error| error.to_string())
    }
}
