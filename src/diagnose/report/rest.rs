//! What the named effects leave unexplained, as sentences.

use super::headline::mismatch;
use super::words::{capitalised, listed, share};
use super::{sentences, words};
use crate::diagnose::diagnosis::{Diagnosis, Distance, Regime};
use crate::diagnose::findings::FindingKind;

/// A mean square this close to that of the noise is not reported: the noise itself is known no
/// better.
const REPORTED_EXCESS: f64 = 0.1;
/// Places that are listed.
const MAX_PLACES: usize = 3;

/// A place where error remains.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// Name of the recording.
    pub recording: String,
    /// What the mass is doing.
    pub regime: Regime,
    /// Share of all remaining error, 0 to 1.
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

/// Sentences on what remains: how much, where and on what it depends; then what shows it.
pub fn sentences(diagnosis: &Diagnosis) -> Vec<String> {
    let mut out = amount(diagnosis);
    out.extend(signs(diagnosis));
    out
}

/// How much of the mismatch the named effects leave, where, and on what it depends.
fn amount(d: &Diagnosis) -> Vec<String> {
    let Some(left) = &d.remaining else {
        return Vec::new();
    };
    let names: Vec<&str> = d.named.iter().map(|n| n.name.as_str()).collect();
    let runs = left.share_of_runs.map_or_else(String::new, |s| {
        format!(
            " in single stretches, and {} of that of whole runs",
            share(s)
        )
    });
    let amount = match names.len() {
        0 => None,
        1 => Some("leaves"),
        _ => Some("leave"),
    };
    let amount = amount.map(|leave| {
        format!(
            "{} {leave} {} of {}{runs}.",
            capitalised(&listed(&names)),
            share(left.share),
            mismatch(d)
        )
    });
    let what = if names.is_empty() {
        "What is missing"
    } else {
        "What remains"
    };
    let place = format!("{what} shows most {}", left.regime.place());
    let place = match left.depends_on {
        Some(quantity) => format!("{place} and depends on {}.", quantity.text()),
        None => format!("{place}; no single quantity stands out on which it depends."),
    };
    amount.into_iter().chain([place]).collect()
}

/// What shows that something remains.
fn signs(diagnosis: &Diagnosis) -> Vec<String> {
    let sets = [
        ("held-out recordings", &diagnosis.held_out),
        ("the fitted recordings", &diagnosis.train),
    ];
    let mut out = Vec::new();
    let sets = sets
        .into_iter()
        .skip(usize::from(!diagnosis.has_held_out()));
    for (name, both) in sets {
        let Distance { chi2, .. } = both.after;
        if !chi2.is_finite() {
            out.push(format!("Nothing could be compared on {name}."));
        } else if chi2 > 1.0 + REPORTED_EXCESS {
            out.push(format!(
                "On {name} the mean square of the residuals is {} times that of the noise.",
                words::chi2(chi2)
            ));
        }
    }
    if out.is_empty() {
        return vec![match diagnosis.inadequacy() {
            Some(found) if found.kind == FindingKind::MeanSquare => {
                format!("{}.", capitalised(&sentences::finding(found)))
            }
            Some(found) => format!(
                "On average the residuals are at the noise, but {}.",
                sentences::finding(found)
            ),
            None => {
                "Nothing above the noise: the residuals are what instrument noise alone would give."
                    .to_owned()
            }
        }];
    }
    // The mean square has been reported already.
    let more = diagnosis
        .inadequacy()
        .filter(|f| f.kind != FindingKind::MeanSquare);
    out.extend(more.map(|f| format!("{}.", capitalised(&sentences::finding(f)))));
    let places = places(diagnosis);
    let most: Vec<String> = places
        .iter()
        .take(MAX_PLACES)
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
        out.push(format!(
            "Most of the remaining error lies in {}.",
            listed(&most)
        ));
    }
    out
}
