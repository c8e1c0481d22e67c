//! Universal files (`.uff`, `.unv`): functions at nodal degrees of freedom, dataset 58, as text or
//! binary (58b).
//!
//! Source: SDRC/UC-SDRL, "Universal File Datasets Summary", 58, 58b and 164. Functions of time are
//! read; spectra and frequency responses are left out and said.

mod ascii;
mod binary;
mod function;
mod units;

use self::function::{Function, Header};
use self::units::{Units, read_units};
use super::arrays::{Arrays, NamedArray, stem};
use super::error::{FileContext, FormatError};
use super::format::{Format, FormatContent};
use super::lines::Lines;
use crate::recording::formats::raw_table::SampleClock;

/// Reads `.uff` files.
#[derive(Debug)]
pub struct Uff;

const NAME: &str = "UFF";

impl Format for Uff {
    fn id(&self) -> &'static str {
        "uff"
    }

    fn name(&self) -> &'static str {
        NAME
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["uff", "unv", "uf", "58"]
    }

    fn recognises(&self, head: &[u8], _file_name: &str) -> bool {
        let mut lines = Lines::new(head).skip_while(|line| line.trim_ascii().is_empty());
        let number = |line: &[u8]| {
            let number = line.get(..6).unwrap_or(line).trim_ascii();
            !number.is_empty() && number.iter().all(u8::is_ascii_digit)
        };
        lines.next().is_some_and(is_delimiter) && lines.next().is_some_and(number)
    }

    fn read(&self, file: &str, bytes: &[u8]) -> Result<FormatContent, FormatError> {
        let context = FileContext { file, format: NAME };
        let mut found = Found::default();
        let mut lines = Lines::new(bytes);
        // Bytes after a binary dataset may be the delimiter without a line of its own.
        while let Some(line) = lines.next() {
            if !is_delimiter(line) {
                continue;
            }
            let Some(first) = lines.next() else { break };
            // The end of one dataset, then the start of the next.
            let first = if is_delimiter(first) {
                lines.next()
            } else {
                Some(first)
            };
            let Some(first) = first else { break };
            found.read_set(&context, bytes, &mut lines, first)?;
        }
        found.into_content(&context)
    }
}

/// A line with -1 in its first six columns.
fn is_delimiter(line: &[u8]) -> bool {
    line.len() >= 2 && line.trim_ascii() == b"-1"
}

/// What a file holds.
#[derive(Default)]
struct Found {
    units: Option<Units>,
    arrays: Arrays,
    /// Times of the last function with uneven spacing, and the folder of its table.
    uneven: Option<(Vec<f64>, String)>,
    sets: usize,
    other_sets: usize,
}

impl Found {
    /// Reads one dataset, whose first line is `first`, up to its closing delimiter.
    fn read_set(
        &mut self,
        context: &FileContext,
        bytes: &[u8],
        lines: &mut Lines,
        first: &[u8],
    ) -> Result<(), FormatError> {
        match first.get(..6).unwrap_or(first).trim_ascii() {
            b"58" => {
                self.sets += 1;
                let header = Header::read(context, first, lines)?;
                if let Some(reason) = header.no_time_history() {
                    self.arrays
                        .left_out
                        .push(format!("{} ({reason})", header.name()));
                }
                let function = if header.is_binary() {
                    binary::read(context, &header, bytes, lines)?
                } else {
                    ascii::read(context, &header, lines)?
                };
                if header.no_time_history().is_none() {
                    self.add(&header, function);
                }
            }
            b"164" => self.units = read_units(lines).or(self.units.take()),
            _ => self.other_sets += 1,
        }
        // To the end of the set; a data line of other sets is never -1 alone.
        for line in lines.by_ref() {
            if is_delimiter(line) {
                break;
            }
        }
        Ok(())
    }

    fn add(&mut self, header: &Header, function: Function) {
        let name = header.name();
        let mut values = function.ordinate;
        self.arrays.notes.extend(function.notes);
        let (unit, note) = units::apply(header, self.units.as_ref(), &mut values);
        self.arrays.notes.extend(note);
        let (scale, note) = header.seconds();
        self.arrays.notes.extend(note);
        let mut parent = String::new();
        let mut clock = None;
        match function.abscissa {
            None => {
                clock = SampleClock::new(header.start * scale, header.interval * scale);
                if clock.is_none() {
                    self.arrays.notes.push(format!(
                        "\"{name}\": the file gives no interval between samples; give the sampling rate."
                    ));
                }
            }
            Some(mut times) => {
                times.iter_mut().for_each(|t| *t *= scale);
                parent = match self.uneven.take() {
                    Some((last, parent)) if last == times => parent,
                    _ => {
                        let parent = format!("function {}", self.sets);
                        self.arrays.arrays.push(NamedArray {
                            parent: parent.clone(),
                            name: "time".to_owned(),
                            unit: Some("s".to_owned()),
                            values: times.clone(),
                            clock: None,
                        });
                        parent
                    }
                };
                self.uneven = Some((times, parent.clone()));
            }
        }
        self.arrays.arrays.push(NamedArray {
            parent,
            name,
            unit,
            values,
            clock,
        });
    }

    fn into_content(mut self, context: &FileContext) -> Result<FormatContent, FormatError> {
        if self.arrays.arrays.is_empty() {
            if self.sets == 0 {
                return Err(context.unsupported(
                    format!(
                        "none of its {} datasets is a function (58)",
                        self.other_sets
                    ),
                    "export the measured time histories as UFF dataset 58",
                ));
            }
            return Err(context.unsupported(
                format!(
                    "its functions are no time histories: {}",
                    super::arrays::listed(&self.arrays.left_out)
                ),
                "export the time histories, not their spectra",
            ));
        }
        if self.other_sets > 0 {
            self.arrays.notes.push(format!(
                "{} datasets other than functions (58) were left out.",
                self.other_sets
            ));
        }
        self.arrays.notes.sort();
        self.arrays.notes.dedup();
        let tables = self.arrays.into_tables(context, &stem(context.file))?;
        Ok(FormatContent::Tables(tables))
    }
}
