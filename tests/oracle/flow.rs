//! Smooth stretches, integrated by `diffsol` up to the zero of a guard.

use diffsol::{NalgebraMat, NalgebraVec, OdeBuilder, OdeSolverMethod, OdeSolverStopReason, Vector};

use super::device::State;

/// Local error per step that is asked of `diffsol`.
#[derive(Debug, Clone, Copy)]
pub struct Tolerance {
    pub relative: f64,
    /// Of displacements [um].
    pub displacement: f64,
    /// Of velocities [um/ms].
    pub velocity: f64,
}

impl Tolerance {
    /// Relative tolerance with absolute ones that match the motion's size (some um, some
    /// 10 um/ms): at 1e-12 that is 1e-16 m.
    pub fn relative(relative: f64) -> Self {
        Self {
            relative,
            displacement: 100.0 * relative,
            velocity: 1000.0 * relative,
        }
    }
}

/// A smooth system with the condition under which it holds.
pub trait System {
    /// Rate of the state `tau` ms into the piece.
    fn rate(&self, tau: f64, s: &State) -> State;
    /// Guard and its rate: the system holds while the guard is not negative.
    fn guard(&self, tau: f64, s: &State) -> (f64, f64);
}

/// Where a stretch ended.
pub struct Reached {
    pub tau: f64,
    pub state: State,
    /// Whether the guard stopped it.
    pub stopped: bool,
    pub steps: usize,
}

fn to_state(v: &NalgebraVec<f64>) -> State {
    [v[0], v[1], v[2], v[3]]
}

/// Integrates from `tau0` to `tau1` or to the guard's first zero. `samples` are times to
/// report, increasing; those within the stretch are handed to `emit`.
pub fn advance<S: System>(
    system: &S,
    start: State,
    (tau0, tau1): (f64, f64),
    tolerance: &Tolerance,
    samples: &mut std::iter::Peekable<impl Iterator<Item = f64>>,
    mut emit: impl FnMut(f64, State),
) -> Reached {
    let problem = OdeBuilder::<NalgebraMat<f64>>::new()
        .t0(tau0)
        .rtol(tolerance.relative)
        .atol([
            tolerance.displacement,
            tolerance.displacement,
            tolerance.velocity,
            tolerance.velocity,
        ])
        .rhs(|x, _p, t, y| {
            for (i, rate) in system
                .rate(t, &[x[0], x[1], x[2], x[3]])
                .into_iter()
                .enumerate()
            {
                y[i] = rate;
            }
        })
        .init(
            move |_p, _t, y| {
                for (i, value) in start.into_iter().enumerate() {
                    y[i] = value;
                }
            },
            4,
        )
        .build()
        .unwrap();
    let mut solver = problem.tsit45().unwrap();
    if solver.set_stop_time(tau1).is_err() {
        // Shorter than the solver can resolve: nothing happens in it.
        return Reached {
            tau: tau1,
            state: start,
            stopped: false,
            steps: 0,
        };
    }
    let (mut from, mut before) = (tau0, start);
    let mut steps = 0;
    let mut value = NalgebraVec::from_vec(vec![0.0; 4], *problem.context());
    loop {
        let reason = solver.step().unwrap();
        steps += 1;
        let to = solver.state().t;
        let after = to_state(solver.state().y);
        let end = violation(system, before, from, to, after, tolerance)
            .map(|beyond| zero(system, before, from, beyond, tolerance));
        let limit = end.as_ref().map_or(to, |(tau, _)| *tau);
        while let Some(tau) = samples.next_if(|&tau| tau <= limit) {
            // Samples that coincide with the start were passed by the rounding of times.
            solver
                .interpolate_inplace(tau.max(from), &mut value)
                .unwrap();
            emit(tau, to_state(&value));
        }
        if let Some((tau, state)) = end {
            return Reached {
                tau,
                state,
                stopped: true,
                steps,
            };
        }
        if matches!(reason, OdeSolverStopReason::TstopReached) {
            return Reached {
                tau: tau1,
                state: after,
                stopped: false,
                steps,
            };
        }
        (from, before) = (to, after);
    }
}

/// State at `to`, integrated anew from `(from, start)`: the interpolant is not trusted
/// for events.
fn state_at(system: &dyn System, start: State, from: f64, to: f64, tolerance: &Tolerance) -> State {
    if to <= from {
        return start;
    }
    let mut none = std::iter::empty().peekable();
    let free = Unguarded(system);
    advance(&free, start, (from, to), tolerance, &mut none, |_, _| ()).state
}

struct Unguarded<'a>(&'a dyn System);

impl System for Unguarded<'_> {
    fn rate(&self, tau: f64, s: &State) -> State {
        self.0.rate(tau, s)
    }
    fn guard(&self, _tau: f64, _s: &State) -> (f64, f64) {
        (f64::INFINITY, 0.0)
    }
}

/// A time in the step at which the guard is negative, if there is one: the step's end, or
/// the guard's minimum inside it (a touch that is over before the step is).
fn violation<S: System>(
    system: &S,
    before: State,
    from: f64,
    to: f64,
    after: State,
    tolerance: &Tolerance,
) -> Option<f64> {
    let (end, end_rate) = system.guard(to, &after);
    if end < 0.0 {
        return Some(to);
    }
    let (_, start_rate) = system.guard(from, &before);
    if !(start_rate < 0.0 && end_rate > 0.0) {
        return None;
    }
    let (mut low, mut high) = (from, to);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let (value, rate) =
            system.guard(middle, &state_at(system, before, from, middle, tolerance));
        if value < 0.0 {
            return Some(middle);
        }
        if rate < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
        if high - low < 1e-9 {
            break;
        }
    }
    None
}

/// The guard's zero in `from .. beyond`, by Newton steps kept inside a bracket.
fn zero<S: System>(
    system: &S,
    before: State,
    from: f64,
    beyond: f64,
    tolerance: &Tolerance,
) -> (f64, State) {
    let (mut low, mut high) = (from, beyond);
    let mut tau = beyond;
    let mut state = state_at(system, before, from, tau, tolerance);
    for _ in 0..100 {
        let (value, rate) = system.guard(tau, &state);
        if value < 0.0 {
            high = tau;
        } else {
            low = tau;
        }
        let newton = tau - value / rate;
        let next = if newton > low && newton < high && rate < 0.0 {
            newton
        } else {
            0.5 * (low + high)
        };
        let moved = (next - tau).abs();
        tau = next;
        state = state_at(system, before, from, tau, tolerance);
        // 1e-11 ms = 1e-14 s.
        if moved < 1e-11 || high - low < 1e-11 {
            break;
        }
    }
    (tau, state)
}
