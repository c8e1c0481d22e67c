//! "Where": strips of residuals over each recording, the worst segments, and what the residuals
//! depend on.

use super::strip::{Scale, figure};
use super::{HALF, Page};
use crate::diagnose::diagnosis::{Diagnosis, Marginal, Regime};
use crate::diagnose::report::svg::axis::Axis;
use crate::diagnose::report::svg::escape;
use crate::diagnose::report::svg::plot::{Dot, Plot};
use crate::diagnose::report::words::{share, time_span, with_named};

/// Segments that get a number, in the table and in the strips.
const NUMBERED: usize = 12;

/// Writes the section's inside.
pub fn write(page: &mut Page, d: &Diagnosis) {
    if d.strips.is_empty() {
        page.paragraph("There are no residuals over time.");
    } else {
        strips(page, d);
    }
    worst(page, d);
    marginals(page, d);
}

fn strips(page: &mut Page, d: &Diagnosis) {
    page.paragraph(
        "Root mean square of simulation minus recording along each recording, on one logarithmic \
         scale. The filled area is the re-tuned model, coloured by what the mass is doing. \
         Numbers refer to the table below.",
    );
    page.raw("<div class=\"legend\">");
    for (i, regime) in Regime::ALL.iter().enumerate() {
        page.raw(&format!(
            "<span><i class=\"r{i}\"></i>{}</span>",
            escape(regime.text())
        ));
    }
    if !d.named.is_empty() {
        page.raw(&format!(
            "<span><i class=\"rule\"></i>{}</span>",
            with_named(d)
        ));
    }
    page.raw("<span><i class=\"dash\"></i>noise</span></div>\n");
    let scale = Scale::of(d);
    for held_out in [false, true] {
        let these: Vec<_> = d
            .strips
            .iter()
            .filter(|s| s.held_out == held_out && !s.time.is_empty())
            .collect();
        if these.is_empty() {
            continue;
        }
        page.heading(if held_out {
            "Held-out recordings"
        } else {
            "Fitted recordings"
        });
        for strip in these {
            let marked: Vec<_> = d
                .mismatch
                .iter()
                .take(NUMBERED)
                .enumerate()
                .filter(|(_, m)| m.recording == strip.recording)
                .collect();
            page.figure(&figure(d, strip, &scale, &marked), "");
        }
    }
}

fn worst(page: &mut Page, d: &Diagnosis) {
    page.heading("Segments with the largest excess over the noise");
    if d.mismatch.is_empty() {
        page.paragraph(
            "There is no segment in which the re-tuned model differs by more than the noise.",
        );
        return;
    }
    let rows: Vec<Vec<String>> = d
        .mismatch
        .iter()
        .take(NUMBERED)
        .enumerate()
        .map(|(i, m)| {
            vec![
                (i + 1).to_string(),
                share(m.share),
                m.recording.clone(),
                time_span(m),
                m.channel.to_owned(),
                m.regime.text().to_owned(),
            ]
        })
        .collect();
    let heads = [
        "",
        "share of the excess",
        "recording",
        "time",
        "channel",
        "regime",
    ];
    page.table(&heads, &rows, &[1]);
    let more = d.mismatch.len().saturating_sub(NUMBERED);
    if more > 0 {
        page.paragraph(&format!("{more} further segments are shorter or weaker."));
    }
}

fn marginals(page: &mut Page, d: &Diagnosis) {
    if d.marginals.is_empty() {
        return;
    }
    page.heading("What the residuals depend on");
    page.paragraph("Mean square of the residuals divided by that of the noise; 1 is noise alone.");
    page.raw("<div class=\"legend\"><span><i class=\"rule\" style=\"color:var(--before)\"></i>re-tuned model</span>");
    if !d.named.is_empty() {
        page.raw(&format!(
            "<span><i class=\"rule\" style=\"color:var(--after)\"></i>{}</span>",
            with_named(d)
        ));
    }
    page.raw("</div>\n<div class=\"grid2\">\n");
    let all: Vec<f64> = d
        .marginals
        .iter()
        .flat_map(|m| m.before.iter().chain(&m.after).copied())
        .chain([1.0])
        .collect();
    for marginal in &d.marginals {
        page.figure(&against(marginal, &all, !d.named.is_empty()), "");
    }
    page.raw("</div>\n");
}

/// One marginal; all of them have the same vertical scale.
fn against(m: &Marginal, all: &[f64], named: bool) -> String {
    let mut plot = Plot::new(
        [HALF, 190.0],
        Axis::linear(m.against, m.unit, m.at.iter().copied()),
        Axis::log("mean square / noise\u{b2}", "", all.iter().copied()),
    );
    plot.level("noise", 1.0);
    let mut draw = |class: &str, values: &[f64]| {
        let points = || m.at.iter().copied().zip(values.iter().copied());
        plot.line(class, points());
        let dots = points().map(|(x, y)| Dot {
            x,
            y,
            error: f64::NAN,
        });
        plot.dots(class, 2.0, dots);
    };
    draw("before", &m.before);
    if named {
        draw("after", &m.after);
    }
    plot.finish()
}
