//! MCAP (mcap.dev/spec): records, either plain or within compressed chunks. The crate `mcap` splits and parses records. Chunks are
//! unpacked here, so that a damaged chunk costs only its messages. Messages in JSON, in CDR (ROS 2) and in protobuf are read; of messages
//! in other encodings only topic and number are known.

use crate::nested::{self, Nested};
use crate::ros_schema::Schema;
use crate::{LogReader, MESSAGE_BYTES_MAX, Message, ReadErrors, TOPICS_MAX, Topic, cdr, protobuf};
use apex_model::time::Time;
use mcap::records::{self, ChunkHeader, Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::BTreeMap;
use std::io::{self, Cursor, Read};

/// First and last bytes of the format.
pub(crate) const MAGIC: &[u8] = mcap::MAGIC;
/// Maximum bytes of one chunk, compressed or unpacked.
const CHUNK_BYTES_MAX: usize = 1 << 28;
/// Bytes of a record before its content: opcode and length.
const RECORD_HEADER: u64 = 9;
/// Bytes that are read at once.
const BLOCK: usize = 1 << 16;

/// Reads an MCAP file.
pub(crate) struct Mcap<R> {
    file: Records<R>,
    /// The chunk that is being read, with its offset in the file.
    chunk: Option<(Records<Cursor<Vec<u8>>>, u64)>,
    begun: bool,
    ended: bool,
    schemas: BTreeMap<u16, SchemaText>,
    channels: BTreeMap<u16, Channel>,
    topics: Vec<Topic>,
    damages: ReadErrors,
}

/// A schema as stored in the file.
struct SchemaText {
    name: String,
    encoding: String,
    data: Vec<u8>,
}

struct Channel {
    topic: usize,
    encoding: Encoding,
}

/// Encoding of the messages of a channel.
enum Encoding {
    Json,
    Cdr(Schema),
    Protobuf(prost_reflect::MessageDescriptor),
    /// Messages of this encoding are only counted.
    Unknown,
}

impl Encoding {
    /// Returns the encoding of a channel's messages; the reason where they cannot be read.
    fn of(name: &str, schema: Option<&SchemaText>) -> Result<Encoding, String> {
        let wanted = |encoding: &str| {
            let schema = schema.ok_or_else(|| "its schema is missing".to_string())?;
            match schema.encoding == encoding {
                true => Ok(schema),
                false => Err(format!("its schema is written in `{}`; `{encoding}` is read here", schema.encoding)),
            }
        };
        match name {
            "json" => Ok(Encoding::Json),
            "cdr" => {
                let SchemaText { name, data, .. } = wanted("ros2msg")?;
                Schema::parse(name, &String::from_utf8_lossy(data)).map(Encoding::Cdr)
            }
            "protobuf" => {
                let SchemaText { name, data, .. } = wanted("protobuf")?;
                protobuf::descriptor(name, data).map(Encoding::Protobuf)
            }
            _ => Err("only json, cdr and protobuf are supported".to_string()),
        }
    }

    fn read(&self, data: &[u8]) -> Result<Nested, String> {
        match self {
            Encoding::Json => serde_json::from_slice::<serde_json::Value>(data)
                .map(Nested::from)
                .map_err(|error| format!("it is not JSON, {error}")),
            Encoding::Cdr(schema) => cdr::read(schema, data),
            Encoding::Protobuf(descriptor) => protobuf::read(descriptor, data),
            Encoding::Unknown => Ok(Nested::Members(Vec::new())),
        }
    }
}

/// The records of a file or of an unpacked chunk.
struct Records<R> {
    input: R,
    reader: LinearReader,
    /// Offset of the next record in the input.
    offset: u64,
}

/// A record with its opcode, content and offset.
type RawRecord = (u8, Vec<u8>, u64);

impl<R: Read> Records<R> {
    /// Reads records of at most `longest` bytes, without the magic bytes around them.
    fn new(input: R, longest: usize) -> Records<R> {
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_emit_chunks(true)
            .with_record_length_limit(longest);
        Records { input, reader: LinearReader::new_with_options(options), offset: 0 }
    }

    /// Returns the next record, or `None` at the end. The inner error holds the offset of a record that is cut or too long.
    fn next(&mut self) -> io::Result<Result<Option<RawRecord>, u64>> {
        loop {
            match self.reader.next_event() {
                None => return Ok(Ok(None)),
                Some(Err(_)) => return Ok(Err(self.offset)),
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    let at = self.offset;
                    self.offset += RECORD_HEADER + data.len() as u64;
                    return Ok(Ok(Some((opcode, data.to_vec(), at))));
                }
                Some(Ok(LinearReadEvent::ReadRequest(_))) => {}
            }
            // Reads one block at a time, regardless of the length that a record claims.
            let slot = self.reader.insert(BLOCK);
            let read = loop {
                match self.input.read(slot) {
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    other => break other?,
                }
            };
            self.reader.notify_read(read);
        }
    }
}

impl<R: Read> Mcap<R> {
    pub(crate) fn new(input: R) -> Mcap<R> {
        Mcap {
            file: Records::new(input, CHUNK_BYTES_MAX),
            chunk: None,
            begun: false,
            ended: false,
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            topics: Vec::new(),
            damages: ReadErrors::default(),
        }
    }

    fn begin(&mut self) -> io::Result<()> {
        let mut first = Vec::new();
        self.file.input.by_ref().take(MAGIC.len() as u64).read_to_end(&mut first)?;
        if first != MAGIC {
            self.damages.add(|| "byte 0: this is not the beginning of an MCAP file".to_string());
        }
        self.file.offset = first.len() as u64;
        Ok(())
    }

    /// Returns the next record of the chunk that is being read, or of the file.
    fn record(&mut self) -> io::Result<Option<RawRecord>> {
        if let Some((chunk, place)) = &mut self.chunk {
            let place = *place;
            match chunk.next()? {
                Ok(Some((opcode, body, _))) => return Ok(Some((opcode, body, place))),
                Ok(None) => {}
                Err(at) => self.damages.add(|| format!("byte {at} of the chunk at byte {place}: a record is cut")),
            }
            self.chunk = None;
        }
        if self.ended {
            return Ok(None);
        }
        let record = self.file.next()?;
        self.ended = !matches!(record, Ok(Some(_)));
        Ok(record.unwrap_or_else(|at| {
            self.damages.add(|| format!("byte {at}: the log ends within a record, or a length is wrong"));
            None
        }))
    }

    fn channel(&mut self, channel: records::Channel, at: u64) {
        if self.channels.contains_key(&channel.id) {
            return;
        }
        if self.topics.len() >= TOPICS_MAX {
            return self.damages.add(|| format!("byte {at}: more than {TOPICS_MAX} topics"));
        }
        let (name, written) = (channel.topic, channel.message_encoding);
        let encoding = Encoding::of(&written, self.schemas.get(&channel.schema_id)).unwrap_or_else(|reason| {
            self.damages
                .add(|| format!("byte {at}: messages of `{name}` in `{written}` are counted, but not read: {reason}"));
            Encoding::Unknown
        });
        self.channels.insert(channel.id, Channel { topic: self.topics.len(), encoding });
        self.topics.push(Topic { name, ..Topic::default() });
    }

    /// Reads a message into `message`; false if it cannot be decoded.
    fn message(&mut self, header: &records::MessageHeader, data: &[u8], at: u64, message: &mut Message) -> bool {
        let Some(channel) = self.channels.get(&header.channel_id) else {
            self.damages.add(|| format!("byte {at}: a message of a channel that was not announced"));
            return false;
        };
        message.topic = channel.topic;
        message.at = Time(i64::try_from(header.log_time).unwrap_or(i64::MAX));
        message.values.clear();
        let Some(topic) = self.topics.get_mut(channel.topic) else { return false };
        match channel.encoding.read(data) {
            Ok(Nested::Members(none)) if none.is_empty() => {}
            Ok(value) => nested::spread(value, topic, &mut message.values),
            Err(reason) => {
                self.damages.add(|| format!("byte {at}: a message of `{}` cannot be read: {reason}", topic.name));
                return false;
            }
        }
        true
    }

    fn open_chunk(&mut self, header: &ChunkHeader, data: &[u8], at: u64) {
        match unpacked(header, data) {
            Ok(records) => self.chunk = Some((Records::new(Cursor::new(records), MESSAGE_BYTES_MAX), at)),
            Err(reason) => self.damages.add(|| format!("byte {at}: this chunk cannot be unpacked: {reason}")),
        }
    }
}

/// Returns the records of a chunk, up to the size that its header announces.
fn unpacked(header: &ChunkHeader, data: &[u8]) -> Result<Vec<u8>, String> {
    let size = usize::try_from(header.uncompressed_size).ok().filter(|size| *size <= CHUNK_BYTES_MAX);
    let size = size.ok_or_else(|| format!("its size of {} bytes exceeds the limit", header.uncompressed_size))?;
    let limited = |decoder: &mut dyn Read| {
        let mut unpacked = Vec::new();
        let read = decoder.take(size as u64).read_to_end(&mut unpacked);
        read.map(|_| unpacked).map_err(|error| error.to_string())
    };
    match header.compression.as_str() {
        "" => Ok(data.to_vec()),
        "lz4" => limited(&mut lz4_flex::frame::FrameDecoder::new(data)),
        "zstd" => {
            let decoder = ruzstd::decoding::StreamingDecoder::new(data).map_err(|error| error.to_string());
            limited(&mut decoder?)
        }
        other => Err(format!("its compression `{other}` is not known")),
    }
}

impl<R: Read> LogReader for Mcap<R> {
    fn next(&mut self, message: &mut Message) -> io::Result<bool> {
        if !self.begun {
            self.begun = true;
            self.begin()?;
        }
        loop {
            let Some((opcode, body, at)) = self.record()? else {
                if self.chunk.is_none() {
                    return Ok(false);
                }
                continue;
            };
            let wanted = matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE | op::CHUNK);
            // Here the data section ends; a summary of it follows.
            self.ended |= opcode == op::DATA_END;
            if !wanted {
                continue;
            }
            match mcap::parse_record(opcode, &body) {
                Ok(Record::Schema { header, data }) => {
                    let (name, encoding, data) = (header.name, header.encoding, data.into_owned());
                    self.schemas.entry(header.id).or_insert(SchemaText { name, encoding, data });
                }
                Ok(Record::Channel(channel)) => self.channel(channel, at),
                Ok(Record::Message { header, data }) => {
                    if self.message(&header, &data, at, message) {
                        return Ok(true);
                    }
                }
                Ok(Record::Chunk { header, data }) => self.open_chunk(&header, &data, at),
                Ok(_) => {}
                Err(error) => {
                    self.damages.add(|| format!("byte {at}: a record of kind {opcode} cannot be read: {error}"))
                }
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
