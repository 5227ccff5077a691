//! A log file with its mapping, read in order of time as measurements.

use crate::civil_time::utc_of_clock;
use crate::mapping_file::{self, MappingError, MappingFile, ReadForm};
use crate::{
    Entry, FieldSummary, Format, LogInterval, LogReader, Message, Ordered, ReadErrors, Sampled, Sampler, survey,
};
use apex_model::event::StateVariable;
use apex_model::library::Library;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

/// A log and its interpretation.
pub struct LogFile {
    path: PathBuf,
    format: Format,
    mapping: Option<MappingFile>,
    own_time: bool,
    /// True once the shipped mapping has been added.
    is_complete: bool,
}

/// Reason for which a log cannot be read; `E` is an error of the caller that takes the samples.
#[derive(Debug)]
pub enum LogError<E> {
    /// The file cannot be opened.
    Open(io::Error),
    /// The file cannot be read to its end.
    Read(io::Error),
    /// The mapping does not fit.
    Mapping(MappingError),
    /// No message of the format was found: the file is not a log of this format. With the first place that could not be read.
    NotALog(Option<String>),
    /// The caller refuses a sample.
    Sink(E),
}

/// Summary of a log that was read.
#[derive(Clone, Debug, Default)]
pub struct Fed {
    /// Errors of reading.
    pub damages: ReadErrors,
    /// The state variables that fields of the log give.
    pub variables: Vec<StateVariable>,
    /// The wanted state variables that no field of the log gives, with the fields that the mapping names for them.
    pub absent: Vec<(StateVariable, Vec<String>)>,
    /// Notes about entries of a mapping that the log contradicts or does not need.
    pub doubts: Vec<String>,
}

impl LogFile {
    /// Returns the log at `path`, interpreted by `mapping`. With `own_time`, times are those of the log's clock; otherwise mission time 0
    /// is the beginning of the log.
    pub fn new(path: &Path, format: Format, mapping: Option<MappingFile>, own_time: bool) -> LogFile {
        LogFile { path: path.to_path_buf(), format, mapping, own_time, is_complete: false }
    }

    /// Returns the path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the format.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Returns the mapping: the given one, completed by entries of the format's shipped mapping for unmapped state variables; or else the
    /// shipped mapping alone; or else the column names of a table. `None` if the meaning of fields is unknown.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn mapping<E>(&mut self, read_form: ReadForm<'_>) -> Result<Option<&MappingFile>, LogError<E>> {
        if let (Some(given), false) = (&mut self.mapping, self.is_complete) {
            self.is_complete = true;
            if let Some(shipped) = mapping_file::shipped(self.format, read_form) {
                given.add(shipped.map_err(LogError::Mapping)?);
            }
        }
        if self.mapping.is_none() {
            self.is_complete = true;
            self.mapping = match mapping_file::shipped(self.format, read_form) {
                Some(shipped) => Some(shipped.map_err(LogError::Mapping)?),
                None => self.of_columns()?,
            };
        }
        Ok(self.mapping.as_ref())
    }

    fn reader<E>(&self) -> Result<Box<dyn LogReader>, LogError<E>> {
        let file = File::open(&self.path).map_err(LogError::Open)?;
        let time = self.mapping.as_ref().and_then(|mapping| mapping.time.clone());
        Ok(self.format.reader(BufReader::new(file), time))
    }

    /// Returns the mapping that the names of a table's columns make.
    fn of_columns<E>(&self) -> Result<Option<MappingFile>, LogError<E>> {
        if self.format != Format::Csv {
            return Ok(None);
        }
        let mut reader = self.reader()?;
        reader.next(&mut Message::default()).map_err(LogError::Read)?;
        match reader.topics().first() {
            Some(topic) => Ok(Some(mapping_file::of_columns(topic, None))),
            None => Err(not_a_log(reader.damages())),
        }
    }

    /// Passes all samples on to `sink` in order of time, in the units declared in `library`. With `wanted`, only samples of these
    /// attributes are passed on, plus the first and last instants of the other samples, without their values.
    ///
    /// # Errors
    /// The file cannot be read, the mapping does not fit, or the caller refuses a sample.
    pub fn feed<E>(
        mut self,
        library: &Library,
        wanted: Option<&BTreeSet<Symbol>>,
        sink: &mut dyn FnMut(Time, Option<(StateVariable, Value)>) -> Result<(), E>,
    ) -> Result<Fed, LogError<E>> {
        let mut reader = self.reader()?;
        let mapping = self.mapping.take().unwrap_or_default().mapping(library).map_err(LogError::Mapping)?;
        let mut sampler = Sampler::new(mapping);
        if let Some(wanted) = wanted {
            sampler.keep_only(wanted);
            let entries = sampler.mapping().entries.iter();
            let wanted = entries.filter(|entry| wanted.contains(&entry.variable.attribute));
            let column = |entry: &Entry| entry.field.strip_prefix("csv.").unwrap_or(&entry.field).to_string();
            reader.carry_only(wanted.flat_map(|entry| [column(entry), entry.field.clone()]).collect());
        }
        let mut first = None;
        let (mut message, mut samples, mut ordered) = (Message::default(), Vec::new(), Ordered::default());
        let mut empty = true;
        let mut origin: Option<Duration> = self.own_time.then_some(Duration::ZERO);
        loop {
            let more = reader.next(&mut message).map_err(LogError::Read)?;
            empty &= !more;
            if more {
                // Mission time 0 is the beginning stated by the log, otherwise the first message.
                let began = reader.began().unwrap_or(message.at);
                let origin = *origin.get_or_insert(began - Time::ZERO);
                message.at = message.at - origin;
                sampler.sample(reader.topics(), &message, &mut samples);
                samples.drain(..).for_each(|sampled| ordered.push(sampled));
            }
            if let Some((begin, end)) = sampler.unwanted() {
                let earlier = first.is_none_or(|first| begin < first);
                first = Some(begin);
                let instants = earlier.then_some(begin).into_iter().chain((!more).then_some(end));
                instants.for_each(|at| ordered.push(Sampled { entry: usize::MAX, value: Value::nil(), at }));
            }
            while let Some(sampled) = ordered.pop(!more) {
                let entry = sampler.mapping().entries.get(sampled.entry);
                let sample = entry.map(|entry| (entry.variable.clone(), sampled.value));
                sink(sampled.at, sample).map_err(LogError::Sink)?;
            }
            if !more {
                let variables = sampler.variables().cloned().collect();
                let (damages, absent) = (reader.damages().clone(), sampler.absent());
                let doubts = sampler.doubts().to_vec();
                return if empty { Err(not_a_log(&damages)) } else { Ok(Fed { damages, variables, absent, doubts }) };
            }
        }
    }

    /// Returns the UTC in nanoseconds at mission time 0; `None` if the log does not state it.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn utc_of_zero<E>(&self) -> Result<Option<i64>, LogError<E>> {
        let mut reader = self.reader()?;
        let Some(of_clock) = utc_of_clock(self.format, &mut *reader).map_err(LogError::Read)? else { return Ok(None) };
        let (mut reader, mut message) = (self.reader()?, Message::default());
        reader.next(&mut message).map_err(LogError::Read)?;
        let began = if self.own_time { Time::ZERO } else { reader.began().unwrap_or(message.at) };
        Ok(Some(of_clock + began.0))
    }

    /// Returns the contents of the log, and the errors of reading.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn fields<E>(&self) -> Result<(Vec<FieldSummary>, Option<LogInterval>, ReadErrors), LogError<E>> {
        let mut reader = self.reader()?;
        let (fields, span) = survey(&mut *reader).map_err(LogError::Read)?;
        if span.is_none() {
            return Err(not_a_log(reader.damages()));
        }
        Ok((fields, span, reader.damages().clone()))
    }

    /// Returns the mapping that was given, or has been found.
    pub fn known_mapping(&self) -> Option<&MappingFile> {
        self.mapping.as_ref()
    }
}

fn not_a_log<E>(damages: &ReadErrors) -> LogError<E> {
    LogError::NotALog(damages.first.first().cloned())
}
