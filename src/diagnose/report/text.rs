//! The summary for the terminal.

use super::headline::verdict_sentence;
use super::words::{
    alike, capitalised, chi2, gain, in_noise, metres, no_experiment, probability, share, size,
    time_span, with_error, would_distinguish,
};
use super::{rest, sentences};
use crate::diagnose::diagnosis::{BeforeAfter, Diagnosis, Verdict};
use crate::model::effects::find;

/// Places of mismatch that are listed.
const MAX_PLACES: usize = 6;
/// Candidates that are listed where nothing or several could be named.
const MAX_CANDIDATES: usize = 5;

/// The diagnosis as a person reads it on a terminal, at most 100 columns where the names
/// of the recordings allow.
pub fn text(diagnosis: &Diagnosis) -> String {
    let mut out = Lines::default();
    if diagnosis.cancelled {
        out.line("Ended early: this is what was found so far.");
    }
    out.line(&verdict_sentence(diagnosis));
    what(&mut out, diagnosis);
    location(&mut out, diagnosis);
    proof(&mut out, diagnosis);
    out.head("What is still not explained");
    for sentence in rest::sentences(diagnosis) {
        out.item(&sentence);
    }
    if !diagnosis.remarks.is_empty() {
        out.head("What limits this answer");
        for remark in sentences::remarks(&diagnosis.remarks) {
            out.item(&remark);
        }
    }
    if let Some(next) = &diagnosis.next_experiment {
        out.head("Next experiment");
        out.item(&format!(
            "drive {}: {} (their chi2 would differ by about {})",
            next.drive,
            would_distinguish(next),
            gain(next.expected)
        ));
    } else if diagnosis.remaining.is_some() {
        out.head("Next experiment");
        out.item(no_experiment(diagnosis));
    }
    out.text
}

fn what(out: &mut Lines, diagnosis: &Diagnosis) {
    for effect in &diagnosis.named {
        out.head(&format!(
            "{} ({}): probability {}, largest force {}",
            capitalised(&effect.name),
            effect.id,
            probability(effect.probability),
            size(effect.size)
        ));
        let rows: Vec<Vec<String>> = effect
            .parameters
            .iter()
            .map(|p| vec![p.id.clone(), with_error(p)])
            .collect();
        out.table(&rows, &[]);
        if let Some(spec) = find(&effect.id) {
            out.item(&format!("law: {}", spec.law));
        }
        let evidence = effect.evidence.iter().map(sentences::evidence);
        for sentence in evidence.chain(alike(&effect.alike)) {
            out.item(&sentence);
        }
    }
    if diagnosis.verdict == Verdict::Unexplained && !diagnosis.candidates.is_empty() {
        out.head("Closest effects of the catalogue");
        let mut rows = vec![columns(["", "probability", "held-out chi2"])];
        let asked = diagnosis.candidates.iter();
        let asked = asked.filter(|c| c.gain.is_finite() || c.score > 0.0);
        rows.extend(asked.take(MAX_CANDIDATES).map(|c| {
            columns([
                c.name.as_str(),
                &probability(c.probability),
                &chi2(c.held_out_chi2),
            ])
        }));
        out.table(&rows, &[1, 2]);
    }
}

fn location(out: &mut Lines, diagnosis: &Diagnosis) {
    if diagnosis.mismatch.is_empty() {
        return;
    }
    out.head("Where the re-tuned model differs from the recordings");
    let rows: Vec<Vec<String>> = diagnosis
        .mismatch
        .iter()
        .take(MAX_PLACES)
        .map(|m| {
            columns([
                &share(m.share),
                m.recording.as_str(),
                &time_span(m),
                m.channel,
                m.regime.text(),
            ])
        })
        .collect();
    out.table(&rows, &[0]);
    let more = diagnosis.mismatch.len().saturating_sub(MAX_PLACES);
    if more > 0 {
        out.item(&format!("and {more} shorter or weaker segments"));
    }
}

fn proof(out: &mut Lines, diagnosis: &Diagnosis) {
    out.head("Proof: rms of simulation minus recording, proof mass");
    let changed = !diagnosis.named.is_empty();
    let row = |name: &str, noise: f64, both: &BeforeAfter| {
        let mut cells = vec![
            name.to_owned(),
            metres(noise),
            metres(both.before.rms),
            in_noise(both.before.rms, noise),
            chi2(both.before.chi2),
        ];
        if changed {
            cells.extend([
                metres(both.after.rms),
                in_noise(both.after.rms, noise),
                chi2(both.after.chi2),
            ]);
        }
        cells
    };
    let mut header = columns(["", "noise", "before", "", "chi2"]);
    if changed {
        header.extend(columns(["after", "", "chi2"]));
    }
    let mut rows = vec![header];
    for (held_out, title, all) in [
        (true, "all held-out", &diagnosis.held_out),
        (false, "all fitted", &diagnosis.train),
    ] {
        let each: Vec<_> = diagnosis
            .proof
            .iter()
            .filter(|p| p.held_out == held_out)
            .collect();
        if each.is_empty() {
            continue;
        }
        rows.push(row(title, diagnosis.noise, all));
        if each.len() > 1 {
            rows.extend(
                each.iter()
                    .map(|p| row(&format!("  {}", p.recording), p.noise, &p.distance)),
            );
        }
    }
    out.table(&rows, &[1, 2, 3, 4, 5, 6, 7]);
}

fn columns<const N: usize>(cells: [&str; N]) -> Vec<String> {
    cells.map(str::to_owned).into()
}

/// Text that grows line by line.
#[derive(Default)]
struct Lines {
    text: String,
}

impl Lines {
    fn line(&mut self, line: &str) {
        self.text.push_str(line.trim_end());
        self.text.push('\n');
    }

    fn head(&mut self, title: &str) {
        self.line("");
        self.line(title);
    }

    /// A sentence, broken at 96 columns.
    fn item(&mut self, sentence: &str) {
        let mut line = String::from("  -");
        for word in sentence.split_whitespace() {
            if line.chars().count() + word.chars().count() > 95 {
                self.line(&line);
                line = String::from("   ");
            }
            line.push(' ');
            line.push_str(word);
        }
        self.line(&line);
    }

    /// Columns as wide as their widest cell; those in `right` end together.
    fn table(&mut self, rows: &[Vec<String>], right: &[usize]) {
        let count = rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |column: usize| {
            let cells = rows.iter().filter_map(|row| row.get(column));
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..count).map(width).collect();
        for row in rows {
            let mut line = String::from(" ");
            for (i, cell) in row.iter().enumerate() {
                let w = widths[i];
                line.push_str(&if right.contains(&i) {
                    format!(" {cell:>w$} ")
                } else {
                    format!(" {cell:<w$} ")
                });
            }
            self.line(&line);
        }
    }
}
