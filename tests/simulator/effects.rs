//! Every effect against the device written again with that effect, by another method.

use crate::support::device::with;
use crate::support::difference::largest_difference;
use crate::twin::{Drive, Effects, Memory, Run, Twin};
use impactscope::model::Model;
use impactscope::model::drive::{VoltageTable, Waveform};
use impactscope::model::preset::Preset;
use impactscope::sim::{Options, Trace, simulate};

const RATE: f64 = 20e3;
const SQUARE: Drive = Drive::Square {
    hz: 50.0,
    volt: 8.0,
};
const SINE: Drive = Drive::Sine {
    hz: 50.0,
    volt: 6.0,
};

fn waveform(drive: &Drive) -> Waveform {
    match drive {
        Drive::Rest => Waveform::Rest,
        &Drive::Sine { hz, volt } => Waveform::Sine {
            frequency: hz,
            amplitude: volt,
        },
        &Drive::Square { hz, volt } => Waveform::Square {
            frequency: hz,
            amplitude: volt,
        },
        Drive::Lines(points) => {
            let (time, volt) = points.iter().copied().unzip();
            Waveform::Table(VoltageTable::new("lines", time, volt).unwrap().into())
        }
    }
}

fn run(model: &Model, drive: &Drive, duration: f64) -> Trace {
    let options = Options {
        rate: RATE,
        tolerance: 1e-14,
        ..Options::default()
    };
    simulate(model, &waveform(drive), duration, &options).unwrap()
}

/// Largest difference of both readings, and of the times of contacts that have ended.
fn compare(name: &str, trace: &Trace, twin: &Run, tolerance: f64) {
    let p = largest_difference(&trace.proof_mass, &twin.proof_mass);
    let c = largest_difference(&trace.cantilever, &twin.cantilever);
    println!(
        "{name}: {p:.1e} m, {c:.1e} m, {} contacts",
        trace.contacts.len()
    );
    assert!(p < tolerance && c < tolerance, "{name}: {p:e} m, {c:e} m");
    for (a, b) in trace.contacts.iter().zip(&twin.contacts) {
        let apart = (a.0 - b.0).abs().max((a.1 - b.1).abs());
        assert!(apart < 1e-7, "{name}: contacts {a:?} and {b:?}");
    }
}

/// Compares under a drive for 50 ms, and sees that the effect is there.
fn check(id: &str, values: &[(&str, f64)], effects: Effects, drives: &[Drive]) {
    for drive in drives {
        let duration = 0.05;
        let trace = run(&with(id, values), drive, duration);
        let twin = Twin::new(effects, drive.clone()).run(duration, RATE);
        compare(id, &trace, &twin, 1e-9);
        let plain = run(&Preset::default().model, drive, duration);
        let moved = largest_difference(&trace.proof_mass, &plain.proof_mass);
        assert!(moved > 20e-9, "{id} moves nothing: {moved:e} m");
    }
}

#[test]
fn the_twin_without_effects_is_the_baseline() {
    for drive in [SQUARE, SINE] {
        let trace = run(&Preset::default().model, &drive, 0.05);
        let twin = Twin::new(Effects::default(), drive).run(0.05, RATE);
        compare("baseline", &trace, &twin, 1e-9);
    }
}

#[test]
fn drive_effects() {
    let effects = Effects {
        amplifier_tau: 80e-6,
        ..Effects::default()
    };
    check("amplifier_lag", &[("tau", 80e-6)], effects, &[SQUARE]);
    let effects = Effects {
        creep: [(0.1, 8e-3), (0.0, 0.0)],
        ..Effects::default()
    };
    let values = [("c", 0.1), ("tau", 8e-3)];
    check("piezo_creep", &values, effects, &[SQUARE, SINE]);
    let effects = Effects {
        creep: [(0.0, 0.0), (0.05, 20e-3)],
        ..Effects::default()
    };
    let values = [("c", 0.0), ("c2", 0.05), ("tau2", 20e-3)];
    check("piezo_creep", &values, effects, &[SQUARE]);
    let effects = Effects {
        creep: [(0.06, 3e-3), (0.05, 20e-3)],
        ..Effects::default()
    };
    let values = [("c", 0.06), ("tau", 3e-3), ("c2", 0.05), ("tau2", 20e-3)];
    check("piezo_creep", &values, effects, &[SQUARE, SINE]);
}

#[test]
fn hysteresis_with_memory() {
    let lines = Drive::Lines(
        [
            (0.0, 0.0),
            (0.005, 7.0),
            (0.010, -4.0),
            (0.015, 5.0),
            (0.020, 1.0),
            (0.025, 3.0),
            (0.030, -6.0),
            (0.034, 2.0),
            (0.038, -2.0),
            (0.044, 8.0),
            (0.050, -8.0),
        ]
        .to_vec(),
    );
    let uniform = Memory {
        share: 0.8,
        width: 1.3,
        reference: 9.0,
        ..Memory::default()
    };
    let weighted = Memory {
        q: 0.3,
        k: 2.0,
        past: -6.5,
        ..uniform
    };
    let bent = Memory {
        k: -0.4,
        middle: (-0.3, 0.2),
        ..uniform
    };
    for memory in [uniform, weighted, bent] {
        let effects = Effects {
            memory,
            ..Effects::default()
        };
        let values = [
            ("s", memory.share),
            ("w", memory.width),
            ("v_ref", memory.reference),
            ("q", memory.q),
            ("k", memory.k),
            ("b1", 0.0),
            ("v_past", memory.past),
            ("m2", memory.middle.0),
            ("m3", memory.middle.1),
        ];
        let drives = [SINE, SQUARE, lines.clone()];
        check("hysteresis_memory", &values, effects, &drives);
    }
}

#[test]
fn forces_on_the_mass() {
    let none = Effects::default;
    let both = [SQUARE, SINE];
    let effects = Effects {
        electrostatic: (9e-8, 90e-6),
        ..none()
    };
    check(
        "electrostatic",
        &[("A", 9e-8), ("g", 90e-6)],
        effects,
        &both,
    );
    for (k3, k5) in [(5e4, 0.0), (-2e4, 0.0), (5e4, -3e11), (0.0, 2e11)] {
        check(
            "cubic_stiffness",
            &[("k3", k3), ("k5", k5)],
            Effects { k3, k5, ..none() },
            &both,
        );
    }
    for k2 in [2.0, -1.5] {
        check(
            "even_stiffness",
            &[("k2", k2)],
            Effects { k2, ..none() },
            &both,
        );
    }
    for (k3, k5, sine_length) in [(-3e4, 0.0, 4e-5), (5e4, -1e11, 3e-5), (2e4, 0.0, 1e-3)] {
        check(
            "cubic_stiffness",
            &[("k3", k3), ("k5", k5), ("l", sine_length)],
            Effects {
                k3,
                k5,
                sine_length,
                ..none()
            },
            &both,
        );
    }
    check(
        "quadratic_drag",
        &[("cd", 5e-7)],
        Effects { cd: 5e-7, ..none() },
        &both,
    );
    let effects = Effects {
        attraction: (20e-9, 3e-6, 3.0),
        ..none()
    };
    let values = [("A", 20e-9), ("h0", 3e-6), ("n", 3.0)];
    check("long_range_attraction", &values, effects, &both);
    let effects = Effects {
        gravity: 9.80665,
        ..none()
    };
    check("gravity", &[("g", 9.80665)], effects, &both);
}

#[test]
fn friction_and_film() {
    for fc in [3e-9, 25e-9] {
        let effects = Effects {
            fc,
            ..Effects::default()
        };
        check("dry_friction", &[("fc", fc)], effects, &[SQUARE, SINE]);
    }
    for load in [(2e-4, 0.0), (3e-4, -2.0), (0.0, 3.0)] {
        let effects = Effects {
            load,
            ..Effects::default()
        };
        let values = [("ml", load.0), ("mq", load.1)];
        check("load_friction", &values, effects, &[SQUARE, SINE]);
    }
    for (film_tau, film_growth) in [(5e-6, 0.0), (200e-6, 0.0), (300e-6, 2.0), (4e-6, 2.0)] {
        let effects = Effects {
            film_tau,
            film_growth,
            ..Effects::default()
        };
        check(
            "film_spring",
            &[("tau", film_tau), ("p", film_growth)],
            effects,
            &[SQUARE, SINE],
        );
    }
}

#[test]
fn structure_and_base() {
    let mode = [11e3, 0.01, 4e4, -1.5e4, 5e4];
    let effects = Effects {
        mode,
        ..Effects::default()
    };
    let values = [
        ("f", mode[0]),
        ("zeta", mode[1]),
        ("phi_c", mode[2]),
        ("phi_p", mode[3]),
        ("phi_d", mode[4]),
    ];
    check("extra_mode", &values, effects, &[SQUARE, SINE]);
    // Two modes of one frequency and damping, each of a shape smaller by the root of two,
    // are one mode.
    let part = |value: f64| value * 0.5f64.sqrt();
    let halves = [
        ("f", mode[0]),
        ("zeta", mode[1]),
        ("phi_c", part(mode[2])),
        ("phi_p", part(mode[3])),
        ("phi_d", part(mode[4])),
        ("f2", mode[0]),
        ("zeta2", mode[1]),
        ("phi_c2", part(mode[2])),
        ("phi_p2", part(mode[3])),
        ("phi_d2", part(mode[4])),
    ];
    check("extra_mode", &halves, effects, &[SQUARE, SINE]);
    for f in [60.0, 1700.0] {
        let effects = Effects {
            base: (30.0, f, 0.7),
            ..Effects::default()
        };
        let values = [("a", 30.0), ("f", f), ("phase", 0.7)];
        check(
            "base_vibration",
            &values,
            effects,
            &[SQUARE, SINE, Drive::Rest],
        );
    }
}

#[test]
fn contact_laws() {
    // In place of the straight line, and on top of half of it.
    for (share, line) in [(0.0, 0.0), (1.0, 0.0), (0.0, 0.5)] {
        let effects = Effects {
            adhesion: (60e-9, 2e-3, share, line),
            ..Effects::default()
        };
        let values = [
            ("dF", 60e-9),
            ("tau", 2e-3),
            ("log_share", share),
            ("line_share", line),
        ];
        check("adhesion_saturation", &values, effects, &[SQUARE, SINE]);
    }
    // The mass sticks at every touch of the slow sine: only the square tells.
    for n in [0.25, -0.3] {
        let effects = Effects {
            restitution: (n, 0.05),
            ..Effects::default()
        };
        let values = [("n", n), ("v0", 0.05)];
        check("velocity_restitution", &values, effects, &[SQUARE]);
    }
    // Stuck at 6 ms, in flight at 23 ms.
    for (height, time) in [(3e-6, 6e-3), (-3e-6, 6e-3), (-5e-6, 23e-3), (90e-6, 17e-3)] {
        let effects = Effects {
            step: (height, time),
            ..Effects::default()
        };
        check(
            "gap_step",
            &[("h", height), ("t0", time)],
            effects,
            &[SQUARE],
        );
    }
}

#[test]
fn compliant_ground() {
    for (k, chi, drive) in [(1e4, 10.0, SQUARE), (1e5, 10.0, SINE), (1e5, 2.0, SQUARE)] {
        let effects = Effects {
            ground: (k, chi),
            ..Effects::default()
        };
        let duration = 0.03;
        let trace = run(
            &with("compliant_ground", &[("k", k), ("chi", chi)]),
            &drive,
            duration,
        );
        let twin = Twin::new(effects, drive).run(duration, RATE);
        compare("compliant_ground", &trace, &twin, 1e-9);
    }
}

#[test]
fn below_the_level_of_the_ground_the_attraction_is_that_of_touch() {
    let effects = Effects {
        ground: (1e4, 10.0),
        attraction: (20e-9, 0.1e-6, 2.0),
        ..Effects::default()
    };
    let mut model = with("compliant_ground", &[("k", 1e4), ("chi", 10.0)]);
    let values = [("A", 20e-9), ("h0", 0.1e-6), ("n", 2.0)];
    model
        .effects
        .extend(with("long_range_attraction", &values).effects);
    let trace = run(&model, &SQUARE, 0.03);
    let twin = Twin::new(effects, SQUARE).run(0.03, RATE);
    compare("both", &trace, &twin, 1e-9);
}

#[test]
fn readings() {
    let effects = Effects {
        sensor_tau: 30e-6,
        ..Effects::default()
    };
    let values = [("tau", 30e-6), ("delay", 0.0)];
    check("sensor_lag", &values, effects, &[SQUARE, SINE]);
    let effects = Effects {
        drift: (2e-6, 0.01, 3e-5),
        ..Effects::default()
    };
    let values = [("a", 2e-6), ("tau", 0.01), ("b", 3e-5)];
    check("zero_drift", &values, effects, &[SQUARE, SINE]);
}
