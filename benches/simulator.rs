//! What a run costs, compared with `diffsol` on the same problem at a similar error.
//!
//! `cargo bench --bench simulator`. After criterion's own figures a table gives, for each
//! case, the error of both against the reference integration, their times and the ratio.

#[path = "../tests/oracle/mod.rs"]
mod oracle;

use std::hint::black_box;
use std::time::Instant;

use criterion::Criterion;
use impactscope::model::Model;
use impactscope::model::drive::Waveform;
use impactscope::sim::{Options, simulate};

use oracle::native::run_native;
use oracle::{Device, Drive, Outcome, Tolerance, run};

struct Case {
    name: &'static str,
    waveform: Waveform,
    drive: Drive,
    duration: f64,
}

fn cases() -> [Case; 3] {
    let square = |name, duration| Case {
        name,
        waveform: Waveform::Square {
            frequency: 5.0,
            amplitude: 8.0,
        },
        drive: Drive::Square { hz: 5.0, volt: 8.0 },
        duration,
    };
    [
        square("5 Hz square, 1 s", 1.0),
        Case {
            name: "50 Hz sine, 1 s",
            waveform: Waveform::Sine {
                frequency: 50.0,
                amplitude: 8.0,
            },
            drive: Drive::Sine {
                hz: 50.0,
                volt: 8.0,
            },
            duration: 1.0,
        },
        // What is computed anew while a slider is dragged.
        square("5 Hz square, 0.4 s", 0.4),
    ]
}

const RATE: f64 = 50e3;

/// Worst error of xp farther than a sample from any event; infinite if the events differ.
fn error(reference: &Outcome, xp: impl Fn(usize) -> f64, events: usize) -> f64 {
    if events != reference.events.len() {
        return f64::INFINITY;
    }
    let near = |t: f64| {
        let next = reference
            .events
            .partition_point(|e| e.time < t - 1.01 / RATE);
        reference
            .events
            .get(next)
            .is_some_and(|e| e.time <= t + 1.01 / RATE)
    };
    let samples = reference.samples.iter().enumerate();
    samples
        .filter(|(i, _)| !near(*i as f64 / RATE))
        .fold(0.0, |m, (i, s)| f64::max(m, (xp(i) - s[1]).abs()))
}

/// Of `diffsol`: relative tolerance, with absolute ones that were found cheapest for a
/// given error.
fn opponent(relative: f64) -> Tolerance {
    Tolerance::relative(relative)
}

/// Seconds of processor time that this process has used, where the system tells (Linux,
/// in hundredths); else a clock. Other work on the machine then does not count.
fn clock(since: Instant) -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // After the name in parentheses: user and system time are the 12th and 13th field.
    let fields = stat
        .rsplit(')')
        .next()
        .unwrap_or_default()
        .split_whitespace();
    let ticks: Vec<f64> = fields
        .skip(11)
        .take(2)
        .filter_map(|f| f.parse().ok())
        .collect();
    match ticks[..] {
        [user, system] => (user + system) / 100.0,
        _ => since.elapsed().as_secs_f64(),
    }
}

/// Time of each [s]: the least of three turns of half a second.
fn times(runs: &[Box<dyn Fn() + '_>]) -> Vec<f64> {
    let since = Instant::now();
    let mut shortest = vec![f64::INFINITY; runs.len()];
    for _ in 0..3 {
        for (least, run) in shortest.iter_mut().zip(runs) {
            let start = clock(since);
            let mut count = 0.0;
            while clock(since) - start < 0.5 {
                (0..5).for_each(|_| run());
                count += 5.0;
            }
            *least = least.min((clock(since) - start) / count);
        }
    }
    shortest
}

/// A way to run a case, with its error and its steps.
struct Figures<'a> {
    label: String,
    error: f64,
    steps: u64,
    run: Box<dyn Fn() + 'a>,
}

fn ours<'a>(case: &'a Case, reference: &Outcome, tolerance: f64) -> Figures<'a> {
    let model = Model::default();
    let options = Options {
        tolerance,
        ..Options::default()
    };
    let run = move || simulate(&model, &case.waveform, case.duration, &options).unwrap();
    let trace = run();
    let contact = |e: &&impactscope::sim::Event| e.kind != impactscope::sim::EventKind::DriveStep;
    let events = trace.events.iter().filter(contact).count();
    Figures {
        label: format!("simulator, tolerance {tolerance:.0e} m"),
        error: error(reference, |i| trace.proof_mass[i], events),
        steps: trace.steps,
        run: Box::new(move || {
            black_box(run());
        }),
    }
}

fn theirs<'a>(case: &'a Case, reference: &Outcome, relative: f64) -> Figures<'a> {
    let device = Device::paper();
    let tolerance = opponent(relative);
    let run = move || run_native(&device, &case.drive, case.duration, RATE, &tolerance);
    let outcome = run();
    Figures {
        label: format!("diffsol tsit45, rtol {relative:.0e}"),
        error: error(reference, |i| outcome.samples[i][1], outcome.events.len()),
        steps: outcome.steps as u64,
        run: Box::new(move || {
            black_box(run());
        }),
    }
}

/// The loosest tolerance of `diffsol` whose error is at most `bound`.
fn loosest(case: &Case, reference: &Outcome, bound: f64) -> f64 {
    let ladder = (8..=25).map(|k| 10_f64.powf(-0.5 * f64::from(k)));
    let device = Device::paper();
    ladder
        .filter(|&relative| {
            let tolerance = opponent(relative);
            let out = run_native(&device, &case.drive, case.duration, RATE, &tolerance);
            error(reference, |i| out.samples[i][1], out.events.len()) <= bound
        })
        .fold(0.0, f64::max)
}

fn main() {
    let mut criterion = Criterion::default()
        .without_plots() // they need a font, which a server may lack
        .configure_from_args();
    let mut lines = Vec::new();
    for case in cases() {
        let device = Device::paper();
        let reference = run(
            &device,
            &case.drive,
            case.duration,
            RATE,
            &Tolerance::relative(1e-13),
        );
        let options = Options::default();
        let model = Model::default();
        let mine = ours(&case, &reference, options.tolerance);
        // Not stricter than twice the simulator's own error; and one that just meets the
        // 1 nm that is asked of both.
        let similar = loosest(&case, &reference, 2.0 * mine.error);
        let enough = loosest(&case, &reference, 1e-9);
        let mut group = criterion.benchmark_group(case.name);
        group.sample_size(20);
        group.bench_function("simulator", |b| {
            b.iter(|| simulate(&model, &case.waveform, case.duration, &options).unwrap());
        });
        let tolerance = opponent(similar);
        group.bench_function("diffsol at a similar error", |b| {
            b.iter(|| run_native(&device, &case.drive, case.duration, RATE, &tolerance));
        });
        group.finish();
        lines.push(format!("{}:", case.name));
        let figures = [
            mine,
            theirs(&case, &reference, similar),
            ours(&case, &reference, 1e-9),
            theirs(&case, &reference, enough),
        ];
        let seconds = times(
            &figures
                .each_ref()
                .map(|f| Box::new(|| (f.run)()) as Box<dyn Fn()>),
        );
        for (i, f) in figures.iter().enumerate() {
            let against = if i % 2 == 1 {
                let ratio = seconds[i] / seconds[i - 1];
                format!(", {ratio:.1} times the simulator's")
            } else {
                String::new()
            };
            lines.push(format!(
                "    {:<34} error {:.1e} m, {:>7} steps, {:>8.3} ms{against}",
                f.label,
                f.error,
                f.steps,
                seconds[i] * 1e3
            ));
        }
    }
    criterion.final_summary();
    for line in lines {
        println!("{line}");
    }
}
