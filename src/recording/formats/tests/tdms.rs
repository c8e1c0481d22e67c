//! TDMS files as npTDMS writes them, and segments made by hand after NI's description.

use super::helpers::{
    INTERVAL, clock, names, notes_say, refusal, table, tables, test_file, times, unit, v, values,
    xp,
};

#[test]
fn segments_groups_and_clocks() {
    let read = tables(test_file!("tdms/segments.tdms"));
    assert_eq!(read.len(), 2);
    let run = &read[0];
    assert_eq!(run.name, "run 'a'");
    assert_eq!((values(run, "V"), values(run, "xp")), (v(), xp()));
    assert_eq!((unit(run, "V"), unit(run, "xp")), (Some("V"), Some("um")));
    assert_eq!(run.clock, clock(0.1, INTERVAL));
    assert!(notes_say(run, &["log/note (text)"]));
    // One channel in its group: its name says so.
    assert_eq!(names(&read[1]), ["T"]);
    assert_eq!(read[1].clock, clock(0.0, 0.001));
}

#[test]
fn scales_are_applied_or_said() {
    let read = tables(test_file!("tdms/scaled.tdms"));
    let run = &read[0];
    // 1 + 2 s + s^2 / 8 with s = 0.5 raw + 0.25, raw = 2 xp.
    let scaled: Vec<f64> = xp()
        .iter()
        .map(|x| x + 0.25)
        .map(|s| 1.0 + 2.0 * s + 0.125 * s * s)
        .collect();
    assert_eq!(values(run, "xp"), scaled);
    assert_eq!(unit(run, "xp"), Some("um"));
    assert!(notes_say(run, &["[0.25, 0.5], then [1, 2, 0.125]"]));
    assert_eq!(values(run, "bridge"), times(&xp(), 2.0));
    assert_eq!(unit(run, "bridge"), None);
    assert!(notes_say(run, &["bridge", "Strain", "raw"]));
    let when = read.iter().find(|t| names(t) == ["when"]).unwrap();
    assert!((values(when, "when")[7] - 0.007).abs() < 1e-9);
}

/// Bytes of a segment: numbers in either order, table of contents and offsets in front.
struct Segment {
    is_big: bool,
    meta: Vec<u8>,
}

impl Segment {
    fn u32(&mut self, value: u32) {
        self.meta.extend(if self.is_big {
            value.to_be_bytes()
        } else {
            value.to_le_bytes()
        });
    }

    fn u64(&mut self, value: u64) {
        self.meta.extend(if self.is_big {
            value.to_be_bytes()
        } else {
            value.to_le_bytes()
        });
    }

    fn text(&mut self, text: &str) {
        self.u32(text.len() as u32);
        self.meta.extend(text.as_bytes());
    }

    /// Two channels of i16, `count` samples in a chunk.
    fn of_two(is_big: bool, count: u64) -> Self {
        let mut segment = Self {
            is_big,
            meta: Vec::new(),
        };
        segment.u32(2);
        for name in ["/'g'/'a'", "/'g'/'b'"] {
            segment.text(name);
            segment.u32(20);
            segment.u32(2);
            segment.u32(1);
            segment.u64(count);
            segment.u32(0);
        }
        segment
    }

    fn with(self, flags: u32, next: Option<u64>, data: &[i16]) -> Vec<u8> {
        let mut lead = Self {
            is_big: self.is_big,
            meta: b"TDSm".to_vec(),
        };
        let flags = flags | if self.is_big { 1 << 6 } else { 0 };
        lead.meta.extend(flags.to_le_bytes());
        lead.u32(4713);
        let raw = self.meta.len() as u64;
        lead.u64(next.unwrap_or(raw + 2 * data.len() as u64));
        lead.u64(raw);
        let mut bytes = lead.meta;
        bytes.extend(self.meta);
        for value in data {
            bytes.extend(if self.is_big {
                value.to_be_bytes()
            } else {
                value.to_le_bytes()
            });
        }
        bytes
    }
}

/// New list of objects, metadata, raw data.
const FLAGS: u32 = 0b1110;
const INTERLEAVED: u32 = 1 << 5;

#[test]
fn byte_orders_interleaving_and_chunks() {
    let data = [1, 2, 3, 4, 5, 6, 7, 8];
    for is_big in [false, true] {
        let read = table((
            "a.tdms",
            &Segment::of_two(is_big, 2).with(FLAGS, None, &data),
        ));
        assert_eq!(values(&read, "a"), [1.0, 2.0, 5.0, 6.0]);
        assert_eq!(values(&read, "b"), [3.0, 4.0, 7.0, 8.0]);
        let bytes = Segment::of_two(is_big, 4).with(FLAGS | INTERLEAVED, None, &data);
        let read = table(("a.tdms", &bytes));
        assert_eq!(values(&read, "a"), [1.0, 3.0, 5.0, 7.0]);
        assert_eq!(values(&read, "b"), [2.0, 4.0, 6.0, 8.0]);
    }
}

#[test]
fn a_second_segment_without_metadata_goes_on() {
    let mut bytes = Segment::of_two(false, 1).with(FLAGS, None, &[1, 2]);
    let none = Segment {
        is_big: false,
        meta: Vec::new(),
    };
    bytes.extend(none.with(1 << 3, None, &[3, 4]));
    let read = table(("a.tdms", &bytes));
    assert_eq!(values(&read, "a"), [1.0, 3.0]);
    assert_eq!(values(&read, "b"), [2.0, 4.0]);
}

#[test]
fn files_that_were_not_closed_or_cut() {
    let bytes = Segment::of_two(false, 3).with(FLAGS, Some(u64::MAX), &[1, 2, 3, 4, 5]);
    // Without a clock, channels of different lengths are tables of their own.
    let read = tables(("a.tdms", &bytes));
    assert_eq!(values(&read[0], "a"), [1.0, 2.0, 3.0]);
    assert_eq!(values(&read[1], "b"), [4.0, 5.0]);
    assert!(notes_say(&read[1], &["not closed"]));
    let bytes = Segment::of_two(false, 1).with(FLAGS, Some(1 << 40), &[1, 2]);
    assert!(notes_say(&table(("a.tdms", &bytes)), &["cut off"]));
}

#[test]
fn daqmx_and_promises_are_refused() {
    let bytes = Segment::of_two(false, 1).with(FLAGS | 1 << 7, None, &[1, 2]);
    let refused = refusal(("a.tdms", &bytes));
    assert!(
        refused.contains("DAQmx") && refused.contains("CSV"),
        "{refused}"
    );
    // Samples that are not there are not allocated.
    let bytes = Segment::of_two(false, u64::MAX / 4).with(FLAGS, None, &[1, 2]);
    assert_eq!(values(&table(("a.tdms", &bytes)), "a"), [1.0, 2.0]);
    assert!(refusal(("a.tdms_index", b"TDSh\0\0\0\0")).contains(".tdms file"));
}
