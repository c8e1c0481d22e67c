//! The `use` lines of a file, and the file that each path leads to.

use std::collections::{BTreeMap, BTreeSet};

use super::source::{Tree, words};

/// One path of a `use` line, braces taken apart: `use a::{b, c::d};` has two.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Use {
    /// The path as it is written, without `as`.
    pub path: Vec<String>,
    /// `pub use` and `pub(...) use`: the file offers the name, it need not use it.
    pub re_export: bool,
}

/// The `use` lines of blanked code.
pub fn uses(code: &str) -> Vec<Use> {
    let mut found = Vec::new();
    for (start, word) in words(code) {
        if word != "use" {
            continue;
        }
        let line_start = code[..start].rfind('\n').map_or(0, |i| i + 1);
        let before = code[line_start..start].trim();
        let re_export = before.starts_with("pub");
        if !(before.is_empty() || re_export) {
            continue;
        }
        let rest = &code[start + "use".len()..];
        let tree = &rest[..rest.find(';').unwrap_or(rest.len())];
        let paths = expanded(tree.trim()).into_iter();
        found.extend(paths.map(|path| Use { path, re_export }));
    }
    found
}

/// The paths of a `use` tree: nested braces taken apart, `as` left out.
fn expanded(tree: &str) -> Vec<Vec<String>> {
    let Some(open) = tree.find('{') else {
        let path = tree.split(" as ").next().unwrap_or(tree);
        return vec![segments(path)];
    };
    let prefix = segments(tree[..open].trim_end().trim_end_matches("::"));
    let inner = &tree[open + 1..tree.rfind('}').unwrap_or(tree.len())];
    let mut paths = Vec::new();
    for part in split_at_commas(inner) {
        for path in expanded(part) {
            // `a::{self}` is `a`.
            let own = path
                .iter()
                .skip(usize::from(path.first().is_some_and(|s| s == "self")));
            paths.push(prefix.iter().chain(own).cloned().collect());
        }
    }
    paths
}

fn segments(path: &str) -> Vec<String> {
    let segments = path.split("::").map(str::trim);
    let named = segments.filter(|segment| !segment.is_empty());
    named.map(str::to_owned).collect()
}

/// The parts between the commas that are in no braces.
fn split_at_commas(text: &str) -> Vec<&str> {
    let mut parts = Vec::new();
    let (mut depth, mut start) = (0, 0);
    for (i, c) in text.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(text[start..i].trim());
                start = i + 1;
            }
            _ => {}
        }
    }
    parts.push(text[start..].trim());
    parts.retain(|part| !part.is_empty());
    parts
}

/// The module of a file, such as `sim::step` for `src/sim/step.rs`; none for the roots.
pub fn module(path: &str) -> Option<String> {
    let path = path.strip_prefix("src/")?.strip_suffix(".rs")?;
    let path = path.strip_suffix("/mod").unwrap_or(path);
    (!["lib", "main"].contains(&path)).then(|| path.replace('/', "::"))
}

/// Where each module is.
pub struct Modules {
    files: BTreeMap<String, String>,
}

impl Modules {
    pub fn of(tree: &Tree) -> Self {
        let files = tree.files.keys();
        let files = files.filter_map(|path| Some((module(path)?, path.clone())));
        Self {
            files: files.collect(),
        }
    }

    /// The path of a `use` line from the crate's root; none if it leads out of the crate.
    pub fn path_from_root(&self, here: &str, path: &[String]) -> Option<Vec<String>> {
        let here: Vec<String> = segments(here);
        let ups = path
            .iter()
            .take_while(|segment| *segment == "super")
            .count();
        let (base, rest) = match path.first()?.as_str() {
            "crate" => (&here[..0], &path[1..]),
            "self" => (&here[..], &path[1..]),
            "super" => (&here[..here.len().checked_sub(ups)?], &path[ups..]),
            child
                if self
                    .files
                    .contains_key(&[here.join("::").as_str(), child].join("::")) =>
            {
                (&here[..], path)
            }
            _ => return None,
        };
        Some(base.iter().chain(rest).cloned().collect())
    }

    /// The file that a path from the root leads to: the deepest module on it.
    pub fn file(&self, path: &[String]) -> Option<&str> {
        let deepest = (1..=path.len()).rev();
        let mut found = deepest.filter_map(|n| self.files.get(&path[..n].join("::")));
        found.next().map(String::as_str)
    }
}

/// Which files each file uses, re-exports left out.
pub fn imports(tree: &Tree) -> BTreeMap<String, BTreeSet<String>> {
    let modules = Modules::of(tree);
    let of_file = |path: &String, code: &str| {
        let here = module(path).unwrap_or_default();
        let own = uses(code).into_iter().filter(|u| !u.re_export);
        let paths = own.filter_map(|u| modules.path_from_root(&here, &u.path));
        let files = paths.filter_map(|p| modules.file(&p).map(str::to_owned));
        files.filter(|file| file != path).collect()
    };
    let files = tree.files.iter().filter(|(path, _)| module(path).is_some());
    files
        .map(|(path, source)| (path.clone(), of_file(path, &source.code)))
        .collect()
}

#[test]
fn nested_braces_and_names_are_taken_apart() {
    let code = "use std::fmt;\npub use a::B;\npub(super) use c::D;\n    use crate::{\n    a::{self, B as C},\n    d::*,\n};\n";
    let found = uses(code);
    let written = |re_export| {
        let found = found.iter().filter(move |u| u.re_export == re_export);
        found.map(|u| u.path.join("::")).collect::<Vec<_>>()
    };
    assert_eq!(
        written(false),
        ["std::fmt", "crate::a", "crate::a::B", "crate::d::*"]
    );
    assert_eq!(written(true), ["a::B", "c::D"]);
}

#[test]
fn paths_lead_to_files() {
    let tree = Tree::made(&[
        ("src/lib.rs", "use self::a::A;"),
        (
            "src/a/mod.rs",
            "use b::B;\nuse self::c::C;\npub use d::D;\n",
        ),
        (
            "src/a/b.rs",
            "use super::c::{C, other as o};\nuse super::super::e::E;\nuse std::fmt;\n",
        ),
        (
            "src/a/c.rs",
            "use crate::a::d::deep::Deep;\n#[cfg(test)]\nmod tests {\n    use super::b;\n}\n",
        ),
        ("src/a/d.rs", "use super::Thing;\n"),
        ("src/e.rs", "use crate::e::own;\n"),
    ]);
    let imports = imports(&tree);
    let of = |path: &str| imports[path].iter().map(String::as_str).collect::<Vec<_>>();
    assert_eq!(of("src/a/mod.rs"), ["src/a/b.rs", "src/a/c.rs"]);
    assert_eq!(of("src/a/b.rs"), ["src/a/c.rs", "src/e.rs"]);
    assert_eq!(of("src/a/c.rs"), ["src/a/d.rs"]);
    assert_eq!(of("src/a/d.rs"), ["src/a/mod.rs"]);
    assert!(of("src/e.rs").is_empty() && !imports.contains_key("src/lib.rs"));
}
