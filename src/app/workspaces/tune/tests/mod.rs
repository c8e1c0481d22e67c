//! Tests of the workspace through its accessibility tree, without a GPU.

mod kept;
mod layout;
mod multiples;
mod panels;
mod residual;
mod sensitivity;
mod sliders;
pub(crate) mod support;
mod validation;

use eframe::egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use egui_kittest::{Harness, Node};

use crate::app::state::State;

/// The workspace at the smallest supported size.
fn harness(state: State) -> Harness<'static, State> {
    let mut harness = Harness::builder()
        .with_size([1280.0, 720.0])
        .with_step_dt(1.0 / 60.0)
        .build_ui_state(super::show, state);
    harness.run_steps(4);
    harness
}

/// The track of the slider whose name starts with `id`.
fn track<'a>(harness: &'a Harness<'_, State>, id: &str) -> Node<'a> {
    let start = format!("{id}, ");
    harness
        .query_all_by_role(Role::Slider)
        .find(|node| {
            node.accesskit_node()
                .label()
                .is_some_and(|label| label.starts_with(&start))
        })
        .unwrap_or_else(|| panic!("no slider {id}"))
}

/// Whether there is such a slider.
fn has_track(harness: &Harness<'_, State>, id: &str) -> bool {
    let start = format!("{id}, ");
    harness.query_all_by_role(Role::Slider).any(|node| {
        node.accesskit_node()
            .label()
            .is_some_and(|label| label.starts_with(&start))
    })
}

/// Types into a field like a person: click, replace the text, Enter.
fn type_into(harness: &mut Harness<'_, State>, label: &str, text: &str) {
    harness.get_by_label(label).click();
    harness.run_steps(3);
    harness.get_by_label(label).type_text(text);
    harness.run_steps(2);
    harness.key_press(eframe::egui::Key::Enter);
    // Long enough that the next click is not a double click.
    harness.run_steps(30);
}

/// Names of the pictures that begin with `start`.
fn pictures(harness: &Harness<'_, State>, start: &str) -> Vec<String> {
    let images = harness.query_all_by_role(Role::Image);
    let names = images.filter_map(|node| node.accesskit_node().label());
    names.filter(|name| name.starts_with(start)).collect()
}

/// Whether some text on screen contains `part`.
fn says(harness: &Harness<'_, State>, part: &str) -> bool {
    harness.query_all_by_label_contains(part).next().is_some()
}
