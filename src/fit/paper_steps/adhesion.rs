//! Step 3, adhesion (figs. 7 and 8): the pull-off force at each release by eq (13) against
//! the time in contact, and the line `Ca t + Ca0` through it, eq (14).
//!
//! Not every release lies on that line, even on a device that obeys it. The law describes
//! *sustained* contact, in which a pull grows until it equals the adhesion. These are excluded
//! and counted:
//!
//! - The drive jumps: the pull passes the adhesion in one step, which only bounds it.
//! - The contact lasts a few periods of the held cantilever: the impact itself ends it, and the
//!   force changes by hundreds of nN between two samples.
//! - The mass is pressed down: it is not pulled off, so the events were misread.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::StepError;
use super::line_fit::{Line, robust_line};
use crate::fit::contact_readings::{ContactReadings, Release};
use crate::fit::thresholds::{
    MAX_FORCE_ERROR_SHARE, MIN_CONTACT_SAMPLES, MIN_CONTACT_TIME_RATIO, MIN_RELEASES,
    MIN_STAY_TIME, PRESSED_SIGMAS,
};
use crate::model::unit::counted;
use crate::recording::quantile_in_place;

/// Why a release does not count for the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum ExcludedRelease {
    /// Contact that is not sustained.
    Brief,
    /// The drive's force jumps there.
    Jump,
    /// The mass is pressed down as it leaves.
    Pressed,
    /// The force is too uncertain.
    Vague,
}

impl ExcludedRelease {
    /// All, in the order in which they are checked.
    pub const ALL: [ExcludedRelease; 4] = [
        ExcludedRelease::Brief,
        ExcludedRelease::Jump,
        ExcludedRelease::Pressed,
        ExcludedRelease::Vague,
    ];

    /// As written in files.
    pub fn id(self) -> &'static str {
        match self {
            ExcludedRelease::Brief => "brief",
            ExcludedRelease::Jump => "jump",
            ExcludedRelease::Pressed => "pressed",
            ExcludedRelease::Vague => "vague",
        }
    }

    fn of(release: &Release, largest: f64) -> Option<Self> {
        if release.contact < MIN_STAY_TIME || release.samples < MIN_CONTACT_SAMPLES {
            Some(ExcludedRelease::Brief)
        } else if release.jump > release.error {
            Some(ExcludedRelease::Jump)
        } else if release.force < -PRESSED_SIGMAS * release.error {
            Some(ExcludedRelease::Pressed)
        } else if release.error.is_nan() || release.error >= MAX_FORCE_ERROR_SHARE * largest {
            Some(ExcludedRelease::Vague)
        } else {
            None
        }
    }
}

impl fmt::Display for ExcludedRelease {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ExcludedRelease::Brief => write!(
                f,
                "after less than {:.1} ms or {MIN_CONTACT_SAMPLES} samples on the ground, no sustained contact",
                1e3 * MIN_STAY_TIME
            ),
            ExcludedRelease::Jump => f.write_str(
                "where the drive jumps, so that the pull passes the adhesion in one step",
            ),
            ExcludedRelease::Pressed => f.write_str("while the drive still pressed the mass down"),
            ExcludedRelease::Vague => f.write_str("whose force is too uncertain"),
        }
    }
}

/// The adhesion law.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Adhesion {
    /// Growth `Ca` \[N/s\] and its standard error.
    pub rate: (f64, f64),
    /// Start `Ca0` \[N\] and its standard error.
    pub start: (f64, f64),
    /// The line, for its confidence band.
    pub line: Line,
    /// The releases that count.
    pub releases: Vec<Release>,
    /// The releases that do not, and why not.
    pub aside: Vec<(Release, ExcludedRelease)>,
    /// Releases that were seen and could not be read.
    pub unread: usize,
    /// Distance of the model from what was read, in units of the noise.
    pub off: f64,
}

impl Adhesion {
    /// Adhesion after `contact` \[s\], and half the width of its 95 % band \[N\].
    pub fn band(&self, contact: f64) -> (f64, f64) {
        (self.line.at(contact), self.line.band_at(contact))
    }

    /// What was set aside, one sentence for each reason there is.
    pub fn set_aside(&self) -> Vec<String> {
        exclusion_sentences(&self.aside, self.unread)
    }
}

fn exclusion_sentences(aside: &[(Release, ExcludedRelease)], unread: usize) -> Vec<String> {
    let sentences = ExcludedRelease::ALL.into_iter().filter_map(|reason| {
        let n = aside.iter().filter(|(_, own)| *own == reason).count();
        (n > 0).then(|| format!("{} {reason}", counted(n, "release")))
    });
    let unread = (unread > 0).then(|| {
        format!(
            "{} that could not be followed: too far from the model, after too few samples on the ground, or on the ground since before the recording",
            counted(unread, "release")
        )
    });
    sentences.chain(unread).collect()
}

/// Fits the line.
///
/// # Errors
/// [`StepError::Unsuited`] if too few releases have a known force, or all contacts last equally long.
pub fn adhesion(names: &str, readings: &ContactReadings) -> Result<Adhesion, StepError> {
    // Only releases under a growing pull bound how large the others may be.
    let largest = readings
        .releases
        .iter()
        .filter(|r| ExcludedRelease::of(r, f64::INFINITY).is_none())
        .fold(0.0f64, |a, r| a.max(r.force.abs()));
    let (mut releases, mut aside) = (Vec::new(), Vec::new());
    for release in &readings.releases {
        match ExcludedRelease::of(release, largest) {
            None => releases.push(*release),
            Some(reason) => aside.push((*release, reason)),
        }
    }
    let unsuited = |reason: String| StepError::Unsuited {
        recording: names.to_owned(),
        reason,
        remedy: "record 5 Hz ramped squares of several lambda, so that contacts of several lengths end in a slow pull",
    };
    if releases.len() < MIN_RELEASES {
        let mut reason = format!(
            "needs {MIN_RELEASES} releases with a known pull-off force, found {}",
            releases.len()
        );
        let exclusions = exclusion_sentences(&aside, readings.unread_releases);
        if !exclusions.is_empty() {
            reason += &format!(" (set aside: {})", exclusions.join("; "));
        }
        return Err(unsuited(reason));
    }
    let times = releases.iter().map(|r| r.contact);
    let (shortest, longest) = times.fold((f64::INFINITY, 0.0f64), |(s, l), t| (s.min(t), l.max(t)));
    if longest < MIN_CONTACT_TIME_RATIO * shortest {
        return Err(unsuited(format!(
            "all contacts last {:.1} to {:.1} ms: they do not determine a slope in time",
            1e3 * shortest,
            1e3 * longest
        )));
    }
    // An error from a linearization can be much too small: none counts as less than the median.
    let mut errors: Vec<f64> = releases.iter().map(|r| r.error).collect();
    let usual = quantile_in_place(&mut errors, 0.5);
    let points: Vec<[f64; 3]> = releases
        .iter()
        .map(|r| [r.contact, r.force, r.error.max(usual)])
        .collect();
    let line = robust_line(&points)
        .ok_or_else(|| unsuited("the releases determine no line".to_owned()))?;
    Ok(Adhesion {
        rate: (line.slope, line.slope_error),
        start: (line.intercept, line.intercept_error),
        line,
        releases,
        aside,
        unread: readings.unread_releases,
        off: readings.off.read,
    })
}
