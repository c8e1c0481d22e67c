//! "Proof": distances before and after on each recording, held-out ones first.

use super::{FULL, Page};
use crate::diagnose::diagnosis::{BeforeAfter, Diagnosis, ProofOf};
use crate::diagnose::report::svg::axis::Axis;
use crate::diagnose::report::svg::{Anchor, Svg, escape};
use crate::diagnose::report::words::{chi2, in_noise, metres, share, two_digits, with_named};

/// Space for the names of the recordings, and for the numbers behind the bars.
const LEFT: f64 = 190.0;
const RIGHT: f64 = 170.0;
/// Heights: of a bar, of a recording's pair of bars with its space, above the first and
/// below the last.
const BAR: f64 = 14.0;
const ROW: f64 = 42.0;
const TOP: f64 = 44.0;
const BOTTOM: f64 = 40.0;
/// Room that the numbers behind a bar take.
const NUMBERS: f64 = 130.0;
/// Longest name that fits the space.
const NAME: usize = 26;

/// Writes the section's inside.
pub fn write(page: &mut Page, d: &Diagnosis) {
    let kept: Vec<&ProofOf> = d.proof.iter().filter(|p| p.held_out).collect();
    let fitted: Vec<&ProofOf> = d.proof.iter().filter(|p| !p.held_out).collect();
    let named = !d.named.is_empty();
    page.paragraph(
        "Root mean square of simulation minus recording, proof mass. Held-out recordings \
         took no part in any fit; only an improvement on them counts.",
    );
    page.raw("<div class=\"legend\"><span><i style=\"background:var(--before)\"></i>re-tuned model</span>");
    if named {
        page.raw(&format!(
            "<span><i style=\"background:var(--after)\"></i>{}</span>",
            with_named(d)
        ));
    }
    page.raw("<span><i class=\"dash\"></i>noise</span></div>\n");
    let all: Vec<&ProofOf> = kept.iter().chain(&fitted).copied().collect();
    for (title, these) in [
        ("Held-out recordings", &kept),
        ("Fitted recordings", &fitted),
    ] {
        if !these.is_empty() {
            page.heading(title);
            page.figure(&bars(d, these, &all), "");
        }
    }
    table(page, d, &kept, &fitted);
}

/// A pair of bars for each of `these` on a scale that holds `all`.
fn bars(d: &Diagnosis, these: &[&ProofOf], all: &[&ProofOf]) -> String {
    let named = !d.named.is_empty();
    let height = TOP + ROW * these.len() as f64 + BOTTOM;
    let longest = all
        .iter()
        .flat_map(|p| [p.distance.before.rms, p.distance.after.rms, 1.2 * p.noise])
        .filter(|v| v.is_finite())
        .fold(0.0, f64::max);
    let axis = Axis::exact("rms", "m", 0.0, longest);
    let in_noise_axis = Axis::exact("rms / noise", "", 0.0, longest / d.noise);
    let x = |share: f64| LEFT + share * (FULL - RIGHT - LEFT);
    let mut svg = Svg::new(FULL, height, "distances before and after");
    let foot = height - BOTTOM;
    for (value, label) in axis.ticks(6) {
        let at = x(axis.place(value));
        svg.segment("grid", [at, TOP], [at, foot]);
        svg.text("tick", [at, foot + 15.0], Anchor::Middle, &label);
    }
    for (value, label) in in_noise_axis.ticks(6) {
        let at = x(in_noise_axis.place(value));
        svg.segment("axis", [at, TOP - 4.0], [at, TOP]);
        svg.text("tick", [at, TOP - 8.0], Anchor::Middle, &label);
    }
    let middle = x(0.5);
    svg.text(
        "title",
        [middle, height - 6.0],
        Anchor::Middle,
        &axis.title(),
    );
    svg.text(
        "title",
        [middle, 14.0],
        Anchor::Middle,
        "in units of the noise",
    );
    svg.segment("axis", [x(0.0), TOP], [x(1.0), TOP]);
    svg.segment("axis", [x(0.0), foot], [x(1.0), foot]);
    for (i, p) in these.iter().enumerate() {
        let top = TOP + ROW * i as f64;
        let middle = top + 0.5 * ROW;
        svg.text(
            "label",
            [LEFT - 8.0, middle + 4.0],
            Anchor::End,
            &short(&p.recording),
        );
        let noise = x(axis.place(p.noise));
        let pairs = [
            ("before", p.distance.before.rms),
            ("after", p.distance.after.rms),
        ];
        let shown = if named { 2 } else { 1 };
        let first = middle - 0.5 * BAR * shown as f64;
        for (k, (class, rms)) in pairs.into_iter().take(shown).enumerate() {
            let y = first + BAR * k as f64;
            let end = if rms.is_finite() {
                x(axis.place(rms))
            } else {
                x(0.0)
            };
            svg.rectangle(class, [x(0.0), y], [end - x(0.0), BAR - 1.0]);
            let words = if rms.is_finite() {
                format!("{}, {}", metres(rms), in_noise(rms, p.noise))
            } else {
                "not compared".to_owned()
            };
            // Numbers stand clear of the mark of the noise.
            let clear = (end..end + NUMBERS).contains(&noise);
            let from = if clear { noise } else { end };
            svg.text("note", [from + 6.0, y + BAR - 3.0], Anchor::Start, &words);
        }
        svg.segment("noise", [noise, top + 3.0], [noise, top + ROW - 3.0]);
    }
    svg.finish()
}

/// A name that fits, its end kept: that is where names of files differ.
fn short(name: &str) -> String {
    let count = name.chars().count();
    if count <= NAME {
        return name.to_owned();
    }
    let end: String = name.chars().skip(count - NAME + 3).collect();
    format!("...{end}")
}

fn table(page: &mut Page, d: &Diagnosis, kept: &[&ProofOf], fitted: &[&ProofOf]) {
    let named = !d.named.is_empty();
    page.raw("<div class=\"wide\"><table>\n<thead><tr><th>recording</th>");
    let heads = [
        "noise",
        "compared",
        "before",
        "",
        "chi2",
        "after",
        "",
        "chi2",
        "lag-1 correlation",
    ];
    let shown = |i: usize| named || !(5..8).contains(&i);
    for (_, head) in heads.iter().enumerate().filter(|(i, _)| shown(*i)) {
        page.raw(&format!("<th class=\"n\">{head}</th>"));
    }
    page.raw("</tr></thead>\n<tbody>\n");
    let mut row = |class: &str, name: &str, noise: f64, rest: [String; 2], both: &BeforeAfter| {
        page.raw(&format!("<tr class=\"{class}\"><td>"));
        page.text(name);
        page.raw("</td>");
        let [covered, white] = rest;
        let cells = [
            metres(noise),
            covered,
            metres(both.before.rms),
            in_noise(both.before.rms, noise),
            chi2(both.before.chi2),
            metres(both.after.rms),
            in_noise(both.after.rms, noise),
            chi2(both.after.chi2),
            white,
        ];
        for (_, cell) in cells.iter().enumerate().filter(|(i, _)| shown(*i)) {
            page.raw(&format!("<td class=\"n\">{}</td>", escape(cell)));
        }
        page.raw("</tr>\n");
    };
    let sets = [
        ("all held-out", kept, &d.held_out),
        ("all fitted", fitted, &d.train),
    ];
    for (title, these, all) in sets {
        if these.is_empty() {
            continue;
        }
        row("all", title, d.noise, [String::new(), String::new()], all);
        for p in these {
            let (before, after) = p.correlation;
            let white = if named {
                format!("{} to {}", two_digits(before), two_digits(after))
            } else {
                two_digits(before)
            };
            let rest = [share(p.covered), white];
            row("one", &p.recording, p.noise, rest, &p.distance);
        }
    }
    page.raw("</tbody></table></div>\n");
    page.paragraph(
        "chi2 is the mean square of the residuals in units of their noise, 1 where nothing \
         is missing. Lag-1 correlation: of successive residuals, near 0 for white noise.",
    );
}
