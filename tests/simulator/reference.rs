//! The reference integrator is examined before it examines the simulator.

use crate::oracle::hybrid::{Event, run_from};
use crate::oracle::{Device, Drive, Kind, Outcome, Tolerance, run};

const RATE: f64 = 50e3;

fn square(hz: f64, volt: f64) -> Drive {
    Drive::Square { hz, volt }
}

#[test]
fn matrices_are_those_of_the_paper_device() {
    let device = Device::paper();
    // Paper device: M in 1e-10 kg = 1e-4 mg, K in N/m; printed to four digits.
    for (value, printed) in [
        (device.m[0][0] * 1e4, 1.7557),
        (device.m[0][1] * 1e4, 0.1909),
        (device.m[1][1] * 1e4, 3.7499),
        (device.k[0][0], 0.26839),
        (device.k[0][1], -0.07061),
        (device.k[1][1], 0.02467),
    ] {
        assert!(
            (value - printed).abs() < 1e-3 * printed.abs(),
            "{value} {printed}"
        );
    }
    // Static motion of the tip per unit of gc: 16.5 um and, as printed, 14.1 um.
    for (device, um) in [(device, 16.5), (Device::paper_as_printed(), 14.1)] {
        let k = device.k;
        let det = k[0][0] * k[1][1] - k[0][1] * k[1][0];
        let tip = -k[1][0] / det * device.eta;
        assert!((tip - um).abs() < 0.02, "{tip}");
    }
}

#[test]
fn drive_is_that_of_the_paper_device() {
    let gain = |drive: Drive, ms: f64| {
        let pieces = drive.pieces(1000.0);
        let piece = pieces.iter().find(|p| p.start <= ms && ms < p.end).unwrap();
        piece.gain(ms - piece.start).0
    };
    // A square starts at +A as just risen; the branches meet at +-8 V.
    assert!((gain(square(5.0, 8.0), 0.0) + 4.98).abs() < 0.02);
    assert!((gain(square(5.0, 8.0), 100.001) - 4.69).abs() < 0.02);
    let sine = Drive::Sine {
        hz: 50.0,
        volt: 8.0,
    };
    // Zero voltage: rising at the start, falling half a period later.
    assert!((gain(sine, 0.0) - 1.4796).abs() < 1e-12);
    assert!((gain(sine, 10.0) + 0.6350).abs() < 1e-9);
    assert!((gain(sine, 20.0) - 1.4796).abs() < 1e-9);
    let ramped = Drive::Ramped {
        hz: 5.0,
        volt: 8.0,
        lambda: 0.25,
    };
    // Rises from -A over T/4 through 0, holds to T/2, falls.
    assert!((gain(ramped, 0.0) - 4.69).abs() < 0.02);
    assert!((gain(ramped, 25.0) - 1.4796).abs() < 1e-9);
    assert!((gain(ramped, 75.0) + 4.98).abs() < 0.02);
    assert!((gain(ramped, 125.0) + 0.6350).abs() < 1e-9);
    // Rates agree with differences.
    for drive in [sine, ramped] {
        for piece in drive.pieces(200.0) {
            let (tau, h) = (0.3 * (piece.end - piece.start), 1e-5);
            let slope = (piece.gain(tau + h).0 - piece.gain(tau - h).0) / (2.0 * h);
            assert!((slope - piece.gain(tau).1).abs() < 1e-6, "{slope}");
        }
    }
}

#[test]
fn free_ring_down_follows_the_modes() {
    // Far from the ground and without film the motion is a sum of damped modes.
    let mut device = Device::paper();
    device.cs = 0.0;
    device.dp = 1e6;
    let start = [3.0, 20.0, -5.0, 60.0];
    let out = run_from(
        &device,
        &Drive::Rest,
        start,
        0.02,
        RATE,
        &Tolerance::relative(1e-12),
    );
    let table = [
        (623.0, 0.0262, 13.381005, 50.145332),
        (6424.0, 0.0257, 74.486762, -12.923177),
    ];
    // q = Phi^-1 x by Cramer's rule.
    let det = table[0].2 * table[1].3 - table[1].2 * table[0].3;
    let modal = |c: f64, p: f64| {
        [
            (table[1].3 * c - table[1].2 * p) / det,
            (table[0].2 * p - table[0].3 * c) / det,
        ]
    };
    let (q0, u0) = (modal(start[0], start[1]), modal(start[2], start[3]));
    let mut worst: f64 = 0.0;
    for (i, sample) in out.samples.iter().enumerate() {
        let t = i as f64 / RATE * 1e3;
        let mut xp = 0.0;
        for n in 0..2 {
            let (hz, zeta, _, phi_p) = table[n];
            let omega = std::f64::consts::TAU * hz * 1e-3;
            let damped = omega * f64::sqrt(1.0 - zeta * zeta);
            let (sin, cos) = (damped * t).sin_cos();
            let q = (-zeta * omega * t).exp()
                * (q0[n] * cos + (u0[n] + zeta * omega * q0[n]) / damped * sin);
            xp += phi_p * q;
        }
        worst = worst.max((xp - sample[1] * 1e6).abs());
    }
    println!("ring-down: worst error {worst:.1e} um");
    assert_eq!(out.samples.len(), 1001);
    assert!(worst < 1e-8, "{worst} um");
}

/// Largest difference of xp [m] and of event times [s]; the lists must be of the same
/// kinds in the same order.
fn compare(a: &Outcome, b: &Outcome) -> (f64, f64) {
    let kinds = |o: &Outcome| o.events.iter().map(|e| e.kind).collect::<Vec<Kind>>();
    assert_eq!(kinds(a), kinds(b));
    assert_eq!(a.samples.len(), b.samples.len());
    let position = a.samples.iter().zip(&b.samples);
    let time = a.events.iter().zip(&b.events);
    (
        position.fold(0.0, |m, (x, y)| f64::max(m, (x[1] - y[1]).abs())),
        time.fold(0.0, |m, (x, y)| f64::max(m, (x.time - y.time).abs())),
    )
}

#[test]
fn refinement_converges() {
    let sine = Drive::Sine {
        hz: 50.0,
        volt: 8.0,
    };
    let ramped = Drive::Ramped {
        hz: 5.0,
        volt: 8.0,
        lambda: 0.25,
    };
    let cases = [
        ("5 Hz square", Device::paper(), square(5.0, 8.0), 1.0),
        ("15 Hz square", Device::paper(), square(15.0, 8.0), 1.0),
        ("50 Hz sine", Device::paper(), sine, 1.0),
        ("5 Hz ramped", Device::paper(), ramped, 0.4),
        (
            "300 Hz square 6 V",
            Device::paper(),
            square(300.0, 6.0),
            0.05,
        ),
        (
            "15 Hz square as printed",
            Device::paper_as_printed(),
            square(15.0, 8.0),
            0.4,
        ),
    ];
    for (name, device, drive, duration) in cases {
        let start = std::time::Instant::now();
        let fine = run(&device, &drive, duration, RATE, &Tolerance::relative(1e-12));
        let seconds = start.elapsed().as_secs_f64();
        let coarse = run(&device, &drive, duration, RATE, &Tolerance::relative(1e-10));
        let (position, time) = compare(&fine, &coarse);
        let count = |kind| fine.events.iter().filter(|e| e.kind == kind).count();
        let closest = fine
            .events
            .iter()
            .filter(|e| e.kind != Kind::Release)
            .map(|e| e.margin.abs())
            .fold(f64::INFINITY, f64::min);
        println!(
            "{name}: {} impacts, {} sticks, {} releases, {} steps in {seconds:.1} s; 1e-10 against 1e-12: xp {position:.1e} m, events {time:.1e} s; closest decision {closest:.1e} N",
            count(Kind::Impact),
            count(Kind::Stick),
            count(Kind::Release),
            fine.steps,
        );
        // The finer run errs a hundredth of this.
        assert!(position < 1e-10, "{name}: {position}");
        assert!(time < 1e-10, "{name}: {time}");
    }
}

#[test]
fn energy_never_grows_undriven() {
    let device = Device::paper();
    // Thrown at the ground hard enough to bounce.
    let start = [0.0, 0.0, 0.0, -400.0];
    let out = run_from(
        &device,
        &Drive::Rest,
        start,
        0.05,
        RATE,
        &Tolerance::relative(1e-12),
    );
    assert!(out.events.iter().any(|e: &Event| e.kind == Kind::Impact));
    let energy = |s: &[f64; 4]| device.energy(&[s[0] * 1e6, s[1] * 1e6, s[2] * 1e3, s[3] * 1e3]);
    let mut last = f64::INFINITY;
    for sample in &out.samples {
        let now = energy(sample);
        assert!(now <= last * (1.0 + 1e-11), "{now} after {last}");
        last = now;
    }
}
