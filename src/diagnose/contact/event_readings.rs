//! Bounces, releases and stays as read by the model of flight, without any contact law. Contact laws
//! are fitted to these readings afterwards.

use super::free_flights;
use crate::diagnose::data::robust_loss::ROBUST_LOSS;
use crate::diagnose::data::side::Split;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::shooting::warm_start::warm_start;
use crate::diagnose::shooting::workspace::Workspace;
use crate::fit::contact_readings;
use crate::fit::contact_readings::ContactReadings;
use crate::fit::problem::Problem;
use crate::fit::problem::huber::Huber;
use crate::fit::problem::prepare::Prepared;
use crate::fit::segment::Segment;
use crate::fit::solve::event_revision::{is_beyond_revision, revise, set_suspects_aside};
use crate::fit::solve::levenberg_marquardt::Clock;
use crate::fit::solve::point::{Point, settle};
use crate::sim::StretchSimulator;

/// Longest segment around events \[s\]: it holds few events, so that a misread one spoils few others.
const MAX_SEGMENT_DURATION: f64 = 1.2e-3;
/// Least error of a ratio \[-\]: instants of neighbouring events share the remaining error of the model.
const MIN_RATIO_ERROR: f64 = 2e-3;
/// Least error of a force \[N\], likewise.
const MIN_FORCE_ERROR: f64 = 5e-11;

/// Readings at the ground on both sides.
#[derive(Debug, Clone, Default)]
pub struct Ground {
    /// Of the fitted recordings.
    pub train: ContactReadings,
    /// Of the held-out recordings.
    pub held_out: ContactReadings,
    /// Mass that the ground feels \[kg\].
    pub mass: f64,
    /// How the events of either side were read.
    pub(crate) known: [Option<Known>; 2],
}

/// Segments around events of one side as they were read last, by a model that fitted well enough.
#[derive(Debug, Clone)]
pub(crate) struct Known {
    segments: Vec<Segment>,
    /// Which of them were read.
    used: Vec<bool>,
    simulator: StretchSimulator,
}

/// Reads the events of both sides with the models as fitted. Those that were read `before`, with
/// a model that lacked something, are taken as they were read then.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn read(
    workspace: &Workspace,
    train: &Fitted,
    held_out: Option<&Fitted>,
    before: Option<&Ground>,
    control: &DiagnoseControl<'_>,
) -> Result<Ground, DiagnoseError> {
    if !train.model.has_ground {
        return Ok(Ground::default());
    }
    if free_flights::is_free(&train.model) {
        let noise = |fitted: &Fitted| fitted.problem.data.first().map_or(0.0, |d| d.sigmas.xp);
        let read = |side: &Split, fitted: &Fitted| {
            let bounces = free_flights::bounces(&side.parts, noise(fitted));
            log::debug!("{} bounces between flights", bounces.len());
            with_least_errors(ContactReadings {
                bounces,
                ..ContactReadings::default()
            })
        };
        let other = workspace.held_out.as_ref().zip(held_out);
        return Ok(Ground {
            train: read(&workspace.train, train),
            held_out: other.map_or_else(Default::default, |(side, fitted)| read(side, fitted)),
            mass: 1.0 / train.model.structure().mobility(),
            known: [None, None],
        });
    }
    let known = |side: usize| before.and_then(|before| before.known[side].as_ref());
    let other = match (held_out, &workspace.held_out) {
        (Some(fitted), Some(side)) => side_readings(workspace, side, fitted, known(1), control)?,
        _ => Default::default(),
    };
    let own = side_readings(workspace, &workspace.train, train, known(0), control)?;
    Ok(Ground {
        train: own.0,
        held_out: other.0,
        mass: 1.0 / train.model.structure().mobility(),
        known: [own.1, other.1],
    })
}

/// What is read of one side, and how.
fn side_readings(
    workspace: &Workspace,
    side: &Split,
    fitted: &Fitted,
    known: Option<&Known>,
    control: &DiagnoseControl<'_>,
) -> Result<(ContactReadings, Option<Known>), DiagnoseError> {
    let (prepared, point) = around_events(workspace, side, fitted)?;
    let (point, known) = match known {
        Some(known) => (as_known(&prepared, point, known)?, None),
        None => read_again(&prepared, point, control)?,
    };
    let found = contact_readings::read_contacts_at(&prepared, &point)?;
    log::debug!(
        "{} bounces and {} releases read, {} and {} not, {:.2} off",
        found.bounces.len(),
        found.releases.len(),
        found.unread,
        found.unread_releases,
        found.off.read
    );
    Ok((with_least_errors(found), known))
}

/// Readings with the errors that neighbouring events share.
fn with_least_errors(mut found: ContactReadings) -> ContactReadings {
    for b in &mut found.bounces {
        log::trace!("{b:?}");
        b.error = b.error.hypot(MIN_RATIO_ERROR);
    }
    for r in &mut found.releases {
        r.error = r.error.hypot(MIN_FORCE_ERROR);
    }
    found
}

/// Reads misread segments again, as in a fit. Also returns how, if the model is near enough for that.
fn read_again(
    prepared: &Prepared,
    mut point: Point,
    control: &DiagnoseControl<'_>,
) -> Result<(Point, Option<Known>), DiagnoseError> {
    let control = control.quiet();
    let eligible = point.used.clone();
    let problem = &prepared.problem;
    set_suspects_aside(problem, &mut point, ROBUST_LOSS, &control)?;
    // The other segments show how near the model is.
    point = settle(
        problem,
        &point.x,
        &point.segments,
        &point.used,
        ROBUST_LOSS,
        1,
    )?;
    if is_beyond_revision(&point) {
        // A second reading would be wrong as well.
        point.used = eligible;
        return Ok((point, None));
    }
    let watch = (&control, &Clock::new(1));
    let back = revise(problem, &mut point, &prepared.segments, ROBUST_LOSS, watch)?;
    let aside = eligible.iter().zip(&point.used);
    let aside = aside.filter(|(e, u)| **e && !**u).count();
    log::debug!("{back} segments read again, {aside} not");
    // Events that had been overlooked count as much as the others.
    let overlooked = |i: usize| point.used[i] && point.segments[i].has_events();
    point.used = (0..eligible.len())
        .map(|i| eligible[i] || overlooked(i))
        .collect();
    let known = Known {
        segments: point.segments.clone(),
        used: point.used.clone(),
        simulator: problem.simulator(&point.x)?,
    };
    Ok((point, Some(known)))
}

/// The same with the events read as they are `known`.
fn as_known(prepared: &Prepared, point: Point, known: &Known) -> Result<Point, DiagnoseError> {
    let problem = &prepared.problem;
    let simulator = problem.simulator(&point.x)?;
    let first = prepared.segments.clone();
    let adopted = warm_start(
        &known.segments,
        first,
        (&known.simulator, &simulator),
        problem,
    );
    let other: Vec<bool> = adopted
        .iter()
        .zip(&prepared.segments)
        .map(|(known, first)| known.joints != first.joints)
        .collect();
    let pick = |i: usize| {
        if other[i] {
            &adopted[i]
        } else {
            &point.segments[i]
        }
    };
    let segments: Vec<Segment> = (0..other.len()).map(|i| pick(i).clone()).collect();
    // Events that were overlooked at first are known now. If the segments were cut differently, none
    // is.
    let found = |i: usize| other[i] && known.used[i] && segments[i].has_events();
    let used: Vec<bool> = (0..other.len())
        .map(|i| point.used[i] || found(i))
        .collect();
    let mut there = near_by(problem, &point.x, &segments, &used)?;
    // A reading that suited an incomplete model may suit this one less.
    let states = problem.states(&point.x, &simulator, &point.segments);
    let cost = |i: usize, of: &Point| {
        let segment = &of.segments[i];
        let nuisances = problem.nuisances_of(&of.x, segment.recording);
        let (states, locals) = (&states[i], &segment.locals);
        problem.cost(segment, states, &simulator, &nuisances, locals, ROBUST_LOSS)
    };
    for i in (0..other.len()).filter(|&i| other[i] && point.used[i]) {
        if cost(i, &point) < cost(i, &there) {
            there.segments[i].clone_from(&point.segments[i]);
        }
    }
    Ok(there)
}

/// Short segments of one side around contact events, fitted by the model of flight without any
/// contact law.
///
/// # Errors
/// [`DiagnoseError`] if the model cannot be simulated.
pub fn around_events(
    workspace: &Workspace,
    side: &Split,
    fitted: &Fitted,
) -> Result<(Prepared, Point), DiagnoseError> {
    let mut prepared = workspace.with_events(side, &fitted.model, MAX_SEGMENT_DURATION)?;
    let own = &fitted.problem;
    for (data, known) in prepared.problem.data.iter_mut().zip(&own.data) {
        data.sigmas = known.sigmas;
        data.sigmas.velocity *= contact_readings::GROUND_LAW_RELAXATION;
        data.sigmas.force *= contact_readings::GROUND_LAW_RELAXATION;
        data.sigmas.height *= contact_readings::GROUND_LAW_RELAXATION;
        data.epoch = known.epoch;
    }
    prepared.problem.space = own.space.clone();
    let x = &fitted.point.x;
    let used: Vec<bool> = prepared.segments.iter().map(|s| s.has_events()).collect();
    let point = near_by(&prepared.problem, x, &prepared.segments, &used)?;
    Ok((prepared, point))
}

/// The segments' own unknowns fitted, all else fixed.
fn near_by(
    problem: &Problem,
    x: &[f64],
    segments: &[Segment],
    used: &[bool],
) -> Result<Point, DiagnoseError> {
    let point = settle(problem, x, segments, used, Huber(1e3), 6)?;
    Ok(settle(problem, x, &point.segments, used, ROBUST_LOSS, 5)?)
}

#[cfg(test)]
mod tests {
    use super::super::event_readings::*;

    use crate::diagnose::test_support::{QUIET, workspace_of};
    use crate::fit::contact_readings::Bounce;
    use crate::fit::segment::event_sequence::GroundEvent;
    use crate::fit::segment::{Joint, JointKind};
    use crate::model::effects::{ActiveEffect, find};
    use crate::model::parameter::ParameterId;
    use crate::model::preset::Preset;
    use crate::model::with_effect;

    #[test]
    fn misread_bounces_are_read_again() {
        const POWER: f64 = 0.25;
        let model = Preset::embedded("paper").unwrap().model;
        let mut law = ActiveEffect::new(find("velocity_restitution").unwrap());
        law.values = vec![POWER, 0.1];
        // Series of bounces, each lower than the last.
        let drives = [("square:40Hz:7V", 0.15)];
        let workspace = workspace_of(&with_effect(&model, law), &drives, 50e3, 20e-9);
        let base = workspace.baseline(&model, &QUIET).unwrap();
        let (prepared, point) = around_events(&workspace, &workspace.train, &base).unwrap();
        let once = contact_readings::read_contacts_at(&prepared, &point).unwrap();
        let ground = read(&workspace, &base, None, None, &QUIET).unwrap();
        let (before, after) = (once.bounces.len(), ground.train.bounces.len());
        assert!(after >= before + 4, "{before} {after}");
        let test = super::super::decide::tests(&ground);
        let test = test.iter().find(|t| t.id == "velocity_restitution");
        let (found, error) = test.map(|t| (t.effect.values[0], t.errors[0])).unwrap();
        assert!((found - POWER).abs() < 4.0 * error, "{found} {error}");
        assert!(error < 0.2 * POWER, "{error}");
    }

    #[test]
    fn overlooked_bounces_are_used_once_they_are_found() {
        let model = Preset::embedded("paper").unwrap().model;
        let drives = [("square:40Hz:7V", 0.15), ("sine:50Hz:8V", 0.12)];
        let workspace = workspace_of(&model, &drives, 50e3, 20e-9);
        let base = workspace.baseline(&model, &QUIET).unwrap();
        let (mut prepared, mut point) = around_events(&workspace, &workspace.train, &base).unwrap();
        let (all, _) = read_again(&prepared, point.clone(), &QUIET).unwrap();
        let all = contact_readings::read_contacts_at(&prepared, &all)
            .unwrap()
            .bounces;
        // Stretches with a bounce, as if nothing had been seen at the ground.
        let mut overlooked = Vec::new();
        for i in 0..point.segments.len() {
            let segment = &mut point.segments[i];
            let bounce = |j: &Joint| matches!(j.what, JointKind::Event(GroundEvent::Bounce { .. }));
            if segment.starts_held || !segment.joints.iter().any(bounce) {
                continue;
            }
            let own: usize = segment.joints.iter().map(Joint::unknowns).sum();
            let mut k = segment.locals.len() - own;
            let mut kept: Vec<usize> = (0..k).collect();
            for joint in &segment.joints {
                if matches!(joint.what, JointKind::Edge(_)) {
                    kept.push(k);
                }
                k += joint.unknowns();
            }
            segment.locals = kept.iter().map(|&k| segment.locals[k]).collect();
            segment.units = kept.iter().map(|&k| segment.units[k]).collect();
            let edge = |j: &Joint| matches!(j.what, JointKind::Edge(_));
            segment.joints.retain(edge);
            prepared.segments[i].clone_from(segment);
            point.used[i] = false;
            overlooked.push(i);
        }
        let left = contact_readings::read_contacts_at(&prepared, &point)
            .unwrap()
            .bounces;
        let (again, known) = read_again(&prepared, point.clone(), &QUIET).unwrap();
        let found = contact_readings::read_contacts_at(&prepared, &again)
            .unwrap()
            .bounces;
        let counts = [left.len(), found.len(), all.len()];
        assert!(overlooked.iter().any(|&i| again.used[i]), "{counts:?}");
        assert!(counts[1] >= counts[0] + 5, "{counts:?}");
        let alpha = model.parameters.get(ParameterId::Alpha);
        let far = |b: &&Bounce| (b.ratio - alpha).abs() > 4.0 * b.error;
        let far = found.iter().filter(far).count();
        assert!(far <= 1, "{far} of {counts:?}");
        // They are still known when all is read once more.
        let mut known = known.unwrap();
        let later = |known: &Known| {
            let point = as_known(&prepared, point.clone(), known).unwrap();
            contact_readings::read_contacts_at(&prepared, &point)
                .unwrap()
                .bounces
                .len()
        };
        let whole = later(&known);
        assert!(whole + 1 >= counts[1], "{whole} {counts:?}");
        // What was cut otherwise then says nothing now.
        known.segments.pop();
        known.used.pop();
        assert_eq!(later(&known), counts[0]);
    }
}
