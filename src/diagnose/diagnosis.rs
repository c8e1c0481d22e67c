//! The result of a diagnosis, with its evidence. SI throughout.

use serde::{Deserialize, Serialize};

use super::findings::{CandidateRemark, Evidence, Finding, Remark};
pub use super::force_curve::{Absorbed, BalanceCurve, BalanceForces, ForceCurve};
use super::packed_points;
pub use super::quantity::Quantity;
use crate::model::Model;
use crate::static_text::{self, StaticText};

/// The answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The baseline, re-tuned, is at the noise floor: nothing is named.
    Adequate,
    /// The named effects were left out, and nothing else is seen to be missing.
    MissingPhysics,
    /// The named effects were left out, and something remains that they do not explain.
    PartlyExplained,
    /// Something is missing that no effect of the catalogue explains.
    Unexplained,
}

/// What the mass is doing in a segment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Regime {
    /// In flight, far from the ground.
    FarFlight,
    /// In flight near the ground, coming down.
    NearGroundApproach,
    /// In flight near the ground, going up.
    NearGroundDeparture,
    /// At a bounce or touch.
    Impact,
    /// Held on the ground.
    Contact,
    /// Pulled off.
    Release,
}

impl Regime {
    /// All, in the order of a cycle.
    pub const ALL: [Self; 6] = [
        Self::FarFlight,
        Self::NearGroundApproach,
        Self::Impact,
        Self::Contact,
        Self::Release,
        Self::NearGroundDeparture,
    ];
}

/// A fitted parameter of an effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Id within the effect.
    pub id: String,
    /// Value, SI.
    pub value: f64,
    /// Standard error, SI, statistical and systematic (scale of the readings, mass of the device);
    /// infinite if the data do not determine it.
    pub std_error: f64,
    /// SI unit.
    #[serde(deserialize_with = "static_text::one")]
    pub unit: StaticText,
}

/// An effect that was left out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NamedEffect {
    /// Id in the catalogue.
    pub id: String,
    /// The term of the field.
    pub name: String,
    /// Probability, 0 to 1, among all that were compared.
    pub probability: f64,
    /// Largest force over the recordings \[N\]; NaN where the effect is no force.
    pub size: f64,
    /// Its parameters.
    pub parameters: Vec<Estimate>,
    /// Ids of effects that the data cannot distinguish from it.
    pub alike: Vec<String>,
    /// Evidence for it.
    pub evidence: Vec<Evidence>,
}

/// An effect that was compared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Id in the catalogue.
    pub id: String,
    /// The term of the field.
    pub name: String,
    /// Probability, 0 to 1.
    pub probability: f64,
    /// Fall of chi2 over the fitted recordings when it alone is added, as a first
    /// estimate from the linearised problem.
    pub score: f64,
    /// The same after a fit with it; NaN if it was not fitted.
    pub gain: f64,
    /// Fall of chi2 on held-out recordings; NaN if it was not fitted.
    pub held_out_gain: f64,
    /// Chi2 per value on held-out recordings with it; NaN if it was not fitted.
    pub held_out_chi2: f64,
    /// What speaks for or against it.
    pub remarks: Vec<CandidateRemark>,
}

/// A span where simulation and recording differ by more than the noise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Mismatch {
    /// Name of the recording.
    pub recording: String,
    /// Begin \[s\].
    pub start: f64,
    /// End \[s\].
    pub end: f64,
    /// `xp` or `xc`.
    #[serde(deserialize_with = "static_text::one")]
    pub channel: StaticText,
    /// What the mass is doing.
    pub regime: Regime,
    /// Share of the whole excess of chi2, 0 to 1.
    pub share: f64,
}

/// Excess of chi2 per value against one quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Marginal {
    /// What it is drawn against: `xp`, `xp'`, `V`, drive phase, time since contact.
    #[serde(deserialize_with = "static_text::one")]
    pub against: StaticText,
    /// SI unit of it.
    #[serde(deserialize_with = "static_text::one")]
    pub unit: StaticText,
    /// Middle of each bin.
    pub at: Vec<f64>,
    /// Mean square of the residuals in units of the noise, before.
    pub before: Vec<f64>,
    /// The same with the named effects.
    pub after: Vec<f64>,
}

/// Residual of the proof mass over one recording, thinned for a picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Strip {
    /// Name of the recording.
    pub recording: String,
    /// Whether it was held out.
    pub held_out: bool,
    /// Middle of each bin \[s\].
    pub time: Vec<f64>,
    /// Root mean square of the residual in each bin \[m\], baseline; NaN where nothing is
    /// compared.
    pub before: Vec<f64>,
    /// With the named effects.
    pub after: Vec<f64>,
    /// Mean of the recording in each bin \[m\], for orientation.
    pub xp: Vec<f64>,
    /// Regime of the last sample in the bin.
    pub regime: Vec<Regime>,
    /// Time \[s\] and residual, measured minus simulated \[m\], of every sample compared,
    /// baseline; NaN between segments.
    #[serde(with = "packed_points")]
    pub samples_before: Vec<[f64; 2]>,
    /// With the named effects.
    #[serde(with = "packed_points")]
    pub samples_after: Vec<[f64; 2]>,
}

/// A bounce as measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BounceSeen {
    /// Which recording, numbered through the fitted and then the others.
    pub recording: usize,
    /// When \[s\].
    pub time: f64,
    /// Speed of approach \[m/s\].
    pub speed: f64,
    /// Speed after over speed before.
    pub ratio: f64,
    /// Standard error of the ratio.
    pub ratio_error: f64,
    /// Time between going below the ground's level and coming above it \[s\].
    pub dwell: f64,
    /// Its standard error \[s\].
    pub dwell_error: f64,
}

/// A release as measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ReleaseSeen {
    /// Which recording.
    pub recording: usize,
    /// When \[s\].
    pub time: f64,
    /// How long the mass was on the ground \[s\].
    pub contact: f64,
    /// Pull-off force, eq (13) \[N\].
    pub force: f64,
    /// Its standard error \[N\].
    pub force_error: f64,
}

/// Height of the ground in one stay.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LevelSeen {
    /// Which recording.
    pub recording: usize,
    /// Middle of the stay \[s\].
    pub time: f64,
    /// Reading of the mass minus the level in the model \[m\].
    pub miss: f64,
    /// Standard error \[m\].
    pub error: f64,
}

/// Contact events.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct EventsSeen {
    /// Bounces.
    pub bounces: Vec<BounceSeen>,
    /// Releases.
    pub releases: Vec<ReleaseSeen>,
    /// Stays.
    pub levels: Vec<LevelSeen>,
}

/// Distance between simulation and recordings.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Distance {
    /// Root mean square of (simulation - recording) of the proof mass \[m\].
    pub rms: f64,
    /// Mean square of the residuals in units of their noise; 1 where nothing is missing.
    pub chi2: f64,
}

/// Before: the re-tuned baseline. After: with the named effects.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct BeforeAfter {
    /// The re-tuned baseline.
    pub before: Distance,
    /// With the named effects.
    pub after: Distance,
}

/// The proof of one recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ProofOf {
    /// Name of the recording.
    pub recording: String,
    /// Whether it was held out.
    pub held_out: bool,
    /// Noise of the proof mass's reading \[m\].
    pub noise: f64,
    /// Share of its samples that are compared.
    pub covered: f64,
    /// Distances.
    pub distance: BeforeAfter,
    /// Correlation of neighbouring residuals, before and after: 0 if white.
    pub correlation: (f64, f64),
}

/// A recording that would help.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NextExperiment {
    /// The drive, as typed on the command line.
    pub drive: String,
    /// The two that it would separate; the second may be `nothing`.
    pub separates: (String, String),
    /// Expected difference of chi2 for a recording of [`Self::DURATION`].
    pub expected: f64,
}

impl NextExperiment {
    /// Length of the recording \[s\].
    pub const DURATION: f64 = 0.2;
}

/// What the named effects do not carry. Where nothing is named, that is all of the mismatch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Remaining {
    /// Share of the mismatch of stretches, each from a start of its own, that is left, 0 to 1.
    pub share: f64,
    /// The same of recordings simulated from one start to their end; `None` where contacts, joints of
    /// the drive or the diagnosis' end do not allow that.
    pub share_of_runs: Option<f64>,
    /// What the mass does where most of it lies.
    pub regime: Regime,
    /// On what it depends, if one quantity stands out.
    pub depends_on: Option<Quantity>,
    /// The force that is still missing against that quantity, if it was measured.
    pub force: Option<ForceCurve>,
}

/// A diagnosis from beginning to end.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Diagnosis {
    /// The answer.
    pub verdict: Verdict,
    /// What the named effects do not carry; `None` where nothing is left.
    #[serde(default)]
    pub remaining: Option<Remaining>,
    /// The effects that were left out, largest gain first.
    pub named: Vec<NamedEffect>,
    /// Every effect that was compared, most probable first.
    pub candidates: Vec<Candidate>,
    /// Where simulation and recordings differ, largest share first.
    pub mismatch: Vec<Mismatch>,
    /// Excess against quantities.
    pub marginals: Vec<Marginal>,
    /// The force that the baseline lacks.
    pub forces: Vec<ForceCurve>,
    /// The same by the balance of forces in flight; `None` where no flight is long enough.
    #[serde(default)]
    pub balance: Option<BalanceForces>,
    /// Residuals over time.
    pub strips: Vec<Strip>,
    /// Events at the ground as measured against the baseline.
    pub events: EventsSeen,
    /// Noise of the proof mass over all fitted recordings \[m\].
    pub noise: f64,
    /// On the recordings that were fitted.
    pub train: BeforeAfter,
    /// On held-out recordings; no numbers if there are none.
    pub held_out: BeforeAfter,
    /// Recording by recording.
    pub proof: Vec<ProofOf>,
    /// What to record next.
    pub next_experiment: Option<NextExperiment>,
    /// The re-tuned baseline.
    pub baseline: Model,
    /// The model with the named effects.
    pub model: Model,
    /// What limits the answer, and what was done about it.
    pub remarks: Vec<Remark>,
    /// Whether it was cancelled: then it is what was found so far.
    pub cancelled: bool,
    /// What is still missing, and why names were refused.
    pub findings: Vec<Finding>,
}

impl Diagnosis {
    /// Whether recordings were held out; if not, their distances are no numbers.
    pub fn has_held_out(&self) -> bool {
        self.proof.iter().any(|p| p.held_out)
    }

    /// What is still missing beyond the noise, if anything.
    pub fn inadequacy(&self) -> Option<&Finding> {
        self.findings.iter().find(|f| !f.kind.refuses_names())
    }
}
