//! States for the tests, without worker threads and files.

use std::sync::Arc;
use std::time::Duration;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::app::files::built_in;
use crate::app::setup::drive_choice::{DriveChoice, Mode};
use crate::app::setup::overlay::Overlay;
use crate::app::setup::own_drive::OwnDrive;
use crate::app::setup::view::View;
use crate::app::simulation::experiments::compare_all;
use crate::app::simulation::min_max_pyramid::Pyramid;
use crate::app::simulation::snapshot::{LiveState, OverlayComparison, Snapshot};
use crate::app::state::State;
use crate::model::drive::Waveform;
use crate::model::parameter::ParameterId;
use crate::model::preset::Preset;
use crate::model::sensor::gaussian;
use crate::recording::Recording;
use crate::recording::compare::Comparison;
use crate::recording::features::{Features, Spread, SteadyState};
use crate::sim::{Event, EventKind, Options, Trace, simulate};

/// The state of a first start without recordings.
pub fn state() -> State {
    let setup = built_in::from_preset(Preset::default());
    State::new(setup, View::default())
}

/// A recording of a decaying oscillation, 100 ms at 50 kHz, with a voltage.
pub fn recording(name: &str, amplitude: f64) -> Recording {
    let time: Vec<f64> = (0..5000).map(|i| 2e-5 * f64::from(i)).collect();
    let values = time
        .iter()
        .map(|t| amplitude * (-30.0 * t).exp() * (3900.0 * t).cos())
        .collect();
    let voltage = time
        .iter()
        .map(|t| if *t < 0.05 { 8.0 } else { -8.0 })
        .collect();
    Recording::new(name, time, Some(voltage), values, None).unwrap()
}

/// An overlay with its own id.
pub fn overlay(id: u64, recording: Recording, made_up: bool) -> Overlay {
    Overlay {
        id,
        recording: Arc::new(recording),
        import: Default::default(),
        alignment: Default::default(),
        drive: Default::default(),
        estimates: Default::default(),
        visible: true,
        color: id as usize,
        made_up,
        role: None,
    }
}

/// A result for `state`, with a comparison for each recording.
pub fn snapshot(state: &State, rms: f64) -> Arc<Snapshot> {
    let features = Some(Arc::new(features(1.0, 253e-6, 31.4e-3)));
    let comparisons = state
        .setup
        .overlays
        .iter()
        .map(|overlay| OverlayComparison {
            id: overlay.id,
            comparison: Ok(Arc::new(comparison(rms))),
            residual_pyramid: None,
            features: Some(Arc::new(self::features(0.0, 212e-6, 32e-3))),
            alignment: overlay.alignment,
            noise: Some(20e-9),
            drive_text: None,
            stretches: None,
            own: None,
        })
        .collect();
    let events = [EventKind::Impact, EventKind::Stick, EventKind::Release]
        .into_iter()
        .map(|kind| Event {
            time: 0.01,
            kind,
            velocity_before: -0.1,
            velocity_after: 0.0,
            pull_off_force: 1e-7,
            contact_duration: 0.0,
        })
        .collect();
    let trace = Trace {
        dt: 2e-5,
        events,
        ..Trace::default()
    };
    Arc::new(Snapshot {
        generation: 1,
        model: Arc::new(state.setup.preset.model.clone()),
        trace: Arc::new(trace),
        proof_mass_pyramid: Arc::new(pyramid()),
        cantilever_pyramid: Arc::new(pyramid()),
        features,
        comparisons,
        cost: Duration::from_micros(2300),
        run_of: None,
        live: None,
    })
}

/// Keeps the present device as a curve with an error of `rms` \[m\] on each recording.
pub fn keep(state: &mut State, name: &str, rms: f64) {
    let run = snapshot(state, rms);
    state.keep_run(name, 0.0, run);
}

/// A state with two recordings, a result, a kept curve and some changed parameters.
pub fn full() -> State {
    let mut state = state();
    state.setup.overlays = vec![
        overlay(0, recording("tapping-15Hz-8V-made-up.csv", 5e-5), true),
        overlay(
            1,
            recording(
                "a-recording-with-a-rather-long-file-name-2024-03-11.csv",
                8e-5,
            ),
            false,
        ),
    ];
    keep(&mut state, "kept 1", 2.6e-6);
    state
        .setup
        .preset
        .model
        .parameters
        .set(ParameterId::Cs, 3e-21);
    state
        .setup
        .preset
        .model
        .parameters
        .set(ParameterId::Alpha, 0.2);
    state.setup.locked.insert("Ca".to_owned());
    state.snapshot = Some(snapshot(&state, 1.25e-6));
    state.selected = Some(0);
    state
}

/// The drive of the recordings of [`compared`].
fn drive() -> Waveform {
    Waveform::parse("square:15Hz:8V", 0.1).unwrap()
}

/// A state with `count` recordings of the device with `eta` times `factor`, each 0.1 s long and
/// with noise of 20 nm, compared as the simulator does. Number `i` begins at `i` times 50 ms.
pub fn compared(count: u64, factor: f64) -> State {
    let mut state = state();
    state.setup.drive = DriveChoice::Waveform(drive());
    state.setup.duration = 0.1;
    let mut device = state.setup.preset.model.clone();
    let eta = device.parameters[ParameterId::Eta];
    device.parameters.set(ParameterId::Eta, factor * eta);
    let options = Options::default();
    let trace = simulate(&device, &drive(), 0.1, &options).unwrap();
    for id in 0..count {
        let mut rng = ChaCha8Rng::seed_from_u64(id);
        let readings = trace.proof_mass.iter();
        let readings = readings.map(|x| x + 20e-9 * gaussian(&mut rng)).collect();
        let start = 0.05 * id as f64;
        let times = (0..trace.len()).map(|i| start + i as f64 * trace.dt);
        let name = format!("rec-{id}.csv");
        let recording = Recording::new(name, times.collect(), None, readings, None).unwrap();
        let mut overlay = overlay(id, recording, false);
        overlay.drive = OwnDrive::Chosen(drive());
        state.setup.overlays.push(overlay);
    }
    simulate_again(&mut state);
    state
}

/// Gives a state the result that the simulator would send for its setup.
pub fn simulate_again(state: &mut State) {
    let model = Arc::new(state.setup.preset.model.clone());
    let duration = state.setup.duration;
    let trace = simulate(&model, &drive(), duration, &Options::default()).unwrap();
    let trace = Arc::new(trace);
    let compared = compare_all(&model, &drive(), &trace, &state.setup.overlays);
    let mut snapshot = Snapshot::new(1, &model, trace, compared, Duration::ZERO);
    snapshot.run_of = Some((drive(), duration));
    state.snapshot = Some(Arc::new(snapshot));
}

/// The same state in live mode.
pub fn live() -> State {
    let mut state = full();
    state.view.mode = Mode::Live;
    let mut snapshot = snapshot(&state, 1e-6).as_ref().clone();
    snapshot.live = Some(LiveState {
        time: 1.2345,
        history_start: 0.2,
        speed: 0.0099,
        paused: false,
    });
    state.snapshot = Some(Arc::new(snapshot));
    state
}

fn features(bounces: f64, peak: f64, contact: f64) -> Features {
    let spread = |mean| Some(Spread { mean, std: 0.0 });
    Features {
        noise: 0.0,
        contact_level: Ok(-58e-6),
        period: Ok(1.0 / 15.0),
        events: Default::default(),
        periods: Vec::new(),
        steady: Ok(SteadyState {
            first: 0,
            periods: 3,
            peak_amplitude: spread(peak),
            contact_duration: spread(contact),
            bounces: spread(bounces),
        }),
    }
}

fn comparison(rms: f64) -> Comparison {
    Comparison {
        first: 0,
        residual: Vec::new(),
        rms,
        nrmse_percent: Some(1.4),
        mean: 0.0,
        count: 5000,
        missing: 0,
        outside: 0,
    }
}

fn pyramid() -> Pyramid {
    Pyramid::default()
}
