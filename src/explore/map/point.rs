//! One point: its device, its drive, its steady response.

use super::axis::AxisOf;
use super::request::{MapRequest, MapStart};
use crate::explore::measures::{self, MeasureId};
use crate::explore::steady_state::{Start, SteadyError, SteadyResponse, SteadySolver};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::model::unit::format_quantity;
use crate::sim::MotionState;

/// Why a point has no values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PointFault {
    /// It is impossible; the reason.
    Hole(String),
    /// The caller ended it.
    Cancelled,
}

/// Solves points one after the other. What it keeps between them saves time and changes no bit.
#[derive(Debug, Clone)]
pub struct PointSolver<'a> {
    request: &'a MapRequest,
    /// The model in the solver.
    model: Option<Model>,
    solver: Option<SteadySolver>,
}

impl<'a> PointSolver<'a> {
    /// For the points of a request.
    #[must_use]
    pub fn new(request: &'a MapRequest) -> Self {
        Self {
            request,
            model: None,
            solver: None,
        }
    }

    /// The steady response of a point, with its drive.
    ///
    /// # Errors
    /// [`PointFault`].
    pub fn response(
        &mut self,
        index: usize,
        go_on: impl FnMut() -> bool,
    ) -> Result<(SteadyResponse, Waveform), PointFault> {
        let values = self.request.values_at(index);
        let drive = self.request.drive_at(&values).map_err(PointFault::Hole)?;
        let of_model = self.request.axes.iter().any(|a| a.of == AxisOf::Model);
        if of_model || self.model.is_none() {
            let (model, _) = self.request.setting(index).map_err(PointFault::Hole)?;
            self.take_model(model)?;
        }
        let response = self.solve(&drive, go_on)?;
        Ok((response, drive))
    }

    /// Puts a model in place for [`Self::solve`].
    ///
    /// # Errors
    /// [`PointFault::Hole`] if it is impossible.
    pub fn take_model(&mut self, model: Model) -> Result<(), PointFault> {
        if self.model.as_ref() == Some(&model) {
            return Ok(());
        }
        self.model = None;
        let made = match &mut self.solver {
            Some(solver) => solver.set_model(&model),
            None => SteadySolver::new(&model, self.request.options.clone())
                .map(|solver| self.solver = Some(solver)),
        };
        made.map_err(fault)?;
        self.model = Some(model);
        Ok(())
    }

    /// The steady response of the model in place, from the request's start, within its bound of
    /// device time.
    ///
    /// # Errors
    /// [`PointFault`].
    pub fn solve(
        &mut self,
        drive: &Waveform,
        go_on: impl FnMut() -> bool,
    ) -> Result<SteadyResponse, PointFault> {
        self.solve_with(drive, self.request.start, go_on)
    }

    /// [`Self::solve`] from another start.
    ///
    /// # Errors
    /// [`PointFault`].
    pub fn solve_with(
        &mut self,
        drive: &Waveform,
        start: MapStart,
        go_on: impl FnMut() -> bool,
    ) -> Result<SteadyResponse, PointFault> {
        let start = match start {
            MapStart::Rest => Start::Rest,
            MapStart::Point {
                displacement,
                velocity,
                switched_on,
            } => Start::Point {
                displacement,
                velocity,
                switched_on,
            },
        };
        self.follow(drive, start, go_on)
    }

    /// [`Self::solve`] from a state at the strobe of another response.
    ///
    /// # Errors
    /// [`PointFault`].
    pub fn solve_from(
        &mut self,
        drive: &Waveform,
        state: &MotionState,
        go_on: impl FnMut() -> bool,
    ) -> Result<SteadyResponse, PointFault> {
        self.follow(drive, Start::State(state), go_on)
    }

    fn follow(
        &mut self,
        drive: &Waveform,
        start: Start<'_>,
        mut go_on: impl FnMut() -> bool,
    ) -> Result<SteadyResponse, PointFault> {
        let Some(solver) = self.solver.as_mut().filter(|_| self.model.is_some()) else {
            return Err(PointFault::Hole("there is no device".to_owned()));
        };
        let bound = self.request.point_device_seconds;
        let period = drive.period().unwrap_or(0.0);
        let time = |seconds| format_quantity(seconds, "s", 3);
        if period > bound {
            return Err(PointFault::Hole(format!(
                "one period of {} is longer than the {} for which a point is followed",
                time(period),
                time(bound)
            )));
        }
        let (mut periods, mut is_over, mut is_cancelled) = (0u32, false, false);
        let found = solver.solve_while(drive, start, || {
            periods += 1;
            is_cancelled = !go_on();
            is_over = f64::from(periods) * period > bound;
            !(is_cancelled || is_over)
        });
        match found {
            Err(SteadyError::Cancelled) if is_over && !is_cancelled => {
                Err(PointFault::Hole(format!(
                    "no steady state within {} of device time, {periods} periods of the drive",
                    time(bound)
                )))
            }
            other => other.map_err(fault),
        }
    }

    /// Largest Lyapunov exponent \[1/period\] of a response that was just solved.
    ///
    /// # Errors
    /// [`PointFault`].
    pub fn lyapunov_exponent(
        &mut self,
        drive: &Waveform,
        response: &SteadyResponse,
        periods: usize,
    ) -> Result<Option<f64>, PointFault> {
        let Some(solver) = &mut self.solver else {
            return Err(PointFault::Hole("there is no device".to_owned()));
        };
        let found = solver.lyapunov_exponent(drive, response, periods);
        found.map_err(fault)
    }

    /// Values of measures for a response that was just solved, NaN where it has none.
    ///
    /// # Errors
    /// [`PointFault`].
    pub fn measure(
        &mut self,
        drive: &Waveform,
        response: &SteadyResponse,
        measures: &[MeasureId],
    ) -> Result<Vec<f64>, PointFault> {
        let Some(solver) = &mut self.solver else {
            return Err(PointFault::Hole("there is no device".to_owned()));
        };
        let values = measures::measure(solver, drive, response, measures).map_err(fault)?;
        Ok(values.into_iter().map(|v| v.unwrap_or(f64::NAN)).collect())
    }
}

fn fault(error: SteadyError) -> PointFault {
    match error {
        SteadyError::Cancelled => PointFault::Cancelled,
        other => PointFault::Hole(other.to_string()),
    }
}
