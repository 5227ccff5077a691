//! Cyclic conditions (`conditions.md`).

use super::Lowering;
use super::clauses::groups;
use super::expected::{Expected, ExpectedKind};
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::read::Datum;
use apex_model::condition::CyclicCondition;
use apex_model::condition::{Condition, ConditionKind};
use apex_model::symbol::Symbol;
use std::sync::Arc;

impl Lowering {
    /// Lowers `(:cyclic [tag] (ATTR OBJ) :period C ..)`.
    pub(crate) fn cyclic(&mut self, datum: &Datum, items: &[Datum]) -> Option<Condition> {
        let (tag, items) = self.condition_tag(items);
        let Some((form, options)) = items.split_first().filter(|(form, _)| form.as_list().is_some()) else {
            let diagnostic = Diagnostic::error(
                codes::MALFORMED_CONDITION,
                datum.span,
                "a `:cyclic` condition names a state variable",
            )
            .help("its shape is `(:cyclic [tag] (ATTRIBUTE OBJECT) :period CONSTRAINT ..)`");
            return self.refuse(diagnostic);
        };
        let (stray, groups) = groups(options);
        self.no_stray(stray)?;
        self.check_groups(&groups, &["period", "amplitude", "cycles", "hysteresis"], "`:cyclic`")?;
        let variable = self.plain_state_variable(form)?;
        let values = Expected::values_of(self, &variable.attribute);
        let mut options = Vec::new();
        for group in groups {
            let expected = match group.name {
                "period" => Expected::plain("the period", ExpectedKind::Duration),
                "cycles" => Expected::number("the number of cycles"),
                _ => values.clone(),
            };
            let constraints = match group.name {
                "hysteresis" => self.one_value(":hysteresis", group.values, datum.span)?,
                _ => self.constraints(group.values, &expected)?,
            };
            options.push((Symbol::new(group.name), constraints));
        }
        if !options.iter().any(|(name, _)| name.is("period")) {
            return self.missing_part(
                datum.span,
                "a `:cyclic` condition states its `:period`",
                "(:cyclic (ATTR OBJ) :period C ..)",
            );
        }
        let kind = ConditionKind::Cyclic(Arc::new(CyclicCondition { variable, options }));
        Some(Condition { tag, kind, place: datum.span.place() })
    }
}
