//! The report as one page that needs nothing else: where, what, how much, proof, what is
//! left, what limits the answer, what to do next.

mod events;
mod location;
mod proof;
mod strip;
mod what;

use super::headline::verdict_sentence;
use super::svg::escape;
use super::words::{
    alike, capitalised, gain, in_noise, metres, no_experiment, probability, size, with_error,
    with_named, would_distinguish,
};
use super::{rest, sentences};
use crate::diagnose::diagnosis::{Diagnosis, Verdict};
use crate::model::parameter::PARAMETERS;
use crate::model::unit::format_quantity;

/// Colours and layout; figures take theirs from it.
const STYLE: &str = include_str!("page.css");
/// Width of a figure across the page \[pixels\].
const FULL: f64 = 860.0;
/// Width of one of two figures side by side.
const HALF: f64 = 424.0;

/// The diagnosis as a page of HTML with figures inside, for a browser or a printer. It
/// loads nothing and runs no script.
pub fn html(diagnosis: &Diagnosis) -> String {
    let mut page = Page::default();
    page.raw("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n");
    page.raw("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n");
    page.raw("<title>Diagnosis - impactscope</title>\n<style>\n");
    page.raw(STYLE);
    page.raw("</style>\n</head>\n<body>\n<main>\n");
    summary(&mut page, diagnosis);
    page.section("Where", |page| location::write(page, diagnosis));
    page.section("What", |page| {
        what::write(page, diagnosis);
        what::balance(page, diagnosis);
        events::write(page, diagnosis);
    });
    page.section("How much", |page| how_much(page, diagnosis));
    page.section("Proof", |page| proof::write(page, diagnosis));
    page.section("What is still not explained", |page| {
        page.list(&rest::sentences(diagnosis));
        what::remaining(page, diagnosis);
    });
    page.section("What limits this answer", |page| {
        if diagnosis.remarks.is_empty() {
            page.paragraph("Nothing was found that limits it.");
        }
        page.list(&sentences::remarks(&diagnosis.remarks));
    });
    page.section("Next experiment", |page| next(page, diagnosis));
    page.raw("<footer>Written by impactscope ");
    page.text(env!("CARGO_PKG_VERSION"));
    page.raw(".</footer>\n</main>\n</body>\n</html>\n");
    page.out
}

fn summary(page: &mut Page, d: &Diagnosis) {
    let kind = match d.verdict {
        Verdict::Adequate => "adequate",
        Verdict::MissingPhysics => "missing",
        Verdict::PartlyExplained => "partly",
        Verdict::Unexplained => "unexplained",
    };
    page.raw(&format!(
        "<header class=\"{kind}\">\n<p class=\"over\">Diagnosis</p>\n<h1>"
    ));
    page.text(&verdict_sentence(d));
    page.raw("</h1>\n<dl class=\"facts\">\n");
    let held_out = d.proof.iter().filter(|p| p.held_out).count();
    let fitted = d.proof.len() - held_out;
    let mut facts = vec![
        (
            "recordings",
            format!("{fitted} fitted, {held_out} held out"),
        ),
        ("noise of the proof mass", metres(d.noise)),
        (
            "held-out error, re-tuned model",
            in_noise(d.held_out.before.rms, d.noise),
        ),
    ];
    if !d.named.is_empty() {
        facts.push((
            if d.named.len() > 1 {
                "held-out error, with the new effects"
            } else {
                "held-out error, with the new effect"
            },
            in_noise(d.held_out.after.rms, d.noise),
        ));
    }
    for (name, value) in facts {
        page.raw("<div><dt>");
        page.text(name);
        page.raw("</dt><dd>");
        page.text(&value);
        page.raw("</dd></div>\n");
    }
    page.raw("</dl>\n");
    if d.cancelled {
        page.paragraph("Ended early: this is what was found so far.");
    }
    page.raw("</header>\n");
}

fn how_much(page: &mut Page, d: &Diagnosis) {
    if d.named.is_empty() {
        page.paragraph("No effect is named, so there is none to quantify.");
    }
    for effect in &d.named {
        page.raw("<h3>");
        page.text(&capitalised(&effect.name));
        page.raw(" <code>");
        page.text(&effect.id);
        page.raw("</code></h3>\n");
        page.paragraph(&format!(
            "Largest force over the recordings: {}. Probability: {}.",
            size(effect.size),
            probability(effect.probability)
        ));
        let spec = crate::model::effects::find(&effect.id);
        if let Some(spec) = spec {
            page.paragraph(&format!("Law: {}. {}", spec.law, spec.sentence));
        }
        let rows: Vec<Vec<String>> = effect
            .parameters
            .iter()
            .map(|p| {
                let known = spec.and_then(|s| s.parameters.iter().find(|q| q.id == p.id));
                vec![
                    p.id.clone(),
                    known.map_or_else(String::new, |q| q.name.to_owned()),
                    with_error(p),
                ]
            })
            .collect();
        page.table(&["parameter", "", "value"], &rows, &[]);
        if let Some(sentence) = alike(&effect.alike) {
            page.paragraph(&sentence);
        }
    }
    page.raw("<details>\n<summary>The model's own parameters, re-tuned</summary>\n");
    let rows: Vec<Vec<String>> = PARAMETERS
        .iter()
        .zip(d.baseline.parameters.iter())
        .zip(d.model.parameters.iter())
        .filter(|((_, (id, _)), _)| d.baseline.uses(*id))
        .map(|((spec, (_, before)), (_, after))| {
            vec![
                spec.id.to_owned(),
                spec.name.to_owned(),
                format_quantity(before, spec.unit, 4),
                format_quantity(after, spec.unit, 4),
            ]
        })
        .collect();
    let heads = ["parameter", "", "re-tuned", with_named(d)];
    page.table(&heads, &rows, &[2, 3]);
    page.raw("</details>\n");
}

fn next(page: &mut Page, d: &Diagnosis) {
    let Some(next) = &d.next_experiment else {
        page.paragraph(no_experiment(d));
        return;
    };
    page.raw("<p>Record the drive <code>");
    page.text(&next.drive);
    page.raw("</code>: ");
    page.text(&format!(
        "{}; their chi2 would differ by about {}.",
        would_distinguish(next),
        gain(next.expected)
    ));
    page.raw("</p>\n");
}

/// A page that grows. Every text passes through [`escape`].
#[derive(Debug, Default)]
pub struct Page {
    out: String,
}

impl Page {
    /// Markup, as it is.
    pub fn raw(&mut self, markup: &str) {
        self.out.push_str(markup);
    }

    /// Text.
    pub fn text(&mut self, text: &str) {
        self.out.push_str(&escape(text));
    }

    /// A section with what `inside` writes.
    fn section(&mut self, title: &str, inside: impl FnOnce(&mut Self)) {
        self.raw("<section>\n<h2>");
        self.text(title);
        self.raw("</h2>\n");
        inside(self);
        self.raw("</section>\n");
    }

    /// A heading within a section.
    pub fn heading(&mut self, title: &str) {
        self.raw("<h3>");
        self.text(title);
        self.raw("</h3>\n");
    }

    /// A paragraph of text.
    pub fn paragraph(&mut self, text: &str) {
        self.raw("<p>");
        self.text(text);
        self.raw("</p>\n");
    }

    /// A list of sentences; nothing if there are none.
    pub fn list(&mut self, sentences: &[String]) {
        if sentences.is_empty() {
            return;
        }
        self.raw("<ul>\n");
        for sentence in sentences {
            self.raw("<li>");
            self.text(sentence);
            self.raw("</li>\n");
        }
        self.raw("</ul>\n");
    }

    /// A table; columns in `right` hold numbers.
    pub fn table(&mut self, heads: &[&str], rows: &[Vec<String>], right: &[usize]) {
        let class = |i: usize| {
            if right.contains(&i) {
                " class=\"n\""
            } else {
                ""
            }
        };
        self.raw("<div class=\"wide\"><table>\n<thead><tr>");
        for (i, head) in heads.iter().enumerate() {
            self.raw(&format!("<th{}>", class(i)));
            self.text(head);
            self.raw("</th>");
        }
        self.raw("</tr></thead>\n<tbody>\n");
        for row in rows {
            self.raw("<tr>");
            for (i, cell) in row.iter().enumerate() {
                self.raw(&format!("<td{}>", class(i)));
                self.text(cell);
                self.raw("</td>");
            }
            self.raw("</tr>\n");
        }
        self.raw("</tbody></table></div>\n");
    }

    /// A figure with a caption.
    pub fn figure(&mut self, svg: &str, caption: &str) {
        self.raw("<figure>\n");
        self.raw(svg);
        if !caption.is_empty() {
            self.raw("<figcaption>");
            self.text(caption);
            self.raw("</figcaption>\n");
        }
        self.raw("</figure>\n");
    }
}
