//! A hypothesis: an effect with its starts, free parameters and bounds.

use crate::diagnose::shooting::fitted::Bound;
use crate::model::effects::ActiveEffect;

/// A hypothesis about an effect that the model lacks.
#[derive(Debug, Clone)]
pub struct Hypothesis {
    /// The effect to begin with.
    pub start: ActiveEffect,
    /// Other starts that look like it, and their own bounds: the one that gains most is used.
    pub alternative_starts: Vec<(ActiveEffect, Vec<Bound>)>,
    /// Ids of its parameters that are fitted.
    pub free: Vec<String>,
    /// Start and free parameters if the effect is too strong for a model without it, if they differ.
    pub cold_start: Option<(ActiveEffect, Vec<String>)>,
    /// Ids of parameters that shape the law, fitted as well once its strength is significant.
    pub shape: Vec<String>,
    /// Parameters that stay within bounds.
    pub bounds: Vec<Bound>,
    /// Fall of chi2 predicted by the linearised problem.
    pub predicted_gain: f64,
    /// Whether it is the best of many times or frequencies that were searched.
    pub look_elsewhere: bool,
    /// Whether its times count through the recordings in the order given.
    pub sequential_time: bool,
    /// If it begins after the fitted recordings: the held-out recording that determines it, to be
    /// proved by the others.
    pub estimated_on_held_out: Option<usize>,
}
