//! The source files, their text without comments, strings and inline tests, and a small
//! lexer for the little Rust that the rules must understand.

use std::collections::BTreeMap;
use std::path::Path;

/// Files by their path from the root of the repository, such as `src/sim/mod.rs`.
#[derive(Debug, Default)]
pub struct Tree {
    pub files: BTreeMap<String, Source>,
}

/// One file.
#[derive(Debug)]
pub struct Source {
    /// The text as the compiler needs it: comments and the contents of strings are blanks,
    /// an inline `mod tests` is gone. Lines keep their numbers up to there.
    pub code: String,
    /// The string literals, without quotes.
    pub strings: Vec<String>,
}

impl Tree {
    /// All of `src` of this repository.
    pub fn of_this_repository() -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let mut tree = Self::default();
        tree.read(root, "src");
        assert!(tree.files.len() > 100, "{} files in src", tree.files.len());
        tree
    }

    fn read(&mut self, root: &Path, folder: &str) {
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            let entry = entry.unwrap();
            let path = format!("{folder}/{}", entry.file_name().to_str().unwrap());
            if entry.file_type().unwrap().is_dir() {
                self.read(root, &path);
            } else if path.ends_with(".rs") {
                let text = std::fs::read_to_string(entry.path()).unwrap();
                self.files.insert(path, Source::new(&text));
            }
        }
    }

    /// A made-up tree.
    pub fn made(files: &[(&str, &str)]) -> Self {
        let files = files
            .iter()
            .map(|(path, text)| ((*path).to_owned(), Source::new(text)));
        Self {
            files: files.collect(),
        }
    }
}

/// Whether a file is compiled for tests alone, by its name.
pub fn is_test(path: &str) -> bool {
    let stem = path.rsplit('/').next().unwrap_or(path);
    let stem = stem.strip_suffix(".rs").unwrap_or(stem);
    path.contains("/tests/")
        || stem == "tests"
        || stem.ends_with("_tests")
        || ["test_support", "fixture"].contains(&stem)
}

impl Source {
    pub fn new(text: &str) -> Self {
        let before_tests = text.split("#[cfg(test)]\nmod tests {").next();
        let (code, strings) = blanked(before_tests.unwrap_or(text));
        Self { code, strings }
    }
}

/// The text with blanks in place of comments and contents of strings, and the strings.
fn blanked(text: &str) -> (String, Vec<String>) {
    let chars: Vec<char> = text.chars().collect();
    let mut code = String::with_capacity(text.len());
    let mut strings = Vec::new();
    let mut i = 0;
    while i < chars.len() {
        let end = match chars[i] {
            '/' if chars.get(i + 1) == Some(&'/') => end_of_line(&chars, i),
            '/' if chars.get(i + 1) == Some(&'*') => end_of_block_comment(&chars, i),
            '"' => {
                let end = end_of_string(&chars, i + 1);
                strings.push(chars[i + 1..end - 1].iter().collect());
                end
            }
            'r' if !follows_a_word(&chars, i) => match raw_string(&chars, i) {
                Some((start, stop, end)) => {
                    strings.push(chars[start..stop].iter().collect());
                    end
                }
                None => i,
            },
            '\'' => end_of_char(&chars, i),
            _ => i,
        };
        if end == i {
            code.push(chars[i]);
            i += 1;
        } else {
            let blank = |c: &char| if *c == '\n' { '\n' } else { ' ' };
            code.extend(chars[i..end].iter().map(blank));
            i = end;
        }
    }
    (code, strings)
}

fn end_of_line(chars: &[char], start: usize) -> usize {
    let length = chars[start..].iter().position(|c| *c == '\n');
    length.map_or(chars.len(), |length| start + length)
}

fn end_of_block_comment(chars: &[char], start: usize) -> usize {
    let mut depth = 0;
    let mut i = start;
    while i + 1 < chars.len() {
        match (chars[i], chars[i + 1]) {
            ('/', '*') => depth += 1,
            ('*', '/') => depth -= 1,
            _ => {
                i += 1;
                continue;
            }
        }
        i += 2;
        if depth == 0 {
            return i;
        }
    }
    chars.len()
}

/// Behind the closing quote.
fn end_of_string(chars: &[char], start: usize) -> usize {
    let mut i = start;
    while i < chars.len() {
        match chars[i] {
            '\\' => i += 2,
            '"' => return i + 1,
            _ => i += 1,
        }
    }
    chars.len()
}

/// Start and end of the contents of `r"..."` or `r#"..."#`, and the end of the literal.
fn raw_string(chars: &[char], start: usize) -> Option<(usize, usize, usize)> {
    let hashes = chars[start + 1..].iter().take_while(|c| **c == '#').count();
    let first = start + 1 + hashes;
    if chars.get(first) != Some(&'"') {
        return None;
    }
    let closes = |i: &usize| {
        let rest = &chars[i + 1..];
        chars[*i] == '"' && rest.len() >= hashes && rest[..hashes].iter().all(|c| *c == '#')
    };
    let stop = (first + 1..chars.len()).find(closes)?;
    Some((first + 1, stop, stop + 1 + hashes))
}

/// Behind a character literal; `start` itself for a lifetime.
fn end_of_char(chars: &[char], start: usize) -> usize {
    if chars.get(start + 1) == Some(&'\\') {
        let closing = (start + 3..chars.len()).find(|i| chars[*i] == '\'');
        return closing.map_or(chars.len(), |i| i + 1);
    }
    if chars.get(start + 2) == Some(&'\'') {
        start + 3
    } else {
        start
    }
}

fn follows_a_word(chars: &[char], i: usize) -> bool {
    // The `b` of `br"..."` belongs to the literal.
    i > 0 && is_word(chars[i - 1]) && !(chars[i - 1] == 'b' && (i < 2 || !is_word(chars[i - 2])))
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The words of blanked code, with where each begins.
pub fn words(code: &str) -> Vec<(usize, &str)> {
    let mut words = Vec::new();
    let mut start = None;
    for (i, c) in code.char_indices().chain([(code.len(), ' ')]) {
        match (is_word(c), start) {
            (true, None) => start = Some(i),
            (false, Some(s)) => {
                words.push((s, &code[s..i]));
                start = None;
            }
            _ => {}
        }
    }
    words
}

/// The number of the line of a place in the code.
pub fn line(code: &str, place: usize) -> usize {
    1 + code[..place].matches('\n').count()
}

#[test]
fn comments_strings_and_tests_are_no_code() {
    let source = Source::new(
        "use a::b; // use c::d;\n/* fn x() { /* } */ */ let s = \"fn y() { \\\" }\"; let r = r#\"a\"b\"#;\n\
         let c = '\"'; let e = '\\''; fn f<'a>(x: &'a str) {}\n#[cfg(test)]\nmod tests {\n use e;\n}\n",
    );
    for gone in ["c::d", "fn x", "fn y", "use e", "\""] {
        assert!(!source.code.contains(gone), "{gone} in {}", source.code);
    }
    for kept in ["use a::b;", "let r =", "fn f<'a>(x: &'a str) {}"] {
        assert!(source.code.contains(kept), "no {kept} in {}", source.code);
    }
    assert_eq!(source.strings, ["fn y() { \\\" }", "a\"b"]);
    assert_eq!(
        words("let x_1 = f(a);"),
        [(0, "let"), (4, "x_1"), (10, "f"), (12, "a")]
    );
}

#[test]
fn test_files_are_told_by_their_names() {
    for path in [
        "src/a/tests.rs",
        "src/a/tests/made_up.rs",
        "src/a_tests.rs",
        "src/a/fixture.rs",
    ] {
        assert!(is_test(path), "{path}");
    }
    for path in [
        "src/contact/law_test.rs",
        "src/score_test/scan.rs",
        "src/a/latest.rs",
    ] {
        assert!(!is_test(path), "{path}");
    }
}
