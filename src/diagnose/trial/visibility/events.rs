//! What the events at the ground add.

use super::{Made, Normal};
use crate::diagnose::trial::hybrid::Kind;
use crate::diagnose::trial::rig::Instruments;

/// Rows of the events: restitution, level of the ground, pull-off force.
pub(super) fn add_events(
    normal: &mut Normal,
    made: &Made<'_>,
    base: usize,
    zeros: usize,
    instruments: &Instruments,
) {
    let sigma = instruments.noise;
    let events = &made.run.events;
    for (i, event) in events.iter().enumerate() {
        let before = i.checked_sub(1).map_or(0.0, |j| events[j].time);
        let after = events.get(i + 1).map_or(f64::INFINITY, |e| e.time);
        let flight = (event.time - before).min(after - event.time).min(4e-4);
        let samples = flight * instruments.rate;
        if samples < 4.0 {
            continue;
        }
        let level_sigma = 2.0 * sigma / samples.sqrt();
        normal.add(
            &[(base, -1.0), (zeros, 1.0)],
            event.level + made.plain.dp,
            1.0 / level_sigma.powi(2),
        );
        match event.kind {
            Kind::Impact if event.before < -5e-3 => {
                // Slope at the end of a parabola through the samples.
                let slope = 4.0 * sigma * instruments.rate * (12.0 / samples.powi(3)).sqrt();
                let expected = -made.plain.alpha * event.before;
                let variance = slope * slope * (1.0 + made.plain.alpha.powi(2));
                let row = [(base + 1, -event.before)];
                normal.add(&row, event.after - expected, 1.0 / variance);
            }
            // Where a step of the drive tore it off, the pull says nothing of adhesion.
            Kind::Release if !event.torn => {
                // The held cantilever's stiffness against the mass is about 0.07 N/m.
                let force = (0.07 * sigma / samples.sqrt()).max(3e-10);
                let line = made.plain.ca * event.contact + made.plain.ca0;
                let row = [(base + 2, event.contact), (base + 3, 1.0)];
                normal.add(&row, event.pull - line, 1.0 / (force * force));
            }
            _ => {}
        }
    }
}
