//! Where results go: standard output or files.

use std::fs;
use std::io::{BufWriter, ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};

use super::{Failure, wrong_command};
use crate::atomic_write::{folder_of, write_atomically};

/// Writes to standard output, through a buffer. A closed pipe is not an error.
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

/// Shows how far the work is: on a terminal as one line that changes, in a log as a line of its
/// own, if it is `new` there.
pub fn progress(line: &str, new: bool) {
    if std::io::stderr().is_terminal() {
        eprint!("\r\x1b[K{line}");
    } else if new {
        eprintln!("{line}");
    }
}

/// Clears the progress line, if standard error is a terminal.
pub fn end_of_progress() {
    if std::io::stderr().is_terminal() {
        eprint!("\r\x1b[K");
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

/// Writes a text to a file as [`bytes`] does.
///
/// # Errors
/// The file's, with its path.
pub fn text(path: &Path, text: &str) -> anyhow::Result<()> {
    bytes(path, text.as_bytes())
}

/// Writes bytes to a file by a temporary file and a rename, so that it is either complete or
/// unchanged, where the system allows that.
///
/// # Errors
/// The file's, with its path.
pub fn bytes(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    // A link stays one: the file that it names is replaced.
    let there = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    // A pipe or a device is written to, not replaced.
    let plain = there.is_file() || !there.exists();
    if plain && write_atomically(&there, bytes).is_ok() {
        return Ok(());
    }
    // A folder that takes no second file may still let this one be written.
    fs::write(&there, bytes).with_context(|| refusal(path))
}

/// Checks before the work that its results can be written: `outputs` are options with their files,
/// `inputs` the files that the command reads.
///
/// # Errors
/// A wrong command if an output is also an input or named twice; else the file's.
pub fn ready(outputs: &[(&str, Option<&Path>)], inputs: &[PathBuf]) -> Result<(), Failure> {
    let files: Vec<(&str, &Path)> = outputs
        .iter()
        .filter_map(|(option, path)| Some((*option, (*path)?)))
        .filter(|(_, path)| *path != Path::new("-"))
        .collect();
    for (k, (option, path)) in files.iter().enumerate() {
        if inputs.iter().any(|input| same(input, path)) {
            return Err(wrong_command(anyhow!(
                "{option} {} is an input file; choose another",
                path.display()
            )));
        }
        if let Some((other, _)) = files[..k].iter().find(|(_, earlier)| same(earlier, path)) {
            return Err(wrong_command(anyhow!(
                "{other} and {option} name the same file {}; choose two files",
                path.display()
            )));
        }
        writable(path).with_context(|| refusal(path))?;
    }
    Ok(())
}

/// Whether two paths name one file.
fn same(a: &Path, b: &Path) -> bool {
    resolved(a) == resolved(b)
}

/// The one path of a file; of a file that is not there yet, the one of its folder with its name.
fn resolved(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| {
        match (fs::canonicalize(folder_of(path)), path.file_name()) {
            (Ok(folder), Some(name)) => folder.join(name),
            _ => path.to_owned(),
        }
    })
}

/// Checks that a file can be written, and changes nothing.
fn writable(path: &Path) -> std::io::Result<()> {
    let mut options = fs::OpenOptions::new();
    if path.is_file() || path.is_dir() {
        // Of a folder this says that it is one.
        options.append(true).open(path)?;
    } else if !path.exists() {
        options.write(true).create_new(true).open(path)?;
        fs::remove_file(path)?;
    }
    Ok(())
}

fn refusal(path: &Path) -> String {
    format!("cannot write {}; choose another folder", path.display())
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        cause
            .downcast_ref::<std::io::Error>()
            .is_some_and(|e| e.kind() == ErrorKind::BrokenPipe)
    })
}

#[cfg(test)]
mod tests {
    use super::super::output::*;

    #[test]
    fn an_input_file_is_never_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let recording = folder.path().join("a.csv");
        fs::write(&recording, "t [s],xp [um]\n").unwrap();
        // The same file by another name.
        let again = folder.path().join(".").join("a.csv");
        let refused = |outputs: &[(&str, Option<&Path>)]| {
            ready(outputs, std::slice::from_ref(&recording)).unwrap_err()
        };
        let failure = refused(&[("--json", None), ("--out", Some(&again))]);
        assert_eq!(failure.code, 2);
        assert!(failure.error.to_string().contains("--out"));
        let twice = folder.path().join("b.toml");
        let failure = refused(&[("--out", Some(&twice)), ("--json", Some(&twice))]);
        assert_eq!(failure.code, 2);
        assert!(failure.error.to_string().contains("--out and --json"));
        // Not there yet, and by another path.
        let name = folder.path().file_name().unwrap();
        let other_name = folder.path().join("..").join(name).join("b.toml");
        let failure = refused(&[("--out", Some(&twice)), ("--json", Some(&other_name))]);
        assert_eq!(failure.code, 2);
        let nowhere = folder.path().join("none").join("b.toml");
        for path in [nowhere.as_path(), folder.path()] {
            let failure = refused(&[("--out", Some(path))]);
            assert_eq!(failure.code, 1);
            assert!(failure.error.to_string().contains("cannot write"));
        }
    }

    #[test]
    fn checking_changes_nothing_and_writing_leaves_one_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("b.toml");
        let outputs = [
            ("--out", Some(path.as_path())),
            ("--json", Some("-".as_ref())),
        ];
        assert!(ready(&outputs, &[]).is_ok() && !path.exists());
        text(&path, "one").unwrap();
        assert!(ready(&outputs, &[]).is_ok());
        assert_eq!(fs::read_to_string(&path).unwrap(), "one");
        text(&path, "two").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "two");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, "one").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        text(&link, "two").unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read_to_string(&file).unwrap(), "two");
    }
}
