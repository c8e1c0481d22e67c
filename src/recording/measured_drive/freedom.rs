//! What the samples leave open of a voltage: of a known waveform its period within what all edges
//! allow, its levels within noise and rounding, its corners; of a smoothed one the instants of its
//! turns. Where readings of the motion are there, they decide.

use super::pieces::open_turns;
use super::samples::Samples;
use super::thresholds::NOISE_REACH_SIGMAS;
use super::{DriveEdge, Found};
use crate::model::drive::Segment;

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
    /// The instant from which on it changes the motion \[s\]; minus infinity for all of it.
    pub acts_from: f64,
}

/// The freedoms of what was found, in the order in which [`changed`] takes them.
pub fn of(
    samples: &Samples<'_>,
    found: &Found,
    pieces: &[Segment],
    edges: &[DriveEdge],
) -> Vec<DriveFreedom> {
    let volts = |sigma: f64| {
        let rounding = samples.quantum;
        (
            sigma.max(rounding / 12f64.sqrt()),
            NOISE_REACH_SIGMAS * sigma + 0.5 * rounding,
        )
    };
    match found {
        Found::Cycle(cycle) => {
            let spread = cycle.spread.iter();
            let open = spread.flat_map(|s| s.directions.iter().map(|_| s.most));
            // The directions are in units of their standard deviations.
            open.map(|most| DriveFreedom {
                name: "period, corners and voltages together",
                unit: "standard deviations",
                sigma: 1.0,
                most,
                acts_from: f64::NEG_INFINITY,
            })
            .collect()
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
                    most: NOISE_REACH_SIGMAS * stretch,
                    acts_from: f64::NEG_INFINITY,
                },
                factor,
                offset,
            ]
        }
        Found::Smooth => {
            let open = open_turns(pieces, edges).into_iter();
            open.map(|k| DriveFreedom {
                name: "turn",
                unit: "s",
                sigma: edges[k].sigma,
                most: edges[k].reach,
                acts_from: edges[k].time - edges[k].reach,
            })
            .collect()
        }
        Found::Lines(_) | Found::Points | Found::Chosen(_) => Vec::new(),
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
            acts_from: f64::NEG_INFINITY,
        },
        DriveFreedom {
            name: "offset",
            unit: "V",
            sigma,
            most,
            acts_from: f64::NEG_INFINITY,
        },
    ]
}

/// What was found with its freedoms at `values`; `None` if it has none or they are its turns.
pub fn changed(found: &Found, values: &[f64]) -> Option<Found> {
    let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
    match found {
        Found::Cycle(cycle) => Some(Found::Cycle(cycle.changed(values))),
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
