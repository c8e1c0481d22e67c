//! Stand-in until branch `recording` lands.
/// Recording minus simulation.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Comparison {
    /// Root mean square [m].
    pub rms: f64,
    /// rms over the recording's range [%].
    pub nrmse_percent: f64,
}
