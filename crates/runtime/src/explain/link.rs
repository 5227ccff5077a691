//! A link of an explanation: something that happened, why, and what that rests on.

use super::cause::CauseDetail;
use apex_model::time::Time;
use serde::Serialize;
use std::fmt;

/// Something that happened, with what stands behind it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Link {
    /// Instant, in seconds of mission time.
    pub t: f64,
    /// The task, `T3`, if it is about one.
    pub task: Option<String>,
    /// Event: `T3 (photograph fire) started`.
    pub what: String,
    /// The kind of cause; none for what came from outside.
    pub kind: Option<String>,
    /// Reason, as text; empty for inputs from outside.
    pub because: String,
    /// The cause with its parts; none for what came from outside.
    pub cause: Option<CauseDetail>,
    /// `file:line:column` of the clause of PDL.
    pub place: Option<String>,
    /// The text of that line.
    pub source: Option<String>,
    /// Causes.
    pub causes: Vec<Link>,
    /// There is more below, which the asked depth leaves out.
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

    /// Returns true when something is left out anywhere below.
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
