//! Stand-in until branch `recording` lands.
/// Features per period.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Features {
    /// Mean number of bounces.
    pub bounces: Option<f64>,
    /// Peak [m].
    pub peak: Option<f64>,
    /// Contact [s].
    pub contact: Option<f64>,
}
