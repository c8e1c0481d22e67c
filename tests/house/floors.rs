//! Imports run downward: each floor uses those below it alone.

use std::collections::BTreeSet;

use super::assert_none;
use super::source::{Tree, is_test, line, words};
use super::uses::{Modules, module, uses};

/// The floors, from the bottom up.
const FLOORS: [&str; 13] = [
    "atomic_write",
    "part_files",
    "static_text",
    "model",
    "sim",
    "recording",
    "fit",
    "explore",
    "diagnose",
    "trial",
    "learn",
    "app",
    "cli",
];

fn height(floor: &str) -> Option<usize> {
    FLOORS.iter().position(|f| *f == floor)
}

/// Files that use a higher floor, in `use` lines, re-exports or paths inside the code, and
/// files on no floor. Tests may look up.
fn upward(tree: &Tree) -> Vec<String> {
    let modules = Modules::of(tree);
    let mut offences = BTreeSet::new();
    for (path, source) in &tree.files {
        let Some(here) = module(path) else { continue };
        let floor = here.split("::").next().unwrap_or(&here);
        let Some(own) = height(floor) else {
            offences.insert(format!("{path}: {floor} is no floor"));
            continue;
        };
        if is_test(path) {
            continue;
        }
        let code = &source.code;
        let mut used: Vec<(String, String)> = Vec::new();
        for u in uses(code) {
            let from_root = modules.path_from_root(&here, &u.path).unwrap_or_default();
            used.extend(from_root.first().map(|f| (f.clone(), path.clone())));
        }
        let words = words(code);
        for pair in words.windows(2) {
            let [(start, word), (next, name)] = [pair[0], pair[1]];
            if word == "crate" && code[start + word.len()..next].trim() == "::" {
                let place = format!("{path}:{}", line(code, start));
                used.push((name.to_owned(), place));
            }
        }
        for (name, place) in used {
            if height(&name).is_some_and(|other| other > own) {
                offences.insert(format!("{place}: {floor} uses {name}, a floor above it"));
            }
        }
    }
    offences.into_iter().collect()
}

#[test]
fn imports_run_downward() {
    assert_none("upward imports", &upward(&Tree::of_this_repository()));
}

#[test]
fn an_upward_import_is_seen() {
    let fine = (
        "src/fit/mod.rs",
        "use crate::sim::Trace;\nuse super::model;\n",
    );
    let fails = |path, text| {
        let offences = upward(&Tree::made(&[fine, (path, text)]));
        assert_eq!(offences.len(), 1, "{path}: {offences:?}");
    };
    assert!(upward(&Tree::made(&[fine])).is_empty());
    fails(
        "src/sim/step.rs",
        "use super::super::recording::Recording;\n",
    );
    fails(
        "src/diagnose/mod.rs",
        "pub use crate::{fit, trial::Case};\n",
    );
    fails("src/app/mod.rs", "fn f() {\n    crate::cli::main();\n}\n");
    fails("src/tools/mod.rs", "");
    let tests = ("src/fit/tests.rs", "use crate::diagnose::Diagnosis;\n");
    let comment = ("src/model/mod.rs", "//! See `crate::fit`.\n");
    assert!(upward(&Tree::made(&[fine, tests, comment])).is_empty());
}
