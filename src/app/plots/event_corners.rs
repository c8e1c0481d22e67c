//! The motion of the mass at its events, between two samples. An impact turns the motion within
//! nanoseconds; a straight line from one sample to the next would cut off the corner. The events
//! are known to 1 ns, so the line is drawn through them.

use crate::sim::{EventKind, Trace};

/// A point of the line: a sample next to events, or an event.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Corner {
    /// When \[s\].
    time: f64,
    /// Reading of the proof mass \[m\].
    value: f64,
    /// Velocity of the proof mass just before and just after [m/s].
    velocities: [f64; 2],
    /// Points between the same two samples have the same number.
    interval: usize,
    is_event: bool,
}

/// The points at the events of a run, in order of time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EventCorners(Vec<Corner>);

impl EventCorners {
    /// The corners of a run. The reading at an event follows from the velocities on both sides of
    /// it and the readings at the samples before and after.
    pub fn of(trace: &Trace) -> Self {
        let mut corners = Vec::new();
        let turns = |kind| kind != EventKind::DriveStep;
        let mut events = trace.events.iter().filter(|e| turns(e.kind)).peekable();
        while let Some(first) = events.next() {
            let position = (first.time - trace.t0) / trace.dt;
            if !(position.is_finite() && position >= 0.0) {
                continue;
            }
            let i = position as usize;
            let mut group = vec![*first];
            let end = trace.time(i + 1);
            while let Some(event) = events.next_if(|event| event.time < end) {
                group.push(*event);
            }
            let at = |values: &[f64], i: usize| values.get(i).copied();
            let known = (
                at(&trace.proof_mass, i),
                at(&trace.proof_mass, i + 1),
                at(&trace.proof_mass_velocity, i),
                at(&trace.proof_mass_velocity, i + 1),
            );
            let (Some(start), Some(stop), Some(v_start), Some(v_stop)) = known else {
                continue;
            };
            let (mut time, mut value, mut velocity) = (trace.time(i), start, v_start);
            let corner = |time, value, velocities, is_event| Corner {
                time,
                value,
                velocities,
                interval: i,
                is_event,
            };
            let from = corners.len();
            corners.push(corner(time, value, [v_start; 2], false));
            for event in &group {
                value += 0.5 * (velocity + event.velocity_before) * (event.time - time);
                (time, velocity) = (event.time, event.velocity_after);
                let velocities = [event.velocity_before, event.velocity_after];
                corners.push(corner(time, value, velocities, true));
            }
            value += 0.5 * (velocity + v_stop) * (end - time);
            // What the velocities do not know, such as a lag of the sensor, grows over the
            // interval: the line must meet the next sample.
            let missing = stop - value;
            for corner in &mut corners[from..] {
                corner.value += missing * (corner.time - trace.time(i)) / trace.dt;
            }
            corners.push(corner(end, stop, [v_stop; 2], false));
            if corners[from..]
                .iter()
                .any(|corner| !corner.value.is_finite())
            {
                corners.truncate(from);
            }
        }
        Self(corners)
    }

    /// The events from `from` to `to` \[s\]: time and reading.
    pub fn events(&self, from: f64, to: f64) -> impl Iterator<Item = [f64; 2]> {
        let first = self.0.partition_point(|corner| corner.time < from);
        let rest = self.0[first..].iter();
        rest.take_while(move |corner| corner.time <= to)
            .filter(|corner| corner.is_event)
            .map(|corner| [corner.time, corner.value])
    }

    /// Least and greatest velocity just before and after the events from `from` to `to` \[s\]
    /// [m/s].
    pub fn velocity_range(&self, from: f64, to: f64) -> Option<(f64, f64)> {
        let first = self.0.partition_point(|corner| corner.time < from);
        let in_view = self.0[first..].iter().take_while(|c| c.time <= to);
        let all = in_view.filter(|c| c.is_event).flat_map(|c| c.velocities);
        all.filter(|v| v.is_finite()).fold(None, |range, v| {
            let (low, high) = range.unwrap_or((v, v));
            Some((v.min(low), v.max(high)))
        })
    }

    /// The events between samples `i` and `i + 1`: reading and velocity, just before and after.
    pub fn between(&self, i: usize) -> impl Iterator<Item = [f64; 2]> {
        let first = self.0.partition_point(|corner| corner.interval < i);
        let here = self.0[first..].iter().take_while(move |c| c.interval == i);
        let events = here.filter(|corner| corner.is_event);
        events.flat_map(|corner| corner.velocities.map(|velocity| [corner.value, velocity]))
    }

    /// Reading at `t` \[s\] between two samples with an event between them, else `None`.
    pub fn value_at(&self, t: f64) -> Option<f64> {
        let after = self.0.partition_point(|corner| corner.time < t);
        let (right, left) = (self.0.get(after)?, self.0.get(after.checked_sub(1)?)?);
        if right.interval != left.interval {
            return None;
        }
        let share = (t - left.time) / (right.time - left.time);
        Some(left.value + share * (right.value - left.value))
    }
}

#[cfg(test)]
mod tests {
    use super::super::event_corners::*;
    use crate::sim::Event;

    /// Falls with 1 mm/s, bounces 4 us after a sample and rises with half the speed.
    pub fn bounce() -> Trace {
        let event = Event {
            time: 24e-6,
            kind: EventKind::Impact,
            velocity_before: -1e-3,
            velocity_after: 5e-4,
            pull_off_force: 0.0,
            contact_duration: 0.0,
        };
        Trace {
            dt: 20e-6,
            // The ground is at -58 um; 4 nm above it at the sample before.
            proof_mass: vec![-57.976e-6, -57.996e-6, -57.992e-6, -57.982e-6],
            proof_mass_velocity: vec![-1e-3, -1e-3, 5e-4, 5e-4],
            events: vec![event],
            ..Trace::default()
        }
    }

    #[test]
    fn the_line_reaches_the_ground_at_the_impact() {
        let corners = EventCorners::of(&bounce());
        let events: Vec<_> = corners.events(0.0, 1.0).collect();
        assert_eq!(events.len(), 1);
        assert_eq!(events[0][0], 24e-6);
        assert!((events[0][1] + 58e-6).abs() < 1e-15, "{:e}", events[0][1]);
        let value = |t| corners.value_at(t).unwrap();
        assert!((value(22e-6) + 57.998e-6).abs() < 1e-15);
        assert!((value(32e-6) + 57.996e-6).abs() < 1e-15);
        assert_eq!(corners.value_at(10e-6), None, "no event near");
        assert_eq!(corners.value_at(50e-6), None);
        // In the plane of displacement and velocity the impact is a vertical line at the ground.
        let plane: Vec<_> = corners.between(1).collect();
        assert_eq!(plane.len(), 2);
        assert_eq!([plane[0][1], plane[1][1]], [-1e-3, 5e-4]);
        assert_eq!(plane[0][0], plane[1][0]);
        assert_eq!(corners.between(0).count() + corners.between(2).count(), 0);
        assert_eq!(corners.velocity_range(0.0, 1.0), Some((-1e-3, 5e-4)));
    }

    #[test]
    fn several_bounces_between_two_samples_are_all_there() {
        let mut trace = bounce();
        let mut second = trace.events[0];
        second.time = 34e-6;
        second.velocity_before = -4e-4;
        second.velocity_after = 5e-4;
        trace.events.push(second);
        let corners = EventCorners::of(&trace);
        assert_eq!(corners.events(0.0, 1.0).count(), 2);
        assert_eq!(corners.events(30e-6, 1.0).count(), 1);
        // A run that ends at the event has no sample after it.
        trace.proof_mass.truncate(2);
        assert_eq!(EventCorners::of(&trace), EventCorners::default());
    }
}
