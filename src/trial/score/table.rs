//! The score of many trials.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::{Deserialize, Serialize};

use super::reported::Verdict;
use super::share::Share;
use super::{COVERED, Coverage, Mark, Outcome, VISIBLE};
use crate::trial::truth::Class;

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
        Self::of(label, outcomes.map(|o| o.mark))
    }

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
        }
    }
}

/// The score of many trials.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// By class; sizes from [`VISIBLE`] on.
    pub by_class: Vec<Row>,
    /// By effect, one concealed, sizes from [`VISIBLE`] on.
    pub by_effect: Vec<Row>,
    /// By size, one concealed.
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

/// Gathers outcomes; those with exchanged voltages count in a row of their own only.
#[must_use]
pub fn aggregate(outcomes: &[Outcome]) -> Table {
    let (shuffled, plain): (Vec<&Outcome>, Vec<&Outcome>) =
        outcomes.iter().partition(|o| o.shuffled);
    let visible = |o: &&Outcome| o.class == Class::Nothing || o.size >= VISIBLE;
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
    let sum = |f: fn(&Coverage) -> usize| plain.iter().copied().map(|o| f(&o.coverage)).sum();
    let compared = sum(|c| c.compared);
    let right: Vec<&Outcome> = outcomes
        .iter()
        .filter(|o| o.class == Class::One && o.mark == Mark::Right)
        .collect();
    let rms = |k: usize| median(right.iter().map(|o| o.rms_over_noise[k]));
    Table {
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
                .filter(|o| visible(o))
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
            ("class (from 3 x smallest visible)", &self.by_class),
            ("effect (from 3 x smallest visible)", &self.by_effect),
            ("size (one effect)", &self.by_size),
            ("an information criterion alone", &self.by_criterion),
        ];
        // Writing to a String cannot fail.
        for (title, rows) in sections {
            let _ = write!(out, "{title:<36}");
            for mark in Mark::ALL {
                let width = width(mark);
                let _ = write!(out, "{:>width$}", mark.text());
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
