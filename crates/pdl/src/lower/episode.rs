//! Episodes: quality, statistics, trends; atomic episodes (`conditions.md`).

use super::Lowering;
use super::clauses::{KeywordGroup, groups, values_of};
use super::expected::{Expected, ExpectedKind};
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::fix::Fix;
use crate::read::{Datum, DatumKind};
use crate::suggest::renames_marked;
use apex_model::condition::{Condition, ConditionKind, Constraint, EpisodeCondition, Quality, Relation};
use apex_model::quantity::Dimension;
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use apex_model::value::Value;

const OPTIONS: &[&str] =
    &["quality", "value", "first-value", "last-value", "object", "timing", "stats", "trend", "probing"];
const STATISTICS: &[&str] = &[
    "mean",
    "count",
    "stddev",
    "variance",
    "sum",
    "difference",
    "min",
    "max",
    "median",
    "time-weighted-mean",
    "time-weighted-stddev",
    "time-weighted-variance",
];
const TRENDS: &[&str] = &["rate", "step", "frequency", "custom", "significance"];

/// Every word for the largest gap that is allowed between samples.
const GAP_WORDS: &[&str] = &[
    "max-gap",
    "maximum-gap",
    "msi",
    "min-sample-interval",
    "minimum-sample-interval",
    "min-frequency",
    "minimum-frequency",
];

impl Lowering {
    /// Lowers `(:episode [tag] (ATTR OBJ) :quality Q ..)`; `outer` is a quality that follows the form directly.
    pub(crate) fn episode(&mut self, datum: &Datum, items: &[Datum], outer: Option<&Datum>) -> Option<Condition> {
        let (any, items) = self.without_any(items);
        let (tag, items) = self.condition_tag(&items);
        let Some((form, options)) = items.split_first().filter(|(form, _)| form.as_list().is_some()) else {
            let diagnostic = Diagnostic::error(
                codes::MALFORMED_CONDITION,
                datum.span,
                "an `:episode` names a state variable",
            )
            .help(
                "its shape is `(:episode [tag] (ATTRIBUTE OBJECT) :quality Q [:value CONSTRAINT..] [:timing ..] ..)`",
            );
            return self.refuse(diagnostic);
        };
        if self.report_missing_colon(items, OPTIONS, "an episode") {
            return None;
        }
        let (stray, options) = groups(options);
        self.no_stray(stray)?;
        self.check_groups(&options, OPTIONS, "`:episode`")?;
        let quality = self.episode_quality(datum, &options, outer);
        let variable = self.plain_state_variable(form)?;
        let expected = Expected::values_of(self, &variable.attribute);
        let value = self.constraints(values_of(&options, "value"), &expected);
        let first_value = self.constraints(values_of(&options, "first-value"), &expected);
        let last_value = self.constraints(values_of(&options, "last-value"), &expected);
        let object = self.constraints(values_of(&options, "object"), &Expected::anything());
        let timing = self.timing(values_of(&options, "timing"), false);
        let stats = self.statistics(values_of(&options, "stats"), &expected);
        let trend = self.trend(values_of(&options, "trend"), &expected);
        let episode = EpisodeCondition {
            variable,
            quality: quality?,
            any,
            value: value?,
            first_value: first_value?,
            last_value: last_value?,
            object: object?,
            timing: timing?,
            stats: stats?,
            trend: trend?,
        };
        let kind = ConditionKind::Episode(episode.into());
        self.probing(Condition { tag, kind, place: datum.span.place() }, &options)
    }

    /// Returns true if the word `:any` is among the data, and the data without it.
    pub(super) fn without_any(&mut self, items: &[Datum]) -> (bool, Vec<Datum>) {
        let any = items.iter().any(|item| item.is(":any"));
        (any, items.iter().filter(|item| !item.is(":any")).cloned().collect())
    }

    fn episode_quality(
        &mut self,
        datum: &Datum,
        options: &[KeywordGroup<'_>],
        outer: Option<&Datum>,
    ) -> Option<Quality> {
        let inner = options.iter().find(|group| group.name == "quality");
        match (inner, outer) {
            (Some(inner), Some(outer)) => {
                self.report_twice("option `:quality`", inner.span, outer.span);
                None
            }
            (Some(inner), None) => {
                let quality = self.only(":quality", inner.values, inner.span)?;
                self.quality(quality)
            }
            (None, Some(outer)) => self.quality(outer),
            (None, None) => {
                let diagnostic =
                    Diagnostic::error(codes::MISSING_QUALITY, datum.span, "this episode does not state its `:quality`")
                        .fixes(quality_added(datum))
                        .reason(
                            "samples may be sparse: between two samples far apart the value can have been anything",
                        );
                self.refuse(diagnostic)
            }
        }
    }

    fn quality(&mut self, datum: &Datum) -> Option<Quality> {
        if datum.is(":no-constraints") {
            return Some(Quality::NoConstraints);
        }
        match datum.as_list() {
            Some([word]) if word.is(":no-constraints") => Some(Quality::NoConstraints),
            Some([word, gap]) if word.keyword().is_some_and(|word| GAP_WORDS.contains(&word)) => {
                // The constraint `(:msi (<= 1s))` states the same limit.
                let gap = match gap.as_list() {
                    Some([relation, limit]) if relation.is("<") || relation.is("<=") => limit,
                    _ => gap,
                };
                if let DatumKind::Duration(length) = &gap.kind
                    && *length < Duration::ZERO
                {
                    let message = format!("{length} is a negative gap");
                    let diagnostic = Diagnostic::error(codes::DURATION_EXPECTED, gap.span, message);
                    return self.refuse(diagnostic.help("write the greatest time between two samples, such as `1s`"));
                }
                self.interval_or_frequency(gap).map(Quality::MaximumGap)
            }
            _ => {
                let diagnostic =
                    Diagnostic::error(codes::MALFORMED_CONDITION, datum.span, "this is not a sampling quality");
                let fixes = quality_renamed(datum);
                self.refuse(
                    diagnostic.fixes_or_help(fixes, || "write `:no-constraints` or `(:max-gap DURATION)`".to_string()),
                )
            }
        }
    }

    fn statistics(&mut self, items: &[Datum], expected: &Expected) -> Option<Vec<(Symbol, Vec<Constraint>)>> {
        self.all(items, |lowering, item| {
            let item = &weighted(item);
            let (name, constraints) = lowering.named_group(item, STATISTICS, "statistic")?;
            if name != "count" {
                lowering.needs_numbers(&format!("the {name}"), item.span, expected)?;
            }
            let expected = match name {
                "count" => Expected::number("the count"),
                "variance" | "time-weighted-variance" => expected.square().real(),
                "sum" | "difference" | "min" | "max" => expected.named(name),
                _ => expected.named(name).real(),
            };
            let constraints = lowering.constraints(constraints, &expected)?;
            Some((Symbol::new(name), constraints))
        })
    }

    fn trend(&mut self, items: &[Datum], expected: &Expected) -> Option<Vec<(Symbol, Vec<Constraint>)>> {
        self.all(items, |lowering, item| {
            let (name, constraints) = lowering.named_group(item, TRENDS, "trend")?;
            if matches!(name, "rate" | "step" | "significance") {
                lowering.needs_numbers(&format!("the {name}"), item.span, expected)?;
            }
            let constraints = match name {
                "rate" => lowering.trend_constraints(constraints, &expected.rate().real())?,
                "step" => lowering.trend_constraints(constraints, &expected.named("step"))?,
                "frequency" => {
                    let kind = ExpectedKind::Measured(Dimension::FREQUENCY, None);
                    lowering.constraints(constraints, &Expected::plain("the frequency", kind))?
                }
                "custom" => lowering.custom_trend(item, constraints)?,
                _ => lowering.one_value(":significance", constraints, item.span)?,
            };
            Some((Symbol::new(name), constraints))
        })
    }

    /// Rejects computations with values that are declared to be other than numbers.
    pub(crate) fn needs_numbers(&mut self, what: &str, span: Span, expected: &Expected) -> Option<()> {
        let declared = match expected.value_type.as_ref() {
            Some(name) if matches!(expected.kind, ExpectedKind::Anything) => name.printed().to_string(),
            _ => return Some(()),
        };
        let message = format!("{what} of {} cannot be computed: its values are of type {declared}", expected.subject);
        let mut diagnostic = Diagnostic::error(codes::VALUE_TYPE, span, message);
        if let Some(place) = expected.declared {
            diagnostic = diagnostic.label(place, format!("declared as {declared} here"));
        }
        self.refuse(diagnostic)
    }

    /// Splits `(:name C..)` into the name, which must be one of `known`, and the constraints.
    fn named_group<'d>(
        &mut self,
        item: &'d Datum,
        known: &[&'static str],
        what: &str,
    ) -> Option<(&'static str, &'d [Datum])> {
        let name = item.as_list().and_then(<[Datum]>::first).and_then(Datum::keyword);
        if let Some(found) = name.and_then(|name| known.iter().find(|known| **known == name))
            && !item.tail().is_empty()
        {
            return Some((found, item.tail()));
        }
        let diagnostic = Diagnostic::error(codes::MALFORMED_CONDITION, item.span, format!("this is not a {what}"));
        let span = item.head_span();
        let mark = |name: &str| format!(":{name}");
        let fixes = renames_marked(span, name.unwrap_or_default(), known.iter().copied(), mark);
        self.refuse(
            diagnostic.fixes_or_help(fixes, || {
                format!("its shape is `(:NAME CONSTRAINT..)`; names are :{}", known.join(" :"))
            }),
        )
    }

    /// Lowers constraints, or the words `:increasing`, `:decreasing`, `:non-increasing`, `:non-decreasing`.
    fn trend_constraints(&mut self, items: &[Datum], expected: &Expected) -> Option<Vec<Constraint>> {
        let groups = self.all(items, |lowering, item| {
            let Some(relation) = item.keyword().and_then(direction) else {
                return lowering.constraints(std::slice::from_ref(item), expected);
            };
            let zero = super::expression::constant(Value::Integer(0), item.span);
            let right = lowering.conform(zero, item.span, expected)?;
            Some(vec![Constraint::Compare { relation, right, tolerance: None }])
        })?;
        Some(groups.into_iter().flatten().collect())
    }

    fn custom_trend(&mut self, item: &Datum, constraints: &[Datum]) -> Option<Vec<Constraint>> {
        let datum = self.only(":custom", constraints, item.span)?;
        let Some(name) = super::pattern::function_name(datum) else {
            let diagnostic = Diagnostic::error(
                codes::MALFORMED_CONDITION,
                datum.span,
                "`:custom` is not followed by the name of a function",
            );
            return self
                .refuse(diagnostic.help("write the name of a predicate of the list of values: `(:custom falls)`"));
        };
        let name = self.predicate(name, datum.span, 1)?;
        Some(vec![Constraint::Predicate(name, Vec::new())])
    }

    /// Returns an option that is a value and not a constraint: `:hysteresis 3deg`, also in its printed form `(= 3deg)`.
    pub(super) fn one_value(&mut self, option: &str, values: &[Datum], span: Span) -> Option<Vec<Constraint>> {
        let datum = self.only(option, values, span)?;
        let right = match datum.as_list() {
            Some([equal, value]) if equal.is("=") => self.expression(value)?,
            _ => self.expression(datum)?,
        };
        Some(vec![Constraint::Compare { relation: Relation::Equal, right, tolerance: None }])
    }

    /// Lowers `(:atomic-episode [tag] FORM [:timing T..])`.
    pub(crate) fn atomic_episode(&mut self, datum: &Datum, items: &[Datum]) -> Option<Condition> {
        let (tag, items) = self.condition_tag(items);
        let Some((form, options)) = items.split_first().filter(|(form, _)| form.as_list().is_some()) else {
            let diagnostic =
                Diagnostic::error(codes::MALFORMED_CONDITION, datum.span, "this `:atomic-episode` has no event form")
                    .help("its shape is `(:atomic-episode [tag] FORM [:timing CONSTRAINT..])`");
            return self.refuse(diagnostic);
        };
        let (stray, options) = groups(options);
        self.no_stray(stray)?;
        self.check_groups(&options, &["timing", "probing"], "`:atomic-episode`")?;
        let pattern = self.pattern(form);
        let timing = self.timing(values_of(&options, "timing"), true);
        let kind = ConditionKind::Event { pattern: pattern?.into(), timing: timing?.into() };
        self.probing(Condition { tag, kind, place: datum.span.place() }, &options)
    }

    /// Returns true for a list whose first item is a list: several groups in one pair of parentheses.
    pub(crate) fn is_nested(datum: &Datum) -> bool {
        matches!(&datum.kind, DatumKind::List(items) if items.first().is_some_and(|first| first.as_list().is_some()))
    }
}

/// Returns the relation that a word of a trend requires of the rate or step.
fn direction(word: &str) -> Option<Relation> {
    match word {
        "increasing" => Some(Relation::Greater),
        "decreasing" => Some(Relation::Less),
        "non-increasing" => Some(Relation::LessOrEqual),
        "non-decreasing" => Some(Relation::GreaterOrEqual),
        _ => None,
    }
}

/// Rewrites `(:mean :time-weighted C..)` as `(:time-weighted-mean C..)`.
fn weighted(item: &Datum) -> Datum {
    let parts = item.as_list().unwrap_or_default();
    let Some((head, rest)) = parts.split_first() else { return item.clone() };
    let (Some(name), true) = (head.keyword(), rest.iter().any(|part| part.keyword() == Some("time-weighted"))) else {
        return item.clone();
    };
    let head = Datum { kind: DatumKind::Symbol(Symbol::new(&format!(":time-weighted-{name}"))), span: head.span };
    let rest = rest.iter().filter(|part| part.keyword() != Some("time-weighted")).cloned();
    Datum { kind: DatumKind::List(std::iter::once(head).chain(rest).collect()), span: item.span }
}

/// Returns both ways to state the quality after the last part of an episode: the one without a requirement, and the one that requires
/// dense samples.
fn quality_added(episode: &Datum) -> Vec<Fix> {
    let Some(last) = episode.as_list().and_then(<[Datum]>::last) else { return Vec::new() };
    let add = |quality: &str, means: &str| {
        let fix = Fix::look(format!("add `:quality {quality}`, which {means}"));
        fix.insert_after(last.span, format!(" :quality {quality}"))
    };
    vec![
        add("(:no-constraints)", "accepts whatever samples arrive"),
        add("(:max-gap 1s)", "requires a sample at least every second"),
    ]
}

/// Returns fixes for a misspelt quality, or one without its colon.
fn quality_renamed(quality: &Datum) -> Vec<Fix> {
    let words = || std::iter::once("no-constraints").chain(GAP_WORDS.iter().copied());
    let word = quality.as_list().and_then(<[Datum]>::first).unwrap_or(quality);
    let Some(name) = word.as_symbol().map(Symbol::folded) else { return Vec::new() };
    if words().any(|known| known == name) {
        return vec![super::slips::colon(name, word.span)];
    }
    renames_marked(word.span, name.trim_start_matches(':'), words(), |name| format!(":{name}"))
}
