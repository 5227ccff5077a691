//! Sources of measurements and events: a log, a flight record, or lines of JSON.

use apex_logs::{Format, LogError, LogFile, MappingError, MappingFile, ReadErrors};
use apex_mission::error::{ErrorKind, MissionError, MissionResult};
use apex_mission::files::{read_text, unreadable};
use apex_mission::{recording, scenario};
use apex_model::effect::Effect;
use apex_model::event::{EventKind, StateVariable, measured};
use apex_model::library::Library;
use apex_model::source::SourceFile;
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_pdl::SourceText;
use apex_runtime::input_lines::read_live;
use apex_runtime::record::RecordReader;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufRead, Read};
use std::path::{Path, PathBuf};

/// Receives lines that the user should read: warnings and notes.
pub type Note<'a> = &'a dyn Fn(&str);

/// Receives each measurement and event.
pub type SampleSink<'a, E> = &'a mut dyn FnMut(Time, EventKind) -> Result<(), E>;

/// Source of the data.
pub enum Source {
    /// Lines of JSON on standard input, passed on as they arrive.
    Lines,
    /// A file of such lines.
    LinesFile(PathBuf),
    /// A flight record.
    Record(Box<RecordReader>),
    /// A log of another system.
    Log(Box<LogFile>),
}

/// First bytes of a flight record.
const RECORD_MAGIC: &[u8] = b"SQLite format 3\0";

impl Source {
    /// Recognises the kind of input at `path`. `mapping` applies to logs; with `own_time` the times are those of the log's clock. `note`
    /// receives messages for the user about the source.
    ///
    /// # Errors
    /// The file cannot be read, has no known format, or does not use the given mapping.
    pub fn of(path: &Path, mapping: Option<&Path>, own_time: bool, note: Note<'_>) -> MissionResult<Source> {
        let mapping = mapping.map(read_mapping).transpose()?;
        if path.as_os_str() == "-" {
            return no_mapping(Source::Lines, mapping.is_some());
        }
        if path.is_dir() {
            return Err(MissionError::data(format!("{} is a folder", path.display())).help("name a file in it"));
        }
        let mut first = vec![0; 512];
        let mut file = File::open(path).map_err(|error| unreadable(path, &error))?;
        let length = file.read(&mut first).map_err(|error| unreadable(path, &error))?;
        first.truncate(length);
        if first.starts_with(RECORD_MAGIC) {
            let (reader, warning) = recording::open(path)?;
            warning.into_iter().for_each(|warning| note(&format!("warning: {warning}")));
            return no_mapping(Source::Record(Box::new(reader)), mapping.is_some());
        }
        let extension = path.extension().map(|extension| extension.to_string_lossy().into_owned()).unwrap_or_default();
        let lines = ["json", "jsonl", "ndjson"].contains(&extension.to_ascii_lowercase().as_str());
        let begins = first.iter().find(|byte| !byte.is_ascii_whitespace());
        // A `#` may also begin texts and tables, so a name with the extension of a log decides.
        let named = Format::of(&[], &extension);
        let in_lines = match begins {
            Some(b'{') => named != Some(Format::Csv),
            Some(b'#') => named.is_none(),
            _ => false,
        };
        if lines || in_lines {
            return no_mapping(Source::LinesFile(path.to_path_buf()), mapping.is_some());
        }
        let Some(format) = Format::of(&first, &extension) else {
            return Err(MissionError::data(format!("the format of {} is not known", path.display()))
                .because("neither its first bytes nor the ending of its name show the format")
                .help("known are JSON lines, flight records, .ulg, .bin, .log, .tlog, .mcap and .csv"));
        };
        Ok(Source::Log(Box::new(LogFile::new(path, format, mapping, own_time))))
    }

    /// Texts that declare the state variables of the source, in addition to those of `library`.
    ///
    /// # Errors
    /// A log without a mapping, or a log that cannot be read.
    pub fn declarations(&mut self, library: &Library) -> MissionResult<Option<SourceText>> {
        let Source::Log(log) = self else { return Ok(None) };
        let (path, format) = (log.path().to_path_buf(), log.format());
        let Some(mapping) = log.mapping(&read_form).map_err(|error| unread(&path, format, error))? else {
            return Err(MissionError::data(format!("{} needs a mapping", path.display()))
                .because(format!("the meaning of the fields of a log in {} is not known", format.name()))
                .help("`--fields` lists them; write (map \"TOPIC.FIELD\" (ATTRIBUTE OBJECT)) for those you need into a file, and name it with `--mapping`"));
        };
        let text = mapping.declarations_beside(library);
        Ok(Some(SourceText { name: mapping.name.clone(), text }))
    }

    /// The PDL in a flight record, if it is `wanted`: it declares the record's state variables.
    ///
    /// # Errors
    /// The record is damaged.
    pub fn recorded_texts(&self, wanted: bool) -> MissionResult<Vec<SourceText>> {
        let Source::Record(reader) = self else { return Ok(Vec::new()) };
        if !wanted {
            return Ok(Vec::new());
        }
        let recorded = reader.pdl_sources().map_err(|error| MissionError::new(ErrorKind::Input, error.to_string()))?;
        let text = |source: SourceFile| SourceText { name: source.name.to_string(), text: source.text.to_string() };
        Ok(recorded.into_iter().map(text).collect())
    }

    /// Passes everything to `sink`, in order of time. `note` receives the parts of a log that cannot be read.
    ///
    /// With `wanted`, samples of other attributes may be left out, but their first and last instant are still passed on. Returns the
    /// state variables of a log.
    ///
    /// # Errors
    /// The source cannot be read; errors of `sink`.
    pub fn feed<E: From<MissionError>>(
        self,
        library: &Library,
        wanted: Option<&BTreeSet<Symbol>>,
        note: Note<'_>,
        sink: SampleSink<'_, E>,
    ) -> Result<Vec<StateVariable>, E> {
        match self {
            Source::Log(log) => return feed_log(*log, library, wanted, note, sink),
            Source::Lines => feed_lines(sink),
            Source::LinesFile(path) => {
                scenario::read(&path)?.into_iter().try_for_each(|input| sink(input.at, input.kind))
            }
            Source::Record(reader) => feed_record(&reader, sink),
        }?;
        Ok(Vec::new())
    }

    /// Nanoseconds of UTC at mission time 0.
    ///
    /// # Errors
    /// The input is lines, or does not state the time.
    pub fn utc_of_zero(&self) -> MissionResult<i64> {
        let unknown = |why: String| {
            MissionError::data("`--utc`: the civil time of this input is not known")
                .because(why)
                .help("leave the option out; instants then count from the beginning of the input")
        };
        if let Source::Record(reader) = self {
            let found = recording::utc_of_zero_ns(reader)?;
            return found.ok_or_else(|| unknown("the mission of the record states no `:start`".to_string()));
        }
        let Source::Log(log) = self else { return Err(unknown("lines of JSON have mission times only".to_string())) };
        let found = log.utc_of_zero().map_err(|error| unread(log.path(), log.format(), error))?;
        let why = format!("{} has no GPS time, and its clock does not count from 1970", log.path().display());
        found.ok_or_else(|| unknown(why))
    }

    /// Returns the mapping of a log as PDL.
    ///
    /// # Errors
    /// The input is not a log, or has no mapping.
    pub fn mapping_text(&mut self) -> MissionResult<String> {
        self.declarations(&Library::default())?;
        match self {
            Source::Log(log) => Ok(log.known_mapping().map(MappingFile::to_pdl).unwrap_or_default()),
            _ => Err(MissionError::data("`--show-mapping` is for logs")
                .because("lines of JSON and flight records name state variables themselves")
                .help("name a log with `--inputs`")),
        }
    }
}

fn no_mapping(source: Source, mapped: bool) -> MissionResult<Source> {
    if mapped {
        return Err(MissionError::data("`--mapping` has no meaning for this input")
            .because("its lines name state variables themselves")
            .help("leave the option out"));
    }
    Ok(source)
}

fn feed_lines<E: From<MissionError>>(sink: SampleSink<'_, E>) -> Result<(), E> {
    let read_value = |text: &str| apex_pdl::read_value(text).map_err(|diagnostic| diagnostic.message);
    let mut now = Time::ZERO;
    for (number, line) in std::io::stdin().lock().lines().enumerate() {
        let line =
            line.map_err(|error| MissionError::new(ErrorKind::Input, "cannot read standard input").because(error))?;
        let text = line.trim();
        if text.is_empty() || text.starts_with('#') {
            continue;
        }
        let input = read_live(text, now, &read_value)
            .map_err(|fault| MissionError::data(format!("<standard input>:{}: {fault}", number + 1)))?;
        now = now.max(input.at);
        sink(input.at, input.kind)?;
    }
    Ok(())
}

fn feed_record<E: From<MissionError>>(reader: &RecordReader, sink: SampleSink<'_, E>) -> Result<(), E> {
    let failed = |error: apex_runtime::RecordError| MissionError::new(ErrorKind::Input, error.to_string());
    for step in reader.steps().map_err(failed)? {
        let step = step.map_err(failed)?;
        let effects = step.decoded_effects().map_err(|what| MissionError::new(ErrorKind::Input, what))?;
        let now = step.batch.now;
        for event in step.batch.events {
            sink(event.at, event.kind)?;
        }
        // The agent receives its own messages and published samples at the instant at which it sends them.
        for effect in effects {
            match effect {
                Effect::Inform { form, .. } => match measured(&form) {
                    Some((variable, value)) => sink(now, EventKind::Measurement(variable, value))?,
                    None => sink(now, EventKind::Occurrence(form))?,
                },
                Effect::Publish { variable, value, .. } => sink(now, EventKind::Measurement(variable, value))?,
                _ => {}
            }
        }
    }
    Ok(())
}

fn feed_log<E: From<MissionError>>(
    log: LogFile,
    library: &Library,
    wanted: Option<&BTreeSet<Symbol>>,
    note: Note<'_>,
    sink: SampleSink<'_, E>,
) -> Result<Vec<StateVariable>, E> {
    let path = log.path().to_path_buf();
    let format = log.format();
    let mut measured = |at, sample: Option<(StateVariable, Value)>| match sample {
        Some((variable, value)) => sink(at, EventKind::Measurement(variable, value)),
        None => sink(at, EventKind::Woken),
    };
    let fed = log.feed(library, wanted, &mut measured).map_err(|error| unread(&path, format, error))?;
    tell_damages(&path, &fed.damages, note);
    fed.doubts.iter().for_each(|doubt| note(&format!("note: {doubt}")));
    for (variable, fields) in fed.absent.iter().filter(|_| wanted.is_some()) {
        let named = fields.join("` or `");
        note(&format!(
            "note: the mapping takes {variable} from `{named}`, which this log does not have; `--fields` lists its fields"
        ));
    }
    Ok(fed.variables)
}

/// The list of the log's contents, as text or JSON.
///
/// # Errors
/// The log cannot be read.
pub fn field_list(log: &LogFile, json: bool, note: Note<'_>) -> MissionResult<String> {
    let (fields, span, damages) =
        log.fields().map_err(|error| unread::<MissionError>(log.path(), log.format(), error))?;
    tell_damages(log.path(), &damages, note);
    Ok(apex_logs::field_list(log.format(), &fields, span, log.known_mapping(), json))
}

fn read_mapping(path: &Path) -> MissionResult<MappingFile> {
    let text = read_text(path)?;
    MappingFile::parse(&path.display().to_string(), &text, &read_form).map_err(of_mapping)
}

fn read_form(text: &str) -> Result<Value, (u32, String)> {
    apex_pdl::read_value(text).map_err(|diagnostic| (diagnostic.span.line, diagnostic.message))
}

fn unread<E: From<MissionError>>(path: &Path, format: Format, error: LogError<E>) -> E {
    let error = match error {
        LogError::Open(error) => unreadable(path, &error),
        LogError::Read(error) => {
            MissionError::new(ErrorKind::Input, format!("cannot read {} to its end", path.display())).because(error)
        }
        LogError::Mapping(error) => of_mapping(error),
        LogError::NotALog(first) => {
            let name = format.name();
            let error = MissionError::data(format!("{} holds no readable message of format {name}", path.display()));
            let error = match first {
                Some(first) => error.because(first),
                None => error.because("it ends before its first message"),
            };
            error.help(
                "name another file, or rename it to the ending of its format: .ulg, .bin, .log, .tlog, .mcap or .csv",
            )
        }
        LogError::Sink(error) => return error,
    };
    error.into()
}

fn of_mapping(error: MappingError) -> MissionError {
    MissionError { reason: error.reason, help: error.help, ..MissionError::data(error.message) }
}

/// Reports the parts that could not be read.
fn tell_damages(path: &Path, damages: &ReadErrors, note: Note<'_>) {
    for what in &damages.first {
        note(&format!("note: {}: {what}", path.display()));
    }
    let more = damages.count.saturating_sub(damages.first.len() as u64);
    if more > 0 {
        note(&format!("note: {}: {more} further damaged places", path.display()));
    }
}
