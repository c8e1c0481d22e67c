//! Where results go: standard output or files.

use std::io::{BufWriter, ErrorKind, Write};
use std::path::Path;

use anyhow::Context;

/// Writes to standard output, through a buffer. A reader that has had enough is no error.
///
/// # Errors
/// Those of `write`.
pub fn to_stdout(write: impl FnOnce(&mut dyn Write) -> anyhow::Result<()>) -> anyhow::Result<()> {
    let mut out = BufWriter::new(std::io::stdout().lock());
    match write(&mut out).and_then(|()| Ok(out.flush()?)) {
        Err(error) if is_broken_pipe(&error) => Ok(()),
        other => other,
    }
}

/// Writes a value as JSON to a file, or to standard output for `-`.
///
/// # Errors
/// The file's, with its path.
pub fn json(path: &Path, value: &impl serde::Serialize) -> anyhow::Result<()> {
    let mut text = serde_json::to_string_pretty(value)?;
    text.push('\n');
    if path == Path::new("-") {
        return to_stdout(|out| Ok(out.write_all(text.as_bytes())?));
    }
    self::text(path, &text)
}

/// Writes a text to a file.
///
/// # Errors
/// The file's, with its path.
pub fn text(path: &Path, text: &str) -> anyhow::Result<()> {
    std::fs::write(path, text)
        .with_context(|| format!("cannot write {}; choose another folder", path.display()))
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        cause
            .downcast_ref::<std::io::Error>()
            .is_some_and(|e| e.kind() == ErrorKind::BrokenPipe)
    })
}
