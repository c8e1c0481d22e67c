//! Where things are: docked tools, small windows, high magnification.

use eframe::egui::accesskit::Role;
use eframe::egui::{Rect, pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

use super::support::{full, live};
use crate::app::state::State;

#[test]
fn tools_dock_beside_the_plots_and_cover_none() {
    for size in [[1600.0, 1000.0], [1280.0, 720.0], [800.0, 500.0]] {
        for (title, open) in [
            ("Drive editor", 0),
            ("Fit", 1),
            ("Identification", 2),
            ("Table A.1", 3),
            ("Sensitivity", 4),
            ("Kept curves", 5),
        ] {
            let mut state = full();
            state.drive_editor_open = open == 0;
            state.fitting.open = open == 1;
            state.identification.open = open == 2;
            state.validation_open = open == 3;
            state.sensing.open = open == 4;
            state.kept_open = open == 5;
            let mut harness = sized(state, size);
            let close = harness.get_by_label(&format!("close {title}")).rect();
            assert!(close.right() <= size[0], "{title} at {size:?}: {close:?}");
            let plot = trajectory(&harness);
            assert!(plot.width() > 100.0, "{title} at {size:?}: {plot:?}");
            let tab = harness
                .get_all_by_role_and_label(Role::Button, title)
                .map(|node| node.rect())
                .find(|rect| (rect.center().y - close.center().y).abs() < 8.0);
            let tab = tab.unwrap_or_else(|| panic!("{title} at {size:?} has no tab"));
            assert!(
                plot.right() <= tab.left(),
                "{title} at {size:?} covers the plots: {plot:?} {tab:?}"
            );
            harness.get_by_label(&format!("close {title}")).click();
            harness.run_steps(30);
            let wider = trajectory(&harness);
            assert!(wider.width() > plot.width() || size[0] < 1000.0);
        }
    }
}

/// The workspace in a window of this size.
fn sized(state: State, size: [f32; 2]) -> Harness<'static, State> {
    let mut harness = Harness::builder()
        .with_size(size)
        .with_step_dt(1.0 / 60.0)
        .build_ui_state(super::super::show, state);
    harness.run_steps(40);
    harness
}

fn trajectory(harness: &Harness<'_, State>) -> Rect {
    let mut images = harness.query_all_by_role(Role::Image);
    let is_it = |label: Option<String>| label.is_some_and(|l| l.starts_with("Trajectory"));
    let image = images.find(|node| is_it(node.accesskit_node().label()));
    image.expect("the trajectory is shown").rect()
}

#[test]
fn in_a_small_window_nothing_overlaps_and_the_misfit_stays_in_view() {
    // 1600 x 1000 pixels at 200 %, and a small screen.
    for size in [[800.0, 500.0], [1280.0, 720.0]] {
        let harness = sized(full(), size);
        let window = Rect::from_min_size(pos2(0.0, 0.0), size.into());
        let misfit = harness.get_by_label_contains("misfit 62.5 x noise").rect();
        assert!(window.contains_rect(misfit), "{size:?}: {misfit:?}");
        let plot = trajectory(&harness);
        assert!(plot.width() > 300.0, "{size:?}: {plot:?}");
        assert!(misfit.bottom() <= plot.top());
        let sliders: Vec<Rect> = harness
            .query_all_by_role(Role::Slider)
            .map(|node| node.rect())
            .collect();
        for (i, slider) in sliders.iter().enumerate() {
            assert!(slider.right() < plot.left(), "{size:?}: {slider:?}");
            assert!(slider.width() > 40.0, "{size:?}: {slider:?}");
            for other in &sliders[..i] {
                assert!(!slider.intersects(*other), "{slider:?} and {other:?}");
            }
        }
        let open = harness.state().view.side_panel;
        assert_eq!(open, size[0] > 1000.0, "{size:?}");
    }
}

#[test]
fn the_controls_of_a_live_run_fit_into_a_small_window() {
    for size in [[800.0, 500.0], [1280.0, 720.0]] {
        let harness = sized(live(), size);
        let window = Rect::from_min_size(pos2(0.0, 0.0), size.into());
        let follow = harness.get_by_label("Follow").rect();
        let mut strip: Vec<Rect> = ["pause", "step", "restart", "speed", "history"]
            .map(|label| harness.get_by_label(label).rect())
            .to_vec();
        strip.push(follow);
        // The switch of the side panel is at the end of the strip.
        let switches = harness.get_all_by_role_and_label(Role::Button, "Recordings");
        let in_strip = |rect: &Rect| (rect.center().y - follow.center().y).abs() < 8.0;
        strip.extend(switches.map(|node| node.rect()).filter(in_strip));
        assert_eq!(strip.len(), 7);
        for (i, rect) in strip.iter().enumerate() {
            assert!(window.contains_rect(*rect), "{size:?}: {rect:?}");
            for other in &strip[..i] {
                assert!(!rect.intersects(*other), "{size:?}: {rect:?} and {other:?}");
            }
        }
    }
}
