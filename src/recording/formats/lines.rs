//! Lines of a text in bytes.

/// Lines one after the other, without their ends (`\n`, `\r\n`).
#[derive(Debug, Clone, Copy)]
pub(super) struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    number: usize,
}

impl<'a> Lines<'a> {
    /// From the start of `bytes`.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            at: 0,
            number: 0,
        }
    }

    /// Bytes before the next line.
    pub fn at(&self) -> usize {
        self.at
    }

    /// Bytes from the next line to the end.
    pub fn remaining(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }

    /// Number of the last line given, from 1.
    pub fn number(&self) -> usize {
        self.number
    }

    /// All bytes from the next line on.
    pub fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    /// Goes over `count` lines of together `bytes` bytes.
    pub fn skip_over(&mut self, bytes: usize, count: usize) {
        self.seek(self.at.saturating_add(bytes));
        self.number += count;
    }

    /// Goes on at byte `at`, which is the start of a line; lines between are not counted.
    pub fn seek(&mut self, at: usize) {
        self.at = at.min(self.bytes.len());
    }

    /// The next line, which is not taken.
    pub fn peek(&self) -> Option<&'a [u8]> {
        let mut copy = *self;
        copy.next()
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|b| *b == b'\n');
        let (line, step) = match length {
            Some(length) => (rest.get(..length)?, length + 1),
            None => (rest, rest.len()),
        };
        self.at += step;
        self.number += 1;
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }
}
