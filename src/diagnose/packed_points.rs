//! Points of a long curve in a file, exact to the last bit and small.
//!
//! Times of an even clock differ by nearly the same in their bits: second differences of these
//! are small. Bytes of the same place in all numbers stand together, so that a compressor finds
//! them alike.

use std::fmt;

use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserializer, Serializer};

/// Bytes of a number.
const NUMBER_BYTES: usize = size_of::<u64>();
/// Bytes of a point.
const POINT_BYTES: usize = 2 * NUMBER_BYTES;

/// Writes points as bytes.
///
/// # Errors
/// Those of the writer.
pub(super) fn serialize<S: Serializer>(points: &[[f64; 2]], writer: S) -> Result<S::Ok, S::Error> {
    writer.serialize_bytes(&packed(points))
}

/// Reads points.
///
/// # Errors
/// Those of the reader, and bytes that are no whole number of points.
pub(super) fn deserialize<'de, D: Deserializer<'de>>(reader: D) -> Result<Vec<[f64; 2]>, D::Error> {
    reader.deserialize_byte_buf(Bytes)
}

struct Bytes;

impl<'de> Visitor<'de> for Bytes {
    type Value = Vec<[f64; 2]>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the bytes of points")
    }

    fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<Self::Value, E> {
        unpacked(bytes).ok_or_else(|| E::custom("a curve is cut off"))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Self::Value, A::Error> {
        // A text format has bytes as a list of numbers.
        let mut bytes = Vec::new();
        while let Some(byte) = items.next_element()? {
            bytes.push(byte);
        }
        self.visit_bytes(&bytes)
    }
}

fn packed(points: &[[f64; 2]]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(POINT_BYTES * points.len());
    let (mut last, mut step) = (0u64, 0u64);
    let times: Vec<u64> = points
        .iter()
        .map(|[time, _]| {
            let bits = time.to_bits();
            let new_step = bits.wrapping_sub(last);
            let change = new_step.wrapping_sub(step);
            (last, step) = (bits, new_step);
            // Small changes of either sign become small numbers.
            (change << 1) ^ ((change.cast_signed() >> 63).cast_unsigned())
        })
        .collect();
    let values: Vec<u64> = points.iter().map(|[_, value]| value.to_bits()).collect();
    for numbers in [times, values] {
        for place in 0..NUMBER_BYTES {
            bytes.extend(numbers.iter().map(|n| n.to_le_bytes()[place]));
        }
    }
    bytes
}

fn unpacked(bytes: &[u8]) -> Option<Vec<[f64; 2]>> {
    if !bytes.len().is_multiple_of(POINT_BYTES) {
        return None;
    }
    let count = bytes.len() / POINT_BYTES;
    let (times, values) = bytes.split_at(count * NUMBER_BYTES);
    let number = |bytes: &[u8], i: usize| {
        let bytes: [u8; NUMBER_BYTES] = std::array::from_fn(|place| bytes[place * count + i]);
        u64::from_le_bytes(bytes)
    };
    let (mut last, mut step) = (0u64, 0u64);
    let points = (0..count).map(|i| {
        let folded = number(times, i);
        let change = (folded >> 1) ^ (folded & 1).wrapping_neg();
        step = step.wrapping_add(change);
        last = last.wrapping_add(step);
        [f64::from_bits(last), f64::from_bits(number(values, i))]
    });
    Some(points.collect())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::packed_points::*;

    proptest! {
        #[test]
        fn points_come_back_to_the_last_bit(
            points in prop::collection::vec((any::<u64>(), any::<u64>()), 0..200),
        ) {
            let points: Vec<[f64; 2]> = points
                .into_iter()
                .map(|(t, v)| [f64::from_bits(t), f64::from_bits(v)])
                .collect();
            let bits = |points: &[[f64; 2]]| -> Vec<[u64; 2]> {
                points.iter().map(|p| p.map(f64::to_bits)).collect()
            };
            let back = unpacked(&packed(&points)).unwrap();
            prop_assert_eq!(bits(&back), bits(&points));
        }
    }

    #[test]
    fn times_of_an_even_clock_are_mostly_zero_bytes() {
        let points: Vec<[f64; 2]> = (0..4000).map(|i| [2e-5 * f64::from(i), 1e-8]).collect();
        let bytes = packed(&points);
        let zeros = bytes[..NUMBER_BYTES * points.len()]
            .iter()
            .filter(|b| **b == 0)
            .count();
        assert!(zeros > 3 * NUMBER_BYTES * points.len() / 4, "{zeros}");
        assert_eq!(unpacked(&bytes[1..]), None);
    }
}
