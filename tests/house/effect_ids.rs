//! An effect is one file and one line in the catalogue: nothing else knows it by its id.

use std::collections::BTreeSet;

use super::assert_none;
use super::source::{Tree, is_test, words};

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
        .filter(|stem| !stem.ends_with("_tests"))
        .collect()
}

/// The id in a string that is one, or that begins with one and a parameter, as `effect.parameter`.
fn id_in<'a>(string: &'a str, ids: &BTreeSet<&str>) -> Option<&'a str> {
    let (id, _) = string.split_once('.').unwrap_or((string, ""));
    let parameter = string.strip_prefix(id).unwrap_or("");
    let one_word = |text: &str| !text.chars().any(char::is_whitespace);
    (ids.contains(id) && one_word(parameter)).then_some(id)
}

/// Effects whose own modules are named in the code, as `effects::effect` or within the braces of
/// `effects::{...}`.
fn modules_in<'a>(code: &'a str, ids: &BTreeSet<&str>) -> BTreeSet<&'a str> {
    let words = words(code);
    let mut found = BTreeSet::new();
    for (i, (start, word)) in words.iter().enumerate() {
        if *word != "effects" {
            continue;
        }
        let rest = code[start + word.len()..].trim_start();
        let Some(path) = rest.strip_prefix("::") else {
            continue;
        };
        let path = path.trim_start();
        // An import ends with its semicolon.
        let end = code.len() - path.len() + path.find([';', '}']).unwrap_or(path.len());
        let braces = path.starts_with('{');
        let after = words[i + 1..].iter().take_while(|(at, _)| *at < end);
        let after = after.take(if braces { usize::MAX } else { 1 });
        found.extend(
            after
                .map(|(_, name)| *name)
                .filter(|name| ids.contains(name)),
        );
    }
    found
}

/// Ids as string literals or modules outside the effects, tests, and the sealed trial, which must
/// not share a description with what it examines.
fn known_elsewhere(tree: &Tree) -> Vec<String> {
    let ids = ids(tree);
    let mut offences = Vec::new();
    for (path, source) in &tree.files {
        if path.starts_with(EFFECTS) || path.contains("/trial/") || is_test(path) {
            continue;
        }
        let strings = source.strings.iter().map(String::as_str);
        let mut named: BTreeSet<&str> = strings.filter_map(|s| id_in(s, &ids)).collect();
        named.extend(modules_in(&source.code, &ids));
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
    for code in [
        "fn f() -> &str { \"gravity.g\" }",
        "fn f() -> String { format!(\"gravity.{p}\") }",
        "use crate::model::effects::gravity::EFFECT;",
        "use crate::model::effects::{ActiveEffect, gravity::EFFECT};",
        "fn f() { model::effects::gravity::build() }",
    ] {
        let tree = Tree::made(&[effect, ("src/fit/a.rs", code)]);
        assert_eq!(known_elsewhere(&tree), ["src/fit/a.rs: gravity"], "{code}");
    }
    for code in [
        "// \"gravity\"\nfn f() -> &str { \"gravity of a case\" }",
        "fn f() -> &str { \"gravity. It is off.\" }",
        "use crate::model::effects::find;\nfn gravity() {}",
        "use crate::model::effects::{find, Need};\nfn gravity() {}",
    ] {
        let tree = Tree::made(&[effect, ("src/fit/a.rs", code)]);
        assert!(known_elsewhere(&tree).is_empty(), "{code}");
    }
}
