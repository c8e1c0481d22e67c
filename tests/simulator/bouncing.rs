//! A ball that rebounds by restitution, against the formulas of its bounces.

use impactscope::model::drive::Waveform;
use impactscope::model::effects::{self, ActiveEffect};
use impactscope::model::ground::{BounceRule, StickSpeed};
use impactscope::model::parameter::ParameterId;
use impactscope::model::preset::Preset;
use impactscope::model::{Model, with_effect};
use impactscope::sim::{Event, EventKind, Options, Trace, simulate};

const GRAVITY: f64 = 9.80665;
const DROP: f64 = 0.3;
const LEVEL: f64 = -0.05;

fn ball(alpha: f64) -> Model {
    let mut model = Preset::embedded("bouncing-ball").unwrap().model;
    model.set("alpha", alpha).unwrap();
    model
}

fn run(model: &Model, duration: f64, tolerance: f64) -> Trace {
    let options = Options {
        rate: 1e3,
        tolerance,
        ..Options::default()
    };
    simulate(model, &Waveform::Rest, duration, &options).unwrap()
}

fn of_kind(trace: &Trace, kind: EventKind) -> Vec<Event> {
    let all = trace.events.iter();
    all.filter(|e| e.kind == kind).cloned().collect()
}

/// Time and speed of arrival of the bounces: `t1 = sqrt(2 h / g)`, `t_n+1 = t_n + 2 alpha v_n / g`,
/// `v_n+1 = alpha v_n`.
fn arrivals(alpha: f64) -> impl Iterator<Item = (f64, f64)> {
    let first = (2.0 * DROP / GRAVITY).sqrt();
    let next = move |(t, v): &(f64, f64)| {
        let after = alpha * v;
        Some((t + 2.0 * after / GRAVITY, after))
    };
    std::iter::successors(Some((first, GRAVITY * first)), next)
}

#[test]
fn times_and_speeds_of_the_bounces_are_geometric() {
    for alpha in [0.3, 0.7, 0.9] {
        // The liveliest ball comes back eight times in 3 s.
        let trace = run(&ball(alpha), 3.0, 1e-12);
        let bounces = of_kind(&trace, EventKind::Impact);
        let clear = arrivals(alpha).take_while(|(t, v)| *t < 3.0 && *v > 1e-3);
        let clear: Vec<(f64, f64)> = clear.collect();
        assert!(bounces.len() >= clear.len() && clear.len() > 5, "{alpha}");
        for (event, (t, v)) in bounces.iter().zip(clear) {
            assert!((event.time - t).abs() < 1e-8, "{alpha}: {event:?} {t}");
            assert!((event.velocity_before + v).abs() < 1e-7, "{event:?} {v}");
            let ratio = -event.velocity_after / event.velocity_before;
            assert!((ratio - alpha).abs() < 1e-12, "{event:?}");
        }
    }
}

#[test]
fn infinitely_many_bounces_end_in_rest() {
    for alpha in [0.3, 0.7, 0.85] {
        let trace = run(&ball(alpha), 4.0, 1e-12);
        let first = (2.0 * DROP / GRAVITY).sqrt();
        let end = first * (1.0 + alpha) / (1.0 - alpha);
        let stuck = of_kind(&trace, EventKind::Stick);
        assert_eq!(stuck.len(), 1, "{alpha}: {stuck:?}");
        // What is left out is shorter than the time of hops of 5 pm.
        assert!(stuck[0].time <= end + 1e-9, "{alpha}: {stuck:?} {end}");
        assert!(end - stuck[0].time < 1e-4, "{alpha}: {stuck:?} {end}");
        assert!(of_kind(&trace, EventKind::Release).is_empty());
        assert!(trace.events.len() < 120, "{}", trace.events.len());
        let rests = |(i, x): (usize, &f64)| trace.time(i) < end || *x == LEVEL;
        assert!(trace.proof_mass.iter().enumerate().all(rests));
        let lowest = trace.proof_mass.iter().copied().fold(f64::MAX, f64::min);
        assert!(lowest > LEVEL - 1e-10, "{lowest}");
    }
}

#[test]
fn energy_is_kept_between_the_bounces_and_lost_at_them() {
    let alpha = 0.7;
    let trace = run(&ball(alpha), 1.3, 1e-12);
    let energy = |i: usize| {
        let v = trace.proof_mass_velocity[i];
        0.5 * v * v + GRAVITY * (trace.proof_mass[i] - LEVEL)
    };
    assert!(trace.len() > 1290);
    for i in 0..trace.len() {
        let done = arrivals(alpha).take_while(|(t, _)| *t < trace.time(i));
        let done = done.take(60).count() as i32;
        let expected = GRAVITY * DROP * alpha.powi(2 * done);
        assert!((energy(i) - expected).abs() < 1e-8 * GRAVITY * DROP, "{i}");
    }
}

#[test]
fn a_coarser_tolerance_ends_in_rest_earlier_and_at_the_same_bounces() {
    let alpha = 0.7;
    let end = (2.0 * DROP / GRAVITY).sqrt() * (1.0 + alpha) / (1.0 - alpha);
    let mut last = f64::INFINITY;
    for tolerance in [1e-4, 1e-6, 1e-8, 1e-10] {
        let trace = run(&ball(alpha), 2.0, tolerance);
        let bounces = of_kind(&trace, EventKind::Impact);
        for (event, (t, _)) in bounces.iter().zip(arrivals(alpha)) {
            assert!((event.time - t).abs() < 1e-7, "{tolerance}: {event:?} {t}");
        }
        let early = end - of_kind(&trace, EventKind::Stick)[0].time;
        // A hop of the height `tolerance` takes `2 sqrt(2 tolerance / g)`, all that follow together
        // `1 / (1 - alpha)` of that; the last one left out may be lower by `alpha^2`.
        let most = 2.0 * (2.0 * tolerance / GRAVITY).sqrt() / (1.0 - alpha);
        assert!(early < 1.01 * most + 1e-9, "{tolerance}: {early} {most}");
        assert!(
            early > 0.99 * alpha * most - 1e-9,
            "{tolerance}: {early} {most}"
        );
        assert!(early < last, "{tolerance}");
        last = early;
    }
}

#[test]
fn a_ball_that_loses_nothing_bounces_for_ever_and_one_that_loses_all_stays() {
    let trace = run(&ball(1.0), 10.0, 1e-12);
    let highest = trace.proof_mass[9000..].iter().copied().fold(0.0, f64::max);
    assert!((highest - 0.25).abs() < 1e-4, "{highest}");
    assert_eq!(of_kind(&trace, EventKind::Impact).len(), 20);
    let trace = run(&ball(0.0), 1.0, 1e-12);
    assert!(of_kind(&trace, EventKind::Impact).is_empty());
    assert_eq!(of_kind(&trace, EventKind::Stick).len(), 1);
}

#[test]
fn slow_arrivals_stick() {
    let alpha = 0.7;
    let count = |stick: StickSpeed, adhesion: f64| {
        let mut model = ball(alpha);
        model.bounce = BounceRule::Restitution(stick);
        model.parameters.set(ParameterId::Ca0, adhesion);
        let trace = run(&model, 3.0, 1e-12);
        assert_eq!(of_kind(&trace, EventKind::Stick).len(), 1);
        of_kind(&trace, EventKind::Impact).len()
    };
    let faster = |least: f64| arrivals(alpha).take_while(|(_, v)| *v > least).count();
    for speed in [0.3, 0.05] {
        assert_eq!(count(StickSpeed::Given(speed), 0.0), faster(speed));
    }
    // alpha v = sqrt(2 Ca0 h / m).
    let (adhesion, reach, mass) = (0.2, 1e-4, 0.005);
    let least = f64::sqrt(2.0 * adhesion * reach / mass) / alpha;
    assert_eq!(
        count(StickSpeed::AdhesionOver(reach), adhesion),
        faster(least)
    );
    // An adhesion without reach takes no energy.
    let all = count(StickSpeed::default(), 0.0);
    assert_eq!(count(StickSpeed::default(), adhesion), all);
    // By the paper's rule a pressed mass sticks at any speed.
    let mut pressed = ball(alpha);
    pressed.bounce = BounceRule::PullOff;
    assert!(of_kind(&run(&pressed, 1.0, 1e-12), EventKind::Impact).is_empty());
}

#[test]
fn a_ball_at_rest_is_thrown_off_by_a_ground_that_falls_faster() {
    // The base, with the ground, moves as a sinusoid of `a`; the ball leaves where it accelerates
    // downward by more than gravity, and adhesion holds it a little longer.
    let thrown = |a: f64, adhesion: f64| {
        let spec = effects::find("base_vibration").unwrap();
        let mut shaken = ActiveEffect::new(spec);
        assert!(shaken.set("a", a) && shaken.set("f", 5.0));
        let mut model = with_effect(&ball(0.5), shaken);
        model.set("x0", LEVEL + 1e-6).unwrap();
        model.parameters.set(ParameterId::Ca0, adhesion);
        let trace = run(&model, 1.0, 1e-12);
        of_kind(&trace, EventKind::Release)
    };
    assert!(thrown(0.9 * GRAVITY, 0.0).is_empty());
    assert!(thrown(1.5 * GRAVITY, 0.6 * 0.005 * GRAVITY).is_empty());
    let free = thrown(1.5 * GRAVITY, 0.0);
    assert!(!free.is_empty());
    for event in &free {
        // -a sin(2 pi f t) = g.
        let phase = std::f64::consts::TAU * 5.0 * event.time;
        assert!((-1.5 * phase.sin() - 1.0).abs() < 1e-6, "{event:?}");
    }
}
