//! The force balance of recordings: which forces act on the measured motion.
//!
//! `cargo run --release --example balance -- device.toml train.csv ... --held-out held.csv ...`

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use impactscope::diagnose::force_balance::analyse;
use impactscope::diagnose::shooting::workspace::Workspace;
use impactscope::diagnose::{DiagnoseControl, DiagnoseOptions};
use impactscope::fit::Part;
use impactscope::model::preset::Preset;
use impactscope::recording::csv::import_auto;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    env_logger::init();
    let mut arguments = std::env::args().skip(1);
    let device = arguments
        .next()
        .ok_or("which device? name a preset or a TOML file")?;
    let model = Preset::load(&device)?.model;
    let mut sides = [Vec::new(), Vec::new()];
    let mut side = 0;
    for path in arguments {
        if path == "--held-out" {
            side = 1;
            continue;
        }
        sides[side].push(Arc::new(import_auto(Path::new(&path), None)?));
    }
    let begin = Instant::now();
    let [train, held_out] = sides;
    let (train, held_out) = Part::sides(train, held_out);
    let options = DiagnoseOptions::default();
    let cancel = AtomicBool::new(false);
    let control = DiagnoseControl {
        cancel: &cancel,
        progress: &|_| {},
    };
    let workspace = Workspace::new(&model, &train, &held_out, &options)?;
    let ready = begin.elapsed();
    let Some(balance) = analyse(&workspace, &options, &control)? else {
        println!("no force balance");
        return Ok(());
    };
    println!(
        "{:.3} -> {:.3}, held out {:.3} -> {:.3}; read {:.1} s, all {:.1} s",
        balance.before.train_per_row(),
        balance.after.train_per_row(),
        balance.before.held_out_per_row(),
        balance.after.held_out_per_row(),
        ready.as_secs_f64(),
        begin.elapsed().as_secs_f64()
    );
    for e in &balance.effects {
        println!(
            "  {} {:?} +- {:?}, gain {:.0?}",
            e.effect.spec.id, e.effect.values, e.errors, e.gain
        );
    }
    for c in balance.candidates.iter().take(5) {
        println!("    {}: {:.0?} {:.3}", c.id, c.gain, c.held_out_per_row);
    }
    Ok(())
}
