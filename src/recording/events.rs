//! Contacts and impacts as the data show them, without a model.
//!
//! The mass *visits* the ground while it is no more than a hop (5 um) above the
//! contact level; hops below that do not end a visit. Within a visit it *touches*
//! where it is at the level to within the noise, or where straight lines through the
//! samples before and after a kink meet there (an impact between two samples).

use super::noise::estimate_noise;
use super::{TimeAxis, median_in_place};

/// Departures up to this height do not end a contact \[m\] (Table A.1's features).
pub const HOP: f64 = 5e-6;
/// Flattest thing that counts as touching, where there is no noise \[m\].
const LEAST_TOLERANCE: f64 = 5e-8;
/// Time on each side of an impact from which the speeds are fitted \[s\].
const FIT_SPAN: f64 = 1e-4;
/// Most and fewest samples on each side.
const FIT_SAMPLES: (usize, usize) = (3, 50);

/// A stay on the ground, small hops included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// First touch \[s\].
    pub start: f64,
    /// Last touch \[s\]; equal to `start` for a touch shorter than a sample.
    pub end: f64,
    /// Whether the recording (or a gap) cuts the contact, so that it may be longer.
    pub cut: bool,
}

impl Contact {
    /// `end - start` \[s\].
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.end - self.start
    }
}

/// A sudden change of speed at the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Impact {
    /// When \[s\], between samples.
    pub time: f64,
    /// Speed just before \[m/s\], negative (downwards).
    pub v_before: f64,
    /// Speed just after \[m/s\]; near zero if the mass stays.
    pub v_after: f64,
}

/// What happens at the ground.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Events {
    /// Contacts in order of time; between two of them the mass was higher than a hop.
    pub contacts: Vec<Contact>,
    /// Impacts in order of time.
    pub impacts: Vec<Impact>,
}

/// How events are looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EventOptions {
    /// Height of the mass at contact \[m\], `-dp` in the model.
    pub contact_level: f64,
    /// Standard deviation of the noise \[m\].
    pub noise: f64,
    /// Departures up to this height do not end a contact \[m\].
    pub hop: f64,
}

impl EventOptions {
    /// Options for a level; the noise is estimated from the data.
    #[must_use]
    pub fn for_data(contact_level: f64, time: TimeAxis, xp: &[f64]) -> Self {
        Self {
            contact_level,
            noise: estimate_noise(time, xp).map_or(0.0, |n| n.sigma),
            hop: HOP,
        }
    }

    /// How far from the level still counts as touching \[m\].
    #[must_use]
    pub fn tolerance(&self) -> f64 {
        (4.0 * self.noise).max(LEAST_TOLERANCE)
    }

    /// The hop height, kept clear of the noise \[m\].
    fn clear_hop(&self) -> f64 {
        self.hop.max(2.0 * self.tolerance())
    }
}

/// Finds contacts and impacts in `xp` \[m\] sampled at `time`. Missing samples and
/// gaps end a contact and mark it as cut. Empty results are no error: the mass may
/// never touch.
#[must_use]
pub fn find_events(time: TimeAxis, xp: &[f64], options: &EventOptions) -> Events {
    let mut events = Events::default();
    if !time.covers(xp.len()) || !options.contact_level.is_finite() {
        return events;
    }
    let visits = visits(time, xp, options);
    for (i, visit) in visits.iter().enumerate() {
        let limits = (
            i.checked_sub(1).map_or(0, |p| visits[p].last),
            visits.get(i + 1).map_or(xp.len() - 1, |v| v.first),
        );
        let impacts = impacts_in(time, xp, options, visit, limits);
        let contact = contact_of(time, xp, options, visit, &impacts);
        events.impacts.extend(impacts);
        events.contacts.extend(contact);
    }
    events
}

/// Samples `first..=last` within a hop of the ground.
#[derive(Debug, Clone, Copy)]
struct Visit {
    first: usize,
    last: usize,
    cut: bool,
}

fn visits(time: TimeAxis, xp: &[f64], options: &EventOptions) -> Vec<Visit> {
    // Two thresholds, so that noise at the edge does not make a departure.
    let enter = options.contact_level + options.clear_hop();
    let leave = enter + 2.0 * options.noise;
    let gap = super::GAP_FACTOR * time.interval(xp.len());
    let mut found: Vec<Visit> = Vec::new();
    let mut open: Option<Visit> = None;
    for (i, &x) in xp.iter().enumerate() {
        let broken = !x.is_finite() || (i > 0 && time.at(i) - time.at(i - 1) > gap);
        if broken && let Some(visit) = open.take() {
            found.push(Visit { cut: true, ..visit });
        }
        if !x.is_finite() {
            continue;
        }
        match &mut open {
            Some(visit) if x <= leave => visit.last = i,
            Some(visit) => {
                found.push(*visit);
                open = None;
            }
            None if x <= enter => {
                open = Some(Visit {
                    first: i,
                    last: i,
                    cut: i == 0 || broken || !xp[i - 1].is_finite(),
                });
            }
            None => {}
        }
    }
    if let Some(visit) = open {
        found.push(Visit { cut: true, ..visit });
    }
    found
}

/// First to last touch of a visit; `None` if the mass turned above the ground.
fn contact_of(
    time: TimeAxis,
    xp: &[f64],
    options: &EventOptions,
    visit: &Visit,
    impacts: &[Impact],
) -> Option<Contact> {
    let touch = options.contact_level + options.tolerance();
    let low = |i: &usize| xp[*i] <= touch;
    let first = (visit.first..=visit.last).find(low);
    let last = (visit.first..=visit.last).rev().find(low);
    // Where the straight line between two samples crosses the touching height.
    let crossing = |i: usize, j: usize| {
        let (t_i, t_j) = (time.at(i), time.at(j));
        let share = (touch - xp[i]) / (xp[j] - xp[i]);
        if share.is_finite() {
            t_i + (t_j - t_i) * share.clamp(0.0, 1.0)
        } else {
            t_i
        }
    };
    let (mut start, mut end) = match (first, last) {
        (Some(first), Some(last)) => (
            if first > visit.first {
                crossing(first - 1, first)
            } else {
                time.at(first)
            },
            if last < visit.last {
                crossing(last, last + 1)
            } else {
                time.at(last)
            },
        ),
        // Only between samples.
        _ => (impacts.first()?.time, impacts.last()?.time),
    };
    if let (Some(a), Some(b)) = (impacts.first(), impacts.last()) {
        start = start.min(a.time);
        end = end.max(b.time);
    }
    // The visit may begin at the very sample that touches: the fall took one sample.
    let cut = visit.cut
        && (first.is_some_and(|i| i == visit.first) || last.is_some_and(|i| i == visit.last));
    Some(Contact { start, end, cut })
}

/// Kinks of a visit that are impacts. `limits`: the last sample of the visit before
/// and the first of the next, which a fit must not reach.
fn impacts_in(
    time: TimeAxis,
    xp: &[f64],
    options: &EventOptions,
    visit: &Visit,
    limits: (usize, usize),
) -> Vec<Impact> {
    let n = xp.len();
    let slope = |i: usize| (xp[i + 1] - xp[i]) / (time.at(i + 1) - time.at(i));
    let kink = |i: usize| {
        if i == 0 || i + 1 >= n {
            return f64::NAN;
        }
        slope(i) - slope(i - 1)
    };
    let interval = time.interval(n);
    let threshold = 6.0 * options.noise * 6f64.sqrt() / interval;
    let from = visit.first.saturating_sub(1).max(1);
    let to = (visit.last + 1).min(n.saturating_sub(2));
    let mut candidates: Vec<usize> = Vec::new();
    for i in from..=to {
        let here = kink(i);
        if here.is_nan() || here <= threshold || here <= 0.0 {
            continue;
        }
        let rises = |j: Option<usize>| j.is_some_and(|j| j + 1 < n && kink(j) > here);
        // A kink between two samples shows at both; the larger one stands for it.
        if rises(i.checked_sub(1)) || rises(Some(i + 1)) {
            continue;
        }
        if candidates.last().is_none_or(|last| i - last >= 2) {
            candidates.push(i);
        }
    }
    let reach = ((FIT_SPAN / interval).round() as usize).clamp(FIT_SAMPLES.0, FIT_SAMPLES.1);
    let mut impacts = Vec::new();
    for (k, &i) in candidates.iter().enumerate() {
        // A fit stays on its own side of the neighbouring kinks.
        let left_end = k
            .checked_sub(1)
            .map_or(limits.0, |p| candidates[p] + 1)
            .min(i - 1);
        let right_end = candidates
            .get(k + 1)
            .map_or(limits.1, |next| next - 1)
            .max(i + 1);
        let left = left_end.max((i - 1).saturating_sub(reach - 1))..=i - 1;
        let right = i + 1..=right_end.min(i + reach).min(n - 1);
        let t_i = time.at(i);
        let (Some(before), Some(after)) = (side(time, xp, left, t_i), side(time, xp, right, t_i))
        else {
            continue;
        };
        // Where the two curves meet, near this sample.
        let meet = (before.0 - after.0) / (after.1 - before.1);
        let lower = time.at(i - 1) - t_i;
        let upper = time.at(i + 1) - t_i;
        let at = if meet.is_finite() {
            meet.clamp(lower, upper)
        } else {
            0.0
        };
        let v_before = before.1 + 2.0 * before.2 * at;
        let v_after = after.1 + 2.0 * after.2 * at;
        let height = before.0 + before.1 * at + before.2 * at * at;
        // Speeds from a few samples are uncertain by about this much.
        let blur = 4.0 * options.noise / (interval * (reach as f64).powf(1.5));
        let sudden = v_after - v_before > (0.3 * v_before.abs()).max(3.0 * blur);
        // Nothing leaves the ground faster than it came: that would be a push.
        let thrown = v_after > 1.2 * v_before.abs() + 2.0 * blur;
        let near = (height - options.contact_level).abs() <= options.clear_hop();
        if v_before < -blur && sudden && near && !thrown {
            impacts.push(Impact {
                time: t_i + at,
                v_before,
                v_after,
            });
        }
    }
    impacts
}

/// Value, slope and half the curvature at `origin` of a parabola (a line below four
/// samples) through the samples of one side; `None` below two finite ones.
fn side(
    time: TimeAxis,
    xp: &[f64],
    range: std::ops::RangeInclusive<usize>,
    origin: f64,
) -> Option<(f64, f64, f64)> {
    let points: Vec<(f64, f64)> = range
        .filter(|i| xp[*i].is_finite())
        .map(|i| (time.at(i) - origin, xp[i]))
        .collect();
    let n = points.len();
    if n < 2 {
        return None;
    }
    // Time in units of the window keeps the normal equations well conditioned.
    let unit = points.iter().fold(0.0, |m: f64, p| m.max(p.0.abs()));
    let order = if n >= 4 { 3 } else { 2 };
    let design = nalgebra::DMatrix::from_fn(n, order, |i, j| (points[i].0 / unit).powi(j as i32));
    let values = nalgebra::DVector::from_fn(n, |i, _| points[i].1);
    let solved = design.svd(true, true).solve(&values, 1e-12).ok()?;
    let curve = if order == 3 { solved[2] } else { 0.0 };
    Some((solved[0], solved[1] / unit, curve / unit / unit))
}

/// Median height while in contact \[m\]; `None` without contacts. Shows how the level
/// drifts or was guessed.
#[must_use]
pub fn resting_height(time: TimeAxis, xp: &[f64], contacts: &[Contact]) -> Option<f64> {
    let mut heights: Vec<f64> = Vec::new();
    let mut i = 0;
    for contact in contacts {
        while i < xp.len() && time.at(i) < contact.start {
            i += 1;
        }
        while i < xp.len() && time.at(i) <= contact.end {
            heights.extend(Some(xp[i]).filter(|x| x.is_finite()));
            i += 1;
        }
    }
    (!heights.is_empty()).then(|| median_in_place(&mut heights))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEVEL: f64 = -58e-6;

    /// A ball thrown at the ground with restitution: `(t, x)` in closed form.
    /// Falls from 20 um, bounces with factor `e`, rests below a speed, and is pulled off
    /// at `release`.
    fn bouncing(rate: f64, e: f64, release: f64) -> (Vec<f64>, Vec<(f64, f64)>) {
        let g = 2000.0;
        let mut impacts = Vec::new();
        let (mut t0, mut h0, mut v0) = (0.0, 20e-6, 0.0);
        let mut pieces = Vec::new();
        loop {
            let hit = (v0 + f64::sqrt(v0 * v0 + 2.0 * g * h0)) / g;
            let v = v0 - g * hit;
            pieces.push((t0, t0 + hit, h0, v0));
            let stays = impacts.len() == 2;
            impacts.push((t0 + hit, v));
            t0 += hit;
            h0 = 0.0;
            v0 = -e * v;
            if stays {
                break;
            }
        }
        let n = (0.02 * rate) as usize;
        let x = (0..n)
            .map(|i| {
                let t = i as f64 / rate;
                if t > release {
                    return LEVEL + 500.0 * (t - release).powi(2);
                }
                pieces
                    .iter()
                    .find(|p| t >= p.0 && t < p.1)
                    .map_or(LEVEL, |p| {
                        let s = t - p.0;
                        LEVEL + p.2 + p.3 * s - 0.5 * g * s * s
                    })
            })
            .collect();
        (x, impacts)
    }

    #[test]
    fn impacts_and_contact_of_a_bouncing_mass() {
        let (x, truth) = bouncing(50e3, 0.8, 10e-3);
        let axis = TimeAxis::Uniform { t0: 0.0, dt: 2e-5 };
        let options = EventOptions::for_data(LEVEL, axis, &x);
        let events = find_events(axis, &x, &options);
        assert_eq!(events.impacts.len(), 3, "{events:?}");
        for (k, (found, (t, v))) in events.impacts.iter().zip(&truth).enumerate() {
            assert!((found.time - t).abs() < 2e-6, "{found:?} {t}");
            assert!((found.v_before / v - 1.0).abs() < 0.02, "{found:?} {v}");
            let after = if k == 2 { 0.0 } else { -0.8 * v };
            assert!(
                (found.v_after - after).abs() < 0.02 * v.abs(),
                "{found:?} {after}"
            );
        }
        // The first hop rises by 0.64 of 20 um, the second by 0.41: both above 5 um.
        assert_eq!(events.contacts.len(), 3, "{events:?}");
        let rest = events.contacts[2];
        assert!(
            (rest.start - truth[2].0).abs() < 2e-6 && (rest.end - 10e-3).abs() < 2e-5,
            "{rest:?}"
        );
        let height = resting_height(axis, &x, &events.contacts).unwrap();
        assert!((height - LEVEL).abs() < 1e-9);
    }

    #[test]
    fn small_hops_are_merged() {
        let (x, truth) = bouncing(50e3, 0.4, 10e-3);
        let axis = TimeAxis::Uniform { t0: 0.0, dt: 2e-5 };
        let events = find_events(axis, &x, &EventOptions::for_data(LEVEL, axis, &x));
        assert_eq!(events.contacts.len(), 1);
        assert!((events.contacts[0].start - truth[0].0).abs() < 2e-6);
        assert!(!events.contacts[0].cut);
    }

    #[test]
    fn a_smooth_turn_above_the_ground_is_no_contact() {
        let x: Vec<f64> = (0..1000)
            .map(|i| LEVEL + 1e-6 + 30e-6 * (1.0 - (i as f64 * 0.02).cos()))
            .collect();
        let axis = TimeAxis::Uniform { t0: 0.0, dt: 2e-5 };
        let events = find_events(axis, &x, &EventOptions::for_data(LEVEL, axis, &x));
        assert_eq!(events, Events::default());
    }

    #[test]
    fn gaps_and_ends_cut_a_contact() {
        let mut x = vec![LEVEL; 100];
        x[50] = f64::NAN;
        let axis = TimeAxis::Uniform { t0: 0.0, dt: 2e-5 };
        let events = find_events(
            axis,
            &x,
            &EventOptions {
                contact_level: LEVEL,
                noise: 0.0,
                hop: HOP,
            },
        );
        assert_eq!(events.contacts.len(), 2);
        assert!(events.contacts.iter().all(|c| c.cut));
        let none = find_events(
            axis,
            &[],
            &EventOptions {
                contact_level: LEVEL,
                noise: 0.0,
                hop: HOP,
            },
        );
        assert_eq!(none, Events::default());
    }
}
