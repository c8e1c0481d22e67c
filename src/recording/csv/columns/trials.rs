//! Recordings side by side: several groups of columns with a time each, or several displacements with
//! one time.

use super::names::{Column, Role};
use super::units::UnitKind;
use crate::recording::csv::settings::ColumnChoice;

/// Most recordings side by side.
const MAX_GROUPS: usize = 256;

/// The columns of one recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Group {
    pub name: String,
    /// Indices of its columns.
    pub columns: Vec<usize>,
}

/// What was chosen for one recording of several.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::recording::csv) struct TrialColumns {
    pub name: String,
    /// Columns of t, V, xp, xc.
    pub choices: [Option<ColumnChoice>; 4],
}

/// The recordings side by side; empty if there is one. `labels` is the row above the names.
pub(super) fn groups(columns: &[Column], labels: &[String]) -> Vec<Group> {
    let is_time = |c: &Column| c.rank(Role::Time).is_some() && c.fits(Role::Time);
    let times: Vec<usize> = (0..columns.len())
        .filter(|i| columns.get(*i).is_some_and(is_time))
        .collect();
    let groups = match times.as_slice() {
        [] => Vec::new(),
        [time] => with_one_time(columns, *time),
        _ => with_own_times(columns, &times, labels),
    };
    if groups.len() > MAX_GROUPS {
        return Vec::new();
    }
    groups
}

/// The same columns again and again, each time with a time.
fn with_own_times(columns: &[Column], times: &[usize], labels: &[String]) -> Vec<Group> {
    let first = times.first().copied().unwrap_or(0);
    let before = columns.get(..first).unwrap_or_default();
    // What stands before the first time, other than a number of the row, belongs to nothing.
    if before.iter().any(|c| !c.is_index()) {
        return Vec::new();
    }
    let ends = times.iter().skip(1).copied().chain([columns.len()]);
    let ranges: Vec<(usize, usize)> = times.iter().copied().zip(ends).collect();
    let signature = |(from, to): (usize, usize)| -> Vec<Option<usize>> {
        let own = columns.get(from..to).unwrap_or_default();
        let roles = own.iter().map(|c| {
            Role::ALL
                .iter()
                .position(|role| c.rank(*role).is_some() && c.fits(*role))
        });
        let mut all: Vec<Option<usize>> = roles.collect();
        while all.last() == Some(&None) {
            all.pop();
        }
        all
    };
    let Some(pattern) = ranges.first().map(|range| signature(*range)) else {
        return Vec::new();
    };
    if pattern.len() < 2 || !ranges.iter().all(|range| signature(*range) == pattern) {
        return Vec::new();
    }
    ranges
        .into_iter()
        .enumerate()
        .map(|(i, (from, to))| {
            let label = labels
                .get(from..to)
                .and_then(|own| own.iter().find(|l| !l.trim().is_empty()));
            let number = columns.get(from).and_then(|c| c.number).unwrap_or(i + 1);
            Group {
                name: label.map_or_else(|| format!("trial {number}"), |l| l.trim().to_owned()),
                columns: (from..to).collect(),
            }
        })
        .collect()
}

/// Several displacements whose names differ by a number, and voltages alike or one for all.
fn with_one_time(columns: &[Column], time: usize) -> Vec<Group> {
    let is_motion = |c: &Column| {
        let named = c.rank(Role::ProofMass).is_some() && c.fits(Role::ProofMass);
        (named || c.kind == Some(UnitKind::Length)) && c.stem().is_some()
    };
    let motions: Vec<usize> = (0..columns.len())
        .filter(|i| columns.get(*i).is_some_and(is_motion))
        .collect();
    let stem = |i: &usize| columns.get(*i).and_then(Column::stem);
    let number = |i: &usize| columns.get(*i).and_then(|c| c.number);
    let (Some(first), true) = (motions.first(), motions.len() >= 2) else {
        return Vec::new();
    };
    let mut numbers: Vec<Option<usize>> = motions.iter().map(number).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let alike = motions.iter().all(|i| stem(i) == stem(first));
    if !alike || numbers.len() != motions.len() {
        return Vec::new();
    }
    motions
        .iter()
        .map(|motion| {
            // Columns of this number, and those without one.
            let own = |i: &usize| {
                *i == time
                    || i == motion
                    || (!motions.contains(i)
                        && (number(i).is_none() || number(i) == number(motion)))
            };
            Group {
                name: columns
                    .get(*motion)
                    .map_or_else(String::new, |c| c.name.trim().to_owned()),
                columns: (0..columns.len()).filter(own).collect(),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::trials::*;

    fn found(header: &str, labels: &str) -> Vec<(String, Vec<usize>)> {
        let cells = |text: &str| -> Vec<String> { text.split(',').map(str::to_owned).collect() };
        let columns: Vec<Column> = cells(header).iter().map(|c| Column::of(c)).collect();
        groups(&columns, &cells(labels))
            .into_iter()
            .map(|g| (g.name, g.columns))
            .collect()
    }

    #[test]
    fn groups_with_their_own_times() {
        let groups = found("t1 [s],xp1 [um],t2 [s],xp2 [um]", "");
        assert_eq!(
            groups,
            [
                ("trial 1".to_owned(), vec![0, 1]),
                ("trial 2".to_owned(), vec![2, 3])
            ]
        );
        let groups = found("t [s],V [V],x [um],t [s],V [V],x [um]", "up,,,down,,");
        assert_eq!(groups[1], ("down".to_owned(), vec![3, 4, 5]));
    }

    #[test]
    fn displacements_with_one_time() {
        let groups = found("t [s],V [V],trial 1 [um],trial 2 [um]", "");
        assert_eq!(groups[1], ("trial 2".to_owned(), vec![0, 1, 3]));
        let groups = found("t [s],V1 [V],xp1 [um],V2 [V],xp2 [um]", "");
        assert_eq!(groups[1].1, [0, 3, 4]);
        for one in [
            "t [s],V [V],xp [um],xc [um]",
            "t [s],xp [um],x [um]",
            "n,t [s],xp [um]",
        ] {
            assert!(found(one, "").is_empty(), "{one}");
        }
    }
}
