//! Fits four parameters to the first two thirds of a recording and measures the error on
//! the last third, which the fit has not seen.
//!
//! `cargo run --release --example fit`

use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use impactscope::fit::{Control, FitOptions, Part, fit};
use impactscope::model::preset::Preset;
use impactscope::recording::csv::import_bytes_auto;

/// A made-up recording: the paper's device with a stronger gas film, and sensor noise.
const RECORDING: &[u8] = include_bytes!("../assets/made-up-paper.csv");

pub fn main() -> Result<(), Box<dyn Error>> {
    // Columns, units and separators are found in the file.
    let recording = Arc::new(import_bytes_auto("made up", RECORDING)?);
    let (fitted, held_out) = Part::split(recording);

    // The fit starts from the paper's values and moves these parameters.
    let model = Preset::default().model;
    let options = FitOptions {
        free: ["eta", "dp", "zeta1", "Cs"].map(str::to_owned).to_vec(),
        ..FitOptions::for_model(&model)
    };
    // A window would show the progress and set `cancel` at the press of a button.
    let cancel = AtomicBool::new(false);
    let control = Control {
        cancel: &cancel,
        progress: &|_| {},
    };
    let result = fit(&model, &[fitted], &[held_out], &options, &control)?;

    for p in &result.parameters {
        println!(
            "{:6} {:.4e} +- {:.1e} {}",
            p.id, p.value, p.std_error, p.unit
        );
    }
    let own = &result.train.0;
    println!(
        "fitted: rms {:.1} nm, noise {:.1} nm",
        own.rms * 1e9,
        own.noise * 1e9
    );
    if let Some((other, _)) = &result.held_out {
        println!("held out: rms {:.1} nm", other.rms * 1e9);
    }
    for remark in &result.remarks {
        println!("{remark}");
    }
    Ok(())
}
