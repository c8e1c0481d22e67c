//! The three forms of a diagnosis.

use super::fixture::{adequate, drag, partly, unexplained};
use crate::diagnose::diagnosis::Quantity;
use crate::diagnose::report::*;

/// Whether every element of a page is closed in its turn; text between is not looked at.
fn well_formed(page: &str) -> Result<(), String> {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = page.strip_prefix("<!DOCTYPE html>").unwrap_or(page);
    while let Some(at) = rest.find('<') {
        rest = &rest[at + 1..];
        let end = rest.find('>').ok_or("a tag without end")?;
        let tag = &rest[..end];
        if tag.contains('<') {
            return Err(format!("< within <{tag}"));
        }
        if !tag.matches('"').count().is_multiple_of(2) {
            return Err(format!("quotes in <{tag}>"));
        }
        if let Some(name) = tag.strip_prefix('/') {
            let last = open.pop();
            if last != Some(name) {
                return Err(format!("</{name}> closes {last:?}"));
            }
        } else if !tag.ends_with('/') {
            open.push(tag.split_whitespace().next().unwrap_or(tag));
        }
        rest = &rest[end + 1..];
    }
    if open.is_empty() {
        Ok(())
    } else {
        Err(format!("left open: {open:?}"))
    }
}

#[test]
fn the_value_has_the_fixed_form() {
    let value = json(&drag());
    let keys = |v: &serde_json::Value| -> Vec<String> {
        let mut keys: Vec<String> = v.as_object().unwrap().keys().cloned().collect();
        keys.sort();
        keys
    };
    assert_eq!(
        keys(&value),
        [
            "candidates",
            "effects",
            "fit",
            "mismatch",
            "next_experiment",
            "remaining",
            "verdict"
        ]
    );
    assert_eq!(value["verdict"], "missing_physics");
    let effect = &value["effects"][0];
    assert_eq!(
        keys(effect),
        ["id", "name", "parameters", "probability", "size_nN"]
    );
    assert_eq!(effect["id"], "quadratic_drag");
    assert!((effect["size_nN"].as_f64().unwrap() - 9.14).abs() < 1e-9);
    let cd = &effect["parameters"]["cd"];
    assert_eq!(keys(cd), ["std_error", "unit", "value"]);
    assert_eq!(cd["value"], 1.023e-7);
    assert_eq!(
        keys(&value["candidates"][0]),
        ["held_out_chi2", "id", "probability"]
    );
    let m = &value["mismatch"][1];
    assert_eq!(
        keys(m),
        [
            "channel",
            "end_s",
            "recording",
            "regime",
            "share",
            "start_s"
        ]
    );
    assert_eq!(m["regime"], "near_ground_departure");
    let fit = &value["fit"];
    assert_eq!(keys(fit), ["held_out", "noise_um", "train"]);
    for set in ["train", "held_out"] {
        assert_eq!(keys(&fit[set]), ["after", "before"]);
        assert_eq!(keys(&fit[set]["after"]), ["chi2", "rms_um"]);
    }
    assert_eq!(fit["noise_um"], 0.02);
    assert_eq!(keys(&value["next_experiment"]), ["drive", "separates"]);
    assert_eq!(value["next_experiment"]["separates"][1], "film_spring");
    assert!(value["remaining"].is_null());
    let value = json(&partly());
    assert_eq!(value["verdict"], "partly_explained");
    let left = &value["remaining"];
    assert_eq!(keys(left), ["depends_on", "regime", "share"]);
    assert_eq!(left["depends_on"], "xp");
    assert_eq!(left["regime"], "far_flight");
    assert_eq!(left["share"], 0.18);
    assert_eq!(value["effects"][0]["id"], "quadratic_drag");
    let all = Quantity::ALL.map(|quantity| serde_json::json!(quantity));
    assert_eq!(all, ["xp", "vp", "V", "t"]);
}

#[test]
fn what_is_not_a_number_is_null() {
    let mut d = drag();
    d.named[0].size = f64::NAN;
    d.named[0].parameters[0].std_error = f64::INFINITY;
    let value = json(&d);
    assert!(value["effects"][0]["size_nN"].is_null());
    assert!(value["effects"][0]["parameters"]["cd"]["std_error"].is_null());
    assert!(value["candidates"][4]["held_out_chi2"].is_null());
    let value = json(&adequate());
    assert!(value["fit"]["held_out"]["after"]["chi2"].is_null());
    assert!(value["next_experiment"].is_null());
    assert_eq!(value["verdict"], "adequate");
    assert_eq!(value["effects"], serde_json::json!([]));
}

#[test]
fn the_summary_says_it_in_its_first_line() {
    let summary = text(&drag());
    println!("{summary}");
    assert!(summary.starts_with("Quadratic drag was left out.\n"));
    for part in [
        "probability 99.9 %, largest force 9.14 nN",
        "(1.023 \u{b1} 0.011)e-7 N s^2/m^2",
        "cannot distinguish it from compressible film",
        "21.9 x noise",
        "Nothing above the noise",
        "drive square:220Hz:8V: 0.2 s of it would distinguish quadratic drag",
    ] {
        assert!(summary.contains(part), "{part} in\n{summary}");
    }
    assert!(summary.lines().all(|line| line.chars().count() <= 100));
    let summary = text(&adequate());
    println!("{summary}");
    assert!(summary.starts_with("Nothing was left out"));
    assert!(!summary.contains("NaN") && !summary.contains("Next experiment"));
    let summary = text(&unexplained());
    println!("{summary}");
    assert!(summary.starts_with("Something was left out, and no effect"));
    assert!(summary.contains("Most of the remaining error lies in"));
    assert!(!summary.contains("NaN"));
}

/// The text on one line, so that breaks do not matter.
fn flat(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn a_part_is_said_with_its_law_what_remains_and_what_to_do_next() {
    let summary = text(&partly());
    println!("{summary}");
    assert!(summary.starts_with(
        "Quadratic drag was left out. It carries 82 % of the mismatch between contacts; the rest"
    ));
    assert!(summary.lines().all(|line| line.chars().count() <= 120));
    let whole = flat(&summary);
    for part in [
        "law: F = ",
        "Quadratic drag leaves 18 % of the mismatch between contacts in single stretches, and 4 % of that of whole runs.",
        "What remains shows most in far flight and depends on the displacement xp.",
        "A force that depends on the displacement xp would lower chi2 by another 5210.",
        "Next experiment - drive square:220Hz:8V",
    ] {
        assert!(whole.contains(part), "{part} in\n{summary}");
    }
    let mut open = partly();
    open.next_experiment = None;
    assert!(flat(&text(&open)).contains("record other amplitudes and frequencies"));
    let page = html(&partly());
    assert!(page.contains("<header class=\"partly\">"));
    assert!(page.contains("still missing with the named effects"));
    let said = headline(&partly());
    println!("{said}");
    assert!(said.starts_with("Left out: quadratic drag (99.9 %), 82 % of the mismatch"));
    assert!(said.contains("The rest is not explained."));
}

#[test]
fn pages_are_well_formed_whole_and_without_nan() {
    for d in [drag(), partly(), adequate(), unexplained()] {
        let page = html(&d);
        well_formed(&page).unwrap();
        for part in [
            "Where",
            "What",
            "How much",
            "Proof",
            "What is still not explained",
            "What limits this answer",
            "Next experiment",
        ] {
            assert!(page.contains(&format!("<h2>{part}</h2>")), "{part}");
        }
        assert!(!page.contains("NaN") && !page.contains(">inf"));
        // Nothing from elsewhere, nothing that runs.
        for foreign in ["http://", "https://", "<script", "url(", "@import"] {
            assert!(!page.contains(foreign), "{foreign}");
        }
    }
}

#[test]
fn the_curves_of_the_force_balance_are_drawn_and_explained() {
    let page = html(&drag());
    for part in [
        "The missing force by the balance of forces in flight",
        "class=\"spread\"",
        "A force over xp&#39; is missing in flight: chi2 falls by 52",
        "No force over xp is seen to be missing in flight",
        "Drawn without its mean and its slope, which re-tuning absorbs.",
        "The red line is what quadratic drag would give in the same way.",
        "With quadratic drag: No force over xp&#39; is seen",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert!(!html(&adequate()).contains("balance of forces"));
    assert!(!html(&unexplained()).contains("The red line"));
}

#[test]
fn names_of_recordings_cannot_break_the_page() {
    let page = html(&unexplained());
    assert!(!page.contains("<b>"));
    assert!(page.contains("&lt;b&gt;&amp;&quot;odd&quot; name&#39;"));
}

#[test]
fn figures_stay_within_their_frames() {
    let page = html(&drag());
    assert_eq!(page.matches("<svg").count(), 9 + 5 + 2 + 2 + 4 + 2);
    for (attribute, most) in [(" x=\"", 860.0), (" cx=\"", 860.0), (" cy=\"", 500.0)] {
        for rest in page.split(attribute).skip(1) {
            let value: f64 = rest.split('"').next().unwrap().parse().unwrap();
            assert!((0.0..=most).contains(&value), "{attribute}{value}");
        }
    }
}

/// For a look at the page in a browser: `cargo test pages_for_a_look -- --ignored`.
#[test]
#[ignore = "writes files for a person to look at"]
fn pages_for_a_look() {
    let folder = std::env::temp_dir();
    for (name, d) in [
        ("missing", drag()),
        ("partly", partly()),
        ("adequate", adequate()),
        ("unexplained", unexplained()),
    ] {
        let path = folder.join(format!("impactscope-report-{name}.html"));
        std::fs::write(&path, html(&d)).unwrap();
        println!("{}", path.display());
    }
}
