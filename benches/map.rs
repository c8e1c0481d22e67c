//! What a map costs: 200 x 200 steady states, its first picture, and what refinement saves.
//!
//! `cargo bench --bench map --no-default-features`. For preset `paper` at 5 to 100 Hz and 2 to 9 V: time
//! until the coarse picture, until the regimes' boundaries are sharp, and until each point is solved,
//! beside plain transients of as many periods as make the same accuracy safe. Criterion's own figures
//! are for one map of 25 x 25.

use std::sync::Mutex;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use criterion::Criterion;
use impactscope::explore::map::{Axis, MapRequest, Pass, PointState, Refinement, compute};
use impactscope::explore::measures::MeasureId;
use impactscope::model::Model;
use impactscope::model::drive::Waveform;
use impactscope::sim::{Options, simulate};

/// Points of the full map along each axis.
const FULL: usize = 200;
/// Points of the coarse one.
const COARSE: usize = 25;
/// Periods of a plain transient.
const TRANSIENT_PERIODS: f64 = 20.0;
/// Each so many points of the full map a plain transient is timed.
const TRANSIENT_STRIDE: usize = 100;

fn request(kind: &str, points: usize) -> MapRequest {
    let model = Model::default();
    let drive = Waveform::parse(&format!("{kind}:50Hz:7V"), 0.02).unwrap();
    let axes = [("f", 5.0, 100.0), ("V", 2.0, 9.0)]
        .map(|(id, from, to)| Axis::new(id, (&model, &drive), (from, to), points).unwrap());
    let measures = [
        MeasureId::Regime,
        MeasureId::ContactShare,
        MeasureId::Peak,
        MeasureId::FirstImpactSpeed,
    ];
    MapRequest::new(model, drive, axes.to_vec(), measures.to_vec())
}

fn timed(kind: &str) {
    let mut request = request(kind, FULL);
    let never = AtomicBool::new(false);
    let start = Instant::now();
    let (coarse, sharp) = (Mutex::new(0.0), Mutex::new(0.0));
    let map = compute(&request, &never, &|update| {
        let now = start.elapsed().as_secs_f64();
        match update.pass {
            Pass::Coarse => *coarse.lock().unwrap() = now,
            Pass::Boundary { .. } => *sharp.lock().unwrap() = now,
            Pass::Rest => {}
        }
    });
    let (map, all) = (map.unwrap(), start.elapsed().as_secs_f64());
    request.refinement = Refinement::WhereRegimeChanges;
    let start = Instant::now();
    let refined = compute(&request, &never, &|_| {}).unwrap();
    let alone = start.elapsed().as_secs_f64();
    let pairs = map.values[0].iter().zip(&refined.values[0]);
    let wrong = pairs.filter(|(a, b)| a != b).count();
    let solved = refined.count(PointState::Solved);
    println!(
        "{kind}, {FULL} x {FULL}: coarse picture {:.2} s, boundaries sharp {:.2} s, all {all:.2} s; refinement alone {alone:.2} s for {solved} points, {wrong} of {} filled with another regime; {} holes",
        coarse.into_inner().unwrap(),
        sharp.into_inner().unwrap(),
        FULL * FULL,
        map.holes.len(),
    );
    let options = Options::default();
    let start = Instant::now();
    let indices = (0..FULL * FULL).step_by(TRANSIENT_STRIDE);
    let count = indices.clone().count();
    for index in indices {
        let (model, drive) = request.setting(index).unwrap();
        let span = TRANSIENT_PERIODS * drive.period().unwrap();
        std::hint::black_box(simulate(&model, &drive, span, &options).unwrap());
    }
    let each = start.elapsed().as_secs_f64() / count as f64;
    println!(
        "{kind}: a plain transient of {TRANSIENT_PERIODS} periods {:.2} ms on one core; a map of them {:.0} s on {} cores",
        1e3 * each,
        each * (FULL * FULL) as f64 / rayon::current_num_threads() as f64,
        rayon::current_num_threads(),
    );
}

fn main() {
    let mut criterion = Criterion::default()
        .without_plots() // they need a font, which a server may lack
        .sample_size(10)
        .configure_from_args();
    let small = request("square", COARSE);
    let never = AtomicBool::new(false);
    criterion.bench_function("map of 25 x 25 points", |b| {
        b.iter(|| compute(&small, &never, &|_| {}).unwrap());
    });
    criterion.final_summary();
    for kind in ["square", "sine"] {
        timed(kind);
    }
}
