//! The score of many trials.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::{Deserialize, Serialize};

use super::reported::Verdict;
use super::share::Share;
use super::{COVERED, Coverage, Mark, Outcome, VISIBLE};
use crate::trial::rigs::RIGS;
use crate::trial::truth::Class;

/// Marks of one kind of trials.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// What the trials have in common.
    pub label: String,
    /// How often each mark was given.
    pub marks: BTreeMap<Mark, Share>,
    /// Names of effects that are not there, over all these trials.
    #[serde(default)]
    pub false_names: usize,
    /// How often the verdict was that nothing is missing.
    #[serde(default)]
    pub adequate: usize,
    /// How often the verdict was that the names explain a part.
    #[serde(default)]
    pub partly_explained: usize,
    /// Time of a diagnosis \[s\], median and worst; `None` where it was not taken.
    #[serde(default)]
    pub seconds: Option<[f64; 2]>,
}

impl Row {
    fn new<'a>(label: impl Into<String>, outcomes: impl Iterator<Item = &'a Outcome>) -> Self {
        let these: Vec<&Outcome> = outcomes.collect();
        let count = |verdict| these.iter().filter(|o| o.verdict == verdict).count();
        let timed = || these.iter().map(|o| o.seconds).filter(|s| *s > 0.0);
        Self {
            false_names: these.iter().map(|o| o.false_names).sum(),
            adequate: count(Verdict::Adequate),
            partly_explained: count(Verdict::PartlyExplained),
            seconds: median(timed()).map(|middle| [middle, timed().fold(0.0, f64::max)]),
            ..Self::of(label, these.iter().map(|o| o.mark))
        }
    }

    /// A row of marks alone.
    fn of(label: impl Into<String>, marks: impl Iterator<Item = Mark>) -> Self {
        let all: Vec<Mark> = marks.collect();
        let marks = Mark::ALL
            .map(|mark| {
                let count = all.iter().filter(|m| **m == mark).count();
                (mark, Share::new(count, all.len()))
            })
            .into();
        Self {
            label: label.into(),
            marks,
            false_names: 0,
            adequate: 0,
            partly_explained: 0,
            seconds: None,
        }
    }

    fn is_empty(&self) -> bool {
        self.marks.values().all(|share| share.of == 0)
    }
}

/// The score of many trials.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// By rig: all trials, and of those the ones with a nameable effect, with nothing and with
    /// something outside the catalogue; sizes from [`VISIBLE`] on.
    #[serde(default)]
    pub by_rig: Vec<Row>,
    /// By class; sizes from [`VISIBLE`] on.
    pub by_class: Vec<Row>,
    /// By effect, one concealed, sizes from [`VISIBLE`] on.
    pub by_effect: Vec<Row>,
    /// By size, one concealed, and two by the smaller of them.
    pub by_size: Vec<Row>,
    /// The same by class for an information criterion alone, as a control.
    pub by_criterion: Vec<Row>,
    /// How often each answer was given to each single concealed effect (`nothing`,
    /// `unexplained` and `several` are answers).
    pub confusion: BTreeMap<String, BTreeMap<String, usize>>,
    /// Stated parameters within [`COVERED`] standard errors.
    pub coverage: Share,
    /// The same where what the instruments conceal from any diagnosis counts as error too.
    pub coverage_with_rig: Share,
    /// Median share of the reported mismatch that lies where the effect acts, over trials
    /// of effects that act at some places only.
    pub median_located: Option<f64>,
    /// Trials whose held-out rms grew.
    pub grew: Share,
    /// Median held-out rms over noise before and after, where one effect was named right.
    pub median_rms_over_noise: Option<[f64; 2]>,
}

/// Whether a trial counts as one in which something can be seen, if anything is there.
fn visible(o: &&Outcome) -> bool {
    o.class == Class::Nothing || o.size >= VISIBLE
}

/// Rows of each rig, in the order of first appearance in the list of rigs.
fn by_rig(plain: &[&Outcome]) -> Vec<Row> {
    let of_settings = "as set";
    let rig = |o: &Outcome| o.rig.clone().unwrap_or_else(|| of_settings.to_owned());
    let known = RIGS.into_iter().map(|rig| rig.id).chain([of_settings]);
    let kinds: [(&str, &[Class]); 3] = [
        ("one or two", &[Class::One, Class::Two]),
        ("nothing", &[Class::Nothing]),
        ("outside", &[Class::Outside]),
    ];
    let mut rows = Vec::new();
    for name in known {
        let own: Vec<&Outcome> = (plain.iter().copied())
            .filter(|o| rig(o) == name)
            .filter(visible)
            .collect();
        if own.is_empty() {
            continue;
        }
        rows.push(Row::new(name, own.iter().copied()));
        for (kind, classes) in kinds {
            let these = own.iter().copied().filter(|o| classes.contains(&o.class));
            let row = Row::new(format!("  {kind}"), these);
            if !row.is_empty() {
                rows.push(row);
            }
        }
    }
    rows
}

/// Rows by the size of the smaller effect, of one and of two.
fn by_size(plain: &[&Outcome]) -> Vec<Row> {
    let bins = [0.0, 1.0, 3.0, 10.0, 30.0, f64::INFINITY];
    let mut rows = Vec::new();
    for (class, prefix) in [(Class::One, ""), (Class::Two, "two, ")] {
        for w in bins.windows(2) {
            let inside = |o: &&Outcome| o.class == class && o.size >= w[0] && o.size < w[1];
            let label = format!("{prefix}{} to {} x smallest visible", w[0], w[1]);
            let row = Row::new(label, plain.iter().copied().filter(inside));
            if class == Class::One || !row.is_empty() {
                rows.push(row);
            }
        }
    }
    rows
}

/// How often each answer was given to each single concealed effect.
fn confusion(plain: &[&Outcome]) -> BTreeMap<String, BTreeMap<String, usize>> {
    let mut confusion: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for o in plain.iter().copied().filter(|o| o.concealed.len() <= 1) {
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
    confusion
}

/// Gathers outcomes; those with exchanged voltages count in a row of their own only.
#[must_use]
pub fn aggregate(outcomes: &[Outcome]) -> Table {
    let (shuffled, plain): (Vec<&Outcome>, Vec<&Outcome>) =
        outcomes.iter().partition(|o| o.shuffled);
    let classes = [
        (Class::Nothing, "nothing left out"),
        (Class::One, "one effect"),
        (Class::Two, "two effects"),
        (Class::Outside, "outside the catalogue"),
    ];
    let by_class = classes
        .map(|(class, label)| {
            let these = plain.iter().copied().filter(|o| o.class == class);
            Row::new(label, these.filter(visible))
        })
        .into_iter()
        .chain(
            (!shuffled.is_empty())
                .then(|| Row::new("voltages exchanged", shuffled.iter().copied())),
        )
        .collect();
    let by_criterion = classes
        .into_iter()
        .filter(|(class, _)| *class != Class::Two)
        .map(|(class, label)| {
            let these = plain.iter().copied().filter(|o| o.class == class);
            Row::of(
                label,
                these.filter(visible).filter_map(|o| o.criterion_mark),
            )
        })
        .collect();
    let single: Vec<&Outcome> = plain
        .iter()
        .copied()
        .filter(|o| o.concealed.len() == 1)
        .collect();
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
    let by_size = by_size(&plain);
    let confusion = confusion(&plain);
    let sum = |f: fn(&Coverage) -> usize| plain.iter().copied().map(|o| f(&o.coverage)).sum();
    let compared = sum(|c| c.compared);
    let right: Vec<&Outcome> = outcomes
        .iter()
        .filter(|o| o.class == Class::One && o.mark == Mark::Right)
        .collect();
    let rms = |k: usize| median(right.iter().map(|o| o.rms_over_noise[k]));
    Table {
        by_rig: by_rig(&plain),
        by_class,
        by_effect,
        by_size,
        by_criterion,
        confusion,
        coverage: Share::new(sum(|c| c.within), compared),
        coverage_with_rig: Share::new(sum(|c| c.within_with_rig), compared),
        median_located: median(
            plain
                .iter()
                .copied()
                .filter(visible)
                .filter_map(|o| o.located),
        ),
        grew: Share::new(plain.iter().filter(|o| o.grew).count(), plain.len()),
        median_rms_over_noise: rms(0).zip(rms(1)).map(|(a, b)| [a, b]),
    }
}

/// Width of a mark's column.
fn width(mark: Mark) -> usize {
    if mark == Mark::Right { 26 } else { 12 }
}

/// Columns behind the marks, with their widths.
const FURTHER_COLUMNS: [(&str, usize); 5] = [
    ("false names", 13),
    ("adequate", 10),
    ("partly", 8),
    ("median s", 10),
    ("worst s", 9),
];

/// What stands in those columns; a row of marks alone has nothing there.
fn further_cells(row: &Row) -> [String; FURTHER_COLUMNS.len()] {
    let count = |n: usize| {
        if n > 0 { n.to_string() } else { "-".to_owned() }
    };
    let time = |which: usize| {
        row.seconds
            .map_or_else(|| "-".to_owned(), |s| format!("{:.1}", s[which]))
    };
    [
        count(row.false_names),
        count(row.adequate),
        count(row.partly_explained),
        time(0),
        time(1),
    ]
}

/// The middle value, the upper one of two.
fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut all: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied()
}

impl Table {
    /// The table for a terminal.
    #[must_use]
    pub fn text(&self) -> String {
        let mut out = String::new();
        let sections = [
            ("rig (from 3 x smallest visible)", &self.by_rig),
            ("class (from 3 x smallest visible)", &self.by_class),
            ("effect (from 3 x smallest visible)", &self.by_effect),
            ("size (one effect, two effects)", &self.by_size),
            ("an information criterion alone", &self.by_criterion),
        ];
        // Writing to a String cannot fail.
        for (title, rows) in sections {
            let _ = write!(out, "{title:<36}");
            for mark in Mark::ALL {
                let width = width(mark);
                let _ = write!(out, "{:>width$}", mark.text());
            }
            for (title, width) in FURTHER_COLUMNS {
                let _ = write!(out, "{title:>width$}");
            }
            out.push('\n');
            for row in rows {
                let _ = write!(out, "{:<36}", row.label);
                for mark in Mark::ALL {
                    // The interval of the share that matters; of the others the number.
                    let cell = match row.marks.get(&mark) {
                        Some(share) if mark == Mark::Right => share.text(),
                        Some(share) if share.count > 0 => share.count.to_string(),
                        _ => "-".to_owned(),
                    };
                    let width = width(mark);
                    let _ = write!(out, "{cell:>width$}");
                }
                for (cell, (_, width)) in further_cells(row).iter().zip(FURTHER_COLUMNS) {
                    let _ = write!(out, "{cell:>width$}");
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
            "\nparameters within {COVERED} standard errors: {}; allowing for the instruments' errors: {}",
            self.coverage.text(),
            self.coverage_with_rig.text()
        );
        if let Some(located) = self.median_located {
            let _ = writeln!(
                out,
                "reported mismatch that lies where the effect acts, median: {:.0} %",
                100.0 * located
            );
        }
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
    use super::super::table::*;

    fn outcome(rig: &str, class: Class, mark: Mark, seconds: f64) -> Outcome {
        Outcome {
            seed: 1,
            rig: Some(rig.to_owned()),
            class,
            shuffled: false,
            concealed: match class {
                Class::Nothing => Vec::new(),
                Class::Two => vec!["gap_step".into(), "dry_friction".into()],
                _ => vec!["dry_friction".into()],
            },
            named: Vec::new(),
            false_names: usize::from(matches!(mark, Mark::Wrong | Mark::FalseAlarm)),
            verdict: match mark {
                Mark::Abstained => Verdict::Adequate,
                Mark::Wrong => Verdict::PartlyExplained,
                _ => Verdict::MissingPhysics,
            },
            size: if class == Class::Nothing { 0.0 } else { 12.0 },
            mark,
            criterion_mark: None,
            rms_over_noise: [2.0, 1.0],
            grew: false,
            coverage: Coverage::default(),
            located: None,
            seconds,
        }
    }

    #[test]
    fn rigs_have_rows_with_false_names_and_times() {
        let outcomes = [
            outcome("spring", Class::One, Mark::Right, 2.0),
            outcome("spring", Class::Two, Mark::Wrong, 5.0),
            outcome("spring", Class::Nothing, Mark::FalseAlarm, 3.0),
            outcome("both-points", Class::One, Mark::Abstained, 7.0),
        ];
        let table = aggregate(&outcomes);
        let labels: Vec<&str> = table.by_rig.iter().map(|r| r.label.as_str()).collect();
        let expected = [
            "both-points",
            "  one or two",
            "spring",
            "  one or two",
            "  nothing",
        ];
        assert_eq!(labels, expected);
        let spring = &table.by_rig[2];
        assert_eq!((spring.false_names, spring.partly_explained), (2, 1));
        assert_eq!(spring.seconds, Some([3.0, 5.0]));
        assert_eq!(table.by_rig[0].adequate, 1);
        let right = table.by_rig[3].marks[&Mark::Right];
        assert_eq!((right.count, right.of), (1, 2));
        // Two effects have rows of their own by size.
        let two = table.by_size.last().unwrap();
        assert!(two.label.starts_with("two, 10 to 30"), "{}", two.label);
        assert_eq!(two.marks[&Mark::Wrong].count, 1);
        let text = table.text();
        for word in ["false names", "worst s", "spring", "5.0"] {
            assert!(text.contains(word), "{word}:\n{text}");
        }
        // It reads back from JSON as it is written, with nothing but numbers in it.
        let json = serde_json::to_string(&table).unwrap();
        assert_eq!(serde_json::from_str::<Table>(&json).unwrap(), table);
    }
}
