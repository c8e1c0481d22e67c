//! Devices and drives drawn at random, simulator against reference: what agrees for one
//! set of values might do so by luck.

use crate::oracle::{Device, Drive, Kind, Tolerance, run};
use crate::support::waveform::waveform;
use impactscope::model::preset::Preset;
use impactscope::sim::{EventKind, Options, simulate};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// One drawn case in SI: values of the table and the drive.
#[derive(Debug)]
struct Case {
    values: [(&'static str, f64); 9],
    drive: Drive,
}

fn draw(rng: &mut ChaCha8Rng) -> Case {
    let mut log = |low: f64, high: f64| low * (high / low).powf(rng.random::<f64>());
    let dp = log(30e-6, 90e-6);
    let values = [
        ("Cs", log(1e-22, 1e-20)),
        ("dp", dp),
        ("gp", dp + log(2e-6, 50e-6)),
        ("Ca", log(1e-8, 1e-4)),
        ("Ca0", log(1e-9, 1e-6)),
        ("eta", log(2e-7, 8e-7)),
        ("zeta1", log(5e-3, 0.5)),
        ("zeta2", log(5e-3, 0.5)),
        // Of `1.1 - alpha`, so that restitution is as often strong as weak.
        ("alpha", 1.1 - log(0.1, 1.1)),
    ];
    let (hz, volt) = (log(10.0, 400.0), log(4.0, 10.0));
    let drive = match rng.random_range(0..3) {
        0 => Drive::Square { hz, volt },
        1 => Drive::Sine { hz, volt },
        _ => Drive::Ramped {
            hz,
            volt,
            lambda: rng.random_range(0.02..0.48),
        },
    };
    Case { values, drive }
}

/// The same values in um, ms, mg, uN.
fn device(case: &Case) -> Device {
    let value = |id: &str| {
        let found = case.values.iter().find(|(name, _)| *name == id);
        found.unwrap().1
    };
    Device {
        cs: value("Cs") * 1e21,
        dp: value("dp") * 1e6,
        gp: value("gp") * 1e6,
        ca: value("Ca") * 1e3,
        ca0: value("Ca0") * 1e6,
        eta: value("eta") * 1e6,
        alpha: value("alpha"),
        ..Device::paper().damped(value("zeta1"), value("zeta2"))
    }
}

fn letter(kind: Kind) -> char {
    match kind {
        Kind::Impact => 'i',
        Kind::Stick => 's',
        Kind::Release => 'r',
    }
}

const DURATION: f64 = 0.04;

/// What one case shows.
struct Shown {
    /// Worst error of xp farther than a sample from events [m].
    position: f64,
    /// Worst error of an event's time [s].
    time: f64,
    events: usize,
    /// Whether the motion amplifies small errors: the reference's own events, at a hundred
    /// times its tolerance, move by more than a tenth of what is allowed here.
    amplifies: bool,
}

/// Runs both.
fn compare(case: &Case) -> Shown {
    let mut model = Preset::default().model;
    for (id, value) in case.values {
        model.set(id, value).unwrap();
    }
    let options = Options::default();
    let trace = simulate(&model, &waveform(case.drive), DURATION, &options).unwrap();
    let tolerance = Tolerance::relative(1e-12);
    let reference = run(
        &device(case),
        &case.drive,
        DURATION,
        options.rate,
        &tolerance,
    );
    let events: Vec<_> = trace
        .events
        .iter()
        .filter(|e| e.kind != EventKind::DriveStep)
        .collect();
    let simulated: String = events
        .iter()
        .map(|e| match e.kind {
            EventKind::Impact => 'i',
            EventKind::Stick => 's',
            _ => 'r',
        })
        .collect();
    let expected: String = reference.events.iter().map(|e| letter(e.kind)).collect();
    let margins = reference.events.iter().filter(|e| e.kind != Kind::Release);
    let closest = margins.fold(f64::INFINITY, |m, e| f64::min(m, e.margin.abs()));
    assert_eq!(
        simulated, expected,
        "closest decision {closest:e} N\n{case:?}\n{:?}\n{:?}",
        events, reference.events
    );
    let time = events.iter().zip(&reference.events);
    let time = time.fold(0.0, |m, (a, b)| f64::max(m, (a.time - b.time).abs()));
    let mut worst: f64 = 0.0;
    for (i, sample) in reference.samples.iter().enumerate() {
        let t = trace.time(i);
        let next = reference
            .events
            .partition_point(|e| e.time < t - 1.01 * trace.dt);
        let near = reference
            .events
            .get(next)
            .is_some_and(|e| e.time <= t + 1.01 * trace.dt);
        if !near {
            worst = worst.max((trace.proof_mass[i] - sample[1]).abs());
        }
    }
    let coarse = Tolerance::relative(1e-10);
    let coarse = run(&device(case), &case.drive, DURATION, options.rate, &coarse);
    let moved = coarse.events.iter().zip(&reference.events);
    let moved = moved.fold(0.0, |m, (a, b)| f64::max(m, (a.time - b.time).abs()));
    Shown {
        position: worst,
        time,
        events: events.len(),
        amplifies: moved > 1e-10 || coarse.events.len() != reference.events.len(),
    }
}

#[test]
fn drawn_devices_agree() {
    const COUNT: usize = 450;
    let mut rng = ChaCha8Rng::seed_from_u64(115_002);
    let (mut position, mut time, mut events) = (0.0, 0.0, 0);
    let (mut touching, mut amplifying) = (0, 0);
    let mut wrong = Vec::new();
    for i in 0..COUNT {
        let case = draw(&mut rng);
        // The order of events is compared for all, even where times drift apart.
        let shown = compare(&case);
        events += shown.events;
        touching += usize::from(shown.events > 0);
        if shown.amplifies {
            amplifying += 1;
            println!(
                "case {i} amplifies: xp {:.1e} m, events {:.1e} s",
                shown.position, shown.time
            );
            continue;
        }
        position = f64::max(position, shown.position);
        time = f64::max(time, shown.time);
        if !(shown.position <= 1e-9 && shown.time <= 1e-9) {
            wrong.push(format!(
                "case {i}: xp {:.1e} m, events {:.1e} s: {case:?}",
                shown.position, shown.time
            ));
        }
    }
    println!(
        "{COUNT} devices, {touching} touch the ground, {events} events; {amplifying} amplify errors, of the others: worst xp {position:.1e} m, event time {time:.1e} s"
    );
    assert!(
        touching > COUNT / 2,
        "too few of the drawn devices reach the ground"
    );
    assert!(
        amplifying < COUNT / 50,
        "{amplifying} are no longer exceptions"
    );
    assert!(wrong.is_empty(), "{wrong:#?}");
}
