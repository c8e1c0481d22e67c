//! An effect is one file and one line in the catalogue: nothing else knows it by its id.

use std::collections::BTreeSet;

use super::assert_none;
use super::source::{Tree, is_test};

const EFFECTS: &str = "src/model/effects/";

/// The ids of the effects: each has a file of its name.
fn ids(tree: &Tree) -> BTreeSet<&str> {
    let files = tree
        .files
        .keys()
        .filter_map(|path| path.strip_prefix(EFFECTS));
    let stems = files.filter_map(|file| file.strip_suffix(".rs"));
    stems
        .filter(|stem| !["mod", "tests"].contains(stem) && !stem.contains('/'))
        .collect()
}

/// Ids as string literals outside the effects, tests, and the sealed trial, which must not
/// share a description with what it examines.
fn known_elsewhere(tree: &Tree) -> Vec<String> {
    let ids = ids(tree);
    let mut offences = Vec::new();
    for (path, source) in &tree.files {
        if path.starts_with(EFFECTS) || path.contains("/trial/") || is_test(path) {
            continue;
        }
        let strings = source.strings.iter().map(String::as_str);
        let named: BTreeSet<&str> = strings.filter(|s| ids.contains(s)).collect();
        if !named.is_empty() {
            let named: Vec<&str> = named.into_iter().collect();
            offences.push(format!("{path}: {}", named.join(", ")));
        }
    }
    offences
}

#[test]
fn no_effect_is_known_by_its_id_elsewhere() {
    let tree = Tree::of_this_repository();
    let n = ids(&tree).len();
    assert!(n >= 18, "{n} effects");
    assert_none("files with ids of effects", &known_elsewhere(&tree));
}

#[test]
fn an_id_elsewhere_is_seen() {
    let effect = (
        "src/model/effects/gravity.rs",
        "const ID: &str = \"gravity\";",
    );
    let code = "// \"gravity\"\nfn f(id: &str) -> bool { id == \"gravity\" }";
    for path in [
        "src/fit/a.rs",
        "src/cli/a.rs",
        "src/diagnose/score_test/scan.rs",
    ] {
        let tree = Tree::made(&[effect, (path, code)]);
        assert_eq!(known_elsewhere(&tree), [format!("{path}: gravity")]);
    }
    for path in [
        "src/trial/menu.rs",
        "src/fit/tests.rs",
        "src/model/effects/mod.rs",
    ] {
        assert!(known_elsewhere(&Tree::made(&[effect, (path, code)])).is_empty());
    }
    let other = "// \"gravity\"\nfn f() -> &str { \"gravity of a case\" }";
    assert!(known_elsewhere(&Tree::made(&[effect, ("src/fit/a.rs", other)])).is_empty());
}
