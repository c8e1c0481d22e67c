//! What the events at the ground add.

use super::normal_equations::{CaseRun, NormalEquations};
use super::stretch::jumps_within;
use crate::trial::device::structure::dot;
use crate::trial::hybrid::{Event, Kind};
use crate::trial::instrument::Instruments;
use crate::trial::voltage::Piece;

/// A release within so many samples after a jump of the drive was caused by it.
const TEAR_SAMPLES: f64 = 4.0;

/// Rows of the events: restitution, level of the ground, pull-off force.
pub(crate) fn add_events(
    normal: &mut NormalEquations,
    case: &CaseRun<'_>,
    base: usize,
    zeros: usize,
    instruments: &Instruments,
) {
    let sigma = instruments.noise;
    let events = &case.run.events;
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
            event.level + case.plain.dp,
            1.0 / level_sigma.powi(2),
        );
        match event.kind {
            Kind::Impact if event.before < -5e-3 => {
                // Slope at the end of a parabola through the samples.
                let slope = 4.0 * sigma * instruments.rate * (12.0 / samples.powi(3)).sqrt();
                let expected = -case.plain.alpha * event.before;
                let variance = slope * slope * (1.0 + case.plain.alpha.powi(2));
                let row = [(base + 1, -event.before)];
                normal.add(&row, event.after - expected, 1.0 / variance);
            }
            // Where a step of the drive tore it off at once, the pull says nothing of adhesion.
            Kind::Release if !event.torn => {
                // The held cantilever's stiffness against the mass is about 0.07 N/m.
                let held = (0.07 * sigma / samples.sqrt()).max(3e-10);
                let instants = release_time_error(case, event, samples, instruments)
                    .hypot(step_time_error(case, event, instruments));
                let force = held.hypot(event.pull_rate * instants);
                let line = case.plain.ca * event.contact + case.plain.ca0;
                let row = [(base + 2, event.contact), (base + 3, 1.0)];
                normal.add(&row, event.pull - line, 1.0 / (force * force));
            }
            _ => {}
        }
    }
}

/// Standard error of an instant \[s\] from which a point moves off with `acceleration` \[m/s^2\],
/// seen for so many samples. What it would have done had it begun later is known: only the
/// velocity that it lacks for that shows.
fn onset_error(acceleration: f64, samples: f64, instruments: &Instruments) -> f64 {
    let speed = |i: usize| acceleration * i as f64 / instruments.rate;
    let information: f64 = (1..=samples as usize).map(|i| speed(i).powi(2)).sum();
    instruments.noise / information.sqrt().max(f64::MIN_POSITIVE)
}

/// Standard error of the instant of a release \[s\], as the mass shows it that flies off.
fn release_time_error(
    case: &CaseRun<'_>,
    event: &Event,
    samples: f64,
    instruments: &Instruments,
) -> f64 {
    onset_error(
        event.pull * case.plain.structure.mobility,
        samples,
        instruments,
    )
}

/// Standard error of the instant \[s\] of the step of the drive that tears the mass off, zero if
/// there is none: a sampled voltage says between which samples it is, the cantilever that it
/// throws, if it is seen, where.
fn step_time_error(case: &CaseRun<'_>, event: &Event, instruments: &Instruments) -> f64 {
    let since = event.time - TEAR_SAMPLES / instruments.rate;
    let Some(&i) = jumps_within(case.pieces, since, event.time).last() else {
        return 0.0;
    };
    let within_sample = 1.0 / instruments.rate / 12f64.sqrt();
    if !instruments.cantilever {
        return within_sample;
    }
    let (plain, at) = (case.plain, case.pieces[i].start);
    let gc = |piece: &Piece| plain.gc(piece, piece.shape.at(at));
    let jump = (gc(&case.pieces[i]) - gc(&case.pieces[i - 1])).abs();
    let s = &plain.structure;
    let thrown = plain.eta * jump * dot(s.n, &s.read_c, &s.push_drive).abs();
    onset_error(thrown, TEAR_SAMPLES, instruments).min(within_sample)
}

#[cfg(test)]
mod tests {
    use super::super::events::*;
    use crate::trial::hybrid::Run;
    use crate::trial::instrument;
    use crate::trial::instrument::StructureKind;
    use crate::trial::rng::TrialRng;
    use crate::trial::voltage::{Waveform, pieces};

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
            pull_rate: rate,
            contact: 5e-3,
            torn: false,
        }
    }

    /// Information on adhesion at touch \[1/N^2\] in a release under a square wave of 50 Hz, after
    /// which the mass touches again `flight` \[s\] later.
    fn adhesion_information(event: Event, flight: f64, cantilever: bool) -> f64 {
        let (plain, _) =
            instrument::device(StructureKind::Lumped, &mut TrialRng::new(5, 0)).unwrap();
        let instruments =
            instrument::instruments(RATE, 20e-9, cantilever, 9, &mut TrialRng::new(5, 1));
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
        let case = CaseRun {
            run: &run,
            plain: &plain,
            pieces: &pieces(&SQUARE, 0.1),
            times: &[],
        };
        let mut normal = NormalEquations {
            matrix: nalgebra::DMatrix::zeros(6, 6),
            right: nalgebra::DVector::zeros(6),
            energy: 0.0,
        };
        add_events(&mut normal, &case, 0, 4, &instruments);
        normal.matrix[(3, 3)]
    }

    #[test]
    fn adhesion_is_less_certain_the_faster_the_pull_grows_at_release() {
        for (flight, held) in [(1e-3, 3.13e-10), (85e-6, 6.79e-10)] {
            let quiet = adhesion_information(release(0.035, 0.0), flight, true).sqrt();
            assert!((quiet * held - 1.0).abs() < 0.02, "{quiet}");
            // Nothing but the instant: sigma / (a dt sqrt(1 + 4 + ...)) at 80 nN.
            let steep = 1.0 / adhesion_information(release(0.035, 1.0), flight, true).sqrt();
            let (plain, _) =
                instrument::device(StructureKind::Lumped, &mut TrialRng::new(5, 0)).unwrap();
            let n = (f64::min(flight, 4e-4) * RATE).floor();
            let squares = n * (n + 1.0) * (2.0 * n + 1.0) / 6.0;
            let instant = 20e-9 * RATE / (80e-9 * plain.structure.mobility * squares.sqrt());
            assert!((steep / instant - 1.0).abs() < 0.02, "{steep} {instant}");
        }
    }

    #[test]
    fn adhesion_is_less_certain_when_a_step_of_the_drive_causes_the_release() {
        let step = 0.03;
        // It grows by 10 nN in each microsecond: where in its sample the step was matters, unless
        // the cantilever that it throws is seen.
        for (cantilever, share) in [(true, 1.0), (false, 0.01)] {
            let adhesion_information =
                |after: f64| adhesion_information(release(step + after, 1e-2), 1e-3, cantilever);
            let torn = adhesion_information(30e-6) / adhesion_information(200e-6);
            assert!(torn > 0.0 && torn < share, "{torn}");
            assert!(
                (adhesion_information(-30e-6) / adhesion_information(200e-6) - 1.0).abs() < 1e-9
            );
        }
        let mut at_once = release(step + 200e-6, 1e-2);
        at_once.torn = true;
        assert_eq!(adhesion_information(at_once, 1e-3, true), 0.0);
    }
}
