//! TODO-doc

/// Why a recording has no stays on the ground that seems to have some.
pub(crate) const HOVERS_REASON: &str = "the mass comes to rest over the ground without touching it";

/// What is found out about the readings on the way.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct ReadingAssumptions {
    /// By how much they are late against the voltage \[s\].
    pub latency: f64,
    /// By how much they lag as the data show it, 0 if they do not \[s\].
    pub lag: f64,
    /// In which recordings of either side the mass rests over the ground.
    pub hovering: (Vec<usize>, Vec<usize>),
}

/// How recordings are read of which it is in doubt whether the mass hovers in them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ContactAmbiguity {
    /// As suits the baseline better.
    AsFitted,
    /// The other way, on the side where it is in doubt first.
    Opposite,
    /// In these of either side it does.
    HoveringIn(Vec<usize>, Vec<usize>),
}
