//! Bytes to UTF-8: which encoding a file is in, and its decoding.

use std::borrow::Cow;

use crate::recording::csv::settings::Encoding;
use crate::recording::error::{ImportWarning, WarningKind};

/// Bytes looked at for the zeros of UTF-16.
const ZERO_SAMPLE_BYTES: usize = 64 << 10;
/// Longest incomplete character at the end of a part of a file \[bytes\].
const MAX_CHARACTER_BYTES: usize = 4;

/// Text in UTF-8, and what it was.
#[derive(Debug)]
pub(in crate::recording::csv) struct Decoded<'a> {
    /// UTF-8 without a byte-order mark.
    pub bytes: Cow<'a, [u8]>,
    /// The encoding, if it was not UTF-8.
    pub from: Option<Encoding>,
    /// Whether the encoding was recognised without a mark that says it.
    pub guessed: bool,
    /// Zero bytes that were cut off the end.
    pub zeros_cut: usize,
    /// Whether some bytes are none of the encoding; they show as U+FFFD.
    pub malformed: bool,
}

/// Decodes `bytes`, by `chosen` if given. With `cut` they are the beginning of a longer file.
pub(in crate::recording::csv) fn decode(
    bytes: &[u8],
    chosen: Option<Encoding>,
    cut: bool,
) -> Decoded<'_> {
    let mark = mark(bytes);
    let (from, guessed) = match (chosen, mark) {
        (Some(encoding), _) => (encoding, false),
        (None, Some((encoding, _))) => (encoding, false),
        (None, None) => recognise(bytes, cut),
    };
    let skip = mark.filter(|(own, _)| *own == from).map_or(0, |(_, n)| n);
    let text = bytes.get(skip..).unwrap_or_default();
    let wide = matches!(from, Encoding::Utf16Le | Encoding::Utf16Be);
    let kept = if wide { text } else { without_zero_tail(text) };
    let zeros_cut = text.len() - kept.len();
    if from == Encoding::Utf8 && is_utf8(kept, cut) {
        return Decoded {
            bytes: Cow::Borrowed(kept),
            from: None,
            guessed: false,
            zeros_cut,
            malformed: false,
        };
    }
    let (decoded, malformed) = from.decoder().decode_without_bom_handling(kept);
    let mut decoded = decoded.into_owned().into_bytes();
    let before = decoded.len();
    decoded.truncate(without_zero_tail(&decoded).len());
    Decoded {
        zeros_cut: zeros_cut + before - decoded.len(),
        bytes: Cow::Owned(decoded),
        from: Some(from),
        guessed,
        malformed: malformed && !cut,
    }
}

/// What is said of an encoding that was recognised.
pub(in crate::recording::csv) fn encoding_warning(encoding: Encoding) -> ImportWarning {
    let message = format!(
        "the text is not UTF-8; it is read as {} (--encoding names another)",
        encoding.label()
    );
    ImportWarning::new(WarningKind::TextEncoding, 1, None, &message)
}

/// The encoding that a byte-order mark says, and the mark's length.
fn mark(bytes: &[u8]) -> Option<(Encoding, usize)> {
    let marks: [(&[u8], Encoding); 3] = [
        (&[0xef, 0xbb, 0xbf], Encoding::Utf8),
        (&[0xff, 0xfe], Encoding::Utf16Le),
        (&[0xfe, 0xff], Encoding::Utf16Be),
    ];
    marks
        .iter()
        .find(|(mark, _)| bytes.starts_with(mark))
        .map(|(mark, encoding)| (*encoding, mark.len()))
}

/// The bytes without the zeros that loggers leave at the end of a block.
fn without_zero_tail(bytes: &[u8]) -> &[u8] {
    let end = bytes.iter().rposition(|b| *b != 0).map_or(0, |p| p + 1);
    bytes.get(..end).unwrap_or(bytes)
}

/// Whether it is UTF-8; with `cut` a character may end beyond.
fn is_utf8(bytes: &[u8], cut: bool) -> bool {
    match std::str::from_utf8(bytes) {
        Ok(_) => true,
        Err(error) => {
            cut && error.error_len().is_none()
                && bytes.len() - error.valid_up_to() < MAX_CHARACTER_BYTES
        }
    }
}

/// The encoding of bytes without a mark, and whether it is a guess.
fn recognise(bytes: &[u8], cut: bool) -> (Encoding, bool) {
    if let Some(wide) = by_zeros(bytes) {
        return (wide, true);
    }
    if is_utf8(without_zero_tail(bytes), cut) {
        return (Encoding::Utf8, false);
    }
    // Chinese text stands in pairs of high bytes; a Western accent or micro sign stands alone.
    let mut pairs = 0usize;
    let mut single = 0usize;
    for run in bytes.split(|b| *b < 0xa1).filter(|run| !run.is_empty()) {
        if run.len().is_multiple_of(2) {
            pairs += 1;
        } else {
            single += 1;
        }
    }
    let is_gbk = pairs > single
        && Encoding::Gbk
            .decoder()
            .decode_without_bom_handling_and_without_replacement(without_zero_tail(bytes))
            .is_some();
    (
        if is_gbk {
            Encoding::Gbk
        } else {
            Encoding::Windows1252
        },
        true,
    )
}

/// Western text in UTF-16 without a mark: every other byte is zero.
fn by_zeros(bytes: &[u8]) -> Option<Encoding> {
    let head = bytes.get(..ZERO_SAMPLE_BYTES).unwrap_or(bytes);
    let zeros = |parity: usize| {
        let every_other = head.iter().skip(parity).step_by(2);
        every_other.filter(|b| **b == 0).count()
    };
    let (even, odd) = (zeros(0), zeros(1));
    let (most, least) = (even.max(odd), even.min(odd));
    let wide = head.len() >= 8 && most * 4 > head.len() && least * 20 < head.len();
    wide.then_some(if odd > even {
        Encoding::Utf16Le
    } else {
        Encoding::Utf16Be
    })
}

#[cfg(test)]
mod tests {
    use super::super::encoding::*;
    use proptest::prelude::*;

    fn text(bytes: &[u8]) -> (String, Option<Encoding>) {
        let decoded = decode(bytes, None, false);
        (
            String::from_utf8_lossy(&decoded.bytes).into_owned(),
            decoded.from,
        )
    }

    #[test]
    fn encodings_are_recognised() {
        let plain = "t [s],x [\u{b5}m]\n0,1\n";
        let wide: Vec<u8> = plain.encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(text(&wide), (plain.to_owned(), Some(Encoding::Utf16Le)));
        let wide: Vec<u8> = plain.encode_utf16().flat_map(u16::to_be_bytes).collect();
        let marked = [&[0xfe, 0xff][..], &wide].concat();
        assert_eq!(text(&marked), (plain.to_owned(), Some(Encoding::Utf16Be)));
        assert_eq!(text(plain.as_bytes()), (plain.to_owned(), None));
        let western = b"t [s],x [\xb5m]\n# M\xfcller\n";
        let (read, from) = text(western);
        assert_eq!(from, Some(Encoding::Windows1252));
        assert!(read.contains("[\u{b5}m]") && read.contains("M\u{fc}ller"));
        let (chinese, _, _) = encoding_rs::GBK.encode("\u{65f6}\u{95f4} [s],\u{4f4d}\u{79fb} [um]");
        let (read, from) = text(&chinese);
        assert_eq!(from, Some(Encoding::Gbk));
        assert!(read.starts_with("\u{65f6}\u{95f4}"));
        assert_eq!(Encoding::named("latin1"), Some(Encoding::Windows1252));
        assert_eq!(Encoding::named("cp1251"), Some(Encoding::Windows1251));
        assert_eq!(Encoding::named("GB2312"), Some(Encoding::Gbk));
        assert_eq!(Encoding::named("klingon"), None);
    }

    #[test]
    fn zeros_at_the_end_are_cut() {
        let decoded = decode(b"t,x\n0,1\n\0\0\0", None, false);
        assert_eq!(
            (&decoded.bytes[..], decoded.zeros_cut),
            (&b"t,x\n0,1\n"[..], 3)
        );
    }

    proptest! {
        #[test]
        fn what_is_encoded_decodes(words in "[a-z,\u{e4}\u{f6}\u{fc}\u{b5}0-9 \n]{1,60}", which in 0usize..4) {
            let encoding = [Encoding::Utf8, Encoding::Windows1252, Encoding::Utf16Le, Encoding::Utf16Be][which];
            let bytes: Vec<u8> = match encoding {
                Encoding::Utf16Le => words.encode_utf16().flat_map(u16::to_le_bytes).collect(),
                Encoding::Utf16Be => words.encode_utf16().flat_map(u16::to_be_bytes).collect(),
                other => other.decoder().encode(&words).0.into_owned(),
            };
            let decoded = decode(&bytes, Some(encoding), false);
            prop_assert_eq!(String::from_utf8(decoded.bytes.into_owned()).unwrap(), words);
        }
    }
}
