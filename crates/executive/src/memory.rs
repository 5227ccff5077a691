//! Memory: how far back the clauses of a program look, and the size of that memory (`condition-rules.md`, rules 20 and 23).
//!
//! The report and the agent share one derivation: [`crate::load`] prepares the histories by the same demands.

use crate::monitoring::memory::retention;
use crate::state::histories::history::{Occurrence, Sample};
use apex_model::agent_limits::Limit;
use apex_model::library::Library;
use apex_model::limits::HISTORY_SAMPLES_DEFAULT;
use apex_model::time::Duration;
use std::collections::BTreeSet;
use std::fmt::{self, Write as _};

pub use crate::monitoring::memory::demand::{Demand, Reach, Subject, Why};

/// Returns the demands of all clauses of `library`, ordered by the data that they read, then as written.
pub fn demands(library: &Library) -> Vec<Demand> {
    let mut demands = retention::demands(library);
    demands.sort_by(|a, b| (&a.subject, a.place).cmp(&(&b.subject, b.place)));
    demands.dedup();
    demands
}

/// Remembered data of one subject.
#[derive(Clone, Debug, PartialEq)]
pub struct MemoryUse {
    /// The variable or message to which the figures apply.
    pub subject: Subject,
    /// Maximum age; `None` without a stated bound.
    pub span: Option<Duration>,
    /// Maximum number of samples (or messages), if a rate is declared or a limit applies.
    pub count: Option<u64>,
    /// Size in bytes, without texts or lists in the values.
    pub bytes: Option<u64>,
    /// The declared rate.
    pub rate_per_s: Option<f64>,
    /// Number of samples that a log keeps while its procedure is at work.
    pub logged: u64,
}

/// Returns the memory of every variable and message that the library declares or looks back at, for each object.
pub fn kept(library: &Library) -> Vec<MemoryUse> {
    let demands = demands(library);
    let everything = demands.iter().filter(|demand| demand.subject == Subject::EveryAttribute);
    let everything: Vec<&Demand> = everything.collect();
    let declared = library.state_variables.keys().cloned().map(Subject::Attribute);
    let asked = demands.iter().map(|demand| demand.subject.clone()).chain([Subject::Messages]);
    let subjects: BTreeSet<Subject> = declared.chain(asked).collect();
    let most = limit(library, Limit::HistorySamples);
    let of = |subject: Subject| {
        let own = demands.iter().filter(|demand| demand.subject == subject);
        match &subject {
            Subject::Messages | Subject::MessagesOf(_) => {
                messages(subject.clone(), own, limit(library, Limit::EventHistory))
            }
            Subject::EveryAttribute => samples(subject.clone(), own, None, most),
            Subject::Attribute(name) => {
                let declaration = library.state_variables.get(name);
                let rate = declaration.and_then(|declared| declared.rate_per_s);
                samples(subject.clone(), own.chain(everything.iter().copied()), rate, most)
            }
        }
    };
    subjects.into_iter().map(of).collect()
}

/// Returns the limit that the agents have; with several agents the greatest.
fn limit(library: &Library, limit: Limit) -> u64 {
    library.crew().iter().map(|agent| agent.limits.of(limit)).max().unwrap_or_else(|| limit.most())
}

fn longest<'a>(demands: impl Iterator<Item = &'a Demand>) -> (Option<Duration>, Option<u64>) {
    let (mut span, mut count) = (Some(Duration::ZERO), Some(0));
    for demand in demands {
        match demand.reach {
            Reach::Span(wanted) => span = span.map(|span: Duration| span.max(wanted)),
            Reach::Log { time: Some(time), count: None } => span = span.map(|span| span.max(time)),
            Reach::Log { count: Some(most), .. } => count = count.map(|count: u64| count.max(most)),
            Reach::Unbounded | Reach::Log { time: None, count: None } => span = None,
        }
    }
    (span, count)
}

fn samples<'a>(
    subject: Subject,
    demands: impl Iterator<Item = &'a Demand>,
    rate_per_s: Option<f64>,
    most: u64,
) -> MemoryUse {
    let (span, logged) = longest(demands);
    let least = HISTORY_SAMPLES_DEFAULT as u64;
    let within = match (span, rate_per_s) {
        (None, _) => Some(most),
        (Some(Duration::ZERO), _) => Some(least),
        // Both ends of the window, plus the sample that is valid at its start.
        (Some(span), Some(rate)) => Some(libm::ceil(span.seconds() * rate) as u64 + 2),
        (Some(_), None) => None,
    };
    let count = within.map(|within| within.max(logged.unwrap_or_default()).clamp(least, most));
    let bytes = count.map(|count| count * size_of::<Sample>() as u64);
    MemoryUse { subject, span, count, bytes, rate_per_s, logged: logged.unwrap_or_default() }
}

fn messages<'a>(subject: Subject, demands: impl Iterator<Item = &'a Demand>, most: u64) -> MemoryUse {
    let (span, logged) = longest(demands);
    let logged = logged.unwrap_or_default();
    let count = if span == Some(Duration::ZERO) && logged > 0 { logged.min(most) } else { most };
    let bytes = Some(count * size_of::<Occurrence>() as u64);
    MemoryUse { subject, span, count: Some(count), bytes, rate_per_s: None, logged }
}

impl Subject {
    fn noun(&self) -> &'static str {
        match self {
            Subject::Attribute(_) | Subject::EveryAttribute => "samples",
            Subject::Messages | Subject::MessagesOf(_) => "messages",
        }
    }
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Subject::Attribute(name) => write!(f, "{name}"),
            Subject::EveryAttribute => f.write_str("every other variable"),
            Subject::Messages => f.write_str("messages"),
            Subject::MessagesOf(word) => write!(f, "messages ({word} ..)"),
        }
    }
}

fn size(bytes: u64) -> String {
    match bytes {
        0..10_000 => format!("{bytes} B"),
        10_000..10_000_000 => format!("{} kB", bytes.div_ceil(1_000)),
        _ => format!("{} MB", bytes.div_ceil(1_000_000)),
    }
}

impl MemoryUse {
    fn words(&self) -> String {
        let what = self.subject.noun();
        let amount = match (self.count, self.bytes) {
            (Some(count), Some(bytes)) => format!("at most {count} {what}, {}", size(bytes)),
            _ => "samples unknown: its rate is not declared".into(),
        };
        let span = match self.span {
            None => "all".to_string(),
            Some(Duration::ZERO) if self.subject == Subject::Messages => "those of the newest instant".to_string(),
            Some(Duration::ZERO) if matches!(self.subject, Subject::MessagesOf(_)) => "its log".to_string(),
            Some(Duration::ZERO) if self.logged > 0 => "its log, else the newest two".to_string(),
            Some(Duration::ZERO) => "the newest two".to_string(),
            Some(span) => format!("the last {span}"),
        };
        let rate = self.rate_per_s.map(|rate| format!(" at {rate} per second")).unwrap_or_default();
        format!("{}: {span}{rate}; {amount}", self.subject)
    }
}

/// Returns the report of `apex check --memory`: the kept data, the clauses that require them, and the clauses without a bound.
pub fn report(library: &Library) -> String {
    let (demands, mut text) = (demands(library), String::new());
    let place = |demand: &Demand| library.describe_place(demand.place);
    for kept in kept(library) {
        let _ = writeln!(text, "{}", kept.words());
        for demand in demands.iter().filter(|demand| demand.subject == kept.subject) {
            let reach = match demand.reach {
                Reach::Span(Duration::ZERO) => "the newest".into(),
                Reach::Span(span) => format!("{span}"),
                Reach::Unbounded => "no bound".into(),
                Reach::Log { time, count } => {
                    let noun = kept.subject.noun();
                    [time.map(|time| format!("log of {time}")), count.map(|count| format!("log of {count} {noun}"))]
                        .into_iter()
                        .flatten()
                        .reduce(|all, next| format!("{all}, {next}"))
                        .unwrap_or_else(|| "log without bound".into())
                }
            };
            let _ = writeln!(text, "  {}: {reach}: {}", place(demand), demand.text);
        }
    }
    for demand in demands.iter().filter(|demand| demand.is_unbounded()) {
        let (because, instead) = (demand.reason(), demand.help());
        let limit = match demand.subject {
            Subject::Messages | Subject::MessagesOf(_) => limit(library, Limit::EventHistory),
            Subject::Attribute(_) | Subject::EveryAttribute => limit(library, Limit::HistorySamples),
        };
        let _ = writeln!(text, "without bound, up to the limit of {limit}: {}: {}", place(demand), demand.text);
        let _ = writeln!(text, "  why: {because}");
        let _ = writeln!(text, "  write instead: {instead}");
    }
    text
}
