//! Whether names that were found are refused for what they leave unexplained: an effect of the
//! catalogue may imitate a law outside it.

use crate::diagnose::findings::{Finding, FindingKind};
use crate::diagnose::thresholds::{
    FRICTION_BY_HEIGHT_LIMITS, LONG_RANGE_DECAY, MIN_CARRIED_SHARE, MIN_FORM_SHARE,
    NEGLIGIBLE_SHARE, PRODUCT_FORCE_LIMITS, STRONGEST_MIN_SHARE, TRAIN_GAIN,
};
use crate::model::Model;
use crate::model::effects::{ActiveEffect, EffectSpec};

/// Whether the force of a law depends on the displacement more than on anything else.
pub fn of_displacement(spec: &&'static EffectSpec) -> bool {
    spec.facts.force_over_displacement
}

/// Whether an attraction acts far beyond the last micrometres before touch.
pub fn attraction_reaches_far(model: &Model) -> bool {
    let falls_off = |e: &ActiveEffect| e.spec.facts.falls_off.map(|of| of(&e.values));
    let attraction = model.effects.iter().find_map(falls_off);
    attraction.is_some_and(|a| a.reach > LONG_RANGE_DECAY * a.exponent)
}

/// What the named effects leave, on which it depends whether their names stand. Gains are falls of
/// chi2 on the fitted recordings.
#[derive(Debug, Clone)]
pub struct AbstentionEvidence {
    /// What the checks of adequacy found.
    pub inadequacy: Option<Finding>,
    /// Names of the effects.
    pub names: Vec<&'static str>,
    /// Those whose force depends on the displacement most.
    pub of_displacement: Vec<&'static EffectSpec>,
    /// Whether an attraction among them acts over the whole stroke.
    pub long_range: bool,
    /// Whether the strongest force that is still missing depends on the displacement.
    pub over_displacement: bool,
    /// Gain by forces of any form.
    pub any_force_gain: f64,
    /// The part of it that other forms of the named laws would bring.
    pub form_gain: f64,
    /// Gain by a steady vibration that grows with the displacement.
    pub vibration_gain: f64,
    /// Gains by friction that depends on the height, and by the dry friction that was named.
    pub friction_gains: (f64, f64),
    /// Gain by all that was named.
    pub named_gain: f64,
    /// Gains by a force of the product of both displacements, and by the named laws of
    /// displacement.
    pub product_gains: (f64, f64),
    /// Share of what was missing that the effects carry.
    pub carried_share: f64,
    /// The same of segments each by itself.
    pub carried_of_segments: f64,
}

/// The checks that refuse names, in the order in which they are asked.
const CHECKS: [fn(&AbstentionEvidence) -> Option<Finding>; 5] = [
    vibration_with_displacement,
    force_of_both_displacements,
    friction_by_height,
    one_force_in_their_place,
    too_small_share,
];

impl AbstentionEvidence {
    /// Why the names are refused, if they are: the first check that says so.
    pub fn first_refusal(&self) -> Option<Finding> {
        CHECKS.iter().find_map(|check| check(self))
    }

    /// What is missing beyond what the checks of adequacy found: a force over the displacement that
    /// these do not look for.
    pub fn further_inadequacy(&self) -> Option<Finding> {
        let missing = |refusal: Finding| Finding {
            kind: FindingKind::MissingForce { over: "xp" },
            ..refusal
        };
        vibration_with_displacement(self)
            .or_else(|| force_of_both_displacements(self))
            .map(missing)
    }

    /// Named laws over the whole stroke. An attraction that acts at touch alone is none.
    fn over_stroke(&self) -> usize {
        let over = |s: &&&EffectSpec| self.long_range || s.facts.falls_off.is_none();
        self.of_displacement.iter().filter(over).count()
    }

    /// Whether two laws over the stroke stand for one.
    fn two_laws_for_one(&self) -> bool {
        self.over_stroke() > 1
    }

    /// Whether another law of displacement is missing than the single one that was named: other
    /// forms of that one do not bring what is missing.
    fn another_law(&self) -> bool {
        let other = self.long_range || self.form_gain < MIN_FORM_SHARE * self.any_force_gain;
        let much = self.any_force_gain - self.form_gain > NEGLIGIBLE_SHARE * self.named_gain;
        much && self.of_displacement.len() == 1 && self.over_displacement && other
    }
}

/// A vibration of the base has one amplitude; one that grows with the displacement is a stiffness
/// that varies in time.
fn vibration_with_displacement(of: &AbstentionEvidence) -> Option<Finding> {
    (of.vibration_gain > TRAIN_GAIN).then_some(Finding {
        kind: FindingKind::VibrationWithDisplacement,
        statistic: of.vibration_gain,
    })
}

/// Laws over the stroke of the mass imitate a force that depends on both displacements.
fn force_of_both_displacements(of: &AbstentionEvidence) -> Option<Finding> {
    let found = of.over_stroke() > 0 && exceeds(of.product_gains, PRODUCT_FORCE_LIMITS);
    found.then_some(Finding {
        kind: FindingKind::ForceOfBothDisplacements,
        statistic: of.product_gains.0,
    })
}

/// Dry friction imitates a friction that depends on the height. Beside a stronger law that is a matter of
/// its form.
fn friction_by_height(of: &AbstentionEvidence) -> Option<Finding> {
    let strongest = of.friction_gains.1 > STRONGEST_MIN_SHARE * of.named_gain;
    let found = of.inadequacy.is_some()
        && strongest
        && exceeds(of.friction_gains, FRICTION_BY_HEIGHT_LIMITS);
    found.then_some(Finding {
        kind: FindingKind::FrictionByHeight,
        statistic: of.friction_gains.0,
    })
}

/// Laws of displacement imitate one law that is not in the catalogue.
fn one_force_in_their_place(of: &AbstentionEvidence) -> Option<Finding> {
    // A single segment that is off says nothing about a force.
    let force = of.inadequacy.as_ref().is_some_and(|f| {
        matches!(
            f.kind,
            FindingKind::MeanSquare | FindingKind::MissingForce { .. }
        )
    });
    let found = force && (of.two_laws_for_one() || of.another_law());
    found.then(|| Finding {
        kind: FindingKind::OneForceInTheirPlace {
            effects: of.of_displacement.iter().map(|s| s.name).collect(),
        },
        statistic: of.form_gain / of.any_force_gain,
    })
}

/// Effects that carry too little of what is missing.
fn too_small_share(of: &AbstentionEvidence) -> Option<Finding> {
    let found = of.inadequacy.is_some() && of.carried_share < MIN_CARRIED_SHARE;
    found.then(|| Finding {
        kind: FindingKind::TooSmallShare {
            effects: of.names.clone(),
            of_segments: of.carried_of_segments,
        },
        statistic: of.carried_share,
    })
}

/// Whether a gain exceeds a least one, and a share of what the named effects bring.
fn exceeds((gain, named): (f64, f64), (least, share): (f64, f64)) -> bool {
    gain > least && gain > share * named
}

#[cfg(test)]
mod tests {
    use super::super::abstention::*;
    use crate::model::effects::find;

    fn finding(kind: FindingKind) -> Finding {
        Finding {
            kind,
            statistic: 180.0,
        }
    }

    /// `ids` named, a force over the displacement still missing.
    fn rest(ids: &[&str]) -> AbstentionEvidence {
        let specs = ids.iter().map(|id| find(id).unwrap());
        AbstentionEvidence {
            inadequacy: Some(finding(FindingKind::MissingForce { over: "xp" })),
            names: specs.clone().map(|s| s.name).collect(),
            of_displacement: specs.filter(of_displacement).collect(),
            long_range: false,
            over_displacement: true,
            any_force_gain: 180.0,
            form_gain: 170.0,
            vibration_gain: 0.0,
            friction_gains: (0.0, 0.0),
            named_gain: 400.0,
            product_gains: (0.0, 0.0),
            carried_share: 0.98,
            carried_of_segments: 0.98,
        }
    }

    #[test]
    fn two_laws_over_the_stroke_are_refused_when_a_force_is_still_missing() {
        let two = rest(&["cubic_stiffness", "electrostatic"]);
        assert!(
            two.first_refusal()
                .is_some_and(|f| matches!(f.kind, FindingKind::OneForceInTheirPlace { .. }))
        );
        let with = |inadequacy| AbstentionEvidence {
            inadequacy,
            ..two.clone()
        };
        assert_eq!(with(None).first_refusal(), None);
        assert_eq!(
            with(Some(finding(FindingKind::LocalSegment))).first_refusal(),
            None
        );
        assert!(
            with(Some(finding(FindingKind::MeanSquare)))
                .first_refusal()
                .is_some()
        );
    }

    #[test]
    fn an_attraction_at_touch_does_not_act_over_the_stroke() {
        let near = rest(&["cubic_stiffness", "long_range_attraction"]);
        assert_eq!(near.first_refusal(), None);
        let far = AbstentionEvidence {
            long_range: true,
            ..near
        };
        assert!(far.first_refusal().is_some());
    }

    #[test]
    fn one_law_is_refused_when_its_other_forms_do_not_explain_the_rest() {
        let one = rest(&["cubic_stiffness", "sensor_lag"]);
        assert_eq!(one.first_refusal(), None);
        let formal = |form_gain| AbstentionEvidence {
            form_gain,
            ..one.clone()
        };
        assert!(formal(100.0).first_refusal().is_some());
        assert!(formal(157.0).first_refusal().is_some());
        assert_eq!(formal(162.0).first_refusal(), None);
        let segment = AbstentionEvidence {
            inadequacy: Some(finding(FindingKind::LocalSegment)),
            ..formal(100.0)
        };
        assert_eq!(segment.first_refusal(), None);
        let little = AbstentionEvidence {
            named_gain: 1e5,
            ..formal(100.0)
        };
        assert_eq!(little.first_refusal(), None);
        let elsewhere = AbstentionEvidence {
            over_displacement: false,
            ..formal(100.0)
        };
        assert_eq!(elsewhere.first_refusal(), None);
    }

    #[test]
    fn friction_that_depends_on_height_is_not_dry_friction() {
        let of = |friction_gains| AbstentionEvidence {
            friction_gains,
            over_displacement: false,
            ..rest(&["dry_friction"])
        };
        assert!(
            of((900.0, 2e4))
                .first_refusal()
                .is_some_and(|f| f.kind == FindingKind::FrictionByHeight)
        );
        // A small share is due to the form of the law, and a small gain to chance.
        assert!(of((410.0, 2e4)).first_refusal().is_some());
        assert_eq!(of((390.0, 2e4)).first_refusal(), None);
        assert_eq!(of((30.0, 200.0)).first_refusal(), None);
        let explained = AbstentionEvidence {
            inadequacy: None,
            ..of((900.0, 2e4))
        };
        assert_eq!(explained.first_refusal(), None);
    }

    #[test]
    fn a_force_of_both_displacements_is_not_a_stiffness() {
        let of = |product_gains| AbstentionEvidence {
            inadequacy: None,
            product_gains,
            ..rest(&["cubic_stiffness"])
        };
        assert!(
            of((210.0, 2e4))
                .first_refusal()
                .is_some_and(|f| f.kind == FindingKind::ForceOfBothDisplacements)
        );
        assert_eq!(of((50.0, 2e4)).first_refusal(), None);
        assert_eq!(of((20.0, 200.0)).first_refusal(), None);
        let at_touch = AbstentionEvidence {
            product_gains: (900.0, 2e4),
            inadequacy: None,
            ..rest(&["long_range_attraction"])
        };
        assert_eq!(at_touch.first_refusal(), None);
    }

    #[test]
    fn too_small_a_share_and_a_growing_vibration_are_refused() {
        let little = AbstentionEvidence {
            carried_share: 0.3,
            carried_of_segments: 0.7,
            ..rest(&["sensor_lag"])
        };
        let refusal = little.first_refusal().unwrap();
        let text = crate::diagnose::report::sentences::finding(&refusal);
        assert!(
            text.contains("70 %") && text.contains("only 30 %"),
            "{text}"
        );
        let swings = AbstentionEvidence {
            inadequacy: None,
            vibration_gain: 2.0 * TRAIN_GAIN,
            ..rest(&["base_vibration"])
        };
        assert!(
            swings
                .first_refusal()
                .is_some_and(|f| f.kind == FindingKind::VibrationWithDisplacement)
        );
    }
}
