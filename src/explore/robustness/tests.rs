use std::sync::atomic::{AtomicBool, Ordering};

use super::super::robustness::*;
use crate::explore::map::{Axis, MapRequest};
use crate::explore::measures::{MeasureId, Regime};
use crate::explore::test_support::{amplitude, linear};
use crate::explore::waveform::DriveLimits;
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::model::preset::Preset;

static NEVER: AtomicBool = AtomicBool::new(false);

fn ensemble(ranges: Vec<CoefficientRange>, members: usize) -> Ensemble {
    Ensemble {
        spread: Spread::Ranges(ranges),
        members,
        seed: 5,
    }
}

fn peak_within(low: Option<f64>, high: Option<f64>) -> Wish {
    let measure = MeasureId::Peak;
    Wish {
        regimes: Vec::new(),
        bounds: vec![MeasureBound { measure, low, high }],
    }
}

#[test]
fn ranges_are_filled_evenly_and_normal_spreads_have_their_moments() {
    let n = 64;
    let ranges = vec![
        CoefficientRange::relative("Cs", 0.5, 2.0),
        CoefficientRange {
            id: "gp".into(),
            low: 60e-6,
            high: 80e-6,
            is_relative: false,
            is_logarithmic: false,
        },
    ];
    let own = ensemble(ranges, n);
    own.check(&Model::default()).unwrap();
    let members = own.draw().unwrap();
    let mut parts: Vec<usize> = members
        .iter()
        .map(|member| match member.changes[0] {
            Change::Factor(factor) => ((factor / 0.5).ln() / 4f64.ln() * n as f64) as usize,
            Change::Value(_) => panic!(),
        })
        .collect();
    parts.sort_unstable();
    assert_eq!(parts, (0..n).collect::<Vec<_>>());
    assert_eq!(own.draw().unwrap(), members);
    let base = Model::default();
    let device = own.device(&base, &members[3]).unwrap();
    assert!(device.get("Cs").unwrap() != base.get("Cs").unwrap());

    let n = 20_000;
    let normal = Ensemble {
        spread: Spread::Normal(NormalSpread {
            ids: vec!["Cs".into(), "gp".into()],
            means: vec![2e-21, 70e-6],
            std_errors: vec![1e-22, 1e-6],
            correlation: vec![vec![1.0, -0.8], vec![-0.8, 1.0]],
        }),
        members: n,
        seed: 9,
    };
    let members = normal.draw().unwrap();
    let mean = |f: &dyn Fn(&Member) -> f64| members.iter().map(f).sum::<f64>() / n as f64;
    let error = 4.0 / (n as f64).sqrt();
    assert!(mean(&|m| m.deviations[0]).abs() < error);
    assert!((mean(&|m| m.deviations[1].powi(2)) - 1.0).abs() < 2.0 * error);
    assert!((mean(&|m| m.deviations[0] * m.deviations[1]) + 0.8).abs() < 2.0 * error);
    for member in &members[..10] {
        let Change::Value(value) = member.changes[1] else {
            panic!()
        };
        assert!((value - (70e-6 + 1e-6 * member.deviations[1])).abs() < 1e-18);
    }
}

#[test]
fn impossible_ensembles_and_wishes_are_refused_in_words() {
    let model = Model::default();
    let said = |ranges, members| {
        ensemble(ranges, members)
            .check(&model)
            .unwrap_err()
            .to_string()
    };
    let half = || CoefficientRange::relative("Cs", 0.5, 2.0);
    assert!(said(vec![], 9).contains("no coefficient"));
    assert!(said(vec![half()], 1).contains("1 members"));
    assert!(said(vec![half(), half()], 9).contains("twice"));
    assert!(said(vec![CoefficientRange::relative("Cs", 2.0, 0.5)], 9).contains("empty"));
    assert!(said(vec![CoefficientRange::relative("Cs", 0.0, 0.5)], 9).contains("above 0"));
    assert!(said(vec![CoefficientRange::relative("magic", 0.5, 2.0)], 9).contains("zeta1"));
    let correlation = vec![vec![1.0, 1.2], vec![1.2, 1.0]];
    let wrong = Ensemble {
        spread: Spread::Normal(NormalSpread {
            ids: vec!["Cs".into(), "gp".into()],
            means: vec![2e-21, 70e-6],
            std_errors: vec![1e-22, 1e-6],
            correlation,
        }),
        members: 9,
        seed: 0,
    };
    assert!(
        wrong
            .check(&model)
            .unwrap_err()
            .to_string()
            .contains("impossible")
    );
    assert!(Wish::default().check().is_err());
    assert!(peak_within(Some(2.0), Some(1.0)).check().is_err());
    assert!(peak_within(None, None).check().is_err());
}

/// A linear device answers in proportion to `eta`, so probability and quantiles are known.
#[test]
fn probabilities_and_quantiles_of_a_linear_device() {
    let model = linear(0.1);
    let drive = Waveform::parse("sine:1Hz:1V", 1.0).unwrap();
    let ranges = vec![
        CoefficientRange::relative("eta", 0.5, 2.0),
        // It does next to nothing here.
        CoefficientRange::relative("zeta1", 0.99, 1.01),
    ];
    let peak = 2.0 * amplitude(&model, 1.0, 1.0);
    let axis = Axis::new("V", (&model, &drive), (1.0, 2.0), 2).unwrap();
    let request = RobustnessRequest {
        map: MapRequest::new(model, drive, vec![axis], vec![MeasureId::Peak]),
        ensemble: ensemble(ranges, 200),
        wish: peak_within(None, Some(2f64.sqrt() * peak)),
    };
    let map = compute(&request, &NEVER, &|_| {}).unwrap();
    let own = |k: usize| map.points[k].clone().unwrap().unwrap();
    // log(eta) is even over two octaves; the limit is half an octave up, or half an octave down.
    for (k, exact) in [(0, 0.75), (1, 0.25)] {
        let own = own(k);
        assert!((own.probability - exact).abs() <= 0.011, "{k}: {own:?}");
        let breaker = own.breaker.unwrap();
        assert_eq!(breaker.id, "eta");
        assert!(breaker.difference > 1.0, "{breaker:?}");
        let quantiles = own.quantiles[0];
        for (found, at) in [
            (quantiles.low, 0.05),
            (quantiles.median, 0.5),
            (quantiles.high, 0.95),
        ] {
            let exact = peak * (k + 1) as f64 * 0.5 * 4f64.powf(at);
            assert!((found / exact - 1.0).abs() < 0.02, "{at}: {found} {exact}");
        }
    }
    let alone = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    assert_eq!(
        alone.install(|| compute(&request, &NEVER, &|_| {}).unwrap()),
        map
    );
    let part = compute_points(&request, &[1], &NEVER, &|_| {}).unwrap();
    assert_eq!(part[0].1, map.points[1].clone().unwrap());
}

#[test]
fn members_that_fail_are_counted_with_their_reason() {
    let (model, drive) = (
        Model::default(),
        Waveform::parse("square:50Hz:7V", 0.02).unwrap(),
    );
    let ranges = vec![CoefficientRange {
        id: "gp".into(),
        low: 48e-6,
        high: 68e-6,
        is_relative: false,
        is_logarithmic: false,
    }];
    let axis = Axis::new("V", (&model, &drive), (6.0, 7.0), 2).unwrap();
    let mut request = RobustnessRequest {
        map: MapRequest::new(model, drive, vec![axis], vec![MeasureId::ContactShare]),
        ensemble: ensemble(ranges, 8),
        wish: Wish::in_contact(0.0, 1.0),
    };
    let map = compute(&request, &NEVER, &|_| {}).unwrap();
    let own = map.points[0].clone().unwrap().unwrap();
    assert_eq!((own.failed, own.probability), (4, 0.5));
    assert!(own.first_failure.unwrap().contains("must exceed dp"));
    assert!(own.breaker.unwrap().difference < 0.0);
    let Spread::Ranges(ranges) = &mut request.ensemble.spread else {
        panic!()
    };
    ranges[0].high = 57e-6;
    let map = compute(&request, &NEVER, &|_| {}).unwrap();
    let reason = map.points[1].clone().unwrap().unwrap_err();
    assert!(reason.contains("each member is impossible"), "{reason}");
}

/// The peak must stay within two octaves and `eta` varies over two: one amplitude keeps all, in
/// the geometric middle.
#[test]
fn the_search_finds_the_middle_of_what_is_wanted() {
    let model = linear(0.1);
    let drive = Waveform::parse("sine:1Hz:1V", 1.0).unwrap();
    let peak = 2.0 * amplitude(&model, 1.0, 1.0);
    let wish = peak_within(Some(1.9 * peak), Some(8.4 * peak));
    let numbers = vec![SearchedNumber {
        id: "amplitude".into(),
        low: 0.5,
        high: 20.0,
    }];
    let own = ensemble(vec![CoefficientRange::relative("eta", 0.5, 2.0)], 16);
    let mut search = WaveformSearch::new((model, drive), numbers, wish, own);
    search.population = 8;
    search.generations = 8;
    let result = find_robust_waveform(&search, &NEVER, &|_| {}).unwrap();
    let best = &result.best[0];
    assert!((best.values[0] / 4.0).ln().abs() < 0.2, "{best:?}");
    assert!(best.fresh.probability > 0.95, "{best:?}");
    // A number that a person could have typed: a whole number of hundredths.
    let hundredths = 100.0 * best.values[0];
    assert!((hundredths - hundredths.round()).abs() < 1e-9, "{best:?}");
    let start = result.start.as_ref().unwrap().probability;
    assert!((best.gain - (best.fresh.probability - start)).abs() < 1e-12 && best.gain > 0.5);
    assert!(best.why.contains("fresh devices"), "{}", best.why);
    let alone = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    let again = alone.install(|| find_robust_waveform(&search, &NEVER, &|_| {}).unwrap());
    assert_eq!(again, result);
    // A limit below what is best is kept.
    search.limits = DriveLimits {
        voltage: Some(2.5),
        slew: None,
    };
    let limited = find_robust_waveform(&search, &NEVER, &|_| {}).unwrap();
    assert!(
        limited.best.iter().all(|own| own.values[0] <= 2.5),
        "{limited:?}"
    );
    assert!(limited.best[0].fresh.probability < best.fresh.probability);
    let cancel = AtomicBool::new(false);
    let cancelled = find_robust_waveform(&search, &cancel, &|progress| {
        cancel.store(progress.generation == 2, Ordering::Relaxed);
    });
    let cancelled = cancelled.unwrap();
    assert!(cancelled.is_cancelled && cancelled.tried == 16 && !cancelled.best.is_empty());
    search.numbers[0].id = "h1".into();
    assert!(
        search
            .check()
            .unwrap_err()
            .to_string()
            .contains("it has frequency, amplitude")
    );
}

#[test]
fn a_device_is_evaluated_alone_as_in_a_map() {
    let model = Preset::default().model;
    let drive = Waveform::parse("square:50Hz:7V", 0.02).unwrap();
    let axis = Axis::new("V", (&model, &drive), (7.0, 8.0), 2).unwrap();
    let request = RobustnessRequest {
        map: MapRequest::new(
            model.clone(),
            drive.clone(),
            vec![axis],
            vec![MeasureId::ContactShare],
        ),
        ensemble: ensemble(vec![CoefficientRange::relative("Ca0", 0.5, 2.0)], 6),
        wish: Wish::regime(Regime::Sticks),
    };
    let map = compute(&request, &NEVER, &|_| {}).unwrap();
    let case = (&model, &drive);
    let alone = evaluate(
        &request.map,
        case,
        &request.ensemble,
        &request.wish,
        &|| true,
    );
    assert_eq!(alone.unwrap(), map.points[0].clone().unwrap().ok());
}
