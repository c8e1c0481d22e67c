//! Where results go: files and standard output.

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufWriter, Error, ErrorKind, Write};
use std::path::{Path, PathBuf};

use anyhow::anyhow;

use super::terminal::shown;
use super::{Failure, wrong_command};
use crate::atomic_write::{folder_of, followed, stream_atomically, write_atomically};

/// Standard output as the value of an option.
pub const STDOUT: &str = "-";

/// The results of a command on their way out. Files are written before standard output, each
/// whatever became of the others; what failed is said at the end. So no failing output takes
/// finished work with it.
#[derive(Debug, Default)]
pub struct Results {
    /// Whether an option has standard output; then texts for people are not said.
    stdout_taken: bool,
    files: Vec<(PathBuf, Vec<u8>)>,
    stdout: Vec<u8>,
    /// What could not be written at last, and why.
    failures: BTreeMap<PathBuf, String>,
}

impl Results {
    /// Whether standard output is for people: no option has it.
    pub fn is_stdout_for_people(&self) -> bool {
        !self.stdout_taken
    }

    /// Takes a text for people, for standard output.
    pub fn say(&mut self, text: &str) {
        if !self.stdout_taken {
            self.stdout.extend_from_slice(shown(text).as_bytes());
        }
    }

    /// Takes what an option puts out.
    pub fn add(&mut self, path: &Path, bytes: impl Into<Vec<u8>>) {
        if is_stdout(path) {
            self.stdout.extend(bytes.into());
        } else {
            self.files.push((path.to_owned(), bytes.into()));
        }
    }

    /// Takes a value as JSON.
    pub fn add_json(&mut self, path: &Path, value: &impl serde::Serialize) {
        match serde_json::to_string_pretty(value) {
            Ok(text) => self.add(path, text + "\n"),
            Err(error) => self.note(path, Err(error.into())),
        }
    }

    /// Puts out what may be too long to be kept as a whole, at once; on standard output after all
    /// that was taken before.
    pub fn stream(
        &mut self,
        path: &Path,
        write: impl FnOnce(&mut dyn Write) -> anyhow::Result<()>,
    ) {
        if is_stdout(path) {
            self.deliver();
            let written = to_stdout(write);
            self.note(Path::new(STDOUT), written);
            return;
        }
        let written = stream_atomically(path, write);
        self.note(path, written);
    }

    /// Writes what was taken so far.
    pub fn deliver(&mut self) {
        for (path, bytes) in std::mem::take(&mut self.files) {
            let written = write_atomically(&path, &bytes);
            self.note(&path, written.map_err(Into::into));
        }
        let bytes = std::mem::take(&mut self.stdout);
        if !bytes.is_empty() {
            let written = to_stdout(|out| Ok(out.write_all(&bytes)?));
            self.note(Path::new(STDOUT), written);
        }
    }

    /// Whether all that was delivered to this file is there.
    pub fn has_written(&self, path: &Path) -> bool {
        !self.failures.contains_key(path)
    }

    /// Writes what was taken.
    ///
    /// # Errors
    /// All outputs that failed, each with its reason.
    pub fn end(mut self) -> Result<(), Failure> {
        self.deliver();
        if self.failures.is_empty() {
            return Ok(());
        }
        let texts: Vec<String> = self.failures.into_values().collect();
        Err(anyhow!(texts.join("; ")).into())
    }

    fn note(&mut self, path: &Path, outcome: anyhow::Result<()>) {
        match outcome {
            // A file is written as a whole each time, standard output goes on.
            Ok(()) if path != Path::new(STDOUT) => {
                self.failures.remove(path);
            }
            Ok(()) => {}
            Err(error) => match system_error(&error) {
                // The reader, like `head`, has enough.
                Some(system) if system.kind() == ErrorKind::BrokenPipe => {}
                Some(system) => {
                    self.failures.insert(path.to_owned(), refusal(path, system));
                }
                None => {
                    self.failures.insert(path.to_owned(), format!("{error:#}"));
                }
            },
        }
    }
}

/// Writes to standard output, through a buffer.
fn to_stdout(write: impl FnOnce(&mut dyn Write) -> anyhow::Result<()>) -> anyhow::Result<()> {
    let mut out = BufWriter::new(std::io::stdout().lock());
    write(&mut out)?;
    Ok(out.flush()?)
}

/// Writes a text to a file, which is whole or as before.
///
/// # Errors
/// The file's, with its path.
pub fn text(path: &Path, text: &str) -> anyhow::Result<()> {
    write_atomically(path, text.as_bytes()).map_err(|error| anyhow!(refusal(path, &error)))
}

/// Checks before the work that its results can be written: `outputs` are options with their files,
/// `inputs` the files that the command reads. Returns what takes the results.
///
/// # Errors
/// A wrong command if an output is also an input, or two outputs go to one file or to standard
/// output; else the file's.
pub fn ready(outputs: &[(&str, Option<&Path>)], inputs: &[PathBuf]) -> Result<Results, Failure> {
    let outputs: Vec<(&str, &Path)> = outputs
        .iter()
        .filter_map(|(option, path)| Some((*option, (*path)?)))
        .collect();
    for (k, (option, path)) in outputs.iter().enumerate() {
        let to_stdout = is_stdout(path);
        if !to_stdout && inputs.iter().any(|input| same(input, path)) {
            return Err(wrong_command(anyhow!(
                "{option} {} is an input file; choose another",
                path.display()
            )));
        }
        let earlier = outputs[..k].iter().find(|(_, earlier)| {
            if to_stdout {
                is_stdout(earlier)
            } else {
                !is_stdout(earlier) && same(earlier, path)
            }
        });
        if let Some((other, _)) = earlier {
            return Err(wrong_command(if to_stdout {
                anyhow!(
                    "{other} and {option} both go to standard output; name a file for one of them"
                )
            } else {
                anyhow!(
                    "{other} and {option} name the same file {}; choose two files",
                    path.display()
                )
            }));
        }
        if !to_stdout {
            writable(path).map_err(|error| anyhow!(refusal(path, &error)))?;
        }
    }
    Ok(Results {
        stdout_taken: outputs.iter().any(|(_, path)| is_stdout(path)),
        ..Results::default()
    })
}

/// Whether a path means standard output, by `-` or as the file or pipe that it goes to. Such a file
/// must not be replaced: what is said afterwards would go to the old one, which has no name any
/// more.
fn is_stdout(path: &Path) -> bool {
    path == Path::new(STDOUT) || is_file_of_stdout(path)
}

#[cfg(unix)]
fn is_file_of_stdout(path: &Path) -> bool {
    use std::os::fd::AsFd;
    use std::os::unix::fs::{FileTypeExt, MetadataExt};

    let own = std::io::stdout().as_fd().try_clone_to_owned();
    let own = own.and_then(|own| fs::File::from(own).metadata());
    let (Ok(own), Ok(named)) = (own, fs::metadata(path)) else {
        return false;
    };
    // A device stays what it is: nothing that goes to it afterwards is lost.
    !own.file_type().is_char_device() && (own.dev(), own.ino()) == (named.dev(), named.ino())
}

#[cfg(not(unix))]
fn is_file_of_stdout(_path: &Path) -> bool {
    false
}

/// Whether two paths name one file.
fn same(a: &Path, b: &Path) -> bool {
    resolved(a) == resolved(b)
}

/// The one path of a file; of a file that is not there yet, the one of its folder with its name.
fn resolved(path: &Path) -> PathBuf {
    let path = followed(path);
    match (fs::canonicalize(folder_of(&path)), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path,
    }
}

/// Checks that a file can be written, and changes nothing.
fn writable(path: &Path) -> std::io::Result<()> {
    let path = &followed(path);
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

/// What is said of an output that the system refuses.
fn refusal(path: &Path, error: &Error) -> String {
    let output = if path == Path::new(STDOUT) {
        "to standard output".to_owned()
    } else {
        path.display().to_string()
    };
    let remedy = match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "make room, or choose another disk",
        ErrorKind::FileTooLarge => "raise the limit on the size of files (ulimit -f)",
        _ if path == Path::new(STDOUT) => "name a file as the output",
        _ => "choose another folder",
    };
    format!("cannot write {output}: {error}; {remedy}")
}

/// The system's error among an error and its causes.
fn system_error(error: &anyhow::Error) -> Option<&Error> {
    error
        .chain()
        .find_map(|cause| cause.downcast_ref::<Error>())
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

    #[test]
    fn a_failure_counts_until_the_file_is_written_after_all() {
        let folder = tempfile::tempdir().unwrap();
        let later = folder.path().join("later");
        let [a, b] = [later.join("a"), folder.path().join("b")];
        let mut results = Results::default();
        results.add(&a, "one");
        results.add_json(&b, &[1, 2]);
        results.deliver();
        assert!(!results.has_written(&a) && results.has_written(&b));
        assert_eq!(fs::read_to_string(&b).unwrap(), "[\n  1,\n  2\n]\n");
        fs::create_dir(&later).unwrap();
        results.add(&a, "two");
        results.deliver();
        assert!(results.has_written(&a));
        assert_eq!(fs::read_to_string(&a).unwrap(), "two");
        results.end().unwrap();
        let mut results = Results::default();
        let nowhere = folder.path().join("none");
        results.add(&nowhere.join("a"), "one");
        results.stream(&nowhere.join("b"), |out| Ok(out.write_all(b"two")?));
        let failure = results.end().unwrap_err();
        assert_eq!(failure.code, 1);
        let text = failure.error.to_string();
        assert_eq!(text.matches("cannot write").count(), 2, "{text}");
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
