//! What the checks of a diagnosis find, what limits its answer, and what speaks for and against each
//! effect: values, not sentences.
//!
//! `report::sentences` puts all of them into words.

use serde::{Deserialize, Serialize};

use crate::fit::{Contradiction, HeldParameter};
use crate::model::preset::known_value::KnownValue;
use crate::recording::instrument_faults::InstrumentFault;
use crate::static_text::{self, StaticText};

/// What a check found beyond its threshold.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// What it is about.
    pub kind: FindingKind,
    /// The statistic that was compared; its meaning and unit depend on the kind.
    pub statistic: f64,
}

/// What a finding is about.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum FindingKind {
    /// The mean square of the residuals, in units of the noise's.
    MeanSquare,
    /// A force that depends on this quantity would still lower chi2: by the statistic.
    MissingForce {
        /// Symbol of the quantity; empty if no single one stands out.
        #[serde(deserialize_with = "static_text::one")]
        over: StaticText,
    },
    /// A single segment, in standard deviations of what noise leaves.
    LocalSegment,
    /// Motion does not continue across the joins of segments, in standard deviations.
    BrokenJoins,
    /// Something rings that nothing in the device excites. The statistic is its frequency \[Hz\];
    /// any counts.
    SelfRinging,
    /// An effect lowers chi2 on the fitted recordings, by the statistic, but not on held-out ones.
    FailsHeldOut {
        /// Name of the effect.
        #[serde(deserialize_with = "static_text::one")]
        effect: StaticText,
    },
    /// Names are refused: a steady vibration grows with the displacement.
    VibrationWithDisplacement,
    /// Names are refused: a force depends on both displacements.
    ForceOfBothDisplacements,
    /// Names are refused: friction depends on the height.
    FrictionByHeight,
    /// Names are refused: they stand for one force over the displacement and leave part of it. The
    /// statistic is the share of the remainder that their form explains.
    OneForceInTheirPlace {
        /// Names of the effects.
        #[serde(deserialize_with = "static_text::several")]
        effects: Vec<StaticText>,
    },
    /// Names are refused: they carry too small a share of what is missing, the statistic; at the joins
    /// of segments where that is less than within these.
    TooSmallShare {
        /// Names of the effects.
        #[serde(deserialize_with = "static_text::several")]
        effects: Vec<StaticText>,
        /// Share that they carry of segments each by itself.
        of_segments: f64,
    },
    /// The recordings need another value of a parameter than is known, by the statistic in common
    /// standard errors.
    KnownContradicted(Contradiction),
}

impl FindingKind {
    /// Whether names are refused for it.
    pub fn refuses_names(&self) -> bool {
        matches!(
            self,
            Self::VibrationWithDisplacement
                | Self::ForceOfBothDisplacements
                | Self::FrictionByHeight
                | Self::OneForceInTheirPlace { .. }
                | Self::TooSmallShare { .. }
        )
    }
}

/// What limits an answer, or what was done to the recordings for it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Remark {
    /// No recordings were held out: the last third of each took their place.
    LastThirdHeldOut,
    /// No contact was found, for this reason.
    NoContact {
        /// As `fit::inspect` says it.
        reason: String,
    },
    /// The recordings are of several devices.
    DifferentDevices {
        /// As `fit::inspect` says it.
        error: String,
    },
    /// So few samples were recorded.
    FewSamples(usize),
    /// Only the proof mass was recorded.
    ProofMassOnly,
    /// Only one recording is fitted.
    SingleExcitation,
    /// So many held-out recordings were dropped, for they read other points of the device.
    HeldOutReadOtherPoints(usize),
    /// Readings of a recording are not the device's, or only roughly.
    InstrumentFault {
        /// Name of the recording.
        recording: String,
        /// What is wrong with them.
        fault: InstrumentFault,
    },
    /// A recording samples a mode too seldom.
    CoarseSampling {
        /// As `fit::inspect` says it.
        said: String,
    },
    /// There is nothing to prove an improvement by.
    NothingHeldOut,
    /// The base vibrates with another phase in each recording.
    VibrationPhasesDiffer,
    /// The scales of the readings differ from recording to recording, by so much at most \[%\].
    ScalesDiffer(f64),
    /// The mass comes to rest above the ground in this recording.
    RestsAboveGround {
        /// Name of the recording.
        recording: String,
    },
    /// Names were found and refused.
    NamesRefused(Finding),
    /// Readings that were set aside as misread \[%\].
    MisreadReadings {
        /// On the fitted recordings.
        train: f64,
        /// On held-out ones.
        held_out: f64,
    },
    /// Whether the mass touches the ground was decided by what explains everything.
    ContactAmbiguous,
    /// No parameter was free: the model was diagnosed as it was given.
    NothingRetuned,
    /// Parameters of effects that the model has already, or known ones, were re-tuned.
    Retuned(Vec<RetunedParameter>),
    /// Parameters of effects that the model has already were held; their ids.
    HeldAsGiven(Vec<String>),
    /// The recordings contradict what is known of a parameter.
    KnownContradicted(Contradiction),
    /// The recordings need another value of a parameter that was held.
    HeldElsewhere(HeldParameter),
    /// The time was used up before the end.
    OutOfTime {
        /// The time \[s\].
        seconds: f64,
        /// Names of the effects that were not compared.
        not_compared: Vec<String>,
    },
}

/// A parameter before and after the re-tuning.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RetunedParameter {
    /// Its id.
    pub id: String,
    /// Before \[SI\].
    pub from: f64,
    /// After \[SI\].
    pub to: f64,
    /// SI unit.
    pub unit: String,
    /// What was known of it.
    pub known: Option<KnownValue>,
}

/// Which recordings prove a contact law.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum LawProof {
    /// The fitted ones determine it, and held-out ones judge it.
    Alone,
    /// The fitted ones determine it only together with the held-out ones.
    WithHeldOut,
    /// Held-out recordings have too few events; each fitted one, left out in turn, confirms it.
    CrossValidated,
    /// The same, but they do not confirm it.
    NotCrossValidated,
}

/// Evidence for an effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Evidence {
    /// Pull-off force that is no straight line in contact time.
    Releases {
        /// Releases that were used.
        count: usize,
        /// Shortest time on the ground \[s\].
        from_s: f64,
        /// Longest \[s\].
        to_s: f64,
        /// Whether it grows as a logarithm, not towards a limit.
        logarithmic: bool,
        /// What proves it.
        proof: LawProof,
    },
    /// Time that bounces spend below the ground's level.
    Dwell {
        /// Bounces that were used.
        count: usize,
        /// That time \[s\].
        seconds: f64,
        /// Its standard error \[s\].
        error: f64,
        /// What proves it.
        proof: LawProof,
    },
    /// Restitution that depends on the speed of approach.
    Restitution {
        /// Bounces that were used.
        count: usize,
        /// Power of the speed.
        power: f64,
        /// Its standard error.
        error: f64,
        /// What proves it.
        proof: LawProof,
    },
    /// An effect that fits flight as well does not fit bounces.
    RejectedTwin {
        /// Name of that effect.
        #[serde(deserialize_with = "static_text::one")]
        twin: StaticText,
        /// Name of the one that was chosen.
        #[serde(deserialize_with = "static_text::one")]
        chosen: StaticText,
        /// Chi2 around bounces, lower by so much with the chosen one.
        fall: f64,
    },
    /// A second mode was found together with it.
    SecondMode {
        /// Its frequency \[Hz\].
        frequency: f64,
    },
    /// Falls of chi2.
    Gains {
        /// On the fitted recordings.
        fitted: f64,
        /// On held-out ones, if there are any.
        held_out: Option<f64>,
    },
    /// The effect begins after the fitted recordings.
    AfterFitted {
        /// Name of the held-out recording that determines it.
        recording: String,
        /// Fall of chi2 on that one.
        gain: f64,
        /// Fall of chi2 on the other held-out ones.
        held_out: f64,
    },
    /// Falls of chi2 of the events at the ground.
    EventGains {
        /// On the fitted recordings.
        fitted: f64,
        /// On those that prove the law.
        held_out: f64,
        /// Whether these are the fitted ones too, each left out in turn.
        cross_validated: bool,
    },
    /// Its time counts from the start of the first recording.
    SequentialTime,
}

impl Evidence {
    /// Whether it is a contact law that the fitted recordings prove among themselves.
    pub fn is_cross_validated(&self) -> bool {
        match self {
            Self::Releases { proof, .. }
            | Self::Dwell { proof, .. }
            | Self::Restitution { proof, .. } => {
                matches!(
                    proof,
                    LawProof::CrossValidated | LawProof::NotCrossValidated
                )
            }
            _ => false,
        }
    }
}

/// What speaks for or against an effect that was compared and not named.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum CandidateRemark {
    /// It would have been named, had names not been refused.
    Refused,
    /// A contact law lowers chi2 of its events too little.
    LawFallsShort {
        /// What the events say of it.
        law: Evidence,
        /// Fall of chi2.
        fall: f64,
        /// The least one for a name.
        needed: f64,
    },
    /// A contact law lowers chi2 of its events, but not where it is to be proved.
    LawFailsProof {
        /// What the events say of it.
        law: Evidence,
        /// Fall of chi2.
        fall: f64,
    },
    /// A contact law lowers chi2 of its events enough, but may not be named.
    LawNotNamed {
        /// What the events say of it.
        law: Evidence,
        /// Fall of chi2.
        fall: f64,
    },
    /// A mode that nothing in the device excites, of this frequency \[Hz\].
    SelfRings(f64),
    /// It improves the fit no more than chance.
    Insignificant,
    /// It improves the fitted recordings alone.
    FailsHeldOut,
    /// Another effect improves the fit more and leaves nothing for it.
    Outweighed,
    /// Its predicted gain was too small for a fit.
    NotFitted,
    /// The device's own parameters explain as much.
    AbsorbedByRetuning,
    /// The device has nothing that it could act on.
    NothingToActOn,
    /// The recordings do not test it.
    NotTested,
    /// The model has it already.
    InModel,
    /// The diagnosis ended before it was compared.
    NotReached,
}
