//! A segment carried from event to event with given unknowns.

use std::ops::Range;

use super::residual_rows::{Encounter, Nuisances, PullOff, Run, Setting};
use crate::fit::segment::event_sequence::Kind;
use crate::fit::segment::{Joint, JointKind, Segment};
use crate::model::drive::Segment as Piece;
use crate::recording::Recording;
use crate::sim::{Points, SimError, StretchSimulator, StretchState, Stretcher};

/// A sensor whose memory fades by more than this exponent from sample to sample has none.
const MEMORY: f64 = 3.0;
/// Share of a lag over which accelerations are taken.
const MOMENT: f64 = 0.1;
/// An edge of the drive this many samples from a release may be what releases.
const EDGE: f64 = 3.0;
/// Readings that show where the mass lies.
const SHOWN: usize = 16;

/// Whether the readings lag by so much that a stretch goes on from what was read where it begins.
pub fn begins_from_reading(segment: &Segment, sim: &StretchSimulator) -> bool {
    sim.reading_states()
        .is_some_and(|at| sim.state_rates()[at] * segment.interval < MEMORY)
}

fn points_of(sim: &StretchSimulator, held: Option<f64>, state: &StretchState) -> Points {
    match held {
        Some(level) => sim.held_points(level, state),
        None => sim.flight_points(state),
    }
}

/// What a first-order lag of `tau` \[s\] shows of a motion that has gone on as it does at
/// `start`: of a harmonic one of frequency w about a middle, `x - (tau v - tau^2 a) / (1 +
/// w^2 tau^2)` mode by mode, with the accelerations of the next moment.
fn points_behind(
    stretcher: &mut Stretcher<'_>,
    pieces: &[Piece],
    (held, start): (Option<f64>, f64),
    state: &StretchState,
    tau: f64,
) -> Result<Points, SimError> {
    let sim = stretcher.simulator();
    let moment = MOMENT * tau;
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
    // Another number of modes is another problem, not a step in this one.
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
    let mut level = level_of(segment, setting, sim, nuisances, skew);
    if let Some(at) = sim.reading_states() {
        // A lag longer than a sample goes on from what was read; a shorter one is where the
        // motion has brought it, and must not take over the noise.
        let lasting = begins_from_reading(segment, sim);
        let on = segment.starts_held.then_some(level);
        let points = if lasting {
            points_of(sim, on, &state)
        } else {
            let tau = 1.0 / sim.state_rates()[at];
            points_behind(stretcher, &pieces, (on, start), &state, tau)?
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
        let epoch = setting.epoch;
        // A ground that steps while the mass lies on it takes it along, unless it keeps lying.
        if let Some(lain) = held
            && let Some(jump) = sim.ground_jump(t + epoch, to + epoch)
        {
            let now = sim.ground_level(jump);
            let jump = jump - epoch;
            let middle = times[..upto].partition_point(|&s| s < jump).max(next);
            let out = |i: usize, p: f64, c: f64| {
                xp[next + i] = p;
                xc[next + i] = c;
            };
            stretcher.propagate(
                &pieces,
                held,
                t,
                jump,
                &mut state,
                &times[next..middle],
                out,
            )?;
            (next, t) = (middle, jump);
            let shown = samples.start + next..samples.start + upto;
            level = shown_level(r, shown, nuisances, [now, lain]);
            // How the beam moves beside the mass goes on.
            held = Some(level);
        }
        let out = |i: usize, p: f64, c: f64| {
            xp[next + i] = p;
            xc[next + i] = c;
        };
        stretcher.propagate(&pieces, held, t, to, &mut state, &times[next..upto], out)?;
        next = upto;
        t = to;
        let Some(&(_, v_after, kind)) = event else {
            break;
        };
        match kind {
            Kind::Bounce { .. } | Kind::Touch => {
                level = sim.ground_level(t + setting.epoch);
                // A mark in the wrong place may find the mass held already.
                if let Some(lain) = held {
                    sim.lift(lain, &mut state);
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

/// The ground's level where `segment` begins \[m\]. Where it stepped while the mass lay on it, the
/// mass may have gone with it or kept lying where it was (a particle comes under it as it flies):
/// that the first readings tell.
fn level_of(
    segment: &Segment,
    setting: &Setting<'_>,
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

/// Which of two levels of the ground the first readings of `samples` show: the first where they
/// show none.
fn shown_level(
    r: &Recording,
    samples: Range<usize>,
    nuisances: &Nuisances,
    levels: [f64; 2],
) -> f64 {
    let first = samples.start..samples.end.min(samples.start + SHOWN);
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
