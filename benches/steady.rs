//! What a steady state costs beside a plain long transient, on the grid of a map.
//!
//! `cargo bench --bench steady --no-default-features`. After criterion's own figures a table gives, for
//! each kind of drive over 5 to 100 Hz and 1 to 10 V, the processor time of a point, how much device
//! time it took, and the processor time of the plain transient.

use std::hint::black_box;
use std::time::Instant;

use criterion::Criterion;
use impactscope::explore::steady_state::{Start, SteadyOptions, SteadyResponse, SteadySolver};
use impactscope::model::Model;
use impactscope::model::drive::Waveform;
use impactscope::sim::{Options, simulate};

/// Points of the grid along each axis.
const GRID: usize = 24;
/// Periods of the plain transient, the last of which is looked at.
const TRANSIENT_PERIODS: f64 = 20.0;
/// Samples a second of it.
const TRANSIENT_RATE: f64 = 50e3;

fn drives(kind: &str) -> Vec<Waveform> {
    let along = |i: usize, from: f64, to: f64| from + (to - from) * i as f64 / (GRID - 1) as f64;
    let points =
        (0..GRID * GRID).map(|k| (along(k / GRID, 5.0, 100.0), along(k % GRID, 1.0, 10.0)));
    points
        .map(|(frequency, amplitude)| match kind {
            "sine" => Waveform::Sine {
                frequency,
                amplitude,
            },
            _ => Waveform::Square {
                frequency,
                amplitude,
            },
        })
        .collect()
}

/// Seconds of processor time of this thread where the system tells (Linux); else a clock.
fn clock(since: Instant) -> f64 {
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let own = stat
        .split_whitespace()
        .next()
        .and_then(|ns| ns.parse().ok());
    own.map_or_else(|| since.elapsed().as_secs_f64(), |ns: f64| ns * 1e-9)
}

fn responses(model: &Model, drives: &[Waveform], options: &SteadyOptions) -> Vec<SteadyResponse> {
    let mut solver = SteadySolver::new(model, options.clone()).unwrap();
    let all = drives.iter();
    all.map(|drive| solver.solve(drive, Start::Rest).unwrap())
        .collect()
}

/// Peak-to-peak displacement over the last period of a plain transient.
fn transient(model: &Model, drive: &Waveform) -> f64 {
    let period = drive.period().unwrap();
    let options = Options {
        rate: TRANSIENT_RATE,
        ..Options::default()
    };
    let trace = simulate(model, drive, TRANSIENT_PERIODS * period, &options).unwrap();
    let last = (period * TRANSIENT_RATE).round() as usize;
    let own = &trace.proof_mass[trace.len() - last.min(trace.len())..];
    let high = own.iter().fold(f64::NEG_INFINITY, |a, x| a.max(*x));
    high - own.iter().fold(f64::INFINITY, |a, x| a.min(*x))
}

fn main() {
    let mut criterion = Criterion::default()
        .without_plots() // they need a font, which a server may lack
        .configure_from_args();
    let model = Model::default();
    let drive = Waveform::Square {
        frequency: 50.0,
        amplitude: 7.0,
    };
    let mut group = criterion.benchmark_group("50 Hz square, 7 V");
    let options = [
        ("steady state of a map", SteadyOptions::for_maps(&model)),
        ("steady state with multipliers", SteadyOptions::default()),
    ];
    for (name, options) in &options {
        let mut solver = SteadySolver::new(&model, options.clone()).unwrap();
        group.bench_function(*name, |b| {
            b.iter(|| solver.solve(&drive, Start::Rest).unwrap());
        });
    }
    group.bench_function("plain transient of 20 periods", |b| {
        b.iter(|| transient(&model, &drive));
    });
    group.finish();
    criterion.final_summary();
    let since = Instant::now();
    for kind in ["square", "sine"] {
        let drives = drives(kind);
        let start = clock(since);
        let found = responses(&model, &drives, &options[0].1);
        let steady = clock(since) - start;
        let start = clock(since);
        let plain: Vec<f64> = drives.iter().map(|d| transient(&model, d)).collect();
        let long = clock(since) - start;
        black_box(&plain);
        let count = drives.len() as f64;
        let device: f64 = found.iter().map(|r| r.device_seconds).sum();
        let periodic = found.iter().filter(|r| r.multiple().is_some()).count();
        println!(
            "{kind}, {GRID} x {GRID}: {:.3} ms and {:.3} s of device time a point, {periodic} periodic; plain transient {:.3} ms a point, {:.1} times as long",
            1e3 * steady / count,
            device / count,
            1e3 * long / count,
            long / steady,
        );
    }
}
