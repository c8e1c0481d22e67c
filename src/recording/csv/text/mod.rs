//! Bytes that are text: reading the file, its encoding, and rows without a delimiter.

pub(super) mod encoding;
pub(super) mod reshape;

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;

use crate::recording::error::{FileText, ImportError, visible};

/// Called with the share done (0 to 1); returns whether to go on.
pub type Progress<'a> = dyn Fn(f32) -> bool + 'a;

/// Share of the progress bar that reading takes; the rest is parsing.
pub(super) const READ_SHARE: f32 = 0.25;
/// How much is read between two reports of progress.
const BLOCK_BYTES: usize = 16 << 20;
/// How much of the file is inspected to distinguish text from something else.
const HEAD_BYTES: usize = 64 << 10;

/// The last part of a path, as a name for the screen.
pub fn short_name(path: &Path) -> String {
    let name = path.file_name().map_or_else(
        || path.display().to_string(),
        |name| name.to_string_lossy().into_owned(),
    );
    visible(&name)
}

/// What ends the lines of `bytes`.
pub(super) fn newline_of(bytes: &[u8]) -> u8 {
    let head = &bytes[..bytes.len().min(HEAD_BYTES)];
    if head.contains(&b'\n') || !head.contains(&b'\r') {
        b'\n'
    } else {
        b'\r'
    }
}

/// Opens an ordinary file; returns it with its size.
pub(super) fn open(path: &Path) -> Result<(File, u64), ImportError> {
    let file = || FileText::from(path.display().to_string());
    let explain = |error: std::io::Error| match error.kind() {
        ErrorKind::NotFound => ImportError::NotFound { file: file() },
        _ => ImportError::Unreadable {
            file: file(),
            reason: error.to_string().into(),
        },
    };
    // Asked before opening: opening a pipe would wait for its writer.
    let about = std::fs::metadata(path).map_err(explain)?;
    if about.is_dir() {
        return Err(ImportError::IsDirectory { file: file() });
    }
    if !about.is_file() {
        return Err(ImportError::NotAFile { file: file() });
    }
    Ok((File::open(path).map_err(explain)?, about.len()))
}

/// The whole file.
pub fn read_file(path: &Path, progress: Option<&Progress>) -> Result<Vec<u8>, ImportError> {
    let (mut input, size) = open(path)?;
    let file = || FileText::from(path.display().to_string());
    let too_large = || ImportError::TooLarge {
        file: file(),
        megabytes: size >> 20,
    };
    let mut bytes = Vec::new();
    let capacity = usize::try_from(size).map_err(|_| too_large())?;
    bytes
        .try_reserve_exact(capacity.saturating_add(1))
        .map_err(|_| too_large())?;
    loop {
        let read = Read::by_ref(&mut input)
            .take(BLOCK_BYTES as u64)
            .read_to_end(&mut bytes)
            .map_err(|error| ImportError::Unreadable {
                file: file(),
                reason: error.to_string().into(),
            })?;
        if read == 0 {
            return Ok(bytes);
        }
        let done = READ_SHARE * (bytes.len() as f32 / (size.max(1)) as f32).min(1.0);
        if progress.is_some_and(|go_on| !go_on(done)) {
            return Err(ImportError::Cancelled { file: file() });
        }
    }
}

/// Text in UTF-8 whose head has been checked: no byte-order mark, its line end known.
#[derive(Debug, Clone, Copy)]
pub(super) struct Text<'a> {
    /// The bytes.
    pub bytes: &'a [u8],
    /// `\n`, or `\r` for files of old.
    pub newline: u8,
}

impl<'a> Text<'a> {
    /// Looks at the head of `bytes`, which are decoded; the rest is checked by [`Text::check`] as it
    /// is read.
    pub(super) fn new(file: &str, bytes: &'a [u8]) -> Result<Self, ImportError> {
        let file = || FileText::from(file);
        if bytes.iter().all(u8::is_ascii_whitespace) {
            return Err(ImportError::Empty { file: file() });
        }
        let head = &bytes[..bytes.len().min(HEAD_BYTES)];
        // 0x1a is the end mark that DOS programs left.
        let control = |b: &u8| *b < 0x20 && !matches!(b, b'\t' | b'\n' | b'\r' | 0x0c | 0x1a);
        let text = Text {
            bytes,
            newline: newline_of(bytes),
        };
        let found = head.iter().filter(|b| control(b)).count();
        if found * 100 > head.len()
            && let Some(at) = head.iter().position(control)
        {
            return Err(text.binary(file(), at, 1, 0));
        }
        Ok(text)
    }

    /// Checks that `bytes[range]` has no zero bytes; `first_line` is the line number of its start.
    pub(super) fn check(
        &self,
        file: &str,
        range: std::ops::Range<usize>,
        first_line: usize,
    ) -> Result<(), ImportError> {
        let start = range.start;
        match memchr::memchr(0, &self.bytes[range]) {
            Some(at) => Err(self.binary(file.into(), start + at, first_line, start)),
            None => Ok(()),
        }
    }

    /// The error for the binary byte at `at`, lines counted from `from` on.
    fn binary(&self, file: FileText, at: usize, first_line: usize, from: usize) -> ImportError {
        ImportError::Binary {
            file,
            line: first_line + self.lines(&self.bytes[from..at]),
            offset: at,
            byte: self.bytes.get(at).copied().unwrap_or_default(),
        }
    }

    /// Number of line ends in `part`.
    pub(super) fn lines(&self, part: &[u8]) -> usize {
        part.iter().filter(|b| **b == self.newline).count()
    }

    /// Where the line after `n` lines starts, and its number from 1.
    pub(super) fn skip_lines(&self, n: usize) -> (usize, usize) {
        let mut start = 0;
        for done in 0..n {
            match self.bytes[start..].iter().position(|b| *b == self.newline) {
                Some(end) => start += end + 1,
                None => return (self.bytes.len(), done + 1),
            }
        }
        (start, n + 1)
    }

    /// The lines of `part`, without their ends.
    pub(super) fn split<'p>(&self, part: &'p [u8]) -> impl Iterator<Item = &'p [u8]> + use<'p> {
        let newline = self.newline;
        part.split(move |b| *b == newline)
            .map(|line| line.strip_suffix(b"\r").unwrap_or(line))
    }
}
