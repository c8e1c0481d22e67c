//! What a fit is asked to do.

use std::ops::Range;
use std::sync::Arc;

use crate::model::Model;
use crate::recording::Recording;

/// What of a rig is not known exactly and no finding either.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeNuisances {
    /// A constant offset of each reading of each recording.
    pub offsets: bool,
    /// Scale of each reading, with the standard deviation of what is known of it. A scale
    /// common to both readings is not told apart from eta, dp and the forces.
    pub scales: Option<f64>,
    /// Skew between the clocks of voltage and readings \[s\], likewise.
    pub skew: Option<f64>,
    /// Time by which the readings were found to be late against the voltage \[s\]; the
    /// recordings are cut by a voltage that is as late, and the skew counts from there.
    pub late: f64,
}

impl Default for FreeNuisances {
    fn default() -> Self {
        Self {
            offsets: true,
            scales: None,
            skew: Some(3e-6),
            late: 0.0,
        }
    }
}

/// What to fit, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct FitOptions {
    /// Ids of the parameters to move; `effect.parameter` for an effect's.
    pub free: Vec<String>,
    /// The rig's own unknowns.
    pub nuisances: FreeNuisances,
    /// Longest segment \[s\]; by itself some periods of the slowest mode.
    pub longest: Option<f64>,
    /// Tolerance of the simulation \[m\].
    pub tolerance: f64,
    /// Most iterations of each stage.
    pub iterations: usize,
    /// Further starts, drawn around the given one, beyond the planned ones.
    pub starts: usize,
    /// Seed of those.
    pub seed: u64,
}

impl FitOptions {
    /// The default parameters of a model, and those of its effects.
    pub fn for_model(model: &Model) -> Self {
        Self {
            free: default_free(model),
            nuisances: FreeNuisances::default(),
            longest: None,
            tolerance: 1e-12,
            iterations: 40,
            starts: 0,
            seed: 0,
        }
    }
}

/// What is fitted if nothing is said: all that people tune where there is a drive or a
/// ground; frequency and damping of a bare oscillator; what its effects leave free.
pub fn default_free(model: &Model) -> Vec<String> {
    use crate::model::parameter::ParameterId as P;
    let device = [
        P::Eta,
        P::Dp,
        P::Zeta1,
        P::Zeta2,
        P::Cs,
        P::Gp,
        P::Ca,
        P::Ca0,
        P::Alpha,
    ];
    let bare = model.piezo.is_none() && !model.has_ground;
    let mut free: Vec<String> = device
        .into_iter()
        .filter(|p| model.uses(*p))
        .map(|p| p.spec().id.to_owned())
        .collect();
    if bare && model.uses(P::Zeta1) {
        free.insert(0, P::F1.spec().id.to_owned());
    }
    free.extend(model.effect_ids());
    free
}

/// A stretch of a recording to be used.
#[derive(Debug, Clone)]
pub struct Part {
    /// The recording.
    pub recording: Arc<Recording>,
    /// Which samples of it.
    pub samples: Range<usize>,
}

impl Part {
    /// All of a recording.
    pub fn whole(recording: Arc<Recording>) -> Self {
        let samples = 0..recording.len();
        Self { recording, samples }
    }

    /// A recording cut in two: its first two thirds and the rest.
    pub fn split(recording: Arc<Recording>) -> (Self, Self) {
        let at = 2 * recording.len() / 3;
        let first = Self {
            samples: 0..at,
            recording: Arc::clone(&recording),
        };
        let rest = Self {
            samples: at..recording.len(),
            recording,
        };
        (first, rest)
    }
}
