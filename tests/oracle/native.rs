//! The same system as `diffsol` is meant to be used, for speed: its own root finding and
//! dense output, one solver for each phase that is kept and only given a new state at an
//! event. This is the opponent in the benchmark; the reference is [`super::hybrid`].
//!
//! Its explicit method is the one that was found fastest here: for the 5 Hz square at an
//! error of 1e-9 m the implicit ESDIRK34 takes 80,000 steps and the explicit Tsit45
//! 21,000; BDF starts at order 1 again after every event and needs 65,000 for 1e-7 m.

use std::cell::Cell;

use diffsol::{
    NalgebraContext, NalgebraMat, NalgebraVec, NonLinearOp, OdeBuilder, OdeEquations,
    OdeSolverMethod, OdeSolverStopReason, Vector,
};

use super::device::{Device, State};
use super::flow::Tolerance;
use super::hybrid::{Outcome, event, si};
use super::voltage::{Drive, Piece};

type Mat = NalgebraMat<f64>;
type Vec64 = NalgebraVec<f64>;

/// What changes at events, seen by the right-hand sides.
struct Now {
    piece: Cell<Piece>,
    /// Start of contact [ms].
    touch: Cell<f64>,
}

/// [`super::hybrid::run`] by the fast route.
pub fn run_native(
    device: &Device,
    drive: &Drive,
    duration: f64,
    rate: f64,
    tolerance: &Tolerance,
) -> Outcome {
    let pieces = drive.pieces(duration * 1e3);
    let now = Now {
        piece: Cell::new(pieces[0]),
        touch: Cell::new(0.0),
    };
    let force = |t: f64| {
        let piece = now.piece.get();
        device.eta * piece.gain(t - piece.start).0
    };
    let held = |x: &[f64]| [x[0], -device.dp, x[1], 0.0];
    let atol = [tolerance.displacement, tolerance.velocity];
    let flight = OdeBuilder::<Mat>::new()
        .rtol(tolerance.relative)
        .atol([atol[0], atol[0], atol[1], atol[1]])
        .rhs(|x, _p, t, y| {
            let [ac, ap] = device.flight(&[x[0], x[1], x[2], x[3]], force(t));
            y.copy_from_slice(&[x[2], x[3], ac, ap]);
        })
        .root(|x, _p, _t, y| y[0] = x[1] + device.dp, 1)
        .init(|_p, _t, y| y.fill(0.0), 4)
        .build()
        .unwrap();
    let hold = OdeBuilder::<Mat>::new()
        .rtol(tolerance.relative)
        .atol(atol)
        .rhs(|x, _p, t, y| y.copy_from_slice(&[x[1], device.held(&held(x), force(t))]))
        .root(
            |x, _p, t, y| {
                let adhesion = device.ca * (t - now.touch.get()) + device.ca0;
                y[0] = adhesion - device.pull_off(&held(x), force(t));
            },
            1,
        )
        .init(|_p, _t, y| y.fill(0.0), 2)
        .build()
        .unwrap();
    let plan = Plan {
        device,
        pieces: &pieces,
        now: &now,
        count: (duration * rate * (1.0 + 1e-12)).floor() as usize,
        interval: 1e3 / rate,
    };
    plan.run(flight.tsit45().unwrap(), hold.tsit45().unwrap())
}

struct Plan<'a> {
    device: &'a Device,
    pieces: &'a [Piece],
    now: &'a Now,
    count: usize,
    /// ms.
    interval: f64,
}

impl Plan<'_> {
    fn run<'s, A, B, F, H>(&self, mut flight: F, mut hold: H) -> Outcome
    where
        A: OdeEquations<T = f64, V = Vec64, M = Mat> + 's,
        B: OdeEquations<T = f64, V = Vec64, M = Mat> + 's,
        F: OdeSolverMethod<'s, A>,
        H: OdeSolverMethod<'s, B>,
    {
        let mut out = Outcome::default();
        out.samples.reserve(self.count + 1);
        let (mut t, mut state, mut contact) = (0.0, [0.0; 4], None);
        let level = self.device.dp;
        for piece in self.pieces {
            self.now.piece.set(*piece);
            while t < piece.end {
                let released = contact.is_some_and(|touch| {
                    let force = self.device.eta * piece.gain(t - piece.start).0;
                    let adhesion = self.device.ca * (t - touch) + self.device.ca0;
                    self.device.pull_off(&state, force) > adhesion
                });
                let stopped = if released {
                    true
                } else if contact.is_some() {
                    let whole = |x: &Vec64| [x[0], -level, x[1], 0.0];
                    let part = [state[0], state[2]];
                    self.stretch(
                        &mut hold,
                        &part,
                        whole,
                        (&mut t, piece.end),
                        &mut state,
                        &mut out,
                    )
                } else {
                    let whole = |x: &Vec64| [x[0], x[1], x[2], x[3]];
                    let part = state;
                    self.stretch(
                        &mut flight,
                        &part,
                        whole,
                        (&mut t, piece.end),
                        &mut state,
                        &mut out,
                    )
                };
                if stopped {
                    let force = self.device.eta * piece.gain(t - piece.start).0;
                    event(
                        self.device,
                        &mut state,
                        &mut contact,
                        force,
                        t,
                        &mut out.events,
                    );
                    self.now.touch.set(contact.unwrap_or(0.0));
                    assert!(out.events.len() < 100_000, "too many events");
                }
            }
        }
        while out.samples.len() <= self.count {
            out.samples.push(si(&state));
        }
        out
    }

    /// Runs one solver from `t` to `end` or to its root; whether it met the root.
    fn stretch<'s, E, S>(
        &self,
        solver: &mut S,
        start: &[f64],
        whole: impl Fn(&Vec64) -> State,
        (t, end): (&mut f64, f64),
        state: &mut State,
        out: &mut Outcome,
    ) -> bool
    where
        E: OdeEquations<T = f64, V = Vec64, M = Mat> + 's,
        S: OdeSolverMethod<'s, E>,
    {
        let problem = solver.problem();
        let mut value = Vec64::zeros(start.len(), NalgebraContext::default());
        {
            let reset = solver.state_mut();
            for (i, x) in start.iter().enumerate() {
                reset.y[i] = *x;
            }
            *reset.t = *t;
            problem.eqn.rhs().call_inplace(reset.y, *t, reset.dy);
            *reset.h = f64::max(*reset.h, 1e-4);
        }
        if solver.set_stop_time(end).is_err() {
            *t = end;
            return false;
        }
        loop {
            let reason = solver.step().unwrap();
            out.steps += 1;
            let (reached, stop) = match reason {
                OdeSolverStopReason::RootFound(at, _) => (at, Some(true)),
                OdeSolverStopReason::TstopReached => (end, Some(false)),
                OdeSolverStopReason::InternalTimestep => (solver.state().t, None),
            };
            while out.samples.len() <= self.count {
                let at = out.samples.len() as f64 * self.interval;
                if at > reached {
                    break;
                }
                let inside = at.max(*t).min(solver.state().t);
                solver.interpolate_inplace(inside, &mut value).unwrap();
                out.samples.push(si(&whole(&value)));
            }
            if let Some(root) = stop {
                if root {
                    solver.state_mut_back(reached).unwrap();
                }
                *state = whole(solver.state().y);
                *t = reached;
                return root;
            }
        }
    }
}
