//! The file of a lesson as it is written, with the place of everything that is checked later.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::Spanned;

/// Version of the format.
pub(super) const FORMAT: u32 = 1;

/// The file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    pub format: Spanned<u32>,
    pub id: Spanned<String>,
    pub title: Spanned<String>,
    pub about: String,
    #[serde(default = "usual_minutes")]
    pub minutes: u32,
    pub setup: Spanned<SetupEntry>,
    #[serde(default)]
    pub step: Vec<Spanned<StepEntry>>,
}

fn usual_minutes() -> u32 {
    5
}

/// What is set up; in a step, what differs from the lesson's.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SetupEntry {
    pub preset: Option<Spanned<String>>,
    pub drive: Option<Spanned<String>>,
    pub duration: Option<Spanned<Quantity>>,
    pub speed: Option<Spanned<f64>>,
    pub pictures: Option<Vec<Spanned<String>>>,
    #[serde(default)]
    pub set: BTreeMap<String, Spanned<Quantity>>,
    #[serde(default)]
    pub effects: BTreeMap<String, Spanned<BTreeMap<String, Spanned<Quantity>>>>,
}

/// A number in SI units, or a quantity with its unit.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
pub(super) enum Quantity {
    Number(f64),
    Text(String),
}

/// A step.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StepEntry {
    pub title: String,
    pub text: Spanned<String>,
    pub alt: Spanned<String>,
    pub setup: Option<Spanned<SetupEntry>>,
    pub choice: Option<Spanned<ChoiceEntry>>,
    pub mark: Option<Spanned<MarkEntry>>,
    pub curve: Option<Spanned<CurveEntry>>,
    pub explore: Option<Spanned<ExploreEntry>>,
    pub fit: Option<Spanned<FitEntry>>,
    pub concealed: Option<Spanned<ConcealedEntry>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ChoiceEntry {
    pub question: Spanned<String>,
    pub options: Vec<Spanned<String>>,
    pub right: Spanned<usize>,
    pub check: Spanned<String>,
    pub because: Spanned<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MarkEntry {
    pub question: Spanned<String>,
    pub of: Spanned<String>,
    pub label: String,
    pub axis: Option<Spanned<String>>,
    pub unit: Spanned<String>,
    pub range: Spanned<(f64, f64)>,
    pub tolerance: Spanned<f64>,
    pub because: Spanned<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CurveEntry {
    pub question: Spanned<String>,
    pub points: Spanned<usize>,
    pub range: Spanned<(Quantity, Quantity)>,
    pub because: Spanned<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ExploreEntry {
    pub task: Spanned<String>,
    pub controls: Vec<Spanned<ControlEntry>>,
    pub goal: Option<Spanned<String>>,
}

/// A control by its id, or with a range of its own.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
pub(super) enum ControlEntry {
    Id(String),
    Ranged(RangedControl),
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RangedControl {
    pub id: String,
    pub range: (Quantity, Quantity),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FitEntry {
    pub task: Spanned<String>,
    pub controls: Vec<Spanned<ControlEntry>>,
    pub truth: BTreeMap<String, Spanned<Quantity>>,
    pub noise: Spanned<Quantity>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ConcealedEntry {
    pub task: Spanned<String>,
    #[serde(default)]
    pub controls: Vec<Spanned<ControlEntry>>,
    pub noise: Spanned<Quantity>,
    pub level: Vec<Spanned<LevelEntry>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LevelEntry {
    pub name: String,
    pub candidate: Vec<Spanned<CandidateEntry>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CandidateEntry {
    pub effect: Spanned<String>,
    #[serde(default)]
    pub set: BTreeMap<String, Spanned<Quantity>>,
    pub sign: String,
}
