//! Scoring: what a diagnosis said against what was concealed, over many trials.

use super::truth::{Class, Truth};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Sizes from this on count as visible: below, abstaining is right.
pub const VISIBLE: f64 = 3.0;
/// Stated errors are good if the truth lies within this many of them.
pub const COVERED: f64 = 3.0;

/// The verdict of a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Nothing was left out.
    Adequate,
    /// The named effects were left out.
    MissingPhysics,
    /// Something is there that the catalogue does not carry.
    Unexplained,
}

/// A parameter as stated by a diagnosis, SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Id of the parameter.
    pub id: String,
    /// Its value.
    pub value: f64,
    /// Its standard error.
    pub std_error: f64,
}

/// An effect as named by a diagnosis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Named {
    /// Id in the catalogue.
    pub id: String,
    /// Stated probability.
    pub probability: f64,
    /// Ids it says it cannot be told apart from.
    pub confusion_group: Vec<String>,
    /// Its parameters.
    pub parameters: Vec<Estimate>,
}

/// Rms \[m\] and chi2 per value of a simulation against recordings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Misfit {
    /// Rms over the proof mass's channel \[m\].
    pub rms: f64,
    /// Chi2 per value.
    pub chi2: f64,
}

/// Misfit before and after the named effects were added.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BeforeAfter {
    /// The re-tuned baseline.
    pub before: Misfit,
    /// With the named effects.
    pub after: Misfit,
}

/// What a diagnosis says of a trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Diagnosis {
    /// Its verdict.
    pub verdict: Verdict,
    /// The effects it names, strongest first.
    pub named: Vec<Named>,
    /// On the recordings that were fitted.
    pub train: BeforeAfter,
    /// On those kept out.
    pub held_out: BeforeAfter,
}

/// How a diagnosis did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mark {
    /// The right answer: the effects and no other, or that nothing or something unknown
    /// is there.
    Right,
    /// Each missing name is in the group that was told beside a name given.
    Group,
    /// Some, not all, of two effects named, nothing wrong.
    Part,
    /// It named nothing where there was something to name.
    Abstained,
    /// It named what is not there.
    Wrong,
    /// It named an effect, or called something unexplained, where nothing was left out.
    FalseAlarm,
}

/// One trial's score.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Seed of the trial.
    pub seed: u64,
    /// Class of the trial.
    pub class: Class,
    /// What was concealed.
    pub concealed: Vec<String>,
    /// What was named.
    pub named: Vec<String>,
    /// Verdict given.
    pub verdict: Verdict,
    /// Size of the least visible concealed effect over the smallest visible; zero if
    /// nothing was concealed.
    pub size: f64,
    /// The mark.
    pub mark: Mark,
    /// Held-out rms of the proof mass over the noise, before and after.
    pub rms_over_noise: [f64; 2],
    /// Whether the held-out rms grew.
    pub grew: bool,
    /// Stated parameters that can be compared with the truth, and how many lie within
    /// [`COVERED`] of their standard errors.
    pub covered: [usize; 2],
}

/// Scores a diagnosis. `may_add` lists effects that may stand beside the right ones
/// without harm (a further mode where the device is a beam). `compare` gives the true
/// value of a parameter where the named effect has one: (effect, parameter) to SI.
#[must_use]
pub fn score(
    truth: &Truth,
    said: &Diagnosis,
    may_add: &[&str],
    compare: &dyn Fn(&str, &str) -> Option<f64>,
) -> Outcome {
    let concealed: Vec<String> = truth.effects.iter().map(|e| e.id.clone()).collect();
    let named: Vec<String> = said.named.iter().map(|n| n.id.clone()).collect();
    let mark = mark(truth.class, &concealed, said, may_add);
    let mut covered = [0, 0];
    if matches!(mark, Mark::Right) {
        for effect in &said.named {
            for estimate in &effect.parameters {
                if let Some(true_value) = compare(&effect.id, &estimate.id) {
                    covered[0] += 1;
                    let off = (estimate.value - true_value).abs();
                    covered[1] += usize::from(off <= COVERED * estimate.std_error);
                }
            }
        }
    }
    let noise = truth.instruments.noise;
    let held = &said.held_out;
    let smallest = truth
        .effects
        .iter()
        .map(|e| e.times_smallest_visible)
        .fold(f64::INFINITY, f64::min);
    Outcome {
        seed: truth.seed,
        class: truth.class,
        concealed,
        named,
        verdict: said.verdict,
        size: if smallest.is_finite() { smallest } else { 0.0 },
        mark,
        rms_over_noise: [held.before.rms / noise, held.after.rms / noise],
        grew: held.after.rms > held.before.rms,
        covered,
    }
}

fn mark(class: Class, concealed: &[String], said: &Diagnosis, may_add: &[&str]) -> Mark {
    let names: Vec<&Named> = said
        .named
        .iter()
        .filter(|n| concealed.contains(&n.id) || !may_add.contains(&n.id.as_str()))
        .collect();
    match class {
        Class::Nothing if names.is_empty() && said.verdict == Verdict::Adequate => Mark::Right,
        Class::Nothing if names.is_empty() && said.verdict == Verdict::MissingPhysics => {
            // Only what may be added was named.
            Mark::Right
        }
        Class::Nothing => Mark::FalseAlarm,
        Class::Outside if !names.is_empty() => Mark::Wrong,
        Class::Outside if said.verdict == Verdict::Unexplained => Mark::Right,
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

/// A share with its 95 % interval (Wilson).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// How many.
    pub count: usize,
    /// Of how many.
    pub of: usize,
    /// The interval.
    pub low: f64,
    /// The interval.
    pub high: f64,
}

impl Share {
    /// `count` of `of`; without any, the interval is all of 0 to 1.
    #[must_use]
    pub fn new(count: usize, of: usize) -> Self {
        if of == 0 {
            return Self {
                count,
                of,
                low: 0.0,
                high: 1.0,
            };
        }
        let (n, z2) = (of as f64, 1.959_964f64.powi(2));
        let p = count as f64 / n;
        let centre = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
        let half = (z2 * (p * (1.0 - p) / n + z2 / (4.0 * n * n))).sqrt() / (1.0 + z2 / n);
        Self {
            count,
            of,
            low: (centre - half).max(0.0),
            high: (centre + half).min(1.0),
        }
    }

    fn text(&self) -> String {
        if self.of == 0 {
            return "-".into();
        }
        format!(
            "{}/{} ({:.0} %, {:.0}-{:.0})",
            self.count,
            self.of,
            100.0 * self.count as f64 / self.of as f64,
            100.0 * self.low,
            100.0 * self.high
        )
    }
}

/// Marks of one kind of trials.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// What the trials have in common.
    pub label: String,
    /// How often each mark was given.
    pub marks: BTreeMap<Mark, Share>,
}

impl Row {
    fn new<'a>(label: impl Into<String>, outcomes: impl Iterator<Item = &'a Outcome>) -> Self {
        let all: Vec<Mark> = outcomes.map(|o| o.mark).collect();
        let marks = MARKS
            .map(|mark| {
                let count = all.iter().filter(|m| **m == mark).count();
                (mark, Share::new(count, all.len()))
            })
            .into();
        Self {
            label: label.into(),
            marks,
        }
    }
}

const MARKS: [Mark; 6] = [
    Mark::Right,
    Mark::Group,
    Mark::Part,
    Mark::Abstained,
    Mark::Wrong,
    Mark::FalseAlarm,
];

/// The score of many trials.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// By class; sizes from [`VISIBLE`] on.
    pub by_class: Vec<Row>,
    /// By effect, one concealed, sizes from [`VISIBLE`] on.
    pub by_effect: Vec<Row>,
    /// By size, one concealed.
    pub by_size: Vec<Row>,
    /// How often each answer was given to each single concealed effect (`nothing`,
    /// `unexplained` and `several` are answers).
    pub confusion: BTreeMap<String, BTreeMap<String, usize>>,
    /// Stated parameters within [`COVERED`] standard errors.
    pub coverage: Share,
    /// Trials whose held-out rms grew.
    pub grew: Share,
    /// Median held-out rms over noise before and after, where one effect was named right.
    pub median_rms_over_noise: Option<[f64; 2]>,
}

/// Gathers outcomes.
#[must_use]
pub fn aggregate(outcomes: &[Outcome]) -> Table {
    let visible = |o: &&Outcome| o.class == Class::Nothing || o.size >= VISIBLE;
    let classes = [
        (Class::Nothing, "nothing left out"),
        (Class::One, "one effect"),
        (Class::Two, "two effects"),
        (Class::Outside, "outside the catalogue"),
    ];
    let by_class = classes
        .map(|(class, label)| {
            let these = outcomes.iter().filter(|o| o.class == class).filter(visible);
            Row::new(label, these)
        })
        .into();
    let single: Vec<&Outcome> = outcomes.iter().filter(|o| o.concealed.len() == 1).collect();
    let mut ids: Vec<&str> = single.iter().map(|o| o.concealed[0].as_str()).collect();
    ids.sort_unstable();
    ids.dedup();
    let by_effect = ids
        .iter()
        .map(|id| {
            let these = single.iter().copied().filter(|o| o.concealed[0] == *id);
            Row::new(*id, these.filter(visible))
        })
        .collect();
    let bins = [0.0, 1.0, 3.0, 10.0, 30.0, f64::INFINITY];
    let by_size = bins
        .windows(2)
        .map(|w| {
            let inside = |o: &&&Outcome| o.class == Class::One && o.size >= w[0] && o.size < w[1];
            let label = format!("{} to {} x smallest visible", w[0], w[1]);
            Row::new(label, single.iter().filter(inside).copied())
        })
        .collect();
    let mut confusion: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for o in outcomes.iter().filter(|o| o.concealed.len() <= 1) {
        let row = o.concealed.first().map_or("nothing", String::as_str);
        let answer = match (o.named.as_slice(), o.verdict) {
            ([], Verdict::Unexplained) => "unexplained",
            ([], _) => "nothing",
            ([one], _) => one,
            _ => "several",
        };
        let cell = confusion.entry(row.to_owned()).or_default();
        *cell.entry(answer.to_owned()).or_default() += 1;
    }
    let sum = |k: usize| outcomes.iter().map(|o| o.covered[k]).sum();
    let right: Vec<&Outcome> = outcomes
        .iter()
        .filter(|o| o.class == Class::One && o.mark == Mark::Right)
        .collect();
    let median = |k: usize| {
        let mut all: Vec<f64> = right.iter().map(|o| o.rms_over_noise[k]).collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied()
    };
    Table {
        by_class,
        by_effect,
        by_size,
        confusion,
        coverage: Share::new(sum(1), sum(0)),
        grew: Share::new(outcomes.iter().filter(|o| o.grew).count(), outcomes.len()),
        median_rms_over_noise: median(0).zip(median(1)).map(|(a, b)| [a, b]),
    }
}

impl Table {
    /// The table for a terminal.
    #[must_use]
    pub fn text(&self) -> String {
        let mut out = String::new();
        let heads = [
            "right",
            "in group",
            "part",
            "abstained",
            "wrong",
            "false alarm",
        ];
        let sections = [
            ("class (from 3 x smallest visible)", &self.by_class),
            ("effect (from 3 x smallest visible)", &self.by_effect),
            ("size (one effect)", &self.by_size),
        ];
        // Writing to a String cannot fail.
        for (title, rows) in sections {
            let _ = write!(out, "{title:<36}");
            for head in heads {
                let _ = write!(out, "{head:>24}");
            }
            out.push('\n');
            for row in rows {
                let _ = write!(out, "{:<36}", row.label);
                for mark in MARKS {
                    let cell = row.marks.get(&mark).map_or_else(String::new, Share::text);
                    let _ = write!(out, "{cell:>24}");
                }
                out.push('\n');
            }
            out.push('\n');
        }
        let _ = writeln!(out, "concealed: answers");
        for (row, answers) in &self.confusion {
            let list: Vec<String> = answers.iter().map(|(a, n)| format!("{a} {n}")).collect();
            let _ = writeln!(out, "{row:<26}{}", list.join(", "));
        }
        let _ = writeln!(
            out,
            "\nparameters within {COVERED} standard errors: {}",
            self.coverage.text()
        );
        let _ = writeln!(out, "held-out rms grew: {}", self.grew.text());
        if let Some([before, after]) = self.median_rms_over_noise {
            let _ = writeln!(
                out,
                "median held-out rms over noise, one effect named right: {before:.2} before, {after:.2} after"
            );
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(verdict: Verdict, names: &[(&str, &[&str])]) -> Diagnosis {
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
            train: both,
            held_out: both,
        }
    }

    #[test]
    fn marks() {
        use Verdict::{Adequate, MissingPhysics as Missing, Unexplained};
        let one = ["sensor_lag".to_owned()];
        let two = ["sensor_lag".to_owned(), "gap_step".to_owned()];
        let of =
            |class, concealed: &[String], d: Diagnosis| mark(class, concealed, &d, &["extra_mode"]);
        assert_eq!(of(Class::Nothing, &[], said(Adequate, &[])), Mark::Right);
        assert_eq!(
            of(Class::Nothing, &[], said(Unexplained, &[])),
            Mark::FalseAlarm
        );
        let lag = ("sensor_lag", &[] as &[&str]);
        assert_eq!(
            of(Class::Nothing, &[], said(Missing, &[lag])),
            Mark::FalseAlarm
        );
        assert_eq!(of(Class::One, &one, said(Missing, &[lag])), Mark::Right);
        let mode = ("extra_mode", &[] as &[&str]);
        assert_eq!(
            of(Class::One, &one, said(Missing, &[lag, mode])),
            Mark::Right
        );
        let amplifier = ("amplifier_lag", &["sensor_lag"] as &[&str]);
        assert_eq!(
            of(Class::One, &one, said(Missing, &[amplifier])),
            Mark::Group
        );
        assert_eq!(
            of(Class::One, &one, said(Missing, &[lag, amplifier])),
            Mark::Wrong
        );
        assert_eq!(of(Class::One, &one, said(Adequate, &[])), Mark::Abstained);
        assert_eq!(of(Class::Two, &two, said(Missing, &[lag])), Mark::Part);
        assert_eq!(
            of(Class::Outside, &one, said(Unexplained, &[])),
            Mark::Right
        );
        assert_eq!(of(Class::Outside, &one, said(Missing, &[lag])), Mark::Wrong);
    }

    #[test]
    fn intervals_of_wilson() {
        // 8 of 10: 0.4902 to 0.9433 (Wilson 1927).
        let share = Share::new(8, 10);
        assert!((share.low - 0.4902).abs() < 1e-4 && (share.high - 0.9433).abs() < 1e-4);
    }
}
