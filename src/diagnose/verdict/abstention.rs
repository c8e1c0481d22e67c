//! Whether names that were found are refused for what they leave.

use crate::diagnose::diagnosis::Inadequacy;
use crate::diagnose::thresholds::{
    FRICTION_BY_HEIGHT_LIMITS, LONG_RANGE_DECAY, MIN_CARRIED_SHARE, MIN_FORM_SHARE,
    NEGLIGIBLE_SHARE, PRODUCT_FORCE_LIMITS, TRAIN_GAIN,
};
use crate::model::Model;
use crate::model::effects::EffectSpec;

/// Laws of which the force hangs on the displacement more than on anything else.
const OF_DISPLACEMENT: [&str; 3] = ["cubic_stiffness", "long_range_attraction", "electrostatic"];

/// Whether the force of a law hangs on the displacement more than on anything else.
pub fn of_displacement(spec: &&'static EffectSpec) -> bool {
    OF_DISPLACEMENT.contains(&spec.id)
}

/// Whether an attraction acts far beyond the last micrometres before touch.
pub fn attraction_reaches_far(model: &Model) -> bool {
    let of = |parameter: &str| model.get(&format!("long_range_attraction.{parameter}"));
    let reach = of("h0").zip(of("n"));
    reach.is_some_and(|(h0, n)| h0 > LONG_RANGE_DECAY * n)
}

/// What the effects named leave.
#[derive(Debug, Clone)]
pub struct AbstentionEvidence {
    /// What is not explained yet.
    pub left: Option<Inadequacy>,
    /// Names of the effects.
    pub names: Vec<&'static str>,
    /// Those of displacement.
    pub displaced: Vec<&'static EffectSpec>,
    /// Whether an attraction among them reaches far.
    pub far: bool,
    /// Whether the strongest force that is left goes over the displacement.
    pub over_xp: bool,
    /// Fall of chi2 by forces without a name.
    pub joint: f64,
    /// The part of it that laws of somewhat other form would bring.
    pub formal: f64,
    /// Fall of chi2 by what swings steadily.
    pub swings: f64,
    /// Fall of chi2 by friction that goes with the height, and by the dry friction beside it.
    pub rubs: (f64, f64),
    /// Fall of chi2 by a force by the product of both displacements, and by the laws of
    /// displacement beside it.
    pub product: (f64, f64),
    /// Share of what was missing that the effects carry.
    pub share: f64,
    /// The same of stretches each by itself.
    pub explained: f64,
}

impl AbstentionEvidence {
    /// Why the names are refused, if they are.
    pub fn refusal(&self) -> Option<String> {
        if self.swings > TRAIN_GAIN {
            return Some("what swings steadily grows with the displacement, as no vibration of the base does: a stiffness that comes and goes is not in the catalogue".to_owned());
        }
        if self.goes_with_both() {
            return Some("what is missing goes with both displacements, as no force over that of the mass does: that is not in the catalogue".to_owned());
        }
        self.left?;
        if exceeds(self.rubs, FRICTION_BY_HEIGHT_LIMITS) {
            return Some("what rubs does so more at some heights than at others, as no dry friction does: a friction that goes with the load is not in the catalogue".to_owned());
        }
        let names = |specs: &[&EffectSpec]| {
            let all: Vec<&str> = specs.iter().map(|s| s.name).collect();
            all.join(" and ")
        };
        // A single stretch that is off says nothing of a force.
        let force = matches!(self.left, Some(Inadequacy::Mean(_) | Inadequacy::Force(..)));
        if force && (self.one_law_in_two() || self.another_law()) {
            return Some(format!(
                "{} would stand for one force over the displacement and still leave something of it: that is rather one law which is not in the catalogue",
                names(&self.displaced)
            ));
        }
        if self.share < MIN_CARRIED_SHARE {
            // Chi2 of stretches each by itself may fall where the whole stays as wrong.
            let unbroken = if self.share < self.explained {
                ", but the flight would go on no better from one stretch to the next"
            } else {
                ""
            };
            return Some(format!(
                "{} would explain {:.0} % of what is missing{unbroken}: too little for a name",
                self.names.join(" and "),
                100.0 * self.explained
            ));
        }
        None
    }

    /// Whether a force by both displacements is left that laws over the stroke stand for.
    pub fn goes_with_both(&self) -> bool {
        self.over_stroke() > 0 && exceeds(self.product, PRODUCT_FORCE_LIMITS)
    }

    /// Laws over the stroke. An attraction that acts at touch alone is none.
    fn over_stroke(&self) -> usize {
        let over = |s: &&&EffectSpec| self.far || s.id != "long_range_attraction";
        self.displaced.iter().filter(over).count()
    }

    /// Whether two laws over the stroke stand for one.
    fn one_law_in_two(&self) -> bool {
        self.over_stroke() > 1
    }

    /// Whether what is left over the displacement is not a matter of the form of the one law
    /// of displacement, for that leaves what its kin carry.
    fn another_law(&self) -> bool {
        let other = self.far || self.formal < MIN_FORM_SHARE * self.joint;
        let much = self.explained < 1.0 - NEGLIGIBLE_SHARE;
        much && self.displaced.len() == 1 && self.over_xp && other
    }
}

/// Whether what a law brings beside others, and they, is more than that, and than that share.
fn exceeds((gain, beside): (f64, f64), (least, share): (f64, f64)) -> bool {
    gain > least && gain > share * beside
}

#[cfg(test)]
mod tests {
    use super::super::abstention::*;
    use crate::model::effects::find;

    /// `ids` named, a force over the displacement left.
    fn rest(ids: &[&str]) -> AbstentionEvidence {
        let specs = ids.iter().map(|id| find(id).unwrap());
        AbstentionEvidence {
            left: Some(Inadequacy::Force("xp", 180.0)),
            names: specs.clone().map(|s| s.name).collect(),
            displaced: specs.filter(of_displacement).collect(),
            far: false,
            over_xp: true,
            joint: 180.0,
            formal: 170.0,
            swings: 0.0,
            rubs: (0.0, 0.0),
            product: (0.0, 0.0),
            share: 0.98,
            explained: 0.98,
        }
    }

    #[test]
    fn two_laws_over_the_stroke_are_refused_for_what_they_leave() {
        let two = rest(&["cubic_stiffness", "electrostatic"]);
        assert!(two.refusal().unwrap().contains("one force"));
        let left = |left| AbstentionEvidence {
            left,
            ..two.clone()
        };
        assert_eq!(left(None).refusal(), None);
        assert_eq!(left(Some(Inadequacy::Stretch(9.0))).refusal(), None);
        assert!(left(Some(Inadequacy::Mean(1.3))).refusal().is_some());
    }

    #[test]
    fn an_attraction_at_touch_is_no_law_over_the_stroke() {
        let near = rest(&["cubic_stiffness", "long_range_attraction"]);
        assert_eq!(near.refusal(), None);
        let far = AbstentionEvidence { far: true, ..near };
        assert!(far.refusal().is_some());
    }

    #[test]
    fn one_law_is_refused_where_its_kin_do_not_carry_the_rest() {
        let one = rest(&["cubic_stiffness", "sensor_lag"]);
        assert_eq!(one.refusal(), None);
        let formal = |formal| AbstentionEvidence {
            formal,
            ..one.clone()
        };
        assert!(formal(100.0).refusal().is_some());
        assert!(formal(157.0).refusal().is_some());
        assert_eq!(formal(162.0).refusal(), None);
        let stretch = AbstentionEvidence {
            left: Some(Inadequacy::Stretch(12.0)),
            ..formal(100.0)
        };
        assert_eq!(stretch.refusal(), None);
        let little = AbstentionEvidence {
            explained: 0.999,
            ..formal(100.0)
        };
        assert_eq!(little.refusal(), None);
        let elsewhere = AbstentionEvidence {
            over_xp: false,
            ..formal(100.0)
        };
        assert_eq!(elsewhere.refusal(), None);
    }

    #[test]
    fn a_friction_that_goes_with_the_height_is_no_dry_one() {
        let of = |rubs| AbstentionEvidence {
            rubs,
            over_xp: false,
            ..rest(&["dry_friction"])
        };
        assert!(of((900.0, 2e4)).refusal().unwrap().contains("rubs"));
        // A small share is a matter of the form of the law, and little is chance.
        assert!(of((410.0, 2e4)).refusal().is_some());
        assert_eq!(of((390.0, 2e4)).refusal(), None);
        assert_eq!(of((30.0, 200.0)).refusal(), None);
        let all_told = AbstentionEvidence {
            left: None,
            ..of((900.0, 2e4))
        };
        assert_eq!(all_told.refusal(), None);
    }

    #[test]
    fn a_force_by_both_displacements_is_no_stiffness() {
        let of = |product| AbstentionEvidence {
            left: None,
            product,
            ..rest(&["cubic_stiffness"])
        };
        assert!(of((210.0, 2e4)).refusal().unwrap().contains("both"));
        assert_eq!(of((190.0, 2e4)).refusal(), None);
        assert_eq!(of((20.0, 200.0)).refusal(), None);
        let at_touch = AbstentionEvidence {
            product: (900.0, 2e4),
            left: None,
            ..rest(&["long_range_attraction"])
        };
        assert_eq!(at_touch.refusal(), None);
    }

    #[test]
    fn too_small_a_share_and_what_swings_are_refused() {
        let little = AbstentionEvidence {
            share: 0.5,
            explained: 0.7,
            ..rest(&["sensor_lag"])
        };
        let said = little.refusal().unwrap();
        assert!(
            said.contains("70 %") && said.contains("go on no better"),
            "{said}"
        );
        let swings = AbstentionEvidence {
            left: None,
            swings: 2.0 * TRAIN_GAIN,
            ..rest(&["base_vibration"])
        };
        assert!(swings.refusal().unwrap().contains("swings"));
    }
}
