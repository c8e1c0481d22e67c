//! All hypotheses with their predicted gains: the catalogue by the score test, a base vibration by
//! frequency, a step of the ground by time, a further mode by its spectral peak.

use super::base_vibration::{VibrationLine, find_vibration};
use super::extra_mode;
use super::level_step::{LevelStep, PROBE_RISE, find_level_steps, first_level_gain};
use crate::diagnose::comparison::hypothesis::Hypothesis;
use crate::diagnose::comparison::trial::ModelState;
use crate::diagnose::data::level_drift;
use crate::diagnose::options::DiagnoseError;
use crate::diagnose::score_test::forms::{
    CONSTANT_BOUND_FACTOR, CatalogueDirection, Scale, catalogue_directions,
};
use crate::diagnose::score_test::linearized::Linearized;
use crate::diagnose::score_test::scan::{ScoreGain, ScoreScan};
use crate::diagnose::shooting::latency::delay_absorbed_by_clocks;
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::thresholds::{RIVAL_LAW_MIN_SCORE_SHARE, SEARCHED_REFIT_MIN_SCORE};
use crate::fit::segment::Segment;
use crate::model::effects::{ActiveEffect, CATALOGUE, EffectSpec, own_ids};

/// Contacts that begin within this time may begin with the same step \[s\].
const SAME_INSTANT: f64 = 1e-3;
/// Largest initial strength of a refit, in units of its form's: the linearised problem knows the
/// direction and only a rough size.
const MAX_START_STRENGTH: f64 = 30.0;
/// The same for a delay, in proportion to which the readings move.
const MAX_START_DELAY: f64 = 300.0;

/// The largest predicted gain among the hypotheses of an effect.
fn best_predicted_gain(all: &[Hypothesis], spec: &EffectSpec) -> f64 {
    let own = all.iter().filter(|h| h.start.spec == spec);
    own.fold(0.0, |most, h| most.max(h.predicted_gain))
}

/// All hypotheses on what `state` lacks: the best law of each effect of the catalogue that is
/// asked, and those that are searched for over a time or a frequency.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn propose(
    workspace: &Workspace,
    state: &ModelState,
    is_asked: &dyn Fn(&EffectSpec) -> bool,
) -> Result<Vec<Hypothesis>, DiagnoseError> {
    let asked = |is_sought: fn(&EffectSpec) -> bool| {
        let mut all = CATALOGUE.iter().copied();
        all.find(|spec| is_sought(spec))
            .filter(|spec| is_asked(spec))
    };
    let model = &state.train.model;
    let linear = Linearized::new(&state.train)?;
    let mut out = laws_of_catalogue(state, &linear, is_asked)?;
    let every = out.clone();
    out.retain(|h| {
        h.predicted_gain >= RIVAL_LAW_MIN_SCORE_SHARE * best_predicted_gain(&every, h.start.spec)
    });
    let unmodelled = workspace.unmodelled_drift(model).cloned();
    if let Some((start, free)) = unmodelled.filter(|(start, _)| is_asked(start.spec)) {
        let gain = best_predicted_gain(&every, start.spec).max(SEARCHED_REFIT_MIN_SCORE);
        // Ahead of laws with the same predicted gain.
        out.insert(0, drift_of_level(start, free, gain));
    }
    if let Some(spec) = asked(EffectSpec::is_base_sinusoid)
        && let Some(line) = find_vibration(&linear, model, spec)?
    {
        out.push(vibration(spec, &line));
    }
    if let Some(spec) = asked(EffectSpec::is_level_step).filter(|_| model.has_ground) {
        let held_out = held_out_contact_times(state);
        for step in find_level_steps(&linear, model, 0, &workspace.epochs())? {
            out.push(level_step(spec, &step, &held_out));
        }
        out.extend(step_before_held_out(workspace, state, spec)?);
    }
    if let Some(spec) = asked(EffectSpec::adds_modes) {
        out.extend(extra_mode::extra_mode_hypothesis(workspace, state, spec)?);
    }
    Ok(out)
}

/// The best form of each law of the catalogue by the score test in the linearised problem. Laws
/// of one effect that differ in their strength parameter are proposed separately.
fn laws_of_catalogue(
    state: &ModelState,
    linear: &Linearized<'_>,
    is_asked: &dyn Fn(&EffectSpec) -> bool,
) -> Result<Vec<Hypothesis>, DiagnoseError> {
    let model = &state.train.model;
    let data = &state.train.problem.data;
    let heights = data.iter().flat_map(|d| &d.recording.proof_mass);
    let length = heights
        .filter(|x| x.is_finite())
        .fold(0.0f64, |a, x| a.max(x.abs()));
    let interval = data.iter().map(|d| d.recording.interval());
    let interval = interval.fold(f64::INFINITY, f64::min);
    let scale = Scale::new(model, length.max(1e-12), interval);
    let mut all = catalogue_directions(model, &scale);
    all.retain(|form| is_asked(form.spec));
    let scan = ScoreScan::new(linear, model, &all)?;
    let (delay, fall) = delay_absorbed_by_clocks(linear.problem(), &linear.point().x);
    let mut out: Vec<Hypothesis> = Vec::new();
    for (k, form) in all.iter().enumerate() {
        // Where a jump of the voltage meets a sample, the cost has a kink in the clock's skew
        // that no linearisation sees past. The delay that the clocks have absorbed is known
        // without one.
        let by_clocks = (fall > 0.0 && is_delay(form)).then(|| ScoreGain {
            gain: fall,
            theta: delay / form.values[form.strength],
        });
        let scores = scan.predicted_gain(k).into_iter().chain(by_clocks);
        let scores = scores.map(|score| admissible(form, score));
        let Some(score) = scores.max_by(|a, b| a.gain.total_cmp(&b.gain)) else {
            continue;
        };
        let gain = score.gain;
        let hypothesis = hypothesis_of_direction(form, &all, score.theta, gain);
        let same = |h: &&mut Hypothesis| h.start.spec == form.spec && h.free == hypothesis.free;
        match out.iter_mut().find(same) {
            Some(known) if known.predicted_gain >= gain => {}
            Some(known) => *known = hypothesis,
            None => out.push(hypothesis),
        }
    }
    Ok(out)
}

/// `score` of `form`, with no gain where the strength has the wrong sign or a lag would be
/// shorter than its form can represent.
fn admissible(form: &CatalogueDirection, score: ScoreGain) -> ScoreGain {
    let strength = score.theta * form.values[form.strength];
    let too_short = form.is_lag() && strength < form.min_strength();
    let gain = if too_short || score.theta < 0.0 && !form.signed {
        0.0
    } else {
        score.gain
    };
    ScoreGain { gain, ..score }
}

/// A drift of the zero as read from the level of the ground: `start`, of which `free` is fitted.
fn drift_of_level(start: ActiveEffect, free: Vec<String>, gain: f64) -> Hypothesis {
    let spec = start.spec;
    let near = |tau: f64| (tau / CONSTANT_BOUND_FACTOR, tau * CONSTANT_BOUND_FACTOR);
    Hypothesis {
        alternative_starts: Vec::new(),
        cold_start: Some((start.clone(), free.clone())),
        shape: level_drift::shape_parameters(spec, &free),
        bounds: vec![(own_ids(spec, &[1])[0].clone(), near(start.values[1]))],
        start,
        free,
        predicted_gain: gain,
        look_elsewhere: false,
        sequential_time: false,
        estimated_on_held_out: None,
    }
}

/// A vibration of the base at the frequency, amplitude and phase found by the search.
fn vibration(spec: &'static EffectSpec, line: &VibrationLine) -> Hypothesis {
    Hypothesis {
        start: ActiveEffect {
            spec,
            values: vec![line.amplitude, line.frequency, line.phase],
        },
        alternative_starts: Vec::new(),
        free: own_ids(spec, &[0, 1, 2]),
        cold_start: None,
        shape: Vec::new(),
        bounds: Vec::new(),
        predicted_gain: line.gain,
        look_elsewhere: true,
        sequential_time: false,
        estimated_on_held_out: None,
    }
}

/// A step of the ground's level. Its time is not determined between the last contact before it
/// and the first after it; the start times of contacts in the held-out recordings (`held_out`,
/// \[s\]) within that interval are alternatives.
fn level_step(spec: &'static EffectSpec, step: &LevelStep, held_out: &[f64]) -> Hypothesis {
    let at = |time: f64| ActiveEffect {
        spec,
        values: vec![PROBE_RISE * step.height, time],
    };
    // Only for a step at the same time in each recording: in a sequence, held-out recordings
    // come later.
    let open = |t: &&f64| !step.sequential_time && **t > step.since && **t < step.time;
    let alternatives = held_out.iter().filter(open);
    Hypothesis {
        start: at(step.time),
        alternative_starts: alternatives.map(|t| (at(*t), Vec::new())).collect(),
        free: own_ids(spec, &[0]),
        cold_start: None,
        shape: Vec::new(),
        bounds: Vec::new(),
        predicted_gain: step.gain,
        look_elsewhere: true,
        sequential_time: step.sequential_time,
        estimated_on_held_out: None,
    }
}

/// A step of the ground between the fitted and the held-out recordings. Its height is determined
/// by the first held-out recording with contacts.
fn step_before_held_out(
    workspace: &Workspace,
    state: &ModelState,
    spec: &'static EffectSpec,
) -> Result<Option<Hypothesis>, DiagnoseError> {
    let Some(held) = &state.held_out else {
        return Ok(None);
    };
    let linear = Linearized::new(held)?;
    let Some((first, score)) = first_level_gain(&linear, &held.model)? else {
        return Ok(None);
    };
    Ok(Some(Hypothesis {
        start: ActiveEffect {
            spec,
            values: vec![PROBE_RISE * score.theta, workspace.fitted_duration()],
        },
        alternative_starts: Vec::new(),
        free: own_ids(spec, &[0]),
        cold_start: None,
        shape: Vec::new(),
        bounds: Vec::new(),
        predicted_gain: score.gain,
        look_elsewhere: true,
        sequential_time: true,
        estimated_on_held_out: Some(first),
    }))
}

/// Start times of contacts in the held-out recordings \[s\], latest first. Of contacts that begin
/// within [`SAME_INSTANT`], the first is kept.
fn held_out_contact_times(state: &ModelState) -> Vec<f64> {
    let Some(held) = &state.held_out else {
        return Vec::new();
    };
    let segments = held.point.segments.iter().filter(|s| s.starts_held);
    let begin = |s: &Segment| {
        let time = &held.problem.data[s.recording].recording.time;
        s.since.unwrap_or(time[s.samples.start]) - 0.5 * s.interval
    };
    let mut all: Vec<f64> = segments.map(begin).collect();
    all.sort_by(f64::total_cmp);
    all.dedup_by(|later, earlier| *later - *earlier < SAME_INSTANT);
    all.reverse();
    all
}

/// Whether the strength of a form delays the readings as a whole.
fn is_delay(form: &CatalogueDirection) -> bool {
    form.spec.facts.reading_delay == Some(form.strength)
}

/// The hypothesis of a catalogue direction, started at `theta` times its strength, with bounds
/// from all forms of the effect.
pub(super) fn hypothesis_of_direction(
    form: &CatalogueDirection,
    all: &[CatalogueDirection],
    theta: f64,
    gain: f64,
) -> Hypothesis {
    let most = if is_delay(form) {
        MAX_START_DELAY
    } else {
        MAX_START_STRENGTH
    };
    let theta = if form.signed {
        theta.clamp(-most, most)
    } else {
        theta.clamp(form.min_strength() / form.values[form.strength], most)
    };
    let start = form.effect(theta);
    let cold_start = form.cold_start.as_ref().map(|(values, free)| {
        let values = values.clone();
        let spec = form.spec;
        (ActiveEffect { spec, values }, own_ids(spec, free))
    });
    Hypothesis {
        start,
        alternative_starts: Vec::new(),
        free: form.free_ids(),
        cold_start,
        shape: own_ids(form.spec, form.shape),
        bounds: form.bounds(all),
        predicted_gain: gain,
        look_elsewhere: false,
        sequential_time: false,
        estimated_on_held_out: None,
    }
}
