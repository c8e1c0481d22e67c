//! The sealed trial: recordings with a concealed effect, the person's guess, the diagnosis,
//! and the envelope that holds the truth. A diagnosis sees only the recordings.

use std::collections::BTreeSet;
use std::sync::Arc;

use eframe::egui::Context;
use serde::{Deserialize, Serialize};

use super::diagnosis_answer::Answer;
use super::job::Job;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::overlay::OverlayId;
use crate::diagnose::report::words::{effect_name, listed};
use crate::diagnose::{Diagnosis, Verdict};
use crate::trial::score::Mark;
use crate::trial::{Case, Class, Envelope, Mix, Recordings, Settings, StructureKind, Truth, score};

/// What may be concealed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Level {
    /// One effect of the catalogue.
    #[default]
    One,
    /// Two effects.
    Two,
    /// Nothing, one or two effects, or a law outside the catalogue.
    Anything,
}

impl Level {
    /// All, the easiest first.
    pub const ALL: [Self; 3] = [Self::One, Self::Two, Self::Anything];

    /// Its name in the window.
    pub fn text(self) -> &'static str {
        match self {
            Self::One => "one effect",
            Self::Two => "two effects",
            Self::Anything => "anything, or nothing",
        }
    }

    fn mix(self) -> Mix {
        match self {
            Self::One => Mix::Only(Class::One),
            Self::Two => Mix::Only(Class::Two),
            Self::Anything => Mix::Standard,
        }
    }
}

/// The person's guess of what is concealed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Guess {
    /// Nothing is concealed.
    Nothing,
    /// Something outside the catalogue.
    Unknown,
    /// These effects of the catalogue.
    Effects(BTreeSet<String>),
    /// These effects and something outside the catalogue.
    Partly(BTreeSet<String>),
}

impl Guess {
    /// A guess of these effects, with something outside the catalogue if `and_more`; `None` of nothing
    /// at all.
    pub fn of(effects: BTreeSet<String>, and_more: bool) -> Option<Self> {
        match (effects.is_empty(), and_more) {
            (true, true) => Some(Self::Unknown),
            (true, false) => None,
            (false, true) => Some(Self::Partly(effects)),
            (false, false) => Some(Self::Effects(effects)),
        }
    }

    /// Whether something outside the catalogue is guessed, alone or with effects.
    pub fn is_unknown_in_part(&self) -> bool {
        matches!(self, Self::Unknown | Self::Partly(_))
    }

    /// The effects guessed.
    pub fn effects(&self) -> BTreeSet<String> {
        match self {
            Self::Nothing | Self::Unknown => BTreeSet::new(),
            Self::Effects(ids) | Self::Partly(ids) => ids.clone(),
        }
    }

    /// The answer of a diagnosis that says the same.
    pub fn verdict(&self) -> Verdict {
        match self {
            Self::Nothing => Verdict::Adequate,
            Self::Unknown => Verdict::Unexplained,
            Self::Effects(_) => Verdict::MissingPhysics,
            Self::Partly(_) => Verdict::PartlyExplained,
        }
    }

    /// In a few words.
    pub fn text(&self) -> String {
        let ids = self.effects();
        let names: Vec<&str> = ids.iter().map(|id| effect_name(id)).collect();
        in_words(self.verdict(), &names)
    }
}

/// Trials opened so far, and how many answers were right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Tally {
    /// Right guesses, and number of guesses.
    pub person: (usize, usize),
    /// Right diagnoses, and number of diagnoses.
    pub tool: (usize, usize),
}

/// The contents of an open envelope.
#[derive(Debug, Clone)]
pub struct Opened {
    /// What was concealed.
    pub truth: Truth,
    /// Whether the hash of the text is the seal shown at the start.
    pub seal_holds: bool,
    /// Mark of the diagnosis, if there was one.
    pub tool: Option<Mark>,
    /// Mark of the guess, if there was one.
    pub person: Option<Mark>,
}

/// The person's own setup and answers, restored after the trial.
#[derive(Debug, Clone)]
pub(crate) struct Own {
    pub(crate) setup: Setup,
    pub(crate) automatic: Option<Arc<Answer>>,
    pub(crate) by_hand: Option<Arc<Answer>>,
}

/// What a trial is drawn from: the same draw gives the same trial.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Draw {
    /// Its seed.
    pub seed: u64,
    /// What may be concealed.
    pub level: Level,
    /// Whether the device is a beam. A further mode then belongs to the device itself.
    pub beam: bool,
    /// Rms of the measurement noise \[m\].
    pub noise: f64,
}

/// A trial in a session, before it is drawn again. What it conceals is in no file: the draw and
/// the seal are enough.
#[derive(Debug, Clone)]
pub(crate) struct Suspended {
    pub(crate) draw: Draw,
    pub(crate) seal: String,
    pub(crate) guess: Option<Guess>,
    /// Marks of the diagnosis and of the guess, if the envelope was open.
    pub(crate) marks: Option<(Option<Mark>, Option<Mark>)>,
    /// Device, drive and settings of the recordings in the trial; their data are drawn again.
    /// `None` if they could not be read.
    pub(crate) setup: Option<Setup>,
    pub(crate) automatic: Option<Arc<Answer>>,
    pub(crate) by_hand: Option<Arc<Answer>>,
}

/// A running trial.
#[derive(Debug, Clone)]
pub struct Sealed {
    /// What it was drawn from.
    pub draw: Draw,
    /// SHA-256 of the truth.
    pub seal: String,
    /// The person's guess.
    pub guess: Option<Guess>,
    /// The envelope's contents, once it is open.
    pub opened: Option<Opened>,
    pub(crate) envelope: Envelope,
    pub(crate) recordings: Vec<OverlayId>,
    pub(crate) own: Box<Own>,
}

/// A generated trial: recordings, envelope, and what they were drawn from.
pub(crate) type Made = (Recordings, Envelope, Draw);

/// State of the sealed trial.
#[derive(Debug, Clone)]
pub struct Trial {
    /// Whether its window is open.
    pub open: bool,
    /// The seed as typed.
    pub seed: String,
    /// What may be concealed.
    pub level: Level,
    /// Whether the device is a distributed beam.
    pub beam: bool,
    /// Rms of the measurement noise \[m\].
    pub noise: f64,
    /// The trial being generated.
    pub making: Option<Job<(), Made>>,
    /// Why none could be generated.
    pub error: Option<String>,
    /// The trial of a session that was opened, until it is drawn again.
    pub(crate) suspended: Option<Box<Suspended>>,
    /// The running trial.
    pub sealed: Option<Sealed>,
    /// Results so far.
    pub tally: Tally,
}

impl Default for Trial {
    fn default() -> Self {
        Self {
            open: false,
            seed: String::new(),
            level: Level::One,
            beam: false,
            noise: Settings::default().noise,
            making: None,
            error: None,
            suspended: None,
            sealed: None,
            tally: Tally::default(),
        }
    }
}

impl Trial {
    /// The typed seed; a random one if nothing is typed.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn seed(&self) -> Result<u64, String> {
        let text = self.seed.trim();
        if text.is_empty() {
            return Ok(u64::from(rand::random::<u32>()));
        }
        text.parse().map_err(|_| {
            format!("\"{text}\" is not a seed: type a whole number, or nothing for a random seed")
        })
    }

    /// Starts generating a trial.
    pub fn conceal(&mut self, context: &Context) {
        self.error = None;
        let seed = match self.seed() {
            Ok(seed) => seed,
            Err(error) => {
                self.error = Some(error);
                return;
            }
        };
        self.draw(
            Draw {
                seed,
                level: self.level,
                beam: self.beam,
                noise: self.noise,
            },
            context,
        );
    }

    /// Whether a trial is being drawn, or is to be drawn again.
    pub(crate) fn has_begun(&self) -> bool {
        self.making.is_some() || self.suspended.is_some()
    }

    /// Starts drawing the trial of a session again.
    pub(crate) fn resume(&mut self, context: &Context) {
        if let Some(suspended) = self.suspended.as_ref().filter(|_| self.making.is_none()) {
            self.draw(suspended.draw, context);
        }
    }

    fn draw(&mut self, draw: Draw, context: &Context) {
        let kind = if draw.beam {
            StructureKind::Beam
        } else {
            StructureKind::Lumped
        };
        let settings = Settings {
            structure: Some(kind),
            noise: draw.noise,
            mix: draw.level.mix(),
            ..Settings::default()
        };
        self.making = Some(Job::start("trial", context, move |_| {
            let case = Case::draw(draw.seed, &settings).map_err(|error| error.to_string())?;
            let (recordings, envelope) = case.into_parts();
            Ok((recordings, envelope, draw))
        }));
    }
}

/// Whether a mark counts as right. The name of an indistinguishable effect does.
pub fn is_right(mark: Mark) -> bool {
    matches!(mark, Mark::Right | Mark::Group)
}

/// A guess in the form that is scored.
pub(crate) fn scored_form(guess: &Guess) -> score::Diagnosis {
    let nowhere = score::Misfit {
        rms: f64::NAN,
        chi2: f64::NAN,
    };
    let both = score::BeforeAfter {
        before: nowhere,
        after: nowhere,
    };
    score::Diagnosis {
        verdict: guess.verdict(),
        named: guess
            .effects()
            .into_iter()
            .map(|id| score::Named {
                id,
                probability: 1.0,
                confusion_group: Vec::new(),
                parameters: Vec::new(),
            })
            .collect(),
        places: Vec::new(),
        train: both,
        held_out: both,
        by_criterion: None,
    }
}

/// The answer of a diagnosis in a few words.
pub fn answer_text(diagnosis: &Diagnosis) -> String {
    let names: Vec<&str> = diagnosis.named.iter().map(|n| n.name.as_str()).collect();
    in_words(diagnosis.verdict, &names)
}

/// An answer, given by a person or by the diagnosis, in a few words.
fn in_words(verdict: Verdict, names: &[&str]) -> String {
    match verdict {
        Verdict::Adequate => "nothing".to_owned(),
        Verdict::Unexplained => "an effect outside the catalogue".to_owned(),
        Verdict::MissingPhysics => listed(names),
        Verdict::PartlyExplained => format!("{}; something else remains", listed(names)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::sealed_trial::*;
    use crate::diagnose::report::fixture;

    #[test]
    fn guesses_and_answers_are_said_alike() {
        let drag = || BTreeSet::from(["quadratic_drag".to_owned()]);
        for (guess, text) in [
            (Guess::of(drag(), false), "quadratic drag"),
            (
                Guess::of(drag(), true),
                "quadratic drag; something else remains",
            ),
            (
                Guess::of(BTreeSet::new(), true),
                "an effect outside the catalogue",
            ),
            (Some(Guess::Nothing), "nothing"),
        ] {
            let guess = guess.unwrap();
            assert_eq!(guess.text(), text);
            assert_eq!(scored_form(&guess).verdict, guess.verdict());
        }
        assert_eq!(Guess::of(BTreeSet::new(), false), None);
        assert_eq!(
            answer_text(&fixture::partly()),
            "quadratic drag; something else remains"
        );
        assert_eq!(answer_text(&fixture::adequate()), "nothing");
    }
}
