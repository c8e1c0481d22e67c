//! Files that are written whole or not at all.

use std::fs::{self, File};
use std::io::{BufWriter, Error, ErrorKind, Result, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Most links to follow from a name to a file, as many as Linux follows.
const MAX_LINKS: usize = 40;

/// Writes bytes to a file so that it is either whole or as before, also after a cut in
/// the power supply. A link stays one: the file that it names is written. A file keeps
/// its permissions.
///
/// A pipe or a device is written to. In a folder that takes no second file, a file is
/// written in place, and its old bytes are put back if that fails; there alone a cut in
/// the power supply can leave half of it.
///
/// # Errors
/// Those of the file system; nothing is left behind then.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<()> {
    stream_atomically(path, |out| out.write_all(bytes))
}

/// [`write_atomically`] of what `write` puts out piece by piece, so that it need not be in memory
/// as a whole.
///
/// # Errors
/// Those of the file system and of `write`; nothing is left behind then.
pub fn stream_atomically<E: From<Error>>(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> std::result::Result<(), E>,
) -> std::result::Result<(), E> {
    let path = &followed(path);
    if is_stream(path) {
        let mut out = BufWriter::new(fs::OpenOptions::new().write(true).open(path)?);
        write(&mut out)?;
        return Ok(out.flush()?);
    }
    let (temporary, file) = match second_file(path) {
        Ok(second) => second,
        Err(error) if refuses_second_file(&error) => {
            let mut bytes = Vec::new();
            write(&mut bytes)?;
            return Ok(write_in_place(path, &bytes)?);
        }
        Err(error) => return Err(error.into()),
    };
    let mut out = BufWriter::new(file);
    let written = write(&mut out).and_then(|()| {
        out.flush()?;
        Ok(out.get_ref().sync_all()?)
    });
    // What is still in the buffer must not be written after a failure.
    drop(out.into_parts());
    let renamed = written.and_then(|()| match fs::rename(&temporary, path) {
        Err(error) if refuses_second_file(&error) => {
            let bytes = fs::read(&temporary)?;
            // The room may be needed.
            let _ = fs::remove_file(&temporary);
            Ok(write_in_place(path, &bytes)?)
        }
        renamed => Ok(renamed?),
    });
    if renamed.is_err() {
        // There is nothing more to be done about it.
        let _ = fs::remove_file(&temporary);
    }
    // The name is in the folder, which has a cache of its own; not every system can do
    // this, and the file is whole either way.
    #[cfg(unix)]
    if renamed.is_ok()
        && let Ok(folder) = File::open(folder_of(path))
    {
        let _ = folder.sync_all();
    }
    renamed
}

/// The folder of a file; the current one for a bare name.
pub fn folder_of(path: &Path) -> &Path {
    path.parent()
        .filter(|folder| !folder.as_os_str().is_empty())
        .unwrap_or(Path::new("."))
}

/// The file that a name leads to, links followed, also where it is not there yet.
pub fn followed(path: &Path) -> PathBuf {
    if let Ok(file) = fs::canonicalize(path) {
        return file;
    }
    let mut path = path.to_owned();
    for _ in 0..MAX_LINKS {
        // What is there and has no other name is a pipe.
        let next = fs::read_link(&path).ok().filter(|_| !path.exists());
        let Some(next) = next else { break };
        path = folder_of(&path).join(next);
    }
    path
}

/// Whether a path names something that takes bytes and keeps none, like a pipe or a device.
fn is_stream(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|there| !there.is_file() && !there.is_dir())
}

/// Whether an error of making or renaming the second file says that the folder takes none, or does
/// not let it have the name of the first. All others are failures, a full disk above all.
fn refuses_second_file(error: &Error) -> bool {
    matches!(
        error.kind(),
        // The last is a name that has no room for the ending of the second file's.
        ErrorKind::PermissionDenied
            | ErrorKind::ReadOnlyFilesystem
            | ErrorKind::ResourceBusy
            | ErrorKind::CrossesDevices
            | ErrorKind::InvalidFilename
    )
}

/// Makes the second file, which is to have the name of the first.
fn second_file(path: &Path) -> Result<(PathBuf, File)> {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let mut name = path.file_name().unwrap_or_default().to_owned();
    // Two programs, or two threads, must not write into the same temporary file.
    let turn = COUNT.fetch_add(1, Ordering::Relaxed);
    name.push(format!(".{}-{turn}.part", std::process::id()));
    let temporary = path.with_file_name(name);
    let file = File::create(&temporary)?;
    #[cfg(unix)]
    if let Ok(old) = fs::metadata(path) {
        // Not every file system has permissions; the bytes count more.
        let _ = file.set_permissions(old.permissions());
    }
    Ok((temporary, file))
}

/// Writes over the bytes of a file, and puts them back if that fails. It is not emptied first: on a
/// full disk, its place could be taken by another file before its bytes are back.
fn write_in_place(path: &Path, bytes: &[u8]) -> Result<()> {
    let old = match fs::read(path) {
        Ok(old) => Some(old),
        Err(error) if error.kind() == ErrorKind::NotFound => None,
        Err(error) => return Err(error),
    };
    let mut options = fs::OpenOptions::new();
    options.write(true).create_new(old.is_none());
    let mut file = options.open(path)?;
    let mut written = 0;
    let Err(error) = overwrite(&mut file, bytes, &mut written) else {
        return Ok(());
    };
    let put_back = match &old {
        Some(old) => put_back(&mut file, old, written),
        None => fs::remove_file(path),
    };
    Err(match put_back {
        Ok(()) => error,
        Err(second) => Error::new(
            error.kind(),
            format!("{error}, and the file as it was before could not be restored: {second}"),
        ),
    })
}

/// Writes from the start of a file to its new end; counts what was `written`.
fn overwrite(file: &mut File, bytes: &[u8], written: &mut usize) -> Result<()> {
    while *written < bytes.len() {
        match file.write(&bytes[*written..]) {
            Ok(0) => return Err(ErrorKind::WriteZero.into()),
            Ok(count) => *written += count,
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    // The rest of the old bytes goes last, when nothing but that can fail any more.
    file.sync_all()?;
    file.set_len(bytes.len() as u64)?;
    file.sync_all()
}

/// Undoes an [`overwrite`] that failed.
fn put_back(file: &mut File, old: &[u8], written: usize) -> Result<()> {
    let shortened = file.metadata()?.len() < old.len() as u64;
    let lost = if shortened {
        old.len()
    } else {
        written.min(old.len())
    };
    file.seek(SeekFrom::Start(0))?;
    file.write_all(&old[..lost])?;
    file.set_len(old.len() as u64)?;
    file.sync_all()
}

#[cfg(test)]
mod tests {
    use super::super::atomic_write::*;

    /// A name that is as long as file systems take it: the second file's would be longer.
    fn longest_name() -> String {
        "x".repeat(255)
    }

    fn names_in(folder: &Path) -> usize {
        fs::read_dir(folder).unwrap().count()
    }

    #[test]
    fn a_file_is_replaced_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        for text in ["one", "", "three"] {
            write_atomically(&path, text.as_bytes()).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
            assert_eq!(names_in(folder.path()), 1);
        }
        assert!(write_atomically(folder.path(), b"one").is_err());
        assert!(write_atomically(&folder.path().join("none").join("a"), b"one").is_err());
        assert_eq!(names_in(folder.path()), 1);
    }

    #[cfg(unix)]
    #[test]
    fn what_fails_while_it_is_put_out_leaves_the_file_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a".to_owned(), longest_name()] {
            let path = folder.path().join(name);
            fs::write(&path, "old").unwrap();
            let failed = stream_atomically(&path, |out| {
                out.write_all(b"half")?;
                Err(Error::other("no more"))
            });
            assert_eq!(failed.unwrap_err().to_string(), "no more");
            assert_eq!(fs::read_to_string(&path).unwrap(), "old");
            stream_atomically(&path, |out| (0..3).try_for_each(|i| write!(out, "{i}"))).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), "012");
            fs::remove_file(&path).unwrap();
            assert_eq!(names_in(folder.path()), 0);
        }
    }

    #[cfg(unix)]
    #[test]
    fn where_no_second_file_can_be_the_file_is_written_in_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(longest_name());
        for text in ["a new file", "shorter", "", "longer than before"] {
            write_atomically(&path, text.as_bytes()).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
            assert_eq!(names_in(folder.path()), 1);
        }
    }

    #[test]
    fn bytes_of_a_file_are_put_back_wherever_writing_in_place_ended() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let old = b"0123456789";
        for (new, kept) in [("abc", 10), ("abc", 3), ("abcdefghijklmno", 15), ("", 10)] {
            fs::write(&path, old).unwrap();
            let mut file = fs::OpenOptions::new().write(true).open(&path).unwrap();
            file.write_all(new.as_bytes()).unwrap();
            file.set_len(kept).unwrap();
            put_back(&mut file, old, new.len()).unwrap();
            assert_eq!(fs::read(&path).unwrap(), old, "{new} of {kept}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_also_to_a_file_that_is_not_there_yet() {
        use std::os::unix::fs::symlink;

        let folder = tempfile::tempdir().unwrap();
        let [file, link, further] = ["file", "link", "further"].map(|n| folder.path().join(n));
        symlink("file", &link).unwrap();
        symlink("link", &further).unwrap();
        for text in ["one", "two"] {
            write_atomically(&further, text.as_bytes()).unwrap();
            assert!(link.is_symlink() && further.is_symlink() && !file.is_symlink());
            assert_eq!(fs::read_to_string(&file).unwrap(), text);
        }
        let circle = folder.path().join("circle");
        symlink("circle", &circle).unwrap();
        assert_eq!(followed(&circle), circle);
    }

    #[cfg(unix)]
    #[test]
    fn a_file_keeps_its_permissions() {
        use std::os::unix::fs::PermissionsExt;

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("private");
        fs::write(&path, "one").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
        write_atomically(&path, b"two").unwrap();
        let mode = fs::metadata(&path).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_written_to_and_stays() {
        let device = Path::new("/dev/null");
        write_atomically(device, b"one").unwrap();
        assert!(is_stream(device));
    }
}
