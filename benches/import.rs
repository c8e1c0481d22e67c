//! Import of a long CSV recording, compared with the plain `csv` crate reading the same
//! text into `f64`. Rows: 1e6, or `IMPORT_ROWS`.

use std::io::Write;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use impactscope::recording::TimeAxis;
use impactscope::recording::csv::{import_auto, write_csv};

/// A recording of `rows` samples at 50 kHz as a recorder writes it: six decimals of
/// time, four of voltage and displacement.
fn recorder_text(rows: usize) -> Vec<u8> {
    let mut text = Vec::with_capacity(rows * 40);
    text.extend_from_slice(b"t [s],V [V],xp [um],xc [um]\n");
    for i in 0..rows {
        let t = i as f64 * 2e-5;
        let (v, x) = ((300.0 * t).sin() * 8.0, (301.0 * t).sin() * 130.0);
        let _ = writeln!(text, "{t:.5},{v:.4},{x:.4},{:.4}", 0.3 * x);
    }
    text
}

/// The same with every digit of a simulation.
fn simulated_text(rows: usize) -> Vec<u8> {
    let x: Vec<f64> = (0..rows)
        .map(|i| (i as f64 * 6e-3).sin() * 130e-6)
        .collect();
    let v: Vec<f64> = (0..rows).map(|i| (i as f64 * 6e-3).sin() * 8.0).collect();
    let mut text = Vec::new();
    let axis = TimeAxis::Uniform { t0: 0.0, dt: 2e-5 };
    let _ = write_csv(&mut text, axis, Some(&v), &x, Some(&x));
    text
}

/// What a straightforward program does.
fn plain_csv_crate(path: &std::path::Path) -> usize {
    let Ok(mut reader) = csv::Reader::from_path(path) else {
        return 0;
    };
    let mut columns: [Vec<f64>; 4] = Default::default();
    let mut record = csv::ByteRecord::new();
    while reader.read_byte_record(&mut record).unwrap_or(false) {
        for (column, cell) in columns.iter_mut().zip(&record) {
            let value = std::str::from_utf8(cell).ok().and_then(|c| c.parse().ok());
            column.push(value.unwrap_or(f64::NAN));
        }
    }
    columns[0].len()
}

fn import(c: &mut Criterion) {
    let rows = std::env::var("IMPORT_ROWS")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(1_000_000);
    let Ok(folder) = tempfile::tempdir() else {
        return;
    };
    let mut group = c.benchmark_group("import");
    group.sample_size(10);
    group.throughput(Throughput::Elements(rows as u64));
    for (name, text) in [
        ("recorder", recorder_text(rows)),
        ("simulated", simulated_text(rows)),
    ] {
        let path = folder.path().join(name);
        if std::fs::write(&path, &text).is_err() {
            return;
        }
        drop(text);
        group.bench_function(format!("{name}/impactscope"), |b| {
            b.iter(|| import_auto(&path, None).map(|r| r.len()).unwrap_or(0));
        });
        group.bench_function(format!("{name}/csv crate"), |b| {
            b.iter(|| plain_csv_crate(&path));
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    // Plots need a font, which a machine without a desktop may lack.
    config = Criterion::default().without_plots();
    targets = import
}
criterion_main!(benches);
