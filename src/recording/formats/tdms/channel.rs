//! A channel while its samples are gathered.

use super::super::bytes::{ByteOrder, Cursor, Layout, NumberType, decode_into};
use super::metadata::{Properties, RawIndex, STAMP_FRACTION, Stored, stamp};

/// One channel of a file.
#[derive(Debug)]
pub(super) struct Channel {
    /// Group and name.
    pub path: Vec<String>,
    pub properties: Properties,
    /// What its last segment said of its data.
    pub index: RawIndex,
    pub values: Vec<f64>,
    /// For the user.
    pub note: Option<String>,
    /// First time stamp: others are seconds since.
    first_stamp: Option<(i64, u64)>,
}

impl Channel {
    pub fn new(path: Vec<String>) -> Self {
        Self {
            path,
            properties: Properties::new(),
            index: RawIndex::None,
            values: Vec::new(),
            note: None,
            first_stamp: None,
        }
    }

    /// Path of its group, as in the file.
    pub fn group_path(&self) -> String {
        let group = self.path.first().map_or("", String::as_str);
        format!("/'{}'", group.replace('\'', "''"))
    }

    /// Why it has no values.
    pub fn emptiness(&self) -> &'static str {
        match self.index {
            RawIndex::Data {
                stored: Stored::Skipped(what),
                ..
            } => what,
            _ => "empty",
        }
    }

    /// Adds `count` samples, the first at `offset`, `stride` bytes apart; `false` if they are not all
    /// there.
    pub fn add(
        &mut self,
        bytes: &[u8],
        stored: Stored,
        order: ByteOrder,
        (offset, stride, count): (usize, usize, usize),
    ) -> bool {
        let layout = |number: NumberType| Layout {
            number,
            order,
            offset,
            stride,
            count,
        };
        match stored {
            Stored::Number(number) => decode_into(bytes, &layout(number), &mut self.values),
            Stored::Complex(number) => {
                self.note = Some(format!(
                    "\"{}\" is complex; its real part was read.",
                    self.path.join("/")
                ));
                decode_into(bytes, &layout(number), &mut self.values)
            }
            Stored::Stamp => {
                for index in 0..count {
                    let at = index
                        .checked_mul(stride)
                        .and_then(|at| at.checked_add(offset));
                    let cell = at.and_then(|at| bytes.get(at..));
                    let Some((seconds, fraction)) =
                        cell.and_then(|cell| stamp(&mut Cursor::new(cell, order), order))
                    else {
                        return false;
                    };
                    let (first, first_fraction) =
                        *self.first_stamp.get_or_insert((seconds, fraction));
                    let fraction = fraction as f64 - first_fraction as f64;
                    let whole = seconds.wrapping_sub(first) as f64;
                    self.values.push(whole + fraction * STAMP_FRACTION);
                    self.note.get_or_insert_with(|| {
                        format!(
                            "\"{}\" holds time stamps; they became seconds since the first, which is {first} s after 1904-01-01 (UTC).",
                            self.path.join("/")
                        )
                    });
                }
                true
            }
            Stored::Skipped(_) => true,
        }
    }
}
