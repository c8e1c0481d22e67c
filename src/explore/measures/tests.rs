use super::*;
use crate::explore::steady_state::{Start, SteadyOptions, SteadyResponse, SteadySolver};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::model::effects::{ActiveEffect, CATALOGUE};
use crate::model::parameter::ParameterId as P;
use crate::model::preset::Preset;
use crate::model::with_effect;
use crate::sim::{EventKind, Options, simulate};

fn solved(model: &Model, drive: &str) -> (SteadySolver, Waveform, SteadyResponse) {
    let drive = Waveform::parse(drive, 1.0).unwrap();
    let mut solver = SteadySolver::new(model, SteadyOptions::default()).unwrap();
    let response = solver.solve(&drive, Start::Rest).unwrap();
    (solver, drive, response)
}

const DRIVES: [&str; 8] = [
    "square:5Hz:8V",
    "square:50Hz:7V",
    "square:100Hz:9V",
    "sine:20Hz:8V",
    "sine:60Hz:2V",
    "sine:90Hz:9V",
    "triangle:35Hz:7V",
    "ramped:50Hz:8V:0.2",
];

#[test]
fn the_table_is_in_order_and_its_ids_are_unique() {
    for row in &MEASURES {
        assert_eq!(row.measure.spec(), row);
        assert_eq!(MeasureId::from_id(row.id), Some(row.measure));
        assert!(!row.meaning.is_empty() && !row.name.is_empty());
    }
    assert_eq!(MeasureId::from_id("none"), None);
    for code in 0..30 {
        if let Some(regime) = Regime::from_code(code) {
            assert_eq!(regime.code(), code, "{regime:?}");
        }
    }
    assert_eq!(
        Regime::from_code(Regime::NotPeriodic.code()),
        Some(Regime::NotPeriodic)
    );
    assert_eq!(Regime::from_code(Regime::NotPeriodic.code() + 1), None);
}

/// In a steady state the drive works as much as is lost: four integrals and the events' jumps, none of
/// which is computed from the others.
#[test]
fn the_energy_balance_closes() {
    let mut worst = 0.0f64;
    for name in ["paper", "paper-as-printed"] {
        let model = Preset::embedded(name).unwrap().model;
        for drive in DRIVES {
            let (mut solver, drive, response) = solved(&model, drive);
            let integrals = solver.integrals(&drive, &response).unwrap();
            let balance = EnergyBalance::of(&response, &integrals);
            assert!(balance.structure > 0.0 && balance.film > 0.0 && balance.impacts >= 0.0);
            assert!(
                balance.imbalance().abs() < 3e-5,
                "{name} {drive:?}: {balance:?}"
            );
            worst = worst.max(balance.imbalance().abs());
        }
    }
    println!("worst imbalance {worst:e}");
}

/// With effects, too: friction, a compliant ground, quadratic drag, gravity.
#[test]
fn the_energy_balance_closes_with_effects() {
    let paper = Preset::default().model;
    for id in [
        "dry_friction",
        "compliant_ground",
        "quadratic_drag",
        "gravity",
        "cubic_stiffness",
    ] {
        let spec = CATALOGUE.iter().find(|spec| spec.id == id).unwrap();
        let model = with_effect(&paper, ActiveEffect::new(spec));
        let (mut solver, drive, response) = solved(&model, "sine:50Hz:8V");
        let integrals = solver.integrals(&drive, &response).unwrap();
        let balance = EnergyBalance::of(&response, &integrals);
        assert!(balance.imbalance().abs() < 1e-4, "{id}: {balance:?}");
    }
}

/// The ground holds a ball's weight, whatever it does: the mean of its force is `m g`.
#[test]
fn the_mean_ground_force_of_a_ball_is_its_weight() {
    let mut model = Preset::embedded("bouncing-ball").unwrap().model;
    model.parameters.set(P::Alpha, 0.5);
    let spec = CATALOGUE
        .iter()
        .find(|spec| spec.id == "base_vibration")
        .unwrap();
    let mut shaken = ActiveEffect::new(spec);
    assert!(shaken.set("a", 13.0) && shaken.set("f", 20.0));
    let model = with_effect(&model, shaken);
    let (mut solver, drive, response) = solved(&model, "sine:20Hz:1V");
    assert!(response.multiple().is_some(), "{:?}", response.kind);
    let own = measure(
        &mut solver,
        &drive,
        &response,
        &[MeasureId::MeanGroundForce],
    )
    .unwrap();
    let weight = 0.005 * 9.80665;
    assert!(
        (own[0].unwrap() / weight - 1.0).abs() < 1e-5,
        "{own:?} {weight}"
    );
}

/// Contact shares, bounces and pull-off forces against the sampled simulator's own contacts.
#[test]
fn contacts_are_those_of_a_long_run() {
    let model = Preset::default().model;
    for text in DRIVES {
        let (_, drive, response) = solved(&model, text);
        let cycle = &response.cycle;
        let end = 60.0 * response.period;
        let trace = simulate(&model, &drive, end, &Options::default()).unwrap();
        let start = end - cycle.duration;
        let within = trace
            .contacts
            .iter()
            .map(|(a, b)| b.min(end) - a.max(start));
        let contact: f64 = within.filter(|d| *d > 0.0).sum();
        let own = value(MeasureId::ContactShare, &response, None).unwrap();
        assert!(
            (own - contact / cycle.duration).abs() < 1e-5,
            "{text}: {own}"
        );
        let events = || trace.events.iter().filter(|e| e.time > start);
        let bounces = events().filter(|e| e.kind == EventKind::Impact).count();
        let own = value(MeasureId::Bounces, &response, None).unwrap();
        assert!(
            (own - bounces as f64 / cycle.periods as f64).abs() < 1e-12,
            "{text}: {own}"
        );
        let pulls = events().filter(|e| e.kind == EventKind::Release);
        let pull = pulls.map(|e| e.pull_off_force).fold(f64::NAN, f64::max);
        match value(MeasureId::PullOffForce, &response, None) {
            Some(own) => assert!((own / pull - 1.0).abs() < 1e-4, "{text}: {own} {pull}"),
            None => assert!(pull.is_nan(), "{text}"),
        }
    }
}

#[test]
fn regimes_are_told_apart() {
    let paper = Preset::default().model;
    let regime = |model: &Model, drive: &str| Regime::of(&solved(model, drive).2);
    assert_eq!(regime(&paper, "sine:20Hz:0.5V"), Regime::NoContact);
    let mut sticky = paper.clone();
    sticky.parameters.set(P::Ca0, 1e-5);
    assert_eq!(regime(&sticky, "square:20Hz:8V"), Regime::NeverLetsGo);
    let mut model = paper.clone();
    model.parameters.set(P::Alpha, 0.0);
    assert_eq!(regime(&model, "sine:20Hz:8V"), Regime::Sticks);
    assert!(matches!(
        regime(&paper, "square:5Hz:9V"),
        Regime::BouncesThenSticks
    ));
}

/// The margin is zero at the change of regime, and tells which.
#[test]
fn the_margin_vanishes_where_the_events_change() {
    let model = Preset::default().model;
    let mut solver = SteadySolver::new(&model, SteadyOptions::default()).unwrap();
    let mut at = |amplitude: f64| {
        let drive = Waveform::Sine {
            frequency: 50.0,
            amplitude,
        };
        solver.solve(&drive, Start::Rest).unwrap()
    };
    let (mut low, mut high) = (1.0, 6.0);
    while high - low > 1e-6 * high {
        let middle = 0.5 * (low + high);
        if at(middle).cycle.arrivals.is_empty() {
            low = middle;
        } else {
            high = middle;
        }
    }
    let below = Margin::of(&at(low));
    assert!(below.distance < 0.01, "{below:?}");
    assert_eq!(below.kind, MarginKind::NewArrival);
    let far = Margin::of(&at(0.7 * low));
    assert!(far.distance > 50.0 * below.distance, "{far:?} {below:?}");
}
