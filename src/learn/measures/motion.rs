//! Numbers of a motion: arrivals, turns, loops and shares of a period.

use crate::learn::run::Run;
use crate::sim::{Event, EventKind, Trace};

pub(super) const NO_ARRIVAL: &str = "the mass does not arrive that often";
pub(super) const NO_CONTACT: &str = "no such contact ends within the run";
pub(super) const NO_PERIOD: &str = "the drive must repeat, and its period fit into the run";
pub(super) const NO_TURN: &str = "the mass does not turn that often";
pub(super) const NO_SAMPLES: &str = "it has no samples";

pub(super) fn arrivals(trace: &Trace) -> impl Iterator<Item = &Event> {
    let kinds = [EventKind::Impact, EventKind::Stick];
    trace.events.iter().filter(move |e| kinds.contains(&e.kind))
}

pub(super) fn releases(trace: &Trace) -> impl Iterator<Item = &Event> {
    trace.events.iter().filter(|e| e.kind == EventKind::Release)
}

/// Samples between two times \[s\].
fn between(trace: &Trace, values: &[f64], (from, to): (f64, f64)) -> Vec<f64> {
    let index = |t: f64| ((t - trace.t0) / trace.dt).max(0.0);
    let first = index(from).ceil() as usize;
    let last = (index(to).floor() as usize + 1).min(values.len());
    values.get(first..last).unwrap_or_default().to_vec()
}

pub(super) fn rebound_height(trace: &Trace, n: usize) -> Result<f64, &'static str> {
    let arrival = arrivals(trace).nth(n).ok_or(NO_ARRIVAL)?;
    let until = arrivals(trace).nth(n + 1).map_or(trace.end(), |e| e.time);
    let ground = trace.ground_level.ok_or(NO_ARRIVAL)?;
    let flight = between(trace, &trace.proof_mass, (arrival.time, until));
    // Nothing is sampled of a very short flight: it is as high as its speed carries it.
    Ok(flight.into_iter().fold(ground, f64::max) - ground)
}

pub(super) fn amplitude(run: &Run) -> f64 {
    let span = run.period.unwrap_or(0.1 * run.duration).min(run.duration);
    let last = between(
        &run.trace,
        &run.trace.proof_mass,
        (run.duration - span, run.duration),
    );
    let (low, high) = crate::recording::extremes(&last);
    0.5 * (high - low)
}

/// Time \[s\] and reading \[m\] of the `n`th turn at the top, from 0, by the velocity's zero between
/// two samples.
pub(super) fn maximum(trace: &Trace, n: usize) -> Result<(f64, f64), &'static str> {
    let pairs = trace.proof_mass_velocity.windows(2).enumerate();
    let mut turns = pairs.filter(|(i, pair)| {
        pair[0] > 0.0 && pair[1] <= 0.0 && !trace.in_contact(trace.time(*i + 1))
    });
    let (i, pair) = turns.nth(n).ok_or(NO_TURN)?;
    let share = pair[0] / (pair[0] - pair[1]);
    let time = trace.time(i) + share * trace.dt;
    let low = trace.proof_mass.get(i).copied().ok_or(NO_TURN)?;
    // The velocity falls linearly to 0 over this share of an interval.
    Ok((time, low + 0.5 * pair[0] * share * trace.dt))
}

fn last_period(run: &Run) -> Result<(f64, f64), &'static str> {
    let period = run.period.filter(|period| *period <= run.duration);
    let period = period.ok_or(NO_PERIOD)?;
    Ok((run.duration - period, run.duration))
}

pub(super) fn loop_width(run: &Run) -> Result<f64, &'static str> {
    let (from, to) = last_period(run)?;
    // A crossing at the very beginning of the period lies between two samples, too.
    let window = (from - 2.0 * run.trace.dt, to);
    let trace = &*run.trace;
    let volts = between(trace, &trace.voltage, window);
    let xp = between(trace, &trace.proof_mass, window);
    let (mut up, mut down) = (None, None);
    for (v, x) in volts.windows(2).zip(xp.windows(2)) {
        let (&[a, b], &[low, high]) = (v, x) else {
            continue;
        };
        if (a < 0.0) != (b < 0.0) {
            let at = low + (high - low) * a / (a - b);
            let side = if a < b { &mut up } else { &mut down };
            *side = Some(at);
        }
    }
    match (up, down) {
        (Some(up), Some(down)) => Ok((up - down).abs()),
        _ => Err("the voltage must pass 0 V both ways in the last period"),
    }
}

/// Shares of the last period: in contact, and with two feet half a period apart both up.
pub(super) fn shares(run: &Run) -> Result<(f64, f64), &'static str> {
    let (from, to) = last_period(run)?;
    let period = to - from;
    let held = |t: f64| run.trace.in_contact(from + (t - from).rem_euclid(period));
    let count = 20_000;
    let (mut own, mut both_up) = (0, 0);
    for i in 0..count {
        let t = from + period * (f64::from(i) + 0.5) / f64::from(count);
        let down = held(t);
        own += i32::from(down);
        both_up += i32::from(!down && !held(t + 0.5 * period));
    }
    let share = |n: i32| f64::from(n) / f64::from(count);
    Ok((share(own), share(both_up)))
}
