//! Clauses that procedures, steps and primitives share: transitions, hooks, profiles, logging.

use super::Lowering;
use super::clauses::groups;
use super::constraint::relation_named;
use super::slips::foreign_relation;
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::fix::Fix;
use crate::read::{Datum, DatumKind};
use apex_model::condition::Condition;
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::ResourceKind;
use apex_model::procedure::{Hooks, LogPolicy, ResourceNeed, Transitions};
use apex_model::time::Duration;
use apex_model::value::Value;

impl Lowering {
    /// Lowers `(end-when C)`, `(terminate (when C))`, `(suspend-when C until C)`, `(suspend (when C) (until C))` and the like.
    pub(crate) fn transition(&mut self, clause: &Datum, transitions: &mut Transitions) -> Option<()> {
        let name = clause.head_name();
        let items = clause.tail();
        let (when, until) = match items {
            [when] if when.head_name() == "when" => (when.tail(), None),
            [when, until] if when.head_name() == "when" && until.head_name() == "until" => {
                (when.tail(), Some(until.tail()))
            }
            // The conditions say by their own words which is which, so that their order does not matter.
            [until, when] if until.head_name() == "until" && when.head_name() == "when" => {
                (when.tail(), Some(until.tail()))
            }
            [when, word, until] if word.is("until") => (std::slice::from_ref(when), Some(std::slice::from_ref(until))),
            [when, until] if until.head_name() == "until" => (std::slice::from_ref(when), Some(until.tail())),
            [word, when] if word.is("when") => (std::slice::from_ref(when), None),
            all => (all, None),
        };
        let is_suspend = name.starts_with("suspend");
        if when.is_empty() || (until.is_some() && !is_suspend) {
            let shape = if is_suspend { "(suspend-when CONDITION [until CONDITION])" } else { "(end-when CONDITION)" };
            let shape = match name {
                "terminate" => "(terminate (when CONDITION))".to_string(),
                "end-when" => shape.to_string(),
                _ if is_suspend => shape.to_string(),
                _ => format!("({name} CONDITION)"),
            };
            return self.missing_part(clause.span, &format!("this `{name}` has the wrong parts"), &shape);
        }
        let condition = self.clause_condition(name, when, clause)?;
        let slot = match name {
            "end-when" | "terminate" => &mut transitions.end_when,
            "exit-when" => &mut transitions.exit_when,
            "skip-when" => &mut transitions.skip_when,
            "restart" | "restart-when" => &mut transitions.restart_when,
            "resume" | "resume-when" => &mut transitions.resume_when,
            _ => &mut transitions.suspend_when,
        };
        if slot.replace(Box::new(condition)).is_some() {
            let diagnostic = Diagnostic::error(
                codes::CLAUSE_TWICE,
                clause.span,
                format!("`{name}` repeats a clause that changes the state of this task"),
            )
            .reason("the same clause is here already in another spelling")
            .help("keep one of them, or join the conditions with `(:or ..)`");
            return self.refuse(diagnostic);
        }
        if let Some(until) = until {
            transitions.suspend_until = Some(Box::new(self.clause_condition(name, until, clause)?));
        }
        Some(())
    }

    /// Returns the single condition of a clause; `:quality Q` may follow an episode.
    fn clause_condition(&mut self, name: &str, items: &[Datum], clause: &Datum) -> Option<Condition> {
        let lowered = self.conditions(items)?;
        let mut lowered = self.clause_conditions(lowered, clause.span);
        match (lowered.pop(), lowered.is_empty()) {
            (Some(condition), true) => Some(condition),
            _ => {
                let diagnostic = Diagnostic::error(
                    codes::MALFORMED,
                    super::span_of(items, clause.span),
                    format!("`{name}` takes one condition"),
                )
                .help("join them: `(:and ..)` or `(:or ..)`");
                self.refuse(diagnostic)
            }
        }
    }

    /// Lowers a hook clause and adds its forms, which may have effects, to `hooks`.
    pub(crate) fn hook(&mut self, clause: &Datum, hooks: &mut Hooks) -> Option<()> {
        let forms = self.body(clause.tail())?;
        match clause.head_name() {
            "on-end" => hooks.on_end.extend(forms),
            "on-suspend" => hooks.on_suspend.extend(forms),
            "on-resume" => hooks.on_resume.extend(forms),
            _ => hooks.on_start.extend(forms),
        }
        Some(())
    }

    /// Lowers `(profile NAME.. (NAME AMOUNT)..)`.
    pub(crate) fn profile(&mut self, clause: &Datum) -> Option<Vec<ResourceNeed>> {
        let (options, entries): (Vec<&Datum>, Vec<&Datum>) =
            clause.tail().iter().partition(|item| item.is(":refuse-if-busy"));
        let refuse_if_busy = !options.is_empty();
        let entries: Vec<Datum> = entries.into_iter().cloned().collect();
        if let ([option, ..], []) = (options.as_slice(), entries.as_slice()) {
            let diagnostic = Diagnostic::error(codes::MALFORMED, option.span, "`:refuse-if-busy` has no resources");
            return self.refuse(diagnostic.help("name them before it: `(profile camera-1 :refuse-if-busy)`"));
        }
        self.all(&entries, |lowering, item| {
            let place = item.span.place();
            match &item.kind {
                DatumKind::Symbol(name) if matches!(name.folded(), "t" | "nil" | "true" | "false") => {
                    let diagnostic = Diagnostic::error(codes::MALFORMED, item.span, format!("`{name}` is not a resource"))
                        .reason("`:refuse-if-busy` is an option without a value, and a profile names resources")
                        .fix(Fix::safe("remove it").replace(item.span, ""));
                    lowering.refuse(diagnostic)
                }
                DatumKind::Symbol(name) if name.folded().starts_with(':') => {
                    let message = format!("`{name}` is neither a resource nor an option of a profile");
                    let diagnostic = Diagnostic::error(codes::MALFORMED, item.span, message)
                        .reason("a task waits until it is granted all of its profile")
                        .help("to fail rather than wait write `:refuse-if-busy`; to stop waiting after a time, `(end-when (:delay 10s))`");
                    lowering.refuse(diagnostic)
                }
                DatumKind::Symbol(_) | DatumKind::Variable(_) | DatumKind::Bound(_) | DatumKind::Indexical(_) => {
                    let resource = lowering.template(item)?;
                    Some(ResourceNeed { resource, amount: None, refuse_if_busy, place })
                }
                DatumKind::List(parts) => match parts.as_slice() {
                    [name, amount] => {
                        lowering.check_amount(name, amount)?;
                        let resource = lowering.template(name);
                        let amount = lowering.pure_expression(amount, "a profile clause");
                        Some(ResourceNeed { resource: resource?, amount: Some(amount?), refuse_if_busy, place })
                    }
                    _ => lowering.missing_part(item.span, "a resource has the wrong parts", "NAME or (NAME AMOUNT)"),
                },
                _ => lowering.missing_part(item.span, "this is not a resource", "NAME or (NAME AMOUNT)"),
            }
        })
    }

    fn check_amount(&mut self, name: &Datum, amount: &Datum) -> Option<()> {
        let Some(symbol) = name.as_symbol() else { return Some(()) };
        let severity = self.undefined();
        match self.names.resources.get(symbol) {
            Some((ResourceKind::Unitary, span)) => {
                let message = format!("resource `{symbol}` has no amount: one task at a time holds all of it");
                let diagnostic = Diagnostic::error(codes::RESOURCE_AMOUNT, amount.span, message)
                    .label(*span, "declared here")
                    .help(format!("declare `(resource {symbol} :capacity N)` or `(resource {symbol} :depletable Q)`"));
                self.refuse(diagnostic)
            }
            None => {
                let message = format!("an amount is asked of `{symbol}`, which is not declared");
                let diagnostic = Diagnostic::new(severity, codes::RESOURCE_AMOUNT, amount.span, message)
                    .help(format!("declare `(resource {symbol} :capacity N)` or `(resource {symbol} :depletable Q)`"));
                self.report(diagnostic);
                self.fragment.then_some(())
            }
            Some((ResourceKind::Depletable(total) | ResourceKind::Renewable(total), span)) => {
                let (wanted, found) = (total.as_number(), amount.to_value().as_number());
                match (wanted, found) {
                    (Some((_, wanted)), Some((_, found))) if wanted != found => {
                        let message = format!("resource `{symbol}` is measured in {wanted}, but this is {found}");
                        let diagnostic = Diagnostic::error(codes::DIMENSION, amount.span, message)
                            .label(*span, format!("declared as {total} here"));
                        self.refuse(diagnostic)
                    }
                    _ => Some(()),
                }
            }
            Some((ResourceKind::Capacity(_), _)) => Some(()),
        }
    }

    /// Lowers `(log (ATTR OBJ)..)` and `(log ((ATTR OBJ) :frequency-limit D ..)..)`; for messages `(:events HEAD)` replaces `(ATTR OBJ)`.
    pub(crate) fn log(&mut self, clause: &Datum) -> Option<Vec<LogPolicy>> {
        self.all(clause.tail(), |lowering, item| {
            let nested = Lowering::is_nested(item);
            let (subject, options) = match item.as_list().and_then(<[Datum]>::split_first) {
                Some((subject, options)) if nested => (subject, options),
                Some(_) => (item, [].as_slice()),
                None => {
                    return lowering.missing_part(
                        item.span,
                        "a log policy names a state variable or messages",
                        "(log (ATTRIBUTE OBJECT) (:events WORD) ..)",
                    );
                }
            };
            let (stray, options) = groups(options);
            lowering.no_stray(stray)?;
            lowering.check_groups(&options, &["frequency-limit", "time-limit", "count-limit"], "`log`")?;
            let frequency = lowering.optional(&options, "frequency-limit", Lowering::log_span)?;
            let time = lowering.optional(&options, "time-limit", Lowering::log_span)?;
            let count = lowering.optional(&options, "count-limit", |lowering, datum| match datum.kind {
                DatumKind::Integer(count) if count > 0 => u64::try_from(count).ok(),
                _ => {
                    let message = "a count limit is a whole number of samples or messages, 1 or more";
                    let diagnostic = Diagnostic::error(codes::NOTHING_TO_LOG, datum.span, message)
                        .help("leave it out to keep all, or write how many: `:count-limit 5000`");
                    lowering.refuse(diagnostic)
                }
            })?;
            lowering.logged_messages(subject)?;
            lowering.logged_variable(subject)?;
            let subject = lowering.template(subject)?;
            Some(LogPolicy { subject, frequency_limit: frequency, time_limit: time, count_limit: count })
        })
    }

    /// Checks that logged messages are named by their first word.
    fn logged_messages(&mut self, subject: &Datum) -> Option<()> {
        let Some((first, rest)) = subject.as_list().and_then(<[Datum]>::split_first) else { return Some(()) };
        if !first.is(":events") {
            return Some(());
        }
        let word = |datum: &Datum| datum.as_symbol().is_some_and(|symbol| !symbol.folded().starts_with(':'));
        match rest {
            [one] if word(one) => Some(()),
            _ => {
                let message = "`:events` is followed by the first word of the messages, and nothing else";
                let help = "write one word, and a policy for each: `(log (:events arrived) (:events left))`";
                self.refuse(Diagnostic::error(codes::NOTHING_TO_LOG, subject.span, message).help(help))
            }
        }
    }

    /// Checks that a logged state variable is an attribute with its object, without comparison and without limits.
    fn logged_variable(&mut self, subject: &Datum) -> Option<()> {
        let Some((first, rest)) = subject.as_list().and_then(<[Datum]>::split_first) else { return Some(()) };
        let text = |datum: &Datum| self.text_at(datum.span).unwrap_or("..").to_string();
        let keyword = |datum: &&Datum| datum.as_symbol().is_some_and(|symbol| symbol.folded().starts_with(':'));
        if first.is(":events") {
            return Some(());
        }
        if keyword(&first) {
            let message = format!("`{}` has no meaning in `log`", text(first));
            return self.missing_part(first.span, &message, "(log (ATTRIBUTE OBJECT) (:events WORD) ..)");
        }
        let variable = match rest.first().filter(|object| !keyword(object)) {
            Some(object) => format!("({} {})", text(first), text(object)),
            None => format!("({} OBJECT)", text(first)),
        };
        if let Some(limit) = rest.iter().find(keyword) {
            let options: Vec<String> = rest.iter().skip_while(|datum| !keyword(datum)).map(text).collect();
            let shape = format!("(log ({variable} {}))", options.join(" "));
            return self.missing_part(
                limit.span,
                "write the limits of a log after its state variable, in brackets",
                &shape,
            );
        }
        let number = |datum: &&Datum| matches!(datum.kind, DatumKind::Integer(_) | DatumKind::Real(_));
        let compares = |datum: &&Datum| relation_named(datum).is_some() || foreign_relation(datum);
        let stray = [first].into_iter().chain(rest).find(compares).or(rest.get(1).filter(number));
        if let Some(stray) = stray {
            let shape =
                if compares(&first) { "(log (ATTRIBUTE OBJECT))".to_string() } else { format!("(log {variable})") };
            let message = "a log keeps the samples of a state variable, whatever their values: it has no comparison";
            return self.missing_part(stray.span, message, &shape);
        }
        if rest.is_empty() {
            let message = format!("`{}` is logged without its object", text(first));
            return self.missing_part(subject.span, &message, &format!("(log {variable})"));
        }
        Some(())
    }

    /// Returns a duration in a clause `log`, which must be greater than zero.
    fn log_span(&mut self, datum: &Datum) -> Option<Duration> {
        let span = self.literal_duration(datum)?;
        if span > Duration::ZERO {
            return Some(span);
        }
        let message = format!("the limit of a log is {span}, expected a duration above zero");
        let help = "leave it out, or write a duration above zero: `:frequency-limit 1s`, `:time-limit P10M`";
        self.refuse(Diagnostic::error(codes::NOTHING_TO_LOG, datum.span, message).help(help))
    }

    /// Returns a constant duration; a frequency means its interval.
    pub(crate) fn literal_duration(&mut self, datum: &Datum) -> Option<Duration> {
        let expr: Expr = self.interval_or_frequency(datum)?;
        match expr.kind {
            ExprKind::Constant(Value::Duration(duration)) => Some(duration),
            _ => {
                let diagnostic =
                    Diagnostic::error(codes::DURATION_EXPECTED, datum.span, "a literal duration is needed here")
                        .help("write a duration with its unit: `5s`, `P1M30S`, `(1 hr 30 min)`");
                self.refuse(diagnostic)
            }
        }
    }
}
