//! Choices of maps, diagrams and ensembles of the Explore workspace.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

/// Which drive a panel of the workspace starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DriveSource {
    /// That of the Tune workspace.
    #[default]
    Tune,
    /// The drawn waveform.
    Drawn,
}

/// An axis as it is chosen; SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AxisChoice {
    /// Id of the number that varies.
    pub id: String,
    /// First value.
    pub from: f64,
    /// Last value.
    pub to: f64,
    /// Equal ratios instead of equal differences.
    pub is_logarithmic: bool,
}

impl AxisChoice {
    /// From `from` to `to`.
    #[must_use]
    pub fn new(id: &str, (from, to): (f64, f64), is_logarithmic: bool) -> Self {
        Self {
            id: id.to_owned(),
            from,
            to,
            is_logarithmic,
        }
    }
}

/// A map over two numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MapChoices {
    /// Which drive.
    pub source: DriveSource,
    /// Horizontal axis.
    pub x: AxisChoice,
    /// Vertical axis.
    pub y: AxisChoice,
    /// Id of the measure that is drawn.
    pub measure: String,
    /// Points along each axis.
    pub points: usize,
}

/// Frequencies of the paper \[Hz\].
const PAPER_FREQUENCIES: (f64, f64) = (5.0, 100.0);
/// Amplitudes up to which the gain of the film was measured \[V\]; below the least, nothing taps.
const PAPER_AMPLITUDES: (f64, f64) = (0.5, crate::model::piezo::MEASURED_VOLTAGE);
/// Points along each axis of a first map: a picture of some seconds.
const FIRST_MAP_POINTS: usize = 100;

impl Default for MapChoices {
    fn default() -> Self {
        Self {
            source: DriveSource::Tune,
            x: AxisChoice::new("frequency", PAPER_FREQUENCIES, true),
            y: AxisChoice::new("amplitude", PAPER_AMPLITUDES, false),
            measure: "regime".to_owned(),
            points: FIRST_MAP_POINTS,
        }
    }
}

/// What an orbit diagram draws over each value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OrbitQuantity {
    /// Displacement at each strobe.
    #[default]
    Displacement,
    /// Speeds of arrival.
    ImpactSpeed,
    /// Bounces of each period of the drive.
    Bounces,
}

/// An orbit diagram.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OrbitChoices {
    /// Which drive.
    pub source: DriveSource,
    /// What is swept.
    pub axis: AxisChoice,
    /// Values of it.
    pub points: usize,
    /// What is drawn.
    pub shown: OrbitQuantity,
}

/// Values of a first diagram.
const FIRST_ORBIT_POINTS: usize = 200;

impl Default for OrbitChoices {
    fn default() -> Self {
        Self {
            source: DriveSource::Tune,
            axis: AxisChoice::new("frequency", PAPER_FREQUENCIES, true),
            points: FIRST_ORBIT_POINTS,
            shown: OrbitQuantity::default(),
        }
    }
}

/// Basins of attraction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BasinChoices {
    /// Which drive.
    pub source: DriveSource,
    /// Whether the phase of switching on varies, in place of displacement and velocity.
    pub over_phase: bool,
    /// Lowest and highest initial displacement \[m\].
    pub displacement: (f64, f64),
    /// Lowest and highest initial velocity \[m/s\].
    pub velocity: (f64, f64),
    /// Phase at which the drive is switched on, from 0 to below 1.
    pub switched_on: f64,
    /// Starts along each direction.
    pub points: usize,
}

/// Starts of a first picture: about the room over the paper's ground \[m\], and speeds \[m/s\] that
/// would lift the mass as far.
const FIRST_DISPLACEMENTS: (f64, f64) = (-55e-6, 55e-6);
const FIRST_VELOCITIES: (f64, f64) = (-0.2, 0.2);
/// Starts along each direction.
const FIRST_BASIN_POINTS: usize = 60;

impl Default for BasinChoices {
    fn default() -> Self {
        Self {
            source: DriveSource::Tune,
            over_phase: false,
            displacement: FIRST_DISPLACEMENTS,
            velocity: FIRST_VELOCITIES,
            switched_on: 0.0,
            points: FIRST_BASIN_POINTS,
        }
    }
}

/// A coefficient that is uncertain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UncertainCoefficient {
    /// Id of the parameter.
    pub id: String,
    /// It lies within its value divided by this factor and times it; above 1.
    pub factor: f64,
}

/// A wanted response.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WishChoices {
    /// Codes of the wanted regimes; any if empty.
    pub regimes: Vec<u32>,
    /// Bounds of the contact share.
    pub contact_share: Option<(f64, f64)>,
    /// Largest impact speed \[m/s\].
    pub impact_speed: Option<f64>,
}

impl Default for WishChoices {
    fn default() -> Self {
        Self {
            regimes: Vec::new(),
            contact_share: Some((0.3, 0.4)),
            impact_speed: None,
        }
    }
}

/// Robustness against uncertain coefficients.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RobustnessChoices {
    /// Which drive.
    pub source: DriveSource,
    /// Whether the covariance of the last fit is taken in place of ranges.
    pub from_fit: bool,
    /// What is uncertain.
    pub coefficients: Vec<UncertainCoefficient>,
    /// Devices that are drawn.
    pub members: usize,
    /// Seed of the draw and of the search.
    pub seed: u64,
    /// What is wanted.
    pub wish: WishChoices,
    /// Horizontal axis of the map of probabilities.
    pub x: AxisChoice,
    /// Vertical axis.
    pub y: AxisChoice,
    /// Points along each axis.
    pub points: usize,
    /// Ids of the numbers of the drive that the search does not touch.
    pub held: BTreeSet<String>,
    /// Waveforms of a generation of the search, and generations.
    pub population: usize,
    /// See `population`.
    pub generations: usize,
}

/// Devices of a first ensemble, and points along each axis of its map: each point costs as many
/// steady states.
const FIRST_MEMBERS: usize = 32;
const FIRST_ROBUST_POINTS: usize = 24;
/// Numbers of a drive that a first search holds: how often the device taps is chosen, and a phase
/// changes nothing. Amplitudes of a drawn period are those of its handles.
const FIRST_HELD: [&str; 2] = ["frequency", "phase"];
/// Coefficients that the paper fits to its recordings: they are known least.
const FIRST_UNCERTAIN: [(&str, f64); 5] = [
    ("Cs", 1.5),
    ("gp", 1.1),
    ("Ca", 1.5),
    ("Ca0", 1.5),
    ("alpha", 1.2),
];

impl Default for RobustnessChoices {
    fn default() -> Self {
        let coefficients = FIRST_UNCERTAIN.map(|(id, factor)| UncertainCoefficient {
            id: id.to_owned(),
            factor,
        });
        let map = MapChoices::default();
        Self {
            source: DriveSource::Tune,
            from_fit: false,
            coefficients: coefficients.into(),
            members: FIRST_MEMBERS,
            seed: 1,
            wish: WishChoices::default(),
            x: map.x,
            y: map.y,
            points: FIRST_ROBUST_POINTS,
            held: FIRST_HELD.map(str::to_owned).into(),
            population: 16,
            generations: 12,
        }
    }
}
