//! The texts of a step with the numbers of its run.

use super::{Step, Task};
use crate::learn::run::Run;
use crate::learn::text::{Text, TextError};

/// The texts of a step as a pupil reads them.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Written {
    /// The idea.
    pub text: String,
    /// What the pictures show.
    pub alt: String,
    /// What is asked, or what to do.
    pub question: String,
    /// The answers of a choice.
    pub options: Vec<String>,
    /// Said after the run.
    pub because: String,
}

impl Step {
    /// Its texts, with the numbers of the run of its own scene.
    ///
    /// # Errors
    /// [`TextError`]: a measure that the run does not have, or a stated number that does not hold.
    pub fn written(&self, run: &Run) -> Result<Written, TextError> {
        let write = |text: &Text| text.written(&self.scene, run);
        let (question, options, because) = match &self.task {
            Task::Watch => (None, None, None),
            Task::Choice(choice) => (
                Some(&choice.question),
                Some(&choice.options),
                Some(&choice.because),
            ),
            Task::Mark(mark) => (Some(&mark.question), None, Some(&mark.because)),
            Task::Curve(curve) => (Some(&curve.question), None, Some(&curve.because)),
            Task::Explore(explore) => (Some(&explore.task), None, None),
            Task::Fit(fit) => (Some(&fit.task), None, None),
            Task::Concealed(game) => (Some(&game.task), None, None),
        };
        let one = |text: Option<&Text>| text.map_or(Ok(String::new()), write);
        Ok(Written {
            text: write(&self.text)?,
            alt: write(&self.alt)?,
            question: one(question)?,
            options: options
                .map_or(&[] as &[Text], Vec::as_slice)
                .iter()
                .map(write)
                .collect::<Result<_, _>>()?,
            because: one(because)?,
        })
    }
}
