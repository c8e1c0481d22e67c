//! Numbers of a run that a lesson may state or ask for.

use super::expression::ExpressionError;
use super::run::Run;
use crate::model::parameter::ParameterId;
use crate::sim::{Event, EventKind, Trace};

/// Rows of the table of measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunMeasure {
    /// Name in a lesson.
    pub id: &'static str,
    /// SI unit; empty without one.
    pub unit: &'static str,
    /// What it is, in a sentence.
    pub meaning: &'static str,
    /// Whether there can be several, counted from 1: `impact_speed(2)`.
    pub is_counted: bool,
    kind: Kind,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Impacts,
    Contacts,
    ArrivalTime,
    ImpactSpeed,
    ReboundSpeed,
    ReboundHeight,
    ContactTime,
    LongestContact,
    ReleaseForce,
    FilmForce,
    Highest,
    Lowest,
    PeakToPeak,
    EndDisplacement,
    Amplitude,
    Maximum,
    MaximumTime,
    SwingTime,
    LoopWidth,
    ContactShare,
    BothUpShare,
    FilmLoss,
    BounceLoss,
    StickingLoss,
    DampingLoss,
    DriveWork,
    Period,
    Duration,
    ProofMass,
    FirstFrequency,
    StaticGap,
}

const fn one(id: &'static str, unit: &'static str, kind: Kind, text: &'static str) -> RunMeasure {
    RunMeasure {
        id,
        unit,
        meaning: text,
        is_counted: false,
        kind,
    }
}

const fn each(id: &'static str, unit: &'static str, kind: Kind, text: &'static str) -> RunMeasure {
    RunMeasure {
        is_counted: true,
        ..one(id, unit, kind, text)
    }
}

/// All measures.
pub const RUN_MEASURES: [RunMeasure; 31] = [
    one(
        "impacts",
        "",
        Kind::Impacts,
        "arrivals at the ground, sticking ones included",
    ),
    one("contacts", "", Kind::Contacts, "contacts that last"),
    each(
        "arrival_time",
        "s",
        Kind::ArrivalTime,
        "when the mass arrives at the ground",
    ),
    each(
        "impact_speed",
        "m/s",
        Kind::ImpactSpeed,
        "speed just before an arrival",
    ),
    each(
        "rebound_speed",
        "m/s",
        Kind::ReboundSpeed,
        "speed just after an arrival; 0 if the mass sticks",
    ),
    each(
        "rebound_height",
        "m",
        Kind::ReboundHeight,
        "greatest height over the ground after an arrival, before the next one",
    ),
    each(
        "contact_time",
        "s",
        Kind::ContactTime,
        "length of a contact that has ended",
    ),
    one(
        "longest_contact",
        "s",
        Kind::LongestContact,
        "length of the longest contact that has ended",
    ),
    each(
        "release_force",
        "N",
        Kind::ReleaseForce,
        "pull-off force at a release",
    ),
    one(
        "film_force",
        "N",
        Kind::FilmForce,
        "largest force of the gas film",
    ),
    one("highest", "m", Kind::Highest, "highest reading of the mass"),
    one("lowest", "m", Kind::Lowest, "lowest reading of the mass"),
    one(
        "peak_to_peak",
        "m",
        Kind::PeakToPeak,
        "highest less lowest reading",
    ),
    one(
        "end_displacement",
        "m",
        Kind::EndDisplacement,
        "reading at the end of the run",
    ),
    one(
        "amplitude",
        "m",
        Kind::Amplitude,
        "half of highest less lowest over the last period of the drive, or the last tenth of the run",
    ),
    each(
        "maximum",
        "m",
        Kind::Maximum,
        "reading where the mass turns at the top",
    ),
    each(
        "maximum_time",
        "s",
        Kind::MaximumTime,
        "when the mass turns at the top",
    ),
    each(
        "swing_time",
        "s",
        Kind::SwingTime,
        "from one turn at the top to the next",
    ),
    one(
        "loop_width",
        "m",
        Kind::LoopWidth,
        "distance of the two branches of the last loop at 0 V",
    ),
    one(
        "contact_share",
        "",
        Kind::ContactShare,
        "share of the last period of the drive in contact",
    ),
    one(
        "both_up_share",
        "",
        Kind::BothUpShare,
        "share of the last period in which neither this foot nor one half a period later is down",
    ),
    one(
        "film_loss",
        "J",
        Kind::FilmLoss,
        "energy lost in the gas film",
    ),
    one(
        "bounce_loss",
        "J",
        Kind::BounceLoss,
        "energy lost in impacts that bounce",
    ),
    one(
        "sticking_loss",
        "J",
        Kind::StickingLoss,
        "energy lost in impacts that stick",
    ),
    one(
        "damping_loss",
        "J",
        Kind::DampingLoss,
        "energy lost in the damping of the modes",
    ),
    one("drive_work", "J", Kind::DriveWork, "work of the drive"),
    one("period", "s", Kind::Period, "period of the drive"),
    one("duration", "s", Kind::Duration, "length of the run"),
    one("proof_mass", "kg", Kind::ProofMass, "mass at the tip"),
    one(
        "ring_frequency",
        "Hz",
        Kind::FirstFrequency,
        "one over the time from the first turn at the top to the next",
    ),
    one(
        "film_at_contact",
        "m",
        Kind::StaticGap,
        "thickness of the gas film that is left at contact",
    ),
];

/// A measure by name.
pub fn find(id: &str) -> Option<&'static RunMeasure> {
    RUN_MEASURES.iter().find(|spec| spec.id == id)
}

/// The names of all measures, for messages.
pub fn names() -> String {
    let names: Vec<&str> = RUN_MEASURES.iter().map(|spec| spec.id).collect();
    names.join(", ")
}

/// Value of a measure of a run \[SI\]; of the first occurrence if none is named.
///
/// # Errors
/// [`ExpressionError`]: none of that name, or the run does not have it.
pub fn value(run: &Run, id: &str, nth: Option<usize>) -> Result<f64, ExpressionError> {
    let unknown = || ExpressionError::Unknown {
        name: id.to_owned(),
        known: names(),
    };
    let spec = find(id).ok_or_else(unknown)?;
    if nth.is_some() && !spec.is_counted {
        return Err(unknown());
    }
    let found = of_run(run, spec.kind, nth.unwrap_or(1) - 1);
    found.map_err(|why| ExpressionError::Missing {
        name: id.to_owned(),
        which: nth.map_or_else(String::new, |n| format!(" number {n}")),
        why,
    })
}

const NO_ARRIVAL: &str = "the mass does not arrive that often";
const NO_CONTACT: &str = "no such contact ends within the run";
const NO_PERIOD: &str = "the drive must repeat, and its period fit into the run";
const NO_TURN: &str = "the mass does not turn that often";
const NO_SAMPLES: &str = "it has no samples";

fn of_run(run: &Run, kind: Kind, n: usize) -> Result<f64, &'static str> {
    let trace = &*run.trace;
    let energies = run.energies.last();
    let arrival = || arrivals(trace).nth(n).ok_or(NO_ARRIVAL);
    let range = || crate::recording::extremes(&trace.proof_mass);
    Ok(match kind {
        Kind::Impacts => arrivals(trace).count() as f64,
        Kind::Contacts => trace.contacts.len() as f64,
        Kind::ArrivalTime => arrival()?.time,
        Kind::ImpactSpeed => arrival()?.velocity_before.abs(),
        Kind::ReboundSpeed => arrival()?.velocity_after.abs(),
        Kind::ReboundHeight => rebound_height(trace, n)?,
        Kind::ContactTime => releases(trace).nth(n).ok_or(NO_CONTACT)?.contact_duration,
        Kind::LongestContact => {
            let all = releases(trace).map(|event| event.contact_duration);
            all.reduce(f64::max).ok_or(NO_CONTACT)?
        }
        Kind::ReleaseForce => releases(trace).nth(n).ok_or(NO_CONTACT)?.pull_off_force,
        Kind::FilmForce => {
            let forces = trace.forces.as_ref().ok_or(NO_SAMPLES)?;
            forces
                .film
                .iter()
                .fold(0.0, |most: f64, f| most.max(f.abs()))
        }
        Kind::Highest => range().1,
        Kind::Lowest => range().0,
        Kind::PeakToPeak => range().1 - range().0,
        Kind::EndDisplacement => *trace.proof_mass.last().ok_or(NO_SAMPLES)?,
        Kind::Amplitude => amplitude(run),
        Kind::Maximum => maximum(trace, n)?.1,
        Kind::MaximumTime => maximum(trace, n)?.0,
        Kind::SwingTime => maximum(trace, n + 1)?.0 - maximum(trace, n)?.0,
        Kind::LoopWidth => loop_width(run)?,
        Kind::ContactShare => shares(run)?.0,
        Kind::BothUpShare => shares(run)?.1,
        Kind::FilmLoss => energies.film,
        Kind::BounceLoss => energies.bounces,
        Kind::StickingLoss => energies.sticking,
        Kind::DampingLoss => energies.damping,
        Kind::DriveWork => energies.drive_work,
        Kind::Period => run.period.ok_or(NO_PERIOD)?,
        Kind::Duration => run.duration,
        Kind::ProofMass => run.model.proof_mass,
        Kind::FirstFrequency => 1.0 / (maximum(trace, 1)?.0 - maximum(trace, 0)?.0),
        Kind::StaticGap => {
            run.model.parameters[ParameterId::Gp] - run.model.parameters[ParameterId::Dp]
        }
    })
}

fn arrivals(trace: &Trace) -> impl Iterator<Item = &Event> {
    let kinds = [EventKind::Impact, EventKind::Stick];
    trace.events.iter().filter(move |e| kinds.contains(&e.kind))
}

fn releases(trace: &Trace) -> impl Iterator<Item = &Event> {
    trace.events.iter().filter(|e| e.kind == EventKind::Release)
}

/// Samples between two times \[s\].
fn between(trace: &Trace, values: &[f64], (from, to): (f64, f64)) -> Vec<f64> {
    let index = |t: f64| ((t - trace.t0) / trace.dt).max(0.0);
    let first = index(from).ceil() as usize;
    let last = (index(to).floor() as usize + 1).min(values.len());
    values.get(first..last).unwrap_or_default().to_vec()
}

fn rebound_height(trace: &Trace, n: usize) -> Result<f64, &'static str> {
    let arrival = arrivals(trace).nth(n).ok_or(NO_ARRIVAL)?;
    let until = arrivals(trace).nth(n + 1).map_or(trace.end(), |e| e.time);
    let ground = trace.ground_level.ok_or(NO_ARRIVAL)?;
    let flight = between(trace, &trace.proof_mass, (arrival.time, until));
    // Nothing is sampled of a very short flight: it is as high as its speed carries it.
    Ok(flight.into_iter().fold(ground, f64::max) - ground)
}

fn amplitude(run: &Run) -> f64 {
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
fn maximum(trace: &Trace, n: usize) -> Result<(f64, f64), &'static str> {
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

fn loop_width(run: &Run) -> Result<f64, &'static str> {
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
fn shares(run: &Run) -> Result<(f64, f64), &'static str> {
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
