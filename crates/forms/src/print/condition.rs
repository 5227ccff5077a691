//! Conditions as text, each in one canonical form.

use super::layout::{joined, list_text};
use super::style::Style;
use apex_model::condition::{
    Condition, ConditionKind, Constraint, EpisodeCondition, Estimation, MeasurementCondition, Quality, Relation,
    Timing, VariablePattern,
};
use apex_model::expression::Expr;
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::value::Value;

/// The tag and the `:probing` option of a condition, as text; both empty for most.
#[derive(Default)]
struct Extras {
    tag: String,
    probing: String,
}

impl Style {
    /// Returns the condition as text.
    pub fn condition(self, condition: &Condition) -> String {
        self.with_probing(condition, String::new())
    }

    /// Returns the text of the condition with its `:probing` option, which goes inside the form.
    fn with_probing(self, condition: &Condition, probing: String) -> String {
        let tag = condition.tag.as_ref().map_or(String::new(), Symbol::to_string);
        match &condition.kind {
            ConditionKind::Measurement(measurement) => self.measurement_with(measurement, Extras { tag, probing }),
            ConditionKind::Episode(episode) => self.episode_with(episode, Extras { tag, probing }),
            ConditionKind::And(parts, constraints) => self.composite(":and", tag, parts, None, constraints),
            ConditionKind::Or(parts, constraints) => self.composite(":or", tag, parts, None, constraints),
            ConditionKind::InOrder(parts, constraints) => self.composite(":in-order", tag, parts, None, constraints),
            ConditionKind::Allen { relation, parts, tolerance, constraints } => {
                let head = format!(":{}", relation.word());
                self.composite(&head, tag, parts, tolerance.as_ref(), constraints)
            }
            ConditionKind::Not(part) => list_text(":not", [tag, self.condition(part)]),
            ConditionKind::Absent(part, window) => {
                list_text(":absent", [tag, self.condition(part), format!(":for {}", self.expression(window))])
            }
            ConditionKind::Delay(least, most) => self.span(":delay", least, most.as_ref()),
            ConditionKind::Timestamp(start, end) => self.span(":timestamp", start, end.as_ref()),
            ConditionKind::Event { pattern, timing } => self.event_with(pattern, timing, Extras { tag, probing }),
            ConditionKind::TaskEnded(name) => format!("(end ?{name})"),
            ConditionKind::TaskState { task, state } => self.task_state(task, state),
            ConditionKind::Function(expr) => self.function(expr),
            ConditionKind::Probing { condition, goal, interval, time_limit, count_limit } => {
                let limit = |name: &str, expr: &Option<Expr>| {
                    expr.as_ref().map_or(String::new(), |expr| format!(":{name} {}", self.expression(expr)))
                };
                let limits = [limit("time-limit", time_limit), limit("count-limit", count_limit)];
                let parts = [self.expression(interval)].into_iter().chain(limits);
                self.with_probing(condition, format!(":probing {}", list_text(&self.template(goal), parts)))
            }
            ConditionKind::Cyclic(cyclic) => self.cyclic_with(cyclic, tag),
        }
    }

    fn composite(
        self,
        head: &str,
        tag: String,
        parts: &[Condition],
        tolerance: Option<&Expr>,
        constraints: &[Expr],
    ) -> String {
        let tolerance = tolerance.map_or(String::new(), |expr| format!(":tolerance {}", self.expression(expr)));
        let constraints = match constraints {
            [] => String::new(),
            all => format!(":constraint {}", joined(all.iter().map(|expr| self.expression(expr)))),
        };
        let parts = parts.iter().map(|part| self.condition(part));
        list_text(head, std::iter::once(tag).chain(parts).chain([tolerance, constraints]))
    }

    /// Returns `(ATTR OBJ.. rest)`.
    pub(super) fn variable(self, variable: &VariablePattern, rest: String) -> String {
        let split = |count: usize| count > 1 || self == Style::Brief;
        let object = match &variable.object {
            Pattern::Literal(Value::List(items)) if items.is_empty() => String::new(),
            Pattern::Literal(Value::List(items)) if items.len() > 1 && self == Style::Exact => {
                joined(items.iter().map(|item| self.literal(item)))
            }
            Pattern::List(items) if split(items.len()) => joined(items.iter().map(|item| self.pattern(item))),
            one => self.pattern(one),
        };
        list_text(variable.attribute.printed(), [object, rest])
    }

    /// Returns a measurement condition as text.
    pub fn measurement(self, condition: &MeasurementCondition) -> String {
        self.measurement_with(condition, Extras::default())
    }

    fn measurement_with(self, measurement: &MeasurementCondition, Extras { tag, probing }: Extras) -> String {
        let is_plain = tag.is_empty()
            && probing.is_empty()
            && measurement.object.is_empty()
            && measurement.timestamp.is_empty()
            && measurement.estimation.is_none();
        if let Some(rest) = self.short_values(&measurement.value).filter(|_| is_plain) {
            return self.variable(&measurement.variable, rest);
        }
        let parts = [
            tag,
            self.variable(&measurement.variable, String::new()),
            self.option(":value", &measurement.value),
            self.option(":object", &measurement.object),
            self.option(":timestamp", &measurement.timestamp),
            measurement.estimation.as_ref().map_or(String::new(), |estimation| self.estimation(estimation)),
            probing,
        ];
        list_text(":measurement", parts)
    }

    /// Returns the value constraints in the short form directly after the state variable, if they permit it.
    fn short_values(self, constraints: &[Constraint]) -> Option<String> {
        match (self, constraints) {
            (_, []) => None,
            (Style::Brief, [only]) => Some(self.infix(only).unwrap_or_else(|| self.constraint(only))),
            (Style::Brief, _) => None,
            (Style::Exact, all) => all.iter().map(|each| self.infix(each)).collect::<Option<Vec<_>>>().map(joined),
        }
    }

    fn estimation(self, estimation: &Estimation) -> String {
        match estimation {
            Estimation::Persist(None) => ":estimation :persist".to_string(),
            Estimation::Persist(Some(timeout)) => {
                format!(":estimation (:persist :with-timeout {})", self.expression(timeout))
            }
            Estimation::LinearRegression(options) if options.is_empty() => ":estimation :linear-regression".to_string(),
            Estimation::LinearRegression(options) => {
                let options = options.iter().map(|(name, expr)| format!(":{name} {}", self.expression(expr)));
                format!(":estimation {}", list_text(":linear-regression", options))
            }
        }
    }

    /// Returns an episode condition as text.
    pub fn episode(self, condition: &EpisodeCondition) -> String {
        self.episode_with(condition, Extras::default())
    }

    fn episode_with(self, episode: &EpisodeCondition, Extras { tag, probing }: Extras) -> String {
        let quality = match &episode.quality {
            Quality::NoConstraints => ":quality :no-constraints".to_string(),
            Quality::MaximumGap(gap) => format!(":quality (:max-gap {})", self.expression(gap)),
        };
        let named = |head: &str, groups: &[(Symbol, Vec<Constraint>)]| match groups {
            [] => String::new(),
            all => {
                let one = |(name, constraints): &(Symbol, Vec<Constraint>)| self.named_group(name, constraints);
                format!(":{head} {}", joined(all.iter().map(one)))
            }
        };
        let parts = [
            tag,
            self.variable(&episode.variable, String::new()),
            if episode.any { ":any".to_string() } else { String::new() },
            quality,
            self.option(":value", &episode.value),
            self.option(":first-value", &episode.first_value),
            self.option(":last-value", &episode.last_value),
            self.option(":object", &episode.object),
            self.timing(&episode.timing),
            named("stats", &episode.stats),
            named("trend", &episode.trend),
            probing,
        ];
        list_text(":episode", parts)
    }

    /// Returns `(:name C..)`; two kinds of groups hold a plain operand instead of constraints.
    fn named_group(self, name: &Symbol, constraints: &[Constraint]) -> String {
        let operand = match (name.folded(), constraints) {
            ("custom", [Constraint::Predicate(predicate, _)]) => Some(predicate.to_string()),
            ("significance", [Constraint::Compare { right, .. }]) => Some(self.expression(right)),
            _ => None,
        };
        match operand {
            Some(operand) => format!("(:{name} {operand})"),
            None => list_text(&format!(":{name}"), constraints.iter().map(|each| self.constraint(each))),
        }
    }

    fn timing(self, timing: &Timing) -> String {
        let groups = [("start", &timing.start), ("end", &timing.end), ("duration", &timing.duration)];
        let groups: Vec<String> = groups
            .into_iter()
            .filter(|(_, constraints)| !constraints.is_empty())
            .map(|(name, all)| list_text(&format!(":{name}"), all.iter().map(|each| self.constraint(each))))
            .collect();
        if groups.is_empty() { String::new() } else { format!(":timing {}", joined(groups)) }
    }

    /// Returns an event condition as text.
    pub fn event(self, pattern: &Pattern, timing: &Timing) -> String {
        self.event_with(pattern, timing, Extras::default())
    }

    fn event_with(self, pattern: &Pattern, timing: &Timing, Extras { tag, probing }: Extras) -> String {
        let timing = self.timing(timing);
        let form = self.pattern(pattern);
        let is_plain = tag.is_empty() && timing.is_empty() && probing.is_empty();
        if is_plain && (self == Style::Brief || !reads_otherwise(pattern)) {
            return form;
        }
        list_text(":atomic-episode", [tag, form, timing, probing])
    }

    /// Returns a wait for a task's state as text.
    pub fn task_state(self, task: &Expr, state: &Pattern) -> String {
        let head = match self {
            Style::Exact => "task-state",
            Style::Brief => "state",
        };
        format!("({head} {} = {})", self.expression(task), self.pattern(state))
    }

    /// Returns a `:delay` or `:timestamp` condition as text.
    pub fn span(self, name: &str, from: &Expr, to: Option<&Expr>) -> String {
        list_text(name, std::iter::once(from).chain(to).map(|expr| self.expression(expr)))
    }

    /// Returns `(:function EXPR)`.
    pub fn function(self, expr: &Expr) -> String {
        format!("(:function {})", self.expression(expr))
    }

    /// Returns `:name C..`, or an empty text without constraints.
    pub(super) fn option(self, name: &str, constraints: &[Constraint]) -> String {
        match constraints {
            [] => String::new(),
            all => format!("{name} {}", joined(all.iter().map(|each| self.constraint(each)))),
        }
    }

    /// Returns a constraint as text.
    pub fn constraint(self, constraint: &Constraint) -> String {
        if let Some(infix) = self.infix(constraint) {
            return format!("({infix})");
        }
        match constraint {
            Constraint::Range(Some(low), Some(high)) => {
                format!("(:range {} {})", self.expression(low), self.expression(high))
            }
            Constraint::Range(Some(low), None) => format!("(:min {})", self.expression(low)),
            Constraint::Range(None, Some(high)) => format!("(:max {})", self.expression(high)),
            Constraint::Predicate(name, arguments) => {
                list_text(name.printed(), arguments.iter().map(|argument| self.expression(argument)))
            }
            _ => String::new(),
        }
    }

    /// Returns `REL right [+/- tolerance]`; `None` for a predicate or a range.
    fn infix(self, constraint: &Constraint) -> Option<String> {
        match constraint {
            Constraint::Compare { relation, right, tolerance } => {
                let tolerance =
                    tolerance.as_ref().map_or(String::new(), |expr| format!(" +/- {}", self.expression(expr)));
                Some(format!("{} {}{tolerance}", relation_text(*relation), self.operand(right)))
            }
            Constraint::Matches(pattern) => Some(format!("= {}", self.pattern(pattern))),
            Constraint::Predicate(..) | Constraint::Range(..) => None,
        }
    }
}

/// Returns true for event forms that would be read as another kind of condition.
fn reads_otherwise(pattern: &Pattern) -> bool {
    const HEADS: &[&str] = &["and", "or", "not", "end", "end-of", "end_of", "terminated", "state", "task-state"];
    const RELATIONS: &[&str] = &["=", "/=", "<", "<=", ">", ">="];
    let symbols: Vec<Option<&Symbol>> = match pattern {
        Pattern::Literal(Value::List(items)) => items.iter().map(Value::as_symbol).collect(),
        Pattern::List(items) => items
            .iter()
            .map(|item| match item {
                Pattern::Literal(value) => value.as_symbol(),
                _ => None,
            })
            .collect(),
        _ => return false,
    };
    let head = symbols.first().copied().flatten();
    head.is_some_and(|head| HEADS.contains(&head.folded()) || head.folded().starts_with(':'))
        || symbols.iter().skip(1).flatten().any(|symbol| RELATIONS.contains(&symbol.folded()))
}

fn relation_text(relation: Relation) -> &'static str {
    match relation {
        Relation::Equal => "=",
        Relation::Different => "/=",
        Relation::Less => "<",
        Relation::LessOrEqual => "<=",
        Relation::Greater => ">",
        Relation::GreaterOrEqual => ">=",
    }
}
