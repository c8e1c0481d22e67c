//! The cycles of a drive, from its recorded voltage.

use super::missing::Missing;
use crate::recording::events::Contact;
use crate::recording::grid::TimeAxis;
use crate::recording::noise::estimate_noise;
use crate::recording::{median_in_place, quantile_in_place};

/// Cycles whose lengths differ by more than this share are not periodic.
const MAX_LENGTH_DEVIATION: f64 = 0.03;
/// Share of the swing that counts as being at the top or at the bottom.
const EDGE_SHARE: f64 = 0.02;

/// Samples by which a recording may end before or after the end of its last period.
const MAX_END_INTERVALS: f64 = 1.5;

/// One cycle of the drive. All times in seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cycle {
    /// The voltage crosses its middle upwards.
    pub start: f64,
    /// It does so again.
    pub end: f64,
    /// The voltage leaves its top: from here it falls or is held low.
    pub fall: f64,
    /// The voltage leaves its bottom: from here it rises.
    pub rise: f64,
}

/// The whole cycles among `n` samples. With a given `period` and no voltage the
/// cycles are laid so that no contact crosses their ends.
///
/// # Errors
/// [`Missing`] if there is neither a period nor a periodic voltage.
pub fn find_cycles(
    time: TimeAxis,
    voltage: Option<&[f64]>,
    n: usize,
    period: Option<f64>,
    contacts: &[Contact],
) -> Result<Vec<Cycle>, Missing> {
    match (voltage, period.filter(|p| p.is_finite() && *p > 0.0)) {
        (Some(voltage), period) => match from_voltage(time, voltage) {
            Err(_) if period.is_some() => Ok(by_clock(time, n, period.unwrap_or(1.0), contacts)),
            found => found,
        },
        (None, Some(period)) => Ok(by_clock(time, n, period, contacts)),
        (None, None) => Err(Missing::NoVoltage),
    }
}

/// Cycles by the clock: each starts a little before a contact would.
fn by_clock(time: TimeAxis, n: usize, period: f64, contacts: &[Contact]) -> Vec<Cycle> {
    let Some(last) = n.checked_sub(1) else {
        return Vec::new();
    };
    let (from, to) = (time.at(0), time.at(last));
    let phase = contacts
        .iter()
        .find(|c| !c.cut)
        .map_or(0.0, |c| (c.start - 0.05 * period - from).rem_euclid(period));
    let whole = ((to - from - phase) / period + 1e-9).floor();
    // More cycles than samples would be no cycles.
    if !(whole >= 1.0 && whole <= n as f64) {
        return Vec::new();
    }
    (0..whole as usize)
        .map(|k| from + phase + k as f64 * period)
        .map(|start| Cycle {
            start,
            end: start + period,
            // Without a voltage nothing is known of its fall: the whole cycle counts.
            fall: start,
            rise: start + period,
        })
        .collect()
}

/// First and last sample at the top or the bottom.
type Stay = (usize, usize);

/// When the voltage leaves its top or bottom \[s\]: at the end of a plateau, but in the
/// middle of a turn such as a sine's, where it goes back from one sample to the next.
/// A turn is about `edge` \[V\] deep, a plateau as deep as the noise.
fn leaving(time: TimeAxis, voltage: &[f64], (first, last): Stay, edge: f64) -> f64 {
    let (from, to) = (time.at(first), time.at(last));
    let mean = |low: f64, high: f64| {
        let (mut sum, mut count) = (0.0, 0);
        for (i, &v) in voltage.iter().enumerate().take(last + 1).skip(first) {
            let place = (2.0 * time.at(i) - from - to) / (to - from);
            if v.is_finite() && (low..=high).contains(&place.abs()) {
                sum += v;
                count += 1;
            }
        }
        (count > 0).then(|| sum / f64::from(count))
    };
    let (Some(edges), Some(middle)) = (mean(0.5, 1.0), mean(0.0, 0.2)) else {
        return to;
    };
    // How far the outermost samples are from the extreme tells the depth of the stay; of
    // a parabola's depth the outer half keeps 0.58, of a plateau's next to nothing.
    let depth = 0.5 * (voltage[first] + voltage[last]) - middle;
    if depth.abs() > 0.3 * edge && (edges - middle) * depth.signum() > 0.3 * depth.abs() {
        0.5 * (from + to)
    } else {
        to
    }
}

/// The regular cycles of a recorded voltage, from one upward crossing of its middle to the
/// next.
fn from_voltage(time: TimeAxis, voltage: &[f64]) -> Result<Vec<Cycle>, Missing> {
    let levels = Levels::of(time, voltage)?;
    let Passages {
        mut crossings,
        tops,
        bottoms,
    } = Passages::of(time, voltage, &levels);
    let first = (0..voltage.len()).find(|i| voltage[*i].is_finite());
    // A square that starts at its top has just risen, a sine that starts at its middle just rises:
    // the period counts from there.
    let begins_at_top = first.is_some_and(|i| voltage[i] >= levels.top);
    let begins_a_cycle =
        begins_at_top || first.is_some_and(|i| (voltage[i] - levels.middle).abs() <= levels.band);
    let begin = first.filter(|_| begins_a_cycle).map(|i| time.at(i));
    let end = (0..voltage.len()).rfind(|i| voltage[*i].is_finite());
    let end = end.map_or(f64::NAN, |i| time.at(i));
    let slack = MAX_END_INTERVALS * time.interval(voltage.len());
    // Two periods with a single rise between them.
    if let ([only], Some(begin)) = (&crossings[..], begin)
        && (only + (only - begin) - end).abs() <= slack
    {
        crossings = vec![begin, *only, only + (only - begin)];
    }
    if crossings.len() < 2 {
        return Err(if crossings.is_empty() && tops.is_empty() {
            Missing::ConstantVoltage
        } else {
            let found = crossings.len().min(usize::from(begins_a_cycle));
            Missing::TooFewPeriods { found }
        });
    }
    let lengths: Vec<f64> = crossings.windows(2).map(|w| w[1] - w[0]).collect();
    let usual = median_in_place(&mut lengths.clone());
    if let Some(begin) = begin.filter(|t| *t < crossings[0])
        && ((crossings[0] - begin) / usual - 1.0).abs() <= MAX_LENGTH_DEVIATION
    {
        crossings.insert(0, begin);
    }
    // The recording ends where the voltage would rise again: its last period is whole, too.
    let next = crossings[crossings.len() - 1] + usual;
    if (next - end).abs() <= slack {
        crossings.push(next);
    }
    let mut deviations: Vec<f64> = lengths.iter().map(|l| (l / usual - 1.0).abs()).collect();
    // The upper quartile: a gap or two may lengthen a few cycles, a sweep changes most.
    let spread = quantile_in_place(&mut deviations, 0.75);
    if spread > MAX_LENGTH_DEVIATION {
        return Err(Missing::NotPeriodic {
            spread_percent: 100.0 * spread,
        });
    }
    let last_between = |events: &[f64], from: f64, to: f64| {
        let end = events.partition_point(|t| *t <= to);
        end.checked_sub(1).map(|i| events[i]).filter(|t| *t >= from)
    };
    Ok(crossings
        .windows(2)
        .filter(|w| ((w[1] - w[0]) / usual - 1.0).abs() <= 2.0 * MAX_LENGTH_DEVIATION)
        .map(|w| {
            let (start, end) = (w[0], w[1]);
            Cycle {
                start,
                end,
                fall: last_between(&tops, start, end).unwrap_or(start),
                rise: last_between(&bottoms, start, end).unwrap_or(end),
            }
        })
        .collect())
}

/// The levels of a voltage against which its passages are counted \[V\].
struct Levels {
    /// Above this it is at its top.
    top: f64,
    /// Half way between lowest and highest.
    middle: f64,
    /// Below this it is at its bottom.
    bottom: f64,
    /// Depth of the zones at top and bottom.
    edge: f64,
    /// Half width of the band around the middle in which nothing is decided.
    band: f64,
}

impl Levels {
    fn of(time: TimeAxis, voltage: &[f64]) -> Result<Self, Missing> {
        let mut sorted: Vec<f64> = voltage.iter().copied().filter(|v| v.is_finite()).collect();
        if sorted.len() < 4 {
            return Err(Missing::TooShort {
                samples: sorted.len(),
            });
        }
        let low = quantile_in_place(&mut sorted, 0.005);
        let high = quantile_in_place(&mut sorted, 0.995);
        let range = high - low;
        let noise = estimate_noise(time, voltage).map_or(0.0, |n| n.sigma);
        if range.is_nan() || range <= 10.0 * noise || range <= 1e-9 * high.abs().max(low.abs()) {
            return Err(Missing::ConstantVoltage);
        }
        let edge = (EDGE_SHARE * range).max(3.0 * noise);
        Ok(Self {
            top: high - edge,
            middle: 0.5 * (high + low),
            bottom: low + edge,
            edge,
            band: 0.1 * range,
        })
    }
}

/// When a voltage passes its middle upwards, leaves its top and leaves its bottom \[s\].
#[derive(Default)]
struct Passages {
    crossings: Vec<f64>,
    tops: Vec<f64>,
    bottoms: Vec<f64>,
}

impl Passages {
    fn of(time: TimeAxis, voltage: &[f64], levels: &Levels) -> Self {
        let Levels {
            top,
            middle,
            bottom,
            edge,
            band,
        } = *levels;
        let mut passages = Self::default();
        // Upward crossings of the middle, armed by having been clearly below it.
        let mut armed = false;
        let (mut was_top, mut was_bottom): (Option<Stay>, Option<Stay>) = (None, None);
        let mut previous: Option<(f64, f64)> = None;
        let mut pending: Option<f64> = None;
        for (i, &v) in voltage.iter().enumerate() {
            if !v.is_finite() {
                continue;
            }
            let t = time.at(i);
            if let Some((t_before, v_before)) = previous {
                if v_before < middle && v >= middle {
                    pending =
                        Some(t_before + (t - t_before) * (middle - v_before) / (v - v_before));
                } else if v < middle {
                    pending = None;
                }
            }
            if v < middle - band {
                armed = true;
                if let Some(stay) = was_top.take() {
                    passages.tops.push(leaving(time, voltage, stay, edge));
                }
            }
            if v > middle + band {
                if let (true, Some(crossing)) = (armed, pending) {
                    passages.crossings.push(crossing);
                    armed = false;
                }
                if let Some(stay) = was_bottom.take() {
                    passages.bottoms.push(leaving(time, voltage, stay, edge));
                }
            }
            if v >= top {
                was_top = Some((was_top.map_or(i, |(first, _)| first), i));
            }
            if v <= bottom {
                was_bottom = Some((was_bottom.map_or(i, |(first, _)| first), i));
            }
            previous = Some((t, v));
        }
        // A turn at the end that the voltage has left, but not as far as its middle.
        let last = voltage.iter().rposition(|v| v.is_finite());
        let has_left = |stay: &Stay| last.is_some_and(|last| stay.1 < last);
        if let Some(stay) = was_top.filter(has_left) {
            passages.tops.push(leaving(time, voltage, stay, edge));
        }
        if let Some(stay) = was_bottom.filter(has_left) {
            passages.bottoms.push(leaving(time, voltage, stay, edge));
        }
        passages
    }
}
