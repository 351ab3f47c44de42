//! The records of an MCAP file, one after the other, those within chunks too. <https://mcap.dev/spec>

use std::io::{BufReader, ErrorKind, Read};

use flate2::Crc;
use lz4_flex::frame::FrameDecoder;
use ruzstd::decoding::StreamingDecoder;

use crate::io::error::{IoError, Place};

/// Largest record that is looked into: schema, channel or message (bytes).
pub(super) const MAX_RECORD: u64 = 1 << 20;
/// Most bytes of all chunks, unpacked.
pub(super) const MAX_UNPACKED: u64 = 64 << 30;
/// Bytes read at a time.
const BUFFER: usize = 1 << 18;

const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";
const FOOTER: u8 = 0x02;
const SCHEMA: u8 = 0x03;
const CHANNEL: u8 = 0x04;
const MESSAGE: u8 = 0x05;
const CHUNK: u8 = 0x06;
const DATA_END: u8 = 0x0f;
/// Bytes of a message before its data.
const MESSAGE_HEAD: u64 = 22;

/// What is done with a file's records.
pub(super) trait Visit {
    /// A type of messages.
    fn schema(&mut self, id: u16, name: &[u8]);
    /// A topic.
    fn channel(&mut self, id: u16, schema: u16, topic: &[u8], encoding: &[u8]) -> Result<(), IoError>;
    /// Whether messages of a channel are to be read.
    fn wants(&self, channel: u16) -> bool;
    /// A message, recorded at `time` (ns).
    fn message(&mut self, channel: u16, time: i64, data: &[u8]) -> Result<(), IoError>;
}

/// Shows all records of a file to `visitor`. No more of them is in memory than one record and what unpacking takes.
pub(super) fn read(content: impl Read, file: &str, visitor: &mut impl Visit) -> Result<(), IoError> {
    let mut input = BufReader::with_capacity(BUFFER, content);
    let mut walk = Walk { visitor, buffer: Vec::new(), unpacked: 0 };
    let done = walk.file(&mut input);
    done.map_err(|error| match error {
        Stop::Io(error) => error,
        Stop::Damaged(what) => IoError::unexpected(Place::file(file), "a whole MCAP file", what),
        Stop::Read(source) if source.kind() == ErrorKind::UnexpectedEof => {
            let found = "one that is cut off (`mcap recover` keeps what is there)";
            IoError::unexpected(Place::file(file), "a whole MCAP file", found)
        }
        Stop::Read(source) => {
            IoError::unexpected(Place::file(file), "a whole MCAP file", format!("damaged data ({source})"))
        }
    })
}

/// Why no more records are read.
enum Stop {
    Io(IoError),
    Damaged(String),
    Read(std::io::Error),
}

impl From<std::io::Error> for Stop {
    fn from(source: std::io::Error) -> Self {
        Stop::Read(source)
    }
}

struct Walk<'v, V> {
    visitor: &'v mut V,
    buffer: Vec<u8>,
    unpacked: u64,
}

impl<V: Visit> Walk<'_, V> {
    fn file(&mut self, input: &mut dyn Read) -> Result<(), Stop> {
        if array(input)? != MAGIC {
            return Err(Stop::Damaged("another beginning".to_owned()));
        }
        loop {
            let [kind] = array(input)?;
            let length = u64::from_le_bytes(array(input)?);
            match kind {
                CHUNK => self.chunk(input, length)?,
                // What follows repeats what was there.
                DATA_END | FOOTER => return Ok(()),
                _ => self.record(input, kind, length)?,
            }
        }
    }

    fn record(&mut self, input: &mut dyn Read, kind: u8, length: u64) -> Result<(), Stop> {
        match kind {
            SCHEMA => {
                let mut fields = body(&mut self.buffer, input, length)?;
                self.visitor.schema(fields.u16()?, fields.text()?);
            }
            CHANNEL => {
                let mut fields = body(&mut self.buffer, input, length)?;
                let (id, schema, topic, encoding) = (fields.u16()?, fields.u16()?, fields.text()?, fields.text()?);
                self.visitor.channel(id, schema, topic, encoding).map_err(Stop::Io)?;
            }
            MESSAGE => {
                let Some(rest) = length.checked_sub(MESSAGE_HEAD) else {
                    return Err(Stop::Damaged(format!("a message of {length} bytes")));
                };
                let head: [u8; MESSAGE_HEAD as usize] = array(input)?;
                let mut fields = Fields(&head);
                let (channel, _sequence, time) = (fields.u16()?, fields.u32()?, fields.u64()?);
                if !self.visitor.wants(channel) {
                    return skip(input, rest);
                }
                let Fields(data) = body(&mut self.buffer, input, rest)?;
                self.visitor.message(channel, time.cast_signed(), data).map_err(Stop::Io)?;
            }
            _ => skip(input, length)?,
        }
        Ok(())
    }

    fn chunk(&mut self, input: &mut dyn Read, length: u64) -> Result<(), Stop> {
        let mut chunk = input.take(length);
        let _times: [u8; 16] = array(&mut chunk)?;
        let size = u64::from_le_bytes(array(&mut chunk)?);
        let crc = u32::from_le_bytes(array(&mut chunk)?);
        let name_length = u64::from(u32::from_le_bytes(array(&mut chunk)?));
        let mut compression = Vec::new();
        chunk.by_ref().take(name_length.min(16)).read_to_end(&mut compression)?;
        let packed_length = u64::from_le_bytes(array(&mut chunk)?);
        self.unpacked = self.unpacked.saturating_add(size);
        if self.unpacked > MAX_UNPACKED {
            return Err(Stop::Damaged(format!("more than {MAX_UNPACKED} bytes, unpacked")));
        }
        let packed = chunk.by_ref().take(packed_length);
        match compression.as_slice() {
            b"" => self.records(packed, size, crc)?,
            b"lz4" => self.records(FrameDecoder::new(packed), size, crc)?,
            b"zstd" => {
                let unpacking = StreamingDecoder::new(packed);
                let unpacking = unpacking.map_err(|error| Stop::Damaged(format!("damaged data ({error})")))?;
                self.records(BufReader::new(unpacking), size, crc)?;
            }
            other => {
                let found = format!("a chunk packed by {:?}, not by zstd or lz4", String::from_utf8_lossy(other));
                return Err(Stop::Damaged(found));
            }
        }
        let rest = chunk.limit();
        skip(&mut chunk, rest)
    }

    /// The records of a chunk, `size` bytes.
    fn records(&mut self, unpacked: impl Read, size: u64, expected: u32) -> Result<(), Stop> {
        let mut input = Checked { input: unpacked.take(size), crc: Crc::new() };
        while input.input.limit() > 0 {
            let [kind] = array(&mut input)?;
            let length = u64::from_le_bytes(array(&mut input)?);
            self.record(&mut input, kind, length)?;
        }
        match input.crc.sum() {
            sum if expected != 0 && sum != expected => {
                Err(Stop::Damaged("a chunk whose checksum is another".to_owned()))
            }
            _ => Ok(()),
        }
    }
}

/// The next `length` bytes. Memory grows with what is there, not with what is said.
fn body<'b>(buffer: &'b mut Vec<u8>, input: &mut dyn Read, length: u64) -> Result<Fields<'b>, Stop> {
    if length > MAX_RECORD {
        return Err(Stop::Damaged(format!("a record of {length} bytes, more than {MAX_RECORD}")));
    }
    buffer.clear();
    let read = input.take(length).read_to_end(buffer)?;
    if (read as u64) < length { Err(cut_off().into()) } else { Ok(Fields(buffer)) }
}

fn cut_off() -> std::io::Error {
    ErrorKind::UnexpectedEof.into()
}

fn array<const N: usize>(input: &mut dyn Read) -> Result<[u8; N], Stop> {
    let mut array = [0; N];
    input.read_exact(&mut array)?;
    Ok(array)
}

fn skip(input: &mut dyn Read, length: u64) -> Result<(), Stop> {
    let skipped = std::io::copy(&mut input.take(length), &mut std::io::sink())?;
    if skipped < length { Err(cut_off().into()) } else { Ok(()) }
}

/// Adds up the checksum of what is read.
struct Checked<R> {
    input: std::io::Take<R>,
    crc: Crc,
}

impl<R: Read> Read for Checked<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.input.read(buffer)?;
        self.crc.update(&buffer[..count]);
        Ok(count)
    }
}

/// Fields of a record, from its beginning.
struct Fields<'b>(&'b [u8]);

impl<'b> Fields<'b> {
    fn take(&mut self, length: usize) -> Result<&'b [u8], Stop> {
        let (taken, rest) =
            self.0.split_at_checked(length).ok_or_else(|| Stop::Damaged("a record cut off".to_owned()))?;
        self.0 = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Stop> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    fn u16(&mut self) -> Result<u16, Stop> {
        Ok(u16::from_le_bytes(self.array()?))
    }

    fn u32(&mut self) -> Result<u32, Stop> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    fn u64(&mut self) -> Result<u64, Stop> {
        Ok(u64::from_le_bytes(self.array()?))
    }

    fn text(&mut self) -> Result<&'b [u8], Stop> {
        let length = self.u32()? as usize;
        self.take(length)
    }
}
