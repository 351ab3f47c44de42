//! The records of an MCAP file, one after the other, those within chunks too. <https://mcap.dev/spec>

use std::io::{BufReader, Read};
use std::path::Path;

use mcap::McapError;
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::io::error::{IoError, Place};

/// Largest record (bytes): two of them are in memory at a time.
pub(super) const MAX_RECORD: usize = 48 << 20;
/// Most bytes that come out of one byte of the file, on average; images of nothing pack to less, but bags are not made of them.
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

/// Bytes of a record before its content.
const RECORD_HEAD: u64 = 9;

fn show(opcode: u8, data: &[u8], file: &str, visitor: &mut impl Visit) -> Result<(), IoError> {
    if !matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
        return Ok(());
    }
    match mcap::parse_record(opcode, data).map_err(|error| damaged(file, &error))? {
        Record::Schema { header, .. } => visitor.schema(header.id, &header.name),
        Record::Channel(channel) => {
            visitor.channel(channel.id, channel.schema_id, &channel.topic, &channel.message_encoding)?;
        }
        Record::Message { header, data } => {
            visitor.message(header.channel_id, header.log_time.cast_signed(), &data)?;
        }
        _ => {}
    }
    Ok(())
}

fn damaged(file: &str, error: &McapError) -> IoError {
    let found = match error {
        McapError::UnexpectedEof => "one that is cut off (`mcap recover` keeps what is there)".to_owned(),
        McapError::BadMagic => "another beginning".to_owned(),
        McapError::RecordTooLarge { len, .. } => format!("a record of {len} bytes, more than {MAX_RECORD}"),
        McapError::BadChunkCrc { .. } => "a chunk whose checksum is another".to_owned(),
        // binrw's own words are many lines.
        McapError::Parse(_) => "a record that is damaged".to_owned(),
        other => other.to_string(),
    };
    IoError::unexpected(Place::file(file), "a whole MCAP file", found)
}
