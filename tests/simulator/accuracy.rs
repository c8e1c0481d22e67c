//! The simulator at its default options against the reference integrator.

use crate::oracle::{Device, Drive, Kind, Outcome, Tolerance, run};
use crate::support::waveform::waveform;
use impactscope::model::preset::Preset;
use impactscope::sim::{Event, EventKind, Options, Trace, simulate};

/// Largest disagreements of one case.
#[derive(Debug, Default)]
struct Worst {
    xp: f64,
    xc: f64,
    vp: f64,
    voltage: f64,
    time: f64,
    /// Of velocities before and after events [m/s].
    velocity: f64,
    /// Of the pull-off force at events [N].
    force: f64,
    contact: f64,
}

fn contact_events(trace: &Trace) -> Vec<Event> {
    let drive = |e: &&Event| e.kind != EventKind::DriveStep;
    trace.events.iter().filter(drive).copied().collect()
}

fn same_kind(a: EventKind, b: Kind) -> bool {
    matches!(
        (a, b),
        (EventKind::Impact, Kind::Impact)
            | (EventKind::Stick, Kind::Stick)
            | (EventKind::Release, Kind::Release)
    )
}

/// Compares all samples that are farther than one sample from any event, and all events.
fn compare(name: &str, trace: &Trace, reference: &Outcome, drive: &Drive) -> Worst {
    let events = contact_events(trace);
    let kinds = events.iter().map(|e| e.kind).collect::<Vec<_>>();
    let expected = reference.events.iter().map(|e| e.kind).collect::<Vec<_>>();
    if let Some(i) = (0..kinds.len().max(expected.len())).find(
        |&i| !matches!((kinds.get(i), expected.get(i)), (Some(&a), Some(&b)) if same_kind(a, b)),
    ) {
        panic!(
            "{name}: event {i} differs: simulator {:?}, reference {:?}; {} and {} events in all",
            events.get(i),
            reference.events.get(i),
            kinds.len(),
            expected.len()
        );
    }
    let mut worst = Worst::default();
    let raise = |what: &mut f64, by: f64| {
        assert!(by.is_finite(), "{name}: not a number");
        *what = what.max(by);
    };
    for (a, b) in events.iter().zip(&reference.events) {
        raise(&mut worst.time, (a.time - b.time).abs());
        raise(
            &mut worst.velocity,
            (a.velocity_before - b.velocity_before).abs(),
        );
        raise(
            &mut worst.velocity,
            (a.velocity_after - b.velocity_after).abs(),
        );
        raise(&mut worst.force, (a.pull_off_force - b.pull_off).abs());
        raise(&mut worst.contact, (a.contact_duration - b.contact).abs());
    }
    assert_eq!(trace.len(), reference.samples.len(), "{name}: samples");
    let pieces = drive.pieces(trace.end() * 1e3 + 1.0);
    let mut next = 0;
    for (i, sample) in reference.samples.iter().enumerate() {
        let t = trace.time(i);
        while next < reference.events.len() && reference.events[next].time < t - 1.01 * trace.dt {
            next += 1;
        }
        let near = |k: usize| {
            let event = reference.events.get(k);
            event.is_some_and(|e| (e.time - t).abs() <= 1.01 * trace.dt)
        };
        if !near(next) {
            raise(&mut worst.xp, (trace.proof_mass[i] - sample[1]).abs());
            raise(&mut worst.xc, (trace.cantilever[i] - sample[0]).abs());
            raise(
                &mut worst.vp,
                (trace.proof_mass_velocity[i] - sample[3]).abs(),
            );
        }
        let piece = pieces
            .partition_point(|p| p.start <= t * 1e3)
            .saturating_sub(1);
        let piece = pieces[piece];
        let edge = f64::min(t * 1e3 - piece.start, piece.end - t * 1e3);
        // On an edge either side is right.
        if edge > 1e-6 {
            let (voltage, _) = piece.voltage(t * 1e3 - piece.start);
            raise(&mut worst.voltage, (trace.voltage[i] - voltage).abs());
        }
    }
    println!(
        "{name}: {} events, {} steps; worst xp {:.1e} m, xc {:.1e} m, vp {:.1e} m/s; event time {:.1e} s, velocity {:.1e} m/s, pull-off {:.1e} N, contact {:.1e} s; voltage {:.1e} V",
        events.len(),
        trace.steps,
        worst.xp,
        worst.xc,
        worst.vp,
        worst.time,
        worst.velocity,
        worst.force,
        worst.contact,
        worst.voltage
    );
    worst
}

fn check(name: &str, preset: &str, device: Device, drive: Drive, duration: f64) {
    let model = Preset::embedded(preset).unwrap().model;
    let options = Options::default();
    assert_eq!(options.rate, 50e3);
    let trace = simulate(&model, &waveform(drive), duration, &options).unwrap();
    let tolerance = Tolerance::relative(1e-12);
    let reference = run(&device, &drive, duration, options.rate, &tolerance);
    let worst = compare(name, &trace, &reference, &drive);
    assert!(worst.xp <= 1e-9, "{name}: xp errs by {} m", worst.xp);
    assert!(worst.xc <= 1e-9, "{name}: xc errs by {} m", worst.xc);
    // 1 nm of the fast mode at 4e4 rad/s.
    assert!(worst.vp <= 4e-5, "{name}: xp' errs by {} m/s", worst.vp);
    assert!(worst.time <= 1e-9, "{name}: events err by {} s", worst.time);
    assert!(
        worst.contact <= 2e-9,
        "{name}: contact errs by {} s",
        worst.contact
    );
    assert!(
        worst.velocity <= 1e-6,
        "{name}: velocity errs by {} m/s",
        worst.velocity
    );
    // A thousandth of the initial adhesion.
    assert!(
        worst.force <= 2.7e-11,
        "{name}: pull-off errs by {} N",
        worst.force
    );
    assert!(
        worst.voltage <= 1e-9,
        "{name}: voltage errs by {} V",
        worst.voltage
    );
    check_contacts(name, &trace);
}

/// The contacts are the stretches from each stick to its release.
fn check_contacts(name: &str, trace: &Trace) {
    let mut expected = Vec::new();
    let mut touch = None;
    for event in contact_events(trace) {
        match event.kind {
            EventKind::Stick => touch = Some(event.time),
            EventKind::Release => expected.push((touch.take().unwrap(), event.time)),
            _ => assert!(touch.is_none(), "{name}: impact while held"),
        }
    }
    if let Some(start) = touch {
        expected.push((start, trace.contacts.last().unwrap().1));
    }
    assert_eq!(trace.contacts, expected, "{name}");
    for (i, &xp) in trace.proof_mass.iter().enumerate() {
        let ground = trace.ground_level.unwrap();
        // Never below the ground, and on it while held.
        assert!(xp >= ground - 1e-15, "{name}: {xp} at {}", trace.time(i));
        if trace.in_contact(trace.time(i)) {
            assert!(
                (xp - ground).abs() < 1e-15,
                "{name}: {xp} at {}",
                trace.time(i)
            );
        }
    }
}

#[test]
fn square_5_hz() {
    let drive = Drive::Square { hz: 5.0, volt: 8.0 };
    check("5 Hz +-8 V square", "paper", Device::paper(), drive, 1.0);
}

#[test]
fn square_15_hz() {
    let drive = Drive::Square {
        hz: 15.0,
        volt: 8.0,
    };
    check("15 Hz +-8 V square", "paper", Device::paper(), drive, 1.0);
}

#[test]
fn sine_50_hz() {
    let drive = Drive::Sine {
        hz: 50.0,
        volt: 8.0,
    };
    check("50 Hz 8 V sine", "paper", Device::paper(), drive, 1.0);
}

#[test]
fn ramped_5_hz() {
    let drive = Drive::Ramped {
        hz: 5.0,
        volt: 8.0,
        lambda: 0.25,
    };
    check("5 Hz 8 V ramped 0.25", "paper", Device::paper(), drive, 0.4);
}

#[test]
fn square_300_hz_small() {
    let drive = Drive::Square {
        hz: 300.0,
        volt: 6.0,
    };
    check("300 Hz 6 V square", "paper", Device::paper(), drive, 0.05);
}

#[test]
fn square_15_hz_as_printed() {
    let drive = Drive::Square {
        hz: 15.0,
        volt: 8.0,
    };
    let device = Device::paper_as_printed();
    check(
        "15 Hz +-8 V square, as printed",
        "paper-as-printed",
        device,
        drive,
        0.4,
    );
}

#[test]
fn all_rows_of_the_paper_keep_their_order_of_events() {
    // The sixteen signals of Table A.1. The 6 V square rows are said to sit on the edge
    // between bounce and stick: how close the decisions are is printed with them.
    let mut rows = Vec::new();
    for hz in [5.0, 15.0, 50.0, 100.0] {
        for volt in [6.0, 8.0] {
            rows.push(Drive::Square { hz, volt });
            rows.push(Drive::Sine { hz, volt });
        }
    }
    let mut worst: f64 = 0.0;
    for drive in rows {
        let (name, hz) = match drive {
            Drive::Square { hz, volt } => (format!("{hz} Hz {volt} V square"), hz),
            Drive::Sine { hz, volt } => (format!("{hz} Hz {volt} V sine"), hz),
            _ => unreachable!(),
        };
        let duration = (4.0 / hz).min(0.4);
        let model = Preset::default().model;
        let options = Options::default();
        let trace = simulate(&model, &waveform(drive), duration, &options).unwrap();
        let tolerance = Tolerance::relative(1e-12);
        let reference = run(&Device::paper(), &drive, duration, options.rate, &tolerance);
        let case = compare(&name, &trace, &reference, &drive);
        let closest = reference
            .events
            .iter()
            .filter(|e| e.kind != Kind::Release)
            .fold(f64::INFINITY, |m, e| f64::min(m, e.margin.abs()));
        println!("    closest decision to bounce or stick: {closest:.1e} N");
        assert!(case.xp <= 1e-9, "{name}: {} m", case.xp);
        assert!(case.time <= 1e-9, "{name}: {} s", case.time);
        worst = worst.max(case.xp);
    }
    println!("all rows: worst xp {worst:.1e} m");
}
