//! A cell without what surrounds its number: quotes, a typographic minus, marks between thousands that
//! cannot be anything else.

use std::borrow::Cow;

/// A cell without what surrounds its number.
pub(super) struct PlainCell<'a> {
    pub text: Cow<'a, [u8]>,
    /// Whether the decimal mark may be a comma.
    pub comma: bool,
    /// Whether a typographic minus was taken off.
    pub negative: bool,
}

impl<'a> PlainCell<'a> {
    pub fn of(text: &'a [u8], comma: bool) -> Self {
        let mut text = text.trim_ascii();
        let mut comma = comma;
        if let Some(inner) = text.strip_prefix(b"\"").and_then(|t| t.strip_suffix(b"\"")) {
            text = inner.trim_ascii();
            // Inside quotes a comma cannot be a delimiter.
            comma = true;
        }
        // U+2212, the minus of typeset tables.
        let (text, negative) = match text.strip_prefix("\u{2212}".as_bytes()) {
            Some(rest) if !rest.starts_with(b"-") && !rest.starts_with(b"+") => (rest, true),
            _ => (text, false),
        };
        Self {
            text: without_thousands_marks(text),
            comma,
            negative,
        }
    }
}

/// Marks between thousands that are no decimal marks: apostrophes, fixed and narrow spaces. Points
/// and commas are not among them: `1.000` is one, or a thousand.
const THOUSANDS_MARKS: [&str; 5] = ["'", "\u{2019}", "\u{a0}", "\u{202f}", "\u{2009}"];

/// `1'732'752.5` without its marks; any other text as it is.
fn without_thousands_marks(text: &[u8]) -> Cow<'_, [u8]> {
    let mark_at = |p: usize| {
        let found = THOUSANDS_MARKS
            .iter()
            .find(|m| text[p..].starts_with(m.as_bytes()));
        found.map(|m| m.len())
    };
    let start = usize::from(matches!(text.first(), Some(b'-' | b'+')));
    let digits = |from: usize| {
        text[from..]
            .iter()
            .take_while(|b| b.is_ascii_digit())
            .count()
    };
    let lead = digits(start);
    let mut p = start + lead;
    if !(1..=3).contains(&lead) || p >= text.len() || mark_at(p).is_none() {
        return Cow::Borrowed(text);
    }
    let mut plain = text[..p].to_vec();
    while let Some(mark) = mark_at(p).filter(|mark| digits(p + mark) == 3) {
        plain.extend_from_slice(&text[p + mark..p + mark + 3]);
        p += mark + 3;
    }
    // A mark that is left makes the rest no number.
    plain.extend_from_slice(&text[p..]);
    Cow::Owned(plain)
}
