//! Measurement conditions, estimation, active sensing (`conditions.md`).

use super::Lowering;
use super::clauses::{KeywordGroup, groups, values_of};
use super::constraint::relation_named;
use super::expected::{Expected, ExpectedKind};
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::read::{Datum, DatumKind};
use apex_model::condition::{
    Condition, ConditionKind, Constraint, Estimation, MeasurementCondition, Relation, VariablePattern,
};
use apex_model::expression::Expr;
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::value::Value;

impl Lowering {
    /// Lowers `(ATTR OBJ REL VAL [+/- E])`, which contains a relation.
    pub(crate) fn short_measurement(&mut self, datum: &Datum, items: &[Datum]) -> Option<ConditionKind> {
        let (variable, value) = self.variable_with_value(datum, items)?;
        let (object, timestamp) = (Vec::new(), Vec::new());
        let measurement = MeasurementCondition { variable, value, object, timestamp, estimation: None };
        Some(ConditionKind::Measurement(measurement.into()))
    }

    /// `ATTR OBJ.. [REL VAL [+/- E]]..`
    fn variable_with_value(&mut self, datum: &Datum, items: &[Datum]) -> Option<(VariablePattern, Vec<Constraint>)> {
        let split =
            items.iter().skip(1).position(|item| relation_named(item).is_some()).map_or(items.len(), |at| at + 1);
        let (names, mut rest) = items.split_at_checked(split).unwrap_or((items, &[]));
        let variable = self.state_variable(datum, names)?;
        let expected = Expected::values_of(self, &variable.attribute);
        let mut constraints = Vec::new();
        while let Some((head, after)) = rest.split_first() {
            let count = after.iter().position(|item| relation_named(item).is_some()).unwrap_or(after.len());
            let (arguments, next) = after.split_at_checked(count).unwrap_or((after, &[]));
            let relation = relation_named(head)?;
            let span = super::span_of(arguments, head.span);
            constraints.push(self.comparison(relation, arguments, span, &expected)?);
            rest = next;
        }
        Some((variable, constraints))
    }

    /// Lowers `ATTR OBJ..` to a pattern over state variables.
    fn state_variable(&mut self, datum: &Datum, names: &[Datum]) -> Option<VariablePattern> {
        let Some((Datum { kind: DatumKind::Symbol(attribute), .. }, objects)) = names.split_first() else {
            let diagnostic =
                Diagnostic::error(codes::MALFORMED_CONDITION, datum.span, "a state variable begins with its attribute")
                    .help("its shape is `(ATTRIBUTE OBJECT)`, for example `(altitude +self+)`");
            return self.refuse(diagnostic);
        };
        self.refuse_expression(attribute, objects, datum.span)?;
        let object = match objects {
            [] => Pattern::Literal(Value::nil()),
            [one] => self.pattern(one)?,
            several => {
                let list = Datum { kind: DatumKind::List(several.to_vec()), span: super::span_of(several, datum.span) };
                self.pattern(&list)?
            }
        };
        Some(VariablePattern { attribute: attribute.clone(), object })
    }

    /// Returns a state variable in the form used in episodes.
    pub(crate) fn plain_state_variable(&mut self, datum: &Datum) -> Option<VariablePattern> {
        let items = datum.as_list().unwrap_or_default();
        if let Some(relation) = items.iter().skip(1).position(|item| relation_named(item).is_some()) {
            return self.refuse_comparison(items, relation + 1);
        }
        self.state_variable(datum, items)
    }

    /// Rejects `(ATTR OBJ > 4)` where a state variable is named without a comparison: the words would be parts of its object.
    fn refuse_comparison<T>(&mut self, items: &[Datum], relation: usize) -> Option<T> {
        let (name, compared) = items.split_at_checked(relation).unwrap_or_default();
        let span = |items: &[Datum]| Some(items.first()?.span.to(items.last()?.span));
        let text = |items: &[Datum]| span(items).and_then(|span| self.text_at(span)).unwrap_or("..").to_string();
        let object = if name.len() < 2 { " OBJECT" } else { "" };
        let help =
            format!("write `({}{object})`, and the comparison as an option: `:value ({})`", text(name), text(compared));
        let span = span(compared).or_else(|| span(items))?;
        let diagnostic =
            Diagnostic::error(codes::MALFORMED_CONDITION, span, "a state variable is named here, not compared")
                .reason("these words would be parts of its object, so no sample would satisfy this")
                .help(help);
        self.refuse(diagnostic)
    }

    /// Lowers `(:measurement [tag] (ATTR OBJ [= VAL]) [:value C..] [:object C..] [:timestamp C..] [:estimation E])`.
    pub(crate) fn measurement(&mut self, datum: &Datum, items: &[Datum]) -> Option<Condition> {
        let (tag, items) = self.condition_tag(items);
        let Some((form, options)) = items.split_first().filter(|(form, _)| form.as_list().is_some()) else {
            let diagnostic =
                Diagnostic::error(codes::MALFORMED_CONDITION, datum.span, "a `:measurement` names a state variable")
                    .help(
                        "its shape is `(:measurement [tag] (ATTRIBUTE OBJECT [= VALUE]) [:timestamp CONSTRAINT..] ..)`",
                    );
            return self.refuse(diagnostic);
        };
        if self.report_missing_colon(options, &["value", "object", "timestamp", "estimation"], "a measurement") {
            return None;
        }
        let (stray, options) = groups(options);
        self.no_stray(stray)?;
        self.check_groups(&options, &["value", "object", "timestamp", "estimation", "probing"], "`:measurement`")?;
        let head = self.variable_with_value(form, form.as_list().unwrap_or_default());
        let (variable, mut value) = head?;
        let expected = Expected::values_of(self, &variable.attribute);
        let more = self.constraints(values_of(&options, "value"), &expected);
        let object = self.constraints(values_of(&options, "object"), &Expected::anything());
        let instant = Expected::plain("the time stamp", ExpectedKind::Instant);
        let timestamp = self.constraints(values_of(&options, "timestamp"), &instant);
        let estimation = self.optional(&options, "estimation", |lowering, datum| lowering.estimation(datum, &expected));
        value.extend(more?);
        let measurement =
            MeasurementCondition { variable, value, object: object?, timestamp: timestamp?, estimation: estimation? };
        self.check_solvable(&measurement, datum.span)?;
        let condition =
            Condition { tag, kind: ConditionKind::Measurement(measurement.into()), place: datum.span.place() };
        self.probing(condition, &options)
    }

    /// Rejects data between a condition's variable and its options.
    pub(crate) fn no_stray(&mut self, stray: &[Datum]) -> Option<()> {
        let Some(first) = stray.first() else { return Some(()) };
        let diagnostic = Diagnostic::error(codes::MALFORMED_CONDITION, first.span, "this belongs to no option")
            .help("options are keywords with their values: `:value (> 5)`");
        self.refuse(diagnostic)
    }

    /// Checks that a condition with an estimator can be solved: an estimator has a value at every instant, so the constraints must state
    /// which instants and, on a line, which values satisfy the condition.
    fn check_solvable(&mut self, measurement: &MeasurementCondition, span: Span) -> Option<()> {
        let is_bound = |constraint: &Constraint| match constraint {
            Constraint::Compare { relation, .. } => *relation != Relation::Different,
            Constraint::Range(..) => true,
            Constraint::Matches(_) | Constraint::Predicate(..) => false,
        };
        let is_value = |constraint: &Constraint| {
            is_bound(constraint)
                || matches!(constraint, Constraint::Matches(Pattern::Variable(_) | Pattern::BoundVariable(_)))
        };
        let what = match &measurement.estimation {
            None => return Some(()),
            Some(_) if !measurement.timestamp.iter().all(is_bound) => "the time of an estimated value",
            Some(Estimation::LinearRegression(_)) if !measurement.value.iter().all(is_value) => "the value of a line",
            Some(_) => return Some(()),
        };
        let message = format!("{what} is constrained in a way that cannot be solved");
        let diagnostic = Diagnostic::error(codes::UNSOLVABLE, span, message)
            .reason(
                "an estimator has a value at every instant, and the first that satisfies the constraints is computed",
            )
            .help("bound it by comparisons (`< <= = >= >`) and ranges");
        self.refuse(diagnostic)
    }

    fn estimation(&mut self, datum: &Datum, expected: &Expected) -> Option<Estimation> {
        let name = datum.keyword().or_else(|| datum.as_list().and_then(<[Datum]>::first).and_then(Datum::keyword));
        let (stray, options) = groups(datum.tail());
        self.no_stray(stray)?;
        match name {
            Some("persist") => {
                self.check_groups(&options, &["with-timeout"], "`:persist`")?;
                let timeout = self.optional(&options, "with-timeout", Lowering::span_of_time)?;
                Some(Estimation::Persist(timeout))
            }
            Some("linear-regression") => self.regression(&options, datum.span, expected),
            _ => {
                let diagnostic = Diagnostic::error(codes::MALFORMED_CONDITION, datum.span, "unknown estimator")
                    .help("estimators are `:persist`, `(:persist :with-timeout D)` and `:linear-regression`");
                self.refuse(diagnostic)
            }
        }
    }

    fn regression(&mut self, options: &[KeywordGroup<'_>], span: Span, expected: &Expected) -> Option<Estimation> {
        const KNOWN: &[&str] =
            &["minimum-points", "maximum-error", "maximum-difference", "minimum-frequency", "start", "end"];
        self.check_groups(options, KNOWN, "`:linear-regression`")?;
        self.needs_numbers("a line through the values", span, expected)?;
        let mut lowered = Vec::new();
        for group in options {
            let datum = self.only(&format!(":{}", group.name), group.values, group.span)?;
            let expr = match group.name {
                "minimum-frequency" => self.interval_or_frequency(datum)?,
                name => {
                    let expected = match name {
                        "minimum-points" => Expected::number("the number of points"),
                        "start" | "end" => Expected::plain("this end of the fit interval", ExpectedKind::Instant),
                        _ => expected.named(&name.replace('-', " ")),
                    };
                    let expr = self.expression(datum)?;
                    self.conform(expr, datum.span, &expected)?
                }
            };
            lowered.push((Symbol::new(group.name), expr));
        }
        Some(Estimation::LinearRegression(lowered))
    }

    /// Wraps a condition that has a `:probing (GOAL INTERVAL [:time-limit D] [:count-limit n])` option.
    pub(crate) fn probing(&mut self, condition: Condition, options: &[KeywordGroup<'_>]) -> Option<Condition> {
        let Some(group) = options.iter().find(|group| group.name == "probing") else { return Some(condition) };
        let datum = self.only(":probing", group.values, group.span)?;
        let (before, limits) = groups(datum.as_list().unwrap_or_default());
        let [goal, interval] = before else {
            let diagnostic =
                Diagnostic::error(codes::MALFORMED_CONDITION, datum.span, "`:probing` has the wrong parts")
                    .help("its shape is `:probing (GOAL INTERVAL [:time-limit D] [:count-limit N])`");
            return self.refuse(diagnostic);
        };
        self.check_groups(&limits, &["time-limit", "count-limit"], "`:probing`")?;
        let goal_template = self.goal(goal);
        let interval = self.duration(interval);
        let time_limit = self.optional(&limits, "time-limit", Lowering::duration);
        let count_limit = self.optional(&limits, "count-limit", Lowering::expression);
        let place = condition.place;
        let kind = ConditionKind::Probing {
            condition: Box::new(condition),
            goal: goal_template?,
            interval: interval?,
            time_limit: time_limit?,
            count_limit: count_limit?,
        };
        Some(Condition { tag: None, kind, place })
    }

    /// Lowers an expression where a span is needed for messages.
    pub(crate) fn pure_expression(&mut self, datum: &Datum, place: &'static str) -> Option<Expr> {
        self.pure(place, |lowering| lowering.expression(datum))
    }

    /// Returns the interval between samples, from a frequency or an interval.
    pub(crate) fn interval_or_frequency(&mut self, datum: &Datum) -> Option<Expr> {
        use apex_model::quantity::Dimension;
        if let DatumKind::Quantity(quantity) = &datum.kind
            && quantity.dimension == Dimension::FREQUENCY
            && quantity.si > 0.0
        {
            let interval = Value::Duration(apex_model::time::Duration::from_seconds(1.0 / quantity.si));
            return Some(super::expression::constant(interval, datum.span));
        }
        self.duration(datum)
    }

    /// Reports a required part that is missing.
    pub(crate) fn missing_part<T>(&mut self, span: Span, message: &str, shape: &str) -> Option<T> {
        let diagnostic = Diagnostic::error(codes::MALFORMED, span, message).help(format!("its shape is `{shape}`"));
        self.refuse(diagnostic)
    }
}
