//! Query retention (M&I)
//! What: determines the history that a query needs, if its text determines the window.
//! Runs: once, when an agent is loaded.
//! Reads: library.
//! Writes: the demands of a survey.
//! Bound: O(arguments).
//! PDL: `value-at`, `samples-over`, `mean-over`, `events-over`, ..
//! Paper: section IV, policies on logged data quantity.

use crate::expression::history_queries::QUERIES;
use crate::monitoring::memory::demand::{Reach, Subject, Why};
use crate::monitoring::memory::reach;
use crate::monitoring::memory::retention::Survey;
use apex_forms::print::Style::Brief;
use apex_model::expression::{Expr, ExprKind};
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use apex_model::value::Value;

impl Survey<'_> {
    /// Adds the demand of a query of messages: its window.
    fn event_query(&mut self, arguments: &[Expr], whole: &Expr) {
        let (text, place) = (|| Brief.expression(whole), whole.place);
        let asked = match arguments {
            [_, window] | [_, window, _] => {
                reach::duration(window, self.library).or_else(|| reach::before_now(window, self.library))
            }
            _ => None,
        };
        let (reach, why) = match asked {
            Some(span) => (Reach::Span(span), Why::Window),
            None => (Reach::Unbounded, Why::QueryTime),
        };
        match arguments.first().map(|argument| &argument.kind) {
            Some(ExprKind::Constant(Value::Symbol(word))) => {
                self.demand(Subject::MessagesOf(word.clone()), reach, why, text, place);
            }
            _ => self.demand(Subject::Messages, reach, why, text, place),
        }
    }

    /// Adds the demand of a query of a history: its window, or no limit if the window is not a literal.
    pub(crate) fn query(&mut self, function: &Symbol, arguments: &[Expr], whole: &Expr) {
        if function.is("events-over") {
            return self.event_query(arguments, whole);
        }
        if !QUERIES.contains(&function.folded()) {
            return;
        }
        let (text, place) = (|| Brief.expression(whole), whole.place);
        let asked = match (function.folded(), arguments) {
            ("most-recent-svvalue", [_, _]) => Some(Duration::ZERO),
            ("most-recent-svvalue", [_, _, _, prior_to]) => reach::before_now(prior_to, self.library),
            ("mean-over" | "min-over" | "max-over" | "samples-over", [_, _, window]) => {
                reach::duration(window, self.library).or_else(|| reach::before_now(window, self.library))
            }
            (_, [_, _, instant] | [_, _, instant, _]) => reach::before_now(instant, self.library),
            _ => None,
        };
        let (reach, why) = match asked {
            Some(span) => (Reach::Span(span), Why::Window),
            None => (Reach::Unbounded, Why::QueryTime),
        };
        match arguments.first().map(|argument| &argument.kind) {
            Some(ExprKind::Constant(Value::Symbol(attribute))) => {
                self.demand(Subject::Attribute(attribute.clone()), reach, why, text, place);
            }
            _ => {
                let why = if reach == Reach::Unbounded { Why::QueryVariable } else { why };
                self.demand(Subject::EveryAttribute, reach, why, text, place);
            }
        }
    }
}
