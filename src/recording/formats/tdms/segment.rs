//! Segments one after the other: lead-in, metadata, raw data in chunks.

use std::collections::HashMap;

use super::super::bytes::{ByteOrder, Cursor};
use super::super::error::{FileContext, FormatError};
use super::channel::Channel;
use super::metadata::{Object, Properties, RawIndex, Stored, path_parts, read_object};

/// Bytes of a lead-in.
const LEAD_IN_BYTES: usize = 28;
/// Most objects in a file; each new segment goes through those it holds.
const MAX_OBJECTS: usize = 20_000;

/// Bits of a segment's table of contents.
mod contents {
    pub const METADATA: u32 = 1 << 1;
    pub const NEW_OBJECT_LIST: u32 = 1 << 2;
    pub const RAW_DATA: u32 = 1 << 3;
    pub const INTERLEAVED: u32 = 1 << 5;
    pub const BIG_ENDIAN: u32 = 1 << 6;
    pub const DAQMX: u32 = 1 << 7;
}

/// All of a file.
#[derive(Debug, Default)]
pub(super) struct Found {
    pub channels: Vec<Channel>,
    /// Properties of the file and of groups, by path as in the file.
    pub properties: HashMap<String, Properties>,
    pub notes: Vec<String>,
}

/// Reads all segments.
///
/// # Errors
/// [`FormatError`] where a segment is not valid, or holds raw data of DAQmx.
pub(super) fn read_segments(context: &FileContext, bytes: &[u8]) -> Result<Found, FormatError> {
    let mut reader = Reader {
        context,
        bytes,
        found: Found::default(),
        index_of: HashMap::new(),
        active: Vec::new(),
    };
    let mut at = 0;
    while bytes.len().saturating_sub(at) >= LEAD_IN_BYTES {
        at = reader.segment(at)?;
    }
    if at < bytes.len() {
        reader.found.notes.push(format!(
            "The file ends in the middle of a segment; its last {} bytes were left out.",
            bytes.len() - at
        ));
    }
    Ok(reader.found)
}

struct Reader<'a> {
    context: &'a FileContext<'a>,
    bytes: &'a [u8],
    found: Found,
    /// Index of a channel by its path as in the file.
    index_of: HashMap<String, usize>,
    /// Channels with data in the segment, in their order.
    active: Vec<usize>,
}

/// A channel's samples in one chunk.
#[derive(Clone, Copy)]
struct Slot {
    channel: usize,
    stored: Stored,
    count: usize,
    bytes: usize,
}

impl Reader<'_> {
    /// Reads the segment at `at`; returns where the next begins.
    fn segment(&mut self, at: usize) -> Result<usize, FormatError> {
        let bytes = self.bytes;
        let context = *self.context;
        let bad = |what: &str| context.malformed(at, format!("{what} of a segment"));
        let lead = bytes
            .get(at..at + LEAD_IN_BYTES)
            .ok_or_else(|| bad("the lead-in"))?;
        if !lead.starts_with(b"TDSm") {
            return Err(bad("the lead-in"));
        }
        let mut cursor = Cursor::new(lead, ByteOrder::Little);
        cursor.seek(4);
        let flags = cursor.u32().ok_or_else(|| bad("the lead-in"))?;
        let order = if flags & contents::BIG_ENDIAN == 0 {
            ByteOrder::Little
        } else {
            ByteOrder::Big
        };
        let mut cursor = Cursor::new(lead, order);
        cursor.seek(12);
        let (next, raw) = cursor
            .u64()
            .zip(cursor.u64())
            .ok_or_else(|| bad("the lead-in"))?;
        let body = at + LEAD_IN_BYTES;
        let offset = |offset: u64| usize::try_from(offset).ok()?.checked_add(body);
        let end = if next == u64::MAX {
            self.found
                .notes
                .push("The file was not closed properly; what was written was read.".to_owned());
            bytes.len()
        } else {
            let end = offset(next).ok_or_else(|| bad("the length"))?;
            if end > bytes.len() {
                self.found.notes.push(format!(
                    "The file was cut off: its last segment should end at byte {end}, the file ends at {}.",
                    bytes.len()
                ));
            }
            end.min(bytes.len())
        };
        let data = offset(raw).ok_or_else(|| bad("the offset of the data"))?;
        if flags & contents::METADATA != 0 {
            let meta = bytes.get(body..data.min(bytes.len())).unwrap_or_default();
            self.metadata(meta, body, order, flags & contents::NEW_OBJECT_LIST != 0)?;
        }
        if flags & contents::RAW_DATA != 0 {
            if flags & contents::DAQMX != 0 {
                return Err(self.daqmx());
            }
            let raw = bytes.get(data..end).unwrap_or_default();
            self.raw_data(raw, data, order, flags & contents::INTERLEAVED != 0)?;
        }
        Ok(end)
    }

    fn daqmx(&self) -> FormatError {
        self.context.unsupported(
            "its samples are raw data of DAQmx, which only its own scales make volts",
            "save it as an ordinary TDMS file (in LabVIEW: read with \"TDMS Read\", write with \"TDMS Write\"), or export it as CSV or Excel",
        )
    }

    /// Updates the channels from a segment's metadata.
    fn metadata(
        &mut self,
        meta: &[u8],
        at: usize,
        order: ByteOrder,
        is_new_list: bool,
    ) -> Result<(), FormatError> {
        let mut cursor = Cursor::new(meta, order);
        let context = *self.context;
        let short =
            |cursor: &Cursor| context.malformed(at + cursor.at(), "the metadata of a segment");
        if is_new_list {
            self.active.clear();
        }
        let count = cursor.u32().ok_or_else(|| short(&cursor))?;
        let mut is_active = vec![false; self.found.channels.len()];
        for channel in &self.active {
            if let Some(active) = is_active.get_mut(*channel) {
                *active = true;
            }
        }
        for _ in 0..count {
            let object = read_object(&mut cursor, order).ok_or_else(|| short(&cursor))?;
            match object.index {
                RawIndex::Daqmx => return Err(self.daqmx()),
                RawIndex::Unknown(code) => {
                    return Err(self.context.unsupported(
                        format!(
                            "\"{}\" has numbers of an unknown type (0x{code:x})",
                            object.path
                        ),
                        "save the channel as double precision numbers",
                    ));
                }
                _ => self.object(object, &mut is_active)?,
            }
        }
        Ok(())
    }

    /// Updates one object.
    fn object(&mut self, object: Object, is_active: &mut Vec<bool>) -> Result<(), FormatError> {
        let parts = path_parts(&object.path);
        if parts.len() < 2 {
            let properties = self.found.properties.entry(object.path).or_default();
            properties.extend(object.properties);
            return Ok(());
        }
        let next = self.found.channels.len();
        let index = *self.index_of.entry(object.path).or_insert(next);
        if index == next {
            if next >= MAX_OBJECTS {
                return Err(self.context.unsupported(
                    format!("it has more than {MAX_OBJECTS} channels"),
                    "save the channels of the recording alone",
                ));
            }
            self.found.channels.push(Channel::new(parts));
            is_active.push(false);
        }
        let Some(channel) = self.found.channels.get_mut(index) else {
            return Ok(());
        };
        channel.properties.extend(object.properties);
        if let RawIndex::Data { .. } = object.index {
            channel.index = object.index;
        }
        let has_data = object.index != RawIndex::None
            && matches!(channel.index, RawIndex::Data { bytes, .. } if bytes > 0);
        let was = is_active
            .get_mut(index)
            .map(|was| std::mem::replace(was, has_data));
        match (was, has_data) {
            (Some(false), true) => self.active.push(index),
            (Some(true), false) => self.active.retain(|active| *active != index),
            _ => {}
        }
        Ok(())
    }

    /// Adds the samples of a segment.
    fn raw_data(
        &mut self,
        raw: &[u8],
        at: usize,
        order: ByteOrder,
        is_interleaved: bool,
    ) -> Result<(), FormatError> {
        let slots: Vec<Slot> = self
            .active
            .iter()
            .filter_map(|channel| match self.found.channels.get(*channel)?.index {
                RawIndex::Data {
                    stored,
                    count,
                    bytes,
                } => Some(Slot {
                    channel: *channel,
                    stored,
                    count,
                    bytes,
                }),
                _ => None,
            })
            .collect();
        if slots.is_empty() || raw.is_empty() {
            return Ok(());
        }
        let left_out = if is_interleaved {
            self.interleaved(raw, at, order, &slots)?
        } else {
            self.contiguous(raw, order, &slots)
        };
        if left_out > 0 {
            self.found.notes.push(format!(
                "A segment ends within a block of samples; {left_out} bytes are no whole sample and were left out."
            ));
        }
        Ok(())
    }

    /// Sample after sample, each of all channels; returns the bytes left over.
    fn interleaved(
        &mut self,
        raw: &[u8],
        at: usize,
        order: ByteOrder,
        slots: &[Slot],
    ) -> Result<usize, FormatError> {
        let sizes: Option<Vec<usize>> = slots.iter().map(|slot| slot.stored.size()).collect();
        let sizes = sizes.ok_or_else(|| {
            self.context
                .malformed(at, "the interleaved data of a segment with text")
        })?;
        let row: usize = sizes.iter().sum();
        let rows = raw.len() / row.max(1);
        let mut offset = 0;
        for (slot, size) in slots.iter().zip(sizes) {
            if let Some(channel) = self.found.channels.get_mut(slot.channel) {
                channel.add(raw, slot.stored, order, (offset, row, rows));
            }
            offset += size;
        }
        Ok(raw.len() - rows * row)
    }

    /// Chunk after chunk, each with all samples of one channel, then of the next; the last chunk may
    /// be cut. Returns the bytes left over.
    fn contiguous(&mut self, raw: &[u8], order: ByteOrder, slots: &[Slot]) -> usize {
        let mut rest = raw;
        while !rest.is_empty() {
            for slot in slots {
                let (bytes, after) = rest.split_at(slot.bytes.min(rest.len()));
                rest = after;
                let Some(size) = slot.stored.size() else {
                    continue;
                };
                let count = slot.count.min(bytes.len() / size);
                if let Some(channel) = self.found.channels.get_mut(slot.channel) {
                    channel.add(bytes, slot.stored, order, (0, size, count));
                }
                if count < slot.count {
                    return bytes.len() - count * size;
                }
            }
        }
        0
    }
}
