//! A function is read on one or two screens: at most a hundred lines, tables excepted.

use super::assert_none;
use super::source::{Tree, is_test, line, words};

const MAX_LINES: usize = 100;

/// Tables written as functions, one entry after the other: file, function, and why.
const TABLES: [(&str, &str, &str); 1] = [(
    "src/app/setup/command/text.rs",
    "text",
    "the name and the help of each command",
)];

/// The functions of blanked code: name, first line, number of lines.
fn functions(code: &str) -> Vec<(&str, usize, usize)> {
    let words = words(code);
    let mut found = Vec::new();
    for pair in words.windows(2) {
        let [(start, word), (place, name)] = [pair[0], pair[1]];
        // `fn(f64)` is a type, without a name.
        if word != "fn" || !code[start + word.len()..place].trim().is_empty() {
            continue;
        }
        if let Some(end) = end_of_body(code, place) {
            let (first, last) = (line(code, start), line(code, end));
            found.push((name, first, last - first + 1));
        }
    }
    found
}

/// Where the body of a function ends; none for a declaration.
fn end_of_body(code: &str, start: usize) -> Option<usize> {
    let (mut braces, mut others) = (0, 0);
    for (i, c) in code[start..].char_indices() {
        match c {
            '(' | '[' => others += 1,
            ')' | ']' => others -= 1,
            '{' => braces += 1,
            '}' => {
                braces -= 1;
                if braces == 0 && others == 0 {
                    return Some(start + i);
                }
            }
            ';' if braces == 0 && others == 0 => return None,
            _ => {}
        }
    }
    None
}

/// What is wrong: long functions that are no tables, and tables that are not there.
fn offences(tree: &Tree, tables: &[(&str, &str, &str)]) -> Vec<String> {
    let mut offences = Vec::new();
    let mut long = Vec::new();
    for (path, source) in tree.files.iter().filter(|(path, _)| !is_test(path)) {
        for (name, first, lines) in functions(&source.code) {
            if lines > MAX_LINES {
                long.push((path.as_str(), name));
                if !tables.iter().any(|(p, n, _)| (*p, *n) == (path, name)) {
                    offences.push(format!("{path}:{first} {name}: {lines} lines"));
                }
            }
        }
    }
    for (path, name, _) in tables {
        if !long.contains(&(path, name)) {
            offences.push(format!("{path}: {name} is no table of that length"));
        }
    }
    offences
}

#[test]
fn functions_are_short() {
    for (path, name, reason) in TABLES {
        assert!(!reason.is_empty(), "no reason for {name} in {path}");
    }
    let found = offences(&Tree::of_this_repository(), &TABLES);
    assert_none("functions of more than a hundred lines", &found);
}

#[test]
fn a_long_function_is_seen() {
    let body = |n: usize| "    f([1; 2]);\n".repeat(n);
    let of = |n: usize| {
        format!(
            "fn short() {{}}\nfn long(x: [u8; 2]) -> u8 {{\n{}}}\n",
            body(n)
        )
    };
    let path = "src/fit/a.rs";
    let (fine, long) = (of(98), of(99));
    assert!(offences(&Tree::made(&[(path, &fine)]), &[]).is_empty());
    let tree = Tree::made(&[(path, &long)]);
    assert_eq!(offences(&tree, &[]), ["src/fit/a.rs:2 long: 101 lines"]);
    assert!(offences(&tree, &[(path, "long", "made up")]).is_empty());
    // What is short again must be taken off the list.
    let stale = offences(&Tree::made(&[(path, &fine)]), &[(path, "long", "made up")]);
    assert_eq!(stale.len(), 1);
    let declared = format!(
        "trait T {{\n    fn declared(x: fn(u8) -> u8);\n{}}}\n",
        body(120)
    );
    assert!(offences(&Tree::made(&[(path, &declared)]), &[]).is_empty());
}
