//! `apex monitor`: conditions over a log, a flight record, a file of inputs or standard input.

use crate::error::{CliError, CliResult, read_text};
use crate::monitor::input::Source;
use crate::options::MonitorOptions;
use crate::output::Listened;
use crate::{output, sources, table_file};
use apex_executive::state::clause::MonitorId;
use apex_executive::{MonitorSession, ResultEvent};
use apex_mission::monitor_report::{Style, placed, verdict_word};
use apex_model::condition::Condition;
use apex_model::event::{EventKind, StateVariable};
use apex_model::library::Library;
use apex_model::time::Time;
use apex_pdl::{CheckedConditions, SourceText};
use apex_tables::ResultWriter;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

type ResultTable = ResultWriter<BufWriter<File>>;

const OPEN: ResultEvent = ResultEvent::Recognised { open: true };

/// Watches the conditions over the input and prints their results.
pub fn run(options: &MonitorOptions) -> CliResult {
    let standard = [PathBuf::from("-")];
    let inputs = if options.inputs.is_empty() { standard.as_slice() } else { options.inputs.as_slice() };
    let results = options.results.as_deref();
    let unwritten = |error| table_file::unwritten(results, &error);
    let mut table = None;
    if let Some(path) = results {
        table_file::refuse_to_overwrite(path, inputs, "--results")?;
        let (file, extension) = (table_file::created(path)?, path.extension().map(std::ffi::OsStr::to_ascii_lowercase));
        let is_parquet = extension.is_some_and(|extension| extension == "parquet" || extension == "pq");
        let begun = if is_parquet { ResultWriter::parquet(file) } else { ResultWriter::csv(file) };
        table = Some(begun.map_err(unwritten)?);
    }
    if let Some(path) = &options.plot {
        check_picture_name(path)?;
        table_file::refuse_to_overwrite(path, inputs, "--plot")?;
        if inputs.len() > 1 {
            return Err(CliError::user("`--plot` draws one input").help("name one with `--inputs`"));
        }
    }
    let mut verdicts = Vec::new();
    for path in inputs {
        let name = (inputs.len() > 1).then(|| path.display().to_string());
        match watch(options, path, name, &mut table)? {
            Some(found) => verdicts.extend(found),
            None => return Ok(()),
        }
    }
    table.map_or(Ok(()), ResultWriter::finish).map_err(unwritten)?;
    match &options.expect {
        Some(expected) if !options.fields && verdicts.iter().any(|verdict| verdict != expected) => {
            Err(CliError::failure(format!("not every verdict is `{expected}`")).because(verdicts.join(", ")))
        }
        _ => Ok(()),
    }
}

/// Watches the conditions over one input and returns their verdicts; none if the reader of the output has gone. `name` stands
/// in front of what is printed of it.
fn watch(
    options: &MonitorOptions,
    path: &Path,
    name: Option<String>,
    table: &mut Option<ResultTable>,
) -> CliResult<Option<Vec<String>>> {
    let mut source = Source::of(path, options.mapping.as_deref(), options.log_time)?;
    if options.fields {
        return list_fields(source, options.json).map(|()| Some(Vec::new()));
    }
    if options.show_mapping {
        return output::print(source.mapping_text()?).map(|()| Some(Vec::new()));
    }
    let time =
        |text: &Option<String>, option| text.as_deref().map(|text| sources::parse_time(text, option)).transpose();
    let span = (time(&options.from, "--from")?, time(&options.until, "--until")?);
    if let (Some(from), Some(until)) = span
        && until < from
    {
        return Err(
            CliError::user(format!("`--until {until}` is before `--from {from}`")).help("give a later `--until`")
        );
    }
    let created = time(&options.created, "--created")?.or(span.0);
    let CheckedConditions { checked, conditions } = conditions(options, &mut source)?;
    let utc_of_zero = if options.utc { Some(source.utc_of_zero()?) } else { None };
    let style =
        Style { json: options.json, live: matches!(source, Source::Lines), several: conditions.len() > 1, utc_of_zero };
    let library = Arc::new(checked.library);
    let session = MonitorSession::new(Arc::clone(&library), sources::host_functions())
        .map(MonitorSession::with_gaps)
        .map(|session| if style.live { session } else { session.over_a_log() })
        .map(|session| if options.plot.is_some() { session.keeping_samples() } else { session })
        .map_err(|reason| CliError::user("the library cannot be used").because(reason))?;
    let out = Listened::standard();
    let results = options.results.as_deref();
    let wanted = session.attributes_read(&conditions);
    let (intervals, known) = (options.plot.is_some().then(Vec::new), Vec::new());
    let mut watching = Watching {
        session,
        conditions,
        created,
        span,
        style,
        name,
        table,
        results,
        out,
        intervals,
        known,
        heard: false,
        over: false,
    };
    let gone = watching.out.gone();
    let fed = source.feed(&library, wanted.as_ref(), &mut |at, kind| watching.take(at, kind));
    // A reader such as `head` that has seen enough.
    if gone.get() {
        return Ok(None);
    }
    // Results of what was read before a fault are printed all the same; a file that is not a log has none.
    if watching.heard || fed.is_ok() {
        watching.known = fed.as_ref().map(Clone::clone).unwrap_or_default();
        let verdicts = watching.end()?;
        if let (Some(path), Some(intervals)) = (&options.plot, &watching.intervals) {
            draw(path, &watching, intervals)?;
        }
        return fed.map(|_| Some(verdicts));
    }
    fed.map(|_| None)
}

/// Writes the picture of what was watched.
fn draw(path: &Path, watching: &Watching<'_>, intervals: &[(Time, Time)]) -> CliResult {
    let failed = |error: Box<dyn std::error::Error>| {
        CliError::failure(format!("cannot write {}", path.display())).because(error)
    };
    let picture = apex_tables::plot(&watching.session, &watching.conditions, intervals).map_err(failed)?;
    let picture = picture.ok_or_else(|| {
        CliError::user(format!("nothing to draw in {}", path.display()))
            .because("no sample of what the conditions read is a number")
            .help("name other conditions, or leave `--plot` out")
    })?;
    std::fs::write(path, picture).map_err(|error| failed(error.into()))
}

/// Refuses names of files that are not pictures of a kind that can be drawn.
fn check_picture_name(path: &Path) -> CliResult {
    match path.extension() {
        Some(extension) if extension.eq_ignore_ascii_case("svg") => Ok(()),
        _ => Err(CliError::user(format!("`--plot {}` is not a name of an SVG file", path.display()))
            .because("pictures are drawn as SVG, which browsers show and other programs convert")
            .help("end the name in .svg")),
    }
}

fn list_fields(mut source: Source, json: bool) -> CliResult {
    // Which state variables come of the fields is part of the answer, where a mapping is known.
    let mapped = source.declarations(&Library::default());
    match source {
        Source::Log(log) => crate::monitor::input::list_fields(&log, json),
        _ => mapped.and(Err(CliError::user("`--fields` is for logs")
            .because("lines of JSON and flight records name state variables themselves")
            .help("`apex trace RECORD --type measurement` lists the samples of a record"))),
    }
}

/// Checks the conditions and everything that they need.
fn conditions(options: &MonitorOptions, source: &mut Source) -> CliResult<CheckedConditions> {
    let mut texts: Vec<SourceText> = Vec::new();
    for (index, text) in options.conditions.iter().enumerate() {
        if Path::new(text).is_file() {
            return Err(CliError::user(format!("`{text}` is a file, not a condition")).help(format!(
                "write `--inputs {text}` to watch it, or `--condition-file {text}` if there are conditions in it"
            )));
        }
        texts.push(SourceText { name: format!("<condition {}>", index + 1), text: text.clone() });
    }
    for path in &options.condition_file {
        texts.push(SourceText { name: path.display().to_string(), text: read_text(path)? });
    }
    if texts.is_empty() {
        return Err(CliError::user("there is no condition to watch")
            .help("give one, such as '(roll-angle aircraft-1 > 15deg)', or `--condition-file FILE`; `--fields` lists what a log holds"));
    }
    let mut library_texts: Vec<SourceText> = Vec::new();
    for (index, text) in options.declare.iter().enumerate() {
        library_texts.push(SourceText { name: format!("<declaration {}>", index + 1), text: text.clone() });
    }
    for path in &options.library {
        library_texts.push(SourceText { name: path.display().to_string(), text: read_text(path)? });
    }
    library_texts.extend(source.recorded_texts(options.library.is_empty())?);
    let folder = options.library.first().and_then(|path| path.parent()).map(std::path::Path::to_path_buf);
    let folder = folder.unwrap_or_default();
    let known = sources::check_texts(library_texts.clone(), &folder).library;
    if let Some(declarations) = source.declarations(&known)? {
        library_texts.push(declarations);
    }
    let read = sources::check_conditions(library_texts, texts, &folder);
    sources::print_warnings_and_errors(&read.checked);
    if read.checked.has_errors() {
        return Err(CliError::already_reported());
    }
    Ok(read)
}

/// A session with its reports.
struct Watching<'a> {
    session: MonitorSession,
    conditions: Vec<Condition>,
    created: Option<Time>,
    /// First and last instant of what counts.
    span: (Option<Time>, Option<Time>),
    style: Style,
    /// The input's name, where there are several.
    name: Option<String>,
    table: &'a mut Option<ResultTable>,
    /// The file of the table.
    results: Option<&'a Path>,
    out: Listened,
    /// The final intervals of all results, for a picture.
    intervals: Option<Vec<(Time, Time)>>,
    /// The state variables that the input is known to have.
    known: Vec<StateVariable>,
    heard: bool,
    /// Something in the input came after the span: the input continues beyond it.
    over: bool,
}

impl Watching<'_> {
    fn take(&mut self, at: Time, kind: EventKind) -> CliResult {
        let (from, until) = self.span;
        let over = until.is_some_and(|until| at > until);
        self.over |= over;
        if over || from.is_some_and(|from| at < from) {
            return Ok(());
        }
        if !self.heard {
            self.begin(self.created.unwrap_or(at))?;
        }
        self.session.take(kind, at);
        self.tell()
    }

    fn begin(&mut self, created_at: Time) -> CliResult {
        self.heard = true;
        for condition in self.conditions.clone() {
            self.session.watch(condition, created_at).map_err(|error| {
                CliError::user(placed(&error.message, error.place, self.session.library()))
                    .because("it must be known when the condition begins to be watched")
            })?;
        }
        Ok(())
    }

    fn tell(&mut self) -> CliResult {
        for error in self.session.take_troubles() {
            let message = placed(&error.message, error.place, self.session.library());
            output::print_error(format_args!("warning: at {}: {message}", error.at));
        }
        for result in self.session.take_results() {
            if let Some(table) = self.table {
                table
                    .write(self.name.as_deref(), &result)
                    .map_err(|error| table_file::unwritten(self.results, &error))?;
            }
            if let (Some(intervals), false) = (&mut self.intervals, result.telling == OPEN) {
                intervals.push(result.result.interval);
            }
            if let Some(text) = self.style.result(&result) {
                self.write(&text)?;
            }
        }
        if self.style.live {
            self.flush()?;
        }
        Ok(())
    }

    /// Prints the remaining results, the verdicts, and the variables without samples.
    fn end(&mut self) -> CliResult<Vec<String>> {
        if !self.heard {
            self.begin(self.created.unwrap_or(Time::ZERO))?;
        }
        let now = self.session.now().max(self.created.unwrap_or(Time::ZERO));
        // The input may end before.
        let now = self.span.1.filter(|_| self.over).map_or(now, |until| now.max(until));
        self.session.advance(now);
        self.session.finish();
        self.tell()?;
        let mut verdicts = Vec::new();
        let missing = self.session.without_samples();
        for number in 0..self.conditions.len() as u64 {
            let Some(judgement) = self.session.verdict(MonitorId(number)) else { continue };
            let mut verdict = verdict_word(&judgement.verdict).to_string();
            // A whole log without a sample says nothing: `--expect not-satisfied` must not be met by it.
            if !missing.is_empty() && !self.style.live && verdict == "not-satisfied" {
                verdict = format!("{verdict} without a sample of {}", missing.join(" "));
            }
            verdicts.push(verdict);
            let text = self.style.verdict(number + 1, &judgement, now);
            self.write(&text)?;
        }
        self.flush()?;
        self.note_missing_samples();
        Ok(verdicts)
    }

    /// Notes each variable that the conditions read and the input has no sample of.
    fn note_missing_samples(&self) {
        let histories = self.session.histories();
        let measured = histories.iter().map(|(variable, _)| variable).chain(&self.known);
        let listed: BTreeSet<String> = measured.map(|variable| variable.to_string()).collect();
        let listed: Vec<String> = listed.into_iter().take(30).collect();
        let listed = if listed.is_empty() { "none at all".to_string() } else { listed.join(" ") };
        for missing in self.session.without_samples() {
            output::print_error(format_args!("note: there is no sample of {missing} in this input; it has {listed}"));
        }
    }

    fn write(&mut self, text: &str) -> CliResult {
        let named = match &self.name {
            None => text.to_string(),
            Some(name) => named(name, text, self.style.json),
        };
        self.out.write_all(named.as_bytes()).map_err(unwritten)
    }

    fn flush(&mut self) -> CliResult {
        self.out.flush().map_err(unwritten)
    }
}

/// A result or verdict with the name of its input: the first member of an object, or in front of the first line.
fn named(name: &str, text: &str, json: bool) -> String {
    match text.strip_prefix('{').filter(|_| json) {
        Some(members) => format!("{{\"input\":{},{members}", serde_json::Value::from(name)),
        None => format!("{name}: {text}"),
    }
}

fn unwritten(error: std::io::Error) -> CliError {
    CliError::failure("cannot write to standard output").because(error)
}
