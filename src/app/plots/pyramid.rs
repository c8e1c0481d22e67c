//! Stand-in until branch `plots` lands.
/// Min/max pyramid.
#[derive(Debug, Clone, Default)]
pub struct Pyramid {}

impl Pyramid {
    /// Uniform.
    pub fn new(_t0: f64, _dt: f64, _values: &[f64]) -> Self {
        Self::default()
    }
    /// Not uniform.
    pub fn xy(_times: &[f64], _values: &[f64]) -> Self {
        Self::default()
    }
}
