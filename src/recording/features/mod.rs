//! The features of Table A.1: peak oscillation amplitude, contact duration, bounces,
//! per period and in the periodic steady state.
//!
//! J. H. Ryou, K. R. Oldham, J. Micromech. Microeng. 22 (2012) 115002, Table A.1. The
//! paper names the three features; they are read here as:
//! - peak oscillation amplitude: highest `xp` reached after break-off while the
//!   voltage falls or is held, minus the lowest `xp`;
//! - contact duration: total time in contact, hops under 5 um merged;
//! - bounces: departures of more than 5 um before the sustained contact; 0 where no
//!   contact is sustained (longer than 0.2 ms).
//!
//! The same function serves recordings and simulated traces.

use self::period::{Cycle, find_cycles};
use super::events::{Contact, EventOptions, Events, HOP_HEIGHT, find_events};
use super::grid::TimeAxis;
use super::level::estimate_contact_level;
use super::noise::estimate_noise;
use super::{Channel, Recording, median_in_place};

pub(crate) mod missing;
pub mod period;
mod words;

pub use self::missing::Missing;

/// A contact longer than this is sustained \[s\].
pub const SUSTAINED: f64 = 2e-4;
/// Peaks within this share of the later ones are steady.
const STEADY_PEAK: f64 = 0.1;
/// Contacts within this share (and [`SUSTAINED`]) of the later ones are steady.
const STEADY_CONTACT: f64 = 0.25;

/// What is known beforehand; whatever is `None` is found from the data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeatureOptions {
    /// Height of the mass at contact \[m\], `-dp`.
    pub contact_level: Option<f64>,
    /// Period of the drive \[s\].
    pub period: Option<f64>,
    /// Standard deviation of the noise of `xp` \[m\].
    pub noise: Option<f64>,
    /// Hops up to this height are merged \[m\].
    pub hop: f64,
    /// Contacts longer than this are sustained \[s\].
    pub sustained: f64,
}

impl Default for FeatureOptions {
    fn default() -> Self {
        Self {
            contact_level: None,
            period: None,
            noise: None,
            hop: HOP_HEIGHT,
            sustained: SUSTAINED,
        }
    }
}

/// Features of one period, from one rise of the voltage to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeriodFeatures {
    /// Start of the period \[s\].
    pub start: f64,
    /// End of the period \[s\].
    pub end: f64,
    /// Peak oscillation amplitude \[m\]; `None` if the mass is never free while the
    /// voltage falls or is held.
    pub peak_amplitude: Option<f64>,
    /// Time in contact \[s\]; `None` if the contact level is unknown.
    pub contact_duration: Option<f64>,
    /// Bounces before the sustained contact; `None` if the contact level is unknown.
    pub bounces: Option<u32>,
    /// Whether samples are missing inside (the period does not count in the mean).
    pub gap: bool,
}

/// Mean and standard deviation over the steady periods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Standard deviation over periods (of the population; 0 for one period).
    pub std: f64,
}

/// The periodic steady state.
#[derive(Debug, Clone, PartialEq)]
pub struct SteadyState {
    /// Index of the first steady period.
    pub first: usize,
    /// Number of periods averaged.
    pub periods: usize,
    /// Peak oscillation amplitude \[m\].
    pub peak_amplitude: Option<Spread>,
    /// Contact duration per period \[s\]; `None` if the contact level is unknown.
    pub contact_duration: Option<Spread>,
    /// Bounces per period; `None` if the contact level is unknown.
    pub bounces: Option<Spread>,
}

/// Features with everything they rest on.
#[derive(Debug, Clone, PartialEq)]
pub struct Features {
    /// Standard deviation of the noise of `xp` that was used \[m\].
    pub noise: f64,
    /// The contact level \[m\], given or found, or why there is none.
    pub contact_level: Result<f64, Missing>,
    /// The period \[s\], given or found, or why there is none.
    pub period: Result<f64, Missing>,
    /// Contacts and impacts; empty if the contact level is unknown.
    pub events: Events,
    /// Features of each whole period.
    pub periods: Vec<PeriodFeatures>,
    /// Means of the steady state, or why there is none.
    pub steady: Result<SteadyState, Missing>,
}

/// [`features`] of a recording.
#[must_use]
pub fn recording_features(recording: &Recording, options: &FeatureOptions) -> Features {
    let voltage = recording.channel(Channel::Voltage);
    features(recording.axis(), voltage, &recording.proof_mass, options)
}

/// Features of `xp` \[m\] and `voltage` \[V\] sampled at `time` (a recording or a
/// simulated trace). Never fails as a whole: each part that cannot be had says why.
#[must_use]
pub fn features(
    time: TimeAxis,
    voltage: Option<&[f64]>,
    xp: &[f64],
    options: &FeatureOptions,
) -> Features {
    if !time.covers(xp.len()) || voltage.is_some_and(|v| v.len() != xp.len()) {
        return Features {
            noise: 0.0,
            contact_level: Err(Missing::BadInput),
            period: Err(Missing::BadInput),
            events: Events::default(),
            periods: Vec::new(),
            steady: Err(Missing::BadInput),
        };
    }
    let estimate = estimate_noise(time, xp).ok();
    let noise = options
        .noise
        .or(estimate.map(|n| n.sigma))
        .filter(|s| s.is_finite())
        .unwrap_or(0.0);
    let contact_level = match options.contact_level.filter(|l| l.is_finite()) {
        Some(level) => Ok(level),
        None => estimate_contact_level(time, voltage, xp, estimate),
    };
    let events = match contact_level {
        Ok(contact_level) => {
            let options = EventOptions {
                contact_level,
                noise,
                hop: options.hop,
            };
            find_events(time, xp, &options)
        }
        Err(_) => Events::default(),
    };
    let cycles = find_cycles(time, voltage, xp.len(), options.period, &events.contacts);
    let widest = super::assemble::GAP_FACTOR * time.interval(xp.len());
    let periods: Vec<PeriodFeatures> = cycles
        .iter()
        .flatten()
        .map(|cycle| {
            let contacts = contact_level.is_ok().then_some(events.contacts.as_slice());
            period_features((time, widest), xp, cycle, contacts, options.sustained)
        })
        .collect();
    let period = cycles.and_then(|cycles| {
        let mut lengths: Vec<f64> = cycles.iter().map(|c| c.end - c.start).collect();
        match options.period {
            Some(period) => Ok(period),
            None if lengths.is_empty() => Err(Missing::TooFewPeriods { found: 0 }),
            None => Ok(median_in_place(&mut lengths)),
        }
    });
    let steady = match &period {
        Ok(_) => steady_state(&periods),
        Err(reason) => Err(reason.clone()),
    };
    Features {
        noise,
        contact_level,
        period,
        events,
        periods,
        steady,
    }
}

/// Index of the first sample at or after `t`, by bisection.
fn index_at(time: TimeAxis, n: usize, t: f64) -> usize {
    let (mut low, mut high) = (0, n);
    while low < high {
        let middle = (low + high) / 2;
        if time.at(middle) < t {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    low
}

/// Features of one cycle. Samples farther apart than `widest` \[s\] have a gap between them;
/// `contacts` are all of them, in order of time.
fn period_features(
    (time, widest): (TimeAxis, f64),
    xp: &[f64],
    cycle: &Cycle,
    contacts: Option<&[Contact]>,
    sustained: f64,
) -> PeriodFeatures {
    let n = xp.len();
    let (from, to) = (index_at(time, n, cycle.start), index_at(time, n, cycle.end));
    let inside = &xp[from..to];
    let lowest = inside
        .iter()
        .copied()
        .filter(|x| x.is_finite())
        .fold(f64::INFINITY, f64::min);
    let gap = inside.iter().any(|x| !x.is_finite())
        || (from + 1..to).any(|i| time.at(i) - time.at(i - 1) > widest);
    let all = contacts.unwrap_or_default();
    let first = all.partition_point(|c| c.end < cycle.start);
    let own: Vec<Contact> = all[first..]
        .iter()
        .take_while(|c| c.start < cycle.end)
        .copied()
        .collect();

    // The mass is free from its last break-off before the voltage rises again; without
    // a contact from where the voltage begins to fall.
    let free_from = own
        .iter()
        .map(|c| c.end)
        .filter(|end| *end < cycle.rise)
        .fold(f64::NEG_INFINITY, f64::max);
    let free_from = if free_from.is_finite() {
        free_from
    } else {
        cycle.fall
    };
    let window = index_at(time, n, free_from)..index_at(time, n, cycle.rise).min(to);
    let stuck = own
        .iter()
        .any(|c| c.start <= free_from && c.end >= cycle.rise);
    let highest = xp
        .get(window)
        .unwrap_or_default()
        .iter()
        .copied()
        .filter(|x| x.is_finite())
        .fold(f64::NEG_INFINITY, f64::max);
    let amplitude = highest - lowest;
    let peak_amplitude = (!stuck && amplitude.is_finite()).then_some(amplitude);

    let (contact_duration, bounces) = match contacts {
        None => (None, None),
        Some(_) => {
            // Of a contact that the period cuts, the same share is on the ground.
            let clipped = |c: &Contact| {
                let inside = (c.end.min(cycle.end) - c.start.max(cycle.start)).max(0.0);
                if c.duration() > 0.0 {
                    inside * c.touching / c.duration()
                } else {
                    0.0
                }
            };
            let total: f64 = own.iter().map(clipped).sum();
            // Each contact before the sustained one ended in a departure.
            let bounces = own
                .iter()
                .position(|c| c.duration() > sustained)
                .unwrap_or(0);
            (Some(total), Some(bounces as u32))
        }
    };
    PeriodFeatures {
        start: cycle.start,
        end: cycle.end,
        peak_amplitude,
        contact_duration,
        bounces,
        gap,
    }
}

/// Finds from which period on the motion repeats, and averages from there.
fn steady_state(periods: &[PeriodFeatures]) -> Result<SteadyState, Missing> {
    let whole: Vec<(usize, &PeriodFeatures)> =
        periods.iter().enumerate().filter(|(_, p)| !p.gap).collect();
    if whole.len() < 2 {
        return Err(Missing::TooFewPeriods { found: whole.len() });
    }
    let later = &whole[whole.len() / 2..];
    let median = |value: &dyn Fn(&PeriodFeatures) -> Option<f64>| {
        let mut values: Vec<f64> = later.iter().filter_map(|(_, p)| value(p)).collect();
        (!values.is_empty()).then(|| median_in_place(&mut values))
    };
    let peak = median(&|p| p.peak_amplitude);
    let contact = median(&|p| p.contact_duration);
    let alike = |p: &PeriodFeatures| {
        let close =
            |value: Option<f64>, usual: Option<f64>, share: f64, floor: f64| match (value, usual) {
                (Some(value), Some(usual)) => (value - usual).abs() <= (share * usual).max(floor),
                (None, None) => true,
                _ => false,
            };
        close(p.peak_amplitude, peak, STEADY_PEAK, 0.0)
            && close(p.contact_duration, contact, STEADY_CONTACT, SUSTAINED)
    };
    let unlike = later.iter().filter(|(_, p)| !alike(p)).count();
    // A mass that bounces differently now and then is still steady in the mean.
    if 3 * unlike > later.len() {
        return Err(Missing::NotSteady {
            unlike,
            periods: later.len(),
        });
    }
    let early = &whole[..whole.len() / 2];
    let skip = early
        .iter()
        .rposition(|(_, p)| !alike(p))
        .map_or(0, |i| i + 1);
    let steady = &whole[skip..];
    let spread = |value: &dyn Fn(&PeriodFeatures) -> Option<f64>| {
        let values: Vec<f64> = steady.iter().filter_map(|(_, p)| value(p)).collect();
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let std = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
        (!values.is_empty()).then_some(Spread { mean, std })
    };
    Ok(SteadyState {
        first: steady.first().map_or(0, |(i, _)| *i),
        periods: steady.len(),
        peak_amplitude: spread(&|p| p.peak_amplitude),
        contact_duration: spread(&|p| p.contact_duration),
        bounces: spread(&|p| p.bounces.map(f64::from)),
    })
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
