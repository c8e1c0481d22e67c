//! What the events at the ground add.

use super::stretch::jumps_within;
use super::{Made, Normal};
use crate::diagnose::trial::hybrid::{Event, Kind};
use crate::diagnose::trial::rig::Instruments;

/// A stay of fewer samples is not told from a bounce.
const STAY: f64 = 6.0;
/// Samples after a jump of the drive in which it may be what tears the mass off.
const TORN: f64 = 4.0;

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
            // Where a step of the drive tore it off, the pull says nothing of adhesion: it grows by
            // many times that within the sample in which the step was, nobody knows when.
            Kind::Release
                if event.contact * instruments.rate > STAY
                    && !(event.torn || torn(made, event.time, instruments.rate)) =>
            {
                // The held cantilever's stiffness against the mass is about 0.07 N/m.
                let held = (0.07 * sigma / samples.sqrt()).max(3e-10);
                let force = held.hypot(event.rate * instant(made, event, samples, instruments));
                let line = made.plain.ca * event.contact + made.plain.ca0;
                let row = [(base + 2, event.contact), (base + 3, 1.0)];
                normal.add(&row, event.pull - line, 1.0 / (force * force));
            }
            _ => {}
        }
    }
}

/// Whether the drive jumped just before `time` \[s\].
fn torn(made: &Made<'_>, time: f64, rate: f64) -> bool {
    !jumps_within(made.pieces, time - TORN / rate, time).is_empty()
}

/// Standard error of the instant of a release \[s\], as the mass shows it that flies off, pulled
/// more and more, over so many samples.
fn instant(made: &Made<'_>, event: &Event, samples: f64, instruments: &Instruments) -> f64 {
    let mobility = made.plain.structure.mobility;
    let (pull, growth) = (event.pull * mobility, event.rate.max(0.0) * mobility);
    let moved = |i: usize| {
        let after = i as f64 / instruments.rate;
        pull * after + 0.5 * growth * after * after
    };
    let told: f64 = (1..=samples as usize).map(|i| moved(i).powi(2)).sum();
    instruments.noise / told.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::trial::dice::Dice;
    use crate::diagnose::trial::hybrid::Run;
    use crate::diagnose::trial::rig::{self, StructureKind};
    use crate::diagnose::trial::voltage::{Waveform, pieces};

    const RATE: f64 = 50e3;
    const SQUARE: Waveform = Waveform::Square {
        frequency: 50.0,
        amplitude: 7.0,
    };

    /// A release at `time` whose pull grows by `rate`.
    fn release(time: f64, rate: f64) -> Event {
        Event {
            time,
            kind: Kind::Release,
            before: 0.0,
            after: 0.0,
            level: -60e-6,
            pull: 80e-9,
            rate,
            contact: 5e-3,
            torn: false,
        }
    }

    /// Information on adhesion at touch \[1/N^2\] in a release under a square wave of 50 Hz, after
    /// which the mass touches again `flight` \[s\] later.
    fn told(event: Event, flight: f64) -> f64 {
        let (plain, _) = rig::device(StructureKind::Lumped, &mut Dice::new(5, 0)).unwrap();
        let instruments = rig::instruments(RATE, 20e-9, true, 9, &mut Dice::new(5, 1));
        let run = Run {
            events: vec![
                event,
                Event {
                    time: event.time + flight,
                    kind: Kind::Stick,
                    ..event
                },
            ],
            ..Run::default()
        };
        let made = Made {
            run: &run,
            plain: &plain,
            pieces: &pieces(&SQUARE, 0.1),
            times: &[],
        };
        let mut normal = Normal {
            matrix: nalgebra::DMatrix::zeros(6, 6),
            right: nalgebra::DVector::zeros(6),
            energy: 0.0,
        };
        add_events(&mut normal, &made, 0, 4, &instruments);
        normal.matrix[(3, 3)]
    }

    #[test]
    fn a_release_tells_the_less_of_adhesion_the_faster_the_pull_grows() {
        // For a mass that is seen to fly for long the instant is known too well to matter.
        for (flight, held) in [(400e-6, 3.13e-10), (85e-6, 6.79e-10)] {
            let quiet = told(release(0.035, 0.0), flight).sqrt();
            assert!((quiet * held - 1.0).abs() < 0.02, "{quiet}");
            let quick = told(release(0.035, 2e-3), flight).sqrt();
            println!("{flight}: {quick} of {quiet}");
            let share = quick / quiet;
            if flight > 1e-4 {
                assert!(share > 0.95, "{share}");
            } else {
                assert!(share < 0.8, "{share}");
            }
        }
    }

    #[test]
    fn a_step_of_the_drive_that_tears_the_mass_off_tells_nothing_of_adhesion() {
        let step = 0.03;
        let told = |after: f64| told(release(step + after, 0.0), 1e-3);
        assert_eq!(told(30e-6), 0.0);
        assert!(told(200e-6) > 0.0);
        assert!(told(-30e-6) > 0.0);
    }
}
