//! The table: header, columns, rows.

use super::command_line::Sweep;
use crate::explore::map::MapPoint;
use crate::explore::measures::{MeasureId, Regime};
use crate::explore::robustness::Robustness;

/// Line that says which part a file is.
pub const SHARD_LINE: &str = "# shard: ";
/// Line that says that points are missing.
pub const INCOMPLETE_LINE: &str = "# incomplete: ";
/// Significant digits less one: far beyond any accuracy, and the last bits of the elementary functions of
/// different machines do not show.
const DECIMALS: usize = 8;
/// Sizes that are written without an exponent.
const PLAIN_SIZES: std::ops::Range<f64> = 1e-4..1e9;

/// A table on its way to a file.
pub struct Table {
    /// Lines before the columns.
    header: Vec<String>,
    columns: String,
    /// Lines of the points.
    pub rows: Vec<String>,
    /// Impossible points.
    pub holes: usize,
    /// Why the first of them is.
    pub first_hole: Option<String>,
}

impl Table {
    /// Without rows yet.
    pub fn new(sweep: &Sweep) -> Self {
        let mut header = sweep.header.clone();
        if let Some((part, parts)) = sweep.shard {
            header.push(format!("{SHARD_LINE}{part}/{parts}"));
        }
        let named = |name: &str, unit: &str| {
            if unit.is_empty() {
                name.to_owned()
            } else {
                format!("{name} [{unit}]")
            }
        };
        let axes = sweep
            .map
            .axes
            .iter()
            .map(|axis| named(&axis.id, &axis.unit));
        let mut columns: Vec<String> = std::iter::once("point".to_owned()).chain(axes).collect();
        if sweep.robustness.is_some() {
            let own = ["probability", "std_error", "failed_members", "breaks_first"];
            columns.extend(own.map(str::to_owned));
            columns.extend(["regime".to_owned(), "regime_share".to_owned()]);
        }
        for measure in &sweep.map.measures {
            let spec = measure.spec();
            match (&sweep.robustness, measure) {
                (Some(_), MeasureId::Regime) => {}
                (Some(_), _) => {
                    let quantiles = ["5%", "50%", "95%"];
                    columns
                        .extend(quantiles.map(|q| named(&format!("{} {q}", spec.id), spec.unit)));
                }
                (None, _) => columns.push(named(spec.id, spec.unit)),
            }
        }
        columns.push("hole".to_owned());
        Self {
            header,
            columns: columns.join(","),
            rows: Vec::new(),
            holes: 0,
            first_hole: None,
        }
    }

    /// Says that only some of so many points are there.
    pub fn note_incomplete(&mut self, points: usize) {
        let line = format!(
            "{INCOMPLETE_LINE}{} of {points} points, cancelled",
            self.rows.len()
        );
        self.header.push(line);
    }

    /// A point of a map.
    pub fn add_point(&mut self, sweep: &Sweep, point: &MapPoint) {
        let measures = &sweep.map.measures;
        let cells = match &point.values {
            Ok(values) => {
                let own = measures.iter().zip(values);
                Ok(own.map(|(measure, value)| cell(*measure, *value)).collect())
            }
            Err(reason) => Err(reason.as_str()),
        };
        self.add(sweep, point.index, cells, measures.len());
    }

    /// A point with what an ensemble says of it.
    pub fn add_answer(&mut self, sweep: &Sweep, index: usize, answer: &Result<Robustness, String>) {
        let of_measures = sweep
            .map
            .measures
            .iter()
            .filter(|m| **m != MeasureId::Regime);
        let count = 6 + 3 * of_measures.count();
        let cells = match answer {
            Ok(own) => Ok(robust_cells(own)),
            Err(reason) => Err(reason.as_str()),
        };
        self.add(sweep, index, cells, count);
    }

    fn add(&mut self, sweep: &Sweep, index: usize, cells: Result<Vec<String>, &str>, count: usize) {
        let axes = sweep.map.values_at(index).into_iter().map(number);
        let mut row: Vec<String> = std::iter::once(index.to_string()).chain(axes).collect();
        match cells {
            Ok(cells) => {
                row.extend(cells);
                row.push(String::new());
            }
            Err(reason) => {
                row.extend(std::iter::repeat_n(String::new(), count));
                row.push(text(reason));
                self.holes += 1;
                self.first_hole.get_or_insert_with(|| reason.to_owned());
            }
        }
        self.rows.push(row.join(","));
    }

    /// The whole file.
    pub fn text(&self) -> String {
        let lines = self
            .header
            .iter()
            .chain(std::iter::once(&self.columns))
            .chain(&self.rows);
        let mut text = String::new();
        for line in lines {
            text += line;
            text.push('\n');
        }
        text
    }
}

fn robust_cells(own: &Robustness) -> Vec<String> {
    let breaker = own.breaker.as_ref().map_or(String::new(), |breaker| {
        let way = if breaker.difference > 0.0 {
            "larger"
        } else {
            "smaller"
        };
        text(&format!("{way} {}", breaker.id))
    });
    let (regime, share) = match own.regimes.first() {
        Some((regime, share)) => (text(&regime.label()), number(*share)),
        None => (String::new(), String::new()),
    };
    let mut cells = vec![
        number(own.probability),
        number(own.std_error()),
        own.failed.to_string(),
        breaker,
        regime,
        share,
    ];
    for quantiles in &own.quantiles {
        cells.extend([quantiles.low, quantiles.median, quantiles.high].map(number));
    }
    cells
}

fn cell(measure: MeasureId, value: f64) -> String {
    match measure {
        MeasureId::Regime => {
            let regime = Regime::from_code(value as u32).filter(|_| value >= 0.0);
            regime.map_or_else(|| number(value), |own| text(&own.label()))
        }
        _ => number(value),
    }
}

/// A number in the fewest digits, at most nine; empty for NaN.
fn number(value: f64) -> String {
    if value.is_nan() {
        return String::new();
    }
    let rounded = format!("{value:.DECIMALS$e}").parse().unwrap_or(value);
    if rounded == 0.0 {
        "0".to_owned()
    } else if PLAIN_SIZES.contains(&f64::abs(rounded)) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

/// A text as a cell, on one line.
fn text(text: &str) -> String {
    let one_line = text.replace(['\n', '\r'], " ");
    if one_line.contains([',', '"']) {
        format!("\"{}\"", one_line.replace('"', "\"\""))
    } else {
        one_line
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::*;

    #[test]
    fn numbers_and_texts_are_read_back() {
        for value in [0.1, -2.5e-21, 1.0 / 3.0, 6e12, 100.0, f64::INFINITY] {
            let back: f64 = number(value).parse().unwrap();
            assert!(
                back == value || (back / value - 1.0).abs() < 1e-8,
                "{value}"
            );
        }
        assert_eq!(
            (number(f64::NAN), number(-0.0)),
            (String::new(), "0".to_owned())
        );
        assert_eq!(number(0.1 + 0.2), "0.3");
        assert_eq!(
            text("bounces, then \"sticks\""),
            "\"bounces, then \"\"sticks\"\"\""
        );
    }
}
