//! The tasks of steps, read and checked.

use std::collections::BTreeMap;

use toml::Spanned;

use super::error::{LessonError, Source};
use super::file::{
    CandidateEntry, ChoiceEntry, ConcealedEntry, CurveEntry, ExploreEntry, FitEntry, MarkEntry,
    Quantity, StepEntry,
};
use super::named::{
    check_name, controls, effect_with, parameter_value, quantity, range, set, some_controls,
    text_of,
};
use super::{
    Candidate, Choice, Claim, Concealed, CurveTask, Explore, HandFit, Level, Mark, MarkAxis,
    Relation, Task,
};
use crate::learn::expression::Expression;
use crate::learn::run::Scene;
use crate::learn::text::unit_scale;

/// Points of a drawn curve.
const CURVE_POINTS: (usize, usize) = (3, 40);
/// What stands in place of an effect where nothing is concealed.
const NOTHING: &str = "nothing";
/// What stands for the right side of the goal in the text of its task.
const GOAL_NAME: &str = "{goal";
/// Largest noise of a made recording \[m\].
const MAX_NOISE: f64 = 1.0;

/// The task of a step that begins at byte `at`.
pub(super) fn read_task(
    source: &Source<'_>,
    scene: &Scene,
    step: &StepEntry,
    at: usize,
) -> Result<Task, LessonError> {
    let count = [
        step.choice.is_some(),
        step.mark.is_some(),
        step.curve.is_some(),
        step.explore.is_some(),
        step.fit.is_some(),
        step.concealed.is_some(),
    ];
    if count.into_iter().filter(|is_there| *is_there).count() > 1 {
        let reason = "a step has one task; write choice, mark, curve, explore, fit or concealed, not several";
        return Err(source.fault(at, reason));
    }
    if let Some(choice) = &step.choice {
        return Ok(Task::Choice(read_choice(source, scene, choice.get_ref())?));
    }
    if let Some(mark) = &step.mark {
        return Ok(Task::Mark(read_mark(source, scene, mark.get_ref())?));
    }
    if let Some(curve) = &step.curve {
        return Ok(Task::Curve(read_curve(source, scene, curve.get_ref())?));
    }
    if let Some(explore) = &step.explore {
        return Ok(Task::Explore(read_explore(source, scene, explore)?));
    }
    if let Some(fit) = &step.fit {
        return Ok(Task::Fit(read_fit(source, scene, fit)?));
    }
    if let Some(game) = &step.concealed {
        return Ok(Task::Concealed(read_concealed(source, scene, game)?));
    }
    Ok(Task::Watch)
}

fn read_choice(
    source: &Source<'_>,
    scene: &Scene,
    entry: &ChoiceEntry,
) -> Result<Choice, LessonError> {
    let options = entry.options.iter().map(|o| text_of(source, scene, o));
    let options = options.collect::<Result<Vec<_>, _>>()?;
    let right = *entry.right.get_ref();
    if options.len() < 2 || !(1..=options.len()).contains(&right) {
        let reason = format!(
            "right is the number of the right option, 1 to {} (write at least 2 options)",
            options.len()
        );
        return Err(source.fault(entry.right.span().start, reason));
    }
    Ok(Choice {
        question: text_of(source, scene, &entry.question)?,
        options,
        right: right - 1,
        check: claim(source, scene, &entry.check)?,
        because: text_of(source, scene, &entry.because)?,
    })
}

fn expression(
    source: &Source<'_>,
    scene: &Scene,
    text: &str,
    at: usize,
) -> Result<Expression, LessonError> {
    let read = Expression::parse(text).map_err(|error| source.fault(at, error.to_string()))?;
    read.each_name(&mut |id| check_name(source, scene, id, at))?;
    Ok(read)
}

/// A claim such as `impact_speed(2) < 0.8 * impact_speed(1)`.
fn claim(source: &Source<'_>, scene: &Scene, text: &Spanned<String>) -> Result<Claim, LessonError> {
    let at = text.span().start;
    let signs = [
        ('<', Relation::Less),
        ('>', Relation::Greater),
        ('~', Relation::Near),
    ];
    let found = signs.into_iter().find_map(|(sign, relation)| {
        let (left, right) = text.get_ref().split_once(sign)?;
        Some((left, relation, right))
    });
    let Some((left, relation, right)) = found else {
        let reason = "a check compares two expressions with <, > or ~ (equal within 5 %), for example \"impacts > 3\"";
        return Err(source.fault(at, reason));
    };
    Ok(Claim {
        source: text.get_ref().clone(),
        left: expression(source, scene, left, at)?,
        relation,
        right: expression(source, scene, right, at)?,
    })
}

fn read_mark(source: &Source<'_>, scene: &Scene, entry: &MarkEntry) -> Result<Mark, LessonError> {
    let of = expression(source, scene, entry.of.get_ref(), entry.of.span().start)?;
    let unit = entry.unit.get_ref();
    let Some((factor, base)) = unit_scale(unit) else {
        let reason = format!("\"{unit}\" is no unit; write for example ms, um, mm/s or Hz");
        return Err(source.fault(entry.unit.span().start, reason));
    };
    let (low, high) = *entry.range.get_ref();
    if !(low < high && low.is_finite() && high.is_finite()) {
        let reason = "a range is two finite numbers in the unit of the mark, the lower one first";
        return Err(source.fault(entry.range.span().start, reason));
    }
    let tolerance = *entry.tolerance.get_ref();
    if !(tolerance > 0.0 && tolerance <= high - low) {
        let reason = "the tolerance is above 0 and at most the range, in the unit of the mark";
        return Err(source.fault(entry.tolerance.span().start, reason));
    }
    let axis = match entry
        .axis
        .as_ref()
        .map(|axis| (axis.get_ref().as_str(), axis))
    {
        None | Some(("own", _)) => MarkAxis::Own,
        Some(("time", _)) if base == "s" => MarkAxis::Time,
        Some(("displacement", _)) if base == scene.preset.model.coordinate.base_unit() => {
            MarkAxis::Displacement
        }
        Some((_, axis)) => {
            let reason = "the axis is own, time (a mark in s) or displacement (a mark in m)";
            return Err(source.fault(axis.span().start, reason));
        }
    };
    Ok(Mark {
        question: text_of(source, scene, &entry.question)?,
        of,
        label: entry.label.clone(),
        axis,
        unit: (unit.clone(), factor),
        range: (low * factor, high * factor),
        tolerance: tolerance * factor,
        because: text_of(source, scene, &entry.because)?,
    })
}

fn read_curve(
    source: &Source<'_>,
    scene: &Scene,
    entry: &CurveEntry,
) -> Result<CurveTask, LessonError> {
    let points = *entry.points.get_ref();
    if !(CURVE_POINTS.0..=CURVE_POINTS.1).contains(&points) {
        let reason = format!(
            "a curve has {} to {} points, not {points}",
            CURVE_POINTS.0, CURVE_POINTS.1
        );
        return Err(source.fault(entry.points.span().start, reason));
    }
    let (low, high) = entry.range.get_ref();
    let unit = scene.preset.model.coordinate.base_unit();
    Ok(CurveTask {
        question: text_of(source, scene, &entry.question)?,
        points,
        range: range(source, (low, high), unit, entry.range.span().start)?,
        because: text_of(source, scene, &entry.because)?,
    })
}

fn read_explore(
    source: &Source<'_>,
    scene: &Scene,
    entry: &Spanned<ExploreEntry>,
) -> Result<Explore, LessonError> {
    let (at, entry) = (entry.span().start, entry.get_ref());
    let goal = entry.goal.as_ref().map(|goal| claim(source, scene, goal));
    let goal = goal.transpose()?;
    let mut task = entry.task.clone();
    if let Some(goal) = &goal {
        // The text then says what the goal asks for.
        let right = format!("{{({})", goal.right);
        *task.get_mut() = task.get_ref().replace(GOAL_NAME, &right);
    }
    Ok(Explore {
        task: text_of(source, scene, &task)?,
        controls: some_controls(source, scene, &entry.controls, at)?,
        goal,
    })
}

fn noise(source: &Source<'_>, scene: &Scene, of: &Spanned<Quantity>) -> Result<f64, LessonError> {
    let noise = quantity(source, of, scene.preset.model.coordinate.base_unit())?;
    if noise > 0.0 && noise < MAX_NOISE {
        return Ok(noise);
    }
    let reason = "the noise is above 0: the score counts in it; write for example \"50 nm\"";
    Err(source.fault(of.span().start, reason))
}

fn read_fit(
    source: &Source<'_>,
    scene: &Scene,
    entry: &Spanned<FitEntry>,
) -> Result<HandFit, LessonError> {
    let (at, entry) = (entry.span().start, entry.get_ref());
    let controls = some_controls(source, scene, &entry.controls, at)?;
    let truth = values(source, scene, &entry.truth)?;
    for (id, _) in &truth {
        if !controls.iter().any(|control| control.id == *id) {
            let at = entry.truth.get(id).map_or(at, |value| value.span().start);
            let reason = format!("{id} is no control of this fit: nobody could find its value");
            return Err(source.fault(at, reason));
        }
    }
    Ok(HandFit {
        task: text_of(source, scene, &entry.task)?,
        controls,
        truth,
        noise: noise(source, scene, &entry.noise)?,
    })
}

/// Values of parameters that a scene has.
fn values(
    source: &Source<'_>,
    scene: &Scene,
    entries: &BTreeMap<String, Spanned<Quantity>>,
) -> Result<Vec<(String, f64)>, LessonError> {
    let mut changed = scene.clone();
    let read = entries.iter().map(|(id, value)| {
        let number = parameter_value(source, &changed, id, value)?;
        let at = value.span().start;
        set(source, &mut changed, (id, at), number)?;
        let checked = changed.preset.model.check();
        checked.map_err(|error| source.fault(at, error.to_string()))?;
        Ok((id.clone(), number))
    });
    read.collect()
}

fn read_concealed(
    source: &Source<'_>,
    scene: &Scene,
    entry: &Spanned<ConcealedEntry>,
) -> Result<Concealed, LessonError> {
    let (at, entry) = (entry.span().start, entry.get_ref());
    let mut levels = Vec::new();
    for level in &entry.level {
        let own = level.get_ref();
        let candidates = own.candidate.iter().map(|c| candidate(source, scene, c));
        let candidates = candidates.collect::<Result<Vec<_>, _>>()?;
        if candidates.len() < 2 {
            let reason = "a level has at least two candidates; else there is nothing to find";
            return Err(source.fault(level.span().start, reason));
        }
        levels.push(Level {
            name: own.name.clone(),
            candidates,
        });
    }
    if levels.is_empty() {
        return Err(source.fault(at, "there is no level; write at least one"));
    }
    Ok(Concealed {
        task: text_of(source, scene, &entry.task)?,
        controls: controls(source, scene, &entry.controls)?,
        noise: noise(source, scene, &entry.noise)?,
        levels,
    })
}

fn candidate(
    source: &Source<'_>,
    scene: &Scene,
    entry: &Spanned<CandidateEntry>,
) -> Result<Candidate, LessonError> {
    let entry = entry.get_ref();
    let id = entry.effect.get_ref();
    if id == NOTHING {
        return Ok(Candidate {
            name: NOTHING.to_owned(),
            effect: None,
            values: Vec::new(),
            sign: entry.sign.clone(),
        });
    }
    let at = entry.effect.span().start;
    let effect = effect_with(source, scene, (id, at), &entry.set)?;
    let ids = effect.spec.parameters.iter().map(|p| p.id.to_owned());
    Ok(Candidate {
        name: effect.spec.name.to_owned(),
        effect: Some(id.clone()),
        values: ids.zip(effect.values.iter().copied()).collect(),
        sign: entry.sign.clone(),
    })
}
