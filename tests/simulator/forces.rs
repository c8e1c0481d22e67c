//! The recorded forces against the equations, with the motion of the reference.

use crate::oracle::{Device, Drive, Kind, Tolerance, run};
use impactscope::model::Model;
use impactscope::model::drive::Waveform;
use impactscope::sim::{Options, simulate};

/// Largest deviations [N] of drive, film, adhesion, ground and pull-off force.
fn deviations(waveform: &Waveform, drive: &Drive, duration: f64) -> [f64; 5] {
    let options = Options {
        forces: true,
        ..Options::default()
    };
    let trace = simulate(&Model::default(), waveform, duration, &options).unwrap();
    let forces = trace.forces.as_ref().unwrap();
    let device = Device::paper();
    let reference = run(
        &device,
        drive,
        duration,
        options.rate,
        &Tolerance::relative(1e-12),
    );
    let pieces = drive.pieces(duration * 1e3);
    let mut worst = [0.0_f64; 5];
    let (mut held_samples, mut free_samples) = (0, 0);
    for (i, sample) in reference.samples.iter().enumerate() {
        let t = trace.time(i);
        let piece = pieces[pieces
            .partition_point(|p| p.start <= t * 1e3)
            .saturating_sub(1)];
        let edge = f64::min(t * 1e3 - piece.start, piece.end - t * 1e3);
        let next = reference.events.partition_point(|e| e.time < t - 1e-8);
        let near = reference
            .events
            .get(next)
            .is_some_and(|e| e.time <= t + 1e-8);
        // On an edge of the drive or of a contact either side is right.
        if near || edge < 1e-6 {
            continue;
        }
        let state = [
            sample[0] * 1e6,
            sample[1] * 1e6,
            sample[2] * 1e3,
            sample[3] * 1e3,
        ];
        let force = device.eta * piece.gain(t * 1e3 - piece.start).0;
        let touch = next.checked_sub(1).map(|k| reference.events[k]);
        let touch = touch.filter(|e| e.kind == Kind::Stick).map(|e| e.time);
        // uN, positive up.
        let expected = if let Some(touch) = touch {
            held_samples += 1;
            let adhesion = device.ca * (t - touch) * 1e3 + device.ca0;
            let pull = device.pull_off(&state, force);
            // The ground balances what the structure pulls with.
            [force, 0.0, adhesion, -pull, pull]
        } else {
            free_samples += 1;
            let gap = state[1] + device.gp;
            [force, -device.cs * state[3] / gap.powi(3), 0.0, 0.0, 0.0]
        };
        let found = [
            forces.drive[i],
            forces.film[i],
            forces.adhesion[i],
            forces.ground[i],
            forces.pull_off[i],
        ];
        for ((worst, found), expected) in worst.iter_mut().zip(found).zip(expected) {
            *worst = worst.max((found - expected * 1e-6).abs());
        }
        assert_eq!(forces.effects[i], 0.0);
    }
    assert!(
        held_samples > 100 && free_samples > 100,
        "{held_samples} {free_samples}"
    );
    worst
}

#[test]
fn forces_follow_the_equations() {
    let square = Waveform::Square {
        frequency: 15.0,
        amplitude: 8.0,
    };
    let sine = Waveform::Sine {
        frequency: 50.0,
        amplitude: 8.0,
    };
    for (name, waveform, drive) in [
        (
            "square",
            square,
            Drive::Square {
                hz: 15.0,
                volt: 8.0,
            },
        ),
        (
            "sine",
            sine,
            Drive::Sine {
                hz: 50.0,
                volt: 8.0,
            },
        ),
    ] {
        let worst = deviations(&waveform, &drive, 0.2);
        println!("{name}: drive, film, adhesion, ground, pull-off err by {worst:?} N");
        // The smallest force that matters is the initial adhesion, 27 nN.
        assert!(worst.iter().all(|&w| w < 1e-12), "{name}: {worst:?}");
    }
}
