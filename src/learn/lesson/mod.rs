//! A lesson: steps, each with a text, a scene and a task. One text file holds one lesson; see
//! `docs/lessons.md`.

mod error;
mod file;
mod named;
mod read;
mod tasks;
#[cfg(test)]
mod tests;
mod written;

use super::controls::Control;
use super::expression::Expression;
use super::run::Scene;
use super::text::Text;

pub use self::error::LessonError;
pub use self::read::is_lesson_text;
pub use self::written::Written;

/// A lesson.
#[derive(Debug, Clone, PartialEq)]
pub struct Lesson {
    /// By which progress is kept; unique among the lessons.
    pub id: String,
    /// Its title.
    pub title: String,
    /// One line on what it teaches.
    pub about: String,
    /// About how long it takes \[minutes\].
    pub minutes: u32,
    /// Its steps, at least one.
    pub steps: Vec<Step>,
}

/// A step of a lesson.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Its heading.
    pub title: String,
    /// One idea.
    pub text: Text,
    /// What the moving pictures show, for those who do not see them.
    pub alt: Text,
    /// What is simulated.
    pub scene: Scene,
    /// Simulated seconds per second in which it plays.
    pub speed: f64,
    /// What is drawn, from top to bottom.
    pub pictures: Vec<LessonPicture>,
    /// What the pupil does.
    pub task: Task,
}

/// A picture of a lesson.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LessonPicture {
    /// The device, moving.
    Device,
    /// The drive voltage against time.
    Voltage,
    /// Displacements against time.
    Trajectory,
    /// Forces against time.
    Forces,
    /// Bars of energies.
    Energy,
    /// Velocity against displacement.
    PhasePortrait,
    /// Displacement against voltage.
    DriveLoop,
}

impl LessonPicture {
    /// All.
    pub const ALL: [Self; 7] = [
        Self::Device,
        Self::Voltage,
        Self::Trajectory,
        Self::Forces,
        Self::Energy,
        Self::PhasePortrait,
        Self::DriveLoop,
    ];

    /// Name in a file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Device => "device",
            Self::Voltage => "voltage",
            Self::Trajectory => "trajectory",
            Self::Forces => "forces",
            Self::Energy => "energy",
            Self::PhasePortrait => "phase_portrait",
            Self::DriveLoop => "drive_loop",
        }
    }
}

/// What the pupil does in a step.
#[derive(Debug, Clone, PartialEq)]
pub enum Task {
    /// Reads, and watches.
    Watch,
    /// Predicts by choosing.
    Choice(Choice),
    /// Predicts by moving a mark.
    Mark(Mark),
    /// Predicts by drawing the curve.
    Curve(CurveTask),
    /// Explores with the named controls.
    Explore(Explore),
    /// Fits a recording by hand.
    Fit(HandFit),
    /// Finds what is concealed.
    Concealed(Concealed),
}

impl Task {
    /// Whether something is predicted before the run is seen.
    pub fn is_prediction(&self) -> bool {
        matches!(self, Self::Choice(_) | Self::Mark(_) | Self::Curve(_))
    }

    /// The controls that the pupil may move.
    pub fn controls(&self) -> &[Control] {
        match self {
            Self::Explore(explore) => &explore.controls,
            Self::Fit(fit) => &fit.controls,
            Self::Concealed(game) => &game.controls,
            _ => &[],
        }
    }
}

/// A question with answers to choose from.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// What is asked.
    pub question: Text,
    /// The answers, at least two.
    pub options: Vec<Text>,
    /// The right one, from 0.
    pub right: usize,
    /// What must hold of the run for it to be right.
    pub check: Claim,
    /// Said after the run.
    pub because: Text,
}

/// A statement about a run: two expressions and which is larger.
#[derive(Debug, Clone, PartialEq)]
pub struct Claim {
    /// As written.
    pub source: String,
    /// On the left.
    pub left: Expression,
    /// What is claimed.
    pub relation: Relation,
    /// On the right.
    pub right: Expression,
}

/// How two numbers compare.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Relation {
    /// The left one is smaller.
    Less,
    /// The left one is larger.
    Greater,
    /// They differ by less than 5 %.
    Near,
}

/// A mark that is moved to a value of the run.
#[derive(Debug, Clone, PartialEq)]
pub struct Mark {
    /// What is asked.
    pub question: Text,
    /// What the mark stands for.
    pub of: Expression,
    /// Name of that on the axis.
    pub label: String,
    /// Which axis it moves on.
    pub axis: MarkAxis,
    /// Unit in which it is shown, with its SI value.
    pub unit: (String, f64),
    /// Where it can be \[SI\].
    pub range: (f64, f64),
    /// What counts as fully right \[SI\].
    pub tolerance: f64,
    /// Said after the run.
    pub because: Text,
}

/// The axis on which a mark moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MarkAxis {
    /// A reading of the trajectory: a horizontal line.
    Displacement,
    /// A time: a vertical line.
    Time,
    /// A scale of its own beneath the pictures.
    Own,
}

/// A curve that is drawn over the trajectory before it is seen.
#[derive(Debug, Clone, PartialEq)]
pub struct CurveTask {
    /// What is asked.
    pub question: Text,
    /// Points that can be moved, evenly over the span.
    pub points: usize,
    /// Readings between which they move \[m\].
    pub range: (f64, f64),
    /// Said after the run.
    pub because: Text,
}

/// A free exploration.
#[derive(Debug, Clone, PartialEq)]
pub struct Explore {
    /// What to try.
    pub task: Text,
    /// What may be moved.
    pub controls: Vec<Control>,
    /// When it is done; by looking alone if `None`.
    pub goal: Option<Claim>,
}

/// A recording to be fitted by hand.
#[derive(Debug, Clone, PartialEq)]
pub struct HandFit {
    /// What to do.
    pub task: Text,
    /// What may be moved.
    pub controls: Vec<Control>,
    /// Values with which the recording is made, by id \[SI\].
    pub truth: Vec<(String, f64)>,
    /// Standard deviation of its noise \[m\].
    pub noise: f64,
}

/// A game: which effect is concealed?
#[derive(Debug, Clone, PartialEq)]
pub struct Concealed {
    /// What to do.
    pub task: Text,
    /// What may be moved: strengths of effects that are tried.
    pub controls: Vec<Control>,
    /// Standard deviation of the noise \[m\].
    pub noise: f64,
    /// Levels, the easiest first.
    pub levels: Vec<Level>,
}

/// A level of the game.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// Its name.
    pub name: String,
    /// What may be concealed, one of them each time.
    pub candidates: Vec<Candidate>,
}

/// What may be concealed.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Name shown; that of the effect, or "nothing".
    pub name: String,
    /// Id of the effect; `None` for nothing.
    pub effect: Option<String>,
    /// Values of its parameters \[SI\].
    pub values: Vec<(String, f64)>,
    /// One sentence on how it shows.
    pub sign: String,
}
