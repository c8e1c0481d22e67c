//! What each recording is used for. Until a person chooses, it is chosen for them.

use crate::app::setup::overlay::{Overlay, OverlayId, Role};
use crate::app::setup::setup::Setup;

/// One in so many recordings is kept out by itself.
const KEPT_OUT: usize = 4;
/// How the name of one begins that is kept out by itself, whatever its place.
const SAYS_SO: [&str; 3] = ["held-out", "held_out", "heldout"];

/// Each recording with what it is used for. Until a person has chosen, those whose names say so
/// are kept out, or the last quarter, at least one, where there are several; hidden ones are
/// left, and so are made-up ones beside recordings of the person's own.
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
    let say = |all: &[(&Overlay, Role)]| all.iter().filter(|a| says_so(a)).count();
    if (1..used).contains(&say(&all)) {
        let them = all.iter_mut().filter(|a| says_so(a));
        them.for_each(|(_, r)| *r = Role::HeldOut);
    } else if used > 1 {
        let kept = (used / KEPT_OUT).max(1);
        let last = all.iter_mut().rev().filter(|(_, r)| *r == Role::Train);
        last.take(kept).for_each(|(_, r)| *r = Role::HeldOut);
    }
    all
}

/// Whether the name of a recording that is used says that it is kept out.
fn says_so((overlay, role): &(&Overlay, Role)) -> bool {
    let name = overlay.recording.name.to_lowercase();
    *role != Role::Unused && SAYS_SO.iter().any(|begin| name.starts_with(begin))
}

/// Whether those of `all` are kept out whose names say so, and no others.
pub fn are_named(all: &[(&Overlay, Role)]) -> bool {
    all.iter().all(|a| says_so(a) == (a.1 == Role::HeldOut))
}

/// Whether a person has chosen what any recording is used for.
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

/// Leaves the roles to the program again.
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
    fn names_say_what_is_kept_out() {
        let mut setup = with(4);
        let call = |setup: &mut Setup, k: usize, name: &str| {
            let recording = std::sync::Arc::make_mut(&mut setup.overlays[k].recording);
            recording.name = name.to_owned();
        };
        call(&mut setup, 1, "Held-out-1.csv");
        call(&mut setup, 4, "train-3.csv");
        assert_eq!(roles(&setup), [Unused, HeldOut, Train, Train, Train]);
        // Where all say so none can be fitted to: the last is kept out.
        for k in 1..5 {
            call(&mut setup, k, "held_out.csv");
        }
        assert_eq!(roles(&setup), [Unused, Train, Train, Train, HeldOut]);
    }

    #[test]
    fn the_last_quarter_is_kept_out_until_a_person_chooses() {
        assert_eq!(roles(&with(0)), [Train]);
        assert_eq!(roles(&with(1)), [Unused, Train]);
        assert_eq!(roles(&with(2)), [Unused, Train, HeldOut]);
        let mut eight = with(8);
        assert_eq!(roles(&eight)[6..], [Train, HeldOut, HeldOut]);
        choose(&mut eight, 17, Train);
        assert_eq!(roles(&eight)[6..], [Train, HeldOut, Train]);
        // One that is hidden keeps what was chosen for it.
        eight.overlays[8].visible = false;
        assert_eq!(roles(&eight)[8], Train);
        forget(&mut eight);
        assert_eq!(roles(&eight)[6..], [Train, HeldOut, Unused]);
    }
}
