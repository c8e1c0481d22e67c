//! Exported pictures: their contents, that they can be read, and that a failed export
//! leaves an older file unchanged.

use std::sync::Arc;
use std::time::Duration;

use crate::app::export::*;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::overlay::{Estimates, Overlay};
use crate::app::setup::view::{Picture, View};
use crate::app::simulation::experiments::compare_all;
use crate::app::simulation::snapshot::Snapshot;
use crate::model::drive::Waveform;
use crate::model::preset::Preset;
use crate::recording::Recording;
use crate::sim::{Options, Trace, simulate};

/// The `paper` device run for 0.15 s, with a recording over it that lies 2 um higher.
fn state() -> State {
    let preset = Preset::default();
    let drive = Waveform::parse("square:15Hz:8V", 0.15).unwrap();
    let options = Options {
        forces: true,
        ..Options::default()
    };
    let trace = Arc::new(simulate(&preset.model, &drive, 0.15, &options).unwrap());
    let noisy = trace.proof_mass.iter().enumerate();
    let xp = noisy.map(|(i, x)| x + 2e-6 + 3e-7 * f64::from((i * 7919 % 101) as u32) / 101.0);
    let recording = Recording::new(
        "tap & <co>.csv",
        trace.times(),
        Some(trace.voltage.clone()),
        xp.collect(),
        None,
    );
    let overlays = vec![Overlay {
        id: 1,
        recording: Arc::new(recording.unwrap()),
        import: Default::default(),
        alignment: Default::default(),
        drive: Default::default(),
        // The 2 um are to be seen.
        estimates: Estimates {
            zeros: false,
            clock: false,
            scales: false,
            start: false,
        },
        visible: true,
        color: 0,
        made_up: false,
        role: None,
    }];
    let model = Arc::new(preset.model.clone());
    let mut state = with_overlays(preset, drive, overlays);
    let compared = compare_all(&model, &Waveform::Rest, &trace, &state.setup.overlays);
    let snapshot = Snapshot::new(1, &model, Arc::clone(&trace), compared, Duration::ZERO);
    state.snapshot = Some(Arc::new(snapshot));
    state
}

fn with_overlays(preset: Preset, drive: Waveform, overlays: Vec<Overlay>) -> State {
    let setup = Setup {
        drive: DriveChoice::Waveform(drive),
        duration: 0.15,
        overlays,
        ..crate::app::files::built_in::from_preset(preset)
    };
    let view = View {
        pictures: Picture::ALL.into(),
        dark: false,
        ..View::default()
    };
    State::new(setup, view)
}

/// Checks that all elements are closed in order and all text is escaped.
fn well_formed(svg: &str) {
    let mut open: Vec<&str> = Vec::new();
    for part in svg.split('<').skip(1) {
        let (tag, text) = part.split_once('>').unwrap();
        assert!(!text.contains('>'), "{text}");
        for (_, rest) in text.match_indices('&').map(|(i, _)| text.split_at(i)) {
            let entity = rest.split(';').next().unwrap();
            assert!(["&amp", "&lt", "&gt", "&quot", "&apos"].contains(&entity));
        }
        let name = tag.split_whitespace().next().unwrap();
        if let Some(name) = name.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') && !name.starts_with(['?', '!']) {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "{open:?}");
}

#[test]
fn an_svg_says_what_the_window_says() {
    let svg = svg_text(&sheet(&state()).unwrap()).unwrap();
    well_formed(&svg);
    for text in [
        "drive V [V]",
        "displacement x [\u{b5}m]",
        "simulation \u{2212} recording [\u{b5}m]",
        "force [\u{b5}N]",
        "time t [ms]",
        "vp [mm/s]",
        "xp of tap &amp; &lt;co&gt;.csv",
        "ground",
        "in contact",
        "\u{b1} noise",
        "bounce",
        "release",
        "pull-off",
        "adhesion",
    ] {
        assert!(svg.contains(text), "{text} is missing");
    }
    assert!(svg.len() < 4_000_000, "{} bytes", svg.len());
}

#[test]
fn an_svg_has_its_size_in_points() {
    let sheet = sheet(&state()).unwrap();
    let page = {
        font().unwrap();
        Page::new(&sheet, PAGE_WIDTH).unwrap().size
    };
    let svg = svg_text(&sheet).unwrap();
    let head = format!("width=\"{}\" height=\"{}\"", page[0], page[1]);
    assert!(svg.contains(&head), "{head}");
}

#[test]
fn a_png_has_its_size_and_curves_in_their_colours() {
    let sheet = sheet(&state()).unwrap();
    let bytes = png_bytes(&sheet).unwrap();
    let picture = image::load_from_memory(&bytes).unwrap().to_rgb8();
    let size = Page::new(&sheet, PAGE_WIDTH).unwrap().size;
    let expected = size.map(|side| side.ceil() as u32 * PNG_PIXELS);
    assert_eq!([picture.width(), picture.height()], expected);
    for line in sheet.stacked.iter().flat_map(|panel| &panel.lines) {
        let [r, g, b, _] = line.color.to_srgba_unmultiplied();
        let near = |p: &image::Rgb<u8>| {
            let difference = |i: usize, c: u8| i32::from(p.0[i]).abs_diff(i32::from(c));
            difference(0, r) + difference(1, g) + difference(2, b) < 30
        };
        assert!(picture.pixels().any(near), "{} is not drawn", line.name);
    }
}

#[test]
fn what_is_drawn_keeps_to_the_time_in_view() {
    let mut state = state();
    state.view.time_range = Some((0.05, 0.06));
    state.view.pictures = [Picture::Trajectory].into();
    let sheet = sheet(&state).unwrap();
    let panel = &sheet.stacked[0];
    assert!((panel.x.range.0 - 50.0).abs() < 1e-9 && (panel.x.range.1 - 60.0).abs() < 1e-9);
    well_formed(&svg_text(&sheet).unwrap());
}

#[test]
fn poor_results_are_exported_and_nothing_is_refused_in_words() {
    let mut state = state();
    let model = Arc::clone(&state.snapshot.as_ref().unwrap().model);
    let one = Trace {
        dt: 1e-5,
        proof_mass: vec![f64::NAN],
        voltage: vec![1.0],
        proof_mass_velocity: vec![0.0],
        ..Trace::default()
    };
    for trace in [Trace::default(), one] {
        let snapshot = Snapshot::new(2, &model, Arc::new(trace), Vec::new(), Duration::ZERO);
        state.snapshot = Some(Arc::new(snapshot));
        let sheet = sheet(&state).unwrap();
        well_formed(&svg_text(&sheet).unwrap());
    }
    state.view.pictures = [Picture::Device].into();
    assert!(matches!(sheet(&state), Err(ExportError::NothingShown)));
}

#[test]
fn files_are_written_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let mut state = state();
    state.view.pictures = [Picture::Voltage].into();
    let path = folder.path().join("plots.svg");
    svg(&path, &state).unwrap();
    let before = std::fs::read(&path).unwrap();
    assert!(before.starts_with(b"<svg"));
    png(&folder.path().join("plots.png"), &state).unwrap();
    state.view.pictures.clear();
    assert!(svg(&path, &state).is_err());
    assert_eq!(std::fs::read(&path).unwrap(), before);
    let nowhere = folder.path().join("none").join("plots.svg");
    state.view.pictures = [Picture::Voltage].into();
    let error = svg(&nowhere, &state).unwrap_err().to_string();
    assert!(
        error.contains("plots.svg") && error.contains("folder"),
        "{error}"
    );
    let left = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(left, 2);
}
