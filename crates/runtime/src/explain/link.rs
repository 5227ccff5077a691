//! A link of a chain of causes: an event or decision, its cause, and the links on which that rests.

use super::cause::CauseDetail;
use apex_model::time::Time;
use serde::Serialize;
use std::fmt;

/// An event or decision, with the links on which it rests.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Link {
    /// Instant, in seconds of mission time.
    pub t: f64,
    /// The task, `T3`, if the link concerns one.
    pub task: Option<String>,
    /// Its number, 3 for `T3`.
    pub task_number: Option<u64>,
    /// Event: `T3 (photograph fire) started`.
    pub what: String,
    /// The kind of cause; `None` for an input from outside.
    pub kind: Option<String>,
    /// Reason, as text; empty for inputs from outside.
    pub because: String,
    /// The cause with its parts; `None` for an input from outside.
    pub cause: Option<CauseDetail>,
    /// `file:line:column` of the clause of PDL.
    pub place: Option<String>,
    /// The text of that line.
    pub source: Option<String>,
    /// The links on which it rests.
    pub causes: Vec<Link>,
    /// True if further links exist beyond the requested depth.
    pub more: bool,
}

/// Longer lines of source are cut in texts.
const SOURCE_CHARACTERS_MAX: usize = 90;

impl Link {
    /// Returns a link of the chain for an observed fact: a sample, a message or an instant.
    pub(super) fn seen(at: Time, what: String) -> Link {
        Link {
            t: at.seconds(),
            task: None,
            task_number: None,
            what,
            kind: None,
            because: String::new(),
            cause: None,
            place: None,
            source: None,
            causes: Vec::new(),
            more: false,
        }
    }

    /// Returns true if links are left out here or anywhere below.
    pub fn is_cut(&self) -> bool {
        self.more || self.causes.iter().any(Link::is_cut)
    }

    /// Writes the chain, two spaces more for every level.
    pub(super) fn write(&self, f: &mut fmt::Formatter<'_>, indent: usize, above: Option<&str>) -> fmt::Result {
        write!(f, "{:indent$}{}: {}", "", Time::from_seconds(self.t), self.what)?;
        if !self.because.is_empty() {
            write!(f, " because {}", self.because)?;
        }
        let place = self.place.as_deref();
        if let Some(place) = place.filter(|place| Some(*place) != above) {
            write!(f, "; from {place}")?;
            if let Some(source) = &self.source {
                write!(f, " {}", shortened(source))?;
            }
        }
        writeln!(f)?;
        self.causes.iter().try_for_each(|cause| cause.write(f, indent + 2, place.or(above)))?;
        if self.more {
            writeln!(f, "{:1$}..", "", indent + 2)?;
        }
        Ok(())
    }
}

fn shortened(source: &str) -> String {
    match source.char_indices().nth(SOURCE_CHARACTERS_MAX) {
        Some((end, _)) => format!("`{} ..`", source.get(..end).unwrap_or_default().trim_end()),
        None => format!("`{source}`"),
    }
}
