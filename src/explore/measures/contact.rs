//! What the events of a cycle tell: contacts, bounces, impacts, peaks.

use super::regime::begins_in_contact;
use crate::explore::steady_state::Cycle;
use crate::sim::{Event, EventKind};

/// Time in contact over the cycle \[s\]; bounces off a rigid ground take none.
pub(super) fn contact_time(cycle: &Cycle) -> f64 {
    let mut since = begins_in_contact(cycle).then_some(0.0);
    let mut total = 0.0;
    for event in &cycle.events {
        match event.kind {
            EventKind::Stick => since = since.or(Some(event.time)),
            EventKind::Release => {
                if let Some(start) = since.take() {
                    total += event.time - start;
                }
            }
            EventKind::Impact | EventKind::DriveStep => {}
        }
    }
    total + since.map_or(0.0, |start| cycle.duration - start)
}

/// Contacts that begin in the cycle, but for bounces.
pub(super) fn sticks(cycle: &Cycle) -> usize {
    count(cycle, EventKind::Stick)
}

/// Bounces in the cycle.
pub(super) fn bounces(cycle: &Cycle) -> usize {
    count(cycle, EventKind::Impact)
}

fn count(cycle: &Cycle, kind: EventKind) -> usize {
    cycle.events.iter().filter(|e| e.kind == kind).count()
}

/// Speed of the first arrival after the longest flight [m/s]: a tap begins with it.
pub(super) fn first_impact_speed(cycle: &Cycle) -> Option<f64> {
    let n = cycle.arrivals.len();
    let flight = |i: usize| {
        let arrival = cycle.arrivals[i].time;
        let before = if i == 0 {
            cycle.arrivals[n - 1].time - cycle.duration
        } else {
            cycle.arrivals[i - 1].time
        };
        // A contact that ends in between is no flight.
        let releases = cycle.events.iter().filter(|e| e.kind == EventKind::Release);
        let left = releases
            .flat_map(|e| [e.time - cycle.duration, e.time])
            .filter(|t| (before..arrival).contains(t));
        arrival - left.fold(before, f64::max)
    };
    let first = (0..n).max_by(|a, b| flight(*a).total_cmp(&flight(*b)))?;
    Some(cycle.arrivals[first].speed)
}

/// Largest speed of arrival [m/s].
pub(super) fn largest_impact_speed(cycle: &Cycle) -> Option<f64> {
    let speeds = cycle.arrivals.iter().map(|a| a.speed);
    speeds.reduce(f64::max)
}

/// Largest pull-off force at a release \[N\].
pub(super) fn pull_off_force(cycle: &Cycle) -> Option<f64> {
    let releases = cycle.events.iter().filter(|e| e.kind == EventKind::Release);
    releases.map(|e| e.pull_off_force).reduce(f64::max)
}

/// Events in which a rigid ground acts with an impulse.
fn impacts(cycle: &Cycle) -> impl Iterator<Item = &Event> {
    let is_rigid = !cycle.has_compliant_ground;
    let arrives = |kind| matches!(kind, EventKind::Impact | EventKind::Stick);
    let all = cycle.events.iter();
    all.filter(move |event| is_rigid && arrives(event.kind))
}

/// Kinetic energy that impacts take over the cycle \[J\]: an impulse on the mass alone changes that of
/// the whole structure by this.
pub(super) fn impact_loss(cycle: &Cycle) -> f64 {
    let lost = impacts(cycle).map(|e| e.velocity_before.powi(2) - e.velocity_after.powi(2));
    0.5 * cycle.impact_mass * lost.sum::<f64>()
}

/// Impulse of impacts over the cycle \[N s\].
pub(super) fn impact_impulse(cycle: &Cycle) -> f64 {
    let changes = impacts(cycle).map(|e| e.velocity_after - e.velocity_before);
    cycle.impact_mass * changes.sum::<f64>()
}
