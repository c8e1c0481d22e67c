//! One panel for each recording.

use eframe::egui::accesskit::Role;
use eframe::egui::{Event, Key, Modifiers, PointerButton, Pos2, Rect, pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

use super::support::{compared, live};
use super::{harness, pictures, says};
use crate::app::setup::view::{Picture, RecordingLayout};
use crate::app::state::State;

/// `count` recordings in a panel each, in a window of 1280 x 720.
fn panels(count: u64) -> Harness<'static, State> {
    let mut state = compared(count, 1.01);
    state.view.recording_layout = RecordingLayout::SmallMultiples;
    state.view.pictures.remove(&Picture::Device);
    harness(state)
}

fn places(harness: &Harness<'_, State>, start: &str) -> Vec<Rect> {
    let images = harness.query_all_by_role(Role::Image);
    let of = images.filter(|node| {
        let label = node.accesskit_node().label();
        label.is_some_and(|l| l.starts_with(start))
    });
    of.map(|node| node.rect()).collect()
}

fn click(harness: &mut Harness<'_, State>, at: Pos2) {
    for pressed in [true, false] {
        harness.event(Event::PointerMoved(at));
        harness.event(Event::PointerButton {
            pos: at,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        });
        harness.step();
    }
    // Long enough that the next click is not a double click.
    harness.run_steps(30);
}

#[test]
fn several_recordings_have_a_choice_and_one_has_none() {
    let mut harness = harness(compared(2, 1.01));
    assert_eq!(pictures(&harness, "Trajectory").len(), 1);
    harness.get_by_label("Small multiples").click();
    harness.run_steps(4);
    for name in ["rec-0.csv", "rec-1.csv"] {
        assert_eq!(
            pictures(&harness, &format!("Trajectory of {name}")).len(),
            1
        );
        assert_eq!(pictures(&harness, &format!("Residual of {name}")).len(), 1);
    }
    assert!(says(&harness, "choose Overlay to see it"));
    harness.get_by_label("Overlay").click();
    harness.run_steps(4);
    assert_eq!(pictures(&harness, "Trajectory:").len(), 1);
    harness.state_mut().setup.overlays[1].visible = false;
    harness.run_steps(3);
    assert!(harness.query_by_label("Small multiples").is_none());
    let mut live = live();
    live.view.recording_layout = RecordingLayout::SmallMultiples;
    let harness = super::harness(live);
    assert_eq!(pictures(&harness, "Trajectory:").len(), 1);
}

#[test]
fn panels_overlap_nothing_and_many_scroll() {
    for count in [2, 3, 4, 8] {
        let harness = panels(count);
        let motions = places(&harness, "Trajectory of");
        let residuals = places(&harness, "Residual of");
        assert_eq!(motions.len() as u64, count);
        assert_eq!(residuals.len() as u64, count);
        let all: Vec<Rect> = motions.iter().chain(&residuals).copied().collect();
        for (i, rect) in all.iter().enumerate() {
            assert!(rect.width() > 100.0 && rect.height() > 30.0, "{rect:?}");
            assert!(rect.right() < 1280.0, "{count}: {rect:?}");
            for other in &all[..i] {
                assert!(!rect.intersects(*other), "{count}: {rect:?} {other:?}");
            }
        }
        // Side by side: the same height, so that equal values are level.
        assert_eq!(motions[0].y_range(), motions[1].y_range());
        let fits = all.iter().all(|rect| rect.bottom() < 720.0);
        assert!(fits || count > 4, "{count}: {all:?}");
        let misfit = harness.get_by_label_contains("misfit ").rect();
        assert!(misfit.bottom() <= motions[0].top());
    }
}

#[test]
fn a_panel_is_selected_and_shown_alone() {
    let mut harness = panels(3);
    harness.get_by_label("select rec-2.csv").click();
    harness.run_steps(30);
    assert_eq!(harness.state().selected, Some(2));
    harness.get_by_label("show rec-1.csv alone").click();
    harness.run_steps(30);
    assert_eq!(harness.state().view.shown_alone, Some(1));
    let shown = pictures(&harness, "Trajectory of");
    assert_eq!(shown.len(), 1);
    assert!(shown[0].contains("rec-1.csv"));
    // It is only not drawn: the misfit is that of all.
    assert!(harness.state().setup.overlays.iter().all(|o| o.visible));
    harness.get_by_label("show all recordings").click();
    harness.run_steps(30);
    assert_eq!(pictures(&harness, "Trajectory of").len(), 3);
}

#[test]
fn each_panel_shows_its_whole_recording_and_cursors_count_from_its_start() {
    let mut harness = panels(2);
    // The second one begins 50 ms later; both are 100 ms long.
    let place = places(&harness, "Trajectory of rec-1.csv")[0];
    click(&mut harness, place.center());
    let cursor = harness.state().cursors.first.unwrap();
    assert!((cursor - 0.05).abs() < 2e-3, "{cursor}");
    assert_eq!(harness.state().selected, Some(1));
    // With the same time for all, it is the time on the axis: 0 to 150 ms.
    harness.get_by_label("same time").click();
    harness.run_steps(30);
    let place = places(&harness, "Trajectory of rec-1.csv")[0];
    click(&mut harness, place.center());
    let cursor = harness.state().cursors.first.unwrap();
    assert!((cursor - 0.075).abs() < 2e-3, "{cursor}");
}

#[test]
fn a_zoom_of_values_is_that_of_all_panels_or_of_one() {
    let mut harness = panels(2);
    let zoom = |harness: &mut Harness<'_, State>| {
        let name = "Scale of Trajectory of rec-1.csv";
        harness.get_by_role_and_label(Role::Splitter, name).focus();
        harness.run_steps(2);
        harness.key_press(Key::ArrowUp);
        harness.run_steps(2);
        let ranges = &harness.state().view.value_ranges;
        ranges.keys().cloned().collect::<Vec<_>>()
    };
    assert_eq!(zoom(&mut harness), ["Trajectory"]);
    harness.state_mut().view.value_ranges.clear();
    harness.get_by_label("same scale").click();
    harness.run_steps(30);
    assert!(harness.state().view.own_value_scales);
    assert_eq!(zoom(&mut harness), ["Trajectory #1"]);
    // Nothing of it is left elsewhere.
    harness.hover_at(pos2(5.0, 5.0));
    assert!(harness.state_mut().view.zoom_out_values());
}
