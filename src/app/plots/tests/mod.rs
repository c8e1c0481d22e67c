//! The pictures without a GPU, by their accessible names.

mod pyramid;
mod switch;

use std::sync::Arc;
use std::time::Duration;

use eframe::egui::accesskit::Role;
use eframe::egui::{
    Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, Pos2, TouchPhase, vec2,
};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

use super::frame::time_window;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::overlay::Overlay;
use crate::app::setup::view::{Picture, View};
use crate::app::simulation::experiments::compare_all;
use crate::app::simulation::snapshot::{LiveState, Snapshot};
use crate::app::state::State;
use crate::model::drive::Waveform;
use crate::model::preset::Preset;
use crate::recording::Recording;
use crate::sim::{Event as SimEvent, EventKind, ForceTraces, Trace};

/// All pictures on, nothing loaded, no result.
fn empty() -> State {
    let setup = Setup {
        drive: DriveChoice::Waveform(Waveform::Rest),
        ..crate::app::files::built_in::from_preset(Preset::default())
    };
    let view = View {
        pictures: Picture::ALL.into(),
        ..View::default()
    };
    State::new(setup, view)
}

/// A made-up run of `samples` at 50 kHz.
fn trace(samples: usize) -> Trace {
    let dt = 2e-5;
    let wave = |f: f64, a: f64| -> Vec<f64> {
        (0..samples)
            .map(|i| a * (f * i as f64 * dt).sin())
            .collect()
    };
    let end = samples as f64 * dt;
    let contacts: Vec<(f64, f64)> = (0..(end / 0.01) as usize)
        .map(|i| (0.01 * i as f64, 0.01 * i as f64 + 2e-3))
        .collect();
    let events = contacts
        .iter()
        .flat_map(|&(a, b)| {
            [
                (a, EventKind::Impact),
                (a, EventKind::Stick),
                (b, EventKind::Release),
            ]
        })
        .map(|(time, kind)| SimEvent {
            time,
            kind,
            velocity_before: -0.1,
            velocity_after: 0.05,
            pull_off_force: 1e-8,
            contact_duration: 0.0,
        })
        .collect();
    Trace {
        dt,
        voltage: wave(94.0, 8.0),
        proof_mass: wave(4000.0, 5e-5),
        cantilever: wave(4000.0, 3e-5),
        proof_mass_velocity: wave(4000.0, 0.2),
        cantilever_velocity: wave(4000.0, 0.1),
        events,
        contacts,
        ground_level: Some(-5e-5),
        forces: Some(ForceTraces {
            drive: wave(94.0, 1e-6),
            film: wave(4000.0, 1e-7),
            effects: vec![0.0; samples],
            adhesion: wave(94.0, 1e-7),
            ground: wave(94.0, 1e-7),
            pull_off: wave(94.0, 2e-7),
        }),
        ..Trace::default()
    }
}

fn with(mut state: State, trace: Trace) -> State {
    let model = Arc::new(state.setup.preset.model.clone());
    let trace = Arc::new(trace);
    let compared = compare_all(&model, &Waveform::Rest, &trace, &state.setup.overlays);
    let snapshot = Snapshot::new(1, &model, trace, compared, Duration::ZERO);
    state.snapshot = Some(Arc::new(snapshot));
    state
}

/// Keeps the present curve.
fn keep(state: &mut State, name: &str) {
    let (shift, run) = (state.setup.kept.len() as f64, state.snapshot.clone());
    state.keep_run(name, shift, run.unwrap());
}

fn recorded(mut state: State) -> State {
    let time: Vec<f64> = (0..5000).map(|i| 2e-5 * f64::from(i)).collect();
    let values: Vec<f64> = time.iter().map(|t| 4e-5 * (4000.0 * t).sin()).collect();
    let volts = vec![8.0; time.len()];
    let recording = Recording::new("tap.csv", time, Some(volts), values, None);
    state.setup.overlays.push(Overlay {
        id: 3,
        recording: Arc::new(recording.unwrap()),
        import: Default::default(),
        alignment: Default::default(),
        drive: Default::default(),
        estimates: Default::default(),
        visible: true,
        color: 0,
        made_up: false,
        role: None,
    });
    state
}

fn harness(state: State) -> Harness<'static, State> {
    harness_in_steps(state, 0.25)
}

/// The pictures, drawn again after `step` seconds on the window's clock.
fn harness_in_steps(state: State, step: f32) -> Harness<'static, State> {
    let mut harness = Harness::builder()
        .with_size([900.0, 1000.0])
        .with_step_dt(step)
        .build_ui_state(super::show, state);
    harness.run_steps(3);
    harness
}

/// Names of the pictures that are there.
fn names(harness: &Harness<'_, State>) -> Vec<String> {
    harness
        .query_all_by_role(Role::Image)
        .filter_map(|node| node.accesskit_node().label())
        .collect()
}

fn plot(harness: &Harness<'_, State>, name: &str) -> eframe::egui::Rect {
    harness
        .query_all_by_role(Role::Image)
        .find(|node| {
            node.accesskit_node()
                .label()
                .is_some_and(|l| l.starts_with(name))
        })
        .unwrap_or_else(|| panic!("no picture {name}"))
        .rect()
}

#[test]
fn every_axis_has_a_quantity_and_a_unit() {
    let state = with(recorded(empty()), trace(20_000));
    let harness = harness(state);
    let names = names(&harness).join("\n");
    for name in [
        "Voltage: drive V [V] against time t [ms]",
        "Trajectory: displacement x [\u{b5}m] against time t [ms]",
        "Residual: simulation \u{2212} recording [\u{b5}m] against time t [ms]",
        "Forces: force [nN] against time t [ms]",
        "Phase portrait: vp [mm/s] against xp [\u{b5}m]",
        "Drive loop: xp [\u{b5}m] against drive V [V]",
    ] {
        assert!(names.contains(name), "{name} is not in\n{names}");
    }
}

#[test]
fn short_and_invalid_traces_are_drawn() {
    drop(harness(empty()));
    drop(harness(recorded(empty())));
    drop(harness(with(recorded(empty()), Trace::default())));
    for samples in [0, 1, 2] {
        drop(harness(with(recorded(empty()), trace(samples))));
    }
    let mut missing = trace(5000);
    missing.proof_mass = vec![f64::NAN; 5000];
    missing.voltage[7] = f64::INFINITY;
    missing.forces = None;
    let mut state = with(empty(), missing);
    keep(&mut state, "kept 1");
    state.cursors.first = Some(0.01);
    state.cursors.second = Some(f64::NAN);
    drop(harness(state));
}

#[test]
fn without_recordings_the_residual_gives_the_reason() {
    let harness = harness(with(empty(), trace(5000)));
    assert!(
        !names(&harness)
            .iter()
            .any(|name| name.starts_with("Residual"))
    );
    harness.get_by_label_contains("Residual: open a recording");
}

#[test]
fn the_readout_shows_values_at_the_cursors() {
    let mut state = with(empty(), trace(5000));
    state.cursors.first = Some(0.01);
    state.cursors.second = Some(0.03);
    let harness = harness(state);
    harness.get_by_label("10 ms");
    harness.get_by_label_contains("dt 20 ms");
    harness.get_by_label_contains("1/dt 50 Hz");
    harness.get_by_label_contains("\u{394} xp");
}

#[test]
fn a_second_cursor_and_the_pointer_move_no_picture() {
    let state = with(recorded(empty()), trace(20_000));
    let mut harness = harness(state);
    let places = |harness: &Harness<'_, State>| {
        ["Voltage", "Trajectory", "Forces"].map(|name| plot(harness, name))
    };
    let before = places(&harness);
    harness.state_mut().cursors.first = Some(0.01);
    harness.state_mut().cursors.second = Some(0.03);
    harness.event(Event::PointerMoved(before[1].center()));
    harness.run_steps(4);
    harness.get_by_label_contains("1/dt 50 Hz");
    assert_eq!(places(&harness), before);
}

/// Turns the wheel at a place.
fn wheel(harness: &mut Harness<'_, State>, at: Pos2, points: f32) {
    harness.event(Event::PointerMoved(at));
    harness.step();
    harness.event(Event::MouseWheel {
        unit: MouseWheelUnit::Point,
        delta: vec2(0.0, points),
        modifiers: Modifiers::NONE,
        phase: TouchPhase::Move,
        source: MouseWheelSource::Unknown,
    });
    // The turn is spread over some frames.
    harness.run_steps(60);
}

#[test]
fn the_wheel_on_the_scale_zooms_in_values_and_not_in_time() {
    // A double click takes less than 0.3 s, and each event is a frame of its own.
    let mut harness = harness_in_steps(with(empty(), trace(20_000)), 1.0 / 60.0);
    let rect = plot(&harness, "Trajectory");
    let window = time_window::in_view(harness.state());
    wheel(&mut harness, rect.left_center() - vec2(20.0, 0.0), 60.0);
    let chosen =
        |harness: &Harness<'_, State>| harness.state().view.value_ranges.get("Trajectory").copied();
    let (low, high) = chosen(&harness).unwrap();
    assert_eq!(time_window::in_view(harness.state()), window);
    // The run is 100 um or so high; the pointer was in the middle.
    wheel(&mut harness, rect.left_center() - vec2(20.0, 0.0), 60.0);
    let (nearer_low, nearer_high) = chosen(&harness).unwrap();
    assert!(nearer_low > low && nearer_high < high);
    let middle = 0.5 * (low + high);
    assert!((0.5 * (nearer_low + nearer_high) - middle).abs() < 0.01 * (high - low));
    // The other pictures stay as they are, and a double click shows all values again.
    assert_eq!(harness.state().view.value_ranges.len(), 1);
    let at = rect.left_center() - vec2(20.0, 0.0);
    for pressed in [true, false, true, false] {
        harness.event(Event::PointerButton {
            pos: at,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        });
    }
    harness.run_steps(2);
    assert_eq!(chosen(&harness), None);
}

fn click(harness: &mut Harness<'_, State>, at: Pos2, modifiers: Modifiers) {
    for pressed in [true, false] {
        harness.event(Event::PointerMoved(at));
        harness.event(Event::PointerButton {
            pos: at,
            button: PointerButton::Primary,
            pressed,
            modifiers,
        });
        harness.step();
    }
}

#[test]
fn clicks_set_cursors_and_escape_clears_them() {
    let mut harness = harness(with(empty(), trace(20_000)));
    let rect = plot(&harness, "Trajectory");
    let (from, to) = time_window::in_view(harness.state());
    click(&mut harness, rect.center(), Modifiers::NONE);
    let first = harness.state().cursors.first.unwrap();
    assert!((first - 0.5 * (from + to)).abs() < 0.01 * (to - from));
    harness.key_press(Key::Escape);
    harness.step();
    assert_eq!(harness.state().cursors.first, None);
}

#[test]
fn the_wheel_zooms_around_the_pointer_and_dragging_pans() {
    let mut harness = harness(with(empty(), trace(20_000)));
    let rect = plot(&harness, "Trajectory");
    let (from, to) = time_window::in_view(harness.state());
    harness.event(Event::PointerMoved(rect.center()));
    harness.step();
    harness.event(Event::MouseWheel {
        unit: MouseWheelUnit::Point,
        delta: vec2(0.0, 60.0),
        modifiers: Modifiers::NONE,
        phase: TouchPhase::Move,
        source: MouseWheelSource::Unknown,
    });
    harness.run_steps(20);
    let (near_from, near_to) = time_window::in_view(harness.state());
    assert!(near_to - near_from < 0.95 * (to - from));
    let middle = 0.5 * (near_from + near_to);
    assert!((middle - 0.5 * (from + to)).abs() < 0.01 * (to - from));
    harness.event(Event::PointerButton {
        pos: rect.center(),
        button: PointerButton::Primary,
        pressed: true,
        modifiers: Modifiers::NONE,
    });
    harness.step();
    for x in [10.0, 20.0, 40.0] {
        harness.event(Event::PointerMoved(rect.center() + vec2(x, 0.0)));
        harness.step();
    }
    assert!(time_window::in_view(harness.state()).0 < near_from);
}

#[test]
fn at_the_widest_zoom_nothing_moves() {
    let mut harness = harness(with(empty(), trace(20_000)));
    let rect = plot(&harness, "Trajectory");
    harness.event(Event::PointerMoved(rect.left_center() + vec2(90.0, 0.0)));
    harness.step();
    let mut seen = Vec::new();
    for _ in 0..12 {
        harness.event(Event::MouseWheel {
            unit: MouseWheelUnit::Point,
            delta: vec2(0.0, -120.0),
            modifiers: Modifiers::NONE,
            phase: TouchPhase::Move,
            source: MouseWheelSource::Unknown,
        });
        harness.run_steps(12);
        seen.push(time_window::in_view(harness.state()));
    }
    let (from, to) = seen[11];
    assert!((to - from - 1.2 * 0.4).abs() < 1e-3, "{seen:?}");
    let (before, _) = seen[8];
    assert!((from - before).abs() < 1e-9, "{seen:?}");
}

#[test]
fn a_live_run_ends_at_the_right_edge() {
    let mut state = with(empty(), trace(20_000));
    let mut snapshot = state.snapshot.as_ref().unwrap().as_ref().clone();
    snapshot.live = Some(LiveState {
        time: 0.39,
        history_start: 0.0,
        speed: 0.01,
        paused: false,
    });
    state.snapshot = Some(Arc::new(snapshot));
    state.view.time_range = Some((0.0, 0.1));
    let (from, to) = time_window::in_view(&state);
    assert!((from - 0.29).abs() < 1e-12 && (to - 0.39).abs() < 1e-12);
    state.scrub = Some(0.2);
    assert_eq!(time_window::in_view(&state).1, 0.2);
    drop(harness(state));
}

#[test]
fn a_live_run_moves_the_device_wherever_pointer_and_cursors_are() {
    let mut state = with(empty(), trace(20_000));
    let mut snapshot = state.snapshot.as_ref().unwrap().as_ref().clone();
    let live = LiveState {
        time: 0.39,
        history_start: 0.0,
        speed: 0.01,
        paused: false,
    };
    snapshot.live = Some(live);
    state.snapshot = Some(Arc::new(snapshot.clone()));
    state.cursors.hover = Some(0.1);
    state.cursors.first = Some(0.2);
    assert_eq!(super::device_time(&state), Some(0.39));
    // Looking back in time, and paused, the pointer chooses the moment.
    state.scrub = Some(0.3);
    assert_eq!(super::device_time(&state), Some(0.1));
    state.cursors.hover = None;
    assert_eq!(super::device_time(&state), Some(0.3));
    snapshot.live = None;
    state.snapshot = Some(Arc::new(snapshot));
    assert_eq!(super::device_time(&state), Some(0.2), "the cursor");
}

#[test]
fn the_device_alone_fills_its_space() {
    let mut state = with(empty(), trace(20_000));
    state.view.pictures = [Picture::Device].into();
    let harness = harness(state);
    let rect = plot(&harness, "Device");
    // The window is 1000 points high.
    assert!(rect.height() > 900.0, "{rect:?}");
}

/// Prints the cost of a frame with a million samples for `-- --nocapture`.
#[test]
fn a_million_samples_cost_their_pixels() {
    let mut harness = harness(with(empty(), trace(1_000_000)));
    let started = std::time::Instant::now();
    harness.run_steps(10);
    println!("a frame with 1e6 samples: {:?}", started.elapsed() / 10);
}
