//! A lesson read from its text and checked: what it names must exist, and what it says can be read.

use toml::Spanned;

use super::error::{LessonError, Source};
use super::file::{FORMAT, File, SetupEntry, StepEntry};
use super::named::{
    effect_with, parameter_value, picture, preset, preset_names, quantity, set, text_of,
};
use super::tasks::read_task;
use super::{Lesson, LessonPicture, Step};
use crate::learn::run::Scene;
use crate::model::drive::Waveform;
use crate::model::preset::toml_fault::TomlFault;

/// Longest span of a scene \[s\].
const MAX_DURATION: f64 = 1000.0;
/// Slowest and fastest play, simulated seconds per second.
const SPEED_RANGE: (f64, f64) = (1e-5, 10.0);
/// Characters that an id may have, so that it is a name in a file of answers.
const MAX_ID_LENGTH: usize = 60;

/// A scene with how it is shown.
#[derive(Clone)]
pub(super) struct Shown {
    pub(super) scene: Scene,
    speed: f64,
    pictures: Vec<LessonPicture>,
}

/// Whether a text is that of a lesson, sound or not: it has a step.
pub fn is_lesson_text(text: &str) -> bool {
    text.lines()
        .any(|line| line.trim_start().starts_with("[[step]]"))
}

impl Lesson {
    /// Reads the text of a lesson; `file` is named in errors.
    ///
    /// # Errors
    /// [`LessonError`] with line, column and reason, at the first thing that cannot be used.
    ///
    /// # Examples
    /// ```
    /// use impactscope::learn::lesson::Lesson;
    ///
    /// let text = "format = 1\nid = \"a\"\ntitle = \"A\"\nabout = \"b\"\n[setup]\npreset = \"papper\"";
    /// let error = Lesson::parse("mine.toml", text).unwrap_err();
    /// assert_eq!((error.line, error.column), (6, 10));
    /// assert!(error.reason.contains("papper"));
    /// ```
    pub fn parse(file: &str, text: &str) -> Result<Self, LessonError> {
        let source = Source { file, text };
        let read: File = toml::from_str(text).map_err(|error| {
            let fault = TomlFault::new(text, &error);
            LessonError {
                file: file.to_owned(),
                line: fault.line,
                column: fault.column,
                reason: fault.reason,
            }
        })?;
        check_head(&source, &read)?;
        let setup = read.setup.get_ref();
        let name = setup.preset.as_ref().ok_or_else(|| {
            source.fault(
                read.setup.span().start,
                format!("[setup] needs a preset; there are {}", preset_names()),
            )
        })?;
        let preset = preset(&source, name)?;
        let speed = usual_speed(preset.duration);
        let usual = Shown {
            scene: Scene::of_preset(preset),
            speed,
            pictures: vec![LessonPicture::Device, LessonPicture::Trajectory],
        };
        let shown = changed(&source, &usual, setup)?;
        check_model(&source, &shown, read.setup.span().start)?;
        if read.step.is_empty() {
            return Err(source.fault(
                text.len(),
                "there is no step; write at least one, beginning with [[step]]",
            ));
        }
        let steps = read
            .step
            .iter()
            .map(|step| read_step(&source, step, &shown));
        Ok(Self {
            id: read.id.get_ref().clone(),
            title: read.title.get_ref().clone(),
            about: read.about.clone(),
            minutes: read.minutes,
            steps: steps.collect::<Result<_, _>>()?,
        })
    }
}

fn check_head(source: &Source<'_>, read: &File) -> Result<(), LessonError> {
    let format = *read.format.get_ref();
    if format != FORMAT {
        let reason = format!("format {format} is not known; this program reads format {FORMAT}");
        return Err(source.fault(read.format.span().start, reason));
    }
    let id = read.id.get_ref();
    let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if id.is_empty() || id.len() > MAX_ID_LENGTH || !id.chars().all(is_plain) {
        let reason = format!(
            "the id \"{id}\" must be small letters, digits and hyphens, at most {MAX_ID_LENGTH}"
        );
        return Err(source.fault(read.id.span().start, reason));
    }
    if read.title.get_ref().trim().is_empty() {
        return Err(source.fault(read.title.span().start, "the title is empty; write one"));
    }
    Ok(())
}

/// A speed at which a span is watched: real time for seconds, slow motion for milliseconds.
pub(super) fn usual_speed(duration: f64) -> f64 {
    /// A whole run takes about this long \[s\].
    const USUAL_PLAY_TIME: f64 = 10.0;
    (duration / USUAL_PLAY_TIME).clamp(SPEED_RANGE.0, 1.0)
}

/// A scene with what an entry changes of it.
fn changed(source: &Source<'_>, from: &Shown, entry: &SetupEntry) -> Result<Shown, LessonError> {
    let mut shown = from.clone();
    if let Some(name) = &entry.preset {
        shown.scene = Scene::of_preset(preset(source, name)?);
        shown.speed = usual_speed(shown.scene.duration);
    }
    if let Some(duration) = &entry.duration {
        let span = quantity(source, duration, "s")?;
        if !(span > 0.0 && span <= MAX_DURATION) {
            let reason = format!("the duration must lie between 0 and {MAX_DURATION} s");
            return Err(source.fault(duration.span().start, reason));
        }
        shown.scene.duration = span;
        shown.speed = usual_speed(span);
    }
    if let Some(drive) = &entry.drive {
        let waveform = Waveform::parse(drive.get_ref(), shown.scene.duration);
        let waveform =
            waveform.map_err(|error| source.fault(drive.span().start, error.to_string()))?;
        let is_rest = waveform == Waveform::Rest;
        if shown.scene.preset.model.piezo.is_none() && !is_rest {
            let reason = "this device has no drive; leave the drive out, or take another preset";
            return Err(source.fault(drive.span().start, reason));
        }
        shown.scene.drive = waveform;
    }
    if let Some(speed) = &entry.speed {
        let value = *speed.get_ref();
        if !(value >= SPEED_RANGE.0 && value <= SPEED_RANGE.1) {
            let reason = format!(
                "the speed must lie between {} and {} simulated seconds a second, not {value}",
                SPEED_RANGE.0, SPEED_RANGE.1
            );
            return Err(source.fault(speed.span().start, reason));
        }
        shown.speed = value;
    }
    if let Some(pictures) = &entry.pictures {
        let found = pictures.iter().map(|name| picture(source, name));
        shown.pictures = found.collect::<Result<_, _>>()?;
    }
    for (id, values) in &entry.effects {
        let at = values.span().start;
        let effect = effect_with(source, &shown.scene, (id, at), values.get_ref())?;
        let effects = &mut shown.scene.preset.model.effects;
        effects.retain(|e| e.spec != effect.spec);
        effects.push(effect);
    }
    for (id, value) in &entry.set {
        let number = parameter_value(source, &shown.scene, id, value)?;
        set(source, &mut shown.scene, (id, value.span().start), number)?;
    }
    Ok(shown)
}

fn check_model(source: &Source<'_>, shown: &Shown, at: usize) -> Result<(), LessonError> {
    let checked = shown.scene.preset.model.check();
    checked.map_err(|error| source.fault(at, error.to_string()))
}

fn read_step(
    source: &Source<'_>,
    entry: &Spanned<StepEntry>,
    of_lesson: &Shown,
) -> Result<Step, LessonError> {
    let step = entry.get_ref();
    let shown = match &step.setup {
        Some(setup) => {
            let shown = changed(source, of_lesson, setup.get_ref())?;
            check_model(source, &shown, setup.span().start)?;
            shown
        }
        None => of_lesson.clone(),
    };
    let alt = text_of(source, &shown.scene, &step.alt)?;
    if alt.source().trim().is_empty() {
        let reason = "the alternative text is empty; say in words what the pictures show";
        return Err(source.fault(step.alt.span().start, reason));
    }
    Ok(Step {
        title: step.title.clone(),
        text: text_of(source, &shown.scene, &step.text)?,
        alt,
        task: read_task(source, &shown.scene, step, entry.span().start)?,
        scene: shown.scene,
        speed: shown.speed,
        pictures: shown.pictures,
    })
}
