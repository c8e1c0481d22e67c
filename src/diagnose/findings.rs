//! What the checks of a diagnosis find, and what limits its answer: values, not sentences.
//!
//! `report::sentences` puts both into words.

/// What a check found beyond its threshold.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// What it is about.
    pub kind: FindingKind,
    /// The statistic that was compared; its meaning and unit depend on the kind.
    pub statistic: f64,
    /// The threshold that it is beyond, in the same unit.
    pub threshold: f64,
}

/// What a finding is about.
#[derive(Debug, Clone, PartialEq)]
pub enum FindingKind {
    /// The mean square of the residuals, in units of the noise's.
    MeanSquare,
    /// A force that depends on this quantity would still lower chi2: by the statistic.
    MissingForce {
        /// Symbol of the quantity.
        over: &'static str,
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
        effect: &'static str,
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
        effects: Vec<&'static str>,
    },
    /// Names are refused: they carry too small a share of what is missing.
    TooSmallShare {
        /// Names of the effects.
        effects: Vec<&'static str>,
        /// Share that they carry of segments each by itself.
        of_segments: f64,
    },
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
#[derive(Debug, Clone, PartialEq)]
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
    /// Samples at the end of the sensor's range were dropped.
    ClippedSamples {
        /// Name of the recording.
        recording: String,
        /// Symbol of the channel.
        channel: &'static str,
        /// How many.
        clipped: usize,
        /// Of how many.
        samples: usize,
    },
    /// There is nothing to prove an improvement by.
    NothingHeldOut,
    /// The base vibrates with another phase in each recording.
    VibrationPhasesDiffer,
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
}
