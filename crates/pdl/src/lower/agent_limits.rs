//! The limits of the executive that an agent sets lower for itself: `:limits (:tasks 200 :event-history 50)` (decision 0033).

use super::Lowering;
use super::clauses::{KeywordGroup, groups};
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::read::Datum;
use apex_model::agent_limits::{Limit, Limits};
use apex_model::value::Value;

const SHAPE: &str = ":limits (:tasks 200 :event-history 50)";

impl Lowering {
    /// Lowers `(:NAME NUMBER ..)`.
    pub(crate) fn agent_limits(&mut self, datum: &Datum) -> Option<Limits> {
        let Some((before, options)) = datum.as_list().map(groups) else {
            return self.missing_part(datum.span, "these are not limits", SHAPE);
        };
        if let Some(first) = before.first() {
            return self.missing_part(first.span, "here the name of a limit is expected", SHAPE);
        }
        let words: Vec<&str> = Limit::ALL.iter().map(|limit| limit.word()).collect();
        // Values are checked, too, where some names are refused.
        let mut fine = self.check_groups(&options, &words, "`:limits`").is_some();
        let mut limits = Limits::default();
        for group in options.iter().filter(|group| words.contains(&group.name) && !group.values.is_empty()) {
            match self.lowered_limit(group) {
                Some((limit, value)) => limits.lower(limit, value),
                None => fine = false,
            }
        }
        fine.then_some(limits)
    }

    fn lowered_limit(&mut self, group: &KeywordGroup<'_>) -> Option<(Limit, u64)> {
        let limit = Limit::ALL.into_iter().find(|limit| limit.word() == group.name)?;
        let datum = self.only(&format!(":{}", group.name), group.values, group.span)?;
        let (least, most) = (limit.least(), limit.most());
        match datum.to_value() {
            Value::Integer(number) if u64::try_from(number).is_ok_and(|number| (least..=most).contains(&number)) => {
                Some((limit, number.unsigned_abs()))
            }
            _ => {
                let message = format!("`:{}` is a whole number from {least} to {most}", limit.word());
                let help = format!("the executive's own limit is {most}: an agent may lower it, not raise it");
                self.refuse(Diagnostic::error(codes::MALFORMED, datum.span, message).help(help))
            }
        }
    }
}
