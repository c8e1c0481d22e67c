//! LZF, the compression that h5py has beside gzip: filter 32000.
//!
//! Format: liblzf by M. Lehmann, `lzf_d.c`.

/// Identifier of the filter in HDF5 files.
pub(super) const LZF: u16 = 32_000;

/// Unpacks a chunk; `None` if a reference points before its start or the bytes end too early. A byte
/// unpacks to fewer than 90.
pub(super) fn unpack(packed: &[u8]) -> Option<Vec<u8>> {
    let mut out: Vec<u8> = Vec::with_capacity(packed.len().saturating_mul(2));
    let mut bytes = packed.iter().copied();
    while let Some(control) = bytes.next() {
        let control = usize::from(control);
        if control < 32 {
            // So many bytes as they are, and one more.
            let before = out.len();
            out.extend(bytes.by_ref().take(control + 1));
            if out.len() - before != control + 1 {
                return None;
            }
            continue;
        }
        let mut length = control >> 5;
        if length == 7 {
            length += usize::from(bytes.next()?);
        }
        let distance = ((control & 0x1f) << 8) + usize::from(bytes.next()?) + 1;
        let start = out.len().checked_sub(distance)?;
        // Byte by byte: the source may reach into what is written.
        for at in start..start + length + 2 {
            out.push(*out.get(at)?);
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literals_and_overlapping_references() {
        // "abc", then 9 bytes from 3 before: length 7 - 7 + 0 + 9.
        let packed = [2, b'a', b'b', b'c', 7 << 5, 0, 2];
        assert_eq!(unpack(&packed).as_deref(), Some(&b"abcabcabcabc"[..]));
        assert_eq!(unpack(&[3, b'a']), None);
        assert_eq!(unpack(&[0, b'a', 1 << 5, 1]), None);
        assert_eq!(unpack(&[0, b'a', 1 << 5]), None);
    }
}
