//! What a file seems to be: encoding, delimiter, decimal mark, comments, header, columns.

mod way;

use self::way::{Way, best_way, first_row, fixed_width, reshaped};
use crate::recording::csv::columns::header_line::{HeaderLine, find_header_line};
use crate::recording::csv::columns::sample::{self, certain_decimal};
use crate::recording::csv::columns::{
    Mapping, TableFacts, Topic, header_clock, map_by_count, map_header,
};
use crate::recording::csv::line::{is_skipped, show, show_row, uncomment};
use crate::recording::csv::number::marks::{Evidence, Verdict};
use crate::recording::csv::preview::{Preview, Trial};
use crate::recording::csv::scopes::{self, Head, ScopeHeader};
use crate::recording::csv::settings::{Decimal, Delimiter, ImportSettings};
use crate::recording::csv::text::Text;
use crate::recording::csv::text::encoding::{decode, encoding_warning};
use crate::recording::csv::text::reshape::labels;
use crate::recording::error::{ImportError, visible};

/// Rows shown.
const SHOWN_ROWS: usize = 20;
/// Lines looked at, so that a file of empty lines costs nothing.
const MAX_LINES: usize = 2000;

/// Looks at the beginning of a file, and at parts of its middle and end. With `cut` the beginning is
/// not all of it.
pub(super) fn look(
    file: &str,
    head: &[u8],
    cut: bool,
    probes: &[&[u8]],
) -> Result<Preview, ImportError> {
    let decoded = decode(head, None, cut);
    let text = Text::new(file, &decoded.bytes)?;
    // The last line of a longer file is cut in the middle: leave it out.
    let whole = if cut {
        let end = text.bytes.iter().rposition(|b| *b == text.newline);
        text.bytes
            .get(..end.map_or(text.bytes.len(), |p| p + 1))
            .unwrap_or_default()
    } else {
        text.bytes
    };
    text.check(file, 0..whole.len(), 1)?;
    let raw: Vec<&[u8]> = text.split(whole).take(MAX_LINES).collect();
    // The first and last line of a probe are parts of lines.
    let mut sample = raw.clone();
    if decoded.from.is_none() {
        for probe in probes {
            let inner: Vec<&[u8]> = text.split(probe).collect();
            let whole = inner.get(1..inner.len().saturating_sub(1));
            sample.extend(whole.unwrap_or_default());
        }
    }
    let no_numbers = || ImportError::NoNumbers {
        file: file.into(),
        line: 1 + raw
            .iter()
            .position(|l| !l.trim_ascii().is_empty())
            .unwrap_or(0),
    };
    let mut way = best_way(&sample).ok_or_else(no_numbers)?;
    if way.delimiter == Delimiter::Spaces
        && let Some(fixed) = fixed_width(&raw, &way)
    {
        way = fixed;
    }
    let scope = scopes::recognise(&Head { lines: &raw });
    let shaped = reshaped(&sample, way.delimiter, &way.cell_ends);
    let sample: Vec<&[u8]> = shaped.split(|b| *b == b'\n').collect();
    let lines = sample.get(..raw.len()).unwrap_or(&sample);
    let start = first_row(lines, way.delimiter.byte(), &way).ok_or_else(no_numbers)?;
    let table = Table {
        file,
        raw: &raw,
        lines,
        sample: &sample,
        way: &way,
        first: start.0,
        columns: start.1,
    };
    let mut preview = table.preview(scope)?;
    if let Some(encoding) = decoded.from.filter(|_| decoded.guessed) {
        preview.settings.encoding = Some(encoding);
        let warning = encoding_warning(encoding);
        preview.warnings.insert(0, warning);
    }
    Ok(preview)
}

/// A file's lines, divided into cells.
struct Table<'a> {
    file: &'a str,
    /// Lines as they are in the file.
    raw: &'a [&'a [u8]],
    /// The same with one byte between cells.
    lines: &'a [&'a [u8]],
    /// The same with lines from the middle and the end of the file.
    sample: &'a [&'a [u8]],
    way: &'a Way,
    /// Index of the first row of numbers.
    first: usize,
    /// Number of its cells.
    columns: usize,
}

impl Table<'_> {
    fn header(&self, scope: Option<&ScopeHeader>) -> Option<HeaderLine> {
        let plain = |cells: Vec<String>, line: usize, next_line: usize| HeaderLine {
            line,
            next_line,
            cells,
            labels: Vec::new(),
            unknown_units: Vec::new(),
        };
        if let Some(scope) = scope {
            // usize::MAX: the preamble stands beside the rows.
            let next = scope.last_line.checked_add(1).unwrap_or(0);
            return Some(plain(scope.cells.clone(), next.saturating_sub(1), next));
        }
        if self.way.delimiter == Delimiter::Labels {
            let found = self.raw.iter().find_map(|line| labels(line))?;
            let cell = |bytes: &[u8]| show(bytes);
            let cells = found.iter().map(|label| match label.unit {
                b"" => cell(label.name),
                unit => format!("{} [{}]", cell(label.name), cell(unit)),
            });
            return Some(plain(cells.collect(), self.first, self.first));
        }
        let before = self.lines.get(..self.first).unwrap_or_default();
        find_header_line(before, self.way.delimiter.byte(), self.columns)
    }

    fn preview(&self, scope: Option<ScopeHeader>) -> Result<Preview, ImportError> {
        let (file, way) = (self.file, self.way);
        let delimiter = way.delimiter.byte();
        let heading = self.header(scope.as_ref());
        let named = heading.as_ref().map_or_else(Vec::new, |h| h.cells.clone());
        // One name per two cells: "0,001;..." written with commas for both purposes.
        if way.delimiter == Delimiter::Comma && named.len() >= 2 && self.columns == 2 * named.len()
        {
            return Err(ImportError::AmbiguousComma {
                file: file.into(),
                line: self.first + 1,
                cells: self.columns,
                names: named.len(),
            });
        }
        let skip_lines = heading.as_ref().map_or(self.first, |h| h.next_line);
        let header_line = heading.as_ref().map_or(skip_lines, |h| h.line);
        let comments: Vec<String> = self
            .raw
            .get(..header_line.min(self.raw.len()))
            .unwrap_or_default()
            .iter()
            .filter(|line| !line.trim_ascii().is_empty())
            .map(|line| show(uncomment(line).unwrap_or(line)))
            .collect();
        let rows: Vec<&[u8]> = self
            .sample
            .iter()
            .skip(skip_lines)
            .copied()
            .filter(|line| !is_skipped(line, delimiter))
            .collect();
        let count = self.columns.max(named.len()).max(way.columns);
        // The time is judged by rows that follow each other.
        let head_rows = rows
            .get(..rows.len().min(self.lines.len()))
            .unwrap_or(&rows);
        let (_, evidence) = sample::columns(&rows, delimiter, count, Decimal::Point);
        let decimal = certain_decimal(&evidence, delimiter).unwrap_or_default();
        let (samples, _) = sample::columns(head_rows, delimiter, count, decimal);
        let mut settings = ImportSettings {
            delimiter: way.delimiter,
            cell_ends: way.cell_ends.clone(),
            decimal,
            skip_lines,
            ..ImportSettings::default()
        };
        let facts = TableFacts {
            file,
            line: heading.as_ref().map_or(self.first, |h| h.line) + 1,
            samples: &samples,
            clock: scope
                .as_ref()
                .and_then(|s| s.clock)
                .or_else(|| header_clock::find(&comments)),
            unknown_units: heading.as_ref().map_or(&[], |h| &h.unknown_units),
            is_si: scope.as_ref().is_some_and(|s| s.is_si),
        };
        let mut mapping = match &heading {
            Some(h) => map_header(&facts, &named, &h.labels, &mut settings),
            None => map_by_count(&facts, self.columns, &mut settings),
        };
        self.ask_decimal(&evidence, &settings, &mut mapping);
        let shown = rows
            .iter()
            .take(SHOWN_ROWS)
            .map(|line| show_row(line, delimiter));
        Ok(Preview {
            name: visible(file),
            size: 0,
            written_by: scope.map(|s| s.maker.to_owned()),
            comments,
            columns: count,
            rows: shown.collect(),
            header: named,
            settings,
            ambiguities: mapping.ambiguities,
            warnings: mapping.warnings,
            trials: mapping
                .trials
                .into_iter()
                .map(|t| Trial {
                    name: t.name,
                    columns: Some(t.choices),
                })
                .collect(),
            is_text: true,
            questions: mapping.questions,
            samples,
        })
    }

    /// Asks for the decimal mark where the cells of a column that is read allow both.
    fn ask_decimal(&self, evidence: &[Evidence], settings: &ImportSettings, mapping: &mut Mapping) {
        let others = certain_decimal(evidence, self.way.delimiter.byte());
        let chosen = [
            &settings.time,
            &settings.voltage,
            &settings.proof_mass,
            &settings.cantilever,
        ];
        let open = chosen.into_iter().flatten().find(|choice| {
            let own = evidence.get(choice.index);
            own.is_some_and(|own| matches!(own.judge(others, settings.decimal), Verdict::Open(_)))
        });
        let Some(choice) = open else { return };
        let question = format!(
            "in column {} a point or a comma stands before three digits in each number: a decimal mark, or one between thousands",
            choice.index + 1
        );
        let error = ImportError::Undecided {
            file: self.file.into(),
            line: self.first + 1,
            question: question.clone().into(),
            options: "--decimal point or --decimal comma".into(),
        };
        mapping.ask(Topic::Decimal, error, question);
    }
}
