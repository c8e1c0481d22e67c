//! Asks what the paper's model leaves out of two recordings.
//!
//! `cargo run --release --example diagnose`

use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use impactscope::diagnose::{DiagnoseControl, DiagnoseOptions, diagnose};
use impactscope::fit::Part;
use impactscope::model::preset::Preset;
use impactscope::recording::csv::import_bytes_auto;

/// Made-up recordings of a device near the paper's, in which a force is concealed.
const FITTED: &[u8] = include_bytes!("../assets/demo/train-4.csv");
const HELD_OUT: &[u8] = include_bytes!("../assets/demo/held-out-3.csv");

pub fn main() -> Result<(), Box<dyn Error>> {
    // Any number of recordings may be given on either side.
    let fitted = [Part::whole(Arc::new(import_bytes_auto("fitted", FITTED)?))];
    let held_out = [Part::whole(Arc::new(import_bytes_auto(
        "held out", HELD_OUT,
    )?))];

    // All effects of the catalogue are candidates unless some are named here.
    let options = DiagnoseOptions {
        candidates: ["quadratic_drag", "dry_friction", "cubic_stiffness"]
            .map(str::to_owned)
            .to_vec(),
        ..DiagnoseOptions::default()
    };
    let cancel = AtomicBool::new(false);
    let control = DiagnoseControl {
        cancel: &cancel,
        progress: &|_| {},
    };
    let model = Preset::default().model;
    let answer = diagnose(&model, &fitted, &held_out, &options, &control)?;

    println!("verdict: {:?}", answer.verdict);
    for effect in &answer.named {
        println!("{}: up to {:.2} nN", effect.name, effect.size * 1e9);
    }
    let errors = &answer.held_out;
    println!(
        "error on the held-out recording: {:.1} nm before, {:.1} nm after, noise {:.1} nm",
        errors.before.rms * 1e9,
        errors.after.rms * 1e9,
        answer.noise * 1e9
    );
    Ok(())
}
