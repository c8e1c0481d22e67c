//! The hybrid system: flight with the film, impact, bounce or stick, hold, release.

use super::device::{Device, State};
use super::flow::{System, advance};
use super::voltage::{Drive, Piece};

pub use super::flow::Tolerance;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Impact,
    Stick,
    Release,
}

/// One event, SI.
#[derive(Debug, Clone, Copy)]
pub struct Event {
    pub time: f64,
    pub kind: Kind,
    pub velocity_before: f64,
    pub velocity_after: f64,
    /// After the hypothesised bounce at an impact or stick, at break-off at a release.
    pub pull_off: f64,
    /// At a release.
    pub contact: f64,
    /// Pull-off force minus the adhesion it had to beat, for judging how close a decision
    /// was [N].
    pub margin: f64,
}

/// A run, SI.
#[derive(Debug, Clone, Default)]
pub struct Outcome {
    pub events: Vec<Event>,
    /// `[xc, xp, xc', xp']` at `i / rate`.
    pub samples: Vec<State>,
    pub steps: usize,
}

struct Flight<'a> {
    device: &'a Device,
    piece: Piece,
}

impl System for Flight<'_> {
    fn rate(&self, tau: f64, s: &State) -> State {
        let [ac, ap] = self
            .device
            .flight(s, self.device.eta * self.piece.gain(tau).0);
        [s[2], s[3], ac, ap]
    }
    fn guard(&self, _tau: f64, s: &State) -> (f64, f64) {
        (s[1] + self.device.dp, s[3])
    }
}

struct Hold<'a> {
    device: &'a Device,
    piece: Piece,
    /// Start of contact, ms into the piece; negative if it began in an earlier one.
    since: f64,
}

impl System for Hold<'_> {
    fn rate(&self, tau: f64, s: &State) -> State {
        let acceleration = self
            .device
            .held(s, self.device.eta * self.piece.gain(tau).0);
        [s[2], 0.0, acceleration, 0.0]
    }
    fn guard(&self, tau: f64, s: &State) -> (f64, f64) {
        let device = self.device;
        let (gain, gain_rate) = self.piece.gain(tau);
        let (force, rate) = (device.eta * gain, device.eta * gain_rate);
        let adhesion = device.ca * (tau - self.since) + device.ca0;
        (
            adhesion - device.pull_off(s, force),
            device.ca - device.pull_off_rate(s, force, rate),
        )
    }
}

const UM: f64 = 1e-6;
const UM_PER_MS: f64 = 1e-3;
const MS: f64 = 1e-3;
const MICRONEWTON: f64 = 1e-6;

/// From um and ms.
pub fn si(s: &State) -> State {
    [s[0] * UM, s[1] * UM, s[2] * UM_PER_MS, s[3] * UM_PER_MS]
}

/// Runs `duration` [s] from rest at the zero position, sampled at `rate` [Hz].
pub fn run(
    device: &Device,
    drive: &Drive,
    duration: f64,
    rate: f64,
    tolerance: &Tolerance,
) -> Outcome {
    run_from(device, drive, [0.0; 4], duration, rate, tolerance)
}

/// [`run`] from another state [um, um/ms].
pub fn run_from(
    device: &Device,
    drive: &Drive,
    mut state: State,
    duration: f64,
    rate: f64,
    tolerance: &Tolerance,
) -> Outcome {
    let mut out = Outcome::default();
    let end = duration / MS;
    let count = (duration * rate * (1.0 + 1e-12)).floor() as usize;
    // Time of the first touch of the present contact [ms].
    let mut contact: Option<f64> = None;
    for piece in drive.pieces(end) {
        let length = piece.end - piece.start;
        let mut tau = 0.0;
        while tau < length {
            let first = out.samples.len();
            // A sample on a boundary belongs to the piece that ends there: positions and
            // velocities are continuous across steps of the drive.
            let mut times = (first..=count)
                .map(|i| i as f64 / rate / MS - piece.start)
                .peekable();
            let emit = |_: f64, s: State| out.samples.push(si(&s));
            let reached = if let Some(touch) = contact {
                let hold = Hold {
                    device,
                    piece,
                    since: touch - piece.start,
                };
                // A step of the drive can tear the mass off at once.
                if hold.guard(tau, &state).0 < 0.0 {
                    super::flow::Reached {
                        tau,
                        state,
                        stopped: true,
                        steps: 0,
                    }
                } else {
                    advance(&hold, state, (tau, length), tolerance, &mut times, emit)
                }
            } else {
                let flight = Flight { device, piece };
                advance(&flight, state, (tau, length), tolerance, &mut times, emit)
            };
            (tau, state) = (reached.tau, reached.state);
            out.steps += reached.steps;
            if reached.stopped {
                let force = device.eta * piece.gain(tau).0;
                let now = piece.start + tau;
                event(
                    device,
                    &mut state,
                    &mut contact,
                    force,
                    now,
                    &mut out.events,
                );
                assert!(out.events.len() < 100_000, "too many events");
            }
        }
    }
    // The sample at the very end, if rounding has left it out.
    while out.samples.len() <= count {
        out.samples.push(si(&state));
    }
    out
}

/// What happens where a guard is zero: eqs (11)-(14).
pub fn event(
    device: &Device,
    state: &mut State,
    contact: &mut Option<f64>,
    force: f64,
    now: f64,
    events: &mut Vec<Event>,
) {
    let before = state[3];
    let (kind, pull_off, adhesion, duration);
    if let Some(touch) = *contact {
        kind = Kind::Release;
        duration = now - touch;
        pull_off = device.pull_off(state, force);
        adhesion = device.ca * duration + device.ca0;
        *contact = None;
    } else {
        state[1] = -device.dp;
        let bounced = device.impulse(state, -device.alpha * before);
        pull_off = device.pull_off(&bounced, force);
        adhesion = device.ca0.max(0.0);
        duration = 0.0;
        if pull_off > adhesion {
            kind = Kind::Impact;
            *state = bounced;
        } else {
            kind = Kind::Stick;
            *state = device.impulse(state, 0.0);
            *contact = Some(now);
        }
    }
    events.push(Event {
        time: now * MS,
        kind,
        velocity_before: before * UM_PER_MS,
        velocity_after: state[3] * UM_PER_MS,
        pull_off: pull_off * MICRONEWTON,
        contact: duration * MS,
        margin: (pull_off - adhesion) * MICRONEWTON,
    });
}
