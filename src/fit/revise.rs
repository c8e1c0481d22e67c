//! Second thoughts on events. Where a segment does not come down to the noise although
//! the others have, the data may have been misread there: a hop too small to be seen, a
//! quick stay taken for a bounce, a sharp turn in the air taken for an impact. Each
//! such reading is tried, and kept if the segment then fits clearly better.

use rayon::prelude::*;

use super::problem::Problem;
use super::robust::Huber;
use super::segment::{Joint, JointKind, Segment};
use super::solve::Point;
use super::timeline::Kind;
use crate::model::Model;
use crate::model::drive::{VoltageTable, Waveform};
use crate::model::parameter::ParameterId;
use crate::sim::{EventKind, Options, Runner, SimError, StretchSimulator, StretchState};

/// A segment whose mean cost is above this is looked at again.
const SUSPECT: f64 = 1.6;
/// Another reading must bring the cost below this share.
const BETTER: f64 = 0.8;
/// Changes made to one segment, one after the other.
const MOST_CHANGES: usize = 2;
/// Segments with more joints than this are not changed joint by joint.
const MOST_JOINTS: usize = 7;
/// Factors on the restitution with which events are predicted.
const RESTITUTIONS: [f64; 5] = [1.0, 0.8, 1.25, 0.6, 1.6];
/// Samples before the first event from which a prediction starts.
const LEAST_BEFORE: usize = 12;
/// Rounds of fitting for each reading tried.
const ROUNDS: usize = 8;
/// Loss while a reading settles: hardly robust.
const LOOSE: Huber = Huber(100.0);

/// Takes the say from segments that do not fit while the others do; returns how many.
///
/// # Errors
/// [`SimError`] if the model makes no sense at the point.
pub fn set_suspects_aside(
    problem: &Problem,
    point: &mut Point,
    huber: Huber,
) -> Result<usize, SimError> {
    let simulator = problem.simulator(&point.x)?;
    let states = problem.states(&simulator, &point.segments);
    let fitted: Vec<(Vec<f64>, f64)> = point
        .segments
        .par_iter()
        .enumerate()
        .map(|(i, segment)| {
            let nuisances = problem.nuisances_of(&point.x, segment.recording);
            let start = segment.locals.clone();
            let (locals, cost) =
                problem.refine(segment, &states[i], &simulator, &nuisances, start, huber, 5);
            (locals, cost / problem.rows(segment).len().max(1) as f64)
        })
        .collect();
    // Measured by the others: where all are off, it is not the reading of events.
    let mut costs: Vec<f64> = fitted.iter().map(|f| f.1).collect();
    let usual = crate::recording::quantile_in_place(&mut costs, 0.5);
    let grounded = problem.space.model(&point.x).has_ground;
    let mut aside = 0;
    for (i, (locals, cost)) in fitted.into_iter().enumerate() {
        point.segments[i].locals = locals;
        // Without a ground there are no events to misread.
        point.used[i] = !grounded || cost <= SUSPECT * usual.max(1.0);
        aside += usize::from(!point.used[i]);
    }
    Ok(aside)
}

/// Tries other readings of the events in the segments set aside, and takes those back
/// that then fit. `first` are the segments as first guessed. Returns how many came back.
///
/// # Errors
/// [`SimError`] if the model makes no sense at the point.
pub fn revise(
    problem: &Problem,
    point: &mut Point,
    first: &[Segment],
    huber: Huber,
) -> Result<usize, SimError> {
    let simulator = problem.simulator(&point.x)?;
    let states = problem.states(&simulator, &point.segments);
    let model = problem.space.model(&point.x);
    let revised: Vec<Option<(Segment, f64)>> = point
        .segments
        .par_iter()
        .enumerate()
        .map(|(i, segment)| {
            let trial = Trial {
                problem,
                simulator: &simulator,
                model: &model,
                states: &states[i],
                x: &point.x,
                huber,
            };
            (!point.used[i]).then(|| trial.revised(segment, &first[i]))
        })
        .collect();
    let mut back = 0;
    for (i, revised) in revised.into_iter().enumerate() {
        if let Some((segment, cost)) = revised {
            point.segments[i] = segment;
            point.used[i] = cost < SUSPECT;
            back += usize::from(point.used[i]);
        }
    }
    Ok(back)
}

struct Trial<'a> {
    problem: &'a Problem,
    simulator: &'a StretchSimulator,
    model: &'a Model,
    states: &'a [f64],
    x: &'a [f64],
    huber: Huber,
}

impl Trial<'_> {
    /// Fits a segment's own unknowns; its mean cost per row.
    fn fit(&self, segment: &mut Segment) -> f64 {
        let nuisances = self.problem.nuisances_of(self.x, segment.recording);
        let refine = |s: &Segment, huber: Huber, rounds| {
            let start = s.locals.clone();
            let p = self.problem;
            p.refine(
                s,
                self.states,
                self.simulator,
                &nuisances,
                start,
                huber,
                rounds,
            )
        };
        segment.locals = refine(segment, LOOSE, ROUNDS).0;
        let (locals, cost) = refine(segment, self.huber, ROUNDS);
        segment.locals = locals;
        cost / self.problem.rows(segment).len().max(1) as f64
    }

    /// Readings with one impact more, where the data turn sharply near the ground.
    fn overlooked(&self, segment: &Segment) -> Vec<Segment> {
        let data = &self.problem.data[segment.recording];
        let (time, xp) = (&data.recording.time, &data.recording.proof_mass);
        let nuisances = self.problem.nuisances_of(self.x, segment.recording);
        let (state, parts) = taken_apart(segment);
        let interval = segment.interval;
        let mut out = Vec::new();
        for i in segment.samples.start + 2..segment.samples.end.saturating_sub(2) {
            let level =
                self.simulator.ground_level(time[i]) * nuisances.scale_p + nuisances.offset_p;
            let fall = (xp[i - 1] - xp[i]).max(xp[i - 2] - xp[i - 1]);
            let lowest = xp[i] < xp[i - 1] && xp[i] <= xp[i + 1];
            // An impact lies less than a sample's way below the lowest sample.
            let low = xp[i] - level < 1.5 * fall.abs() + 5.0 * data.sigmas.xp;
            let taken = |p: &Part| (p.0.time - time[i]).abs() < 2.0 * interval;
            if !(lowest && low) || parts.iter().any(taken) {
                continue;
            }
            let rise = (xp[i + 1] - xp[i]).max(xp[i + 2] - xp[i + 1]);
            let v_after = (rise / interval).max(0.0);
            let joint = Joint {
                time: time[i],
                reach: 5.0 * interval,
                sigma: 2.0 * interval,
                what: JointKind::Event(Kind::Bounce { v_after }),
            };
            let at = parts.partition_point(|p| p.0.time < time[i]);
            let mut all = parts.clone();
            all.insert(at, (joint, vec![0.0, v_after / segment.velocity_unit]));
            out.push(put_together(segment, state, all));
        }
        out
    }

    /// The reading that the model itself predicts from the state at the segment's start,
    /// which is fitted to what comes before its first event.
    fn predicted(&self, segment: &Segment, factor: f64) -> Option<Segment> {
        let data = &self.problem.data[segment.recording];
        let time = &data.recording.time;
        let nuisances = self.problem.nuisances_of(self.x, segment.recording);
        let (_, parts) = taken_apart(segment);
        let is_event = |p: &Part| matches!(p.0.what, JointKind::Event(_));
        let before = match parts.iter().find(|p| is_event(p)) {
            Some(p) => time.partition_point(|&t| t < p.0.time - 0.5 * segment.interval),
            None => (segment.samples.start + 2 * LEAST_BEFORE).min(segment.samples.end - 1),
        };
        let mut state = segment.clone();
        if before > segment.samples.start + LEAST_BEFORE {
            state.samples = segment.samples.start..before;
            let quiet = |p: &&Part| !is_event(p) && p.0.time < time[before];
            let (own, _) = taken_apart(segment);
            state = put_together(&state, own, parts.iter().filter(quiet).cloned().collect());
            self.fit(&mut state);
        }
        let (own, known) = taken_apart(&state);
        let edges: Vec<Part> = parts
            .iter()
            .filter(|p| !is_event(p))
            .map(|p| {
                known
                    .iter()
                    .find(|k| k.0.time == p.0.time)
                    .unwrap_or(p)
                    .clone()
            })
            .collect();
        let start = time[segment.samples.start] + nuisances.skew;
        let end = time[segment.samples.end - 1] + nuisances.skew;
        let mut pieces = segment.pieces.clone();
        for (joint, unknowns) in &edges {
            if let JointKind::Edge(piece) = joint.what {
                let at = joint.time + unknowns[0] * segment.time_unit();
                pieces[piece - 1].end = at;
                pieces[piece].start = at;
            }
        }
        let margin = 10.0 * segment.interval;
        let table =
            VoltageTable::from_pieces(&pieces, start - margin, end + margin, segment.interval);
        let drive = Waveform::Table(std::sync::Arc::new(table.ok()?));
        let n = own.len() / 2;
        let value = |i: usize| own[i] * segment.units[i];
        let from = StretchState {
            q: (0..n).map(value).collect(),
            v: (n..2 * n).map(value).collect(),
            z: self.states.to_vec(),
        };
        let since = segment.starts_held.then(|| segment.since.unwrap_or(start));
        let options = Options {
            max_events: 200,
            ..self.problem.options
        };
        let mut model = self.model.clone();
        let alpha = model.parameters[ParameterId::Alpha];
        model
            .parameters
            .set(ParameterId::Alpha, (factor * alpha).min(1.0));
        let runner = Runner::from_state(&model, &drive, &options, start, &from, since);
        let mut runner = runner.ok()?;
        let mut trace = runner.new_trace();
        runner.advance(end, &mut trace).ok()?;
        let mut all = edges;
        for e in trace.events.iter().filter(|e| e.time < end) {
            let kind = match e.kind {
                EventKind::Impact => Kind::Bounce {
                    v_after: e.velocity_after,
                },
                EventKind::Stick => Kind::Touch,
                EventKind::Release => Kind::Release {
                    telling: e.contact_duration > 1.5 * segment.interval
                        && (!segment.starts_held || segment.since.is_some()),
                },
                EventKind::DriveStep => continue,
            };
            let joint = Joint {
                time: e.time - nuisances.skew,
                reach: 5.0 * segment.interval,
                sigma: 2.0 * segment.interval,
                what: JointKind::Event(kind),
            };
            let mut unknowns = vec![0.0];
            if let Kind::Bounce { v_after } = kind {
                unknowns.push(v_after / segment.velocity_unit);
            }
            all.push((joint, unknowns));
        }
        all.sort_by(|a, b| a.0.time.total_cmp(&b.0.time));
        Some(put_together(segment, own, all))
    }

    /// The best reading found, with its mean cost per row.
    fn revised(&self, segment: &Segment, first: &Segment) -> (Segment, f64) {
        let mut best = segment.clone();
        let mut cost = self.fit(&mut best);
        // The same reading from the first guess: the fit may have gone astray before.
        let mut others = vec![first.clone()];
        // Restitution is told by the bounces, so that it may be off as long as they are
        // misread.
        others.extend(
            RESTITUTIONS
                .iter()
                .filter_map(|f| self.predicted(first, *f)),
        );
        others.retain(Segment::is_consistent);
        for mut other in others {
            if cost < SUSPECT {
                break;
            }
            let now = self.fit(&mut other);
            if now < BETTER * cost {
                (best, cost) = (other, now);
            }
        }
        for _ in 0..MOST_CHANGES {
            if cost < SUSPECT || best.joints.len() > MOST_JOINTS {
                break;
            }
            let mut found: Option<(Segment, f64)> = None;
            let mut others = readings(&best);
            others.extend(self.overlooked(&best));
            others.retain(Segment::is_consistent);
            for mut other in others {
                let now = self.fit(&mut other);
                if now < found.as_ref().map_or(BETTER * cost, |f| f.1) {
                    found = Some((other, now));
                }
            }
            let Some((segment, now)) = found else { break };
            (best, cost) = (segment, now);
        }
        (best, cost)
    }
}

/// A joint with its own unknowns.
type Part = (Joint, Vec<f64>);

/// Other readings of a segment, each one change away.
fn readings(segment: &Segment) -> Vec<Segment> {
    let (state, parts) = taken_apart(segment);
    let velocity_unit = segment.velocity_unit;
    let interval = segment.interval;
    let mut out = Vec::new();
    let mut add = |parts: Vec<Part>| out.push(put_together(segment, state, parts));
    for i in 0..parts.len() {
        let with = |new: Vec<Part>, removed: usize| {
            let mut all = parts[..i].to_vec();
            all.extend(new);
            all.extend_from_slice(&parts[i + removed..]);
            all
        };
        let (joint, own) = &parts[i];
        let JointKind::Event(kind) = joint.what else {
            continue;
        };
        let at = joint.time + own[0] * segment.time_unit();
        let event = |kind, time: f64| Joint {
            time,
            what: JointKind::Event(kind),
            ..*joint
        };
        let next = parts.get(i + 1).map(|p| p.0.what);
        let brief = matches!(next, Some(JointKind::Event(Kind::Release { .. })));
        let touch = || (event(Kind::Touch, at), vec![0.0]);
        let release = |after: f64| {
            let kind = Kind::Release {
                telling: after > 1.5 * interval,
            };
            (event(kind, at + after), vec![0.0])
        };
        match kind {
            Kind::Bounce { .. } => {
                // No impact at all, or one without a bounce.
                add(with(Vec::new(), 1));
                for stay in [0.3, 2.0] {
                    add(with(vec![touch(), release(stay * interval)], 1));
                }
            }
            Kind::Touch => {
                if brief {
                    let v_after = 0.02;
                    let bounce = event(Kind::Bounce { v_after }, at);
                    add(with(vec![(bounce, vec![0.0, v_after / velocity_unit])], 2));
                    add(with(Vec::new(), 2));
                }
                // A hop before the stay.
                for hop in [3.0, 5.0, 8.0] {
                    let later = (event(Kind::Touch, at + hop * interval), vec![0.0]);
                    add(with(vec![touch(), release(0.3 * interval), later], 1));
                }
            }
            Kind::Release { .. } => {
                // Back on the ground at once, and off again.
                if i > 0
                    && matches!(parts[i - 1].0.what, JointKind::Event(Kind::Touch))
                    && let Some(JointKind::Event(Kind::Touch)) = next
                {
                    // The hop was none.
                    add(with(Vec::new(), 2));
                }
            }
        }
    }
    out
}

fn taken_apart(segment: &Segment) -> (&[f64], Vec<Part>) {
    let joints: usize = segment.joints.iter().map(Joint::unknowns).sum();
    let (state, mut rest) = segment.locals.split_at(segment.locals.len() - joints);
    let parts = segment.joints.iter().map(|joint| {
        let (own, after) = rest.split_at(joint.unknowns());
        rest = after;
        (*joint, own.to_vec())
    });
    let parts = parts.collect();
    (state, parts)
}

fn put_together(segment: &Segment, state: &[f64], parts: Vec<Part>) -> Segment {
    let mut units = segment.units[..state.len()].to_vec();
    let mut locals = state.to_vec();
    for (joint, own) in &parts {
        units.push(segment.time_unit());
        if joint.unknowns() == 2 {
            units.push(segment.velocity_unit);
        }
        locals.extend_from_slice(own);
    }
    Segment {
        joints: parts.into_iter().map(|p| p.0).collect(),
        locals,
        units,
        ..segment.clone()
    }
}
