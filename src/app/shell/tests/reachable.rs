//! What a person reaches whatever else is shown: what is under a notice, running jobs, and
//! sliders by keys.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Rect, pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

use super::super::window::Shell;
use super::{harness, preset, wait};
use crate::app::analysis::job::Job;
use crate::app::workspaces::tune::table_a1::calibrate;
use crate::app::workspaces::tune::table_a1::calibrate::TableFitState;
use crate::model::parameter::ParameterId;

#[test]
fn a_click_on_a_notice_reaches_what_is_under_it_and_only_its_buttons_take_clicks() {
    let mut harness = harness(preset("paper"));
    wait(&mut harness, |_| true);
    harness
        .state_mut()
        .services
        .notice(true, "something failed");
    // Older notices are above newer ones: the first is over a plot, not over its time axis.
    for text in ["and another", "and a third one"] {
        harness.state_mut().services.notice(true, text);
    }
    harness.run_steps(10);
    let notice = harness.get_by_label("something failed").rect();
    let plot = harness
        .query_all_by_role(Role::Image)
        .find(|node| {
            let label = node.accesskit_node().label();
            label.is_some_and(|l| l.starts_with("Trajectory"))
        })
        .unwrap()
        .rect();
    // Over the plots, beside the panels whose values and recordings it speaks of.
    assert!(
        plot.x_range().contains(notice.center().x),
        "{notice:?}, {plot:?}"
    );
    // A picture is under the text: the click sets its cursor.
    let under = notice.center();
    let is_in_plot = |rect: Rect| rect.contains(under);
    let images = harness.query_all_by_role(Role::Image);
    assert!(images.map(|n| n.rect()).any(is_in_plot), "{notice:?}");
    harness.drag_at(under);
    harness.run_steps(2);
    harness.drop_at(under);
    harness.run_steps(4);
    let services = &harness.state().services;
    assert!(
        services.state.cursors.first.is_some(),
        "the click was swallowed"
    );
    assert_eq!(services.state.notices.len(), 3);
    harness.get_by_label("Dismiss all").click();
    harness.run_steps(3);
    assert!(harness.state().services.state.notices.is_empty());
}

/// Work without a result that lasts until it is cancelled.
fn stopped<T>(cancel: &AtomicBool) -> Result<T, String> {
    while !cancel.load(Ordering::Relaxed) {
        std::thread::sleep(Duration::from_millis(2));
    }
    Err("stopped".to_owned())
}

#[test]
fn jobs_are_seen_and_cancelled_from_any_workspace() {
    let mut harness = harness(preset("paper"));
    wait(&mut harness, |_| true);
    let context = harness.ctx.clone();
    let fit = Job::start("fit", &context, move |control| stopped(control.cancel()));
    let table = Job::start("table fit", &context, move |control| {
        control.report((0.4, Duration::from_secs(9)));
        stopped(control.cancel())
    });
    let state = &mut harness.state_mut().services.state;
    state.fitting.job = Some(fit.clone());
    state.view.workspace = "diagnose".to_owned();
    let table_fit = TableFitState {
        job: Some(table.clone()),
        ..TableFitState::default()
    };
    let key = calibrate::key();
    context.data_mut(|data| data.insert_temp(key, table_fit));
    for _ in 0..100 {
        harness.run_steps(2);
        if table.progress().is_some() {
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    harness.run_steps(2);
    harness.get_by_label("fit to Table A.1 40 %");
    let place = harness.get_by_label("cancel fit to Table A.1").rect();
    harness.get_by_label("cancel fit").click();
    harness.run_steps(3);
    assert!(fit.is_cancelled() && !table.is_cancelled());
    for _ in 0..200 {
        harness.run_steps(2);
        if harness.query_by_label("cancel fit").is_none() {
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(
        harness.query_by_label("cancel fit").is_none(),
        "it has ended"
    );
    // The pointer is over the list: what is left of it has not moved.
    harness.get_by_label("fit ended");
    let button = harness.get_by_label("cancel fit to Table A.1");
    assert_eq!(button.rect(), place);
    // Elsewhere it lets the others move up.
    harness.hover_at(pos2(700.0, 400.0));
    harness.run_steps(3);
    assert!(harness.query_by_label("fit ended").is_none());
    let button = harness.get_by_label("cancel fit to Table A.1");
    assert!(button.rect().left() < place.left());
    button.click();
    harness.run_steps(3);
    assert!(table.is_cancelled());
}

#[test]
fn a_key_leads_to_a_slider_and_the_arrows_move_it() {
    let mut harness = harness(preset("paper"));
    wait(&mut harness, |_| true);
    let f1 = |harness: &Harness<'_, Shell>| {
        harness.state().services.state.setup.preset.model.parameters[ParameterId::F1]
    };
    let before = f1(&harness);
    harness.key_press(Key::Slash);
    harness.run_steps(4);
    harness.get_by_label("find a slider").type_text("f1");
    harness.run_steps(3);
    harness.key_press(Key::Enter);
    // It is in a closed part of the panel, which opens.
    harness.run_steps(60);
    harness.key_press(Key::ArrowRight);
    harness.run_steps(3);
    assert!(f1(&harness) > before);
    // With a slider in focus the other keys still work.
    harness.key_press(Key::W);
    harness.run_steps(2);
    assert_eq!(harness.state().services.state.view.time_range, None);
}
