//! Step 3, adhesion (figs. 7 and 8): the pull-off force at each release by eq (13) against
//! the time in contact, and the line `Ca t + Ca0` through it, eq (14).

use super::{Line, StepError, counted, line};
use crate::fit::readings::{Readings, Release};

/// Forces less certain than this share of the largest do not count.
const CERTAIN: f64 = 0.3;
/// Fewest releases for a line with an error.
const LEAST: usize = 3;
/// The longest contact must be this many times the shortest for a slope.
const SPREAD: f64 = 1.3;

/// The adhesion law.
#[derive(Debug, Clone, PartialEq)]
pub struct Adhesion {
    /// Growth `Ca` \[N/s\] and its standard error.
    pub rate: (f64, f64),
    /// Start `Ca0` \[N\] and its standard error.
    pub start: (f64, f64),
    /// The line, for its confidence band.
    pub line: Line,
    /// The releases that count.
    pub releases: Vec<Release>,
}

impl Adhesion {
    /// Adhesion after `contact` \[s\], and half the width of its 95 % band \[N\].
    pub fn band(&self, contact: f64) -> (f64, f64) {
        (self.line.at(contact), 1.96 * self.line.error_at(contact))
    }
}

/// Fits the line.
///
/// # Errors
/// [`StepError::Unsuited`] if too few releases tell the force, or all after equal times.
pub fn adhesion(names: &str, readings: &Readings) -> Result<Adhesion, StepError> {
    let largest = readings
        .releases
        .iter()
        .fold(0.0f64, |a, r| a.max(r.force.abs()));
    let releases: Vec<Release> = readings
        .releases
        .iter()
        .filter(|r| r.error < CERTAIN * largest)
        .copied()
        .collect();
    let unsuited = |reason: String| StepError::Unsuited {
        recording: names.to_owned(),
        reason,
        remedy: "record 5 Hz ramped squares of several lambda, so that contacts of several lengths end in a slow pull",
    };
    if releases.len() < LEAST {
        return Err(unsuited(format!(
            "{} the pull-off force, {LEAST} are needed",
            counted(releases.len(), "release tells", "releases tell")
        )));
    }
    let times = releases.iter().map(|r| r.contact);
    let (shortest, longest) = times.fold((f64::INFINITY, 0.0f64), |(s, l), t| (s.min(t), l.max(t)));
    if longest < SPREAD * shortest {
        return Err(unsuited(format!(
            "all contacts last about {:.1} ms: a slope in time cannot be told",
            1e3 * longest
        )));
    }
    // Scatter beyond the stated errors, first seen with equal weights, widens them.
    let weighted = |own2: f64| -> Vec<[f64; 3]> {
        releases
            .iter()
            .map(|r| {
                [
                    r.contact,
                    r.force,
                    1.0 / (r.error * r.error + own2).max(1e-40),
                ]
            })
            .collect()
    };
    let none = || unsuited("the releases determine no line".to_owned());
    let first = line(&weighted(0.0)).ok_or_else(none)?;
    let noise2 = releases.iter().map(|r| r.error * r.error).sum::<f64>() / releases.len() as f64;
    let left2 = releases
        .iter()
        .map(|r| (r.force - first.at(r.contact)).powi(2))
        .sum::<f64>()
        / (releases.len() - 2).max(1) as f64;
    let line = line(&weighted((left2 - noise2).max(0.0))).ok_or_else(none)?;
    Ok(Adhesion {
        rate: (line.slope, line.slope_error),
        start: (line.intercept, line.intercept_error),
        line,
        releases,
    })
}
