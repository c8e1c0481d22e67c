//! `sweep` as others run it: shards and their merging byte by byte, and what is refused.

use std::path::Path;
use std::process::{Command, Output, Stdio};

fn sweep(folder: &Path, line: &str) -> Output {
    Command::new("sh")
        .args(["-c", &format!("\"$P\" sweep {line}")])
        .current_dir(folder)
        .env("P", env!("CARGO_BIN_EXE_impactscope"))
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .stdin(Stdio::null())
        .output()
        .unwrap()
}

fn done(folder: &Path, line: &str) {
    let output = sweep(folder, line);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{line}: {said}");
}

/// What is said of a command that fails with this exit code.
fn refused(folder: &Path, line: &str, code: i32) -> String {
    let output = sweep(folder, line);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{line}: {said}");
    said
}

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[test]
fn shards_merge_to_the_bytes_of_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (name, grid) in [
        (
            "map",
            "--grid f=20:90:5Hz,gp=55um:75um:4 --measure regime,contact,peak,drive_work",
        ),
        (
            "ensemble",
            "--grid V=4:8:5 --over Cs:0.5x..2x,Ca0:0.5x..2x --ensemble 5 --want contact=0.1..0.5 --seed 3",
        ),
    ] {
        done(folder, &format!("{grid} --out {name}.csv"));
        for part in 1..=3 {
            done(
                folder,
                &format!("{grid} --shard {part}/3 --out {name}-{part}.csv"),
            );
        }
        // In another folder, by another number of threads, and in another order.
        std::fs::create_dir_all(folder.join("other")).unwrap();
        let again = format!("{grid} --shard 2/3 --out other/{name}.csv");
        let threads = Command::new("sh")
            .args(["-c", &format!("RAYON_NUM_THREADS=3 \"$P\" sweep {again}")])
            .current_dir(folder)
            .env("P", env!("CARGO_BIN_EXE_impactscope"))
            .status();
        assert!(threads.unwrap().success());
        assert_eq!(
            bytes(folder, &format!("other/{name}.csv")),
            bytes(folder, &format!("{name}-2.csv"))
        );
        done(
            folder,
            &format!(
                "--merge {name}-3.csv other/{name}.csv {name}-1.csv {name}-2.csv --out merged.csv"
            ),
        );
        let (whole, merged) = (
            bytes(folder, &format!("{name}.csv")),
            bytes(folder, "merged.csv"),
        );
        assert_eq!(
            String::from_utf8(merged).unwrap(),
            String::from_utf8(whole).unwrap()
        );
    }
    // One run is its own only shard.
    done(folder, "--merge map.csv --out merged.csv");
    assert_eq!(bytes(folder, "merged.csv"), bytes(folder, "map.csv"));
}

#[test]
fn a_table_says_what_it_is_and_why_points_are_missing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let output = sweep(
        folder,
        "--preset paper --drive square --grid f=20:90:3Hz,gp=50um:70um:2 --measure contact,regime --out -",
    );
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let text = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[0].starts_with("# impactscope 0."), "{text}");
    let command = "# command: impactscope sweep --preset paper --drive square:15Hz:8V --grid f=20:90:3Hz,gp=50um:70um:2 --measure contact_share,regime --seed 0";
    assert_eq!(lines[1], command);
    assert_eq!(lines[2], "# seed: 0");
    assert!(lines[3].contains("sha256"));
    assert_eq!(lines[4], "# points: 6");
    assert_eq!(
        lines[5],
        "point,frequency [Hz],gp [m],contact_share,regime,hole"
    );
    assert!(
        lines[6].starts_with("0,20,5e-5,,,") && lines[6].contains("must exceed dp"),
        "{text}"
    );
    assert!(lines[9].starts_with("3,20,7e-5,0."), "{text}");
    assert_eq!(lines.len(), 12);
    assert!(said.contains("3 of 6 points are impossible"), "{said}");
    // Logarithmic, and multiples of the device's value.
    let output = sweep(folder, "--grid Cs=0.1x:10x:3:log --measure peak --out -");
    let text = String::from_utf8(output.stdout).unwrap();
    let rows: Vec<&str> = text.lines().skip(6).collect();
    let value = |k: usize| rows[k].split(',').nth(1).unwrap().parse::<f64>().unwrap();
    assert!(
        (value(1) / 1.747e-21 - 1.0).abs() < 1e-7 && (value(2) / value(0) - 100.0).abs() < 1e-5
    );
}

#[test]
fn what_makes_no_sense_is_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (line, part) in [
        ("--grid f=5:5:20Hz --out a.csv", "the range is empty"),
        ("--grid f=5:9:1Hz --out a.csv", "1 point is no axis"),
        ("--grid f=5:9 --out a.csv", "write ID=FROM:TO:COUNT"),
        ("--grid f=5:9:4V --out a.csv", "not a unit"),
        (
            "--grid magic=1:2:4 --out a.csv",
            "there is no \"magic\" to vary",
        ),
        (
            "--grid V=1:2:4,V=2:3:4 --out a.csv",
            "both axes are amplitude",
        ),
        (
            "--grid V=1:2:4,f=2:3:4,Cs=1x:2x:4 --out a.csv",
            "more than 2",
        ),
        ("--grid offset=-1:2:4:log --out a.csv", "above 0"),
        (
            "--grid f=5:100:100000Hz,V=2:9:100000 --out a.csv",
            "10000000000 points",
        ),
        (
            "--grid V=4:8:3 --measure magic --out a.csv",
            "there is no measure magic; there are regime",
        ),
        (
            "--grid V=4:8:3 --measure peak,peak --out a.csv",
            "asked for twice",
        ),
        ("--grid V=4:8:3 --shard 4/3 --out a.csv", "write I/N"),
        ("--grid V=4:8:3 --shard 1/9 --out a.csv", "at most 3 parts"),
        (
            "--grid V=4:8:3 --over magic:1x..2x --out a.csv",
            "there is no \"magic\"",
        ),
        (
            "--grid V=4:8:3 --over Cs:2x..1x --out a.csv",
            "the range is empty",
        ),
        (
            "--grid V=4:8:3 --over Cs:1x..2 --out a.csv",
            "write both with x or none",
        ),
        (
            "--grid V=4:8:3 --ensemble 9 --out a.csv",
            "--over Cs:0.5x..2x",
        ),
        (
            "--grid V=4:8:3 --over Cs:1x..2x --want regime=odd --out a.csv",
            "there is no regime",
        ),
        ("--out a.csv", "--grid is missing"),
        (
            "--grid V=4:8:3 --drive rest --out a.csv",
            "the drive rest has none",
        ),
        (
            "--preset bouncing-ball --drive sine:5Hz:1V --grid f=1:2:3 --preset oscillator --measure regime --out a.csv",
            "cannot be used multiple times",
        ),
        (
            "--preset oscillator --drive sine:5Hz:1V --grid f=1:2:3 --measure regime --out a.csv",
            "has no ground",
        ),
    ] {
        let said = refused(folder, line, 2);
        assert!(said.contains(part), "{line}: {said}");
        assert!(!folder.join("a.csv").exists(), "{line}");
    }
}

#[test]
fn shards_that_are_missing_or_contradict_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let grid = "--grid V=4:8:6 --measure peak";
    for part in 1..=3 {
        done(folder, &format!("{grid} --shard {part}/3 --out {part}.csv"));
    }
    done(
        folder,
        "--grid V=4:9:6 --measure peak --shard 3/3 --out other.csv",
    );
    done(folder, &format!("{grid} --shard 1/2 --out half.csv"));
    let text = String::from_utf8(bytes(folder, "2.csv")).unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write("cut.csv", &text[..text.len() - 4]);
    let mut lines: Vec<&str> = text.lines().collect();
    let last = lines.pop().unwrap();
    write("short.csv", &(lines.join("\n") + "\n"));
    let contradicting = last.replacen("4,", "4,9", 1);
    write(
        "changed.csv",
        &(lines.join("\n") + "\n" + &contradicting + "\n"),
    );
    write("text.csv", "t [s],xp [um]\n0,1\n");
    for (files, part) in [
        ("1.csv 3.csv", "shards 2/3 are missing"),
        ("1.csv 2.csv other.csv", "are of different sweeps"),
        ("1.csv half.csv", "one of 2"),
        ("1.csv cut.csv 3.csv", "cut off"),
        ("1.csv short.csv 3.csv", "it has 1 rows"),
        ("1.csv 2.csv changed.csv 3.csv", "contradict one another"),
        ("1.csv text.csv", "this is no table"),
        ("1.csv none.csv", "none.csv"),
    ] {
        let said = refused(folder, &format!("--merge {files} --out m.csv"), 1);
        assert!(said.contains(part), "{files}: {said}");
        assert!(!folder.join("m.csv").exists());
    }
    assert!(refused(folder, "--merge 1.csv 2.csv --out 1.csv", 2).contains("is an input file"));
}
