//! What must hold whatever the parameters: energy, time shift, scale, repeatability.

use std::sync::Arc;

use impactscope::model::Model;
use impactscope::model::drive::{VoltageTable, Waveform};
use impactscope::model::parameter::ParameterId;
use impactscope::model::preset::Preset;
use impactscope::sim::{EventKind, Options, Runner, Trace, simulate};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use rayon::prelude::*;

/// Seeded, so that a red run can be had again; no files are left behind.
fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(20_120_905),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

fn paper(changes: &[(&str, f64)]) -> Model {
    let mut model = Preset::default().model;
    for (id, value) in changes {
        model.set(id, *value).unwrap();
    }
    model
}

fn square(frequency: f64, amplitude: f64) -> Waveform {
    Waveform::Square {
        frequency,
        amplitude,
    }
}

fn kinds(trace: &Trace) -> Vec<EventKind> {
    trace.events.iter().map(|e| e.kind).collect()
}

/// Largest difference of xp, a sample at an event's edge included: positions do not jump.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let pairs = a.iter().zip(b);
    pairs.fold(0.0, |m, (x, y)| f64::max(m, (x - y).abs()))
}

/// Kinetic and elastic energy at each sample [J].
fn energy(model: &Model, trace: &Trace) -> Vec<f64> {
    let (m, _, k) = model.structure().matrices().unwrap();
    let sample = |i: usize| {
        let x = nalgebra::Vector2::new(trace.cantilever[i], trace.proof_mass[i]);
        let v = nalgebra::Vector2::new(trace.cantilever_velocity[i], trace.proof_mass_velocity[i]);
        0.5 * (v.dot(&(m * v)) + x.dot(&(k * x)))
    };
    (0..trace.len()).map(sample).collect()
}

/// What an error of twice the tolerance in the fast mode's displacement is worth [J].
fn slack(model: &Model, energy: f64) -> f64 {
    let mass = model.structure().matrices().unwrap().0[(1, 1)];
    let omega = std::f64::consts::TAU * model.parameters[ParameterId::F2];
    (2.0 * energy * mass).sqrt() * omega * 2.0 * Options::default().tolerance + 1e-24
}

proptest! {
    #![proptest_config(config(48))]

    #[test]
    fn undriven_energy_never_grows(
        x0 in -57e-6..150e-6,
        v0 in -1.0..1.0,
        alpha in 0.0..=1.0,
        cs in prop_oneof![Just(0.0), 1e-23..1e-19],
        zeta in prop_oneof![Just(0.0), 1e-3..0.5],
        ca0 in prop_oneof![Just(0.0), 1e-9..1e-6],
    ) {
        let model = paper(&[
            ("x0", x0), ("v0", v0), ("alpha", alpha), ("Cs", cs),
            ("zeta1", zeta), ("zeta2", zeta), ("Ca0", ca0),
        ]);
        let trace = simulate(&model, &Waveform::Rest, 0.02, &Options::default()).unwrap();
        let energy = energy(&model, &trace);
        let slack = slack(&model, energy[0]);
        let mut least = energy[0];
        for (i, &now) in energy.iter().enumerate() {
            prop_assert!(
                now <= least + slack,
                "{} after {} J at {} s; events {:?}", now, least, trace.time(i), trace.events
            );
            least = least.min(now);
        }
    }

    #[test]
    fn conservative_flight_and_elastic_impacts_keep_their_energy(
        x0 in 0.0..150e-6,
        v0 in -0.5..0.5,
    ) {
        // alpha = 1, nothing that damps, and no adhesion: only sticking can lose energy.
        let model = paper(&[
            ("x0", x0), ("v0", v0), ("alpha", 1.0), ("Cs", 0.0),
            ("zeta1", 0.0), ("zeta2", 0.0), ("Ca0", 0.0), ("Ca", 0.0),
        ]);
        let trace = simulate(&model, &Waveform::Rest, 0.01, &Options::default()).unwrap();
        let energy = energy(&model, &trace);
        let slack = slack(&model, energy[0]);
        let end = trace.contacts.first().map_or(trace.end(), |c| c.0);
        for (i, e) in energy.iter().enumerate().take_while(|(i, _)| trace.time(*i) < end) {
            prop_assert!((e - energy[0]).abs() < slack, "{} at {}", e / energy[0] - 1.0, i);
        }
    }

    #[test]
    fn a_delayed_drive_gives_the_delayed_motion(
        delay in 1_usize..400,
        steps in prop::collection::vec((1e-3..8e-3, -9.0..9.0), 3..10),
    ) {
        // A voltage at which the rising branch exerts no force, so that the device rests
        // until the table begins; the first change rises, so that the branch is kept.
        let gain = |v: f64| 1.4796 + v * (-0.7057 + v * (-0.0255 + v * 0.0016));
        let (mut low, mut high) = (0.0, 4.0);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if gain(middle) > 0.0 { low = middle } else { high = middle }
        }
        let table = |start: f64| {
            let (mut time, mut voltage) = (vec![start, start + 2e-3], vec![low, 8.5]);
            for (dt, v) in &steps {
                time.push(time[time.len() - 1] + dt);
                voltage.push(*v);
            }
            Waveform::Table(Arc::new(VoltageTable::new("test", time, voltage).unwrap()))
        };
        let model = paper(&[]);
        let options = Options::default();
        let shift = delay as f64 / options.rate;
        let now = simulate(&model, &table(1e-3), 0.08, &options).unwrap();
        let later = simulate(&model, &table(1e-3 + shift), 0.08 + shift, &options).unwrap();
        prop_assert_eq!(later.len(), now.len() + delay);
        prop_assert!(later.proof_mass[..delay].iter().all(|x| x.abs() < 1e-15));
        prop_assert_eq!(kinds(&now), kinds(&later));
        let error = difference(&now.proof_mass, &later.proof_mass[delay..]);
        prop_assert!(error < 1e-9, "{}", error);
        for (a, b) in now.events.iter().zip(&later.events) {
            prop_assert!((a.time + shift - b.time).abs() < 1e-9, "{:?} {:?}", a, b);
        }
    }

    #[test]
    fn a_scaled_device_moves_to_scale(
        scale in 0.1..10.0,
        frequency in 5.0..200.0,
        amplitude in 3.0..9.0,
        alpha in 0.0..1.0,
    ) {
        // All lengths and forces times `scale`, at the same frequencies and masses:
        // Cs / L^3 has to stay.
        let run = |s: f64| {
            let mut model = paper(&[("alpha", alpha)]);
            for (id, power) in [("eta", 1), ("dp", 1), ("gp", 1), ("Ca", 1), ("Ca0", 1), ("Cs", 3)] {
                let at = ParameterId::from_id(id).unwrap();
                model.set(id, model.parameters[at] * f64::powi(s, power)).unwrap();
            }
            let options = Options { tolerance: 1e-12 * s, ..Options::default() };
            simulate(&model, &square(frequency, amplitude), 0.03, &options).unwrap()
        };
        let (one, other) = (run(1.0), run(scale));
        prop_assert_eq!(kinds(&one), kinds(&other));
        let scaled: Vec<f64> = other.proof_mass.iter().map(|x| x / scale).collect();
        let error = difference(&one.proof_mass, &scaled);
        prop_assert!(error < 1e-9, "{}", error);
    }

    #[test]
    fn the_same_again_gives_the_same_bytes(
        frequency in 5.0..300.0,
        amplitude in 3.0..9.0,
        alpha in 0.0..1.0,
    ) {
        let model = paper(&[("alpha", alpha)]);
        let options = Options { forces: true, ..Options::default() };
        let run = || simulate(&model, &square(frequency, amplitude), 0.02, &options).unwrap();
        let (a, b) = (run(), run());
        let bits = |t: &Trace| t.proof_mass.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(&a), bits(&b));
        prop_assert_eq!(a, b);
    }

    #[test]
    fn pieces_make_the_whole(
        cuts in prop::collection::vec(0.0..0.06_f64, 1..12),
        frequency in 5.0..100.0,
    ) {
        let model = paper(&[]);
        let drive = square(frequency, 8.0);
        let options = Options::default();
        let whole = simulate(&model, &drive, 0.06, &options).unwrap();
        let mut cuts = cuts;
        cuts.push(0.06);
        cuts.sort_by(f64::total_cmp);
        let mut runner = Runner::new(&model, &drive, &options).unwrap();
        let mut trace = runner.new_trace();
        for &cut in &cuts {
            runner.advance(cut, &mut trace).unwrap();
            prop_assert!(runner.time() >= cut, "{} for {}", runner.time(), cut);
            // Whole steps, but not more than one of them too far: 1 ms is a generous step.
            prop_assert!(runner.time() < cut + 1e-3, "{} for {}", runner.time(), cut);
            let due = (runner.time() * options.rate + 1e-9).floor() as usize + 1;
            prop_assert!(trace.len().abs_diff(due) <= 1, "{} of {}", trace.len(), due);
        }
        whole_is_start_of(&whole, &trace)?;
    }

    #[test]
    fn a_changed_parameter_keeps_position_and_velocity(
        at in 1e-3..0.03,
        cs in 1e-22..1e-20,
        zeta in 0.01..0.3,
        eta in 1e-7..5e-7,
    ) {
        let drive = square(50.0, 8.0);
        let options = Options { rate: 1e6, ..Options::default() };
        let mut runner = Runner::new(&paper(&[]), &drive, &options).unwrap();
        let mut trace = runner.new_trace();
        runner.advance(at, &mut trace).unwrap();
        let change = runner.time();
        runner.set_model(&paper(&[("Cs", cs), ("zeta1", zeta), ("eta", eta)])).unwrap();
        runner.advance(change + 20e-6, &mut trace).unwrap();
        let event = |t: f64| trace.events.iter().any(|e| (e.time - t).abs() < 2e-6);
        let from = ((change - 3e-6) * options.rate) as usize;
        for i in from..from + 10 {
            // 1 us at 1 m/s and at 1e5 m/s^2: faster than this device moves.
            for channel in [&trace.proof_mass, &trace.cantilever] {
                let step = (channel[i + 1] - channel[i]).abs();
                prop_assert!(step < 1e-6, "{}", step);
            }
            for channel in [&trace.proof_mass_velocity, &trace.cantilever_velocity] {
                let step = (channel[i + 1] - channel[i]).abs();
                prop_assert!(event(trace.time(i)) || step < 0.1, "{} at {}", step, trace.time(i));
            }
        }
    }
}

/// Whether `whole` is, bit by bit, the start of `longer`.
fn whole_is_start_of(whole: &Trace, longer: &Trace) -> Result<(), TestCaseError> {
    let end = whole.end();
    prop_assert!(longer.len() >= whole.len());
    prop_assert_eq!(&whole.proof_mass[..], &longer.proof_mass[..whole.len()]);
    prop_assert_eq!(
        &whole.cantilever_velocity[..],
        &longer.cantilever_velocity[..whole.len()]
    );
    prop_assert!(longer.events.len() >= whole.events.len());
    prop_assert_eq!(&whole.events[..], &longer.events[..whole.events.len()]);
    prop_assert!(
        longer.events[whole.events.len()..]
            .iter()
            .all(|e| e.time >= end)
    );
    prop_assert!(longer.contacts.len() >= whole.contacts.len());
    for (a, b) in whole.contacts.iter().zip(&longer.contacts) {
        prop_assert_eq!(a.0, b.0);
        // The last one may have been cut by the end of the run.
        prop_assert!(
            a.1 == b.1 || (a.1 <= b.1 && a.1 >= end - 1e-9),
            "{:?} {:?}",
            a,
            b
        );
    }
    Ok(())
}

#[test]
fn setting_the_same_model_changes_nothing() {
    let model = paper(&[]);
    let drive = square(15.0, 8.0);
    let options = Options::default();
    let whole = simulate(&model, &drive, 0.1, &options).unwrap();
    let mut runner = Runner::new(&model, &drive, &options).unwrap();
    let mut trace = runner.new_trace();
    for i in 1..=20 {
        runner.advance(f64::from(i) * 5e-3, &mut trace).unwrap();
        runner.set_model(&model).unwrap();
        runner.set_drive(&drive).unwrap();
    }
    same_within(&whole, &trace);
}

/// Whether `whole` is the start of `longer` within what the tolerance allows.
fn same_within(whole: &Trace, longer: &Trace) {
    let events = &longer.events[..whole.events.len()];
    for (a, b) in whole.events.iter().zip(events) {
        assert_eq!(a.kind, b.kind);
        assert!((a.time - b.time).abs() < 1e-9, "{a:?} {b:?}");
    }
    let error = difference(&whole.proof_mass, &longer.proof_mass[..whole.len()]);
    assert!(error < 1e-10, "{error}");
}

#[test]
fn a_refused_change_changes_nothing() {
    let options = Options::default();
    let drive = square(15.0, 8.0);
    let mut runner = Runner::new(&paper(&[]), &drive, &options).unwrap();
    let mut trace = runner.new_trace();
    runner.advance(0.02, &mut trace).unwrap();
    assert!(runner.set_model(&paper(&[("gp", 10e-6)])).is_err());
    assert!(runner.set_drive(&square(-1.0, 8.0)).is_err());
    runner.advance(0.04, &mut trace).unwrap();
    let whole = simulate(&paper(&[]), &drive, 0.04, &options).unwrap();
    whole_is_start_of(&whole, &trace).unwrap();
}

#[test]
fn an_ensemble_in_parallel_is_the_ensemble_in_series() {
    let one = |i: usize| {
        let model = paper(&[("alpha", i as f64 / 40.0), ("Cs", 1e-21 * (1.0 + i as f64))]);
        simulate(&model, &square(15.0, 8.0), 0.05, &Options::default()).unwrap()
    };
    let series: Vec<Trace> = (0..40).map(one).collect();
    let parallel: Vec<Trace> = (0..40).into_par_iter().map(one).collect();
    assert_eq!(series, parallel);
    // The members do differ.
    assert!(series.windows(2).all(|w| w[0] != w[1]));
}

#[test]
fn a_device_can_be_handed_to_a_thread() {
    fn sendable<T: Send + Sync + 'static>() {}
    sendable::<Runner>();
    sendable::<Trace>();
    sendable::<Model>();
    sendable::<Waveform>();
}

#[test]
fn sampling_does_not_change_the_motion() {
    let run = |rate: f64| {
        let options = Options {
            rate,
            ..Options::default()
        };
        simulate(&paper(&[]), &square(15.0, 8.0), 0.1, &options).unwrap()
    };
    let (fine, coarse) = (run(200e3), run(50e3));
    assert_eq!(kinds(&fine), kinds(&coarse));
    let thinned: Vec<f64> = fine.proof_mass.iter().step_by(4).copied().collect();
    assert!(difference(&thinned, &coarse.proof_mass) < 1e-10);
    for (a, b) in fine.events.iter().zip(&coarse.events) {
        assert!((a.time - b.time).abs() < 1e-9);
    }
}

/// A recorded voltage may hold two samples that are as close as two numbers can be.
#[test]
fn two_samples_at_one_instant_change_nothing() {
    let model = paper(&[]);
    let run = |twice: u64| {
        let mut time: Vec<f64> = (0..=200).map(|i| 1e-4 * f64::from(i)).collect();
        if twice > 0 {
            let again = f64::from_bits(time[77].to_bits() + twice);
            time.insert(78, again);
        }
        let volts = time.iter().map(|t| 8.0 * (300.0 * t).sin()).collect();
        let table = VoltageTable::new("table", time, volts).unwrap();
        let drive = Waveform::Table(table.into());
        simulate(&model, &drive, 0.02, &Options::default()).unwrap()
    };
    let plain = run(0);
    for ulps in [1, 5, 1000] {
        let worst = difference(&plain.proof_mass, &run(ulps).proof_mass);
        assert!(worst < 1e-11, "{ulps} ulps: {worst:e} m");
    }
}
