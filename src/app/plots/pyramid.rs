//! Stand-in until branch `plots` lands.
/// Min/max pyramid.
#[derive(Debug, Clone, Default)]
pub struct Pyramid {}
