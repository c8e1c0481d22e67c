//! Parameters that no device has: the simulator ends within the steps it is given, with a
//! sound trace or with an error that says what is wrong.

use std::sync::{Arc, Mutex, mpsc};
use std::time::Duration;

use impactscope::model::drive::{VoltageTable, Waveform};
use impactscope::model::effects::ActiveEffect;
use impactscope::model::parameter::ParameterId;
use impactscope::model::preset::Preset;
use impactscope::model::{Model, effects};
use impactscope::sim::{Options, Runner, SimError, Trace, simulate};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn options() -> Options {
    Options {
        max_steps: 200_000,
        max_events: 100_000,
        forces: true,
        ..Options::default()
    }
}

fn all_finite(trace: &Trace) -> Result<(), String> {
    let forces = trace.forces.iter().flat_map(|f| {
        [
            &f.drive,
            &f.film,
            &f.effects,
            &f.adhesion,
            &f.ground,
            &f.pull_off,
        ]
    });
    let channels = [
        &trace.voltage,
        &trace.proof_mass,
        &trace.cantilever,
        &trace.proof_mass_velocity,
        &trace.cantilever_velocity,
    ];
    for (k, channel) in channels.into_iter().chain(forces).enumerate() {
        if let Some(i) = channel.iter().position(|x| !x.is_finite()) {
            return Err(format!("channel {k}, sample {i} is {}", channel[i]));
        }
    }
    for event in &trace.events {
        let values = [
            event.time,
            event.velocity_before,
            event.velocity_after,
            event.pull_off_force,
            event.contact_duration,
        ];
        if values.iter().any(|x| !x.is_finite()) {
            return Err(format!("{event:?}"));
        }
    }
    if !trace.events.is_sorted_by(|a, b| a.time <= b.time) {
        return Err("events out of order".to_owned());
    }
    Ok(())
}

/// Runs, and judges what comes back.
fn judge(model: &Model, drive: &Waveform, duration: f64, options: &Options) -> Result<(), String> {
    let outcome = simulate(model, drive, duration, options);
    match outcome {
        Ok(trace) => {
            let expected = (duration * options.rate + 1e-9).floor() as usize + 1;
            if trace.steps > options.max_steps {
                return Err(format!("{} steps", trace.steps));
            }
            if trace.len() != expected {
                return Err(format!("{} samples instead of {expected}", trace.len()));
            }
            if let Some(ground) = trace.ground_level {
                let scale = ground.abs().max(1e-6);
                let below = |x: &&f64| **x < ground - 1e-9 * scale;
                if let Some(x) = trace.proof_mass.iter().find(below) {
                    return Err(format!("{x} m is below the ground at {ground} m"));
                }
            }
            all_finite(&trace)
        }
        Err(error) => match &error {
            SimError::Diverged {
                time, parameter, ..
            }
            | SimError::StepTooSmall {
                time, parameter, ..
            }
            | SimError::TooMuchWork {
                time, parameter, ..
            } => {
                if parameter.is_empty() || !(0.0..=duration).contains(time) {
                    return Err(format!("says too little: {error:?}"));
                }
                Ok(())
            }
            SimError::Model(_) | SimError::Drive(_) | SimError::Options { .. } => Ok(()),
        },
    }
}

/// A value from zero, or from any decade of the range.
fn decades(low: f64, high: f64) -> impl Strategy<Value = f64> {
    prop_oneof![
        1 => Just(0.0),
        6 => (low.log10()..high.log10()).prop_map(|e| 10_f64.powf(e)),
    ]
}

fn drives() -> impl Strategy<Value = Waveform> {
    let frequency = || (-1.0..6.0).prop_map(|e| 10_f64.powf(e));
    let amplitude = || prop_oneof![-10.0..10.0, -1e4..1e4];
    prop_oneof![
        Just(Waveform::Rest),
        (frequency(), amplitude()).prop_map(|(frequency, amplitude)| Waveform::Square {
            frequency,
            amplitude
        }),
        (frequency(), amplitude()).prop_map(|(frequency, amplitude)| Waveform::Sine {
            frequency,
            amplitude
        }),
        (frequency(), amplitude()).prop_map(|(frequency, amplitude)| Waveform::Triangle {
            frequency,
            amplitude
        }),
        (frequency(), amplitude(), 0.0..=0.5).prop_map(|(frequency, amplitude, lambda)| {
            Waveform::Ramped {
                frequency,
                amplitude,
                lambda,
            }
        }),
        (frequency(), frequency(), amplitude()).prop_map(|(from, to, amplitude)| {
            Waveform::Chirp {
                from,
                to,
                amplitude,
                duration: 0.02,
            }
        }),
    ]
}

fn models() -> impl Strategy<Value = Model> {
    let ground = (
        decades(1e-25, 1e-12),
        // dp and what the film has left at contact.
        (-7.0..-2.0).prop_map(|e: f64| 10_f64.powf(e)),
        prop_oneof![Just(1e-9), (-9.0..-2.0).prop_map(|e: f64| 10_f64.powf(e))],
        decades(1e-10, 1e3),
        decades(1e-12, 1.0),
        prop_oneof![Just(0.0), Just(1.0), 0.0..1.0],
    );
    let structure = (
        decades(1e-10, 1.0),
        prop_oneof![Just(0.0), Just(1.0), 0.0..20.0],
        prop_oneof![Just(0.0), Just(1.0), 0.0..20.0],
        decades(1e-1, 1e6),
        decades(1e-1, 1e6),
    );
    let start = (
        prop_oneof![3 => Just(0.0), 1 => -1e-3..1e-3, 1 => -1e6..1e6],
        prop_oneof![3 => Just(0.0), 1 => -10.0..10.0, 1 => -1e9..1e9],
        prop_oneof![4 => Just(None), 1 => decades(1e-12, 1e6).prop_map(Some)],
    );
    (ground, structure, start).prop_map(|(ground, structure, start)| {
        let (cs, dp, left, ca, ca0, alpha) = ground;
        let (eta, zeta1, zeta2, f1, f2) = structure;
        let (x0, v0, drag) = start;
        let mut model = Preset::default().model;
        if let Some(cd) = drag {
            let spec = effects::find("quadratic_drag").unwrap();
            model.effects.push(ActiveEffect::new(spec));
            model.set("quadratic_drag.cd", cd).unwrap();
        }
        for (id, value) in [
            ("Cs", cs),
            ("dp", dp),
            ("gp", dp + left),
            ("Ca", ca),
            ("Ca0", ca0),
            ("alpha", alpha),
            ("eta", eta),
            ("zeta1", zeta1),
            ("zeta2", zeta2),
            ("f1", f1),
            ("f2", f2),
            ("x0", x0),
            ("v0", v0),
        ] {
            model.set(id, value).unwrap();
        }
        model
    })
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 128,
        rng_seed: RngSeed::Fixed(20_120_905),
        failure_persistence: None,
        max_shrink_iters: 64,
        ..ProptestConfig::default()
    })]

    #[test]
    fn any_device_ends_soundly(model in models(), drive in drives()) {
        if let Err(reason) = judge(&model, &drive, 0.02, &options()) {
            return Err(TestCaseError::fail(format!("{reason}\n{:?}", model.parameters)));
        }
    }

    #[test]
    fn any_tolerance_and_rate_end_soundly(
        tolerance in (-20.0..0.0).prop_map(|e: f64| 10_f64.powf(e)),
        rate in (0.0..6.5).prop_map(|e: f64| 10_f64.powf(e)),
        fixed in prop_oneof![3 => Just(None), 1 => (-12.0..1.0).prop_map(|e: f64| Some(10_f64.powf(e)))],
        drive in drives(),
    ) {
        let options = Options { tolerance, rate, fixed_step: fixed, ..options() };
        if let Err(reason) = judge(&Preset::default().model, &drive, 0.02, &options) {
            return Err(TestCaseError::fail(format!("{reason}\n{options:?}")));
        }
    }
}

/// Single cases that are easy to get wrong.
#[test]
fn corners_end_soundly() {
    let square = Waveform::Square {
        frequency: 15.0,
        amplitude: 8.0,
    };
    let corners: [&[(&str, f64)]; 12] = [
        &[("gp", 58.001e-6)],
        &[("gp", 58.001e-6), ("Cs", 1e-12)],
        &[("alpha", 1.0), ("Ca0", 0.0), ("Ca", 0.0)],
        &[("alpha", 0.0), ("Ca0", 0.0), ("Ca", 0.0)],
        &[("Cs", 0.0), ("zeta1", 0.0), ("zeta2", 0.0), ("alpha", 1.0)],
        &[("zeta1", 20.0), ("zeta2", 20.0)],
        &[("f1", 0.0)],
        &[("f1", 0.0), ("f2", 0.0)],
        &[
            ("f1", 6424.0),
            ("f2", 6424.0),
            ("zeta1", 1.0),
            ("zeta2", 1.0),
        ],
        &[("f1", 1e6), ("f2", 1e6)],
        &[("eta", 1e9)],
        &[("v0", -1e9)],
    ];
    for changes in corners {
        let mut model = Preset::default().model;
        for (id, value) in changes {
            model.set(id, *value).unwrap();
        }
        if let Err(reason) = judge(&model, &square, 0.1, &options()) {
            panic!("{changes:?}: {reason}");
        }
    }
}

#[test]
fn senseless_options_are_refused_by_name() {
    let model = Preset::default().model;
    let good = Options::default();
    let cases = [
        Options { rate: 0.0, ..good },
        Options { rate: -1.0, ..good },
        Options {
            rate: f64::NAN,
            ..good
        },
        Options {
            rate: f64::INFINITY,
            ..good
        },
        Options {
            tolerance: 0.0,
            ..good
        },
        Options {
            tolerance: -1e-12,
            ..good
        },
        Options {
            tolerance: f64::NAN,
            ..good
        },
        Options {
            fixed_step: Some(0.0),
            ..good
        },
        Options {
            fixed_step: Some(-1.0),
            ..good
        },
        Options {
            fixed_step: Some(f64::NAN),
            ..good
        },
    ];
    for options in cases {
        let error = simulate(&model, &Waveform::Rest, 0.01, &options);
        assert!(
            matches!(error, Err(SimError::Options { .. })),
            "{options:?}: {error:?}"
        );
    }
    for duration in [f64::NAN, f64::INFINITY, -1.0, 1e12] {
        let outcome = simulate(&model, &Waveform::Rest, duration, &good);
        assert!(
            outcome.is_err(),
            "{duration}: {} samples",
            outcome.unwrap().len()
        );
    }
}

/// Wall time after which a case counts as endless; all of them together take seconds.
const ENDLESS: Duration = Duration::from_secs(240);

/// Does `work` on a thread of its own. It names each case before it begins it; one that does not
/// end is named here.
fn that_ends(work: impl FnOnce(&dyn Fn(String)) + Send + 'static) {
    let case = Arc::new(Mutex::new(String::new()));
    let (done, end) = mpsc::channel();
    let named = Arc::clone(&case);
    let thread = std::thread::spawn(move || {
        // Dropped where the work is done, or has failed.
        let _done: mpsc::Sender<()> = done;
        work(&|name| *named.lock().unwrap() = name);
    });
    if end.recv_timeout(ENDLESS) == Err(mpsc::RecvTimeoutError::Timeout) {
        panic!("{} does not end", case.lock().unwrap());
    }
    if let Err(panic) = thread.join() {
        std::panic::resume_unwind(panic);
    }
}

/// Ends of a parameter's limits, and numbers near the ends of all numbers.
fn extremes((low, high): (f64, f64)) -> Vec<f64> {
    let tiny = f64::from_bits(1);
    let mut all = vec![
        0.0, low, high, tiny, -tiny, 1e-300, -1e-300, 1e300, -1e300, 1e-12,
    ];
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// Runs for a few samples and a few steps, and judges how many samples came and how much room
/// was made for them.
fn bounded(model: &Model, drive: &Waveform) -> Result<Option<Trace>, String> {
    const SAMPLES: usize = 6;
    /// What a trace may reserve beyond its samples.
    const ROOM: usize = 256;
    let options = Options {
        max_steps: 60,
        max_events: 60,
        ..Options::default()
    };
    let Ok(trace) = simulate(model, drive, 1e-4, &options) else {
        return Ok(None);
    };
    let room = trace.proof_mass.capacity().max(trace.voltage.capacity());
    if trace.len() != SAMPLES || room > ROOM {
        return Err(format!("{} samples, room for {room}", trace.len()));
    }
    all_finite(&trace).map(|()| Some(trace))
}

#[test]
fn every_effect_ends_at_the_extremes_of_its_parameters() {
    that_ends(|name| {
        let square = Waveform::parse("square:15Hz:8V", 0.1).unwrap();
        for spec in effects::CATALOGUE {
            let run = |changes: &[(&str, f64)]| {
                name(format!("{} {changes:?}", spec.id));
                let mut model = Preset::default().model;
                let mut effect = ActiveEffect::new(spec);
                for (id, value) in changes {
                    effect.set(id, *value);
                }
                model.effects.push(effect);
                if let Err(reason) = bounded(&model, &square) {
                    panic!("{} {changes:?}: {reason}", spec.id);
                }
            };
            for (i, a) in spec.parameters.iter().enumerate() {
                for x in extremes(a.limits) {
                    run(&[(a.id, x)]);
                    for b in &spec.parameters[..i] {
                        for y in extremes(b.limits) {
                            run(&[(a.id, x), (b.id, y)]);
                        }
                    }
                }
            }
        }
    });
}

/// A motion too fast or too stiff to follow takes a bounded number of steps for its time, and the
/// error names the effect.
#[test]
fn every_effect_takes_a_bounded_number_of_steps_at_its_extremes() {
    const SPAN: f64 = 0.01;
    /// Steps given at once, for each second, for each of the few pieces of the drive, and for modes of
    /// an effect that need steps of 1.5 us.
    const GIVEN: u64 = 4000;
    const MOST: u64 = GIVEN + 20_000 + 20 * 64 + 4 * 6_700;
    let options = Options {
        max_steps_at_once: GIVEN,
        ..Options::default()
    };
    let square = Waveform::parse("square:15Hz:8V", SPAN).unwrap();
    let mut given_up = Vec::new();
    for spec in effects::CATALOGUE {
        for parameter in spec.parameters {
            let ((low, high), (from, to)) = (parameter.limits, parameter.range);
            for value in [low, high, from, to, 1e3 * parameter.default] {
                let mut model = Preset::default().model;
                let mut effect = ActiveEffect::new(spec);
                effect.set(parameter.id, value);
                model.effects.push(effect);
                let Ok(mut runner) = Runner::new(&model, &square, &options) else {
                    continue;
                };
                let mut trace = runner.new_trace();
                let outcome = runner.advance(SPAN, &mut trace);
                let case = format!("{}.{} = {value:e}", spec.id, parameter.id);
                assert!(trace.steps <= MOST, "{case}: {} steps", trace.steps);
                if let Err(SimError::TooMuchWork { parameter, .. }) = outcome {
                    // A mode of an effect may be so fast that steps of the usual length are too many.
                    assert!(
                        [spec.id, "duration"].contains(&parameter),
                        "{case}: {parameter}"
                    );
                    given_up.push(case);
                }
            }
        }
    }
    println!("given up: {given_up:#?}");
    let stiff = |case: &String| case.starts_with("quadratic_drag");
    assert!(given_up.iter().any(stiff));
}

/// Usual parameters are far from the bound.
#[test]
fn every_effect_at_its_usual_value_is_followed() {
    let options = Options {
        max_steps_at_once: 2000,
        ..Options::default()
    };
    let square = Waveform::parse("square:15Hz:8V", 0.1).unwrap();
    for spec in effects::CATALOGUE {
        let mut model = Preset::default().model;
        model.effects.push(ActiveEffect::new(spec));
        let outcome = simulate(&model, &square, 0.1, &options);
        assert!(outcome.is_ok(), "{}: {:?}", spec.id, outcome.err());
    }
}

#[test]
fn a_span_that_takes_too_many_steps_is_refused_at_once() {
    let mut fast = Preset::default().model;
    fast.set("f2", 1e6).unwrap();
    let error = simulate(&fast, &Waveform::Rest, 1e3, &Options::default()).unwrap_err();
    assert!(
        matches!(
            error,
            SimError::Options {
                what: "duration",
                ..
            }
        ),
        "{error}"
    );
    assert!(error.to_string().contains("steps"), "{error}");
}

#[test]
fn every_device_ends_at_the_extremes_of_its_parameters() {
    that_ends(|name| {
        let points = (vec![0.0, 2e-5, 3e-5], vec![0.0, 8.0, -8.0]);
        let table = VoltageTable::new("three points", points.0, points.1).unwrap();
        let drives = [Waveform::Rest, Waveform::Table(Arc::new(table))];
        for preset in [
            "paper",
            "paper-as-printed",
            "oscillator",
            "faller",
            "bouncing-ball",
        ] {
            let device = Preset::embedded(preset).unwrap().model;
            for id in ParameterId::ALL.into_iter().filter(|id| device.uses(*id)) {
                for value in extremes(id.spec().limits) {
                    name(format!("{preset} {} = {value:e}", id.spec().id));
                    let mut model = device.clone();
                    if model.set(id.spec().id, value).is_err() {
                        continue;
                    }
                    for drive in &drives {
                        if let Err(reason) = bounded(&model, drive) {
                            panic!("{preset} {} = {value:e}: {reason}", id.spec().id);
                        }
                    }
                }
            }
        }
    });
}

/// A step of the slow device is 10^5 s long, and late readings begin 1000 s before the run.
#[test]
fn no_more_samples_are_taken_than_are_asked_for() {
    let mut slow = Preset::embedded("oscillator").unwrap().model;
    slow.set("f1", 1e-5).unwrap();
    let mut late = Preset::default().model;
    let mut effect = ActiveEffect::new(effects::find("sensor_lag").unwrap());
    effect.set("delay", 1e3);
    late.effects.push(effect);
    for model in [&slow, &late] {
        let trace = simulate(model, &Waveform::Rest, 0.1, &options()).unwrap();
        assert_eq!(trace.len(), 5001);
        let forces = trace.forces.unwrap();
        for column in [&trace.proof_mass, &trace.voltage, &forces.film] {
            assert!(column.capacity() < 6000, "room for {}", column.capacity());
        }
    }
    // A run without a last sample would be ahead by all of the delay.
    let mut runner = Runner::new(&late, &Waveform::Rest, &options()).unwrap();
    let mut trace = runner.new_trace();
    let error = runner.advance(1e-3, &mut trace).unwrap_err();
    assert!(error.to_string().contains("delay"), "{error}");
    assert!(trace.is_empty());
}

#[test]
fn a_time_constant_too_short_to_follow_is_none() {
    let square = Waveform::parse("square:15Hz:8V", 0.1).unwrap();
    // Before the first impact, after which the smallest difference grows.
    let run = |model: &Model| simulate(model, &square, 3e-4, &options()).unwrap();
    let without = run(&Preset::default().model);
    for id in ["sensor_lag", "amplifier_lag", "film_spring"] {
        for tau in [f64::from_bits(1), 1e-300, 1e-25] {
            let mut model = Preset::default().model;
            let mut effect = ActiveEffect::new(effects::find(id).unwrap());
            effect.set("tau", tau);
            model.effects.push(effect);
            let with = run(&model);
            assert_eq!(with.len(), without.len());
            for (a, b) in with.proof_mass.iter().zip(&without.proof_mass) {
                assert!((a - b).abs() < 1e-11, "{id} {tau:e}: {a} {b}");
            }
        }
    }
}
