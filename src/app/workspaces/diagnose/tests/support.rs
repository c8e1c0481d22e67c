//! States for the tests, without threads and files.

use std::sync::Arc;

use crate::app::analysis::diagnosis_answer::Asked;
use crate::app::files::built_in;
use crate::app::setup::overlay::Role;
use crate::app::setup::view::View;
use crate::app::state::State;
use crate::diagnose::Diagnosis;
use crate::model::preset::Preset;
use crate::recording::Recording;

/// The state of a first start without recordings.
pub fn empty() -> State {
    let setup = built_in::from_preset(Preset::default());
    State::new(setup, View::default())
}

/// A short recording of a decaying oscillation with a constant voltage.
pub fn recording(name: &str) -> Arc<Recording> {
    let time: Vec<f64> = (0..2000).map(|i| 2e-5 * f64::from(i)).collect();
    let ring = |t: &f64| 5e-5 * (-30.0 * t).exp() * (3900.0 * t).cos();
    let values = time.iter().map(ring).collect();
    let voltage = vec![8.0; time.len()];
    Arc::new(Recording::new(name, time, Some(voltage), values, None).unwrap())
}

/// A state with recordings of these names, as if loaded by a person.
pub fn with(names: &[&str]) -> State {
    let mut state = empty();
    for (id, name) in (1..).zip(names) {
        let mut overlay = built_in::unread(id, recording(name));
        overlay.made_up = false;
        state.setup.overlays.push(overlay);
    }
    state
}

/// A state in which a search has found `diagnosis`.
pub fn answered(diagnosis: Diagnosis) -> State {
    let mut names: Vec<(&str, bool)> = Vec::new();
    for p in &diagnosis.proof {
        names.push((p.recording.as_str(), p.held_out));
    }
    let mut state = with(&names.iter().map(|n| n.0).collect::<Vec<_>>());
    for (overlay, (_, held_out)) in state.setup.overlays.iter_mut().zip(&names) {
        let role = if *held_out {
            Role::HeldOut
        } else {
            Role::Train
        };
        overlay.role = Some(role);
    }
    let asked = Asked::of(&state.setup, None);
    state.diagnosing.adopt(diagnosis, asked);
    state
}
