//! The head of a TSPLIB file: keys with values.

use super::super::distance::Metric;
use super::super::instance::ProblemKind;
use super::super::pose;
use super::super::words::{self, TextToken};
use super::HELP;
use crate::format_error::FormatError;

/// Data that the head states.
#[derive(Default)]
pub(super) struct Header {
    pub(super) name: Option<String>,
    pub(super) question: Option<ProblemKind>,
    /// Number of nodes, the depot included.
    pub(super) dimension: Option<usize>,
    /// The metric; `Some(None)` where weights are given as numbers.
    pub(super) metric: Option<Option<Metric>>,
    /// Layout of weights.
    pub(super) layout: Option<String>,
    /// The longest tour of an orienteering problem.
    pub(super) limit: Option<f64>,
}

/// Returns the key and the value of the line that `first` begins.
pub(super) fn split(first: &TextToken<'_>) -> (String, String) {
    let line = first.whole_line.trim_start_matches('\u{feff}');
    let (key, value) = match line.split_once(':') {
        Some((key, value)) => (key, value),
        None => line.trim().split_once(char::is_whitespace).unwrap_or((line.trim(), "")),
    };
    (key.trim().to_uppercase(), value.trim().to_string())
}

impl Header {
    /// Stores the value of one key.
    pub(super) fn set(&mut self, key: &str, value: String, at: &TextToken<'_>) -> Result<(), FormatError> {
        let upper = value.to_uppercase();
        // Mistakes are shown where the value begins.
        let column = at.whole_line.find(value.as_str()).filter(|_| !value.is_empty());
        let chars = column.and_then(|column| at.whole_line.get(..column)).map(|before| before.chars().count() + 1);
        let word = TextToken { text: value.as_str(), column: chars.unwrap_or(at.column), ..*at };
        match key {
            "NAME" => self.name = Some(words::cut(&value)).filter(|name| !name.is_empty()),
            "COMMENT" | "NODE_COORD_TYPE" | "DISPLAY_DATA_TYPE" => {}
            "TYPE" => self.question = Some(question(&upper, &word)?),
            "DIMENSION" => {
                let count = word.count("DIMENSION, the number of nodes", usize::MAX >> 12)?;
                pose::check_count(count.saturating_sub(1), &word)?;
                self.dimension = Some(count);
            }
            "COST_LIMIT" => self.limit = Some(word.amount("COST_LIMIT, the longest tour")?),
            "EDGE_WEIGHT_TYPE" if upper == "EXPLICIT" => self.metric = Some(None),
            "EDGE_WEIGHT_TYPE" => {
                let unknown = || {
                    let reason = "supported types are EUC_2D, CEIL_2D, MAN_2D, MAX_2D, ATT, GEO and EXPLICIT";
                    word.trouble(format!("unknown edge weight type {}", words::cut(&upper)), reason, HELP)
                };
                self.metric = Some(Some(Metric::of(&upper).ok_or_else(unknown)?));
            }
            "EDGE_WEIGHT_FORMAT" => self.layout = Some(upper).filter(|layout| layout != "FUNCTION"),
            _ => {
                let reason = "a key that is not known may change the problem";
                return Err(at.trouble(format!("{} is not known", words::cut(key)), reason, HELP));
            }
        }
        Ok(())
    }
}

fn question(value: &str, at: &TextToken<'_>) -> Result<ProblemKind, FormatError> {
    match value.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default() {
        "TSP" | "ATSP" => Ok(ProblemKind::Tour),
        "OP" => Ok(ProblemKind::Orienteering),
        _ => {
            let reason = "supported types are TSP, ATSP and OP";
            Err(at.trouble(format!("problems of type {} are not planned for", words::cut(value)), reason, HELP))
        }
    }
}
