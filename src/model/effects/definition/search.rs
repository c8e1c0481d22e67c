//! How a fit finds an effect: first guesses, bounds, and variations of its law.

use super::facts::{ContactLaw, Quantity};

/// How a fit finds an effect and refines its law.
#[derive(Debug, Clone, Copy)]
pub struct Search {
    /// What is searched for.
    pub found_by: FoundBy,
    /// Constants other than the strength make no sense below this.
    pub least_constant: fn(&Motion) -> f64,
    /// Bounds of some parameters in every fit.
    pub bounds: &'static [(usize, (f64, f64))],
    /// Where a fit begins if the law is too strong for any model without it.
    pub cold_start: Option<ColdStart>,
    /// Ids of parameters that stay fixed until the size of the effect is known: they would run
    /// away before.
    pub deferred: &'static [&'static str],
    /// How its law is refined, if shape parameters alone are no good start for that.
    pub refinement: Option<Refinement>,
    /// What its law leaves if its form is somewhat off, for its values.
    pub form_errors: fn(&[f64], &FormTolerance) -> Vec<FormError>,
}

impl Search {
    /// An effect that is found nowhere; `found_by` must be stated.
    pub const DEFAULT: Self = Self {
        found_by: FoundBy::Starts(|_| Vec::new()),
        least_constant: |_| 0.0,
        bounds: &[],
        cold_start: None,
        deferred: &[],
        refinement: None,
        form_errors: |_, _| Vec::new(),
    };
}

/// What a search for an effect varies.
#[derive(Debug, Clone, Copy)]
pub enum FoundBy {
    /// Its strength, from each of some first guesses: in each the simulation moves in proportion.
    Starts(fn(&Motion) -> Vec<Start>),
    /// The frequency of a steady sinusoid, with the values amplitude, frequency, phase.
    Frequency,
    /// The time of a step of the ground's level, with the values height, time.
    StepTime,
    /// The frequency of a vibration mode.
    ModeFrequency,
    /// Nothing: events at the ground show it.
    ContactEvents(ContactLaw),
}

/// A device and the size of its motion, by which first guesses are sized. SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Whether it has a drive.
    pub is_driven: bool,
    /// Whether it has a ground.
    pub has_ground: bool,
    /// Whether its mass hangs on a spring.
    pub is_sprung: bool,
    /// Distance from the zero position of the mass to the ground \[m\].
    pub contact_distance: f64,
    /// Largest displacement \[m\].
    pub length: f64,
    /// Usual speed \[m/s\].
    pub speed: f64,
    /// Force that goes with the largest displacement \[N\].
    pub force: f64,
    /// Time between samples \[s\].
    pub interval: f64,
}

/// A first guess of an effect: a direction in which the simulation moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Start {
    /// Values of its parameters, of a size at which it still acts in proportion.
    pub values: Vec<f64>,
    /// Which parameter is its strength.
    pub strength: usize,
    /// Whether the strength may be negative.
    pub signed: bool,
    /// Which parameters are fitted.
    pub free: &'static [usize],
    /// Which parameters shape the law, to be fitted as well once the effect has shown.
    pub shape: &'static [usize],
    /// Force that a unit of the first shape parameter makes at the largest displacement, if a
    /// fit's step of that may be too large for the device.
    pub shape_force: Option<f64>,
}

impl Start {
    /// A guess whose strength must not be negative.
    pub fn positive(values: &[f64], strength: usize, free: &'static [usize]) -> Self {
        Self {
            values: values.to_vec(),
            strength,
            signed: false,
            free,
            shape: &[],
            shape_force: None,
        }
    }

    /// A guess whose strength may have either sign.
    pub fn signed(values: &[f64], strength: usize, free: &'static [usize]) -> Self {
        Self {
            signed: true,
            ..Self::positive(values, strength, free)
        }
    }

    /// The same guess with shape parameters.
    pub fn shaped_by(self, shape: &'static [usize]) -> Self {
        Self { shape, ..self }
    }
}

/// Where a fit begins if the law is too strong for any model without it: the defaults with some
/// other values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColdStart {
    /// Parameters with another value than their default.
    pub set: &'static [(usize, f64)],
    /// Which parameters are fitted.
    pub free: &'static [usize],
}

/// Values from which a law can be fitted with its shape, from those fitted without it and the
/// voltage from lowest to highest \[V\]; `None` if those values are a good start already.
pub type RefinedStart = fn(&[f64], &dyn Fn() -> f64) -> Option<Vec<f64>>;

/// How a law that has shown is refined by its shape parameters.
#[derive(Debug, Clone, Copy)]
pub struct Refinement {
    /// Values from which all of them can be fitted.
    pub start: RefinedStart,
    /// Bounds in that fit.
    pub bounds: RefinedBounds,
    /// Values without the shape that come nearest to those with it; `None` without a shape.
    pub simplified: fn(&[f64]) -> Option<Vec<f64>>,
}

/// Bounds in the fit of a refined law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RefinedBounds {
    /// A lag, which may be as short as the shortest one that is looked for \[s\], whatever it was
    /// bounded by before.
    ShortestLag(usize, f64),
    /// Shape parameters that are bounded as others: pairs of the other and the shape parameter.
    Alike(&'static [(usize, usize)]),
}

/// By how much the form of a law may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FormTolerance {
    /// Share of the force.
    pub share: f64,
    /// Other time constants, as factors.
    pub times: [f64; 3],
    /// Lowest and highest voltage \[V\].
    pub volts: (f64, f64),
}

impl FormTolerance {
    /// `values` with one of them multiplied by [`Self::share`].
    pub fn scaled(&self, values: &[f64], strength: usize) -> Vec<f64> {
        let mut values = values.to_vec();
        values[strength] *= self.share;
        values
    }
}

/// What a law of somewhat other form adds to an effect.
#[derive(Debug, Clone, PartialEq)]
pub enum FormError {
    /// The effect once more with other values.
    Everywhere(Vec<f64>),
    /// The effect once more with other values, in each of some windows of a quantity.
    InWindows(Vec<f64>, Quantity),
    /// A force \[N\] in each of some windows of a quantity.
    ForceInWindows(f64, Quantity),
    /// A force of the drive, in units of `gc`, in each of some windows of the voltage.
    DriveInWindows(f64),
}
