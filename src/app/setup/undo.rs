//! Undo and redo: one step per finished interaction.

use super::current_setup::Setup;

/// Steps that can be undone.
const MAX_STEPS: usize = 200;
/// A change counts as finished when nothing has moved for this long \[s\].
const SETTLE_TIME: f64 = 0.3;

/// Setups to go back and forth between.
#[derive(Debug)]
pub struct History {
    past: Vec<Setup>,
    future: Vec<Setup>,
    /// The last finished setup.
    settled: Setup,
    /// The setup seen last, and since when it has been like this \[s\].
    seen: Setup,
    since: f64,
    /// Whether a button or a text field was held in the last frame.
    held: bool,
}

impl History {
    /// A history that starts here.
    pub fn new(setup: &Setup) -> Self {
        Self {
            past: Vec::new(),
            future: Vec::new(),
            settled: setup.clone(),
            seen: setup.clone(),
            since: 0.0,
            held: false,
        }
    }

    /// Looks at the setup once a frame. `interacting`: a button or a text field is held;
    /// `now` \[s\]. Returns whether it must be called again soon for a change to settle.
    pub fn observe(&mut self, setup: &Setup, interacting: bool, now: f64) -> bool {
        // A new interaction: the change before it is a step of its own, however soon the
        // new one follows.
        if interacting && !self.held {
            self.settle();
        }
        self.held = interacting;
        if *setup != self.seen {
            self.seen = setup.clone();
            self.since = now;
        }
        if self.seen == self.settled {
            return false;
        }
        if interacting || now - self.since < SETTLE_TIME {
            return true;
        }
        self.settle();
        false
    }

    /// Makes what was last seen a step of its own, if it is a change.
    fn settle(&mut self) {
        if self.seen != self.settled {
            self.past
                .push(std::mem::replace(&mut self.settled, self.seen.clone()));
            self.future.clear();
            if self.past.len() > MAX_STEPS {
                self.past.remove(0);
            }
        }
    }

    /// Takes the last step back; false if there is none.
    pub fn undo(&mut self, setup: &mut Setup) -> bool {
        self.seen = setup.clone();
        self.settle();
        let Some(before) = self.past.pop() else {
            return false;
        };
        self.future
            .push(std::mem::replace(&mut self.settled, before));
        self.show(setup);
        true
    }

    /// Makes the last undone step again; false if there is none.
    pub fn redo(&mut self, setup: &mut Setup) -> bool {
        self.seen = setup.clone();
        self.settle();
        let Some(after) = self.future.pop() else {
            return false;
        };
        self.past.push(std::mem::replace(&mut self.settled, after));
        self.show(setup);
        true
    }

    fn show(&mut self, setup: &mut Setup) {
        self.seen = self.settled.clone();
        *setup = self.settled.clone();
    }

    /// Whether undo or redo can bring back a setup of this kind.
    pub fn holds(&self, is_it: impl Fn(&Setup) -> bool) -> bool {
        let steps = self.past.iter().chain(&self.future);
        steps.chain([&self.settled, &self.seen]).any(is_it)
    }

    /// Whether there is a step to take back.
    pub fn can_undo(&self) -> bool {
        !self.past.is_empty() || self.seen != self.settled
    }

    /// Whether there is a step to make again.
    pub fn can_redo(&self) -> bool {
        !self.future.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::super::undo::*;
    use crate::app::files::built_in;
    use crate::model::parameter::ParameterId;
    use crate::model::preset::known_value::KnownValue;

    fn alpha(setup: &Setup) -> f64 {
        setup.preset.model.parameters[ParameterId::Alpha]
    }

    fn set(setup: &mut Setup, value: f64) {
        setup.preset.model.parameters.set(ParameterId::Alpha, value);
    }

    #[test]
    fn a_drag_is_one_step() {
        let mut setup = built_in::setup();
        let before = setup.clone();
        let mut history = History::new(&setup);
        for i in 0..50 {
            set(&mut setup, 0.2 + 0.01 * f64::from(i));
            assert!(history.observe(&setup, true, 0.02 * f64::from(i)));
        }
        let dragged = setup.clone();
        assert!(history.observe(&setup, false, 1.1));
        assert!(!history.observe(&setup, false, 1.6));
        assert!(history.undo(&mut setup));
        assert_eq!(setup, before);
        assert!(!history.undo(&mut setup));
        assert!(history.redo(&mut setup));
        assert_eq!(setup, dragged);
        assert!(!history.redo(&mut setup));
    }

    #[test]
    fn what_is_known_and_asked_is_undone_too() {
        let mut setup = built_in::setup();
        let before = setup.clone();
        let mut history = History::new(&setup);
        let known = KnownValue::new(&setup.preset.model, "zeta1", (0.026, 1e-3)).unwrap();
        setup.preset.known.push(known);
        history.observe(&setup, false, 0.0);
        history.observe(&setup, false, 1.0);
        setup.diagnosis.longest = Some(30.0);
        history.observe(&setup, false, 2.0);
        history.observe(&setup, false, 3.0);
        assert!(history.undo(&mut setup));
        assert_eq!(
            (setup.preset.known.len(), setup.diagnosis.longest),
            (1, None)
        );
        assert!(history.undo(&mut setup));
        assert_eq!(setup, before);
    }

    #[test]
    fn a_new_change_ends_redo_and_an_unsettled_one_is_not_lost() {
        let mut setup = built_in::setup();
        let mut history = History::new(&setup);
        set(&mut setup, 0.5);
        history.observe(&setup, false, 0.0);
        history.observe(&setup, false, 1.0);
        history.undo(&mut setup);
        set(&mut setup, 0.7);
        history.observe(&setup, true, 2.0);
        assert!(history.undo(&mut setup), "the change in progress is a step");
        assert!(history.redo(&mut setup));
        assert_eq!(setup.preset.model.parameters[ParameterId::Alpha], 0.7);
        assert!(!history.can_redo());
    }

    #[test]
    fn two_drags_in_quick_succession_are_two_steps() {
        let mut setup = built_in::setup();
        let start = alpha(&setup);
        let mut history = History::new(&setup);
        for (i, value) in [0.5, 0.6].into_iter().enumerate() {
            let now = 0.1 * i as f64;
            history.observe(&setup, true, now);
            set(&mut setup, value);
            history.observe(&setup, true, now + 0.02);
            history.observe(&setup, false, now + 0.04);
        }
        assert!(history.undo(&mut setup));
        assert_eq!(alpha(&setup), 0.5);
        assert!(history.undo(&mut setup));
        assert_eq!(alpha(&setup), start);
        assert!(!history.can_undo());
    }

    #[test]
    fn a_drag_back_to_the_start_is_no_step() {
        let mut setup = built_in::setup();
        let start = alpha(&setup);
        let mut history = History::new(&setup);
        for value in [start, 0.5, start] {
            set(&mut setup, value);
            history.observe(&setup, true, 0.0);
        }
        assert!(!history.observe(&setup, false, 1.0));
        assert!(!history.can_undo() && !history.can_redo());
    }

    #[test]
    fn what_only_the_view_changed_leaves_redo_alone() {
        let mut setup = built_in::setup();
        let mut history = History::new(&setup);
        set(&mut setup, 0.5);
        history.observe(&setup, false, 0.0);
        assert!(history.undo(&mut setup));
        for now in [1.0, 2.0] {
            history.observe(&setup, true, now);
            history.observe(&setup, false, now + 0.5);
        }
        assert!(history.redo(&mut setup));
        assert_eq!(alpha(&setup), 0.5);
    }

    #[test]
    fn the_oldest_steps_are_forgotten() {
        let mut setup = built_in::setup();
        let mut history = History::new(&setup);
        for i in 0..(MAX_STEPS + 50) {
            set(&mut setup, 0.1 + 0.001 * i as f64);
            history.observe(&setup, true, i as f64);
            history.observe(&setup, false, i as f64 + 0.5);
        }
        let steps = std::iter::from_fn(|| history.undo(&mut setup).then_some(())).count();
        assert_eq!(steps, MAX_STEPS);
    }
}
