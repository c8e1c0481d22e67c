//! Stand-in until branch `recording` lands.
/// Shift and scale of a recording against the simulation.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Alignment {
    /// Added to the recording's times [s].
    pub shift: f64,
    /// Factor on the displacement.
    pub scale: f64,
    /// Added to the displacement [m].
    pub offset: f64,
}
impl Default for Alignment {
    fn default() -> Self {
        Self { shift: 0.0, scale: 1.0, offset: 0.0 }
    }
}
