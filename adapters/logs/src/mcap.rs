//! MCAP: records with an opcode and a length, plain or within compressed chunks (mcap.dev/spec). Messages in JSON are
//! read; of others their topic and number are known.

use crate::bytes::{Bytes, u16_at, u32_at, u64_at};
use crate::{LogReader, MESSAGE_BYTES_MAX, Message, ReadErrors, TOPICS_MAX, Topic, json_fields};
use apex_model::time::Time;
use std::collections::BTreeMap;
use std::io::{self, Cursor, Read};

/// First and last bytes of the format.
pub(crate) const MAGIC: &[u8] = &[0x89, b'M', b'C', b'A', b'P', 0x30, b'\r', b'\n'];
const RECORD_HEADER: usize = 9;
/// Bytes of one chunk, packed or not.
const CHUNK_BYTES_MAX: usize = 1 << 28;

/// Reads an MCAP file.
pub(crate) struct Mcap<R> {
    bytes: Bytes<R>,
    /// The chunk that is being read, with its place in the file.
    chunk: Option<(Bytes<Cursor<Vec<u8>>>, u64)>,
    begun: bool,
    ended: bool,
    channels: BTreeMap<u16, Channel>,
    topics: Vec<Topic>,
    damages: ReadErrors,
}

struct Channel {
    topic: usize,
    is_json: bool,
}

/// A record of the file or of the chunk at hand.
enum Record {
    Some(u8, Vec<u8>, u64),
    End,
}

impl<R: Read> Mcap<R> {
    pub(crate) fn new(input: R) -> Mcap<R> {
        Mcap {
            bytes: Bytes::new(input),
            chunk: None,
            begun: false,
            ended: false,
            channels: BTreeMap::new(),
            topics: Vec::new(),
            damages: ReadErrors::default(),
        }
    }

    fn record(&mut self) -> io::Result<Record> {
        if let Some((chunk, place)) = &mut self.chunk {
            let place = *place;
            match record_of(chunk, MESSAGE_BYTES_MAX)? {
                Ok(Record::Some(code, body, _)) => return Ok(Record::Some(code, body, place)),
                Ok(Record::End) => {}
                Err(at) => self.damages.add(|| format!("byte {at} of the chunk at byte {place}: a record is cut")),
            }
            self.chunk = None;
        }
        if self.ended {
            return Ok(Record::End);
        }
        match record_of(&mut self.bytes, CHUNK_BYTES_MAX)? {
            Ok(record) => Ok(record),
            Err(at) => {
                self.ended = true;
                self.damages.add(|| format!("byte {at}: the log ends within a record, or a length is wrong"));
                Ok(Record::End)
            }
        }
    }

    fn channel(&mut self, body: &[u8], at: u64) -> Option<()> {
        let number = u16_at(body, 0)?;
        let (name, after) = string(body, 4)?;
        let (encoding, _) = string(body, after)?;
        if self.channels.contains_key(&number) {
            return Some(());
        }
        if self.topics.len() >= TOPICS_MAX {
            self.damages.add(|| format!("byte {at}: more than {TOPICS_MAX} topics"));
            return Some(());
        }
        let is_json = encoding == "json";
        if !is_json {
            self.damages.add(|| {
                format!("byte {at}: messages of `{name}` are written in `{encoding}`, of which nothing but json is read here")
            });
        }
        self.channels.insert(number, Channel { topic: self.topics.len(), is_json });
        self.topics.push(Topic { name, fields: Vec::new() });
        Some(())
    }

    fn message(&mut self, body: &[u8], at: u64, message: &mut Message) -> bool {
        let (Some(number), Some(log_time)) = (u16_at(body, 0), u64_at(body, 6)) else { return false };
        let Some(channel) = self.channels.get(&number) else {
            self.damages.add(|| format!("byte {at}: a message of a channel that was not announced"));
            return false;
        };
        message.topic = channel.topic;
        message.at = Time(i64::try_from(log_time).unwrap_or(i64::MAX));
        message.values.clear();
        if channel.is_json {
            let json = serde_json::from_slice(body.get(22..).unwrap_or_default());
            match (json, self.topics.get_mut(channel.topic)) {
                (Ok(json), Some(topic)) => json_fields::spread(&json, topic, &mut message.values),
                _ => {
                    self.damages.add(|| format!("byte {at}: a message that says it is JSON and is not"));
                    return false;
                }
            }
        }
        true
    }

    fn open_chunk(&mut self, body: &[u8], at: u64) {
        let opened = || {
            let size = usize::try_from(u64_at(body, 16)?).ok().filter(|size| *size <= CHUNK_BYTES_MAX)?;
            let (compression, after) = string(body, 28)?;
            let records = body.get(after.checked_add(8)?..)?;
            Some((size, compression, records.to_vec()))
        };
        let Some((size, compression, records)) = opened() else {
            return self.damages.add(|| format!("byte {at}: this chunk cannot be understood"));
        };
        let unpacked = match compression.as_str() {
            "" => Ok(records),
            "lz4" => limited(lz4_flex::frame::FrameDecoder::new(Cursor::new(records)), size),
            "zstd" => ruzstd::decoding::StreamingDecoder::new(Cursor::new(records))
                .map_err(|error| error.to_string())
                .and_then(|decoder| limited(decoder, size)),
            other => Err(format!("its compression `{other}` is not known")),
        };
        match unpacked {
            Ok(records) => self.chunk = Some((Bytes::new(Cursor::new(records)), at)),
            Err(reason) => self.damages.add(|| format!("byte {at}: this chunk cannot be unpacked: {reason}")),
        }
    }
}

/// What a decompressor yields, up to the size that was announced.
fn limited(decoder: impl Read, size: usize) -> Result<Vec<u8>, String> {
    let mut unpacked = Vec::new();
    decoder.take(size as u64).read_to_end(&mut unpacked).map_err(|error| error.to_string())?;
    Ok(unpacked)
}

/// The next record; the error is the place of one that is cut.
fn record_of<R: Read>(bytes: &mut Bytes<R>, longest: usize) -> io::Result<Result<Record, u64>> {
    let at = bytes.offset;
    let header = bytes.peek(RECORD_HEADER)?;
    if header.is_empty() || header.starts_with(MAGIC) {
        return Ok(Ok(Record::End));
    }
    let (Some(code), Some(length)) = (header.first().copied(), u64_at(header, 1)) else { return Ok(Err(at)) };
    let Some(length) = usize::try_from(length).ok().filter(|length| *length <= longest) else { return Ok(Err(at)) };
    bytes.skip(RECORD_HEADER);
    let body = bytes.peek(length)?.to_vec();
    if body.len() < length {
        return Ok(Err(at));
    }
    bytes.skip(length);
    Ok(Ok(Record::Some(code, body, at)))
}

/// A string with its length before it, and where the bytes after it begin.
fn string(body: &[u8], at: usize) -> Option<(String, usize)> {
    let length = usize::try_from(u32_at(body, at)?).ok()?;
    let end = at.checked_add(4)?.checked_add(length)?;
    Some((String::from_utf8_lossy(body.get(at + 4..end)?).into_owned(), end))
}

impl<R: Read> LogReader for Mcap<R> {
    fn next(&mut self, message: &mut Message) -> io::Result<bool> {
        if !self.begun {
            self.begun = true;
            if !self.bytes.peek(MAGIC.len())?.starts_with(MAGIC) {
                self.damages.add(|| "byte 0: this is not the beginning of an MCAP file".to_string());
            }
            self.bytes.skip(MAGIC.len());
        }
        loop {
            match self.record()? {
                Record::End if self.chunk.is_none() => return Ok(false),
                Record::End => {}
                Record::Some(0x04, body, at) => {
                    if self.channel(&body, at).is_none() {
                        self.damages.add(|| format!("byte {at}: this channel cannot be understood"));
                    }
                }
                Record::Some(0x05, body, at) => {
                    if self.message(&body, at, message) {
                        return Ok(true);
                    }
                }
                Record::Some(0x06, body, at) => self.open_chunk(&body, at),
                // The data section ends here; what follows is a summary of it.
                Record::Some(0x0f, ..) => self.ended = true,
                Record::Some(..) => {}
            }
        }
    }

    fn topics(&self) -> &[Topic] {
        &self.topics
    }

    fn damages(&self) -> &ReadErrors {
        &self.damages
    }
}
