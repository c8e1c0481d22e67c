//! The example: recordings that come with the program, so that a diagnosis can be tried at
//! once.

use crate::app::files::built_in;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::overlay::{Overlay, OverlayId, Role};
use crate::app::state::State;
use crate::model::preset::Preset;
use crate::trial::{Recordings, demo};

/// Loads the example and the paper's device. The person's own recordings stay, hidden and
/// unused. One undo step reverts it.
///
/// # Errors
/// Why the recordings cannot be read.
pub fn load(state: &mut State, last: &mut OverlayId) -> Result<(), String> {
    let recordings = demo::recordings().map_err(|error| error.to_string())?;
    crate::app::setup::current_setup::choose_preset(&mut state.setup, &Preset::default());
    let overlays = &mut state.setup.overlays;
    // Built-in recordings are replaced.
    overlays.retain(|overlay| !overlay.made_up);
    for overlay in overlays.iter_mut() {
        (overlay.role, overlay.visible) = (Some(Role::Unused), false);
    }
    add(&mut state.setup, recordings, true, last);
    state.selected = None;
    Ok(())
}

/// Whether the example is loaded.
pub fn is_loaded(setup: &Setup) -> bool {
    let of_example = |o: &&Overlay| o.made_up && !built_in::is_of_first_start(&o.recording.name);
    setup.overlays.iter().filter(of_example).count() > 1
}

/// Adds recordings that come from no file, with their roles; the first one is drawn in Tune.
pub(crate) fn add(
    setup: &mut Setup,
    recordings: Recordings,
    made_up: bool,
    last: &mut OverlayId,
) -> Vec<OverlayId> {
    let Recordings { train, held_out } = recordings;
    let train = train.into_iter().map(|r| (r, Role::Train));
    let held_out = held_out.into_iter().map(|r| (r, Role::HeldOut));
    let mut ids = Vec::new();
    for (color, (recording, role)) in train.chain(held_out).enumerate() {
        *last += 1;
        ids.push(*last);
        setup.overlays.push(Overlay {
            role: Some(role),
            visible: color == 0,
            made_up,
            color,
            ..crate::app::files::built_in::unread(*last, recording)
        });
    }
    ids
}
