//! A table of a binary format as the text that [`crate::recording::csv`] reads: one mechanism decides
//! what columns are, in which unit, and what is worth asking, whatever the file.

use rayon::prelude::*;

use crate::recording::formats::raw_table::RawTable;

/// Rows written by one thread at a time.
const BLOCK_ROWS: usize = 4096;
/// Length of a number \[bytes\], for the room that is made.
const NUMBER_LENGTH: usize = 20;

/// The first `most_rows` rows of the table with a header, cells separated by tabulators, numbers in the digits that identify
/// them. Where the file gives a rate, a column of times is put first.
pub fn text_of(table: &RawTable, most_rows: usize) -> Vec<u8> {
    let mut text = Vec::new();
    let mut header: Vec<String> = table
        .columns
        .iter()
        .map(|c| heading(&c.name, c.unit.as_deref()))
        .collect();
    if table.clock.is_some() {
        header.insert(0, "time [s]".to_owned());
    }
    text.extend_from_slice(header.join("\t").as_bytes());
    text.push(b'\n');
    let rows = table.rows().min(most_rows);
    let starts: Vec<usize> = (0..rows).step_by(BLOCK_ROWS).collect();
    let blocks: Vec<Vec<u8>> = starts
        .into_par_iter()
        .map(|start| block(table, start..(start + BLOCK_ROWS).min(rows), header.len()))
        .collect();
    text.reserve(blocks.iter().map(Vec::len).sum());
    for block in blocks {
        text.extend_from_slice(&block);
    }
    text
}

fn block(table: &RawTable, rows: std::ops::Range<usize>, columns: usize) -> Vec<u8> {
    let mut out = Vec::with_capacity(rows.len() * columns * NUMBER_LENGTH);
    let mut buffer = zmij::Buffer::new();
    for row in rows {
        let time = table
            .clock
            .map(|clock| clock.start + row as f64 * clock.interval);
        let values = table
            .columns
            .iter()
            .map(|c| c.values.get(row).copied().unwrap_or(f64::NAN));
        for (i, value) in time.into_iter().chain(values).enumerate() {
            if i > 0 {
                out.push(b'\t');
            }
            // A missing number is an empty cell.
            if value.is_finite() {
                out.extend_from_slice(buffer.format_finite(value).as_bytes());
            }
        }
        out.push(b'\n');
    }
    out
}

/// A name with its unit, as a header of text has it.
fn heading(name: &str, unit: Option<&str>) -> String {
    let clean = |text: &str| -> String {
        let all = text.chars().map(|c| match c {
            '"' => '\'',
            c if c.is_control() => ' ',
            c => c,
        });
        all.collect::<String>().trim().to_owned()
    };
    let name = clean(name);
    match unit.map(clean).filter(|unit| !unit.is_empty()) {
        Some(unit) => format!("{name} [{unit}]"),
        None => name,
    }
}

#[cfg(test)]
mod tests {
    use super::super::raw_text::*;
    use crate::recording::formats::raw_table::{RawColumn, SampleClock};

    #[test]
    fn numbers_come_back_bit_for_bit() {
        let column = |name: &str, unit: Option<&str>, values: Vec<f64>| RawColumn {
            name: name.to_owned(),
            unit: unit.map(str::to_owned),
            values,
        };
        let values = vec![0.1 + 0.2, -1.0 / 3.0, 6.02e23, f64::NAN];
        let table = RawTable {
            name: "a".to_owned(),
            columns: vec![
                column("V\t1", Some("V"), values.clone()),
                column("xp", None, vec![1.0; 4]),
            ],
            clock: SampleClock::new(0.5, 2e-5),
            notes: Vec::new(),
        };
        let text = String::from_utf8(text_of(&table, usize::MAX)).unwrap();
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some("time [s]\tV 1 [V]\txp"));
        for (i, (line, value)) in lines.zip(&values).enumerate() {
            let cells: Vec<&str> = line.split('\t').collect();
            assert_eq!(cells[0].parse::<f64>().unwrap(), 0.5 + i as f64 * 2e-5);
            match cells[1].parse::<f64>() {
                Ok(read) => assert_eq!(read.to_bits(), value.to_bits()),
                Err(_) => assert!(cells[1].is_empty() && value.is_nan()),
            }
        }
    }
}
