//! The lines of results in a session's file: comments of TOML, each with a hash of its own. A
//! line that was damaged or cut off is known by its hash.

use std::io::{Read, Write};

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use sha2::{Digest, Sha256};

use crate::app::files::session_text::RESULTS_MARK;

/// Begins a line of a part.
const PART_MARK: &str = "#@";
/// Version of the lines, not of what stands in them.
const LINES_VERSION: &str = "1";
/// Digits of a line's hash: 64 bit notice any damage.
const HASH_DIGITS: usize = 16;
/// Largest part \[bytes\], some hundred times what a large diagnosis needs: a made-up line
/// cannot fill the memory.
const MAX_PART_BYTES: u64 = 1 << 28;
/// The digits of base 64.
const BASE_64_DIGITS: &[u8; 64] =
    b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// A line, read.
#[derive(Debug, PartialEq)]
pub(super) struct Line<'a> {
    /// Name of the part.
    pub(super) id: &'a str,
    /// Its bytes; `None` if the line is damaged.
    pub(super) bytes: Option<Vec<u8>>,
}

/// What became of the lines of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Extent {
    /// All are there.
    Whole,
    /// Some are missing.
    Cut,
    /// Another version of the program wrote them.
    OtherVersion,
}

/// Hash and data of a part.
pub(super) fn data(bytes: &[u8]) -> String {
    let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
    // Writing to memory does not fail.
    let packed = packed
        .write_all(bytes)
        .and_then(|()| packed.finish())
        .unwrap_or_default();
    let text = to_base64(&packed);
    format!("{} {text}", hash(&text))
}

/// A whole line.
pub(super) fn line(id: &str, bytes: &[u8]) -> String {
    with_id(id, &data(bytes))
}

/// A whole line of hash and data.
pub(super) fn with_id(id: &str, data: &str) -> String {
    format!("{PART_MARK} {id} {data}")
}

/// All lines with their head, which says how many there are.
pub(super) fn joined(lines: &[String]) -> String {
    let mut text = format!(
        "{RESULTS_MARK}{LINES_VERSION} {}: what was computed in this session, for the program\n",
        lines.len()
    );
    for line in lines {
        text += line;
        text.push('\n');
    }
    text
}

/// Reads lines.
pub(super) fn read(text: &str) -> (Vec<Line<'_>>, Extent) {
    let mut all = text.lines();
    let head = all.next().and_then(|head| head.strip_prefix(RESULTS_MARK));
    let Some((version, rest)) = head.and_then(|head| head.split_once(' ')) else {
        let extent = match text.trim().is_empty() {
            true => Extent::Whole,
            false => Extent::Cut,
        };
        return (Vec::new(), extent);
    };
    if version != LINES_VERSION {
        return (Vec::new(), Extent::OtherVersion);
    }
    let count = rest.split(':').next().and_then(|n| n.parse::<usize>().ok());
    let lines: Vec<Line<'_>> = all.filter_map(part).collect();
    let extent = match count == Some(lines.len()) {
        true => Extent::Whole,
        false => Extent::Cut,
    };
    (lines, extent)
}

fn part(line: &str) -> Option<Line<'_>> {
    let mut words = line.split_whitespace();
    if words.next() != Some(PART_MARK) {
        return None;
    }
    let id = words.next()?;
    let bytes = match (words.next(), words.next(), words.next()) {
        (Some(expected), Some(text), None) if hash(text) == expected => unpacked(text),
        _ => None,
    };
    Some(Line { id, bytes })
}

fn unpacked(text: &str) -> Option<Vec<u8>> {
    let packed = from_base64(text)?;
    let mut bytes = Vec::new();
    let mut reader = ZlibDecoder::new(&packed[..]).take(MAX_PART_BYTES);
    reader.read_to_end(&mut bytes).ok()?;
    Some(bytes)
}

fn hash(text: &str) -> String {
    let digest = Sha256::digest(text.as_bytes());
    let digits: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
    digits[..HASH_DIGITS].to_owned()
}

/// Bytes in base 64, without padding.
fn to_base64(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len() * 4 / 3 + 4);
    for three in bytes.chunks(3) {
        let mut number = 0u32;
        for i in 0..3 {
            number = (number << 8) | u32::from(three.get(i).copied().unwrap_or(0));
        }
        for i in 0..=three.len() {
            let digit = (number >> (18 - 6 * i)) & 63;
            text.push(char::from(BASE_64_DIGITS[digit as usize]));
        }
    }
    text
}

/// The bytes of [`to_base64`].
fn from_base64(text: &str) -> Option<Vec<u8>> {
    let digit = |byte: &u8| match byte {
        b'A'..=b'Z' => Some(byte - b'A'),
        b'a'..=b'z' => Some(byte - b'a' + 26),
        b'0'..=b'9' => Some(byte - b'0' + 52),
        b'+' => Some(62),
        b'/' => Some(63),
        _ => None,
    };
    let mut bytes = Vec::with_capacity(text.len() * 3 / 4);
    for four in text.as_bytes().chunks(4) {
        let mut number = 0u32;
        for i in 0..4 {
            let next = four.get(i).map_or(Some(0), digit)?;
            number = (number << 6) | u32::from(next);
        }
        // One digit alone is no byte.
        let count = four.len().checked_sub(2)?;
        bytes.extend((0..=count).take(3).map(|i| (number >> (16 - 8 * i)) as u8));
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::lines::*;

    proptest! {
        #[test]
        fn bytes_come_back(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
            let text = to_base64(&bytes);
            prop_assert_eq!(from_base64(&text), Some(bytes.clone()));
            let text = joined(&[line("a", &bytes), line("b", &[])]);
            let (lines, extent) = read(&text);
            prop_assert_eq!(extent, Extent::Whole);
            prop_assert_eq!(lines[0].bytes.as_deref(), Some(&bytes[..]));
            prop_assert_eq!(lines[1].id, "b");
        }
    }

    #[test]
    fn the_digits_are_those_of_base_64() {
        assert_eq!(to_base64(b"Man"), "TWFu");
        assert_eq!(to_base64(b"Ma"), "TWE");
        assert_eq!(from_base64("TQ"), Some(b"M".to_vec()));
        assert_eq!(from_base64("T"), None);
        assert_eq!(from_base64("T*"), None);
    }

    #[test]
    fn damage_is_noticed_where_it_is() {
        let text = joined(&[line("a", b"one"), line("b", b"two")]);
        assert!(text.lines().all(|line| line.starts_with('#')));
        // Each digit of the second line in turn.
        let start = text.find(" b ").unwrap() + 3;
        for at in start..text.len() - 1 {
            let mut damaged = text.clone().into_bytes();
            damaged[at] = if damaged[at] == b'x' { b'y' } else { b'x' };
            let damaged = String::from_utf8(damaged).unwrap();
            let (lines, _) = read(&damaged);
            assert_eq!(lines[0].bytes.as_deref(), Some(&b"one"[..]));
            assert_eq!(lines[1].bytes, None, "{damaged}");
        }
        // Cut off anywhere behind the head.
        for end in text.find('\n').unwrap() + 1..text.len() - 1 {
            let (lines, extent) = read(&text[..end]);
            assert!(
                extent == Extent::Cut || lines.iter().any(|line| line.bytes.is_none()),
                "{end}"
            );
        }
        assert_eq!(read(""), (Vec::new(), Extent::Whole));
        let other = text.replacen(&format!("{RESULTS_MARK}1"), &format!("{RESULTS_MARK}2"), 1);
        assert_eq!(read(&other), (Vec::new(), Extent::OtherVersion));
    }
}
