//! Scoring: what a diagnosis reported against what was concealed, over many trials.

pub(crate) mod located;
pub(crate) mod parameters;
pub(crate) mod reported;
pub(crate) mod share;
pub(crate) mod table;

pub use self::parameters::{TrueValue, true_value};
pub use self::reported::{BeforeAfter, Diagnosis, Estimate, Misfit, Named, Place, Verdict};
pub use self::share::Share;
pub use self::table::{Row, Table, aggregate};

use serde::{Deserialize, Serialize};

use super::truth::{Class, Truth};
use located::located;

/// Sizes from this on count as visible: below, abstaining is right.
pub const VISIBLE: f64 = 3.0;
/// Stated errors are good if the truth lies within this many of them.
pub const COVERED: f64 = 3.0;

/// Effects that may be named in addition to those concealed: a `beam` has vibration modes without
/// end, of which the model has two.
#[must_use]
pub fn may_also_name(beam: bool) -> &'static [&'static str] {
    if beam { &["extra_mode"] } else { &[] }
}

/// How a diagnosis did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mark {
    /// The right answer: the effects and no other, or that nothing or something unknown
    /// is there.
    Right,
    /// Each missing name is in the group of indistinguishable effects of a name given.
    Group,
    /// Some, not all, of two effects named, nothing wrong.
    Part,
    /// It named nothing where there was something to name.
    Abstained,
    /// It named what is not there.
    Wrong,
    /// It named an effect, or called something unexplained, where nothing is concealed.
    FalseAlarm,
}

impl Mark {
    /// All, best first.
    pub const ALL: [Self; 6] = [
        Self::Right,
        Self::Group,
        Self::Part,
        Self::Abstained,
        Self::Wrong,
        Self::FalseAlarm,
    ];

    /// For people.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Group => "in group",
            Self::Part => "part",
            Self::Abstained => "abstained",
            Self::Wrong => "wrong",
            Self::FalseAlarm => "false alarm",
        }
    }
}

/// One trial's score.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Seed of the trial.
    pub seed: u64,
    /// Name of the rig; `None` for an actuator with the settings' own numbers.
    #[serde(default)]
    pub rig: Option<String>,
    /// Class of the trial.
    pub class: Class,
    /// Whether each recording was given the voltage of another: then the right answer
    /// names nothing.
    pub shuffled: bool,
    /// What was concealed.
    pub concealed: Vec<String>,
    /// What was named.
    pub named: Vec<String>,
    /// How many of the names are of effects that are not there and not allowed in addition.
    #[serde(default)]
    pub false_names: usize,
    /// Verdict given.
    pub verdict: Verdict,
    /// Size of the least visible concealed effect over the smallest visible; zero if
    /// nothing was concealed.
    pub size: f64,
    /// The mark.
    pub mark: Mark,
    /// The mark that an information criterion alone would have got; `None` where two
    /// effects were concealed, of which it names one at most.
    pub criterion_mark: Option<Mark>,
    /// Held-out rms of the proof mass over the noise, before and after.
    pub rms_over_noise: [f64; 2],
    /// Whether the held-out rms grew.
    pub grew: bool,
    /// Stated parameters against the truth, where the names are right.
    pub coverage: Coverage,
    /// Share of the reported mismatch that lies where the concealed effects act; `None`
    /// where they act everywhere, or nothing is reported.
    pub located: Option<f64>,
    /// Time of the diagnosis \[s\]; zero if it was not taken.
    #[serde(default)]
    pub seconds: f64,
}

/// Stated parameters against the truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Coverage {
    /// Parameters that can be compared.
    pub compared: usize,
    /// How many lie within [`COVERED`] of their standard errors.
    pub within: usize,
    /// The same where what the instruments conceal counts as error too.
    pub within_with_rig: usize,
}

/// Scores a diagnosis. `may_add` lists effects that may be named together with the right ones
/// without harm (a further mode where the device is a beam).
#[must_use]
pub fn score(truth: &Truth, reported: &Diagnosis, may_add: &[&str]) -> Outcome {
    let reported = &as_concealed(truth, reported);
    let concealed: Vec<String> = truth.effects.iter().map(|e| e.id.clone()).collect();
    let named: Vec<String> = reported.named.iter().map(|n| n.id.clone()).collect();
    let mark = mark(truth.class, &concealed, reported, may_add);
    let coverage = if mark == Mark::Right {
        coverage(truth, reported)
    } else {
        Coverage::default()
    };
    let noise = truth.noise();
    let is_false = |id: &&String| !concealed.contains(id) && !may_add.contains(&id.as_str());
    let false_names = named.iter().filter(is_false).count();
    let concealed_ids = concealed.clone();
    let held = &reported.held_out;
    let smallest = truth
        .effects
        .iter()
        .map(|e| e.times_smallest_visible)
        .fold(f64::INFINITY, f64::min);
    Outcome {
        seed: truth.seed,
        rig: truth.rig.clone(),
        class: truth.class,
        shuffled: false,
        concealed,
        named,
        false_names,
        verdict: reported.verdict,
        size: if smallest.is_finite() { smallest } else { 0.0 },
        mark,
        criterion_mark: criterion_mark(truth.class, &concealed_ids, reported, may_add),
        rms_over_noise: [held.before.rms / noise, held.after.rms / noise],
        grew: held.after.rms > held.before.rms,
        coverage,
        located: located(truth, &reported.places),
        seconds: 0.0,
    }
}

/// What was reported, with names that say the same as what is concealed replaced by its own.
fn as_concealed(truth: &Truth, reported: &Diagnosis) -> Diagnosis {
    let own = |id: &String| {
        let same = truth.effects.iter().find(|e| e.same_as.contains(id));
        same.map_or_else(|| id.clone(), |e| e.id.clone())
    };
    let mut reported = reported.clone();
    for effect in &mut reported.named {
        effect.id = own(&effect.id);
        effect.confusion_group = effect.confusion_group.iter().map(&own).collect();
    }
    // Both names of one effect are one name.
    let mut seen = std::collections::BTreeSet::new();
    reported
        .named
        .retain(|effect| seen.insert(effect.id.clone()));
    reported.by_criterion = reported.by_criterion.as_ref().map(own);
    reported
}

/// Scores a diagnosis of recordings with exchanged voltages: right if nothing is named.
#[must_use]
pub fn score_shuffled(truth: &Truth, reported: &Diagnosis) -> Outcome {
    Outcome {
        shuffled: true,
        mark: if reported.named.is_empty() {
            Mark::Right
        } else {
            Mark::Wrong
        },
        coverage: Coverage::default(),
        false_names: reported.named.len(),
        located: None,
        ..score(truth, reported, &[])
    }
}

/// The mark of an information criterion alone. It has no word for what the catalogue does
/// not hold: naming nothing is right there.
fn criterion_mark(
    class: Class,
    concealed: &[String],
    reported: &Diagnosis,
    may_add: &[&str],
) -> Option<Mark> {
    let name = reported
        .by_criterion
        .as_ref()
        .filter(|id| concealed.contains(id) || !may_add.contains(&id.as_str()));
    match (class, name) {
        (Class::Two, _) => None,
        (Class::Nothing | Class::Outside, None) => Some(Mark::Right),
        (Class::Nothing, Some(_)) => Some(Mark::FalseAlarm),
        (Class::Outside, Some(_)) => Some(Mark::Wrong),
        (Class::One, None) => Some(Mark::Abstained),
        (Class::One, Some(id)) if concealed.contains(id) => Some(Mark::Right),
        (Class::One, Some(_)) => Some(Mark::Wrong),
    }
}

fn coverage(truth: &Truth, reported: &Diagnosis) -> Coverage {
    let mut coverage = Coverage::default();
    for effect in &reported.named {
        for estimate in &effect.parameters {
            let Some(real) = true_value(truth, effect, &estimate.id) else {
                continue;
            };
            // One that says of itself that it does not know is no statement.
            if !estimate.std_error.is_finite() {
                continue;
            }
            let off = (estimate.value - real.value).abs();
            let room = COVERED * estimate.std_error;
            coverage.compared += 1;
            coverage.within += usize::from(off <= room);
            coverage.within_with_rig += usize::from(off <= room + real.instrument_bias);
        }
    }
    coverage
}

fn mark(class: Class, concealed: &[String], reported: &Diagnosis, may_add: &[&str]) -> Mark {
    let names: Vec<&Named> = reported
        .named
        .iter()
        .filter(|n| concealed.contains(&n.id) || !may_add.contains(&n.id.as_str()))
        .collect();
    match class {
        Class::Nothing if names.is_empty() && reported.verdict == Verdict::Adequate => Mark::Right,
        // Only what may be added was named.
        Class::Nothing
            if names.is_empty()
                && (reported.verdict == Verdict::MissingPhysics || !reported.named.is_empty()) =>
        {
            Mark::Right
        }
        Class::Nothing => Mark::FalseAlarm,
        // Names count as names, whatever is said to remain. One that says the same as the law
        // has its id here.
        Class::Outside if !names.is_empty() => {
            if names.iter().all(|n| concealed.contains(&n.id)) {
                Mark::Right
            } else {
                Mark::Wrong
            }
        }
        Class::Outside
            if matches!(
                reported.verdict,
                Verdict::Unexplained | Verdict::PartlyExplained
            ) =>
        {
            Mark::Right
        }
        Class::Outside => Mark::Abstained,
        Class::One | Class::Two => {
            if names.is_empty() {
                return Mark::Abstained;
            }
            let given = |id: &String| names.iter().any(|n| n.id == *id);
            let hinted =
                |id: &String| given(id) || names.iter().any(|n| n.confusion_group.contains(id));
            // A name is excused if its own group holds an effect that is there.
            let excused = |n: &&Named| {
                concealed.contains(&n.id)
                    || n.confusion_group
                        .iter()
                        .any(|g| concealed.contains(g) && !given(g))
            };
            let clean = names.iter().all(|n| concealed.contains(&n.id));
            if clean && concealed.iter().all(given) {
                Mark::Right
            } else if !names.iter().all(excused) {
                Mark::Wrong
            } else if concealed.iter().all(hinted) {
                Mark::Group
            } else {
                Mark::Part
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::score::*;

    fn reported(verdict: Verdict, names: &[(&str, &[&str])]) -> Diagnosis {
        let misfit = |rms| Misfit { rms, chi2: 1.0 };
        let both = BeforeAfter {
            before: misfit(4e-8),
            after: misfit(2e-8),
        };
        Diagnosis {
            verdict,
            named: names
                .iter()
                .map(|(id, group)| Named {
                    id: (*id).into(),
                    probability: 0.9,
                    confusion_group: group.iter().map(|g| (*g).to_owned()).collect(),
                    parameters: Vec::new(),
                })
                .collect(),
            places: Vec::new(),
            train: both,
            held_out: both,
            by_criterion: names.first().map(|(id, _)| (*id).to_owned()),
        }
    }

    #[test]
    fn a_name_counts_whatever_the_verdict() {
        use super::reported::Verdict::{MissingPhysics, PartlyExplained};
        let one = ["sensor_lag".to_owned()];
        let lag = ("sensor_lag", &[] as &[&str]);
        let drag = ("quadratic_drag", &[] as &[&str]);
        for verdict in [MissingPhysics, PartlyExplained] {
            let of = |class, concealed: &[String], name| {
                mark(class, concealed, &reported(verdict, &[name]), &[])
            };
            assert_eq!(of(Class::One, &one, lag), Mark::Right);
            assert_eq!(of(Class::One, &one, drag), Mark::Wrong);
            assert_eq!(of(Class::Nothing, &[], lag), Mark::FalseAlarm);
            assert_eq!(of(Class::Outside, &one, drag), Mark::Wrong);
        }
        let nothing = reported(PartlyExplained, &[]);
        assert_eq!(mark(Class::Nothing, &[], &nothing, &[]), Mark::FalseAlarm);
        assert_eq!(mark(Class::Outside, &one, &nothing, &[]), Mark::Right);
    }

    #[test]
    fn a_name_that_says_the_same_is_right_and_others_are_false() {
        use super::reported::Verdict::MissingPhysics;
        let settings = crate::trial::Settings {
            mix: crate::trial::Mix::Effect("sine_stiffness".into()),
            ..crate::trial::Settings::of_rig("pendulum")
        };
        let truth = crate::trial::Case::draw(5, &settings).unwrap();
        let truth = truth.truth();
        let of = |names: &[(&str, &[&str])]| score(truth, &reported(MissingPhysics, names), &[]);
        for names in [
            &[("sine_stiffness", &[] as &[&str])][..],
            &[("cubic_stiffness", &[])],
            &[("cubic_stiffness", &[]), ("sine_stiffness", &[])],
        ] {
            let outcome = of(names);
            assert_eq!((outcome.mark, outcome.false_names), (Mark::Right, 0));
            assert_eq!(outcome.rig.as_deref(), Some("pendulum"));
        }
        let outcome = of(&[("cubic_stiffness", &[]), ("dry_friction", &[])]);
        assert_eq!((outcome.mark, outcome.false_names), (Mark::Wrong, 1));
    }

    #[test]
    fn marks() {
        use super::reported::Verdict::{Adequate, MissingPhysics as Missing, Unexplained};
        let one = ["sensor_lag".to_owned()];
        let two = ["sensor_lag".to_owned(), "gap_step".to_owned()];
        let of =
            |class, concealed: &[String], d: Diagnosis| mark(class, concealed, &d, &["extra_mode"]);
        assert_eq!(
            of(Class::Nothing, &[], reported(Adequate, &[])),
            Mark::Right
        );
        assert_eq!(
            of(Class::Nothing, &[], reported(Unexplained, &[])),
            Mark::FalseAlarm
        );
        let lag = ("sensor_lag", &[] as &[&str]);
        assert_eq!(
            of(Class::Nothing, &[], reported(Missing, &[lag])),
            Mark::FalseAlarm
        );
        assert_eq!(of(Class::One, &one, reported(Missing, &[lag])), Mark::Right);
        let mode = ("extra_mode", &[] as &[&str]);
        assert_eq!(
            of(Class::One, &one, reported(Missing, &[lag, mode])),
            Mark::Right
        );
        let amplifier = ("amplifier_lag", &["sensor_lag"] as &[&str]);
        assert_eq!(
            of(Class::One, &one, reported(Missing, &[amplifier])),
            Mark::Group
        );
        assert_eq!(
            of(Class::One, &one, reported(Missing, &[lag, amplifier])),
            Mark::Wrong
        );
        assert_eq!(
            of(Class::One, &one, reported(Adequate, &[])),
            Mark::Abstained
        );
        assert_eq!(of(Class::Two, &two, reported(Missing, &[lag])), Mark::Part);
        assert_eq!(
            of(Class::Outside, &one, reported(Unexplained, &[])),
            Mark::Right
        );
        assert_eq!(
            of(Class::Outside, &two[1..], reported(Missing, &[lag])),
            Mark::Wrong
        );
        assert_eq!(
            of(Class::Outside, &one, reported(Missing, &[lag])),
            Mark::Right
        );
        let alone = |class, concealed: &[String], d: &Diagnosis| {
            criterion_mark(class, concealed, d, &["extra_mode"])
        };
        let named = reported(Missing, &[lag]);
        assert_eq!(alone(Class::One, &one, &named), Some(Mark::Right));
        assert_eq!(alone(Class::Nothing, &[], &named), Some(Mark::FalseAlarm));
        assert_eq!(alone(Class::Two, &two, &named), None);
        let mode = reported(Missing, &[mode]);
        assert_eq!(alone(Class::One, &one, &mode), Some(Mark::Abstained));
    }
}
