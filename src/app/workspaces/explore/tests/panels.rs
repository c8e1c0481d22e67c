//! Each panel: its inputs have names, its answers come, and what is done to it has its effect.

use eframe::egui::{Key, Modifiers, pos2, vec2};
use egui_kittest::kittest::{NodeT, Queryable};

use super::{faults, harness, press, says, state, wait};
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::explore::{AxisChoice, DriveSource, ExplorePanel};
use crate::app::setup::workspace_id::WorkspaceId;
use crate::explore::gait::GaitPreset;
use crate::model::drive::Waveform;
use crate::model::preset::Preset;

#[test]
fn every_input_of_every_panel_has_a_name_and_is_in_the_window() {
    for panel in ExplorePanel::ALL {
        let harness = harness(state(panel));
        let found = faults(&harness);
        assert!(found.is_empty(), "{panel:?}: {found:#?}");
        for other in ExplorePanel::ALL {
            assert!(says(&harness, other.title()), "{panel:?}: {other:?}");
        }
    }
}

#[test]
fn a_map_is_computed_shows_its_regimes_and_opens_a_case_in_tune() {
    let mut harness = harness(state(ExplorePanel::Map));
    wait(&mut harness, |h| {
        h.state().exploring.map.run.job().is_none()
    });
    assert!(says(&harness, "36 of 36 points"));
    assert!(says(&harness, "Regimes, share of the map"));
    let picture = harness.get_by_label_contains("map: drive amplitude").rect();
    let at = picture.center() + vec2(40.0, -20.0);
    harness.hover_at(at);
    wait(&mut harness, |h| {
        !h.state().exploring.map.steady.is_waiting() && h.state().exploring.map.point.is_some()
    });
    assert!(says(&harness, "Steady response"));
    // Keys move the point.
    let before = harness.state().exploring.map.point;
    harness.drag_at(at);
    harness.run_steps(1);
    harness.drop_at(at);
    harness.run_steps(3);
    let state = harness.state();
    assert_eq!(state.view.workspace, WorkspaceId::Tune.name());
    let (_, drive) = state.exploring.map.setting(before.unwrap()).unwrap();
    assert_eq!(state.setup.drive, DriveChoice::Waveform(drive));
}

#[test]
fn bad_axes_and_devices_without_ground_say_why() {
    let mut bad = state(ExplorePanel::Map);
    bad.setup.explore.map.x.to = bad.setup.explore.map.x.from;
    assert!(says(&harness(bad), "empty"));
    let mut unknown = state(ExplorePanel::Orbit);
    unknown.setup.explore.orbit.axis = AxisChoice::new("lambda", (0.0, 0.4), false);
    unknown.setup.drive = DriveChoice::Waveform(Waveform::parse("square:15Hz:8V", 0.1).unwrap());
    assert!(says(&harness(unknown), "No diagram"));
    let mut free = state(ExplorePanel::Map);
    free.setup.preset = Preset::embedded("oscillator").unwrap();
    assert!(says(&harness(free), "has no drive"));
    let mut recorded = state(ExplorePanel::Basins);
    recorded.setup.drive = DriveChoice::Recorded(3);
    assert!(says(&harness(recorded), "does not repeat"));
}

#[test]
fn a_handle_is_dragged_added_and_deleted_and_the_response_follows() {
    let mut harness = harness(state(ExplorePanel::Waveform));
    wait(&mut harness, |h| {
        let steady = &h.state().exploring.drawing.steady;
        steady.asked().is_some() && !steady.is_waiting()
    });
    assert!(says(&harness, "contact share"));
    let before = harness.state().setup.explore.drawn.clone();
    // The canvas shows the whole period between its sides.
    let canvas = harness.get_by_label_contains("drawn period").rect();
    let range = crate::app::plots::explore::drawing::voltages_in_view(&before);
    let place = |time: f64, voltage: f64| {
        let y = (range.1 - voltage) / (range.1 - range.0);
        pos2(
            canvas.left() + time as f32 * canvas.width(),
            canvas.top() + y as f32 * canvas.height(),
        )
    };
    let handle = before.handles()[1];
    harness.drag_at(place(handle.time, handle.voltage));
    harness.run_steps(2);
    assert_eq!(harness.state().exploring.drawing.selected, Some(1));
    harness.hover_at(place(handle.time + 0.1, handle.voltage - 3.0));
    harness.run_steps(2);
    harness.drop_at(place(handle.time + 0.1, handle.voltage - 3.0));
    harness.run_steps(2);
    let moved = harness.state().setup.explore.drawn.handles()[1];
    assert!((moved.time - 0.15).abs() < 0.015, "{moved:?}");
    assert!((moved.voltage - 5.0).abs() < 0.2, "{moved:?}");
    harness.key_press(Key::Delete);
    harness.run_steps(2);
    assert_eq!(harness.state().setup.explore.drawn.handles().len(), 3);
    harness.key_press_modifiers(Modifiers::NONE, Key::PageDown);
    harness.run_steps(2);
    assert_eq!(harness.state().exploring.drawing.selected, Some(0));
    let asked = harness.state().exploring.drawing.steady.asked().unwrap();
    let drawn = harness.state().setup.explore.drawn.waveform().unwrap();
    assert_eq!(asked.drive, drawn);
}

#[test]
fn what_exceeds_a_limit_is_said() {
    let mut over = state(ExplorePanel::Waveform);
    over.setup.explore.drawn.offset = 1.0;
    over.setup.explore.drawn.limits.slew = Some(10.0);
    let harness = harness(over);
    assert!(says(&harness, "The voltage is exceeded"));
    assert!(says(&harness, "The slew is exceeded"));
}

#[test]
fn a_gait_shows_bars_and_says_that_there_is_no_body() {
    let mut six = state(ExplorePanel::Gait);
    six.setup.explore.gait.set_count(6);
    six.setup.explore.gait.apply(GaitPreset::Wave);
    let mut harness = harness(six);
    wait(&mut harness, |h| says(h, "fewer than 6 down"));
    assert!(says(&harness, "There is no body"));
    assert!(says(&harness, "gait: contacts of 6 feet"));
    press(&mut harness, "in phase");
    let gait = &harness.state().setup.explore.gait;
    assert!(gait.feet.iter().all(|foot| foot.delay == 0.0));
    let gait = super::super::gait_of(harness.state()).unwrap();
    assert_eq!(gait.names.len(), 6);
    assert!(faults(&harness).is_empty());
}

#[test]
fn an_orbit_diagram_and_basins_are_computed() {
    let mut harness_of_orbit = harness(state(ExplorePanel::Orbit));
    wait(&mut harness_of_orbit, |h| {
        h.state().exploring.orbit.run.job().is_none()
    });
    assert!(says(&harness_of_orbit, "12 steady states"));
    let mut over_phase = state(ExplorePanel::Basins);
    over_phase.setup.explore.basins.over_phase = true;
    let mut harness = harness(over_phase);
    wait(&mut harness, |h| {
        h.state().exploring.basins.run.job().is_none()
    });
    assert!(says(&harness, "4 of 4 starts"));
    let growing = harness
        .state()
        .exploring
        .basins
        .run
        .growing()
        .unwrap()
        .clone();
    let shares: f64 = growing
        .lock()
        .answer
        .responses
        .iter()
        .map(|r| r.share)
        .sum();
    assert!((shares - 1.0).abs() < 1e-9, "{shares}");
}

#[test]
fn robustness_answers_for_the_drive_maps_and_finds_waveforms() {
    let mut small = state(ExplorePanel::Robustness);
    small.setup.explore.robustness.source = DriveSource::Drawn;
    let mut harness = harness(small);
    wait(&mut harness, |h| says(h, "of 4 devices"));
    press(&mut harness, "Compute the map");
    wait(&mut harness, |h| {
        h.state().exploring.robust.map.job().is_none()
    });
    assert!(says(&harness, "9 of 9 points"));
    harness
        .state_mut()
        .setup
        .explore
        .robustness
        .wish
        .contact_share = None;
    harness.run_steps(3);
    assert!(says(&harness, "nothing is wanted"));
    let titles = harness.query_all_by_label_contains("Find a robust waveform");
    let visible = titles.filter(|node| !node.accesskit_node().is_hidden());
    assert_eq!(visible.count(), 1);
}
