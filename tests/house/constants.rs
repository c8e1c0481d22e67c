//! A constant's name says what it is: no single word that fits anything.

use super::assert_none;
use super::source::{Tree, line, words};

/// Words that say nothing of what is measured, or in what.
const VAGUE: [&str; 40] = [
    "FAR", "NEAR", "MOST", "LEAST", "SHARE", "SMALL", "LOST", "OFF", "WHOLE", "APART", "CLOSE",
    "SHORT", "LONG", "CLEAR", "ODD", "BACK", "FEW", "HOP", "SURELY", "FORM", "KIN", "NEXT",
    "STILL", // Those below are as vague.
    "ASIDE", "BAD", "BESIDE", "BETTER", "BEYOND", "BIG", "ENOUGH", "GOOD", "LARGE", "LATE", "MANY",
    "MUCH", "OVER", "POOR", "ROUGH", "TOLD", "WORSE",
];

fn vague(tree: &Tree) -> Vec<String> {
    let mut offences = Vec::new();
    for (path, source) in &tree.files {
        let words = words(&source.code);
        for pair in words.windows(2) {
            let [(start, word), (_, name)] = [pair[0], pair[1]];
            if word == "const" && VAGUE.contains(&name) {
                offences.push(format!("{path}:{} {name}", line(&source.code, start)));
            }
        }
    }
    offences
}

#[test]
fn constants_have_telling_names() {
    let found = vague(&Tree::of_this_repository());
    assert_none("constants of a vague name", &found);
}

#[test]
fn a_vague_constant_is_seen() {
    let code = "const FAR_OFF_CHI2: f64 = 1.0;\n// const FAR: f64\npub(super) const FAR: f64 = 2.0;\n\
                fn f() { const FEW: usize = 3; }\n#[cfg(test)]\nmod tests {\n    const NEAR: f64 = 1.0;\n}\n";
    let found = vague(&Tree::made(&[("src/fit/a.rs", code)]));
    assert_eq!(found, ["src/fit/a.rs:3 FAR", "src/fit/a.rs:4 FEW"]);
}
