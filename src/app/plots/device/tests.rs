//! The picture by its accessible name, without a GPU, over made-up and simulated runs.

use std::sync::Arc;
use std::time::Duration;

use eframe::egui::{Theme, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

use super::moment::{Extremes, Moment};
use super::paint::nice_below;
use crate::app::files::built_in;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::view::View;
use crate::app::simulation::snapshot::{LiveState, Snapshot};
use crate::app::state::State;
use crate::model::drive::Waveform;
use crate::model::parameter::ParameterId;
use crate::model::preset::Preset;
use crate::sim::{Event, EventKind, ForceTraces, Options, Trace, simulate};

/// A state of an embedded preset, without a run.
fn state(preset: &str) -> State {
    let mut setup = built_in::setup();
    setup.preset = Preset::embedded(preset).unwrap();
    let drive = Waveform::parse(&setup.preset.drive, setup.preset.duration).unwrap();
    setup.drive = DriveChoice::Waveform(drive);
    setup.overlays.clear();
    State::new(setup, View::default())
}

fn with(mut state: State, trace: Trace) -> State {
    let model = Arc::new(state.setup.preset.model.clone());
    let snapshot = Snapshot::new(1, &model, Arc::new(trace), &[], Duration::ZERO);
    state.snapshot = Some(Arc::new(snapshot));
    state
}

fn simulated(preset: &str, rate: f64, duration: f64, forces: bool) -> State {
    let state = state(preset);
    let options = Options {
        rate,
        forces,
        ..Options::default()
    };
    let DriveChoice::Waveform(drive) = &state.setup.drive else {
        unreachable!()
    };
    let trace = simulate(&state.setup.preset.model, drive, duration, &options).unwrap();
    with(state, trace)
}

/// Falls for 1 ms, is held from 1 ms to 3 ms, then rises.
fn held() -> Trace {
    let level = -58e-6;
    let xp = vec![0.0, level, level, level, 20e-6];
    let all = |x: f64| vec![x; 5];
    Trace {
        dt: 1e-3,
        voltage: all(-8.0),
        cantilever: all(-10e-6),
        proof_mass_velocity: all(0.0),
        cantilever_velocity: all(0.0),
        contacts: vec![(1e-3, 3e-3)],
        events: vec![Event {
            time: 3e-3,
            kind: EventKind::Release,
            velocity_before: 0.0,
            velocity_after: 0.0,
            pull_off_force: 3e-8,
            contact_duration: 2e-3,
        }],
        ground_level: Some(level),
        forces: Some(ForceTraces {
            drive: all(1e-6),
            film: all(0.0),
            effects: all(0.0),
            adhesion: all(3e-8),
            ground: all(-2e-8),
            pull_off: vec![0.0, -1e-8, 2e-8, 3e-8, 0.0],
        }),
        proof_mass: xp,
        ..Trace::default()
    }
}

/// The accessible name of the picture at a time.
fn name(state: &State, time: Option<f64>, size: (f32, f32), theme: Theme) -> String {
    let mut harness = Harness::builder()
        .with_size(vec2(size.0, size.1))
        .with_theme(theme)
        .build_ui(|ui| super::show(ui, state, time));
    harness.run();
    let node = harness.get_by_label_contains("Device");
    node.accesskit_node().label().unwrap_or_default()
}

fn label_of(state: &State, time: Option<f64>) -> String {
    name(state, time, (500.0, 150.0), Theme::Dark)
}

#[test]
fn the_name_describes_the_motion() {
    let state = with(state("paper"), held());
    assert!(label_of(&state, Some(0.5e-3)).contains("in flight"));
    let pressed = label_of(&state, Some(1e-3));
    assert!(pressed.contains("in contact"), "{pressed}");
    assert!(pressed.contains("xp = -58 µm, V = -8 V"), "{pressed}");
    let pulled = label_of(&state, Some(2e-3));
    // Adhesion after 1 ms: 27.43 nN + 1.7 uN/s x 1 ms.
    assert!(pulled.contains("pull-off force 20 of 29.1 nN"), "{pulled}");
    assert!(label_of(&state, Some(3.5e-3)).contains("in flight"));
    // Times beyond the run show its ends, and no time shows its last sample.
    assert!(label_of(&state, Some(9.0)).contains("xp = 20 µm"));
    assert!(label_of(&state, None).contains("xp = 20 µm"));
    assert!(label_of(&state, Some(-9.0)).contains("xp = 0 m"));
}

#[test]
fn a_contact_without_end_lasts_to_the_end_of_the_run() {
    let mut trace = held();
    trace.proof_mass[4] = -58e-6;
    trace.contacts = vec![(1e-3, 4e-3)];
    trace.events.clear();
    let state = with(state("paper"), trace);
    let end = label_of(&state, None);
    assert!(end.contains("in contact for 3 ms"), "{end}");
}

#[test]
fn nothing_to_draw_is_named() {
    let empty = state("paper");
    assert!(label_of(&empty, None).contains("nothing to draw"));
    let empty = with(state("paper"), Trace::default());
    assert!(label_of(&empty, Some(0.0)).contains("nothing to draw"));
    let mut trace = held();
    trace.proof_mass = vec![f64::NAN; 5];
    let nan = with(state("paper"), trace);
    assert!(label_of(&nan, Some(1e-3)).contains("nothing to draw"));
    let mut trace = held();
    trace.dt = f64::NAN;
    assert!(label_of(&with(state("paper"), trace), Some(1e-3)).contains("Device"));
}

#[test]
fn one_sample_and_missing_columns_are_drawn() {
    let trace = Trace {
        dt: 1e-3,
        proof_mass: vec![1e-6],
        ..Trace::default()
    };
    for preset in ["paper", "oscillator", "faller"] {
        let label = label_of(&with(state(preset), trace.clone()), Some(0.0));
        assert!(label.contains("xp = 1 µm"), "{label}");
    }
    let mut trace = held();
    trace.cantilever = vec![f64::NAN; 5];
    trace.voltage.clear();
    trace.forces = None;
    let label = label_of(&with(state("paper"), trace), Some(2e-3));
    assert!(
        label.ends_with("in contact for 1 ms, xp = -58 µm"),
        "{label}"
    );
}

#[test]
fn all_presets_sizes_and_themes_are_drawn() {
    let states = [
        simulated("paper", 50e3, 0.04, true),
        simulated("paper", 50e3, 0.04, false),
        simulated("oscillator", 1e3, 2.0, true),
        simulated("faller", 1e3, 3.0, true),
    ];
    for state in &states {
        for size in [(240.0, 110.0), (500.0, 150.0), (1000.0, 260.0)] {
            for theme in [Theme::Dark, Theme::Light] {
                for share in [0.0, 0.3, 1.0] {
                    let end = state.snapshot.as_ref().unwrap().trace.end();
                    let label = name(state, Some(share * end), size, theme);
                    assert!(label.starts_with("Device, in "), "{label}");
                }
            }
        }
    }
}

#[test]
fn forces_that_were_not_recorded_are_computed() {
    let (with, without) = (
        simulated("paper", 50e3, 0.06, true),
        simulated("paper", 50e3, 0.06, false),
    );
    let mut flights = 0;
    for i in 5..2900 {
        let moment = |state: &State| {
            Moment::new(
                state,
                state.snapshot.as_ref().unwrap(),
                Some(f64::from(i) * 2e-5),
            )
            .unwrap()
        };
        let (a, b) = (moment(&with), moment(&without));
        let (drive, computed) = (a.drive.unwrap(), b.drive.unwrap());
        assert!((drive - computed).abs() <= 1e-9 * drive.abs(), "{i}");
        if a.contact_since.is_none() {
            let (film, computed) = (a.film.unwrap(), b.film.unwrap());
            assert!((film - computed).abs() <= 1e-3 * film.abs() + 1e-12, "{i}");
            flights += 1;
        }
    }
    assert!(flights > 100, "{flights}");
}

#[test]
fn the_range_is_that_of_the_run_without_the_sensor_offset() {
    let mut state = state("paper");
    let offset = 5e-6;
    let parameters = &mut state.setup.preset.model.parameters;
    parameters.set(ParameterId::OffsetP, offset);
    let mut trace = held();
    trace.proof_mass.iter_mut().for_each(|x| *x += offset);
    trace.ground_level = trace.ground_level.map(|x| x + offset);
    let state = with(state, trace);
    let snapshot = state.snapshot.as_ref().unwrap();
    let extremes = Extremes::new(snapshot, None);
    assert!((extremes.low + 58e-6).abs() < 1e-12);
    assert!((extremes.high - 20e-6).abs() < 1e-12);
    assert!(extremes.are_of(snapshot));
    // Drawn at its true position; the number is what the sensor shows.
    let moment = Moment::new(&state, snapshot, Some(2e-3)).unwrap();
    assert!((moment.xp + 58e-6).abs() < 1e-12);
    assert!((moment.reading + 53e-6).abs() < 1e-12);
}

/// A run that moves up to `high` \[m\]; live or not.
fn moved(high: f64, live: bool) -> Snapshot {
    let mut trace = held();
    trace.proof_mass = trace.proof_mass.iter().map(|x| x * high / 20e-6).collect();
    trace.ground_level = None;
    trace.cantilever = vec![0.0; trace.len()];
    let mut snapshot = with(state("paper"), trace)
        .snapshot
        .unwrap()
        .as_ref()
        .clone();
    snapshot.live = live.then_some(LiveState {
        time: 4e-3,
        history_start: 0.0,
        speed: 0.01,
        paused: false,
    });
    snapshot
}

#[test]
fn the_scale_stays_while_the_motion_fits_and_grows_in_few_steps() {
    for live in [true, false] {
        // As a slider is dragged, or a live run begins: twenty runs, each a little larger.
        let mut scale: Option<Extremes> = None;
        let mut changes = 0;
        for i in 1..=20 {
            let now = Extremes::new(&moved(1e-6 * f64::from(i), live), scale.as_ref());
            let range = |e: &Extremes| (e.low, e.high);
            changes += usize::from(scale.as_ref().is_some_and(|old| range(old) != range(&now)));
            scale = Some(now);
        }
        assert!(changes <= 7, "{changes} changes of the scale, live {live}");
    }
    // A live run that swings little for a while keeps its scale, and its arrows.
    let large = Extremes::new(&moved(20e-6, true), None);
    let small = Extremes::new(&moved(1e-6, true), Some(&large));
    assert_eq!((small.low, small.high), (large.low, large.high));
    assert!(small.contact >= large.contact && small.speed >= large.speed);
    // Another device has its own scale, and so has a scale that is fitted again.
    let mut other = moved(1e-6, true);
    let mut model = other.model.as_ref().clone();
    model.name = "another".to_owned();
    other.model = Arc::new(model);
    assert!(Extremes::new(&other, Some(&large)).high < 0.1 * large.high);
    assert!(Extremes::new(&moved(1e-6, true), None).high < 0.1 * large.high);
}

#[test]
fn round_lengths() {
    for (x, nice) in [(0.7, 0.5), (1.0, 1.0), (4.9e-6, 2e-6), (63.0, 50.0)] {
        assert!((nice_below(x) / nice - 1.0).abs() < 1e-9, "{x}");
    }
    assert_eq!(nice_below(f64::NAN), 1.0);
}
