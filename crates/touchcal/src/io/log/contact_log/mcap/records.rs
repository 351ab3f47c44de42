//! The records of an MCAP file, one after the other, those within chunks too.
//! <https://mcap.dev/spec>

use std::io::{BufReader, Read};
use std::path::Path;

use mcap::McapError;
use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::io::base::error::{IoError, Place};

/// Largest record (bytes): two of them are in memory at a time.
pub(super) const MAX_RECORD: usize = 48 << 20;
/// Most bytes that come out of one byte of the file, on average; images of nothing pack to less,
/// but bags are not made of them.
const MAX_RATIO: u64 = 1000;
/// Unpacked bytes from which on that holds.
const FEW: u64 = 256 << 20;
/// Bytes read at a time.
const BUFFER: usize = 1 << 18;

/// What is done with a file's records.
pub(super) trait Visit {
    /// A type of messages.
    fn schema(&mut self, id: u16, name: &str);
    /// A topic.
    fn channel(&mut self, id: u16, schema: u16, topic: &str, encoding: &str) -> Result<(), IoError>;
    /// A message, recorded at `time` (ns).
    fn message(&mut self, channel: u16, time: i64, data: &[u8]) -> Result<(), IoError>;
}

/// Shows all records of a file to `visitor`.
pub(super) fn read(content: impl Read, file: &str, visitor: &mut impl Visit) -> Result<(), IoError> {
    let mut input = BufReader::with_capacity(BUFFER, content);
    let options = LinearReaderOptions::default().with_validate_chunk_crcs(true).with_record_length_limit(MAX_RECORD);
    let mut reader = LinearReader::new_with_options(options);
    let (mut packed, mut unpacked) = (0u64, 0u64);
    while let Some(event) = reader.next_event() {
        match event.map_err(|error| damaged(file, &error))? {
            LinearReadEvent::ReadRequest(count) => {
                let failed = |source| IoError::file(Path::new(file), "read", source);
                let count = input.read(reader.insert(count)).map_err(failed)?;
                reader.notify_read(count);
                packed += count as u64;
            }
            // What follows repeats what was there.
            LinearReadEvent::Record { opcode: op::DATA_END, .. } => return Ok(()),
            LinearReadEvent::Record { opcode, data } => {
                unpacked += data.len() as u64 + RECORD_HEAD;
                if unpacked > FEW && unpacked / MAX_RATIO > packed {
                    let found = format!("{packed} bytes of which {unpacked} come when unpacked");
                    return Err(IoError::unexpected(Place::file(file), "a whole MCAP file", found));
                }
                show(opcode, data, file, visitor)?;
            }
        }
    }
    Ok(())
}

/// What is said of a record that does not hold what it should.
const DAMAGED: &str = "a record that is damaged";
/// Bytes of a record before its content.
const RECORD_HEAD: u64 = 9;

/// Not by the mcap crate, which sets aside as much memory as a record says that its text takes.
fn show(opcode: u8, data: &[u8], file: &str, visitor: &mut impl Visit) -> Result<(), IoError> {
    let cut = || IoError::unexpected(Place::file(file), "a whole MCAP file", DAMAGED);
    let mut fields = Fields(data);
    match opcode {
        op::SCHEMA => {
            let (id, name) = fields.u16().zip(fields.text()).ok_or_else(cut)?;
            visitor.schema(id, name);
        }
        op::CHANNEL => {
            let (id, schema) = fields.u16().zip(fields.u16()).ok_or_else(cut)?;
            let (topic, encoding) = fields.text().zip(fields.text()).ok_or_else(cut)?;
            visitor.channel(id, schema, topic, encoding)?;
        }
        op::MESSAGE => {
            let (channel, _sequence) = fields.u16().zip(fields.array::<4>()).ok_or_else(cut)?;
            let (recorded, _published) = fields.array().zip(fields.array::<8>()).ok_or_else(cut)?;
            visitor.message(channel, i64::from_le_bytes(recorded), fields.0)?;
        }
        _ => {}
    }
    Ok(())
}

/// Fields of a record, from its beginning.
struct Fields<'b>(&'b [u8]);

impl<'b> Fields<'b> {
    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (array, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*array)
    }

    fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    fn text(&mut self) -> Option<&'b str> {
        let length = self.array().map(u32::from_le_bytes)?;
        let (text, rest) = self.0.split_at_checked(length as usize)?;
        self.0 = rest;
        std::str::from_utf8(text).ok()
    }
}

fn damaged(file: &str, error: &McapError) -> IoError {
    let found = match error {
        McapError::UnexpectedEof => "one that is cut off (`mcap recover` keeps what is there)".to_owned(),
        McapError::BadMagic => "another beginning".to_owned(),
        McapError::RecordTooLarge { len, .. } => format!("a record of {len} bytes, more than {MAX_RECORD}"),
        McapError::BadChunkCrc { .. } => "a chunk whose checksum is another".to_owned(),
        // binrw's own words are many lines.
        McapError::Parse(_) => DAMAGED.to_owned(),
        other => other.to_string(),
    };
    IoError::unexpected(Place::file(file), "a whole MCAP file", found)
}
