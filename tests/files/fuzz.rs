//! The bodies of the fuzz targets on their seeds and on some thousand seeded mutations of
//! these: a short run of what `cargo fuzz` does without end (see `fuzz`).

#[path = "../../fuzz/src/bodies.rs"]
mod bodies;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Mutations of each target, and the time after which no more are tried: how far a slow
/// machine comes is printed.
const MUTATION_COUNT: usize = 3000;
const MAX_RUN_TIME: Duration = Duration::from_secs(6);
/// Longest input that mutations grow to [bytes].
const MAX_INPUT_LENGTH: usize = 1 << 16;
/// What files break by.
const TOKENS: &[&str] = &[
    "nan",
    "NaN",
    "inf",
    "-inf",
    "1e308",
    "1e-308",
    "5e-324",
    "1e999",
    "-0",
    "0",
    "-1",
    "1",
    "18446744073709551615",
    "9223372036854775807",
    "-9223372036854775808",
    "4294967296",
    ",",
    ";",
    "\t",
    "\n",
    "\r\n",
    "\"",
    "\"\"\"",
    "'",
    "=",
    "[",
    "]",
    "{",
    "}",
    "#",
    "\u{feff}",
    "\u{1b}[31m",
    "\u{0}",
    "1.797e308Hz",
];

/// The files of a folder and of those in it, in order of name.
fn files_below(folder: &Path) -> Vec<PathBuf> {
    let entries =
        std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let below = |path: PathBuf| {
        if path.is_dir() {
            files_below(&path)
        } else {
            vec![path]
        }
    };
    paths.into_iter().flat_map(below).collect()
}

/// The seeds of a target. Those of the formats are the files that other programs wrote.
fn seeds(target: &str) -> Vec<Vec<u8>> {
    let folder = match target {
        "formats" => "assets/test_files/formats".to_owned(),
        _ => format!("fuzz/seeds/{target}"),
    };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let paths = files_below(&folder);
    assert!(!paths.is_empty(), "no seed in {}", folder.display());
    paths
        .iter()
        .map(|path| std::fs::read(path).unwrap())
        .collect()
}

/// A place in `bytes`, its end included.
fn place(rng: &mut ChaCha8Rng, bytes: &[u8]) -> usize {
    rng.random_range(0..=bytes.len())
}

/// A range of some of `bytes`.
fn piece(rng: &mut ChaCha8Rng, bytes: &[u8]) -> std::ops::Range<usize> {
    let start = place(rng, bytes);
    let longest = (bytes.len() - start).min(64);
    start..start + rng.random_range(0..=longest)
}

/// `bytes` changed at some places, with pieces of `other`.
fn mutated(rng: &mut ChaCha8Rng, bytes: &[u8], other: &[u8]) -> Vec<u8> {
    let mut out = bytes.to_vec();
    for _ in 0..rng.random_range(1..=6) {
        let at = place(rng, &out);
        match rng.random_range(0..8) {
            0 if at < out.len() => out[at] ^= 1 << rng.random_range(0..8),
            1 if at < out.len() => out[at] = rng.random_range(0..=255),
            2 => {
                let gone = piece(rng, &out);
                out.drain(gone);
            }
            3 => {
                let copy = piece(rng, &out);
                let copy = out[copy].to_vec();
                out.splice(at..at, copy);
            }
            4 => out.truncate(at),
            5 => {
                let there = piece(rng, other);
                out.splice(at..at, other[there].iter().copied());
            }
            // A token in place of what stands there, or between.
            6 => {
                let token = TOKENS[rng.random_range(0..TOKENS.len())];
                out.splice(at..at, token.bytes());
            }
            _ => {
                let token = TOKENS[rng.random_range(0..TOKENS.len())];
                let cell = |b: &u8| b.is_ascii_alphanumeric() || b".-+".contains(b);
                let end = at + out[at..].iter().take_while(|b| cell(b)).count();
                out.splice(at..end, token.bytes());
            }
        }
    }
    out.truncate(MAX_INPUT_LENGTH);
    out
}

/// Runs `body` on the seeds of `target` and on mutations of them. A find is printed, so that it
/// can become a seed.
fn run(target: &str, body: fn(&[u8])) {
    let seeds = seeds(target);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let checked = |bytes: &[u8]| {
        let outcome = std::panic::catch_unwind(|| body(bytes));
        if let Err(panic) = outcome {
            println!("the input was: {}", bytes.escape_ascii());
            std::panic::resume_unwind(panic);
        }
    };
    for seed in &seeds {
        checked(seed);
    }
    let begun = Instant::now();
    let mut done = 0;
    while done < MUTATION_COUNT && begun.elapsed() < MAX_RUN_TIME {
        let pick = |rng: &mut ChaCha8Rng| rng.random_range(0..seeds.len());
        let (one, other) = (pick(&mut rng), pick(&mut rng));
        let input = mutated(&mut rng, &seeds[one], &seeds[other]);
        let since = Instant::now();
        checked(&input);
        let took = since.elapsed();
        assert!(
            took < Duration::from_secs(10),
            "{took:.1?} for: {}",
            input.escape_ascii()
        );
        done += 1;
    }
    println!("{target}: {} seeds, {done} mutations", seeds.len());
    assert!(done > 0);
}

#[test]
fn recordings_survive_a_short_fuzzing() {
    run("recordings", bodies::recordings);
}

#[test]
fn formats_survive_a_short_fuzzing() {
    run("formats", bodies::formats);
}

#[test]
fn presets_survive_a_short_fuzzing() {
    run("presets", bodies::presets);
}

#[cfg(feature = "gui")]
#[test]
fn sessions_survive_a_short_fuzzing() {
    run("sessions", bodies::sessions);
}

#[test]
fn drives_survive_a_short_fuzzing() {
    run("drives", bodies::drives);
}

#[test]
fn models_survive_a_short_fuzzing() {
    run("models", bodies::models);
}
