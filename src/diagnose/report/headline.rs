//! The verdict in a sentence or two.

use super::words::{capitalised, listed, metres, probability, share};
use crate::diagnose::diagnosis::{Diagnosis, Verdict};

/// The verdict in one or two sentences.
pub fn verdict_sentence(diagnosis: &Diagnosis) -> String {
    match diagnosis.verdict {
        Verdict::Adequate => {
            "Nothing was left out: the re-tuned model explains the recordings down to their noise."
                .to_owned()
        }
        Verdict::MissingPhysics => were_left_out(diagnosis),
        Verdict::PartlyExplained => {
            let carry = if diagnosis.named.len() == 1 {
                "It carries"
            } else {
                "They carry"
            };
            format!(
                "{} {carry} {}; the rest is not explained.",
                were_left_out(diagnosis),
                carried(diagnosis)
            )
        }
        Verdict::Unexplained => {
            let place = diagnosis.mismatch.first().map_or_else(String::new, |m| {
                format!(" It shows most in {}, {}.", m.channel, m.regime.text())
            });
            format!(
                "Something was left out, and no effect of the catalogue explains it, so nothing is named.{place}"
            )
        }
    }
}

/// Names of the effects that were left out, as a sentence.
fn were_left_out(d: &Diagnosis) -> String {
    let names: Vec<&str> = d.named.iter().map(|n| n.name.as_str()).collect();
    let verb = if names.len() == 1 { "was" } else { "were" };
    format!("{} {verb} left out.", capitalised(&listed(&names)))
}

/// How much of the mismatch the named effects carry.
fn carried(d: &Diagnosis) -> String {
    let left = d.remaining.as_ref().map_or(0.0, |r| r.share);
    format!("{} of {}", share(1.0 - left), mismatch(d))
}

/// The mismatch of which shares are given: contacts are counted apart.
pub fn mismatch(d: &Diagnosis) -> &'static str {
    if d.model.has_ground {
        "the mismatch between contacts"
    } else {
        "the mismatch"
    }
}

/// Said of an answer without held-out recordings.
const NOT_PROVED: &str = "no recordings were held out, so this is not proved";

/// The answer with its proof in one or two sentences: what was left out, how probable that
/// is, how much it carries, and how far the error falls on held-out recordings.
pub fn headline(d: &Diagnosis) -> String {
    let noise = metres(d.noise);
    match d.verdict {
        Verdict::Adequate => {
            let proof = if d.has_held_out() {
                let error = metres(d.held_out.before.rms);
                format!("(error on held-out recordings {error}, noise {noise})")
            } else {
                format!("(noise {noise}); {NOT_PROVED}")
            };
            format!(
                "Nothing is missing: the re-tuned model explains the recordings down to their noise {proof}."
            )
        }
        Verdict::MissingPhysics => format!("Left out: {}. {}", with_probabilities(d), change(d)),
        Verdict::PartlyExplained => format!(
            "Left out: {}, {}. The rest is not explained. {}",
            with_probabilities(d),
            carried(d),
            change(d)
        ),
        Verdict::Unexplained => {
            let place = d.mismatch.first().map_or_else(String::new, |m| {
                format!("; it shows most in {}, {}", m.channel, m.regime.text())
            });
            let (on, error) = if d.has_held_out() {
                ("held-out", d.held_out.before.rms)
            } else {
                ("the fitted", d.train.before.rms)
            };
            format!(
                "Something is missing that no effect of the catalogue explains{place}. On {on} \
                 recordings the error is {} (noise {noise}).",
                metres(error)
            )
        }
    }
}

fn with_probabilities(d: &Diagnosis) -> String {
    let names: Vec<String> = d
        .named
        .iter()
        .map(|n| format!("{} ({})", n.name, probability(n.probability)))
        .collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    listed(&names)
}

/// How the error changes on held-out recordings, as a sentence.
pub fn change(d: &Diagnosis) -> String {
    if !d.has_held_out() {
        return format!("{}.", capitalised(NOT_PROVED));
    }
    let (before, after) = (d.held_out.before.rms, d.held_out.after.rms);
    let (was, is, noise) = (metres(before), metres(after), metres(d.noise));
    if was == is {
        return format!(
            "On recordings not used for fitting, the error stays at about {is} (noise {noise}). No single \
             sample shows the effect; the statistics over all of them do."
        );
    }
    let goes = if after < before { "falls" } else { "grows" };
    format!(
        "On recordings not used for fitting, the error {goes} from {was} to {is} (noise {noise})."
    )
}
