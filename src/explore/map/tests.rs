use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use super::super::map::*;
use super::lattice::around;
use crate::explore::measures::{MeasureId, Regime};
use crate::explore::steady_state::SteadyOptions;
use crate::explore::test_support::{amplitude, linear};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::model::preset::Preset;
use crate::sim::{Event, EventKind, Options, simulate};

static NEVER: AtomicBool = AtomicBool::new(false);

fn square() -> Waveform {
    Waveform::parse("square:50Hz:7V", 0.02).unwrap()
}

fn request(axes: &[(&str, f64, f64, usize)], measures: &[MeasureId]) -> MapRequest {
    request_for(Model::default(), square(), axes, measures)
}

fn request_for(
    model: Model,
    drive: Waveform,
    axes: &[(&str, f64, f64, usize)],
    measures: &[MeasureId],
) -> MapRequest {
    let axes = axes
        .iter()
        .map(|&(id, from, to, count)| Axis::new(id, (&model, &drive), (from, to), count).unwrap());
    let axes = axes.collect();
    MapRequest::new(model, drive, axes, measures.to_vec())
}

fn bits(map: &MapResult) -> Vec<Vec<u64>> {
    let all = map.values.iter();
    all.map(|own| own.iter().map(|v| v.to_bits()).collect())
        .collect()
}

#[test]
fn points_agree_with_long_transients() {
    let model = Model::default();
    let request = request(
        &[("f", 20.0, 95.0, 4), ("V", 2.0, 8.5, 4)],
        &[MeasureId::Peak],
    );
    let map = compute(&request, &NEVER, &|_| {}).unwrap();
    for index in 0..request.points() {
        let (_, drive) = request.setting(index).unwrap();
        let period = drive.period().unwrap();
        let options = Options::default();
        let trace = simulate(&model, &drive, 40.0 * period, &options).unwrap();
        let last = (period * options.rate).round() as usize;
        let own = &trace.proof_mass[trace.len() - last..];
        let high = own.iter().fold(f64::NEG_INFINITY, |a, x| a.max(*x));
        // Samples miss the instant of an impact.
        let since = 39.0 * period;
        let touches = |e: &Event| e.kind != EventKind::DriveStep && e.time > since;
        let ground = trace.events.iter().any(touches).then_some(-58e-6);
        let low = own
            .iter()
            .copied()
            .chain(ground)
            .fold(f64::INFINITY, f64::min);
        let peak = high - low;
        let (_, _, response) = solve_point(&request, index, &NEVER).unwrap();
        // Samples miss a turn by half of w^2 x dt^2, dt = 10 us; other periods of the response differ.
        if response.multiple() == Some(1) {
            let error = (map.values[0][index] - peak).abs() / peak;
            assert!(error < 1e-3, "{:?}: {error}", request.values_at(index));
        }
    }
}

#[test]
fn a_linear_device_has_the_closed_form() {
    let model = linear(0.05);
    let drive = Waveform::parse("sine:1Hz:2V", 1.0).unwrap();
    let axes = [("zeta1", 0.05, 0.4, 4), ("f", 0.5, 3.0, 5)];
    let request = request_for(model, drive, &axes, &[MeasureId::Peak]);
    let map = compute(&request, &NEVER, &|_| {}).unwrap();
    assert!(map.holes.is_empty(), "{:?}", map.holes);
    for (index, peak) in map.values[0].iter().enumerate() {
        let (model, _) = request.setting(index).unwrap();
        let exact = 2.0 * amplitude(&model, request.values_at(index)[1], 2.0);
        let error = (peak / exact - 1.0).abs();
        assert!(error < 1e-4, "{:?}: {error}", request.values_at(index));
    }
}

#[test]
fn the_same_bits_whatever_the_threads_the_order_and_the_parts() {
    let measures = [
        MeasureId::Regime,
        MeasureId::ContactShare,
        MeasureId::DriveWork,
    ];
    let request = request(&[("Cs", 1e-22, 4e-21, 9), ("V", 2.0, 9.0, 11)], &measures);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build()
            .unwrap()
            .install(|| compute(&request, &NEVER, &|_| {}).unwrap())
    };
    let (one, four) = (with(1), with(4));
    assert_eq!(bits(&one), bits(&four));
    assert_eq!(one.count(PointState::Solved), 99);
    // Backwards, every third, as a shard would.
    let own: Vec<usize> = (0..99).rev().filter(|k| k % 3 == 1).collect();
    let part = compute_points(&request, &own, &NEVER, &|_| {}).unwrap();
    for (index, point) in own.iter().zip(&part) {
        assert_eq!(point.index, *index);
        for (all, value) in one.values.iter().zip(point.values.as_ref().unwrap()) {
            assert_eq!(all[*index].to_bits(), value.to_bits());
        }
    }
}

#[test]
fn refinement_finds_the_regimes_with_fewer_points() {
    let mut request = request(
        &[("f", 5.0, 100.0, 60), ("V", 2.0, 9.0, 60)],
        &[MeasureId::Regime],
    );
    request.options = SteadyOptions {
        max_periods: 60,
        ..request.options
    };
    let all = compute(&request, &NEVER, &|_| {}).unwrap();
    request.refinement = Refinement::WhereRegimeChanges;
    let received = Mutex::new(MapResult::pending(&request));
    let fewer = compute(&request, &NEVER, &|update| {
        received.lock().unwrap().apply(&update)
    })
    .unwrap();
    assert!(fewer.is_complete());
    assert_eq!(bits(&fewer), bits(&received.into_inner().unwrap()));
    let solved = fewer.count(PointState::Solved);
    assert!(solved < 3600, "{solved}");
    let (exact, found) = (&all.values[0], &fewer.values[0]);
    let is_wrong = |k: usize| exact[k] != found[k];
    // A region of one regime of which any point is known is known as a whole: only islands between
    // the points of the coarse lattice are missed.
    for k in (0..3600).filter(|k| is_wrong(*k)) {
        assert_eq!(fewer.states[k], PointState::Filled);
        for (i, j) in around(request.place(k), request.shape()) {
            let near = i + j * 60;
            assert!(exact[near] != exact[k] || is_wrong(near), "{k} {near}");
        }
    }
    println!(
        "{solved} of 3600 solved, {} filled wrongly",
        (0..3600).filter(|k| is_wrong(*k)).count()
    );
}

#[test]
fn holes_have_reasons() {
    // gp must exceed dp = 58 um.
    let map = request(
        &[("gp", 50e-6, 70e-6, 5), ("V", 2.0, 8.0, 3)],
        &[MeasureId::Regime],
    );
    let map = compute(&map, &NEVER, &|_| {}).unwrap();
    assert_eq!((map.count(PointState::Hole), map.holes.len()), (6, 6));
    assert!(
        map.holes
            .values()
            .all(|reason| reason.contains("must exceed dp"))
    );
    assert!(map.holes.keys().all(|index| index % 5 < 2));
    assert!(map.values[0][4].is_finite() && map.values[0][0].is_nan());
    // The drive refuses, too.
    let drive = Waveform::parse("ramped:50Hz:7V:0.1", 0.02).unwrap();
    let map = request_for(
        Model::default(),
        drive,
        &[("lambda", 0.1, 0.9, 3)],
        &[MeasureId::Peak],
    );
    let map = compute(&map, &NEVER, &|_| {}).unwrap();
    assert_eq!(map.states[0], PointState::Solved);
    assert_eq!(map.states[2], PointState::Hole);
    assert!(map.holes[&2].contains("lambda"), "{:?}", map.holes);
    // No point is followed for ever.
    let slow = request(&[("f", 1e-4, 100.0, 2)], &[MeasureId::Peak]);
    let map = compute(&slow, &NEVER, &|_| {}).unwrap();
    assert!(map.holes[&0].contains("longer than"), "{:?}", map.holes);
    assert_eq!(map.states[1], PointState::Solved);
}

#[test]
fn cancelling_keeps_what_is_solved() {
    let request = request(
        &[("f", 5.0, 100.0, 80), ("V", 2.0, 9.0, 80)],
        &[MeasureId::Regime],
    );
    let (cancel, updates) = (AtomicBool::new(false), AtomicUsize::new(0));
    let map = compute(&request, &cancel, &|update| {
        assert!(update.solved <= update.total);
        if updates.fetch_add(1, Ordering::Relaxed) == 3 {
            cancel.store(true, Ordering::Relaxed);
        }
    });
    let map = map.unwrap();
    assert!(!map.is_complete());
    let solved = map.count(PointState::Solved);
    assert!(solved > 0 && solved < 1000, "{solved}");
    assert!(solve_point(&request, 7, &AtomicBool::new(true)) == Err(PointFault::Cancelled));
}

#[test]
fn wrong_requests_are_refused_in_words() {
    let (model, drive) = (Model::default(), square());
    let said = |id: &str, range, count| {
        let made = Axis::new(id, (&model, &drive), range, count);
        made.unwrap_err().to_string()
    };
    assert!(said("f", (5.0, 5.0), 9).contains("the range is empty"));
    assert!(said("f", (5.0, 9.0), 1).contains("1 point is no axis"));
    assert!(said("f", (f64::NAN, 9.0), 4).contains("no range"));
    let unknown = said("Css", (1.0, 2.0), 4);
    assert!(
        unknown.contains("duty") && unknown.contains("zeta1"),
        "{unknown}"
    );
    let mut log = Axis::new("offset", (&model, &drive), (-1.0, 2.0), 4).unwrap();
    log.is_logarithmic = true;
    assert!(log.check().unwrap_err().to_string().contains("above 0"));
    let huge = request(
        &[("f", 5.0, 100.0, 100_000), ("V", 2.0, 9.0, 100_000)],
        &[MeasureId::Peak],
    );
    let text = huge.check().unwrap_err().to_string();
    assert!(text.contains("10000000000 points"), "{text}");
    let twice = request(
        &[("V", 5.0, 6.0, 3), ("V", 2.0, 9.0, 3)],
        &[MeasureId::Peak],
    );
    assert!(
        twice
            .check()
            .unwrap_err()
            .to_string()
            .contains("both axes are amplitude")
    );
    let mut none = request(&[("V", 5.0, 6.0, 3)], &[]);
    assert!(none.check().unwrap_err().to_string().contains("no measure"));
    none.axes.clear();
    assert!(none.check().unwrap_err().to_string().contains("no axis"));
    let air = Preset::embedded("oscillator").unwrap().model;
    let air = request_for(
        air,
        square(),
        &[("f", 1.0, 2.0, 3)],
        &[MeasureId::Regime, MeasureId::Peak],
    );
    let text = air.check().unwrap_err().to_string();
    assert!(
        text.contains("has no ground") && text.contains("regime cannot"),
        "{text}"
    );
}

#[test]
fn axes_meet_their_ends_and_find_their_places() {
    let (model, drive) = (Model::default(), square());
    let mut axis = Axis::new("Cs", (&model, &drive), (1e-22, 1e-20), 21).unwrap();
    for is_logarithmic in [false, true] {
        axis.is_logarithmic = is_logarithmic;
        assert_eq!((axis.value(0), axis.value(20)), (1e-22, 1e-20));
        for k in 0..21 {
            assert!((axis.position(axis.value(k)) - k as f64).abs() < 1e-9);
        }
    }
    assert!((axis.value(10) / 1e-21 - 1.0).abs() < 1e-12);
    assert_eq!(
        Axis::new("f", (&model, &drive), (5.0, 9.0), 3).unwrap().id,
        "frequency"
    );
    assert_eq!(Regime::from_code(0), Some(Regime::NoContact));
}
