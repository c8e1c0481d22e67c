//! How far a device is from recordings: each simulated as a whole under its own voltage.
//!
//! `cargo run --release --example misfit -- device.toml recording.csv ...`

use std::path::Path;
use std::sync::Arc;

use impactscope::fit::experiment::whole_run;
use impactscope::model::preset::Preset;
use impactscope::recording::csv::import_auto;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let device = arguments
        .next()
        .ok_or("which device? name a preset or a TOML file")?;
    let model = Preset::load(&device)?.model;
    for path in arguments {
        let recording = Arc::new(import_auto(Path::new(&path), None)?);
        let Some(run) = whole_run(&recording, &model)? else {
            println!("{path}: no voltage");
            continue;
        };
        let Some(misfit) = run.result.misfit(&run.experiment) else {
            println!("{path}: rms {:.3e} m, no noise", run.result.proof_mass.rms);
            continue;
        };
        let drive = recording.own_drive().and_then(Result::ok);
        let drive = drive.map_or_else(|| "no drive".to_owned(), |d| d.text.clone());
        let start = match &run.experiment.start {
            None => "from rest",
            Some(start) if start.held_since.is_some() => "from the ground",
            Some(_) => "from motion",
        };
        println!("{misfit:.3} x noise, {start}, {drive}: {path}");
    }
    Ok(())
}
