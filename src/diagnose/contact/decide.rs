//! Which contact laws are named: by the events as the baseline reads them, and as the model with the
//! named effects reads them.

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
    COMPLIANCE_DESPITE_MODE_GAIN, CONFIRMING_HELD_GAIN, CONTACT_LAW_STANDS_SHARE, HELD_GAIN,
    TRAIN_GAIN,
};
use crate::model::effects::{ContactLaw, EffectSpec};

/// What a contact law is named by.
#[derive(Debug, Clone, Copy)]
pub struct Rules<'a> {
    /// Effects chosen by hand, whatever the events say, in place of a search.
    pub by_hand: Option<&'a [String]>,
    /// Whether there are held-out recordings.
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
            let held = test.held_gain > CONFIRMING_HELD_GAIN;
            let alone = test.gain > TRAIN_GAIN && (!self.held_out || held);
            // Both sides together count if the fitted one does not contradict and the held-out one
            // proves it.
            let predicted = |least: f64| {
                let both = test.gain + test.held_gain;
                test.gain > -HELD_GAIN && held && both > least
            };
            alone || test.min_predictive_gain.is_some_and(predicted)
        })
    }

    /// The law of a compliant ground, if the events call for it.
    fn compliant<'t>(&self, tests: &'t [LawTest]) -> Option<&'t LawTest> {
        let mut all = tests.iter();
        all.find(|t| t.law() == Some(ContactLaw::Compliance) && self.passes(t))
    }

    /// The laws to be named together with `effects`: tested `first` by the baseline, and `again` with
    /// those effects.
    pub fn named(
        &self,
        first: &[LawTest],
        again: &[LawTest],
        effects: &[&EffectSpec],
    ) -> Vec<LawTest> {
        let is_obscured = |law| effects.iter().any(|e| e.facts.obscures.contains(&law));
        let of = |id: &str| again.iter().find(|t| t.id == id);
        // Flight hardly determines an attraction next to the ground, where it slows bounces and pulls
        // at the end of each contact. Restitution and adhesion must have shown without it, with the
        // same sign.
        let shown = |t: &LawTest| {
            let mut before = first.iter().filter(|b| b.id == t.id && self.passes(b));
            before.any(|b| b.effect.values[0] * t.effect.values[0] > 0.0)
        };
        // Nor does it determine how a further mode rings after impacts.
        let sure = |t: &LawTest| {
            let doubtful = t
                .law()
                .filter(|law| is_obscured(*law))
                .is_some_and(|law| match law {
                    ContactLaw::Compliance => t.gain + t.held_gain <= COMPLIANCE_DESPITE_MODE_GAIN,
                    ContactLaw::Restitution | ContactLaw::Adhesion => !shown(t),
                });
            !doubtful || self.by_hand(t.id) == Some(true)
        };
        // An effect that is missing in flight may look like a compliant ground.
        let stands = |first: &LawTest| {
            let still = |t: &LawTest| {
                let (now, then) = (t.gain + t.held_gain, first.gain + first.held_gain);
                now > CONTACT_LAW_STANDS_SHARE * then && sure(t)
            };
            let by_hand = self.by_hand(first.id);
            by_hand.unwrap_or_else(|| of(first.id).is_some_and(still))
        };
        let soft = match self.compliant(first) {
            Some(test) => Some(test).filter(|t| stands(t)),
            None => self.compliant(again).filter(|t| sure(t)),
        };
        // A compliant ground has its own law of restitution.
        let compatible = |t: &LawTest| match t.law() {
            Some(ContactLaw::Compliance) => false,
            Some(ContactLaw::Restitution) => soft.is_none() || self.by_hand(t.id) == Some(true),
            _ => true,
        };
        let others = again.iter();
        let others = others.filter(|t| compatible(t) && self.passes(t) && sure(t));
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
pub(super) fn tests(ground: &Ground) -> Vec<LawTest> {
    let all = [
        restitution(ground),
        adhesion::test(ground),
        compliance(ground),
    ];
    let all: Vec<LawTest> = all.into_iter().flatten().collect();
    for t in &all {
        log::debug!(
            "{} gains {:.1}, held-out {:.1}: {:?}",
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
    use crate::diagnose::findings::Evidence;
    use crate::model::effects::{ActiveEffect, find};

    /// What the events say of a law with a first parameter of `value`.
    fn says(id: &str, gain: f64, held_gain: f64, value: f64) -> LawTest {
        let mut effect = ActiveEffect::new(find(id).unwrap());
        effect.values[0] = value;
        LawTest {
            id: effect.spec.id,
            gain,
            held_gain,
            min_predictive_gain: Some(50.0),
            held_chi2: 1.0,
            effect,
            errors: Vec::new(),
            sets: Vec::new(),
            evidence: Evidence::SequentialTime,
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
    fn a_law_needs_held_out_events() {
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
    fn only_adhesion_is_named_together_with_a_compliant_ground() {
        let all = [
            says("velocity_restitution", 80.0, 80.0, 0.1),
            says("adhesion_saturation", 80.0, 80.0, 1e-8),
            says("compliant_ground", 80.0, 80.0, 1e5),
        ];
        let named = ids(&all, &all, &[]);
        assert_eq!(named, ["compliant_ground", "adhesion_saturation"]);
        // It was due to an effect that was missing in flight.
        let first = [says("compliant_ground", 400.0, 400.0, 1e5)];
        let faint = says("compliant_ground", 60.0, 60.0, 1e5);
        let again = [all[0].clone(), all[1].clone(), faint.clone()];
        let named = ids(&first, &again, &["quadratic_drag"]);
        assert_eq!(named, ["velocity_restitution", "adhesion_saturation"]);
        // It was hidden by an effect that was missing in flight.
        assert_eq!(
            ids(&[], &[faint], &["quadratic_drag"]),
            ["compliant_ground"]
        );
    }

    #[test]
    fn a_compliant_ground_needs_a_larger_gain_together_with_a_further_mode() {
        let faint = [says("compliant_ground", 40.0, 40.0, 1e5)];
        assert!(ids(&faint, &faint, &["extra_mode"]).is_empty());
        assert_eq!(ids(&faint, &faint, &[]), ["compliant_ground"]);
        let sure = [says("compliant_ground", 60.0, 60.0, 1e5)];
        assert_eq!(ids(&sure, &sure, &["extra_mode"]), ["compliant_ground"]);
    }

    #[test]
    fn restitution_must_show_without_the_attraction() {
        let bent = [says("adhesion_saturation", 80.0, 80.0, 1e-8)];
        assert!(ids(&[], &bent, &["long_range_attraction"]).is_empty());
        let again = [says("velocity_restitution", 80.0, 80.0, 0.2)];
        let named_after = |first: LawTest| ids(&[first], &again, &["long_range_attraction"]);
        assert!(named_after(says("velocity_restitution", 80.0, 80.0, -0.05)).is_empty());
        assert!(named_after(says("velocity_restitution", 8.0, 8.0, 0.05)).is_empty());
        assert_eq!(
            named_after(says("velocity_restitution", 80.0, 80.0, 0.05)),
            ["velocity_restitution"]
        );
    }

    #[test]
    fn effects_chosen_by_hand_are_named() {
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
