//! The result of drawing a law, and how strengths are drawn.

use super::hidden_forces::Term;
use super::law::Law;
use crate::trial::rng::TrialRng;

/// What a draw gives: the formulation's name, how many times stronger the law may become and
/// stay realistic, and the law. `None` if the device has no static gain.
pub(super) type Drawn = Option<(&'static str, f64, Law)>;

/// A hidden force with its formulation and room.
pub(super) fn term(formulation: &'static str, most: f64, term: Term) -> (&'static str, f64, Law) {
    (formulation, most, Law::Term(term))
}

/// A strength within `[low, high]`, and how many times stronger it may become.
pub(super) fn strength(rng: &mut TrialRng, low: f64, high: f64) -> (f64, f64) {
    let value = rng.log_between(low, high);
    (value, high / value)
}
