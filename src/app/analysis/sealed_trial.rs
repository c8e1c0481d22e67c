//! The sealed trial: recordings that conceal an effect, a guess, the answer of the tool,
//! and the envelope. The truth stays in its envelope until that is opened; a diagnosis
//! sees the recordings alone.

use std::collections::BTreeSet;
use std::sync::Arc;

use eframe::egui::Context;
use sha2::{Digest, Sha256};

use super::diagnosis::Answer;
use super::job::Job;
use crate::app::files::built_in;
use crate::app::flows::load_example;
use crate::app::setup::setup::{OverlayId, Setup};
use crate::app::state::State;
use crate::diagnose::diagnosis::Diagnosis;
use crate::model::preset::Preset;
use crate::trial::draw::{Case, Mix, Recordings, Settings};
use crate::trial::instrument::StructureKind;
use crate::trial::score;
use crate::trial::score::{Mark, score};
use crate::trial::truth::{Class, Envelope, Truth};

/// What may be concealed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
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

    /// For people.
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

/// What a person believes is concealed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Guess {
    /// Nothing was left out.
    Nothing,
    /// Something that the catalogue does not have.
    Unknown,
    /// These effects of the catalogue.
    Effects(BTreeSet<String>),
}

/// Trials opened so far, and how many of them were told right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Guesses that were right, of how many.
    pub person: (usize, usize),
    /// Diagnoses that were right, of how many.
    pub tool: (usize, usize),
}

/// What an open envelope shows.
#[derive(Debug, Clone)]
pub struct Opened {
    /// What was concealed.
    pub truth: Truth,
    /// Whether the text's hash is the seal that was shown at first.
    pub seal_holds: bool,
    /// Mark of the tool's answer, if there was one.
    pub tool: Option<Mark>,
    /// Mark of the guess, if there was one.
    pub person: Option<Mark>,
}

/// What was put aside for a trial.
#[derive(Debug, Clone)]
struct Own {
    setup: Setup,
    automatic: Option<Arc<Answer>>,
    by_hand: Option<Arc<Answer>>,
}

/// A trial whose recordings are loaded.
#[derive(Debug, Clone)]
pub struct Sealed {
    /// Its seed.
    pub seed: u64,
    /// SHA-256 of the truth.
    pub seal: String,
    /// What the person believes.
    pub guess: Option<Guess>,
    /// The envelope's contents, once it is open.
    pub opened: Option<Opened>,
    /// Whether the device is a beam, to which a further mode belongs.
    beam: bool,
    envelope: Envelope,
    recordings: Vec<OverlayId>,
    own: Box<Own>,
}

/// Recordings and envelope of a trial that was made: its seed, and whether it is a beam.
type Made = (Recordings, Envelope, u64, bool);

/// The sealed trial's state.
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
    /// Rms of the readings' noise \[m\].
    pub noise: f64,
    /// The trial that is being made.
    pub making: Option<Job<(), Made>>,
    /// Why none could be made.
    pub error: Option<String>,
    /// The one that is on.
    pub sealed: Option<Sealed>,
    /// How it has gone so far.
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
            sealed: None,
            tally: Tally::default(),
        }
    }
}

impl Trial {
    /// The seed that is typed; one by chance if none is.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn seed(&self) -> Result<u64, String> {
        let text = self.seed.trim();
        if text.is_empty() {
            return Ok(u64::from(rand::random::<u32>()));
        }
        text.parse().map_err(|_| {
            format!("\"{text}\" is no seed: type a whole number, or nothing for one by chance")
        })
    }

    /// Starts making a trial.
    pub fn conceal(&mut self, context: &Context) {
        self.error = None;
        let seed = match self.seed() {
            Ok(seed) => seed,
            Err(error) => {
                self.error = Some(error);
                return;
            }
        };
        let kind = if self.beam {
            StructureKind::Beam
        } else {
            StructureKind::Lumped
        };
        let settings = Settings {
            structure: Some(kind),
            noise: self.noise,
            mix: self.level.mix(),
            ..Settings::default()
        };
        let beam = self.beam;
        self.making = Some(Job::start("trial", context, move |_| {
            let case = Case::draw(seed, &settings).map_err(|error| error.to_string())?;
            let (recordings, envelope) = case.into_parts();
            Ok((recordings, envelope, seed, beam))
        }));
    }
}

/// Takes a trial that was made, and notices one whose recordings were taken back.
pub(crate) fn poll(state: &mut State, last: &mut OverlayId) {
    if let Some(made) = state.diagnosing.trial.making.as_ref().and_then(Job::take) {
        state.diagnosing.trial.making = None;
        match made {
            Ok(made) => begin(state, made, last),
            Err(error) => state.diagnosing.trial.error = Some(error),
        }
    }
    let trial = &mut state.diagnosing.trial;
    let there = |sealed: &Sealed| {
        let overlays = &state.setup.overlays;
        overlays.iter().any(|o| sealed.recordings.contains(&o.id))
    };
    if trial.sealed.as_ref().is_some_and(|sealed| !there(sealed)) {
        // Undone: what was the person's own is back by that already.
        trial.sealed = None;
    }
}

/// Loads a trial's recordings in place of the person's own, which are put aside.
fn begin(state: &mut State, (recordings, envelope, seed, beam): Made, last: &mut OverlayId) {
    end(state);
    let setup = built_in::from_preset(Preset::default());
    let own = Box::new(Own {
        setup: std::mem::replace(&mut state.setup, setup),
        automatic: state.diagnosing.automatic.take(),
        by_hand: state.diagnosing.by_hand.take(),
    });
    state.diagnosing.picked = None;
    state.diagnosing.error = None;
    if let Some(running) = state.diagnosing.running.take() {
        running.job.cancel();
    }
    let ids = load_example::add(&mut state.setup, recordings, false, last);
    state.selected = None;
    state.diagnosing.trial.sealed = Some(Sealed {
        seed,
        seal: envelope.seal().to_owned(),
        guess: None,
        opened: None,
        beam,
        envelope,
        recordings: ids,
        own,
    });
}

/// Ends the trial: the person's own recordings, device and answers come back.
pub fn end(state: &mut State) {
    let Some(sealed) = state.diagnosing.trial.sealed.take() else {
        return;
    };
    if let Some(running) = state.diagnosing.running.take() {
        running.job.cancel();
    }
    let own = *sealed.own;
    state.setup = own.setup;
    state.selected = state.setup.overlays.first().map(|overlay| overlay.id);
    let diagnosing = &mut state.diagnosing;
    diagnosing.automatic = own.automatic;
    diagnosing.by_hand = own.by_hand;
    diagnosing.picked = None;
    diagnosing.error = None;
    if let Some(answer) = diagnosing.shown().cloned() {
        diagnosing.look.begin(&answer);
    }
}

/// The setup that is the person's own: a trial is no part of a session.
pub fn own_setup(state: &State) -> &Setup {
    match &state.diagnosing.trial.sealed {
        Some(sealed) => &sealed.own.setup,
        None => &state.setup,
    }
}

/// Opens the envelope: scores guess and answer, and adds them to the tally.
pub fn open(state: &mut State) {
    let diagnosing = &mut state.diagnosing;
    let answer = diagnosing.automatic.clone();
    let trial = &mut diagnosing.trial;
    let Some(sealed) = trial.sealed.as_mut().filter(|s| s.opened.is_none()) else {
        return;
    };
    let (truth, text) = sealed.envelope.clone().open();
    let hash: String = Sha256::digest(text.as_bytes())
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    let may_add: &[&str] = if sealed.beam { &["extra_mode"] } else { &[] };
    let mark = |said: &score::Diagnosis| score(&truth, said, may_add).mark;
    let tool = answer.map(|answer| mark(&score::Diagnosis::from(&answer.diagnosis)));
    let person = sealed.guess.as_ref().map(|guess| mark(&said(guess)));
    let count = |(right, of): &mut (usize, usize), mark: Option<Mark>| {
        *of += usize::from(mark.is_some());
        *right += usize::from(mark.is_some_and(is_right));
    };
    count(&mut trial.tally.tool, tool);
    count(&mut trial.tally.person, person);
    sealed.opened = Some(Opened {
        seal_holds: hash == sealed.seal,
        truth,
        tool,
        person,
    });
}

/// Whether a mark counts as right: also the name of one that cannot be told from it.
pub fn is_right(mark: Mark) -> bool {
    matches!(mark, Mark::Right | Mark::Group)
}

/// A guess as it is scored.
fn said(guess: &Guess) -> score::Diagnosis {
    use crate::trial::score::score::Verdict;
    let nowhere = score::Misfit {
        rms: f64::NAN,
        chi2: f64::NAN,
    };
    let both = score::BeforeAfter {
        before: nowhere,
        after: nowhere,
    };
    let (verdict, ids) = match guess {
        Guess::Nothing => (Verdict::Adequate, BTreeSet::new()),
        Guess::Unknown => (Verdict::Unexplained, BTreeSet::new()),
        Guess::Effects(ids) => (Verdict::MissingPhysics, ids.clone()),
    };
    score::Diagnosis {
        verdict,
        named: ids
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

/// What a diagnosis answers in a few words.
pub fn answer_text(diagnosis: &Diagnosis) -> String {
    use crate::diagnose::diagnosis::Verdict;
    let names: Vec<&str> = diagnosis.named.iter().map(|n| n.name.as_str()).collect();
    match diagnosis.verdict {
        Verdict::Adequate => "nothing was left out".to_owned(),
        Verdict::Unexplained => "something that the catalogue does not have".to_owned(),
        Verdict::MissingPhysics => crate::diagnose::report::words::listed(&names),
    }
}
