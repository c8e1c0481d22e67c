//! Options of a fit: which parameters are free, which nuisances are estimated with them, how the
//! recordings are cut and how long the search may take.

use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::model::Model;
use crate::model::preset::known_value::KnownValue;
use crate::recording::Recording;

/// Unknowns of the instrument, estimated for each recording with every fit (nuisance parameters).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FreeNuisances {
    /// A constant offset of each reading of each recording.
    pub offsets: bool,
    /// Standard deviation of each reading's scale around 1; `None` holds it. A scale common to
    /// both readings cannot be distinguished from eta, dp and the forces.
    pub scales: Option<f64>,
    /// Standard deviation of the skew between the clocks of voltage and readings \[s\]; `None`
    /// holds it.
    pub skew: Option<f64>,
    /// Lag of the readings behind the voltage \[s\], known beforehand. The recordings are cut by a
    /// voltage with that lag, and the skew counts from there.
    pub reading_lag: f64,
}

impl Default for FreeNuisances {
    fn default() -> Self {
        Self {
            offsets: true,
            scales: None,
            skew: Some(3e-6),
            reading_lag: 0.0,
        }
    }
}

impl FreeNuisances {
    /// Those of a recording: what a person has said of its instrument comes first. A lag given for
    /// all comes on top of its own.
    #[must_use]
    pub fn of(&self, recording: &Recording) -> Self {
        recording.instrument.map_or(*self, |own| Self {
            offsets: own.zeros,
            scales: own.scale,
            skew: own.clock,
            reading_lag: self.reading_lag + own.lag,
        })
    }
}

/// What to fit, and how.
///
/// # Examples
/// ```
/// use impactscope::fit::FitOptions;
/// use impactscope::model::preset::Preset;
///
/// let model = Preset::default().model;
/// let options = FitOptions {
///     free: vec!["eta".to_owned(), "dp".to_owned()],
///     ..FitOptions::for_model(&model)
/// };
/// assert_eq!(options.starts, 0);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FitOptions {
    /// Ids of the parameters to move; `effect.parameter` for an effect's.
    pub free: Vec<String>,
    /// What is known of free parameters beforehand.
    #[serde(default)]
    pub known: Vec<KnownValue>,
    /// Unknowns of the instrument.
    pub nuisances: FreeNuisances,
    /// Longest segment \[s\]; `None` for some periods of the slowest mode.
    pub longest: Option<f64>,
    /// Tolerance of the simulation \[m\].
    pub tolerance: f64,
    /// Most iterations of each stage.
    pub iterations: usize,
    /// Random starts around the given one, in addition to the planned ones.
    pub starts: usize,
    /// Seed of the random starts.
    pub seed: u64,
    /// Time after which the fit ends with the best so far; `None` for no limit.
    #[serde(default)]
    pub budget: Option<Duration>,
}

impl FitOptions {
    /// Defaults for a model: [`default_free`], offsets and skew as nuisances, no random start.
    pub fn for_model(model: &Model) -> Self {
        Self {
            free: default_free(model),
            known: Vec::new(),
            nuisances: FreeNuisances::default(),
            longest: None,
            tolerance: 1e-12,
            iterations: 40,
            starts: 0,
            seed: 0,
            budget: None,
        }
    }
}

/// Ids of the parameters that are free by default: everything that is usually tuned if there is
/// a drive or a ground, frequency and damping of a bare oscillator, and those of its effects.
///
/// # Examples
/// ```
/// use impactscope::fit::default_free;
/// use impactscope::model::preset::Preset;
///
/// let paper = Preset::default().model;
/// assert!(default_free(&paper).contains(&"Cs".to_owned()));
/// let oscillator = Preset::load("oscillator")?.model;
/// assert_eq!(default_free(&oscillator)[0], "f1");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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

/// Ids of everything of a device that recordings can tell: those of [`default_free`], and its
/// frequencies, its shape and how the drive acts on it, which differ from one piece to the next.
///
/// # Examples
/// ```
/// use impactscope::fit::whole_device;
/// use impactscope::model::preset::Preset;
///
/// let paper = Preset::default().model;
/// assert!(["Cs", "f2", "shape_c1"].iter().all(|id| whole_device(&paper).contains(&(*id).to_owned())));
/// ```
pub fn whole_device(model: &Model) -> Vec<String> {
    use crate::model::parameter::ParameterId as P;
    let mut all = default_free(model);
    let structure = [P::F1, P::F2, P::ShapeC1, P::ShapeC2, P::ShapeP2, P::DriveP];
    for id in structure.into_iter().filter(|p| model.uses(*p)) {
        let id = id.spec().id.to_owned();
        if !all.contains(&id) {
            all.push(id);
        }
    }
    all
}

/// A range of samples of a recording. Samples that are no readings of the device, by
/// [`Recording::instrument_faults`], are missing in it.
#[derive(Debug, Clone)]
pub struct Part {
    /// The recording without unusable samples.
    pub recording: Arc<Recording>,
    /// Which samples of it.
    pub samples: Range<usize>,
}

impl Part {
    /// All of a recording.
    pub fn whole(recording: Arc<Recording>) -> Self {
        let recording = recording.usable();
        let samples = 0..recording.len();
        Self { recording, samples }
    }

    /// What is fitted and what is held out: the recordings as they are given; without held-out
    /// ones the last third of each. Window and command line both ask here.
    pub fn sides(
        train: Vec<Arc<Recording>>,
        held_out: Vec<Arc<Recording>>,
    ) -> (Vec<Self>, Vec<Self>) {
        if held_out.is_empty() {
            return train.into_iter().map(Self::split).unzip();
        }
        let whole = |all: Vec<Arc<Recording>>| all.into_iter().map(Self::whole).collect();
        (whole(train), whole(held_out))
    }

    /// A recording cut in two: its first two thirds, to fit to, and the rest, to hold out.
    ///
    /// # Examples
    /// ```
    /// use std::sync::Arc;
    ///
    /// use impactscope::fit::Part;
    /// use impactscope::recording::Recording;
    ///
    /// let time: Vec<f64> = (0..30).map(|i| 1e-5 * f64::from(i)).collect();
    /// let recording = Recording::new("ring", time.clone(), None, time, None)?;
    /// let (train, held_out) = Part::split(Arc::new(recording));
    /// assert_eq!((train.samples, held_out.samples), (0..20, 20..30));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn split(recording: Arc<Recording>) -> (Self, Self) {
        let recording = recording.usable();
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

    /// Sentences on what is wrong with the readings of each recording of `parts`, once each.
    pub fn fault_sentences(parts: &[Part]) -> Vec<String> {
        let mut out: Vec<String> = Vec::new();
        for part in parts {
            let r = &part.recording;
            let own = r.instrument_faults().faults.iter();
            for text in own.map(|fault| format!("{}: {}", r.name, fault.sentence())) {
                if !out.contains(&text) {
                    out.push(text);
                }
            }
        }
        out
    }
}
