//! Stand-in until branch `recording` lands.
/// How columns are read.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct ImportSettings {}
