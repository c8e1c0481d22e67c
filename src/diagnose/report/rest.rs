//! What the named effects leave unexplained.

use super::words;
use super::words::listed;
use crate::diagnose::diagnosis::{Diagnosis, Distance, Inadequacy, Regime};

/// A mean square this close to the noise alone is not worth words: the noise itself is
/// known no better.
const SLACK: f64 = 0.1;
/// Places that are told.
const PLACES: usize = 3;

/// A place where something is left.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// Name of the recording.
    pub recording: String,
    /// What the mass is doing.
    pub regime: Regime,
    /// Share of all that is left, 0 to 1.
    pub share: f64,
}

/// Where the residuals after naming exceed the noise, largest first.
pub fn places(diagnosis: &Diagnosis) -> Vec<Place> {
    let mut all: Vec<Place> = Vec::new();
    for strip in &diagnosis.strips {
        let noise = diagnosis
            .proof
            .iter()
            .find(|p| p.recording == strip.recording && p.held_out == strip.held_out)
            .map_or(diagnosis.noise, |p| p.noise);
        for regime in Regime::ALL {
            // Summed with their sign, bins that are only noise cancel.
            let excess: f64 = strip
                .after
                .iter()
                .zip(&strip.regime)
                .filter(|(rms, r)| **r == regime && rms.is_finite())
                .map(|(rms, _)| (rms / noise).powi(2) - 1.0)
                .sum();
            if excess > 0.0 {
                all.push(Place {
                    recording: strip.recording.clone(),
                    regime,
                    share: excess,
                });
            }
        }
    }
    let whole: f64 = all.iter().map(|p| p.share).sum();
    for place in &mut all {
        place.share /= whole;
    }
    all.sort_by(|a, b| b.share.total_cmp(&a.share));
    all
}

/// Sentences on what is left.
pub fn sentences(diagnosis: &Diagnosis) -> Vec<String> {
    let sets = [
        ("the recordings kept out", &diagnosis.held_out),
        ("the recordings fitted to", &diagnosis.train),
    ];
    let mut left = Vec::new();
    for (name, both) in sets {
        let Distance { chi2, .. } = both.after;
        if !chi2.is_finite() {
            left.push(format!("Nothing could be compared on {name}."));
        } else if chi2 > 1.0 + SLACK {
            left.push(format!(
                "On {name} the mean square of the residuals is {} times that of the noise.",
                words::chi2(chi2)
            ));
        }
    }
    if left.is_empty() {
        return vec![match diagnosis.left {
            Some(mean @ Inadequacy::Mean(_)) => format!("{}.", words::capitalised(&mean.text())),
            Some(rest) => format!(
                "In the mean nothing is above the noise, but {}.",
                rest.text()
            ),
            None => {
                "Nothing above the noise: residuals are what the instruments' noise makes them."
                    .to_owned()
            }
        }];
    }
    // The mean square has been told already.
    let more = diagnosis.left.filter(|l| !matches!(l, Inadequacy::Mean(_)));
    left.extend(more.map(|l| format!("{}.", words::capitalised(&l.text()))));
    let places = places(diagnosis);
    let most: Vec<String> = places
        .iter()
        .take(PLACES)
        .map(|p| {
            format!(
                "{} of {} ({:.0} %)",
                p.regime.text(),
                p.recording,
                100.0 * p.share
            )
        })
        .collect();
    if !most.is_empty() {
        let most: Vec<&str> = most.iter().map(String::as_str).collect();
        left.push(format!("Most of what is left lies in {}.", listed(&most)));
    }
    left
}
