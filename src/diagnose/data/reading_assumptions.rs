//! What is assumed about the readings when recordings are cut into segments.

/// Why a recording has no contacts although it seems to have some.
pub(crate) const HOVERS_REASON: &str = "the mass comes to rest over the ground without touching it";

/// What the re-tuning has found out about the readings.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct ReadingAssumptions {
    /// By how much the readings are late against the voltage \[s\].
    pub latency: f64,
    /// Time constant by which the readings lag according to the data \[s\]; 0 without a lag.
    pub lag: f64,
    /// Whether the scales of the readings differ from recording to recording.
    pub own_scales: bool,
    /// Fitted and held-out recordings in which the mass rests above the ground.
    pub hovering: (Vec<usize>, Vec<usize>),
}

/// How recordings are read in which it is ambiguous whether the mass hovers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ContactAmbiguity {
    /// As fits the baseline better.
    AsFitted,
    /// The opposite way, in the first split where it is ambiguous.
    Opposite,
    /// The mass hovers in these fitted and held-out recordings.
    HoveringIn(Vec<usize>, Vec<usize>),
}
