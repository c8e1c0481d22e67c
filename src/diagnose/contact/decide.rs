//! Which laws of the ground are named: what the events say by the baseline, and what they
//! still say once the flight is told.

use super::adhesion;
use super::compliance::compliance;
use super::event_readings;
use super::event_readings::Ground;
use super::law_test::LawTest;
use super::restitution::restitution;
use crate::diagnose::comparison::trial::ModelState;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::thresholds::{
    COMPLIANCE_DESPITE_MODE_GAIN, CONTACT_LAW_STANDS_SHARE, HELD_GAIN, TRAIN_GAIN,
};
use crate::model::effects::EffectSpec;

/// What a law of the ground is named by.
#[derive(Debug, Clone, Copy)]
pub struct Rules<'a> {
    /// Effects that are taken as left out whatever the events say, in place of a search.
    pub by_hand: Option<&'a [String]>,
    /// Whether there are recordings that were kept out.
    pub held_out: bool,
}

impl Rules<'_> {
    fn by_hand(&self, id: &str) -> Option<bool> {
        let ids = self.by_hand?;
        Some(ids.iter().any(|i| i == id))
    }

    /// Whether a law is named by its events alone.
    fn passes(&self, test: &LawTest) -> bool {
        self.by_hand(test.id).unwrap_or_else(|| {
            let held = test.held_gain > 0.5 * HELD_GAIN;
            let told = test.gain > TRAIN_GAIN && (!self.held_out || held);
            // What both sides tell together counts where the one does not speak against it and
            // the other proves it.
            let foreseen = |least: f64| {
                let both = test.gain + test.held_gain;
                test.gain > -HELD_GAIN && held && both > least
            };
            told || test.foreseen.is_some_and(foreseen)
        })
    }

    /// The law of a ground that gives way, if the events call for it.
    fn gives_way<'t>(&self, tests: &'t [LawTest]) -> Option<&'t LawTest> {
        let mut all = tests.iter();
        all.find(|t| t.id == "compliant_ground" && self.passes(t))
    }

    /// The laws to be named beside `effects`, of what the events said at `first`, by the
    /// baseline, and say `again`, with those effects.
    pub fn named(
        &self,
        first: &[LawTest],
        again: &[LawTest],
        effects: &[&EffectSpec],
    ) -> Vec<LawTest> {
        let has = |id: &str| effects.iter().any(|e| e.id == id);
        let of = |id: &str| again.iter().find(|t| t.id == id);
        // Flight tells little of how an attraction goes on next to the ground, where it makes
        // slow bounces slower and pulls at the end of each contact: what bends must have shown
        // without it, and the same way.
        let shown = |t: &LawTest| {
            let mut before = first.iter().filter(|b| b.id == t.id && self.passes(b));
            before.any(|b| b.effect.values[0] * t.effect.values[0] > 0.0)
        };
        // Nor of how a further mode rings that the impacts set off.
        let sure = |t: &LawTest| {
            let doubtful = match t.id {
                "compliant_ground" if has("extra_mode") => {
                    t.gain + t.held_gain <= COMPLIANCE_DESPITE_MODE_GAIN
                }
                "velocity_restitution" | "adhesion_saturation" if has("long_range_attraction") => {
                    !shown(t)
                }
                _ => false,
            };
            !doubtful || self.by_hand(t.id) == Some(true)
        };
        // What was left out of flight may look like a ground that gives way.
        let stands = |first: &LawTest| {
            let still = |t: &LawTest| {
                let (now, then) = (t.gain + t.held_gain, first.gain + first.held_gain);
                now > CONTACT_LAW_STANDS_SHARE * then && sure(t)
            };
            let by_hand = self.by_hand(first.id);
            by_hand.unwrap_or_else(|| of(first.id).is_some_and(still))
        };
        let soft = match self.gives_way(first) {
            Some(test) => Some(test).filter(|t| stands(t)),
            None => self.gives_way(again).filter(|t| sure(t)),
        };
        // A ground that gives way rebounds by its own law.
        let beside = |t: &LawTest| match t.id {
            "compliant_ground" => false,
            "velocity_restitution" => soft.is_none() || self.by_hand(t.id) == Some(true),
            _ => true,
        };
        let others = again.iter();
        let others = others.filter(|t| beside(t) && self.passes(t) && sure(t));
        soft.into_iter().chain(others).cloned().collect()
    }
}

/// The events at the ground as a model reads them, and what they say of each contact law.
pub struct ContactEvents {
    /// The readings.
    pub ground: Ground,
    /// One test for each law that the model may lack.
    pub tests: Vec<LawTest>,
}

impl ContactEvents {
    /// Reads the events by a model as fitted. Segments that were read `before` are taken as they
    /// were read then.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn read(
        workspace: &Workspace,
        state: &ModelState,
        before: Option<&Self>,
        control: &DiagnoseControl<'_>,
    ) -> Result<Self, DiagnoseError> {
        let held_out = state.held_out.as_ref();
        let before = before.map(|before| &before.ground);
        let ground = event_readings::read(workspace, &state.train, held_out, before, control)?;
        let tests = tests(&ground);
        Ok(Self { ground, tests })
    }
}

/// The contact laws that the events call for.
pub struct ContactLaws {
    /// The last test of each law.
    pub tests: Vec<LawTest>,
    /// Those that are named.
    pub named: Vec<LawTest>,
}

impl ContactLaws {
    /// No law is named.
    pub fn none(events: &ContactEvents) -> Self {
        Self {
            tests: events.tests.clone(),
            named: Vec::new(),
        }
    }

    /// Decides by the events as read by the baseline and, if effects were named, by them once more.
    /// `again` is called before that.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn decide(
        workspace: &Workspace,
        first: &ContactEvents,
        state: &ModelState,
        rules: &Rules<'_>,
        again: &dyn Fn(),
        control: &DiagnoseControl<'_>,
    ) -> Result<Self, DiagnoseError> {
        let tests = if state.named.is_empty() {
            first.tests.clone()
        } else {
            again();
            ContactEvents::read(workspace, state, Some(first), control)?.tests
        };
        let named = rules.named(&first.tests, &tests, &state.specs());
        Ok(Self { tests, named })
    }
}

/// All laws of the ground that the model may lack.
fn tests(ground: &Ground) -> Vec<LawTest> {
    let all = [
        restitution(ground),
        adhesion::test(ground),
        compliance(ground),
    ];
    let all: Vec<LawTest> = all.into_iter().flatten().collect();
    for t in &all {
        log::debug!(
            "{} gains {:.1}, {:.1} kept out: {}",
            t.id,
            t.gain,
            t.held_gain,
            t.evidence
        );
    }
    all
}

#[cfg(test)]
mod tests {
    use super::super::decide::*;
    use crate::model::effects::{ActiveEffect, find};

    /// What the events say of a law with a first parameter of `value`.
    fn says(id: &str, gain: f64, held_gain: f64, value: f64) -> LawTest {
        let mut effect = ActiveEffect::new(find(id).unwrap());
        effect.values[0] = value;
        LawTest {
            id: effect.spec.id,
            gain,
            held_gain,
            foreseen: Some(50.0),
            held_chi2: 1.0,
            effect,
            errors: Vec::new(),
            sets: Vec::new(),
            evidence: String::new(),
        }
    }

    const RULES: Rules<'static> = Rules {
        by_hand: None,
        held_out: true,
    };

    fn ids(first: &[LawTest], again: &[LawTest], effects: &[&str]) -> Vec<&'static str> {
        let effects: Vec<&EffectSpec> = effects.iter().map(|id| find(id).unwrap()).collect();
        let named = RULES.named(first, again, &effects);
        named.iter().map(|t| t.id).collect()
    }

    #[test]
    fn a_law_needs_both_sides() {
        for (gain, held, named) in [
            (60.0, 20.0, true),
            (60.0, -20.0, false),
            (5.0, 60.0, true),
            (5.0, 20.0, false),
        ] {
            let test = [says("adhesion_saturation", gain, held, 1e-8)];
            assert_eq!(!ids(&test, &test, &[]).is_empty(), named, "{gain} {held}");
        }
    }

    #[test]
    fn only_adhesion_bends_beside_a_ground_that_gives_way() {
        let all = [
            says("velocity_restitution", 80.0, 80.0, 0.1),
            says("adhesion_saturation", 80.0, 80.0, 1e-8),
            says("compliant_ground", 80.0, 80.0, 1e5),
        ];
        let named = ids(&all, &all, &[]);
        assert_eq!(named, ["compliant_ground", "adhesion_saturation"]);
        // Told by what flight lacked, it is none.
        let first = [says("compliant_ground", 400.0, 400.0, 1e5)];
        let faint = says("compliant_ground", 60.0, 60.0, 1e5);
        let again = [all[0].clone(), all[1].clone(), faint.clone()];
        let named = ids(&first, &again, &["quadratic_drag"]);
        assert_eq!(named, ["velocity_restitution", "adhesion_saturation"]);
        // Where flight alone hid it, it is one.
        assert_eq!(
            ids(&[], &[faint], &["quadratic_drag"]),
            ["compliant_ground"]
        );
    }

    #[test]
    fn a_ground_must_give_way_by_more_beside_a_further_mode() {
        let faint = [says("compliant_ground", 40.0, 40.0, 1e5)];
        assert!(ids(&faint, &faint, &["extra_mode"]).is_empty());
        assert_eq!(ids(&faint, &faint, &[]), ["compliant_ground"]);
        let sure = [says("compliant_ground", 60.0, 60.0, 1e5)];
        assert_eq!(ids(&sure, &sure, &["extra_mode"]), ["compliant_ground"]);
    }

    #[test]
    fn beside_an_attraction_restitution_must_have_shown_before() {
        let bent = [says("adhesion_saturation", 80.0, 80.0, 1e-8)];
        assert!(ids(&[], &bent, &["long_range_attraction"]).is_empty());
        let again = [says("velocity_restitution", 80.0, 80.0, 0.2)];
        let beside = |first: LawTest| ids(&[first], &again, &["long_range_attraction"]);
        assert!(beside(says("velocity_restitution", 80.0, 80.0, -0.05)).is_empty());
        assert!(beside(says("velocity_restitution", 8.0, 8.0, 0.05)).is_empty());
        assert_eq!(
            beside(says("velocity_restitution", 80.0, 80.0, 0.05)),
            ["velocity_restitution"]
        );
    }

    #[test]
    fn what_is_asked_for_by_hand_is_named() {
        let faint = [says("velocity_restitution", 1.0, 1.0, 0.1)];
        let ids = ["velocity_restitution".to_owned()];
        let rules = Rules {
            by_hand: Some(&ids),
            ..RULES
        };
        assert_eq!(rules.named(&faint, &faint, &[]).len(), 1);
        let none = Rules {
            by_hand: Some(&[]),
            ..RULES
        };
        let sure = [says("velocity_restitution", 90.0, 90.0, 0.1)];
        assert!(none.named(&sure, &sure, &[]).is_empty());
    }
}
