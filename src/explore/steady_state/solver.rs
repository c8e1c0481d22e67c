//! The strategy: follow the transient, shoot where that is cheaper, accept what recurs.

use super::chaos::{CHAOTIC_EXPONENT, lyapunov_exponent};
use super::coordinates::Scale;
use super::error::SteadyError;
use super::grazing::Grazing;
use super::options::SteadyOptions;
use super::recurrence::{History, Recurrence};
use super::response::{Aperiodicity, Cycle, Method, ResponseKind, Stability, SteadyResponse};
use super::shooting::{FixedPoint, LocalMap};
use super::stroboscope::{PeriodRecord, Stroboscope};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::sim::{Integrals, MotionPhase, MotionState};

/// States this far apart, as a share of the response, are too far for shooting.
const SHOOTING_DISTANCE: f64 = 0.3;
/// Periods before the first try of shooting.
const PERIODS_BEFORE_SHOOTING: usize = 4;
/// Maps that shooting costs beside those of one Jacobian.
const MAPS_BESIDE_JACOBIAN: usize = 3;
/// Cycles in a row that must recur near grazing.
const CYCLES_NEAR_GRAZING: usize = 4;
/// Least modulus of an unstable multiplier; less may be an error of differences.
const UNSTABLE_MODULUS: f64 = 1.0 + 1e-3;

/// Where a response begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Start<'a> {
    /// The model's initial state; the drive begins at its phase 0.
    Rest,
    /// A displacement \[m\] and a velocity [m/s] of the mass, as those of the parameters `x0` and
    /// `v0`; the drive begins at a phase from 0 to below 1.
    Point {
        /// Displacement \[m\].
        displacement: f64,
        /// Velocity [m/s].
        velocity: f64,
        /// Phase of the drive at which it is switched on.
        switched_on: f64,
    },
    /// [`super::Cycle::start`] of another response, of the same device or of one like it.
    State(&'a MotionState),
}

/// Steady responses of a device, one after the other. It keeps what it has prepared for the device;
/// a clone of it serves another thread.
#[derive(Debug, Clone)]
pub struct SteadySolver {
    options: SteadyOptions,
    stroboscope: Stroboscope,
}

impl SteadySolver {
    /// For `model`.
    ///
    /// # Errors
    /// [`SteadyError`] if model or options are invalid.
    pub fn new(model: &Model, options: SteadyOptions) -> Result<Self, SteadyError> {
        options.check()?;
        let stroboscope = Stroboscope::new(model, &options.simulator, options.strobe_phase)?;
        Ok(Self {
            options,
            stroboscope,
        })
    }

    /// What is asked.
    #[must_use]
    pub fn options(&self) -> &SteadyOptions {
        &self.options
    }

    /// Another model from now on. Cheap where the structure stays the same.
    ///
    /// # Errors
    /// [`SteadyError::Simulation`] if it is invalid; nothing has changed then.
    pub fn set_model(&mut self, model: &Model) -> Result<(), SteadyError> {
        self.stroboscope.runner.replace_model(model)?;
        Ok(())
    }

    /// The steady response under `drive`.
    ///
    /// # Errors
    /// [`SteadyError`].
    pub fn solve(
        &mut self,
        drive: &Waveform,
        start: Start<'_>,
    ) -> Result<SteadyResponse, SteadyError> {
        self.solve_while(drive, start, || true)
    }

    /// [`Self::solve`] that can be cancelled: `go_on` is asked before each period of the drive.
    ///
    /// # Errors
    /// [`SteadyError`]; [`SteadyError::Cancelled`] if `go_on` says no.
    pub fn solve_while(
        &mut self,
        drive: &Waveform,
        start: Start<'_>,
        mut go_on: impl FnMut() -> bool,
    ) -> Result<SteadyResponse, SteadyError> {
        self.begin(drive, start)?;
        let period = self.stroboscope.period();
        let mut scale = Scale::new(&self.stroboscope.runner, period);
        let options = self.options.clone();
        let (most, kept) = (options.max_multiple, options.kept_periods);
        let mut history = History::new(self.stroboscope.state(), most, kept);
        let mass = self.stroboscope.runner.impact_mass();
        let (mut recurred, mut next_try) = (0, PERIODS_BEFORE_SHOOTING);
        for followed in 1..=options.max_periods {
            if !go_on() {
                return Err(SteadyError::Cancelled);
            }
            let record = self.stroboscope.advance()?;
            history.push(record, self.stroboscope.state(), &mut scale, mass);
            let found = history.found(options.recurrence);
            if let Some(found) = found.filter(|found| self.lasts(&history, *found)) {
                recurred += 1;
                let records = history.last(found.multiple);
                let grazing = self.grazing(&records);
                if !grazing.is_near() || recurred >= CYCLES_NEAR_GRAZING * found.multiple {
                    let end = history.latest().clone();
                    let point = FixedPoint {
                        start: end.clone(),
                        residual: found.distance,
                        records,
                        end,
                    };
                    return self.periodic(point, &scale, Method::Transient, followed);
                }
                continue;
            }
            recurred = 0;
            if followed >= next_try && options.shooting {
                if let Some(point) = self.shoot(&history, &scale)? {
                    return self.periodic(point, &scale, Method::Shooting, followed);
                }
                if self.stroboscope.state() != *history.latest() {
                    self.stroboscope.restore(history.latest())?;
                    next_try = 2 * followed;
                }
            }
        }
        self.not_periodic(&history, &scale)
    }

    /// Puts drive and start in place, and goes on to the first strobe.
    fn begin(&mut self, drive: &Waveform, start: Start<'_>) -> Result<(), SteadyError> {
        match start {
            Start::Rest => self.stroboscope.begin(drive, 0.0, None)?,
            Start::Point {
                displacement,
                velocity,
                switched_on,
            } => {
                if !(0.0..1.0).contains(&switched_on) {
                    let fault =
                        format!("the phase of switching on, {switched_on}, is not in 0 .. 1");
                    return Err(SteadyError::Start(fault));
                }
                let ground = self.stroboscope.runner.ground_level(0.0);
                if !(displacement.is_finite() && velocity.is_finite() && displacement > ground) {
                    return Err(SteadyError::Start(format!(
                        "a displacement of {displacement} m with {velocity} m/s is not above the ground at {ground} m"
                    )));
                }
                let initial = Some((displacement, velocity));
                self.stroboscope.begin(drive, switched_on, initial)?;
            }
            Start::State(state) => {
                self.stroboscope.begin(drive, 0.0, None)?;
                return self.stroboscope.begin_from(state);
            }
        }
        self.stroboscope.advance().map(|_| ())
    }

    /// Whether what recurs can go on: a contact without end does if it holds no less later.
    fn lasts(&self, history: &History, found: Recurrence) -> bool {
        let state = history.latest();
        let MotionPhase::Held { since, .. } = state.phase else {
            return true;
        };
        let one_contact = state.time - since > found.multiple as f64 * self.stroboscope.period();
        let runner = &self.stroboscope.runner;
        let age = state.time - since;
        let now = runner.release_threshold(age);
        let horizon = age + self.options.max_periods as f64 * self.stroboscope.period();
        !one_contact || runner.release_threshold(horizon) >= now
    }

    fn grazing(&self, records: &[PeriodRecord]) -> Grazing {
        match self.stroboscope.cycle(records) {
            Some(cycle) => Grazing::of(
                &cycle.arrivals,
                &cycle.turns,
                cycle.ground_level,
                cycle.highest,
            ),
            None => Grazing::of(&[], &[], f64::NEG_INFINITY, 0.0),
        }
    }

    /// The fixed point near the latest state, if it is cheaper to compute than to wait for.
    fn shoot(
        &mut self,
        history: &History,
        scale: &Scale,
    ) -> Result<Option<FixedPoint>, SteadyError> {
        let Some(near) = history.closest().filter(|r| r.distance < SHOOTING_DISTANCE) else {
            return Ok(None);
        };
        let multiple = near.multiple;
        let Some(dimension) = scale.pack(history.latest(), true).map(|x| x.len()) else {
            return Ok(None);
        };
        let cost = multiple * (dimension + MAPS_BESIDE_JACOBIAN);
        let waiting = near.periods_left(self.options.recurrence);
        // Without a pace the transient does not end by itself.
        let is_cheaper = waiting.is_nan() || waiting > cost as f64;
        if !is_cheaper || !history.repeats_events(multiple) {
            return Ok(None);
        }
        if self.grazing(&history.last(multiple)).is_near() {
            return Ok(None);
        }
        let mut map = LocalMap {
            stroboscope: &mut self.stroboscope,
            scale,
            multiple,
        };
        let Some(point) = map.fixed_point(history.latest(), self.options.recurrence)? else {
            return Ok(None);
        };
        // The transient would not come to an unstable response.
        let multipliers = map.multipliers(&point.start, &point.records, &point.end)?;
        let is_stable = multipliers
            .and_then(|all| all.first().map(|m| m.norm() < UNSTABLE_MODULUS))
            .unwrap_or(false);
        if !is_stable || self.grazing(&point.records).is_near() {
            return Ok(None);
        }
        self.stroboscope.restore(&point.end)?;
        let fewer = point.of_fewest_periods(scale, self.options.recurrence);
        Ok(Some(fewer))
    }

    /// The answer for a fixed point.
    fn periodic(
        &mut self,
        point: FixedPoint,
        scale: &Scale,
        method: Method,
        periods_followed: usize,
    ) -> Result<SteadyResponse, SteadyError> {
        self.stroboscope.restore(&point.end)?;
        let grazing = self.grazing(&point.records);
        let multiple = point.records.len();
        let cycle = self.stroboscope.cycle(&point.records);
        let stability = if !self.options.multipliers {
            Stability::NotComputed
        } else if grazing.is_near() {
            Stability::NotSmooth
        } else {
            let mut map = LocalMap {
                stroboscope: &mut self.stroboscope,
                scale,
                multiple,
            };
            let start = &point.records[0].start;
            let all = map.multipliers(start, &point.records, &point.end)?;
            all.map_or(Stability::NotSmooth, Stability::Multipliers)
        };
        let kind = ResponseKind::Periodic { multiple };
        let residual = point.residual;
        self.answer(
            kind,
            cycle,
            method,
            (residual, stability, grazing),
            periods_followed,
        )
    }

    fn not_periodic(
        &mut self,
        history: &History,
        scale: &Scale,
    ) -> Result<SteadyResponse, SteadyError> {
        let records = history.last(self.options.kept_periods.max(1));
        let cycle = self.stroboscope.cycle(&records);
        let grazing = self.grazing(&records);
        let residual = history.closest().map_or(f64::INFINITY, |r| r.distance);
        let periods = self.options.chaos_periods;
        let exponent = lyapunov_exponent(&mut self.stroboscope, scale, history.latest(), periods)?;
        let reason = match exponent {
            Some(exponent) if exponent > CHAOTIC_EXPONENT => Aperiodicity::Chaotic { exponent },
            exponent => Aperiodicity::Undetermined { exponent },
        };
        let kind = ResponseKind::NotPeriodic(reason);
        let stability = Stability::NotComputed;
        let followed = self.options.max_periods;
        let found = (residual, stability, grazing);
        self.answer(kind, cycle, Method::Transient, found, followed)
    }

    fn answer(
        &self,
        kind: ResponseKind,
        cycle: Option<Cycle>,
        method: Method,
        (residual, stability, grazing): (f64, Stability, Grazing),
        periods_followed: usize,
    ) -> Result<SteadyResponse, SteadyError> {
        // Each answer rests on a period at least.
        let cycle = cycle.ok_or(SteadyError::Options {
            what: "max_periods",
            reason: "no period was followed; give at least one".to_owned(),
        })?;
        Ok(SteadyResponse {
            kind,
            period: self.stroboscope.period(),
            cycle,
            method,
            residual,
            stability,
            grazing,
            device_seconds: self.stroboscope.device_seconds,
            periods_followed,
        })
    }

    /// Largest Lyapunov exponent of the response \[1/period of the drive\] over `periods`, from its
    /// cycle's start; negative where neighbours come together. `None` if no neighbour can be made.
    ///
    /// # Errors
    /// Those of the simulation.
    pub fn lyapunov_exponent(
        &mut self,
        drive: &Waveform,
        response: &SteadyResponse,
        periods: usize,
    ) -> Result<Option<f64>, SteadyError> {
        self.stroboscope.begin(drive, 0.0, None)?;
        let mut scale = Scale::new(&self.stroboscope.runner, response.period);
        scale.include(&response.cycle.start);
        let cycle = &response.cycle;
        scale.include_motion(cycle.top_speed, cycle.impact_mass, cycle.span());
        lyapunov_exponent(&mut self.stroboscope, &scale, &cycle.start, periods)
    }

    /// What forces do over the response's cycle: it is simulated once more.
    ///
    /// # Errors
    /// Those of the simulation.
    pub fn integrals(
        &mut self,
        drive: &Waveform,
        response: &SteadyResponse,
    ) -> Result<Integrals, SteadyError> {
        self.stroboscope.begin(drive, 0.0, None)?;
        self.stroboscope.integrals(&response.cycle)
    }

    /// The response's cycle as a trace of `samples` a period of the drive, times from its start.
    ///
    /// # Errors
    /// Those of the simulation.
    pub fn trace(
        &mut self,
        model: &Model,
        drive: &Waveform,
        response: &SteadyResponse,
        samples: usize,
    ) -> Result<crate::sim::Trace, SteadyError> {
        let options = crate::sim::Options {
            rate: samples as f64 / response.period,
            ..self.options.simulator
        };
        super::stroboscope::sampled(model, drive, &response.cycle, &options)
    }
}
