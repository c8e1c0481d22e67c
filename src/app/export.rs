//! Stand-in until branch `device` lands.
use super::state::State;
use std::path::Path;
/// SVG.
pub fn svg(_path: &Path, _state: &State) -> Result<(), String> {
    Err("not yet".into())
}
/// PNG.
pub fn png(_path: &Path, _state: &State) -> Result<(), String> {
    Err("not yet".into())
}
