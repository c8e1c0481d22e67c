//! Time from a moved slider to the new curve, without drawing: the simulator thread with the
//! default span of 0.4 s and recordings of several lengths. Prints the median and the worst
//! of 60 moves.

use std::sync::Arc;
use std::time::{Duration, Instant};

use impactscope::app::files::built_in;
use impactscope::app::setup::drive_choice::Mode;
use impactscope::app::setup::overlay::Overlay;
use impactscope::app::simulation::request::SimulationRequest;
use impactscope::app::simulation::worker::{Worker, WorkerEvent};
use impactscope::model::drive::Waveform;
use impactscope::model::parameter::ParameterId;
use impactscope::recording::Recording;

/// Moves of the slider per case.
const SLIDER_MOVES: usize = 60;

fn request(overlays: &[Overlay], cs: f64) -> Result<SimulationRequest, Box<dyn std::error::Error>> {
    let mut model = built_in::setup().preset.model;
    model.parameters.set(ParameterId::Cs, cs);
    Ok(SimulationRequest {
        model: Arc::new(model),
        drive: Waveform::parse("square:15Hz:8V", 0.4)?,
        duration: 0.4,
        forces: true,
        overlays: overlays.to_vec(),
        mode: Mode::WholeSpan,
        slow_down: 0.01,
        paused: false,
        scrub: None,
        restarts: 0,
        steps: 0,
    })
}

/// A sine of `samples` at `rate` [Hz] as a recording.
fn recording(samples: usize, rate: f64) -> Result<Overlay, Box<dyn std::error::Error>> {
    let time: Vec<f64> = (0..samples).map(|i| i as f64 / rate).collect();
    let values = time.iter().map(|t| 5e-5 * (6000.0 * t).sin()).collect();
    let made_up = built_in::made_up(7).ok_or("the built-in recording")?;
    Ok(Overlay {
        recording: Arc::new(Recording::new("wave", time, None, values, None)?),
        ..made_up
    })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let cases = [
        ("no recording", vec![]),
        (
            "the built-in ones, 2.5e4 samples",
            built_in::setup().overlays,
        ),
        ("1e6 samples in 20 s", vec![recording(1_000_000, 5e4)?]),
        ("1e7 samples in 200 s", vec![recording(10_000_000, 5e4)?]),
        ("1e6 samples in 0.4 s", vec![recording(1_000_000, 2.5e6)?]),
    ];
    for (name, overlays) in cases {
        let worker = Worker::start(|| {})?;
        let mut times = Vec::with_capacity(SLIDER_MOVES);
        for i in 0..SLIDER_MOVES {
            let cs = 1e-21 * (1.0 + 0.05 * i as f64);
            let request = request(&overlays, cs)?;
            let started = Instant::now();
            worker.send(request);
            loop {
                let found = worker.events().iter().any(|event| {
                    matches!(event, WorkerEvent::Snapshot(s) if s.model.parameters[ParameterId::Cs] == cs)
                });
                if found {
                    break;
                }
                std::thread::sleep(Duration::from_micros(50));
            }
            times.push(started.elapsed());
            // As in a drag: the next move comes with the next frame.
            std::thread::sleep(Duration::from_millis(16));
        }
        times.sort();
        println!(
            "{name:32} median {:5.1} ms, worst {:5.1} ms",
            times[SLIDER_MOVES / 2].as_secs_f64() * 1e3,
            times[SLIDER_MOVES - 1].as_secs_f64() * 1e3
        );
    }
    Ok(())
}
