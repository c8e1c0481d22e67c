//! TODO-doc

use crate::diagnose::shooting::fitted::Bound;
use crate::model::effects::ActiveEffect;

/// A hypothesis about what was left out.
#[derive(Debug, Clone)]
pub struct Hypothesis {
    /// The effect to begin with.
    pub start: ActiveEffect,
    /// Others to begin with that look like it, and their own bounds: the one that brings most
    /// is kept.
    pub alternative_starts: Vec<(ActiveEffect, Vec<Bound>)>,
    /// Ids of its parameters that are fitted.
    pub free: Vec<String>,
    /// The effect to begin with, and ids of the parameters that are fitted, where the law is
    /// too strong for any model without it, if those are others.
    pub cold_start: Option<(ActiveEffect, Vec<String>)>,
    /// Ids of those that shape the law, fitted besides once it has shown up.
    pub shape: Vec<String>,
    /// Parameters that stay within bounds.
    pub bounds: Vec<Bound>,
    /// Fall of chi2 promised by the linearised problem.
    pub predicted_gain: f64,
    /// Whether it is the best of many times or frequencies that were searched.
    pub look_elsewhere: bool,
    /// Whether its times go through the series of recordings.
    pub sequential_time: bool,
    /// If it begins after the fitted recordings: that of those kept out by which it is told, to
    /// be proved by the others.
    pub estimated_on_held_out: Option<usize>,
}
