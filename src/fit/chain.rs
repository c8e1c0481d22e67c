//! A segment simulated: what is left between data and simulation, in units of the noise.
//!
//! The rows are, in this order: the readings of the proof mass, those of the cantilever,
//! at each event the laws of the ground (the height at a touch, the velocity after a
//! bounce, the force at a release), and how far the instants are from where they were
//! guessed. Their number does not depend on the unknowns.

use super::colour::Colour;
use super::segment::{Joint, JointKind, Segment};
use super::timeline::Kind;
use crate::model::drive::Segment as Piece;
use crate::recording::Recording;
use crate::sim::{SimError, StretchSimulator, StretchState, Stretcher};

/// A stay this many samples long is short.
const SHORT: f64 = 6.0;
/// A sensor whose memory fades by more than this exponent from sample to sample has none.
const MEMORY: f64 = 3.0;
/// An edge of the drive this many samples from a release may be what releases.
const EDGE: f64 = 3.0;
/// By how much less the force at the end of a short stay is trusted.
const VAGUE: f64 = 30.0;

/// The unknowns that belong to a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nuisances {
    /// Added to the reading of the proof mass \[m\].
    pub offset_p: f64,
    /// Added to that of the cantilever \[m\].
    pub offset_c: f64,
    /// Factor of the reading of the proof mass.
    pub scale_p: f64,
    /// Factor of that of the cantilever.
    pub scale_c: f64,
    /// The drive's clock minus the reading's \[s\].
    pub skew: f64,
}

impl Default for Nuisances {
    fn default() -> Self {
        Self {
            offset_p: 0.0,
            offset_c: 0.0,
            scale_p: 1.0,
            scale_c: 1.0,
            skew: 0.0,
        }
    }
}

/// Standard deviations of the rows of one recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sigmas {
    /// Noise of the proof mass \[m\].
    pub xp: f64,
    /// Noise of the cantilever \[m\].
    pub xc: f64,
    /// Of the height at which the mass meets the ground \[m\].
    pub height: f64,
    /// Of the velocity after a bounce \[m/s\].
    pub velocity: f64,
    /// Of the force at a release \[N\].
    pub force: f64,
    /// Of the held cantilever's rest where only the mass was recorded \[m\].
    pub rest: f64,
    /// Colour of the noise of either reading.
    pub colour: Colour,
}

/// What a row is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Row {
    /// A reading of the proof mass.
    ProofMass,
    /// A reading of the cantilever.
    Cantilever,
    /// Height at a touch or bounce.
    Height,
    /// Velocity after a bounce.
    Velocity,
    /// Force at a release.
    Force,
    /// What was known before.
    Prior,
}

/// A segment's surroundings.
#[derive(Debug, Clone, Copy)]
pub struct Setting<'a> {
    /// The recording.
    pub recording: &'a Recording,
    /// Standard deviations of the rows.
    pub sigmas: &'a Sigmas,
    /// The effects' extra states at its start; empty for those of rest.
    pub states: &'a [f64],
    /// Time from the beginning of the series to that of the recording \[s\], by which the
    /// ground's level goes.
    pub epoch: f64,
}

/// Kinds of the rows that [`residuals`] gives.
pub fn rows(segment: &Segment, setting: &Setting<'_>) -> Vec<Row> {
    let r = setting.recording;
    let finite = |values: &[f64]| {
        values[segment.samples.clone()]
            .iter()
            .filter(|x| x.is_finite())
            .count()
    };
    let mut rows = vec![Row::ProofMass; finite(&r.proof_mass)];
    if let Some(xc) = &r.cantilever {
        rows.resize(rows.len() + finite(xc), Row::Cantilever);
    }
    for joint in &segment.joints {
        if let JointKind::Event(kind) = joint.what {
            match kind {
                Kind::Bounce { .. } => rows.extend([Row::Height, Row::Velocity]),
                Kind::Touch => rows.push(Row::Height),
                Kind::Release { .. } => rows.push(Row::Force),
            }
        }
        rows.push(Row::Prior);
    }
    if segment.starts_held {
        rows.resize(rows.len() + held_count(segment), Row::Prior);
    }
    rows
}

/// Unknowns of a held start.
fn held_count(segment: &Segment) -> usize {
    let joints: usize = segment.joints.iter().map(Joint::unknowns).sum();
    segment.locals.len() - joints
}

/// What one event of a simulated segment is like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Encounter {
    /// The mass comes down.
    Meeting {
        /// When, by the drive's clock \[s\].
        time: f64,
        /// How far from the ground the two are \[m\].
        miss: f64,
        /// Speed of approach \[m/s\].
        speed: f64,
        /// Velocity after, if it bounces \[m/s\].
        after: Option<f64>,
    },
    /// It is pulled off, or was free already (`None`).
    PullOff(Option<PullOff>),
}

/// How the mass is pulled off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PullOff {
    /// When, by the drive's clock \[s\].
    pub time: f64,
    /// How long it was on the ground \[s\].
    pub contact: f64,
    /// With what force \[N\].
    pub force: f64,
    /// The largest step of that force at an edge of the drive close by \[N\].
    pub jump: f64,
    /// Whether the stay was long enough to tell the force.
    pub telling: bool,
}

/// A segment simulated with given unknowns.
#[derive(Debug, Clone, Default)]
pub struct Run {
    /// Proof mass and cantilever at the samples, without the sensor \[m\].
    pub xp: Vec<f64>,
    /// See [`Self::xp`].
    pub xc: Vec<f64>,
    /// What happened at the ground, in order of time.
    pub encounters: Vec<Encounter>,
    /// How far each instant is from its guess, in standard deviations.
    priors: Vec<f64>,
    /// Where a held start would rest.
    rest: Option<StretchState>,
}

/// Simulates `segment` with the unknowns `locals`.
///
/// # Errors
/// [`SimError`] where no simulation is possible.
pub fn run(
    segment: &Segment,
    setting: &Setting<'_>,
    stretcher: &mut Stretcher<'_>,
    nuisances: &Nuisances,
    locals: &[f64],
) -> Result<Run, SimError> {
    let sim = stretcher.simulator();
    let r = setting.recording;
    let samples = segment.samples.clone();
    // What a late reading shows happened before.
    let skew = nuisances.skew - sim.reading_delay();
    let value = |i: usize| segment.value(locals, i);
    let start = r.time[samples.start] + skew;
    let end = r.time[samples.end - 1] + skew;
    let times: Vec<f64> = r.time[samples.clone()].iter().map(|t| t + skew).collect();
    let (mut xp, mut xc) = (vec![f64::NAN; times.len()], vec![f64::NAN; times.len()]);

    // The instants, each kept within its reach and after the one before.
    let mut pieces = segment.pieces.clone();
    let modes = sim.modes();
    let n = if segment.starts_held {
        modes - 1
    } else {
        modes
    };
    let mut k = 2 * n;
    let mut instants = Vec::with_capacity(segment.joints.len());
    let mut priors = Vec::with_capacity(segment.joints.len());
    for joint in &segment.joints {
        // Both kinds are shifted by the reading's clock. Were an edge by the drive's, a skew
        // and all edges of a recording could hardly be told apart.
        let away = match joint.what {
            JointKind::Event(_) => value(k),
            JointKind::Edge(_) => value(k) + skew,
        };
        priors.push(away / joint.sigma);
        let away = away.clamp(-joint.reach, joint.reach);
        k += 1;
        let v_after = match joint.what {
            JointKind::Event(Kind::Bounce { .. }) => {
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

    let mut state = StretchState {
        q: (0..n).map(value).collect(),
        v: (n..2 * n).map(value).collect(),
        z: if setting.states.is_empty() {
            sim.rest_state(&pieces, start, None).z
        } else {
            setting.states.to_vec()
        },
    };
    if let Some(at) = sim.reading_states() {
        // A lag longer than a sample goes on from what was read; a shorter one has no
        // memory, and must not take over the noise.
        let lasting = sim.state_rates()[at] * segment.interval < MEMORY;
        let points = if segment.starts_held {
            sim.held_points(sim.ground_level(start + setting.epoch), &state)
        } else {
            sim.flight_points(&state)
        };
        let n = nuisances;
        let i = samples.start;
        let begun = |x: f64, shown: Option<f64>, offset: f64, scale: f64| match shown {
            Some(shown) if lasting && shown.is_finite() => (shown - offset) / scale,
            _ => x,
        };
        let xc = r.cantilever.as_ref().map(|xc| xc[i]);
        state.z[at] = begun(points.xp, Some(r.proof_mass[i]), n.offset_p, n.scale_p);
        state.z[at + 1] = begun(points.xc, xc, n.offset_c, n.scale_c);
    }
    let mut t = start;
    let mut level = sim.ground_level(start + setting.epoch);
    let mut held = segment.starts_held.then_some(level);
    let rest = held.map(|_| sim.rest_state(&pieces, start, held));
    let mut since = segment.since.unwrap_or(start) + skew;
    let mut next = 0;
    let mut encounters = Vec::with_capacity(instants.len());
    for i in 0..=instants.len() {
        let event = instants.get(i);
        let to = event.map_or(end, |e| e.0.clamp(t, end.max(t)));
        let upto = if event.is_some() {
            times.partition_point(|&s| s <= to)
        } else {
            times.len()
        };
        let upto = upto.max(next);
        let out = |i: usize, p: f64, c: f64| {
            xp[next + i] = p;
            xc[next + i] = c;
        };
        stretcher.carry(&pieces, held, t, to, &mut state, &times[next..upto], out)?;
        next = upto;
        t = to;
        let Some(&(_, v_after, kind)) = event else {
            break;
        };
        match kind {
            Kind::Bounce { .. } | Kind::Touch => {
                level = sim.ground_level(t + setting.epoch);
                // A mark in the wrong place may find the mass held already.
                if held.is_some() {
                    sim.lift(level, &mut state);
                }
                let points = sim.flight_points(&state);
                let bounces = !matches!(kind, Kind::Touch);
                encounters.push(Encounter::Meeting {
                    time: t,
                    miss: points.xp - level,
                    speed: (-points.vp).max(0.0),
                    after: bounces.then_some(v_after),
                });
                if !bounces {
                    sim.kick(level, 0.0, &mut state);
                    sim.land(level, &mut state);
                    held = Some(level);
                    since = t;
                } else {
                    sim.kick(level, v_after, &mut state);
                    held = None;
                }
            }
            Kind::Release { telling } => {
                if held.is_none() {
                    encounters.push(Encounter::PullOff(None));
                    continue;
                }
                encounters.push(Encounter::PullOff(Some(PullOff {
                    time: t,
                    contact: t - since,
                    force: sim.pull_off(&pieces, t, level, &state),
                    jump: jump(sim, &pieces, t, level, &state, r.interval()),
                    telling,
                })));
                sim.lift(level, &mut state);
                held = None;
            }
        }
    }

    Ok(Run {
        xp,
        xc,
        encounters,
        priors,
        rest,
    })
}

/// The largest step of the pull-off force at an edge of the drive that is so close to `t`
/// that the release may be its doing \[N\].
fn jump(
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
        .filter(|start| (start - t).abs() < EDGE * interval)
        .map(|start| (force(start + 1e-3 * interval) - force(start - 1e-3 * interval)).abs())
        .fold(0.0, f64::max)
}

/// What an event leaves of the laws of the ground, in standard deviations.
fn law(
    encounter: &Encounter,
    sim: &StretchSimulator,
    s: &Sigmas,
    interval: f64,
    out: &mut Vec<f64>,
) {
    match *encounter {
        Encounter::Meeting {
            miss, speed, after, ..
        } => {
            out.push(miss / s.height);
            if let Some(after) = after {
                out.push((after - sim.restitution(speed) * speed) / s.velocity);
            }
        }
        Encounter::PullOff(Some(pull)) if pull.telling => {
            // The force at the end of a stay of a few samples rests on instants that few
            // samples tell: it has less of a say.
            let stay = pull.contact / (SHORT * interval);
            let sigma = s.force * (1.0 + VAGUE * (-stay * stay).exp());
            out.push((pull.force - sim.adhesion(pull.contact)) / sigma);
        }
        Encounter::PullOff(_) => out.push(0.0),
    }
}

/// Simulates `segment` with the unknowns `locals` and writes what is left, measured minus
/// simulated over its standard deviation, to `out`.
///
/// # Errors
/// [`SimError`] where no simulation is possible.
pub fn residuals(
    segment: &Segment,
    setting: &Setting<'_>,
    stretcher: &mut Stretcher<'_>,
    nuisances: &Nuisances,
    locals: &[f64],
    out: &mut Vec<f64>,
) -> Result<(), SimError> {
    out.clear();
    let Run {
        xp,
        xc,
        encounters,
        priors,
        rest,
    } = run(segment, setting, stretcher, nuisances, locals)?;
    let sim = stretcher.simulator();
    let (r, s) = (setting.recording, setting.sigmas);
    let samples = segment.samples.clone();
    for (i, x) in samples.clone().zip(&xp) {
        if r.proof_mass[i].is_finite() {
            let shown = nuisances.scale_p * x + nuisances.offset_p;
            out.push((r.proof_mass[i] - shown) / s.xp);
        }
    }
    s.colour.whiten(out);
    let first = out.len();
    if let Some(measured) = &r.cantilever {
        for (i, x) in samples.zip(&xc) {
            if measured[i].is_finite() {
                let shown = nuisances.scale_c * x + nuisances.offset_c;
                out.push((measured[i] - shown) / s.xc);
            }
        }
    }
    s.colour.whiten(&mut out[first..]);
    let mut encounters = encounters.iter();
    for (joint, prior) in segment.joints.iter().zip(priors) {
        if let JointKind::Event(_) = joint.what
            && let Some(encounter) = encounters.next()
        {
            law(encounter, sim, s, r.interval(), out);
        }
        out.push(prior);
    }
    if let Some(rest) = rest {
        let held = sim.held_structure();
        let n = held.omega2.len();
        // Without a reading of it the cantilever is known only by having come to rest.
        let loose = r.cantilever.is_some() || !segment.settled;
        let sigma = if loose { 1e4 * s.rest } else { s.rest };
        for j in 0..n {
            let shape = held.cantilever[j].abs().max(1e-300);
            out.push((state_at(segment, locals, j) - rest.q[j]) * shape / sigma);
        }
        for j in 0..n {
            let shape = held.cantilever[j].abs().max(1e-300) / held.omega2[j].sqrt().max(1e-300);
            out.push((state_at(segment, locals, n + j) - rest.v[j]) * shape / sigma);
        }
    }
    Ok(())
}

fn state_at(segment: &Segment, locals: &[f64], i: usize) -> f64 {
    segment.value(locals, i)
}
