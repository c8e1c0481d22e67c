//! Simulates one segment from event to event with given unknowns.

use std::ops::Range;

use super::residual_rows::{Encounter, Nuisances, PullOff, SegmentContext, SegmentRun};
use super::segment_joints::{Joints, place_joints};
use super::segment_start::initial_state;
use crate::fit::segment::Segment;
use crate::fit::segment::event_sequence::GroundEvent;
use crate::fit::thresholds::RELEASE_EDGE_SAMPLES;
use crate::model::drive::Segment as Piece;
use crate::recording::Recording;
use crate::sim::{SimError, StretchSimulator, StretchState, Stretcher};

/// Number of readings that decide where the mass lies.
const LEVEL_READINGS: usize = 16;

/// Simulates `segment` with the unknowns `locals`: initial state, then the joints' instants and
/// velocities, all in the segment's units.
///
/// # Errors
/// [`SimError`] where no simulation is possible.
pub fn simulate_segment(
    segment: &Segment,
    context: &SegmentContext<'_>,
    stretcher: &mut Stretcher<'_>,
    nuisances: &Nuisances,
    locals: &[f64],
) -> Result<SegmentRun, SimError> {
    let sim = stretcher.simulator();
    let r = context.recording;
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
    let level = ground_level_at_start(segment, context, sim, nuisances, skew);
    let state = initial_state(
        segment,
        context,
        stretcher,
        nuisances,
        locals,
        (&pieces, start, level),
    )?;
    let held = segment.starts_held.then_some(level);
    let rest = held.map(|_| sim.rest_state(&pieces, start, held));
    let mut passage = Passage {
        context,
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

/// A segment on its way from event to event.
struct Passage<'a> {
    context: &'a SegmentContext<'a>,
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
        let epoch = self.context.epoch;
        if let Some(before) = self.held
            && let Some(jump) = sim.ground_jump(self.t + epoch, to + epoch)
        {
            let now = sim.ground_level(jump);
            let jump = jump - epoch;
            let middle = self.times[..upto].partition_point(|&s| s < jump);
            self.carry(stretcher, jump, middle.max(self.next))?;
            let shown = self.first + self.next..self.first + upto;
            let levels = [now, before];
            self.level = shown_level(self.context.recording, shown, self.nuisances, levels);
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
        self.level = sim.ground_level(self.t + self.context.epoch);
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
        let interval = self.context.recording.interval();
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
    context: &SegmentContext<'_>,
    sim: &StretchSimulator,
    nuisances: &Nuisances,
    skew: f64,
) -> f64 {
    let r = context.recording;
    let from = segment.samples.start;
    let at = |t: f64| sim.ground_level(t + skew + context.epoch);
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
