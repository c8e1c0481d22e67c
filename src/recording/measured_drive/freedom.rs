//! What of a known waveform the samples leave open: its period within what all edges allow, its
//! amplitude within noise and rounding, its ramps. Where readings of the motion are there, they
//! decide.

use super::Found;
use super::samples::Samples;

/// Most knots of a period whose phases are left open.
const MAX_OPEN_KNOTS: usize = 4;
/// Standard deviations that a freedom may be off.
const MAX_SIGMAS: f64 = 4.0;
/// Steps of a coarse digitiser over the span of a square wave that shows none of them.
const UNSEEN_STEPS: f64 = 128.0;

/// A number that the samples do not determine completely.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveFreedom {
    /// What it is.
    pub name: &'static str,
    /// Its unit; empty for a share.
    pub unit: &'static str,
    /// Standard deviation around 0.
    pub sigma: f64,
    /// Farthest from 0.
    pub most: f64,
}

/// The freedoms of what was found, in the order in which [`changed`] takes them.
pub fn of(samples: &Samples<'_>, found: &Found) -> Vec<DriveFreedom> {
    let volts = |sigma: f64| {
        let rounding = samples.quantum;
        (
            sigma.max(rounding / 12f64.sqrt()),
            MAX_SIGMAS * sigma + 0.5 * rounding,
        )
    };
    match found {
        Found::Cycle(cycle) => {
            let sigma = cycle.knots.iter().map(|k| k.sigma).fold(0.0, f64::max);
            let amplitude = cycle.amplitude().max(1e-12);
            let (mut sigma, mut most) = volts(sigma);
            // Levels alone do not show the step of a digitiser. Where they have no noise, it is
            // larger than the noise was.
            let levels = cycle.knots.iter().all(|k| k.jumps());
            let coarse = 2.0 * amplitude / UNSEEN_STEPS;
            if levels && !samples.is_noisy() && !is_setting(amplitude) {
                (sigma, most) = (coarse / 12f64.sqrt(), 0.5 * coarse);
            }
            let (low, high) = cycle.period_bounds;
            let off = |t: f64| (t / cycle.period - 1.0).abs();
            let stretch = off(low).max(off(high));
            let [factor, offset] = of_voltages(amplitude, sigma, most);
            let mut all = vec![
                DriveFreedom {
                    name: "period",
                    unit: "",
                    sigma: stretch,
                    most: stretch,
                },
                factor,
                offset,
            ];
            for knot in cycle.knots.iter().skip(1).take(MAX_OPEN_KNOTS) {
                let reach = (knot.bounds.1 - knot.time).max(knot.time - knot.bounds.0);
                all.push(DriveFreedom {
                    name: "phase of a corner or edge",
                    unit: "",
                    sigma: reach / cycle.period,
                    most: reach / cycle.period,
                });
            }
            all
        }
        Found::Sinusoids(sinusoids) => {
            let (Some(part), n) = (sinusoids.parts.first(), samples.len() as f64) else {
                return Vec::new();
            };
            let (sigma, most) = volts(samples.sigma * (2.0 / n).sqrt());
            let amplitude = part.amplitude.abs().max(1e-12);
            let span = samples.in_time();
            // A phase known to so many turns at both ends.
            let turns = part.time_sigma * part.from.abs();
            let stretch = 3.5 * turns / (part.from.abs() * (span.last - span.first));
            let [factor, offset] = of_voltages(amplitude, sigma, most);
            vec![
                DriveFreedom {
                    name: "frequency",
                    unit: "",
                    sigma: stretch,
                    most: MAX_SIGMAS * stretch,
                },
                factor,
                offset,
            ]
        }
        Found::Lines(_) | Found::Smooth | Found::Points | Found::Chosen(_) => Vec::new(),
    }
}

/// Factor on the amplitude and offset of a waveform whose voltages have standard deviation `sigma`
/// and are off by `most` at most \[V\].
fn of_voltages(amplitude: f64, sigma: f64, most: f64) -> [DriveFreedom; 2] {
    [
        DriveFreedom {
            name: "amplitude",
            unit: "",
            sigma: sigma / amplitude,
            most: most / amplitude,
        },
        DriveFreedom {
            name: "offset",
            unit: "V",
            sigma,
            most,
        },
    ]
}

/// Whether a voltage is one of two digits, as people set them.
fn is_setting(voltage: f64) -> bool {
    let two_digits: f64 = format!("{voltage:.1e}").parse().unwrap_or(f64::NAN);
    (two_digits - voltage).abs() < 1e-6 * voltage.abs()
}

/// What was found with its freedoms at `values`; `None` if it has none.
pub fn changed(found: &Found, values: &[f64]) -> Option<Found> {
    let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
    let shares = values.get(3..).unwrap_or_default();
    match found {
        Found::Cycle(cycle) => Some(Found::Cycle(cycle.changed(
            value(0),
            1.0 + value(1),
            value(2),
            shares,
        ))),
        Found::Sinusoids(sinusoids) => {
            let mut changed = sinusoids.clone();
            changed.offset += value(2);
            for part in &mut changed.parts {
                part.amplitude *= 1.0 + value(1);
                part.from *= 1.0 + value(0);
                part.rate *= 1.0 + value(0);
            }
            Some(Found::Sinusoids(changed))
        }
        Found::Lines(_) | Found::Smooth | Found::Points | Found::Chosen(_) => None,
    }
}
