//! Simulates one segment from event to event with given unknowns.

use std::ops::Range;

use super::residual_rows::{Encounter, Nuisances, PullOff, SegmentContext, SegmentRun};
use crate::fit::segment::event_sequence::GroundEvent;
use crate::fit::segment::{Joint, JointKind, Segment};
use crate::fit::thresholds::{MAX_SENSOR_FADE, RELEASE_EDGE_SAMPLES};
use crate::model::drive::Segment as Piece;
use crate::recording::Recording;
use crate::sim::{Points, SimError, StretchSimulator, StretchState, Stretcher};

/// Share of a lag over which accelerations are estimated by differences.
const ACCELERATION_LAG_SHARE: f64 = 0.1;
/// Number of readings that decide where the mass lies.
const LEVEL_READINGS: usize = 16;

/// Whether the readings lag by so much that a segment begins with the sensor at its first reading.
pub fn begins_from_reading(segment: &Segment, sim: &StretchSimulator) -> bool {
    sim.reading_states()
        .is_some_and(|at| sim.state_rates()[at] * segment.interval < MAX_SENSOR_FADE)
}

fn points_of(sim: &StretchSimulator, held: Option<f64>, state: &StretchState) -> Points {
    match held {
        Some(level) => sim.held_points(level, state),
        None => sim.flight_points(state),
    }
}

/// Output of a first-order lag of `tau` \[s\] for a motion that has always been as at `start`.
/// For a harmonic motion of frequency w about a middle it is `x - (tau v - tau^2 a) / (1 +
/// w^2 tau^2)` mode by mode, with the accelerations of the next moment.
fn lagged_points(
    stretcher: &mut Stretcher<'_>,
    pieces: &[Piece],
    (held, start): (Option<f64>, f64),
    state: &StretchState,
    tau: f64,
) -> Result<Points, SimError> {
    let sim = stretcher.simulator();
    let moment = ACCELERATION_LAG_SHARE * tau;
    let mut later = state.clone();
    stretcher.propagate(
        pieces,
        held,
        start,
        start + moment,
        &mut later,
        &[],
        |_, _, _| {},
    )?;
    let omega2: Vec<f64> = match held {
        Some(_) => sim.held_omega2().collect(),
        None => sim.flight_omega2().collect(),
    };
    let mut behind = state.clone();
    for (k, w2) in omega2.into_iter().enumerate() {
        let a = (later.v[k] - state.v[k]) / moment;
        behind.q[k] -= (tau * state.v[k] - tau * tau * a) / (1.0 + w2 * tau * tau);
    }
    Ok(points_of(sim, held, &behind))
}

/// Simulates `segment` with the unknowns `locals`: initial state, then the joints' instants and
/// velocities, all in the segment's units.
///
/// # Errors
/// [`SimError`] where no simulation is possible.
pub fn simulate_segment(
    segment: &Segment,
    setting: &SegmentContext<'_>,
    stretcher: &mut Stretcher<'_>,
    nuisances: &Nuisances,
    locals: &[f64],
) -> Result<SegmentRun, SimError> {
    let sim = stretcher.simulator();
    let r = setting.recording;
    let samples = segment.samples.clone();
    // A reading that lags shows what happened before.
    let skew = nuisances.skew - sim.reading_delay();
    let start = r.time[samples.start] + skew;
    let end = r.time[samples.end - 1] + skew;
    let times: Vec<f64> = r.time[samples.clone()].iter().map(|t| t + skew).collect();
    let Joints {
        pieces,
        instants,
        priors,
    } = place_joints(segment, sim, locals, skew)?;
    let level = ground_level_at_start(segment, setting, sim, nuisances, skew);
    let state = initial_state(
        segment,
        setting,
        stretcher,
        nuisances,
        locals,
        (&pieces, start, level),
    )?;
    let held = segment.starts_held.then_some(level);
    let rest = held.map(|_| sim.rest_state(&pieces, start, held));
    let mut passage = Passage {
        setting,
        nuisances,
        first: samples.start,
        xp: vec![f64::NAN; times.len()],
        xc: vec![f64::NAN; times.len()],
        pieces,
        times,
        state,
        t: start,
        next: 0,
        level,
        held,
        since: segment.since.unwrap_or(start) + skew,
        encounters: Vec::with_capacity(instants.len()),
    };
    for &(at, v_after, kind) in &instants {
        let to = at.clamp(passage.t, end.max(passage.t));
        let upto = passage.times.partition_point(|&s| s <= to);
        passage.carry_to(stretcher, to, upto)?;
        match kind {
            GroundEvent::Bounce { .. } => passage.meet_ground(sim, Some(v_after)),
            GroundEvent::Touch => passage.meet_ground(sim, None),
            GroundEvent::Release { informative } => passage.leave_ground(sim, informative),
        }
    }
    let all = passage.times.len();
    passage.carry_to(stretcher, end, all)?;
    Ok(SegmentRun {
        xp: passage.xp,
        xc: passage.xc,
        encounters: passage.encounters,
        priors,
        rest,
    })
}

/// A segment's joints at the instants that its unknowns give them.
struct Joints {
    /// The drive with its edges moved.
    pieces: Vec<Piece>,
    /// Instant \[s\], velocity after \[m/s\] and kind of each event.
    instants: Vec<(f64, f64, GroundEvent)>,
    /// Distance of each joint from its first guess, in its standard deviations.
    priors: Vec<f64>,
}

/// Number of modes that are free where the segment begins: a held mass takes one away.
fn free_modes(segment: &Segment, sim: &StretchSimulator) -> usize {
    if segment.starts_held {
        sim.modes() - 1
    } else {
        sim.modes()
    }
}

/// Reads the joints' instants from the unknowns and keeps each within its reach.
///
/// # Errors
/// [`SimError::Options`] if the simulator has another number of modes than the segment: that is
/// another problem, not a step in this one.
fn place_joints(
    segment: &Segment,
    sim: &StretchSimulator,
    locals: &[f64],
    skew: f64,
) -> Result<Joints, SimError> {
    let value = |i: usize| segment.value(locals, i);
    let mut pieces = segment.pieces.clone();
    let modes = sim.modes();
    let n = free_modes(segment, sim);
    let own: usize = segment.joints.iter().map(Joint::unknowns).sum();
    if segment.units.len() != 2 * n + own {
        return Err(SimError::Options {
            what: "modes",
            reason: format!("{modes} of them are not those that the stretch was made for"),
        });
    }
    let mut k = 2 * n;
    let mut instants = Vec::with_capacity(segment.joints.len());
    let mut priors = Vec::with_capacity(segment.joints.len());
    for joint in &segment.joints {
        // Both kinds are shifted by the reading's clock. If edges went by the drive's clock, a
        // skew could hardly be distinguished from a shift of all edges of a recording.
        let away = match joint.what {
            JointKind::Event(_) => value(k),
            JointKind::Edge(_) => value(k) + skew,
        };
        priors.push(away / joint.sigma);
        let away = away.clamp(-joint.reach, joint.reach);
        k += 1;
        let v_after = match joint.what {
            JointKind::Event(GroundEvent::Bounce { .. }) => {
                k += 1;
                value(k - 1)
            }
            _ => 0.0,
        };
        match joint.what {
            JointKind::Edge(piece) => {
                let low = pieces[piece - 1].start;
                let high = pieces[piece].end;
                let at = (joint.time + away).clamp(low + 1e-12, (high - 1e-12).max(low + 1e-12));
                pieces[piece - 1].end = at;
                pieces[piece].start = at;
            }
            JointKind::Event(kind) => instants.push((joint.time + away + skew, v_after, kind)),
        }
    }
    Ok(Joints {
        pieces,
        instants,
        priors,
    })
}

/// State in which a segment begins: modes from its unknowns, the effects' states from the
/// context, the sensor's memory from the reading where it lasts longer than a sample.
///
/// # Errors
/// [`SimError`] if the motion just after the start cannot be simulated.
fn initial_state(
    segment: &Segment,
    setting: &SegmentContext<'_>,
    stretcher: &mut Stretcher<'_>,
    nuisances: &Nuisances,
    locals: &[f64],
    (pieces, start, level): (&[Piece], f64, f64),
) -> Result<StretchState, SimError> {
    let sim = stretcher.simulator();
    let r = setting.recording;
    let value = |i: usize| segment.value(locals, i);
    let n = free_modes(segment, sim);
    let mut state = StretchState {
        q: (0..n).map(value).collect(),
        v: (n..2 * n).map(value).collect(),
        z: if setting.states.is_empty() {
            sim.rest_state(pieces, start, None).z
        } else {
            setting.states.to_vec()
        },
    };
    if let Some(at) = sim.reading_states() {
        // A lag longer than a sample goes on from what was read. A shorter one is where the
        // motion has brought it, and must not take over the noise.
        let lasting = begins_from_reading(segment, sim);
        let on = segment.starts_held.then_some(level);
        let points = if lasting {
            points_of(sim, on, &state)
        } else {
            let tau = 1.0 / sim.state_rates()[at];
            lagged_points(stretcher, pieces, (on, start), &state, tau)?
        };
        let n = nuisances;
        let i = segment.samples.start;
        let begun = |x: f64, shown: Option<f64>, offset: f64, scale: f64| match shown {
            Some(shown) if lasting && shown.is_finite() => (shown - offset) / scale,
            _ => x,
        };
        let xc = r.cantilever.as_ref().map(|xc| xc[i]);
        state.z[at] = begun(points.xp, Some(r.proof_mass[i]), n.offset_p, n.scale_p);
        state.z[at + 1] = begun(points.xc, xc, n.offset_c, n.scale_c);
    }
    Ok(state)
}

/// A segment on its way from event to event.
struct Passage<'a> {
    setting: &'a SegmentContext<'a>,
    nuisances: &'a Nuisances,
    /// Index of the segment's first sample in the recording.
    first: usize,
    pieces: Vec<Piece>,
    /// Times of the samples, by the clock of the drive \[s\].
    times: Vec<f64>,
    xp: Vec<f64>,
    xc: Vec<f64>,
    state: StretchState,
    /// Now \[s\].
    t: f64,
    /// The next sample to be simulated.
    next: usize,
    /// Ground level \[m\].
    level: f64,
    /// Level at which the mass is held; `None` in flight.
    held: Option<f64>,
    /// When the latest contact began \[s\].
    since: f64,
    encounters: Vec<Encounter>,
}

impl Passage<'_> {
    /// Carries the motion to `to` with the samples before number `upto`. A ground that steps
    /// while the mass lies on it takes the mass along, unless the readings show otherwise.
    ///
    /// # Errors
    /// [`SimError`] where no simulation is possible.
    fn carry_to(
        &mut self,
        stretcher: &mut Stretcher<'_>,
        to: f64,
        upto: usize,
    ) -> Result<(), SimError> {
        let sim = stretcher.simulator();
        let upto = upto.max(self.next);
        let epoch = self.setting.epoch;
        if let Some(before) = self.held
            && let Some(jump) = sim.ground_jump(self.t + epoch, to + epoch)
        {
            let now = sim.ground_level(jump);
            let jump = jump - epoch;
            let middle = self.times[..upto].partition_point(|&s| s < jump);
            self.carry(stretcher, jump, middle.max(self.next))?;
            let shown = self.first + self.next..self.first + upto;
            let levels = [now, before];
            self.level = shown_level(self.setting.recording, shown, self.nuisances, levels);
            // The beam goes on moving relative to the mass.
            self.held = Some(self.level);
        }
        self.carry(stretcher, to, upto)
    }

    fn carry(
        &mut self,
        stretcher: &mut Stretcher<'_>,
        to: f64,
        upto: usize,
    ) -> Result<(), SimError> {
        let next = self.next;
        let (xp, xc) = (&mut self.xp, &mut self.xc);
        let out = |i: usize, p: f64, c: f64| {
            xp[next + i] = p;
            xc[next + i] = c;
        };
        stretcher.propagate(
            &self.pieces,
            self.held,
            self.t,
            to,
            &mut self.state,
            &self.times[next..upto],
            out,
        )?;
        self.next = upto;
        self.t = to;
        Ok(())
    }

    /// The mass meets the ground: it bounces with velocity `after`, or stays where that is `None`.
    fn meet_ground(&mut self, sim: &StretchSimulator, after: Option<f64>) {
        self.level = sim.ground_level(self.t + self.setting.epoch);
        // A mark in the wrong place may find the mass held already.
        if let Some(before) = self.held {
            sim.lift(before, &mut self.state);
        }
        let points = sim.flight_points(&self.state);
        self.encounters.push(Encounter::Meeting {
            time: self.t,
            miss: points.xp - self.level,
            speed: (-points.vp).max(0.0),
            after,
        });
        match after {
            Some(v_after) => {
                sim.kick(self.level, v_after, &mut self.state);
                self.held = None;
            }
            None => {
                sim.kick(self.level, 0.0, &mut self.state);
                sim.land(self.level, &mut self.state);
                self.held = Some(self.level);
                self.since = self.t;
            }
        }
    }

    /// The mass leaves the ground on which it lies; noted as missing if it does not lie there.
    fn leave_ground(&mut self, sim: &StretchSimulator, informative: bool) {
        if self.held.is_none() {
            self.encounters.push(Encounter::PullOff(None));
            return;
        }
        let (t, level) = (self.t, self.level);
        let interval = self.setting.recording.interval();
        self.encounters.push(Encounter::PullOff(Some(PullOff {
            time: t,
            contact: t - self.since,
            force: sim.pull_off(&self.pieces, t, level, &self.state),
            jump: pull_off_jump(sim, &self.pieces, t, level, &self.state, interval),
            informative,
        })));
        sim.lift(level, &mut self.state);
        self.held = None;
    }
}

/// Ground level where `segment` begins \[m\]. If it stepped while the mass lay on it, the mass may
/// have moved with it or stayed (a particle comes under the mass while it flies). The first
/// readings decide.
fn ground_level_at_start(
    segment: &Segment,
    setting: &SegmentContext<'_>,
    sim: &StretchSimulator,
    nuisances: &Nuisances,
    skew: f64,
) -> f64 {
    let r = setting.recording;
    let from = segment.samples.start;
    let at = |t: f64| sim.ground_level(t + skew + setting.epoch);
    let now = at(r.time[from]);
    let landed = segment.since.filter(|_| segment.starts_held).map(at);
    let Some(landed) = landed.filter(|landed| *landed != now) else {
        return now;
    };
    shown_level(r, from..segment.samples.end, nuisances, [now, landed])
}

/// Which of two ground levels the first readings of `samples` are closer to; the first if there
/// are none.
fn shown_level(
    r: &Recording,
    samples: Range<usize>,
    nuisances: &Nuisances,
    levels: [f64; 2],
) -> f64 {
    let first = samples.start..samples.end.min(samples.start + LEVEL_READINGS);
    let first = &r.proof_mass[first];
    let off = |level: f64| {
        let reading = nuisances.offset_p + nuisances.scale_p * level;
        let finite = first.iter().filter(|x| x.is_finite());
        finite.map(|x| (x - reading).abs()).sum::<f64>()
    };
    let [a, b] = levels;
    if off(b) < off(a) { b } else { a }
}

/// The largest step of the pull-off force at an edge of the drive that is so close to `t`
/// that the release may be its doing \[N\].
fn pull_off_jump(
    sim: &StretchSimulator,
    pieces: &[Piece],
    t: f64,
    level: f64,
    state: &StretchState,
    interval: f64,
) -> f64 {
    let force = |at: f64| sim.pull_off(pieces, at, level, state);
    pieces
        .iter()
        .map(|piece| piece.start)
        .filter(|start| (start - t).abs() < RELEASE_EDGE_SAMPLES * interval)
        .map(|start| (force(start + 1e-3 * interval) - force(start - 1e-3 * interval)).abs())
        .fold(0.0, f64::max)
}
