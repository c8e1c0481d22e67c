//! The role of each recording: fit, held out or unused. Until the person chooses, the program
//! does.

use crate::app::setup::current_setup::Setup;
use crate::app::setup::overlay::{Overlay, OverlayId, Role};

/// The program holds out one of this many recordings.
const HELD_OUT_ONE_IN: usize = 4;
/// A recording whose name starts with one of these is held out.
const HELD_OUT_PREFIXES: [&str; 3] = ["held-out", "held_out", "heldout"];

/// Each recording with its role. Until the person has chosen, recordings named as held out
/// are held out; if there are none, the last quarter is, and at least one of several. Hidden
/// recordings are unused, and so are made-up ones if the person has recordings of their own.
/// Made-up ones are all fitted: each tells what the others do not.
pub fn of(setup: &Setup) -> Vec<(&Overlay, Role)> {
    let own = setup.overlays.iter().any(|o| !o.made_up);
    let counts = |o: &Overlay| o.visible && !(own && o.made_up);
    let usual = |o: &Overlay| {
        if counts(o) { Role::Train } else { Role::Unused }
    };
    let mut all: Vec<(&Overlay, Role)> = (setup.overlays.iter())
        .map(|o| (o, o.role.unwrap_or(usual(o))))
        .collect();
    if is_chosen(setup) {
        return all;
    }
    let used = all.iter().filter(|(_, r)| *r == Role::Train).count();
    let say = |all: &[(&Overlay, Role)]| all.iter().filter(|a| is_named_held_out(a)).count();
    if (1..used).contains(&say(&all)) {
        let them = all.iter_mut().filter(|a| is_named_held_out(a));
        them.for_each(|(_, r)| *r = Role::HeldOut);
    } else if used > 1 && own {
        let held_out = (used / HELD_OUT_ONE_IN).max(1);
        let last = all.iter_mut().rev().filter(|(_, r)| *r == Role::Train);
        last.take(held_out).for_each(|(_, r)| *r = Role::HeldOut);
    }
    all
}

/// The recordings with a role.
pub fn with_role(setup: &Setup, role: Role) -> impl Iterator<Item = &Overlay> {
    let all = of(setup).into_iter();
    all.filter(move |(_, r)| *r == role)
        .map(|(overlay, _)| overlay)
}

/// Whether a used recording is named as held out.
fn is_named_held_out((overlay, role): &(&Overlay, Role)) -> bool {
    let name = overlay.recording.name.to_lowercase();
    *role != Role::Unused
        && HELD_OUT_PREFIXES
            .iter()
            .any(|begin| name.starts_with(begin))
}

/// Whether exactly those recordings are held out that are named so.
pub fn are_named(all: &[(&Overlay, Role)]) -> bool {
    all.iter()
        .all(|a| is_named_held_out(a) == (a.1 == Role::HeldOut))
}

/// Whether the person has chosen a role for any recording.
pub fn is_chosen(setup: &Setup) -> bool {
    setup.overlays.iter().any(|o| o.role.is_some())
}

/// Chooses a role for one recording; the others keep theirs.
pub fn choose(setup: &mut Setup, id: OverlayId, role: Role) {
    let all: Vec<(OverlayId, Role)> = of(setup).into_iter().map(|(o, r)| (o.id, r)).collect();
    for (overlay, (_, now)) in setup.overlays.iter_mut().zip(all) {
        overlay.role = Some(if overlay.id == id { role } else { now });
    }
}

/// Lets the program choose the roles again.
pub fn forget(setup: &mut Setup) {
    for overlay in &mut setup.overlays {
        overlay.role = None;
    }
}

#[cfg(test)]
mod tests {
    use super::super::recording_roles::*;
    use crate::app::files::built_in;
    use crate::app::setup::overlay::Role::{HeldOut, Train, Unused};

    fn with(count: u64) -> Setup {
        let mut setup = built_in::setup();
        setup.overlays.truncate(1);
        for id in 0..count {
            let mut own = setup.overlays[0].clone();
            (own.id, own.made_up) = (10 + id, false);
            setup.overlays.push(own);
        }
        setup
    }

    fn roles(setup: &Setup) -> Vec<Role> {
        of(setup).into_iter().map(|(_, role)| role).collect()
    }

    #[test]
    fn recordings_named_held_out_are_held_out() {
        let mut setup = with(4);
        let call = |setup: &mut Setup, k: usize, name: &str| {
            let recording = std::sync::Arc::make_mut(&mut setup.overlays[k].recording);
            recording.name = name.to_owned();
        };
        call(&mut setup, 1, "Held-out-1.csv");
        call(&mut setup, 4, "train-3.csv");
        assert_eq!(roles(&setup), [Unused, HeldOut, Train, Train, Train]);
        // If all are named held out, only the last one is, so that some can be fitted to.
        for k in 1..5 {
            call(&mut setup, k, "held_out.csv");
        }
        assert_eq!(roles(&setup), [Unused, Train, Train, Train, HeldOut]);
    }

    #[test]
    fn the_last_quarter_is_held_out_until_a_person_chooses() {
        // The recordings that come with the program are all fitted: together they tell everything.
        assert_eq!(roles(&built_in::setup()), [Train, Train]);
        assert_eq!(roles(&with(0)), [Train]);
        assert_eq!(roles(&with(1)), [Unused, Train]);
        assert_eq!(roles(&with(2)), [Unused, Train, HeldOut]);
        let mut eight = with(8);
        assert_eq!(roles(&eight)[6..], [Train, HeldOut, HeldOut]);
        choose(&mut eight, 17, Train);
        assert_eq!(roles(&eight)[6..], [Train, HeldOut, Train]);
        // A hidden recording keeps its chosen role.
        eight.overlays[8].visible = false;
        assert_eq!(roles(&eight)[8], Train);
        forget(&mut eight);
        assert_eq!(roles(&eight)[6..], [Train, HeldOut, Unused]);
    }
}
