//! Simulates the paper's device under a square wave and lists its impacts.
//!
//! `cargo run --release --example simulate`

use std::error::Error;

use impactscope::model::drive::Waveform;
use impactscope::model::preset::Preset;
use impactscope::sim::{EventKind, Options, simulate};

pub fn main() -> Result<(), Box<dyn Error>> {
    // A preset is a device with a usual drive. Values are SI.
    let mut model = Preset::default().model;
    model.set("Cs", 2e-21)?; // coefficient of the gas film

    let duration = 0.2;
    let drive = Waveform::parse("square:15Hz:8V", duration)?;
    let trace = simulate(&model, &drive, duration, &Options::default())?;

    println!("{} samples at {} kHz", trace.len(), 1e-3 / trace.dt);
    let lowest = trace.proof_mass.iter().copied().fold(0.0, f64::min);
    println!("the proof mass goes down to {:.2} um", lowest * 1e6);
    for event in &trace.events {
        if event.kind == EventKind::Impact {
            println!(
                "impact at {:8.4} ms with {:6.2} mm/s",
                event.time * 1e3,
                event.velocity_before * 1e3
            );
        }
    }
    Ok(())
}
