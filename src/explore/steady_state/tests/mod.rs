mod closed_forms;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::model::effects::{ActiveEffect, CATALOGUE};
use crate::model::parameter::ParameterId as P;
use crate::model::preset::Preset;
use crate::model::with_effect;
use crate::sim::{EventKind, Options, Trace, simulate};

fn preset(name: &str) -> Model {
    Preset::embedded(name).unwrap().model
}

fn with(model: &Model, id: &str, values: &[(&str, f64)]) -> Model {
    let spec = CATALOGUE.iter().find(|spec| spec.id == id).unwrap();
    let mut effect = ActiveEffect::new(spec);
    for (parameter, value) in values {
        assert!(effect.set(parameter, *value), "{parameter}");
    }
    with_effect(model, effect)
}

fn solve(model: &Model, drive: &str, options: SteadyOptions) -> SteadyResponse {
    let drive = Waveform::parse(drive, 1.0).unwrap();
    SteadySolver::new(model, options)
        .unwrap()
        .solve(&drive, Start::Rest)
        .unwrap()
}

/// Extremes of the displacement and numbers of arrivals over the last `periods` of a run.
fn end_of_run(trace: &Trace, period: f64, periods: usize, end: f64) -> (f64, f64, usize) {
    let start = end - periods as f64 * period;
    let from = ((start - trace.t0) / trace.dt).ceil() as usize;
    let own = &trace.proof_mass[from..];
    // Parabolas through three samples each.
    let top = |sign: f64| {
        let peaks = own.windows(3).map(|w| {
            let [a, b, c] = [0, 1, 2].map(|i| sign * w[i]);
            let (slope, bend) = (0.5 * (c - a), a - 2.0 * b + c);
            if bend < 0.0 && slope.abs() < -bend {
                b - 0.5 * slope * slope / bend
            } else {
                b
            }
        });
        peaks.fold(f64::NEG_INFINITY, f64::max)
    };
    let (high, low) = (top(1.0), -top(-1.0));
    let arrives = |kind| matches!(kind, EventKind::Impact | EventKind::Stick);
    let events = trace.events.iter();
    let arrivals = events.filter(|e| arrives(e.kind) && e.time > start && e.time <= end);
    (high, low, arrivals.count())
}

/// A device and a drive drawn from a seed.
fn drawn(seed: u64) -> (Model, Waveform) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut model = preset("paper");
    let p = &mut model.parameters;
    let mut scaled = |id, low: f64, high: f64| {
        let factor = f64::exp(rng.random_range(low.ln()..high.ln()));
        p.set(id, p[id] * factor);
    };
    scaled(P::Cs, 0.3, 3.0);
    scaled(P::Gp, 0.95, 1.2);
    scaled(P::Ca, 0.3, 3.0);
    scaled(P::Ca0, 0.3, 3.0);
    scaled(P::Alpha, 0.5, 2.0);
    scaled(P::Zeta1, 0.5, 4.0);
    let frequency = f64::exp(rng.random_range(f64::ln(10.0)..f64::ln(150.0)));
    let amplitude = rng.random_range(1.0..10.0);
    let drive = match rng.random_range(0..4) {
        0 => Waveform::Sine {
            frequency,
            amplitude,
        },
        1 => Waveform::Square {
            frequency,
            amplitude,
        },
        2 => Waveform::Triangle {
            frequency,
            amplitude,
        },
        _ => Waveform::Ramped {
            frequency,
            amplitude,
            lambda: rng.random_range(0.02..0.45),
        },
    };
    (model, drive)
}

/// Every answer is where a plain transient of the sampled simulator is after many periods.
#[test]
fn answers_agree_with_long_transients_of_random_devices_and_drives() {
    const CASES: u64 = 60;
    const PERIODS: f64 = 120.0;
    let (mut worst, mut shot, mut near, mut aperiodic) = (0.0f64, 0, 0, 0);
    for seed in 0..CASES {
        let (model, drive) = drawn(seed);
        let mut solver = SteadySolver::new(&model, SteadyOptions::default()).unwrap();
        let response = solver.solve(&drive, Start::Rest).unwrap();
        let Some(multiple) = response.multiple() else {
            aperiodic += 1;
            continue;
        };
        let period = drive.period().unwrap();
        let end = PERIODS * period;
        let options = Options {
            rate: 2e5,
            ..Options::default()
        };
        let trace = simulate(&model, &drive, end, &options).unwrap();
        let (high, low, arrivals) = end_of_run(&trace, period, multiple, end);
        let cycle = &response.cycle;
        shot += usize::from(response.method == Method::Shooting);
        if response.grazing.is_near() {
            near += 1;
            continue;
        }
        assert_eq!(
            arrivals,
            cycle.arrivals.len(),
            "seed {seed}: {drive:?} {:?}",
            response.grazing
        );
        let span = cycle.span();
        // Between two samples an impact is missed by far more: there the ground is the lowest.
        let lowest = if arrivals > 0 { -58e-6 } else { low };
        let error = (high - cycle.highest)
            .abs()
            .max((lowest - cycle.lowest).abs())
            / span;
        assert!(
            error < 5e-6,
            "seed {seed}: {error} {drive:?} {:?}",
            response.grazing
        );
        worst = worst.max(error);
    }
    println!(
        "worst {worst:e}, by shooting {shot}, near grazing {near}, not periodic {aperiodic} of {CASES}"
    );
    assert!(near + aperiodic <= 6, "{near} {aperiodic}");
    assert!(shot >= 3, "{shot}");
}

#[test]
fn grazing_is_flagged_where_contact_begins() {
    let model = preset("paper");
    let mut solver = SteadySolver::new(&model, SteadyOptions::default()).unwrap();
    let mut at = |amplitude: f64| {
        let drive = Waveform::Sine {
            frequency: 50.0,
            amplitude,
        };
        solver.solve(&drive, Start::Rest).unwrap()
    };
    let (mut low, mut high) = (1.0, 6.0);
    assert!(at(low).cycle.arrivals.is_empty() && !at(high).cycle.arrivals.is_empty());
    while high - low > 1e-7 * high {
        let middle = 0.5 * (low + high);
        if at(middle).cycle.arrivals.is_empty() {
            low = middle;
        } else {
            high = middle;
        }
    }
    for response in [at(low), at(high)] {
        assert!(response.grazing.is_near(), "{:?}", response.grazing);
        assert_eq!(response.stability, Stability::NotSmooth);
        assert_eq!(response.method, Method::Transient);
    }
    // 5 % away the lowest turn is some per cent of the way above the ground.
    let away = at(0.95 * low);
    assert!(!away.grazing.is_near() && away.stability.largest_modulus().unwrap() < 1.0);
}

#[test]
fn the_strobe_and_the_start_do_not_matter() {
    let model = preset("paper");
    let drive = Waveform::parse("sine:50Hz:8V", 1.0).unwrap();
    let mut solver = SteadySolver::new(&model, SteadyOptions::default()).unwrap();
    let first = solver.solve(&drive, Start::Rest).unwrap();
    let modulus = first.stability.largest_modulus().unwrap();
    for phase in [0.1, 0.45, 0.8] {
        let options = SteadyOptions {
            strobe_phase: phase,
            ..SteadyOptions::default()
        };
        let other = SteadySolver::new(&model, options)
            .unwrap()
            .solve(&drive, Start::Rest)
            .unwrap();
        assert_eq!(other.kind, first.kind);
        assert!((other.cycle.highest - first.cycle.highest).abs() < 1e-5 * first.cycle.span());
        assert!((other.stability.largest_modulus().unwrap() - modulus).abs() < 1e-3);
    }
    // A neighbour's state is a start, and its own state is at once the answer.
    let nearby = Waveform::parse("sine:51Hz:8.1V", 1.0).unwrap();
    let neighbour = solver.solve(&nearby, Start::Rest).unwrap();
    let warm = solver
        .solve(&drive, Start::State(&neighbour.cycle.start))
        .unwrap();
    assert!((warm.cycle.highest - first.cycle.highest).abs() < 1e-5 * first.cycle.span());
    let again = solver
        .solve(&drive, Start::State(&first.cycle.start))
        .unwrap();
    assert!(again.periods_followed <= 3, "{}", again.periods_followed);
    // The trace of the cycle ends where it begins, and shows the same extremes.
    let trace = solver.trace(&model, &drive, &first, 4000).unwrap();
    let high = trace
        .proof_mass
        .iter()
        .fold(f64::NEG_INFINITY, |a, x| a.max(*x));
    assert!((high - first.cycle.highest).abs() < 1e-4 * first.cycle.span());
    assert!((trace.len() as i64 - 4000).abs() <= 1 && trace.t0.abs() < 1e-9);
}

#[test]
fn a_stopped_run_is_the_run() {
    let model = preset("paper");
    let drive = Waveform::parse("ramped:40Hz:8V:0.2", 1.0).unwrap();
    let mut solver = SteadySolver::new(&model, SteadyOptions::default()).unwrap();
    let response = solver.solve(&drive, Start::Rest).unwrap();
    let period = response.period;
    let options = Options {
        rate: 1000.0 / period,
        ..Options::default()
    };
    let trace = simulate(&model, &drive, 40.0 * period, &options).unwrap();
    let last = trace.proof_mass[trace.len() - 1];
    let own = response.cycle.strobes[0].displacement;
    assert!(
        (last - own).abs() < 2e-6 * response.cycle.span(),
        "{last} {own}"
    );
}

#[test]
fn a_mass_that_never_lets_go_is_steady_at_once() {
    let mut model = preset("paper");
    model.parameters.set(P::Ca0, 1e-5);
    let response = solve(&model, "square:20Hz:8V", SteadyOptions::default());
    assert_eq!(response.kind, ResponseKind::Periodic { multiple: 1 });
    assert!(
        response
            .cycle
            .events
            .iter()
            .all(|e| e.kind == EventKind::DriveStep)
    );
    assert!((response.cycle.highest + 58e-6).abs() < 1e-9);
    assert!(response.cycle.least_hold_share > 0.5);
}

#[test]
fn what_has_no_steady_response_says_why() {
    let model = preset("paper");
    let mut solver = SteadySolver::new(&model, SteadyOptions::default()).unwrap();
    let rest = solver.solve(&Waveform::Rest, Start::Rest).unwrap_err();
    assert_eq!(rest, SteadyError::DriveNotPeriodic);
    let drive = Waveform::parse("sine:50Hz:8V", 1.0).unwrap();
    let shaken = with(&model, "base_vibration", &[("a", 1.0), ("f", 30.0)]);
    let mut other = SteadySolver::new(&shaken, SteadyOptions::default()).unwrap();
    let error = other.solve(&drive, Start::Rest).unwrap_err();
    assert!(
        matches!(error, SteadyError::DeviceNotPeriodic { .. }),
        "{error}"
    );
    assert!(error.to_string().contains("base"));
    let buried = Start::Point {
        displacement: -1e-3,
        velocity: 0.0,
        switched_on: 0.0,
    };
    assert!(matches!(
        solver.solve(&drive, buried),
        Err(SteadyError::Start(_))
    ));
    let mut broken = preset("paper");
    broken.parameters.set(P::Gp, 1e-6);
    assert!(matches!(
        solver.set_model(&broken),
        Err(SteadyError::Simulation(_))
    ));
    // It still serves.
    assert!(solver.solve(&drive, Start::Rest).is_ok());
    let ended = solver.solve_while(&drive, Start::Rest, || false);
    assert_eq!(ended.unwrap_err(), SteadyError::Cancelled);
    let options = SteadyOptions {
        max_multiple: 0,
        ..SteadyOptions::default()
    };
    assert!(SteadySolver::new(&model, options).is_err());
}

#[test]
fn another_model_is_that_model() {
    let drive = Waveform::parse("square:50Hz:7V", 1.0).unwrap();
    let mut solver = SteadySolver::new(&preset("paper"), SteadyOptions::default()).unwrap();
    solver.solve(&drive, Start::Rest).unwrap();
    let mut model = preset("paper");
    for (id, value) in [(P::Cs, 3e-21), (P::F1, 500.0)] {
        model.parameters.set(id, value);
        solver.set_model(&model).unwrap();
        let own = solver.solve(&drive, Start::Rest).unwrap();
        let fresh = SteadySolver::new(&model, SteadyOptions::default())
            .unwrap()
            .solve(&drive, Start::Rest)
            .unwrap();
        assert_eq!(own, fresh);
    }
}

#[test]
fn effects_with_slow_and_remembering_states_reach_a_steady_response() {
    let drive = Waveform::parse("sine:50Hz:8V", 1.0).unwrap();
    for spec in CATALOGUE {
        let model = with_effect(&preset("paper"), ActiveEffect::new(spec));
        if model.check().is_err() || spec.id == "base_vibration" {
            continue;
        }
        let mut solver = SteadySolver::new(&model, SteadyOptions::default()).unwrap();
        let response = solver.solve(&drive, Start::Rest);
        let response = response.unwrap_or_else(|error| panic!("{}: {error}", spec.id));
        assert!(
            response.multiple().is_some(),
            "{}: {:?}",
            spec.id,
            response.residual
        );
    }
}

#[test]
fn exponents_of_a_stable_response_are_those_of_its_multipliers() {
    let model = preset("paper");
    let drive = Waveform::parse("sine:80Hz:2V", 1.0).unwrap();
    let mut solver = SteadySolver::new(&model, SteadyOptions::default()).unwrap();
    let response = solver.solve(&drive, Start::Rest).unwrap();
    let modulus = response.stability.largest_modulus().unwrap();
    let exponent = solver
        .lyapunov_exponent(&drive, &response, 8)
        .unwrap()
        .unwrap();
    // The neighbour turns while it comes closer: its distance is not that of one direction.
    assert!(
        (exponent - modulus.ln()).abs() < 0.2,
        "{exponent} {}",
        modulus.ln()
    );
    assert!(exponent < 0.0 && modulus < 1.0);
}

/// Taking a state out and putting it back changes nothing, at edges of the drive and with memories, too.
#[test]
fn a_restored_run_goes_on_as_if_it_had_not_stopped() {
    use crate::sim::Runner;
    for text in ["square:50Hz:8V", "sine:50Hz:8V", "ramped:50Hz:8V:0.3"] {
        let drive = Waveform::parse(text, 1.0).unwrap();
        for spec in CATALOGUE {
            let model = with_effect(&preset("paper"), ActiveEffect::new(spec));
            if model.check().is_err() {
                continue;
            }
            let mut steady = Runner::new(&model, &drive, &Options::default()).unwrap();
            let mut stopped = steady.clone();
            let (mut a, mut b) = (steady.new_trace(), stopped.new_trace());
            for i in 1..=12 {
                // Every second stop is an edge of the square wave.
                let end = f64::from(i) * 0.005;
                steady.advance_to(end, &mut a).unwrap();
                stopped.advance_to(end, &mut b).unwrap();
                let state = stopped.motion_state();
                stopped.restore(&state).unwrap();
            }
            let kinds = |trace: &Trace| trace.events.iter().map(|e| e.kind).collect::<Vec<_>>();
            assert_eq!(kinds(&a), kinds(&b), "{} {text}", spec.id);
            let (one, two) = (steady.motion_state(), stopped.motion_state());
            let (x, y) = (steady.mass_in(&one), stopped.mass_in(&two));
            assert!((x.0 - y.0).abs() < 1e-9, "{} {text}: {x:?} {y:?}", spec.id);
            for (p, q) in one.coordinates.z.iter().zip(&two.coordinates.z) {
                let size = 1e-12 + p.abs().max(q.abs());
                assert!((p - q).abs() < 1e-5 * size, "{} {text}: {p} {q}", spec.id);
            }
        }
    }
}

/// A table that repeats from late on, and a ground that jumps, are met where they repeat.
#[test]
fn a_late_table_and_a_ground_that_jumped_are_steady_later() {
    use crate::model::drive::VoltageTable;
    let model = preset("paper");
    let table = VoltageTable::new("late", vec![0.11, 0.115, 0.12], vec![-8.0, 8.0, -8.0])
        .and_then(|table| table.repeating(0.02))
        .unwrap();
    let drive = Waveform::Table(std::sync::Arc::new(table));
    let mut solver = SteadySolver::new(&model, SteadyOptions::default()).unwrap();
    let response = solver.solve(&drive, Start::Rest).unwrap();
    assert!(response.cycle.top_speed > 0.0 && response.cycle.start.time >= 0.11);
    assert!(response.cycle.span() > 10e-6, "{}", response.cycle.span());
    let jumped = with(&model, "gap_step", &[]);
    let drive = Waveform::parse("sine:50Hz:8V", 1.0).unwrap();
    let mut other = SteadySolver::new(&jumped, SteadyOptions::default()).unwrap();
    let late = other.solve(&drive, Start::Rest).unwrap();
    let mut level = late.cycle.ground_level;
    assert!(
        (level
            - solver
                .solve(&drive, Start::Rest)
                .unwrap()
                .cycle
                .ground_level)
            .abs()
            > 0.0
    );
    level += 58e-6;
    let mut moved = model.clone();
    moved.parameters.set(P::Dp, 58e-6 - level);
    let mut there = SteadySolver::new(&moved, SteadyOptions::default()).unwrap();
    let own = there.solve(&drive, Start::Rest).unwrap();
    assert!((own.cycle.highest - late.cycle.highest).abs() < 1e-4 * own.cycle.span());
}

/// The options of maps on a grid of the paper's drives, against long transients over the same number of
/// periods.
#[test]
fn the_options_of_maps_agree_with_long_transients_on_a_grid() {
    const GRID: usize = 10;
    let model = preset("paper");
    let mut solver = SteadySolver::new(&model, SteadyOptions::for_maps(&model)).unwrap();
    let (mut worst, mut near, mut differ) = (0.0f64, 0, Vec::new());
    for k in 0..2 * GRID * GRID {
        let along = |i: usize| i as f64 / (GRID - 1) as f64;
        let frequency = 5.0 + 95.0 * along(k / 2 / GRID);
        let amplitude = 1.0 + 9.0 * along(k / 2 % GRID);
        let drive = if k % 2 == 0 {
            Waveform::Sine {
                frequency,
                amplitude,
            }
        } else {
            Waveform::Square {
                frequency,
                amplitude,
            }
        };
        let response = solver.solve(&drive, Start::Rest).unwrap();
        let multiple = response.multiple().unwrap();
        let period = 1.0 / frequency;
        let end = (0.6 * frequency).ceil().max(8.0) * period;
        let options = Options {
            rate: 2e5,
            ..Options::default()
        };
        let trace = simulate(&model, &drive, end, &options).unwrap();
        let (high, _, arrivals) = end_of_run(&trace, period, multiple, end);
        let error = (high - response.cycle.highest).abs() / response.cycle.span();
        if response.grazing.is_near() {
            near += 1;
        } else if arrivals != response.cycle.arrivals.len() || error > 1e-3 {
            differ.push((drive, multiple, error));
        } else {
            worst = worst.max(error);
        }
    }
    println!("worst {worst:e}, near grazing {near}, differ {differ:?}");
    assert!(worst < 2e-5 && near <= 3, "{worst} {near}");
    assert!(differ.is_empty(), "{differ:?}");
}
