//! Time from a moved slider to the new curve, without drawing: the simulator thread with the
//! default span of 0.4 s and recordings of several lengths, and five recordings each under its own
//! measured voltage. Prints the median and the worst of 60 moves. `diffsol` does the runs of the
//! five alone, two at a time, without comparing them; its time over the worker's is the ratio.

#[path = "../tests/oracle/mod.rs"]
mod oracle;

use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

use impactscope::app::files::built_in;
use impactscope::app::setup::drive_choice::Mode;
use impactscope::app::setup::overlay::Overlay;
use impactscope::app::simulation::request::SimulationRequest;
use impactscope::app::simulation::worker::{Worker, WorkerEvent};
use impactscope::model::drive::Waveform;
use impactscope::model::parameter::ParameterId;
use impactscope::model::sensor::Sensor;
use impactscope::recording::Recording;
use impactscope::sim::{Options, simulate};
use rayon::prelude::*;

use oracle::native::run_native;
use oracle::{Device, Drive, Tolerance};

/// Moves of the slider per case.
const SLIDER_MOVES: usize = 60;

fn request(overlays: &[Overlay], cs: f64) -> Result<SimulationRequest, Box<dyn std::error::Error>> {
    let mut model = built_in::setup().preset.model;
    model.parameters.set(ParameterId::Cs, cs);
    Ok(SimulationRequest {
        from_steady: false,
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

/// Experiments under drives of their own: the drive as text, for the other integrator, and the
/// span [s].
const EXPERIMENTS: [(&str, Drive, f64); 5] = [
    (
        "square:15Hz:8V",
        Drive::Square {
            hz: 15.0,
            volt: 8.0,
        },
        0.4,
    ),
    (
        "ramped:5Hz:8V:0.25",
        Drive::Ramped {
            hz: 5.0,
            volt: 8.0,
            lambda: 0.25,
        },
        0.4,
    ),
    (
        "sine:50Hz:8V",
        Drive::Sine {
            hz: 50.0,
            volt: 8.0,
        },
        0.2,
    ),
    (
        "square:50Hz:7V",
        Drive::Square {
            hz: 50.0,
            volt: 7.0,
        },
        0.3,
    ),
    (
        "square:300Hz:6V",
        Drive::Square {
            hz: 300.0,
            volt: 6.0,
        },
        0.1,
    ),
];
/// Samples per second of the experiments [Hz].
const EXPERIMENT_RATE: f64 = 50e3;
/// Noise of their readings [m] and of their voltage [V].
const EXPERIMENT_NOISE: (f64, f64) = (20e-9, 1e-3);
/// Relative tolerance of `diffsol` that meets 1 nm in the simulator bench.
const PEER_TOLERANCE: f64 = 1e-9;

/// The experiments as recordings of the built-in device.
fn experiments() -> Result<Vec<Overlay>, Box<dyn std::error::Error>> {
    let model = built_in::setup().preset.model;
    let noisy = |mut values: Vec<f64>, noise: f64, seed: u64| {
        let sensor = Sensor {
            noise,
            ..Sensor::default()
        };
        sensor.add_noise(&mut values, seed);
        values
    };
    let mut all = Vec::new();
    for (k, (text, _, span)) in EXPERIMENTS.into_iter().enumerate() {
        let drive = Waveform::parse(text, span)?;
        let options = Options {
            rate: EXPERIMENT_RATE,
            ..Options::default()
        };
        let trace = simulate(&model, &drive, span, &options)?;
        let times = trace.times();
        let (seed, (of_readings, of_voltage)) = (10 * k as u64, EXPERIMENT_NOISE);
        let recording = Recording::new(
            text,
            times,
            Some(noisy(trace.voltage, of_voltage, seed)),
            noisy(trace.proof_mass, of_readings, seed + 1),
            Some(noisy(trace.cantilever, of_readings, seed + 2)),
        )?;
        all.push(built_in::unread(100 + k as u64, Arc::new(recording)));
    }
    Ok(all)
}

/// Median time in which `diffsol` does the runs of the experiments.
fn peer() -> Duration {
    const TURNS: usize = 9;
    let device = Device::paper();
    let tolerance = Tolerance::relative(PEER_TOLERANCE);
    let mut times: Vec<Duration> = (0..TURNS)
        .map(|_| {
            let started = Instant::now();
            EXPERIMENTS.par_iter().for_each(|(_, drive, span)| {
                black_box(run_native(
                    &device,
                    drive,
                    *span,
                    EXPERIMENT_RATE,
                    &tolerance,
                ));
            });
            started.elapsed()
        })
        .collect();
    times.sort();
    times[TURNS / 2]
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
    const OWN_DRIVES: &str = "five under their own drives";
    let cases = [
        ("no recording", vec![]),
        (OWN_DRIVES, experiments()?),
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
        if name == OWN_DRIVES {
            let peer = peer().as_secs_f64();
            println!(
                "    diffsol, the runs alone           {:5.1} ms, {:.1} times as long",
                1e3 * peer,
                peer / times[SLIDER_MOVES / 2].as_secs_f64()
            );
        }
    }
    Ok(())
}
