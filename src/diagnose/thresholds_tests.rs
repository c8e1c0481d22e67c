//! Thresholds against the statistics recorded for them, and what their entries say.

use crate::diagnose::thresholds::*;

/// A threshold between the largest statistic recorded with nothing to detect and the smallest
/// one with something, as far as either was recorded.
struct Recorded {
    name: &'static str,
    threshold: f64,
    largest_without: f64,
    smallest_with: Option<f64>,
}

const RECORDED: [Recorded; 3] = [
    Recorded {
        name: "TRAIN_GAIN",
        threshold: TRAIN_GAIN,
        largest_without: 20.0,
        smallest_with: None,
    },
    Recorded {
        name: "MIN_FORM_SHARE",
        threshold: MIN_FORM_SHARE,
        largest_without: 0.87,
        smallest_with: Some(0.9),
    },
    Recorded {
        name: "PRODUCT_FORCE_LIMITS",
        threshold: PRODUCT_FORCE_LIMITS.0,
        largest_without: 2.5,
        smallest_with: Some(40.0),
    },
];
/// Shares counted in sealed trials: how many were so, of how many, and by how much the threshold was
/// rounded.
const COUNTED: [(&str, f64, f64, f64, f64); 2] = [
    (
        "CALIBRATED_PRECISION",
        CALIBRATED_PRECISION,
        246.0,
        260.0,
        0.005,
    ),
    (
        "FALSE_ABSTENTION_RATE",
        FALSE_ABSTENTION_RATE,
        5.0,
        27.0,
        0.02,
    ),
];

#[test]
fn thresholds_lie_between_their_recorded_statistics() {
    for r in &RECORDED {
        assert!(r.threshold > r.largest_without, "{}", r.name);
        assert!(
            r.smallest_with.is_none_or(|with| r.threshold < with),
            "{}",
            r.name
        );
    }
    for (name, share, so, all, rounding) in COUNTED {
        assert!((share - so / all).abs() < rounding, "{name}");
    }
}

/// What is wrong with the headers and entries of a file of thresholds, and how many entries it has.
fn offences(text: &str, calibrated: &[&str]) -> (Vec<String>, usize) {
    let (mut found, mut count) = (Vec::new(), 0);
    let (mut header, mut doc) = (String::new(), String::new());
    for line in text.lines() {
        if let Some(more) = line.strip_prefix("/// ") {
            doc.push_str(more);
            doc.push(' ');
        } else if let Some(more) = line.strip_prefix("// ") {
            header.push_str(more);
            header.push(' ');
        } else if let Some(rest) = line.strip_prefix("pub const ") {
            let name = rest.split(':').next().unwrap_or(rest);
            if !header.contains("Judgement; check with `trial") {
                found.push(format!("{name}: the section has no check"));
            }
            if doc.contains("Calibrated by `trial") != calibrated.contains(&name) {
                found.push(format!("{name}: calibrated or not"));
            }
            if doc.is_empty() || doc.contains("Judgement") {
                found.push(format!("{name}: no entry of its own"));
            }
            doc.clear();
            count += 1;
        } else if line.is_empty() {
            header.clear();
        }
    }
    (found, count)
}

#[test]
fn every_threshold_says_what_calibrates_it() {
    let recorded = RECORDED.iter().map(|r| r.name);
    let calibrated: Vec<&str> = recorded.chain(COUNTED.iter().map(|c| c.0)).collect();
    let (found, count) = offences(include_str!("thresholds.rs"), &calibrated);
    assert_eq!(found, [""; 0]);
    assert!(count > 100, "{count}");
}

#[test]
fn a_threshold_that_does_not_say_it_is_seen() {
    let bad = "// Room\n/// A.\npub const ONE: f64 = 1.0;\n\n// Other. Judgement; check with `trial`.\n\
               /// Calibrated by `trial`.\npub const TWO: f64 = 2.0;\npub const THREE: f64 = 3.0;\n";
    let (found, count) = offences(bad, &["THREE"]);
    assert_eq!(count, 3);
    assert_eq!(
        found,
        [
            "ONE: the section has no check",
            "TWO: calibrated or not",
            "THREE: calibrated or not",
            "THREE: no entry of its own"
        ]
    );
}
