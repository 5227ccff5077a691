//! Conditions watched over one input: their results as lines, rows of a table and a picture, and their verdicts.

use crate::absences::{self, Absences};
use crate::source::{Note, Source};
use apex_executive::state::clause::MonitorId;
use apex_executive::state::monitors::monitor::Interest;
use apex_executive::{MonitorResult, MonitorSession, ResultEvent};
use apex_mission::error::{MissionError, MissionResult};
use apex_mission::monitor_report::{Style, placed, verdict_word};
use apex_mission::program::host_functions;
use apex_model::condition::Condition;
use apex_model::event::{EventKind, StateVariable};
use apex_model::library::Library;
use apex_model::time::Time;
use apex_tables::ResultWriter;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::sync::Arc;

/// A table of results in a file.
pub type ResultTable = ResultWriter<BufWriter<File>>;

const OPEN: ResultEvent = ResultEvent::Recognised { open: true };

/// Conditions to watch with their library, span and style.
pub struct LogMonitorTerms {
    /// The declarations and functions that the conditions use.
    pub library: Arc<Library>,
    /// The conditions.
    pub conditions: Vec<Condition>,
    /// The instant from which the conditions are watched; `None` is that of the first input.
    pub created: Option<Time>,
    /// First and last instant that count.
    pub span: (Option<Time>, Option<Time>),
    /// Style of the lines.
    pub style: Style,
    /// True keeps samples and intervals for a picture.
    pub is_drawn: bool,
}

/// Destinations of results.
pub struct Destinations<'a> {
    /// Receives the lines.
    pub out: &'a mut dyn Write,
    /// The input's name if there are several inputs; each line begins with it.
    pub name: Option<String>,
    /// The table with its file.
    pub table: Option<(&'a mut ResultTable, &'a Path)>,
    /// Receives warnings.
    pub note: Note<'a>,
}

/// Conditions watched over one input.
pub struct LogMonitor<'a> {
    session: MonitorSession,
    terms: LogMonitorTerms,
    to: Destinations<'a>,
    /// The final intervals of all results, for a picture.
    intervals: Vec<(Time, Time)>,
    absences: Absences,
    /// The state variables that the input is known to have.
    known: Vec<StateVariable>,
    heard: bool,
    /// The instant of the last input, also if it is outside of the span.
    last: Option<Time>,
    /// True once the input contained something after the span: the input then continues beyond the span.
    over: bool,
}

impl<'a> LogMonitor<'a> {
    /// Returns a monitor that has read no input yet.
    ///
    /// # Errors
    /// The library needs functions that this program does not have.
    pub fn new(terms: LogMonitorTerms, to: Destinations<'a>) -> MissionResult<LogMonitor<'a>> {
        let session = MonitorSession::new(Arc::clone(&terms.library), host_functions())
            .map_err(|reason| MissionError::data("the library cannot be used").because(reason))?
            .with_gaps();
        let session = if terms.style.live { session } else { session.over_a_log() };
        let session = if terms.is_drawn { session.keeping_samples() } else { session };
        Ok(LogMonitor {
            session,
            terms,
            to,
            intervals: Vec::new(),
            absences: Absences::default(),
            known: Vec::new(),
            heard: false,
            last: None,
            over: false,
        })
    }

    /// Watches `source` to its end and returns the verdicts, one word for each condition. If reading fails, results before the failure
    /// are still reported; an input that is not a log has none.
    ///
    /// # Errors
    /// The source cannot be read; a condition cannot be watched; results cannot be written.
    pub fn run(&mut self, source: Source) -> MissionResult<Vec<String>> {
        let wanted = self.session.attributes_read(&self.terms.conditions);
        let (library, note) = (Arc::clone(&self.terms.library), self.to.note);
        let fed = source.feed(&library, wanted.as_ref(), note, &mut |at, kind| self.take(at, kind));
        if !self.heard && fed.is_err() {
            return fed.map(|_| Vec::new());
        }
        self.known = fed.as_ref().map(Clone::clone).unwrap_or_default();
        let verdicts = self.end()?;
        fed.map(|_| verdicts)
    }

    /// Returns true once any part of the input counted, or once the monitor has ended.
    pub fn has_begun(&self) -> bool {
        self.heard
    }

    /// Returns a picture (SVG) of the watched variables; `None` if no sample is a number.
    ///
    /// # Errors
    /// The picture cannot be drawn.
    pub fn picture(&self) -> Result<Option<String>, Box<dyn std::error::Error>> {
        apex_tables::plot(&self.session, &self.terms.conditions, &self.intervals)
    }

    fn take(&mut self, at: Time, kind: EventKind) -> MissionResult {
        let (from, until) = self.terms.span;
        let over = until.is_some_and(|until| at > until);
        self.over |= over;
        self.last = self.last.max(Some(at));
        if over || from.is_some_and(|from| at < from) {
            return Ok(());
        }
        if !self.heard {
            self.begin(self.terms.created.unwrap_or(at))?;
        }
        self.session.take(kind, at);
        self.tell()
    }

    fn begin(&mut self, created_at: Time) -> MissionResult {
        self.heard = true;
        let conditions = self.terms.conditions.clone();
        let watched: Vec<MonitorId> =
            conditions.iter().map(|condition| self.watch(condition, created_at)).collect::<MissionResult<_>>()?;
        // A live reader wants each result at once.
        let conditions = if self.terms.style.live { &[][..] } else { &conditions };
        for (condition, id) in conditions.iter().zip(watched) {
            if let Some(part) = absences::absent(condition) {
                let part = self.watch(part, created_at)?;
                self.absences.add(id, part);
            }
        }
        Ok(())
    }

    fn watch(&mut self, condition: &Condition, created_at: Time) -> MissionResult<MonitorId> {
        self.session.watch(condition.clone(), created_at).map_err(|error| {
            MissionError::data(placed(&error.message, error.place, self.session.library()))
                .because("the values in a condition must be known when it begins to be watched")
        })
    }

    fn tell(&mut self) -> MissionResult {
        for error in self.session.take_troubles() {
            let message = placed(&error.message, error.place, self.session.library());
            (self.to.note)(&format!("warning: at {}: {message}", error.at));
        }
        for result in self.session.take_results() {
            if let Some(result) = self.absences.pass(result) {
                self.report(&result)?;
            }
        }
        if self.terms.style.live {
            self.flush()?;
        }
        Ok(())
    }

    fn report(&mut self, result: &MonitorResult) -> MissionResult {
        if let Some((table, path)) = &mut self.to.table {
            table.write(self.to.name.as_deref(), result).map_err(|error| unwritten_table(Some(path), &error))?;
        }
        if self.terms.is_drawn && result.telling != OPEN {
            self.intervals.push(result.result.interval);
        }
        if let Some(text) = self.terms.style.result(result) {
            self.write(&text)?;
        }
        Ok(())
    }

    /// Reports the remaining results, the verdicts, and the variables without samples.
    fn end(&mut self) -> MissionResult<Vec<String>> {
        let created = self.terms.created.unwrap_or(Time::ZERO);
        if let (false, Some(from), Some(last)) = (self.heard || self.over, self.terms.span.0, self.last) {
            return Err(MissionError::data(format!("the input ends at {last}, before `--from {from}`"))
                .because("no data exist after that instant")
                .help("give an earlier `--from`"));
        }
        if !self.heard {
            self.begin(created)?;
        }
        let now = self.session.now().max(created);
        // The input may end before the span does.
        let now = self.terms.span.1.filter(|_| self.over).map_or(now, |until| now.max(until));
        self.session.advance(now);
        self.session.finish();
        self.tell()?;
        for (known, part) in self.absences.finish() {
            let end = if self.session.is_in_doubt(known.watch) { self.last_known(part) } else { now };
            self.report(&absences::until(known, end))?;
        }
        let missing = self.session.without_samples();
        let mut verdicts = Vec::new();
        for number in 0..self.terms.conditions.len() as u64 {
            let Some(judgement) = self.session.verdict(MonitorId(number)) else { continue };
            let mut verdict = verdict_word(&judgement.verdict).to_string();
            // A whole log without a sample gives no evidence, so it must not satisfy `--expect not-satisfied`.
            if !missing.is_empty() && !self.terms.style.live && verdict == "not-satisfied" {
                verdict = format!("{verdict} without a sample of {}", missing.join(" "));
            }
            verdicts.push(verdict);
            let text = self.terms.style.verdict(number + 1, &judgement, now);
            self.write(&text)?;
        }
        self.flush()?;
        self.note_missing_samples();
        Ok(verdicts)
    }

    /// Returns the instant of the newest sample of the variable of `part` that has been silent longest.
    fn last_known(&self, part: MonitorId) -> Time {
        let histories = self.session.histories();
        let newest = self.session.interests(part).into_iter().flat_map(|interest| match interest {
            Interest::Variable(variable) => histories.get(&variable).into_iter().collect(),
            Interest::Attribute(attribute) => histories.of_attribute(&attribute).map(|(_, history)| history).collect(),
            _ => Vec::new(),
        });
        newest.filter_map(|history| history.newest()).map(|sample| sample.at).min().unwrap_or(Time::BEGINNING)
    }

    /// Notes each variable that the conditions read and the input has no sample of.
    fn note_missing_samples(&self) {
        let histories = self.session.histories();
        let measured = histories.iter().map(|(variable, _)| variable).chain(&self.known);
        let listed: BTreeSet<String> = measured.map(|variable| variable.to_string()).collect();
        let listed: Vec<String> = listed.into_iter().take(30).collect();
        let listed = if listed.is_empty() { "none at all".to_string() } else { listed.join(" ") };
        for missing in self.session.without_samples() {
            (self.to.note)(&format!("note: there is no sample of {missing} in this input; it has {listed}"));
        }
    }

    fn write(&mut self, text: &str) -> MissionResult {
        let named = match &self.to.name {
            None => text.to_string(),
            Some(name) => named(name, text, self.terms.style.json),
        };
        self.to.out.write_all(named.as_bytes()).map_err(unwritten)
    }

    fn flush(&mut self) -> MissionResult {
        self.to.out.flush().map_err(unwritten)
    }
}

/// Returns a result or verdict with the name of its input: the first member of an object, or in front of the first line.
fn named(name: &str, text: &str, json: bool) -> String {
    match text.strip_prefix('{').filter(|_| json) {
        Some(members) => format!("{{\"input\":{},{members}", serde_json::Value::from(name)),
        None => format!("{name}: {text}"),
    }
}

fn unwritten(error: std::io::Error) -> MissionError {
    MissionError::output("cannot write to standard output").because(error)
}

/// Returns the error of a table that could not be written; without a path, the table goes to standard output.
pub fn unwritten_table(path: Option<&Path>, error: &std::io::Error) -> MissionError {
    let name = path.map_or_else(|| "standard output".to_string(), |path| path.display().to_string());
    MissionError::output(format!("cannot write {name}"))
        .because(error)
        .help("the table is incomplete; check its folder and the free space there")
}
