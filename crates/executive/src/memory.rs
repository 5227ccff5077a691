//! Memory: how far back a program looks, clause by clause, and what that takes (`monitoring.md`, rules 20 and 23).
//!
//! What is derived here is what an agent obeys: [`crate::load`] prepares the histories by the same demands.

use crate::monitoring;
use apex_model::agent_limits::Limit;
use apex_model::history::{Occurrence, Sample};
use apex_model::library::Library;
use apex_model::limits::HISTORY_SAMPLES_DEFAULT;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use std::collections::BTreeSet;
use std::fmt::{self, Write as _};

/// What is remembered.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subject {
    /// Samples of one attribute, for each object.
    Attribute(Symbol),
    /// Samples of any attribute.
    EveryAttribute,
    /// Messages.
    Messages,
    /// Messages that begin with this word.
    MessagesOf(Symbol),
}

/// How much of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// So long before the newest.
    Span(Duration),
    /// Everything, up to the hard limit.
    Unbounded,
    /// What a log policy keeps while its procedure is at work.
    Log {
        /// Not longer.
        time: Option<Duration>,
        /// Not more.
        count: Option<u64>,
    },
}

/// Why it is remembered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Why {
    /// A query or a constraint on time names its window.
    Window,
    /// Late samples are accepted.
    Lateness,
    /// A `:timestamp` without an earliest time that is written out.
    AnyTime,
    /// An episode's start or end is constrained.
    EpisodeTimes,
    /// A message's time is constrained, without an earliest time that is written out.
    EventTimes,
    /// A condition counts from its task's creation, but can be watched later only.
    SinceCreation,
    /// How far back a query asks is known only then.
    QueryTime,
    /// Which variable a query asks for is known only then.
    QueryVariable,
    /// The fit interval of a line begins at a time that is not written out.
    FitInterval,
    /// A `:custom` trend is asked about all values of an episode.
    Values,
    /// Cycles are looked for in all that is remembered.
    Cycles,
    /// A `log` clause.
    Log,
}

impl Why {
    /// Why the clause needs what it needs, and what to write where it should need less.
    fn words(self) -> (&'static str, &'static str) {
        match self {
            Why::Window => ("it names its window", "a shorter window"),
            Why::Lateness => (
                "when a sample comes late, conditions that wait look back over all they have waited for",
                "no `:lateness`, where the variable's samples come in order",
            ),
            Why::AnyTime => {
                ("its samples may lie any time ago", "an earliest time before now: `:timestamp (> (- +now+ P10M))`")
            }
            Why::EpisodeTimes => (
                "its run may have begun any time ago",
                "no `:start` and no `:end`: without them it counts from its task's creation",
            ),
            Why::EventTimes => {
                ("its message may lie any time ago", "an earliest time before now: `:timing (:es (- +now+ P10M))`")
            }
            Why::SinceCreation => (
                "it counts from its task's creation, but names a task that is known only later",
                "two steps: one that waits for the task, and after it one that waits for this",
            ),
            Why::QueryTime => (
                "how far back it asks is known only when it asks",
                "a window such as `P10M`, or an instant such as `(- +now+ P10S)`",
            ),
            Why::QueryVariable => {
                ("which state variable it asks for is known only when it asks", "the name of the state variable")
            }
            Why::FitInterval => (
                "the samples of its line may begin any time ago",
                "a `:start` before now that is written out: `:start (- +now+ P10M)`",
            ),
            Why::Values => (
                "its predicate is asked about all values of the episode",
                "a statistic or another trend, which keep no values",
            ),
            Why::Cycles => ("it looks for cycles in all that is remembered", "a condition with a window"),
            Why::Log => ("its policy has no `:time-limit` and no `:count-limit`", "`:time-limit P10M`"),
        }
    }
}

/// What one clause needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Demand {
    /// What it looks at.
    pub subject: Subject,
    /// How far.
    pub reach: Reach,
    /// Why.
    pub why: Why,
    /// The clause as PDL.
    pub text: String,
    /// Where it stands.
    pub place: Place,
}

impl Demand {
    /// Is it without a bound of its own?
    pub fn is_unbounded(&self) -> bool {
        matches!(self.reach, Reach::Unbounded | Reach::Log { time: None, count: None })
    }

    /// Why the clause needs what it needs.
    pub fn reason(&self) -> &'static str {
        self.why.words().0
    }

    /// What to write instead, so that it needs less.
    pub fn help(&self) -> &'static str {
        self.why.words().1
    }
}

/// What all clauses of `library` need, in order of what they look at, then as they are written.
pub fn demands(library: &Library) -> Vec<Demand> {
    let mut demands = monitoring::demands(library);
    demands.sort_by(|a, b| (&a.subject, a.place).cmp(&(&b.subject, b.place)));
    demands.dedup();
    demands
}

/// What is kept of one subject.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept {
    /// Of what.
    pub subject: Subject,
    /// For how long, at the most; none is without a bound of its own.
    pub span: Option<Duration>,
    /// How many samples (or messages) at the most, where a rate is declared or a limit applies.
    pub count: Option<u64>,
    /// How many bytes these are, each counted without text or lists in it.
    pub bytes: Option<u64>,
    /// The declared rate.
    pub rate_per_s: Option<f64>,
    /// How many samples a log keeps while its procedure is at work.
    pub logged: u64,
}

/// What is kept of everything that the library declares or looks back at, for each object of it.
pub fn kept(library: &Library) -> Vec<Kept> {
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

/// The limit as the agents have it: of several the greatest.
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
) -> Kept {
    let (span, logged) = longest(demands);
    let least = HISTORY_SAMPLES_DEFAULT as u64;
    let within = match (span, rate_per_s) {
        (None, _) => Some(most),
        (Some(Duration::ZERO), _) => Some(least),
        // Both ends of the window, and the sample that held when it begins.
        (Some(span), Some(rate)) => Some(libm::ceil(span.seconds() * rate) as u64 + 2),
        (Some(_), None) => None,
    };
    let count = within.map(|within| within.max(logged.unwrap_or_default()).clamp(least, most));
    let bytes = count.map(|count| count * size_of::<Sample>() as u64);
    Kept { subject, span, count, bytes, rate_per_s, logged: logged.unwrap_or_default() }
}

fn messages<'a>(subject: Subject, demands: impl Iterator<Item = &'a Demand>, most: u64) -> Kept {
    let (span, logged) = longest(demands);
    let logged = logged.unwrap_or_default();
    let count = if span == Some(Duration::ZERO) && logged > 0 { logged.min(most) } else { most };
    let bytes = Some(count * size_of::<Occurrence>() as u64);
    Kept { subject, span, count: Some(count), bytes, rate_per_s: None, logged }
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

impl Kept {
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
        let rate = self.rate_per_s.map(|rate| format!(" at {rate} a second")).unwrap_or_default();
        format!("{}: {span}{rate}; {amount}", self.subject)
    }
}

/// The report of `apex check --memory`: what is kept, because of which clauses, and which of them have no bound.
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
