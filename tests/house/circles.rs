//! Files do not use each other in circles.

use std::collections::{BTreeMap, BTreeSet};

use super::assert_none;
use super::source::Tree;
use super::uses::imports;

/// Circles that may stay, at most four: the files of each, and why it is natural.
const ALLOWED: [(&[&str], &str); 0] = [];

type Graph = BTreeMap<String, BTreeSet<String>>;

/// Groups of two and more files of which each leads to each other.
fn circles(graph: &Graph) -> Vec<BTreeSet<String>> {
    let reach: BTreeMap<&str, BTreeSet<&str>> = graph
        .keys()
        .map(|file| (file.as_str(), reachable(graph, file)))
        .collect();
    let mut found: Vec<BTreeSet<String>> = Vec::new();
    for (file, reached) in &reach {
        let back = |other: &&&str| reach.get(**other).is_some_and(|r| r.contains(file));
        let group: BTreeSet<String> = reached
            .iter()
            .filter(back)
            .map(|s| (*s).to_owned())
            .collect();
        if group.len() > 1 && !found.contains(&group) {
            found.push(group);
        }
    }
    found
}

fn reachable<'a>(graph: &'a Graph, start: &str) -> BTreeSet<&'a str> {
    let mut reached = BTreeSet::new();
    let mut next: Vec<&str> = graph[start].iter().map(String::as_str).collect();
    while let Some(file) = next.pop() {
        if reached.insert(file) {
            let further = graph.get(file).into_iter().flatten();
            next.extend(further.map(String::as_str));
        }
    }
    reached
}

/// What is wrong: circles that are not allowed, and allowed ones that are not there.
fn offences(tree: &Tree, allowed: &[(&[&str], &str)]) -> Vec<String> {
    let found = circles(&imports(tree));
    let is = |circle: &BTreeSet<String>, files: &[&str]| {
        circle.len() == files.len() && files.iter().all(|file| circle.contains(*file))
    };
    let mut offences = Vec::new();
    for circle in &found {
        if !allowed.iter().any(|(files, _)| is(circle, files)) {
            let files: Vec<&str> = circle.iter().map(String::as_str).collect();
            offences.push(format!("{} files: {}", files.len(), files.join(", ")));
        }
    }
    for (files, _) in allowed {
        if !found.iter().any(|circle| is(circle, files)) {
            offences.push(format!("allowed, but not there: {}", files.join(", ")));
        }
    }
    offences
}

#[test]
fn there_are_no_circles() {
    let n = ALLOWED.len();
    assert!(n <= 4, "{n} circles are allowed, four are the most");
    for (files, reason) in ALLOWED {
        assert!(!reason.is_empty(), "no reason for {files:?}");
    }
    let found = offences(&Tree::of_this_repository(), &ALLOWED);
    assert_none("circles of imports", &found);
}

#[test]
fn a_circle_is_seen() {
    let a = ("src/sim/a.rs", "use super::b::B;\n");
    let b = ("src/sim/b.rs", "use super::c::C;\n");
    let c = ("src/sim/c.rs", "use super::a::A;\n");
    let line = Tree::made(&[a, b, ("src/sim/c.rs", "")]);
    assert!(offences(&line, &[]).is_empty());
    let circle = Tree::made(&[a, b, c]);
    let files: &[&str] = &["src/sim/a.rs", "src/sim/b.rs", "src/sim/c.rs"];
    assert_eq!(
        offences(&circle, &[]),
        [format!("3 files: {}", files.join(", "))]
    );
    assert!(offences(&circle, &[(files, "made up")]).is_empty());
    // A part of it allowed is not all of it, and what is gone must be taken off the list.
    assert_eq!(offences(&circle, &[(&files[..2], "made up")]).len(), 2);
    // A folder and its file count; a re-export and a test do not.
    let folder = ("src/fit/mod.rs", "mod x;\nuse x::X;\n");
    let child = ("src/fit/x.rs", "use super::Fit;\n");
    assert_eq!(offences(&Tree::made(&[folder, child]), &[]).len(), 1);
    let re_export = ("src/fit/mod.rs", "mod x;\npub use x::X;\n");
    assert!(offences(&Tree::made(&[re_export, child]), &[]).is_empty());
    let test = (
        "src/fit/x.rs",
        "#[cfg(test)]\nmod tests {\n    use super::super::Fit;\n}\n",
    );
    assert!(offences(&Tree::made(&[folder, test]), &[]).is_empty());
}
