//! Hypotheses with what each promises: the catalogue in the linearised problem, a
//! vibration by frequency, a step of the ground by time, a further mode by its hump.

use super::base_vibration::find_line;
use super::extra_mode;
use super::level_step::{RISE, find_step, first_level};
use crate::diagnose::comparison::hypothesis::Hypothesis;
use crate::diagnose::comparison::trial::ModelState;
use crate::diagnose::data::level_drift;
use crate::diagnose::options::DiagnoseError;
use crate::diagnose::score_test::forms::{CatalogueDirection, Scale, forms};
use crate::diagnose::score_test::linearized::Linearized;
use crate::diagnose::score_test::scan::{ScoreGain, ScoreScan};
use crate::diagnose::shooting::latency::{DELAY, taken};
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::thresholds::{RIVAL_LAW_MIN_SCORE_SHARE, SEARCHED_REFIT_MIN_SCORE};
use crate::fit::segment::Segment;
use crate::model::effects::{ActiveEffect, EffectSpec, find, own_ids};

/// Stays that begin so close to each other may begin with the step \[s\].
const WHILE: f64 = 1e-3;
/// Most times a form's strength that a refit begins with: the linearised problem knows
/// direction and rough size only.
const MOST: f64 = 30.0;
/// The same for a delay, in proportion to which the readings move.
const MOST_DELAY: f64 = 300.0;
/// Exponents that an attraction may have: that of a sphere on a plane to one that falls off as
/// an exponential does.
const EXPONENTS: (f64, f64) = (2.0, 12.0);
/// Factor by which constants may leave what was looked at.
const NEAR: f64 = 3.0;

/// The largest promise among the hypotheses of an effect.
fn most_of(all: &[Hypothesis], spec: &EffectSpec) -> f64 {
    let own = all.iter().filter(|h| h.start.spec == spec);
    own.fold(0.0, |most, h| most.max(h.predicted_gain))
}

/// The best form of each law of each effect that is asked, with what the linearised problem
/// promises.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn promises(
    workspace: &Workspace,
    stand: &ModelState,
    is_asked: &dyn Fn(&EffectSpec) -> bool,
) -> Result<Vec<Hypothesis>, DiagnoseError> {
    let asked = |id: &str| find(id).filter(|spec| is_asked(spec));
    let model = &stand.train.model;
    let linear = Linearized::new(&stand.train)?;
    let data = &stand.train.problem.data;
    let heights = data.iter().flat_map(|d| &d.recording.proof_mass);
    let length = heights
        .filter(|x| x.is_finite())
        .fold(0.0f64, |a, x| a.max(x.abs()));
    let interval = data.iter().map(|d| d.recording.interval());
    let interval = interval.fold(f64::INFINITY, f64::min);
    let mut all = forms(model, &Scale::new(model, length.max(1e-12), interval));
    all.retain(|form| is_asked(form.spec));
    let scan = ScoreScan::new(&linear, model, &all)?;
    let (delay, fall) = taken(linear.problem(), &linear.point().x);
    let mut out: Vec<Hypothesis> = Vec::new();
    for (k, form) in all.iter().enumerate() {
        let worth = |promise: ScoreGain| {
            let strength = promise.theta * form.values[form.strength];
            let too_short = form.is_lag() && strength < form.least();
            let gain = if too_short || promise.theta < 0.0 && !form.signed {
                0.0
            } else {
                promise.gain
            };
            ScoreGain { gain, ..promise }
        };
        // Where a jump of the voltage meets a sample, a clock has a kink that no linearisation
        // sees past: what the clocks would give up is known without one.
        let by_clocks = (fall > 0.0 && form.strength_id() == DELAY).then(|| ScoreGain {
            gain: fall,
            theta: delay / form.values[form.strength],
        });
        let told = scan.promise(k).into_iter().chain(by_clocks).map(worth);
        let Some(promise) = told.max_by(|a, b| a.gain.total_cmp(&b.gain)) else {
            continue;
        };
        let gain = promise.gain;
        let hypothesis = from_form(form, &all, promise.theta, gain);
        // Laws of one effect that differ in what is their strength are asked each.
        let same = |h: &&mut Hypothesis| h.start.spec == form.spec && h.free == hypothesis.free;
        match out.iter_mut().find(same) {
            Some(known) if known.predicted_gain >= gain => {}
            Some(known) => *known = hypothesis,
            None => out.push(hypothesis),
        }
    }
    let every = out.clone();
    out.retain(|h| h.predicted_gain >= RIVAL_LAW_MIN_SCORE_SHARE * most_of(&every, h.start.spec));
    let beyond = workspace.drift_beyond(model).cloned();
    if let Some((start, free)) = beyond.filter(|(start, _)| is_asked(start.spec)) {
        let spec = start.spec;
        let shape = level_drift::shape_beside(spec, &free);
        let near = |tau: f64| (tau / NEAR, tau * NEAR);
        let read = Hypothesis {
            alternative_starts: Vec::new(),
            cold_start: Some((start.clone(), free.clone())),
            shape,
            bounds: vec![(own_ids(spec, &[1])[0].clone(), near(start.values[1]))],
            start,
            free,
            predicted_gain: most_of(&every, spec).max(SEARCHED_REFIT_MIN_SCORE),
            look_elsewhere: false,
            sequential_time: false,
            estimated_on_held_out: None,
        };
        // Before those that promise as much.
        out.insert(0, read);
    }
    if let Some(spec) = asked("base_vibration")
        && let Some(line) = find_line(&linear, model, spec)?
    {
        let start = ActiveEffect {
            spec,
            values: vec![line.amplitude, line.frequency, line.phase],
        };
        out.push(Hypothesis {
            start,
            alternative_starts: Vec::new(),
            free: own_ids(spec, &[0, 1, 2]),
            cold_start: None,
            shape: Vec::new(),
            bounds: Vec::new(),
            predicted_gain: line.gain,
            look_elsewhere: true,
            sequential_time: false,
            estimated_on_held_out: None,
        });
    }
    if let Some(spec) = asked("gap_step").filter(|_| model.has_ground) {
        let stays = held_out_stays(stand);
        for step in find_step(&linear, model, 0, &workspace.epochs())? {
            let at = |time: f64| ActiveEffect {
                spec,
                values: vec![RISE * step.height, time],
            };
            // Only in each recording: those kept out are later in the series.
            let open = |t: &&f64| !step.series && **t > step.since && **t < step.time;
            out.push(Hypothesis {
                start: at(step.time),
                alternative_starts: stays
                    .iter()
                    .filter(open)
                    .map(|t| (at(*t), Vec::new()))
                    .collect(),
                free: own_ids(spec, &[0]),
                cold_start: None,
                shape: Vec::new(),
                bounds: Vec::new(),
                predicted_gain: step.gain,
                look_elsewhere: true,
                sequential_time: step.series,
                estimated_on_held_out: None,
            });
        }
        out.extend(after_all(workspace, stand, spec)?);
    }
    if let Some(spec) = asked("extra_mode") {
        out.extend(extra_mode::further(workspace, stand, spec)?);
    }
    Ok(out)
}

/// A step of the ground between the fitted recordings and those kept out. The first of those kept
/// out tells its height.
fn after_all(
    workspace: &Workspace,
    stand: &ModelState,
    spec: &'static EffectSpec,
) -> Result<Option<Hypothesis>, DiagnoseError> {
    let Some(held) = &stand.held_out else {
        return Ok(None);
    };
    let linear = Linearized::new(held)?;
    let Some((first, promise)) = first_level(&linear, &held.model)? else {
        return Ok(None);
    };
    Ok(Some(Hypothesis {
        start: ActiveEffect {
            spec,
            values: vec![RISE * promise.theta, workspace.end_of_fitted()],
        },
        alternative_starts: Vec::new(),
        free: own_ids(spec, &[0]),
        cold_start: None,
        shape: Vec::new(),
        bounds: Vec::new(),
        predicted_gain: promise.gain,
        look_elsewhere: true,
        sequential_time: true,
        estimated_on_held_out: Some(first),
    }))
}

/// When stays on the ground begin in the recordings kept out \[s\], the last first, each a
/// while before the next: beginnings that are closer are those of one instant, the
/// first of them.
fn held_out_stays(stand: &ModelState) -> Vec<f64> {
    let Some(held) = &stand.held_out else {
        return Vec::new();
    };
    let segments = held.point.segments.iter().filter(|s| s.starts_held);
    let begin = |s: &Segment| {
        let time = &held.problem.data[s.recording].recording.time;
        s.since.unwrap_or(time[s.samples.start]) - 0.5 * s.interval
    };
    let mut all: Vec<f64> = segments.map(begin).collect();
    all.sort_by(f64::total_cmp);
    all.dedup_by(|later, earlier| *later - *earlier < WHILE);
    all.reverse();
    all
}

fn from_form(
    form: &CatalogueDirection,
    all: &[CatalogueDirection],
    theta: f64,
    gain: f64,
) -> Hypothesis {
    let most = match form.strength_id().as_str() {
        DELAY => MOST_DELAY,
        _ => MOST,
    };
    let theta = if form.signed {
        theta.clamp(-most, most)
    } else {
        theta.clamp(form.least() / form.values[form.strength], most)
    };
    let mut bounds = Vec::new();
    if !form.signed {
        bounds.push((form.strength_id(), (form.least(), f64::INFINITY)));
    }
    // A slow effect that is free to be quick would pass for another: constants stay near
    // what was looked at.
    let own = |i: usize| {
        let same = all.iter().filter(|f| f.spec == form.spec);
        same.map(move |f| f.values[i]).filter(|v| *v > 0.0)
    };
    for &i in form.free.iter().filter(|i| **i != form.strength) {
        let low = (own(i).fold(f64::INFINITY, f64::min) / NEAR).max(form.least_constant);
        let high = own(i).fold(0.0, f64::max) * NEAR;
        if low < high {
            let id = format!("{}.{}", form.spec.id, form.spec.parameters[i].id);
            bounds.push((id, (low, high)));
        }
    }
    if form.spec.id == "long_range_attraction" {
        bounds.push((format!("{}.n", form.spec.id), EXPONENTS));
    }
    let start = form.effect(theta);
    let full = form.full.as_ref().map(|(values, free)| {
        let values = values.clone();
        let spec = form.spec;
        (ActiveEffect { spec, values }, own_ids(spec, free))
    });
    Hypothesis {
        start,
        alternative_starts: Vec::new(),
        free: form.free_ids(),
        cold_start: full,
        shape: own_ids(form.spec, form.shape),
        bounds,
        predicted_gain: gain,
        look_elsewhere: false,
        sequential_time: false,
        estimated_on_held_out: None,
    }
}
