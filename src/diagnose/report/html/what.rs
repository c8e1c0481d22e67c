//! "What": every effect that was compared, and the force that the model lacks.

use super::{HALF, Page};
use crate::diagnose::diagnosis::{Diagnosis, ForceCurve};
use crate::diagnose::report::force_balance::{absorbed_sentence, curve_sentence};
use crate::diagnose::report::ground::law_through;
use crate::diagnose::report::sentences;
use crate::diagnose::report::svg::axis::Axis;
use crate::diagnose::report::svg::escape;
use crate::diagnose::report::svg::plot::{Dot, Plot};
use crate::diagnose::report::words::{chi2, gain, gain_where_fitted, listed, probability};

/// Writes the candidates and the force curves.
pub fn write(page: &mut Page, d: &Diagnosis) {
    candidates(page, d);
    if d.forces.is_empty() {
        return;
    }
    page.heading("The force that the re-tuned model lacks");
    let names: Vec<&str> = d.named.iter().map(|n| n.name.as_str()).collect();
    let law = if d.forces.iter().any(|f| !f.law.is_empty()) {
        format!(
            " The line is the fitted law of {}. A constant and a slope are added to it, because re-tuning absorbs both.",
            listed(&names)
        )
    } else {
        String::new()
    };
    page.paragraph(&format!(
        "Mean force on the proof mass as measured, with standard errors.{law}"
    ));
    page.raw("<div class=\"grid2\">\n");
    for curve in &d.forces {
        page.figure(&force(curve), "");
    }
    page.raw("</div>\n");
}

/// Writes the force that the balance of forces in flight gives.
pub fn balance(page: &mut Page, d: &Diagnosis) {
    let Some(found) = d.balance.as_ref().filter(|b| !b.before.is_empty()) else {
        return;
    };
    page.heading("The missing force by the balance of forces in flight");
    let names: Vec<&str> = d.named.iter().map(|n| n.name.as_str()).collect();
    let law = if found.before.iter().any(|c| !c.curve.law.is_empty()) {
        format!(
            " The red line is what {} would give in the same way.",
            listed(&names)
        )
    } else {
        String::new()
    };
    page.paragraph(&format!(
        "Nothing is simulated here: the points are the force that the measured motion itself \
         calls for, if it depends on one quantity alone, with a band of one standard error.{law}"
    ));
    page.raw("<div class=\"grid2\">\n");
    for c in &found.before {
        let mut caption = format!("{} {}", curve_sentence(c), absorbed_sentence(c));
        if let Some(left) = found.after_over(c.quantity) {
            caption += &format!(" With {}: {}", listed(&names), curve_sentence(left));
        }
        page.figure(&force_with_band(&c.curve, &c.curve.law, true), &caption);
    }
    page.raw("</div>\n");
}

/// Draws the force that the named effects do not carry.
pub fn remaining(page: &mut Page, d: &Diagnosis) {
    let left = d.remaining.as_ref().filter(|_| !d.named.is_empty());
    let Some(curve) = left.and_then(|left| left.force.as_ref()) else {
        return;
    };
    let caption = "Mean force on the proof mass that is still missing with the named effects.";
    page.figure(&force(curve), caption);
}

fn candidates(page: &mut Page, d: &Diagnosis) {
    if d.candidates.is_empty() {
        page.paragraph("No effect was compared.");
        return;
    }
    page.paragraph(
        "Every effect that was compared. The gain is the fall of chi2 when the effect is \
         added; what counts is the gain on held-out recordings.",
    );
    page.raw("<div class=\"wide\"><table>\n<thead><tr><th>effect</th>");
    for head in [
        "probability",
        "gain, fitted",
        "gain, held-out",
        "chi2, held-out",
    ] {
        page.raw(&format!("<th class=\"n\">{head}</th>"));
    }
    page.raw("<th>for and against</th></tr></thead>\n<tbody>\n");
    for c in &d.candidates {
        let named = d.named.iter().find(|n| n.id == c.id);
        page.raw(if named.is_some() {
            "<tr class=\"named\"><td>"
        } else {
            "<tr><td>"
        });
        page.text(&c.name);
        page.raw("</td>");
        for cell in [
            probability(c.probability),
            gain_where_fitted(c),
            gain(c.held_out_gain),
            chi2(c.held_out_chi2),
        ] {
            page.raw(&format!("<td class=\"n\">{}</td>", escape(&cell)));
        }
        page.raw("<td class=\"why\">");
        let evidence = named.iter().flat_map(|n| &n.evidence);
        let remarks = c.remarks.iter().map(sentences::candidate);
        for sentence in evidence.map(sentences::evidence).chain(remarks) {
            page.paragraph(&sentence);
        }
        page.raw("</td></tr>\n");
    }
    page.raw("</tbody></table></div>\n");
}

fn force(curve: &ForceCurve) -> String {
    force_with_band(curve, &law_through(curve), false)
}

/// Draws a force with the law that goes with it, and a band of one standard error if it is continuous.
fn force_with_band(curve: &ForceCurve, law: &[f64], has_band: bool) -> String {
    let measured = curve.force.iter().zip(&curve.std_error);
    let ends = measured
        .filter(|(f, _)| f.is_finite())
        .flat_map(|(f, e)| {
            let e = if e.is_finite() { *e } else { 0.0 };
            [f - e, f + e]
        })
        .chain(law.iter().copied())
        .chain([0.0]);
    let mut plot = Plot::new(
        [HALF, 230.0],
        Axis::linear(curve.against, curve.unit, curve.at.iter().copied()),
        Axis::linear("force", "N", ends),
    );
    plot.level("axis", 0.0);
    let dots = (0..curve.at.len().min(curve.force.len())).map(|i| Dot {
        x: curve.at[i],
        y: curve.force[i],
        error: curve.std_error.get(i).copied().unwrap_or(f64::NAN),
    });
    let dots: Vec<Dot> = dots.collect();
    if has_band {
        plot.band("spread", &dots);
    }
    plot.dots("seen", 2.4, dots);
    let law = curve.at.iter().copied().zip(law.iter().copied());
    plot.line("law", law);
    plot.finish()
}
