//! Results of conditions for operators and for programs.

use apex_executive::state::monitors::monitor::{Unmet, Verdict};
use apex_executive::{Judgement, MonitorResult, ResultEvent, SamplingGap};
use apex_model::because::Evidence;
use apex_model::library::Library;
use apex_model::source::Place;
use apex_model::time::Time;
use serde_json::{Value as Json, json};
use std::fmt::Write;
use time::format_description::well_known::Rfc3339;

/// Style of reports about results.
#[derive(Clone, Copy)]
pub struct Style {
    /// As JSON.
    pub json: bool,
    /// Also reports results that are not final yet, as soon as they are recognised.
    pub live: bool,
    /// True if several conditions are watched: each line then names its condition.
    pub several: bool,
    /// Nanoseconds of UTC at mission time 0: instants are printed in civil time, too.
    pub utc_of_zero: Option<i64>,
}

impl Style {
    /// Returns a result as one or more lines; `None` if a later result will include it.
    pub fn result(self, result: &MonitorResult) -> Option<String> {
        let number = result.watch.0 + 1;
        let satisfaction = &result.result;
        let (start, end) = satisfaction.interval;
        let evidence: Vec<String> = satisfaction.evidence.iter().map(|evidence| evidence.text()).collect();
        let open = result.telling == ResultEvent::Recognised { open: true };
        if self.json {
            let bindings: serde_json::Map<String, Json> = satisfaction
                .bindings
                .iter()
                .map(|(name, value)| (name.printed().to_string(), Json::String(value.to_string())))
                .collect();
            let telling = if result.telling == ResultEvent::Closed { "closed" } else { "recognised" };
            let mut line = json!({
                "condition": number, "telling": telling, "open": open, "start_s": start.seconds(),
                "end_s": end.seconds(), "recognised_at_s": satisfaction.recognised_at.seconds(), "start_ns": start.0,
                "end_ns": end.0, "duration_ns": (end - start).0, "recognised_at_ns": satisfaction.recognised_at.0,
                "bindings": bindings,
                "evidence": evidence, "gaps": result.gaps.iter().map(gap_json).collect::<Vec<Json>>(),
            });
            if let Some(object) = line.as_object_mut() {
                let instants =
                    [("start_utc", start), ("end_utc", end), ("recognised_at_utc", satisfaction.recognised_at)];
                object.extend(
                    instants.into_iter().filter_map(|(name, at)| Some((name.to_string(), self.utc(at)?.into()))),
                );
            }
            return Some(format!("{line}\n"));
        }
        if open && !self.live {
            return None;
        }
        let mut text = if self.several { format!("{number}: ") } else { String::new() };
        if start == end {
            let _ = write!(text, "at {start}");
        } else {
            let _ = write!(text, "{start} to {end} ({:.3} s)", (end - start).seconds());
        }
        if let (Some(from), Some(to)) = (self.utc(start), self.utc(end)) {
            let _ = if start == end { write!(text, " [{from}]") } else { write!(text, " [{from} to {to}]") };
        }
        let known_at = satisfaction.recognised_at;
        let _ = match result.telling {
            ResultEvent::Recognised { open: true } => write!(text, ", recognised at {known_at}, continues"),
            _ if known_at == end && start == end => Ok(()),
            _ => write!(text, ", recognised at {known_at}"),
        };
        let bindings: Vec<String> =
            satisfaction.bindings.iter().map(|(name, value)| format!("?{name} = {value}")).collect();
        if !bindings.is_empty() {
            let _ = write!(text, ", {}", bindings.join(", "));
        }
        let _ = writeln!(text, "\n  because {}", evidence.join(", "));
        for gap in result.gaps.iter().filter(|gap| is_long(gap, &satisfaction.evidence)) {
            let _ = writeln!(
                text,
                "  no sample of {} for {:.3} s, from {} to {}",
                gap.variable,
                gap.length().seconds(),
                gap.start,
                gap.end
            );
        }
        Some(text)
    }

    /// Returns the instant in civil time (ISO 8601); `None` if it is unknown or not requested.
    fn utc(self, at: Time) -> Option<String> {
        let nanoseconds = i128::from(self.utc_of_zero?) + i128::from(at.0);
        time::OffsetDateTime::from_unix_timestamp_nanos(nanoseconds).ok()?.format(&Rfc3339).ok()
    }

    /// Returns the status of a condition at the end.
    pub fn verdict(self, number: u64, judgement: &Judgement, now: Time) -> String {
        let word = verdict_word(&judgement.verdict);
        if self.json {
            let because: Vec<Json> = judgement.because.iter().map(unmet_json).collect();
            let line = json!({
                "condition": number, "verdict": word, "results": judgement.results, "until_s": now.seconds(),
                "until_ns": now.0, "because": because,
            });
            return format!("{line}\n");
        }
        let mut text = if self.several { format!("{number}: ") } else { String::new() };
        let results = match judgement.results {
            1 => "1 result".to_string(),
            several => format!("{several} results"),
        };
        let _ = writeln!(text, "{word} up to {now}, {results}");
        for Unmet { what, now, since, .. } in &judgement.because {
            let since = since.map(|since| format!(", since {since}")).unwrap_or_default();
            let colon = if now.is_empty() { "" } else { ": " };
            let _ = writeln!(text, "  {what}{colon}{now}{since}");
        }
        text
    }
}

/// Returns true if the gap gets a line for operators: more than twice the mean spacing of the samples of its run.
fn is_long(gap: &SamplingGap, evidence: &[Evidence]) -> bool {
    evidence.iter().any(|fact| match fact {
        Evidence::Run { variable, start, end, samples } if *variable == gap.variable && *end >= gap.end => {
            let spacings = samples.saturating_sub(1).max(1) as f64;
            *start <= gap.start && gap.length().seconds() > 2.0 * (*end - *start).seconds() / spacings
        }
        _ => false,
    })
}

fn gap_json(gap: &SamplingGap) -> Json {
    json!({
        "variable": gap.variable.to_string(), "start_s": gap.start.seconds(), "end_s": gap.end.seconds(),
        "length_s": gap.length().seconds(), "start_ns": gap.start.0, "end_ns": gap.end.0, "length_ns": gap.length().0,
    })
}

/// Returns a verdict in the words of programs and `--expect`.
pub fn verdict_word(verdict: &Verdict) -> &'static str {
    match verdict {
        Verdict::Satisfied(_) => "satisfied",
        Verdict::NotSatisfied => "not-satisfied",
        Verdict::Unknown => "unknown",
    }
}

fn unmet_json(unmet: &Unmet) -> Json {
    json!({
        "what": unmet.what, "now": unmet.now, "since_s": unmet.since.map(Time::seconds),
        "until_s": unmet.until.map(Time::seconds),
    })
}

/// Returns a message with its place in a text, where it has one.
pub fn placed(message: &str, place: Option<Place>, library: &Library) -> String {
    match place {
        Some(place) => format!("{}: {message}", library.describe_place(place)),
        None => message.to_string(),
    }
}
