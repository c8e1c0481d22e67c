//! Vibration modes of an Euler-Bernoulli cantilever with a rigid mass at its end.
//!
//! `EI w'''' = m w^2 w` with `w = w' = 0` at the clamp and, for a mass `M` with moment of inertia
//! `J` about its centre, which lies `d` beyond the end,
//! `EI w''' = -W^2 M (w + d w')`, `EI w'' = W^2 ((J + M d^2) w' + M d w)`
//! (S. S. Rao, Vibration of Continuous Systems, 2007, ch. 11). The shape is written as
//! `a exp(-k x) + b exp(-k (L - x)) + c cos(k x) + e sin(k x)`, which loses no digits in high modes,
//! as cosh and sinh do. The roots are of the determinant for `a` and `b`.

use std::f64::consts::{PI, TAU};

use super::section::BeamDesign;
use crate::model::bisection::bisect;
use crate::model::design::error::DesignError;

/// A mode of the beam, mass-normalised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamMode {
    /// Natural frequency \[Hz\].
    pub frequency: f64,
    /// Wave number times length, `k L`.
    pub wave_number: f64,
    /// Shape at the middle of the beam [kg^-1/2].
    pub middle: f64,
    /// Shape at the end of the beam [kg^-1/2].
    pub end: f64,
    /// Shape at the centre of the end mass [kg^-1/2].
    pub mass_centre: f64,
    /// Difference of the slopes at the ends of the piezo layer [kg^-1/2 m^-1]: by it a bending moment
    /// acts on the mode.
    pub piezo_slope: f64,
}

/// Step of `k L` in the search of roots. Modes of a beam are a good unit apart; where a very
/// heavy mass brings them together, they are still hundreds of steps apart.
const ROOT_STEP: f64 = 2e-3;
/// First `k L` that is looked at: an end mass of 1e14 beams.
const FIRST_WAVE_NUMBER: f64 = 4e-4;
/// Panels of the integral of the shape's square, each by Gauss's rule of five points.
const PANELS: usize = 128;

/// Nodes and weights of Gauss's rule of five points on -1 .. 1.
const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

/// The shape for given `k` and factors of the two exponentials.
#[derive(Debug, Clone, Copy)]
struct Shape {
    k: f64,
    length: f64,
    a: f64,
    b: f64,
}

impl Shape {
    /// Deflection and its first three derivatives, each divided by that power of `k`.
    fn at(&self, x: f64) -> [f64; 4] {
        let Self { k, length, a, b } = *self;
        let from_clamp = a * (-k * x).exp();
        let from_end = b * (-k * (length - x)).exp();
        let at_clamp = b * (-k * length).exp();
        let (c, e) = (-(a + at_clamp), a - at_clamp);
        let (sin, cos) = (k * x).sin_cos();
        [
            from_clamp + from_end + c * cos + e * sin,
            -from_clamp + from_end - c * sin + e * cos,
            from_clamp + from_end - c * cos - e * sin,
            -from_clamp + from_end + c * sin - e * cos,
        ]
    }

    fn integral_of_square(&self) -> f64 {
        let half = 0.5 * self.length / PANELS as f64;
        let panel = |i: usize| -> f64 {
            let middle = (2 * i + 1) as f64 * half;
            let point = |(x, weight): &(f64, f64)| weight * self.at(middle + half * x)[0].powi(2);
            GAUSS.iter().map(point).sum()
        };
        half * (0..PANELS).map(panel).sum::<f64>()
    }
}

/// Residuals of the two conditions at the end, of shear and moment, without units.
fn end_conditions(design: &BeamDesign, shape: &Shape) -> [f64; 2] {
    let [w, w1, w2, w3] = shape.at(design.length);
    let end = &design.end_mass;
    // `W^2 / EI = k^4 / m`.
    let (k, m) = (shape.k, design.section.mass_per_length);
    let mass = end.mass * k / m;
    let offset = end.offset * k;
    let inertia = end.inertia * k * k * k / m;
    [
        w3 + mass * (w + offset * w1),
        w2 - (inertia + mass * offset * offset) * w1 - mass * offset * w,
    ]
}

/// Conditions at the end for `(a, b) = (1, 0)` and `(0, 1)`.
fn system(design: &BeamDesign, k: f64) -> [[f64; 2]; 2] {
    let unit = |a: f64, b: f64| {
        let shape = Shape {
            k,
            length: design.length,
            a,
            b,
        };
        end_conditions(design, &shape)
    };
    [unit(1.0, 0.0), unit(0.0, 1.0)]
}

fn determinant(design: &BeamDesign, k: f64) -> f64 {
    let [[p, q], [r, s]] = system(design, k);
    p * s - q * r
}

/// The first modes of the beam, in order of frequency. Shapes have the sign that makes them positive
/// at the beam's middle.
///
/// # Errors
/// [`DesignError`] for values that no beam has.
///
/// # Examples
/// ```
/// use impactscope::model::design::{BeamDesign, EndMass, Section, beam_modes};
///
/// let beam = BeamDesign::new(1.0, Section::given(1.0, 1.0)?, EndMass::default(), 2);
/// let modes = beam_modes(&beam)?;
/// assert!((modes[0].wave_number - 1.875104068711961).abs() < 1e-9);
/// assert!((modes[1].wave_number - 4.694091132974174).abs() < 1e-9);
/// # Ok::<(), impactscope::model::design::DesignError>(())
/// ```
pub fn beam_modes(design: &BeamDesign) -> Result<Vec<BeamMode>, DesignError> {
    design.check()?;
    let length = design.length;
    let value = |kl: f64| determinant(design, kl / length);
    let mut modes = Vec::with_capacity(design.modes);
    // The end mass adds two freedoms to the beam's one for each pi.
    let last = (design.modes as f64 + 3.0) * PI;
    let (mut low, mut at_low) = (FIRST_WAVE_NUMBER, value(FIRST_WAVE_NUMBER));
    while modes.len() < design.modes && low < last {
        let step = ROOT_STEP.min(0.05 * low);
        let high = low + step;
        let at_high = value(high);
        if at_low * at_high < 0.0 || at_high == 0.0 {
            let root = bisect(low, high, |kl| (value(kl) < 0.0) != (at_low < 0.0));
            modes.push(mode(design, root / length));
            // A root exactly at the end of a step counts once.
            low = high + if at_high == 0.0 { 1e-9 * step } else { 0.0 };
            at_low = value(low);
            continue;
        }
        (low, at_low) = (high, at_high);
    }
    if modes.len() < design.modes {
        let reason = format!(
            "{} were found, {} were asked for; the masses of beam and end are too far apart",
            modes.len(),
            design.modes
        );
        return Err(DesignError::value("modes", reason));
    }
    Ok(modes)
}

fn mode(design: &BeamDesign, k: f64) -> BeamMode {
    let [[p, q], [r, s]] = system(design, k);
    // The better of the two rows of the singular system.
    let (a, b) = if p.abs() + r.abs() > q.abs() + s.abs() {
        (-r, p)
    } else {
        (-s, q)
    };
    // One exponential may be far larger than the other.
    let scale = a.abs().max(b.abs());
    let shape = Shape {
        k,
        length: design.length,
        a: a / scale,
        b: b / scale,
    };
    let [end, end_slope, ..] = shape.at(design.length);
    let end_slope = k * end_slope;
    let mass = &design.end_mass;
    let centre = end + mass.offset * end_slope;
    let middle = shape.at(0.5 * design.length)[0];
    let modal_mass = design.section.mass_per_length * shape.integral_of_square()
        + mass.mass * centre * centre
        + mass.inertia * end_slope * end_slope;
    let sign = if middle >= 0.0 { 1.0 } else { -1.0 };
    let factor = sign / modal_mass.sqrt();
    let slope = |x: f64| k * shape.at(x)[1];
    let stiffness_over_mass = design.section.stiffness / design.section.mass_per_length;
    BeamMode {
        frequency: stiffness_over_mass.sqrt() * k * k / TAU,
        wave_number: k * design.length,
        middle: factor * middle,
        end: factor * end,
        mass_centre: factor * centre,
        piezo_slope: factor * (slope(design.piezo_span.1) - slope(design.piezo_span.0)),
    }
}
