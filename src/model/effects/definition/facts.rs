//! Properties of an effect's law that decisions ask for, in the model's terms.

use crate::model::parameter::Parameters;

/// Properties of an effect's law. [`Facts::DEFAULT`] has none of them.
#[derive(Debug, Clone, Copy)]
pub struct Facts {
    /// Ids of the parameters that switch the effect off where all of them are 0; none for a law
    /// that has no strength.
    pub strengths: &'static [&'static str],
    /// Whether its force depends on the displacement of the mass more than on anything else.
    pub force_over_displacement: bool,
    /// For an attraction to the ground: how it falls off with height, for its values.
    pub falls_off: Option<fn(&[f64]) -> FallOff>,
    /// Which parameter is a friction force \[N\] that is the same at all heights and speeds.
    pub friction_force: Option<usize>,
    /// For added vibration modes: how the parameters of one mode are laid out.
    pub modes: Option<ModeLayout>,
    /// Whether it moves the zero of the readings by `a (1 - exp(-t/tau)) + b t`, with the values
    /// a, tau, b: the level at which the mass lies shows that course.
    pub is_zero_course: bool,
    /// Which parameter is a time by which readings are late as a whole \[s\]. It acts as a shift
    /// between the clocks of voltage and readings.
    pub reading_delay: Option<usize>,
    /// Parameters by which edges of the voltage appear late and rounded in the readings.
    pub edge_lags: &'static [EdgeLag],
    /// Id of an effect that looks the same in flight and differs at impacts only. One of the two
    /// names the other.
    pub twin_in_flight: Option<&'static str>,
    /// Laws of the ground that it makes doubtful: it acts where their events are read.
    pub obscures: &'static [ContactLaw],
    /// Largest force \[N\] by values and device, for a force that no single instant shows.
    pub largest_force: Option<fn(&[f64], &Parameters) -> f64>,
    /// Whether parameter number `i` has any influence for these values; see
    /// [`super::ActiveEffect::bears`].
    pub is_felt: fn(&[f64], usize) -> bool,
    /// Id of its strength, if peaks, contacts and counted bounces of a sweep of frequencies
    /// determine that: it can then be fitted to a table of such features.
    pub feature_strength: Option<&'static str>,
}

impl Facts {
    /// A law without special properties.
    pub const DEFAULT: Self = Self {
        strengths: &[],
        force_over_displacement: false,
        falls_off: None,
        friction_force: None,
        modes: None,
        is_zero_course: false,
        reading_delay: None,
        edge_lags: &[],
        twin_in_flight: None,
        obscures: &[],
        largest_force: None,
        is_felt: |_, _| true,
        feature_strength: None,
    };
}

/// Laws of the ground in the baseline that an effect may replace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactLaw {
    /// Restitution, constant in the baseline.
    Restitution,
    /// Adhesion, linear in contact time in the baseline.
    Adhesion,
    /// The ground itself, rigid in the baseline.
    Compliance,
}

/// An attraction that falls off with height `h` as `(h0 / (h + h0))^n`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FallOff {
    /// `h0` \[m\].
    pub reach: f64,
    /// `n`.
    pub exponent: f64,
}

/// How the parameters of added modes are laid out: those of one mode after the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ModeLayout {
    /// Parameters of each mode.
    pub per_mode: usize,
    /// Which of these is its frequency.
    pub frequency: usize,
    /// The first of its shapes; all after it are shapes, too.
    pub first_shape: usize,
}

/// A parameter by which edges of the voltage appear late and rounded in the readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EdgeLag {
    /// Which parameter.
    pub parameter: usize,
    /// What lags.
    pub kind: LagKind,
}

/// What lags behind an edge of the voltage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LagKind {
    /// The drive, which settles with a time constant \[s\].
    DriveSettles,
    /// The drive, whose voltage changes at a bounded rate \[s/V\].
    DriveSlews,
    /// The readings, which settle with a time constant \[s\].
    Readings,
}

/// A quantity that a force may depend on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Displacement of the proof mass.
    Displacement,
    /// Velocity of the proof mass.
    Velocity,
    /// Voltage.
    Voltage,
}

impl Quantity {
    /// Its symbol, as on an axis.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Displacement => "xp",
            Self::Velocity => "xp'",
            Self::Voltage => "V",
        }
    }
}

/// The picture in which an effect shows best.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EvidenceFigure {
    /// The missing force over a quantity.
    Force(Quantity),
    /// The residual over a quantity.
    Residual(Quantity),
    /// The residual over the time since the last event.
    RingDown,
    /// Readings of events at the ground.
    Events(EventFigure),
    /// The residual over time.
    Time,
}

/// Pictures of events at the ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventFigure {
    /// Restitution over approach speed.
    Restitution,
    /// Contact duration of bounces over approach speed.
    Dwell,
    /// Adhesion over contact time.
    Adhesion,
    /// Level of the ground over time.
    Level,
}
