//! What is wrong with a TOML text, in one line whatever the text holds. A text may be one line
//! of megabytes, and hold control characters that a terminal obeys.

use std::fmt;

/// Characters of the line shown before the fault, and after it.
const SHOWN_AROUND: (usize, usize) = (20, 40);
/// Most characters of a key in a message.
const MAX_KEY_LENGTH: usize = 80;
/// Most characters of a reason; the longest list of known names is shorter.
const MAX_REASON_LENGTH: usize = 1000;

/// A fault of a TOML text. Its text form is one short line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TomlFault {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What stands there, without control characters.
    pub excerpt: String,
    /// What is wrong, without control characters.
    pub reason: String,
}

impl TomlFault {
    /// The fault that reading `text` gave.
    pub fn new(text: &str, error: &toml::de::Error) -> Self {
        let start = error.span().map_or(0, |span| span.start).min(text.len());
        // A span begins at a character, but nothing relies on it.
        let start = (0..=start)
            .rev()
            .find(|i| text.is_char_boundary(*i))
            .unwrap_or(0);
        let (before, after) = text.split_at(start);
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        let in_line = &before[line_start..];
        let rest = after.split('\n').next().unwrap_or_default();
        let column = in_line.chars().count() + 1;
        let skipped = (column - 1).saturating_sub(SHOWN_AROUND.0);
        let mut excerpt = String::new();
        if skipped > 0 {
            excerpt += "...";
        }
        excerpt.extend(in_line.chars().skip(skipped));
        excerpt.extend(rest.chars().take(SHOWN_AROUND.1));
        if rest.chars().nth(SHOWN_AROUND.1).is_some() {
            excerpt += "...";
        }
        Self {
            line: before.matches('\n').count() + 1,
            column,
            excerpt: escaped(excerpt.trim()),
            reason: short_reason(error.message()),
        }
    }
}

impl fmt::Display for TomlFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            line,
            column,
            excerpt,
            reason,
        } = self;
        write!(f, "line {line}, column {column}: {reason}")?;
        if excerpt.is_empty() {
            return Ok(());
        }
        write!(f, "; there stands: {excerpt}")
    }
}

/// A key as it is named in a message.
pub fn short_key(key: &str) -> String {
    shortened(key, MAX_KEY_LENGTH)
}

/// A reason that may hold text of a file, as it stands in a message.
pub fn short_reason(reason: &str) -> String {
    shortened(reason, MAX_REASON_LENGTH)
}

/// `text` without control characters; its middle left out if it has more than `most`
/// characters.
fn shortened(text: &str, most: usize) -> String {
    let text = text.trim();
    let count = text.chars().count();
    if count <= most {
        return escaped(text);
    }
    // The end of a message says what was expected.
    let (head, tail) = (most / 2, most / 4);
    let first: String = text.chars().take(head).collect();
    let last: String = text.chars().skip(count - tail).collect();
    let left_out = count - head - tail;
    format!(
        "{} ... ({left_out} characters) ... {}",
        escaped(&first),
        escaped(&last)
    )
}

/// Control characters as they are typed, line ends as `; `.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\n' => out += "; ",
            '\t' => out.push(' '),
            c if c.is_control() => out.extend(c.escape_default()),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::toml_fault::*;

    fn fault(text: &str) -> TomlFault {
        TomlFault::new(text, &toml::from_str::<toml::Table>(text).unwrap_err())
    }

    #[test]
    fn a_fault_names_its_place_and_shows_what_stands_there() {
        let found = fault("a = 1\nbb = 2 2\n");
        assert_eq!(found.line, 2);
        assert!(found.column >= 5, "{found}");
        assert!(found.to_string().contains("bb = 2"), "{found}");
    }

    #[test]
    fn a_line_of_half_a_megabyte_gives_a_short_message() {
        let long = "x".repeat(467_000);
        for text in [
            format!("a = \"{long}"),
            format!("{long} {long}"),
            format!("a = {{ b = [{long}] }}"),
            format!("a = \"{long}\" b"),
            format!("\u{e9}{long} = \u{1b}[31m"),
        ] {
            let said = fault(&text).to_string();
            assert!(said.len() < 1500, "{} bytes", said.len());
            assert!(!said.contains(char::is_control), "{said:?}");
        }
    }

    #[test]
    fn control_characters_are_written_out() {
        assert_eq!(short_key("a\u{1b}[31mb"), "a\\u{1b}[31mb");
        assert_eq!(short_reason("one\ntwo"), "one; two");
        let cut = short_reason(&"\u{7}".repeat(5000));
        assert!(cut.contains("(4250 characters)"), "{cut}");
        assert!(!cut.contains('\u{7}'));
    }
}
