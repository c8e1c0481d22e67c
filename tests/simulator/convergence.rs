//! How the error falls with the step and with the tolerance.

use crate::oracle::{Device, Drive, Tolerance, run};
use impactscope::model::drive::Waveform;
use impactscope::model::preset::Preset;
use impactscope::sim::{Options, simulate};

/// Film coefficient that is some 60 times the device's: the modes are cheap to follow
/// exactly, so that only the film (and the drive) tells the order of the method.
const STRONG_FILM: f64 = 1e-19;

/// Largest error of xp with fixed steps on a smooth flight, against the reference.
fn error(fixed_step: f64, waveform: &Waveform, duration: f64, reference: &[[f64; 4]]) -> f64 {
    let options = Options {
        fixed_step: Some(fixed_step),
        ..Options::default()
    };
    let mut model = Preset::default().model;
    model.set("Cs", STRONG_FILM).unwrap();
    let trace = simulate(&model, waveform, duration, &options).unwrap();
    assert!(trace.contacts.is_empty(), "{:?}", trace.events);
    assert_eq!(trace.len(), reference.len());
    let pairs = trace.proof_mass.iter().zip(reference);
    pairs.fold(0.0, |m, (x, r)| f64::max(m, (x - r[1]).abs()))
}

/// Halves the step until rounding takes over; prints and returns the orders seen between
/// errors that are clear of it.
fn orders(name: &str, waveform: &Waveform, drive: Drive, duration: f64, coarsest: f64) -> Vec<f64> {
    let mut device = Device::paper();
    // In uN um^2 ms.
    device.cs = STRONG_FILM * 1e21;
    let tolerance = Tolerance::relative(1e-14);
    let reference = run(&device, &drive, duration, 50e3, &tolerance).samples;
    let mut orders = Vec::new();
    let mut last: Option<f64> = None;
    let mut step = coarsest;
    for _ in 0..9 {
        let now = error(step, waveform, duration, &reference);
        let order = last.map(|before: f64| (before / now).log2());
        println!("{name}: step {step:.2e} s, error {now:.2e} m, order {order:.2?}");
        // Below this the reference's own error and rounding are in sight.
        if now < 1e-15 {
            break;
        }
        orders.extend(order);
        last = Some(now);
        step *= 0.5;
    }
    orders
}

#[test]
fn fixed_steps_converge_with_their_order() {
    // The first flight of the standard square, before its first impact at 0.33 ms.
    let square = Waveform::Square {
        frequency: 5.0,
        amplitude: 8.0,
    };
    let drive = Drive::Square { hz: 5.0, volt: 8.0 };
    let short = orders("first flight", &square, drive, 0.32e-3, 1.6e-4);
    // A drive that changes all the time and stays clear of the ground.
    let sine = Waveform::Sine {
        frequency: 50.0,
        amplitude: 4.0,
    };
    let drive = Drive::Sine {
        hz: 50.0,
        volt: 4.0,
    };
    let long = orders("sine flight", &sine, drive, 4.9e-3, 1.6e-4);
    for (name, orders) in [("first flight", short), ("sine flight", long)] {
        assert!(
            orders.len() >= 2,
            "{name}: too few errors to tell: {orders:?}"
        );
        // From the third step on; each pair, and not only the kindest, has to show it. The
        // method shows 8.5 to 9.4, the documents promise 4.
        assert!(
            orders.iter().skip(1).all(|&order| order >= 4.0),
            "{name}: {orders:?}"
        );
    }
}

#[test]
fn tighter_tolerance_errs_less() {
    let drive = Drive::Square {
        hz: 15.0,
        volt: 8.0,
    };
    let waveform = Waveform::Square {
        frequency: 15.0,
        amplitude: 8.0,
    };
    let reference = run(
        &Device::paper(),
        &drive,
        0.2,
        50e3,
        &Tolerance::relative(1e-13),
    );
    let mut errors = Vec::new();
    let mut costs = Vec::new();
    for tolerance in [1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13] {
        let options = Options {
            tolerance,
            ..Options::default()
        };
        let trace = simulate(&Preset::default().model, &waveform, 0.2, &options).unwrap();
        let near = |t: f64| {
            let events = reference.events.iter();
            events
                .into_iter()
                .any(|e| (e.time - t).abs() <= 1.01 * trace.dt)
        };
        let mut worst: f64 = 0.0;
        for (i, sample) in reference.samples.iter().enumerate() {
            if !near(trace.time(i)) {
                worst = worst.max((trace.proof_mass[i] - sample[1]).abs());
            }
        }
        println!(
            "tolerance {tolerance:.0e} m: error {worst:.2e} m, {} steps",
            trace.steps
        );
        errors.push(worst);
        costs.push(trace.steps);
    }
    // A hundredth of the tolerance gives at most a fifth of the error, until rounding.
    for (i, pair) in errors.windows(3).enumerate() {
        assert!(
            pair[2] < 0.2 * pair[0] || pair[2] < 1e-12,
            "{i}: {errors:?}"
        );
    }
    assert!(costs.is_sorted(), "{costs:?}");
}
