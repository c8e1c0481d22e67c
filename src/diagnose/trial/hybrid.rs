//! Flight, impact, contact and release of a trial device, with events found as roots
//! on the solver's continuous extension.

use super::device::{Device, Ground, Phase};
use super::integrator::{MAX_STATE, State, Stepper};
use super::voltage::Piece;
use thiserror::Error;

/// Events after which a run is given up.
const MAX_EVENTS: usize = 200_000;
/// Steps after which a run is given up.
const MAX_STEPS: u64 = 20_000_000;
/// First step after a discontinuity \[s\].
const FIRST_STEP: f64 = 1e-7;
/// Longest step \[s\].
const LONGEST_STEP: f64 = 2e-5;
/// Longest stretch that is noted as one \[s\].
const LONGEST_STRETCH: f64 = 3e-3;
/// Shortest step \[s\].
const SHORTEST_STEP: f64 = 1e-13;

/// Why a trial device could not be run.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RunError {
    /// The motion cannot be followed.
    #[error("the trial device cannot be followed beyond t = {time:.6} s; draw another seed")]
    Stalled {
        /// When \[s\].
        time: f64,
    },
    /// Too many events or steps.
    #[error("the trial device chatters at t = {time:.6} s; draw another seed")]
    TooMuchWork {
        /// When \[s\].
        time: f64,
    },
}

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A bounce.
    Impact,
    /// A touch that held.
    Stick,
    /// A release.
    Release,
}

/// One event at the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// When \[s\].
    pub time: f64,
    /// What.
    pub kind: Kind,
    /// Velocity of the mass before \[m/s\].
    pub before: f64,
    /// And after.
    pub after: f64,
    /// Level of the ground \[m\].
    pub level: f64,
    /// Force with which the structure alone pulls the mass off \[N\].
    pub pull: f64,
    /// Contact that ends here \[s\].
    pub contact: f64,
    /// Whether a step of the drive tore the mass off, with more than adhesion holds.
    pub torn: bool,
}

/// A stretch without ground events, from a known state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// From \[s\].
    pub start: f64,
    /// To \[s\].
    pub end: f64,
    /// What the mass is doing.
    pub phase: Phase,
    /// State at `start`.
    pub state: State,
}

/// A run, sampled.
#[derive(Debug, Clone, Default)]
pub struct Run {
    /// What the sensor at the mass shows at each asked time \[m\].
    pub proof_mass: Vec<f64>,
    /// What the sensor at the cantilever shows \[m\].
    pub cantilever: Vec<f64>,
    /// Events at the ground, in order.
    pub events: Vec<Event>,
    /// Stretches between them, in order.
    pub stretches: Vec<Stretch>,
    /// Steps taken.
    pub steps: u64,
    /// Coordinates of the device: the velocities of a state stand behind as many.
    pub coordinates: usize,
}

/// The device on its way.
struct Traveller<'a> {
    device: &'a Device,
    times: &'a [f64],
    t: f64,
    y: State,
    phase: Phase,
    run: Run,
    stretch: (f64, State, Phase),
}

/// Cuts pieces where the ground steps.
fn with_ground_step(pieces: &[Piece], at: f64) -> Vec<Piece> {
    let mut out = Vec::with_capacity(pieces.len() + 1);
    for piece in pieces {
        if at > piece.start && at < piece.end {
            let (mut a, mut b) = (piece.clone(), piece.clone());
            a.end = at;
            b.start = at;
            out.extend([a, b]);
        } else {
            out.push(piece.clone());
        }
    }
    out
}

/// Runs from rest at zero over `[0, end]` \[s\], read at `times` (not falling; those
/// before zero show the rest state).
///
/// # Errors
/// [`RunError`] if the motion diverges or chatters.
pub fn run(
    device: &Device,
    pieces: &[Piece],
    end: f64,
    times: &[f64],
    tolerance: f64,
) -> Result<Run, RunError> {
    let y = [0.0; MAX_STATE];
    let phase = Phase::Flight { direction: 0.0 };
    let mut traveller = Traveller {
        device,
        times,
        t: 0.0,
        y,
        phase,
        run: Run {
            coordinates: device.structure.n,
            ..Run::default()
        },
        stretch: (0.0, y, phase),
    };
    let early = times.partition_point(|t| *t < 0.0);
    traveller.run.proof_mass.resize(early, 0.0);
    traveller.run.cantilever.resize(early, 0.0);
    let pieces = with_ground_step(pieces, device.rise_time);
    for (i, piece) in pieces.iter().enumerate() {
        if piece.start >= end {
            break;
        }
        if i == 0 {
            traveller.fly(piece);
        }
        traveller.travel(piece, piece.end.min(end), &device.tolerances(tolerance))?;
    }
    traveller.close_stretch();
    // Rounding may leave the last times beyond the end.
    let [xp, xc] = {
        let (p, c) = device.readings(&traveller.y);
        [p, c]
    };
    traveller.run.proof_mass.resize(times.len(), xp);
    traveller.run.cantilever.resize(times.len(), xc);
    Ok(traveller.run)
}

impl Traveller<'_> {
    fn close_stretch(&mut self) {
        let (start, state, phase) = self.stretch;
        if self.t > start {
            self.run.stretches.push(Stretch {
                start,
                end: self.t,
                phase,
                state,
            });
        }
        self.stretch = (self.t, self.y, self.phase);
    }

    /// Into the air: chooses the direction of dry friction, or jams.
    fn fly(&mut self, piece: &Piece) {
        self.phase = Phase::Flight { direction: 0.0 };
        if self.device.friction == 0.0 {
            return;
        }
        let velocity = self.device.points(&self.y)[1];
        if velocity.abs() > 1e-9 {
            self.phase = Phase::Flight {
                direction: velocity.signum(),
            };
            return;
        }
        let (hold, _) = self.device.hold(self.t, &self.y, piece, self.phase);
        if hold.abs() <= self.device.friction {
            self.device.kick(&mut self.y, -velocity);
            self.phase = Phase::Jammed;
        } else {
            // It starts to move the way it is pulled.
            self.phase = Phase::Flight {
                direction: -hold.signum(),
            };
        }
    }

    /// Below zero once the phase ends.
    fn guard(&self, t: f64, y: &State, piece: &Piece) -> [f64; 2] {
        let device = self.device;
        match self.phase {
            Phase::Flight { direction } => {
                let [xp, vp, ..] = device.points(y);
                let turn = if device.friction > 0.0 && direction != 0.0 {
                    vp * direction
                } else {
                    1.0
                };
                [xp - device.level(t), turn]
            }
            Phase::Jammed => {
                let (hold, _) = device.hold(t, y, piece, self.phase);
                [device.friction - hold.abs(), 1.0]
            }
            Phase::Held { since } => {
                let (hold, _) = device.hold(t, y, piece, self.phase);
                // The ground pulls with `hold` below zero as the structure pulls up.
                [device.adhesion(t - since) + hold, 1.0]
            }
            Phase::Touching { since } => [device.bond(t, y, since), 1.0],
        }
    }

    /// What follows when guard number `which` fell below zero.
    fn switch(&mut self, which: usize, piece: &Piece, torn: bool) {
        let device = self.device;
        let [xp, vp, ..] = device.points(&self.y);
        let level = device.level(self.t);
        match self.phase {
            Phase::Flight { .. } if which == 0 => self.touch(piece, xp, vp, level),
            Phase::Flight { .. } => {
                device.kick(&mut self.y, -vp);
                self.fly(piece);
            }
            Phase::Jammed => self.fly(piece),
            Phase::Held { since } | Phase::Touching { since } => {
                let (hold, load) = device.hold(self.t, &self.y, piece, self.phase);
                self.run.events.push(Event {
                    time: self.t,
                    kind: Kind::Release,
                    before: vp,
                    after: vp,
                    level,
                    pull: -hold - load,
                    contact: self.t - since,
                    torn,
                });
                self.close_stretch();
                self.fly(piece);
                if device.friction > 0.0 {
                    self.phase = Phase::Flight { direction: 1.0 };
                }
                self.stretch = (self.t, self.y, self.phase);
            }
        }
    }

    /// The mass has met the ground.
    fn touch(&mut self, piece: &Piece, xp: f64, vp: f64, level: f64) {
        let device = self.device;
        let since = self.t;
        self.close_stretch();
        if device.ground != Ground::Rigid {
            self.phase = Phase::Touching { since };
            self.stretch = (self.t, self.y, self.phase);
            return;
        }
        device.shift(&mut self.y, level - xp);
        let down = vp.min(0.0);
        let after = -device.restitution(down) * down;
        device.kick(&mut self.y, after - vp);
        let held = Phase::Held { since };
        let (hold, load) = device.hold(self.t, &self.y, piece, held);
        let bounces = -hold > device.adhesion(0.0).max(0.0);
        let mut event = Event {
            time: self.t,
            kind: Kind::Impact,
            before: vp,
            after,
            level,
            pull: -hold - load,
            contact: 0.0,
            torn: false,
        };
        if bounces {
            self.fly(piece);
            if device.friction > 0.0 {
                self.phase = Phase::Flight { direction: 1.0 };
            }
        } else {
            device.kick(&mut self.y, -after);
            self.phase = held;
            event.kind = Kind::Stick;
            event.after = 0.0;
        }
        self.run.events.push(event);
        self.stretch = (self.t, self.y, self.phase);
    }

    fn sample(&mut self, stepper: &Stepper, from: f64, h: f64, until: f64) {
        while let Some(time) = self.times.get(self.run.proof_mass.len()) {
            if *time > until {
                break;
            }
            let y = stepper.at(((time - from) / h).clamp(0.0, 1.0));
            let (xp, xc) = self.device.readings(&y);
            self.run.proof_mass.push(xp);
            self.run.cantilever.push(xc);
        }
    }

    /// Goes on to `end` within one piece of the drive.
    fn travel(&mut self, piece: &Piece, end: f64, tolerance: &State) -> Result<(), RunError> {
        let device = self.device;
        // The ground may have stepped, or the drive with it.
        let level = device.level(self.t);
        let [xp, vp, ..] = device.points(&self.y);
        if matches!(self.phase, Phase::Held { .. }) || (xp < level && self.phase == Phase::Jammed) {
            device.shift(&mut self.y, level - xp);
        } else if matches!(self.phase, Phase::Flight { .. })
            && xp < level
            && device.ground == Ground::Rigid
        {
            device.shift(&mut self.y, level - xp);
            device.kick(&mut self.y, vp.max(0.0) - vp);
        }
        if !matches!(self.phase, Phase::Flight { .. })
            && self.guard(self.t, &self.y, piece)[0] < 0.0
        {
            self.switch(0, piece, true);
        }
        let mut stepper = Stepper::new(device.dimension());
        let mut h = FIRST_STEP;
        let mut fresh = true;
        while end - self.t > 1e-15 {
            self.run.steps += 1;
            if self.run.steps > MAX_STEPS || self.run.events.len() > MAX_EVENTS {
                return Err(RunError::TooMuchWork { time: self.t });
            }
            let phase = self.phase;
            let mut rhs = |t: f64, y: &State, out: &mut State| device.flow(t, y, piece, phase, out);
            if fresh {
                stepper.restart(self.t, &self.y, &mut rhs);
                fresh = false;
            }
            let left = end - self.t;
            let last = h >= left;
            let step = if last { left } else { h };
            let error = stepper.attempt(self.t, &self.y, step, tolerance, &mut rhs);
            // A NaN counts as too large.
            if !(error <= 1.0) {
                let factor = if error.is_finite() {
                    (0.9 * error.powf(-0.2)).clamp(0.1, 0.9)
                } else {
                    0.1
                };
                h = step * factor;
                if h < SHORTEST_STEP {
                    return Err(RunError::Stalled { time: self.t });
                }
                continue;
            }
            stepper.prepare(&self.y, step);
            let from = self.t;
            if let Some((share, which)) = self.first_event(&stepper, from, step, piece) {
                let at = from + share * step;
                self.sample(&stepper, from, step, at);
                self.y = stepper.at(share);
                self.t = at;
                self.switch(which, piece, false);
                fresh = true;
                h = FIRST_STEP;
                continue;
            }
            let to = if last { end } else { from + step };
            self.sample(&stepper, from, step, to);
            self.y = stepper.end;
            self.t = to;
            if to - self.stretch.0 > LONGEST_STRETCH {
                self.close_stretch();
            }
            if matches!(self.phase, Phase::Held { .. } | Phase::Jammed) {
                // Rounding must not let the held mass creep.
                let drift = device.points(&self.y)[1];
                device.kick(&mut self.y, -drift);
            }
            stepper.go_on();
            h = (step * (0.9 * error.max(1e-10).powf(-0.2)).clamp(0.3, 4.0)).min(LONGEST_STEP);
            if last {
                h = h.max(FIRST_STEP);
            }
        }
        self.t = end;
        Ok(())
    }

    /// The first root of a guard within the prepared step.
    fn first_event(
        &self,
        stepper: &Stepper,
        from: f64,
        step: f64,
        piece: &Piece,
    ) -> Option<(f64, usize)> {
        let value = |s: f64| self.guard(from + s * step, &stepper.at(s), piece);
        let mut low = 0.0;
        for high in [0.25, 0.5, 0.75, 1.0] {
            let g = value(high);
            if g[0] < 0.0 || g[1] < 0.0 {
                let mut best: Option<(f64, usize)> = None;
                for which in 0..2 {
                    if g[which] >= 0.0 {
                        continue;
                    }
                    let (mut a, mut b) = (low, high);
                    while (b - a) * step > 1e-14 && b - a > 1e-13 {
                        let middle = 0.5 * (a + b);
                        if value(middle)[which] < 0.0 {
                            b = middle;
                        } else {
                            a = middle;
                        }
                    }
                    if best.is_none_or(|(s, _)| b < s) {
                        best = Some((b, which));
                    }
                }
                return best;
            }
            low = high;
        }
        None
    }
}

/// The motion from `stretch`'s state with the phase kept, read at `times` within it.
/// Returns the proof mass's and the cantilever's readings.
///
/// # Errors
/// [`RunError`] if the motion diverges.
pub fn follow(
    device: &Device,
    pieces: &[Piece],
    stretch: &Stretch,
    times: &[f64],
    tolerance: f64,
) -> Result<[Vec<f64>; 2], RunError> {
    let tolerances = device.tolerances(tolerance);
    let mut out = [
        Vec::with_capacity(times.len()),
        Vec::with_capacity(times.len()),
    ];
    let (mut t, mut y) = (stretch.start, stretch.state);
    let mut h = 1e-6;
    let mut stepper = Stepper::new(device.dimension());
    let first = pieces.partition_point(|piece| piece.end <= t);
    for piece in &pieces[first.min(pieces.len())..] {
        let end = piece.end.min(stretch.end);
        let mut rhs =
            |t: f64, y: &State, out: &mut State| device.flow(t, y, piece, stretch.phase, out);
        stepper.restart(t, &y, &mut rhs);
        while end - t > 1e-15 {
            let last = h >= end - t;
            let step = if last { end - t } else { h };
            let error = stepper.attempt(t, &y, step, &tolerances, &mut rhs);
            if !(error <= 1.0) {
                h = 0.3 * step;
                if h < SHORTEST_STEP {
                    return Err(RunError::Stalled { time: t });
                }
                continue;
            }
            stepper.prepare(&y, step);
            let to = if last { end } else { t + step };
            while let Some(time) = times.get(out[0].len()).filter(|time| **time <= to) {
                let (xp, xc) = device.readings(&stepper.at(((time - t) / step).clamp(0.0, 1.0)));
                out[0].push(xp);
                out[1].push(xc);
            }
            y = stepper.end;
            t = to;
            stepper.go_on();
            h = (step * (0.9 * error.max(1e-10).powf(-0.2)).clamp(0.3, 4.0))
                .clamp(1e-8, LONGEST_STEP);
        }
        if piece.end >= stretch.end {
            break;
        }
    }
    let (xp, xc) = device.readings(&y);
    out[0].resize(times.len(), xp);
    out[1].resize(times.len(), xc);
    Ok(out)
}
