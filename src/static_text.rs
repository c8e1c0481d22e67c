//! The program's own words in results (units, symbols, names of effects) read back from a file.
//!
//! Results hold them as `&'static str`. There are few different ones: each is stored once and
//! stays until the program ends.

use std::collections::BTreeSet;
use std::fmt;
use std::sync::{Mutex, PoisonError};

use serde::de::Error;
use serde::{Deserialize, Deserializer};

/// A text that lives as long as the program. The alias keeps serde from borrowing it from what
/// is read.
pub type StaticText = &'static str;

/// Longest text that is taken \[bytes\]: the program's own words are far shorter.
const MAX_TEXT_BYTES: usize = 300;
/// Most different texts that are taken in one run: a file of made-up words cannot fill the
/// memory.
const MAX_TEXTS: usize = 4096;

/// All texts that were read so far.
static STORED_TEXTS: Mutex<BTreeSet<StaticText>> = Mutex::new(BTreeSet::new());

/// Why a text is not taken.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unusual;

impl fmt::Display for Unusual {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a word of a result is none of the program's")
    }
}

/// `text` as one that lives as long as the program.
///
/// # Errors
/// [`Unusual`] if it is too long, or one of too many.
pub fn stored(text: &str) -> Result<StaticText, Unusual> {
    let mut stored = STORED_TEXTS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = stored.get(text) {
        return Ok(known);
    }
    if text.len() > MAX_TEXT_BYTES || stored.len() >= MAX_TEXTS {
        return Err(Unusual);
    }
    let text: StaticText = Box::leak(text.to_owned().into_boxed_str());
    stored.insert(text);
    Ok(text)
}

/// Reads one text.
///
/// # Errors
/// Those of the reader, and [`Unusual`].
pub fn one<'de, D: Deserializer<'de>>(reader: D) -> Result<StaticText, D::Error> {
    stored(&String::deserialize(reader)?).map_err(D::Error::custom)
}

/// Reads a text that may be absent.
///
/// # Errors
/// Those of the reader, and [`Unusual`].
pub fn optional<'de, D: Deserializer<'de>>(reader: D) -> Result<Option<StaticText>, D::Error> {
    let text = Option::<String>::deserialize(reader)?;
    text.map(|text| stored(&text).map_err(D::Error::custom))
        .transpose()
}

/// Reads several texts.
///
/// # Errors
/// Those of the reader, and [`Unusual`].
pub fn several<'de, D: Deserializer<'de>>(reader: D) -> Result<Vec<StaticText>, D::Error> {
    let texts = Vec::<String>::deserialize(reader)?;
    texts
        .iter()
        .map(|text| stored(text).map_err(D::Error::custom))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::static_text::*;

    #[test]
    fn a_text_is_stored_once_and_a_long_one_is_refused() {
        let first = stored("N s/m").unwrap();
        let again = stored("N s/m").unwrap();
        assert!(std::ptr::eq(first, again));
        assert_eq!(stored(&"x".repeat(MAX_TEXT_BYTES + 1)), Err(Unusual));
    }
}
