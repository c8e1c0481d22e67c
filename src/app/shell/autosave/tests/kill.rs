//! Processes that are killed in mid-edit. Each child edits without a pause, as fast as a
//! slider is dragged, and says what it edited and when; the parent kills it at a random
//! instant and reads the session that is left.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Command, Stdio};
use std::thread::JoinHandle;
use std::time::{SystemTime, UNIX_EPOCH};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::services;
use crate::app::shell::autosave::*;

/// Folder of a child's sessions; only set for children.
const CHILD_FOLDER: &str = "IMPACTSCOPE_TEST_KILLED_CHILD";
/// Path of the child's test, for this binary to run only it.
const CHILD_TEST: &str = "app::shell::autosave::tests::kill::edits_until_it_is_killed";
/// Time between two edits of a child.
const EDIT_TIME: Duration = Duration::from_millis(10);
/// Kills, and how many processes run at once.
const KILL_COUNT: usize = 60;
const KILLED_AT_ONCE: usize = 20;
/// When a child is killed, after its first edit \[s\].
const KILL_TIMES: std::ops::Range<f64> = 5.0..11.0;
/// Most that may be lost \[s\].
const MAX_LOSS: f64 = 5.0;

/// Seconds since 1970: the same clock in parent and children.
fn now() -> f64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    since.as_secs_f64()
}

/// Not a test of its own: the child of the one below, for which the environment says where
/// its sessions are.
#[test]
fn edits_until_it_is_killed() {
    let Some(folder) = std::env::var_os(CHILD_FOLDER) else {
        return;
    };
    let claimed = claim(Path::new(&folder), Start::LastSession).unwrap();
    let mut services = services();
    let mut autosave = Autosave::new(&services.state, Some(claimed.slot));
    let mut out = std::io::stdout().lock();
    // A parent that has failed ends its children by closing their output.
    for edit in 1_u64.. {
        let said = writeln!(out, "edit {edit} {:.6} .", now()).and_then(|()| out.flush());
        if said.is_err() {
            return;
        }
        services.state.setup.duration = edit as f64;
        autosave.look(&mut services, Instant::now(), || {});
        std::thread::sleep(EDIT_TIME);
    }
}

/// A child with its folder, and what it says.
struct Edited {
    child: Child,
    folder: tempfile::TempDir,
    said: JoinHandle<Vec<(u64, f64)>>,
    /// When the first edit was read.
    begun: std::sync::mpsc::Receiver<()>,
    /// How long after that it is killed.
    lives: Duration,
}

impl Edited {
    fn start(lives: f64) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", CHILD_TEST, "--nocapture", "--test-threads=1"])
            .env(CHILD_FOLDER, folder.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap());
        let (tell, begun) = std::sync::mpsc::channel();
        let said = std::thread::spawn(move || {
            let mut edits = Vec::new();
            for line in lines.lines().map_while(Result::ok) {
                let Some(edit) = edit_in(&line) else { continue };
                if edits.is_empty() {
                    let _ = tell.send(());
                }
                edits.push(edit);
            }
            edits
        });
        Self {
            child,
            folder,
            said,
            begun,
            lives: Duration::from_secs_f64(lives),
        }
    }
}

/// Number and time of an edit in a line of a child. A line that the kill cut off has no end
/// mark. The test harness writes its own words before the first.
fn edit_in(line: &str) -> Option<(u64, f64)> {
    let words = line.rsplit_once("edit ")?.1.strip_suffix(" .")?;
    let (edit, time) = words.split_once(' ')?;
    Some((edit.parse().ok()?, time.parse().ok()?))
}

/// Kills the child in its time. Returns the time that is lost \[s\], and how many part files
/// were left.
fn kill(mut edited: Edited) -> (f64, usize) {
    edited.begun.recv().expect("a child that edits");
    std::thread::sleep(edited.lives);
    edited.child.kill().unwrap();
    let killed = now();
    edited.child.wait().unwrap();
    let edits = edited.said.join().unwrap();
    let folder = edited.folder.path();
    let parts = || {
        let entries = std::fs::read_dir(folder).unwrap().flatten();
        entries
            .filter(|e| e.file_name().to_string_lossy().ends_with(".part"))
            .count()
    };
    let left = parts();
    // The next window finds the session, and no lock that holds it back.
    let claimed = claim(folder, Start::LastSession).unwrap();
    assert_eq!(claimed.words, None);
    assert_eq!(parts(), 0, "part files are swept");
    let mut notices = Vec::new();
    let loaded = restore(&claimed.slot, &mut notices);
    assert!(notices.is_empty(), "{notices:?}");
    let saved = loaded.expect("a session that can be read").setup.duration as u64;
    let lost = edits.iter().find(|(edit, _)| *edit > saved);
    assert!(saved > 0 && edits.len() > 100, "{saved} of {}", edits.len());
    (lost.map_or(0.0, |(_, time)| killed - time), left)
}

#[test]
fn sixty_kills_in_mid_edit_lose_at_most_five_seconds() {
    let mut rng = ChaCha8Rng::seed_from_u64(60);
    let mut losses = Vec::new();
    let mut parts = 0;
    while losses.len() < KILL_COUNT {
        let children: Vec<Edited> = (0..KILLED_AT_ONCE)
            .map(|_| Edited::start(rng.random_range(KILL_TIMES)))
            .collect();
        let kills: Vec<_> = children
            .into_iter()
            .map(|edited| std::thread::spawn(move || kill(edited)))
            .collect();
        for done in kills {
            let (loss, left) = done.join().unwrap();
            losses.push(loss);
            parts += left;
        }
    }
    losses.sort_by(f64::total_cmp);
    let worst = losses[losses.len() - 1];
    println!(
        "{} kills: {:.2} s lost at the median, {worst:.2} s at most; {parts} part files left and swept",
        losses.len(),
        losses[losses.len() / 2]
    );
    assert!(worst <= MAX_LOSS, "{losses:?}");
}
