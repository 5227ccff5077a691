//! Questions to the operator: the default among the options, the time limit, and a procedure for each answer.

use super::findings::Findings;
use crate::analysis::kinds::{Kind, Kinds};
use crate::analysis::methods::Methods;
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity, Span};
use crate::print::template_text;
use crate::suggest::{near, renames};
use apex_model::expression::{Expr, ExprKind, Template};
use apex_model::library::Library;
use apex_model::pattern::Pattern;
use apex_model::procedure::{Activity, BuiltInActivity, Procedure, Step};
use apex_model::quantity::Dimension;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::value::Value;

pub(super) fn check(library: &Library, methods: &Methods<'_>, findings: &mut Findings<'_>) {
    for procedure in &library.procedures {
        for step in &procedure.steps {
            let Activity::BuiltIn(BuiltInActivity::AskOperator, arguments) = &step.activity else { continue };
            let [_, options, by, ..] = arguments.as_slice() else { continue };
            let options = constants(options);
            let default = arguments.get(3).and_then(constant);
            time_limit(library, by, findings);
            default_among(step, &options, default, findings);
            if let Some(Pattern::Variable(answer)) = step.binds.as_deref() {
                let offered: Vec<&Value> = options.iter().copied().chain(default).collect();
                answers((library, methods), procedure, step, answer, &offered, findings);
            }
        }
    }
}

/// Returns true if a step asks the operator.
pub(super) fn has_questions(library: &Library) -> bool {
    let asks = |step: &Step| matches!(step.activity, Activity::BuiltIn(BuiltInActivity::AskOperator, _));
    library.procedures.iter().any(|procedure| procedure.steps.iter().any(asks))
}

fn constant(expr: &Expr) -> Option<&Value> {
    match &expr.kind {
        ExprKind::Constant(value) => Some(value),
        ExprKind::Template(template) => match &**template {
            Template::Constant(value) => Some(value),
            _ => None,
        },
        _ => None,
    }
}

/// Returns the options if all are constant.
fn constants(options: &Expr) -> Vec<&Value> {
    match constant(options) {
        Some(Value::List(items)) => items.iter().collect(),
        _ => Vec::new(),
    }
}

fn time_limit(library: &Library, by: &Expr, findings: &mut Findings<'_>) {
    let found = match Kinds::of(library, by) {
        Kind::Number(Dimension::TIME) | Kind::Instant | Kind::Unknown => return,
        found => found.words(),
    };
    let message = format!("`:by` takes a span of time or an instant, but this is {found}");
    let span = findings.locator.span(by.place);
    findings.add(Diagnostic::new(Severity::Warning, codes::ARGUMENT_TYPE, span, message));
}

fn default_among(step: &Step, options: &[&Value], default: Option<&Value>, findings: &mut Findings<'_>) {
    let Some(Value::Symbol(word)) = default.filter(|default| !options.is_empty() && !options.contains(default)) else {
        return;
    };
    let span = after_keyword(findings, step, ":default", word);
    let words = options.iter().filter_map(|option| option.as_symbol()).map(Symbol::printed);
    let diagnostic =
        Diagnostic::new(Severity::Warning, codes::UNSERVED_ANSWER, span, format!("`{word}` is not one of the options"))
            .reason("without an answer the default counts, so it must be an answer that the operator can choose")
            .fixes(renames(span, word.printed(), words));
    findings.add(diagnostic);
}

/// Reports goals of the procedure that contain the answer as a word and that no method serves for one of the options.
fn answers(
    (library, methods): (&Library, &Methods<'_>),
    procedure: &Procedure,
    asking: &Step,
    answer: &Symbol,
    offered: &[&Value],
    findings: &mut Findings<'_>,
) {
    for step in &procedure.steps {
        let Activity::Goal(goal) = &step.activity else { continue };
        if !mentions(goal, answer) {
            continue;
        }
        for value in offered {
            let filled = fill(goal, answer, value);
            if methods.serving(&filled).is_none_or(|serving| !serving.is_empty()) {
                continue;
            }
            let span = match value {
                Value::Symbol(word) => findings.locator.word(asking.place, word),
                _ => findings.locator.activity(asking.place),
            };
            let message =
                format!("the answer `{value}` leads to `{}`, a goal that no procedure serves", template_text(&filled));
            let severity = if step.on_failure.is_some() { Severity::Note } else { Severity::Warning };
            let mut diagnostic = Diagnostic::new(severity, codes::UNSERVED_ANSWER, span, message)
                .label(findings.locator.activity(step.place), "pursued with the answer")
                .help("write a procedure for it, or correct the option");
            if let Some(place) = unused_index(library, &filled) {
                diagnostic = diagnostic.label(findings.locator.index(place), "serves a similar goal");
            }
            findings.add(diagnostic);
        }
    }
}

fn mentions(goal: &Template, answer: &Symbol) -> bool {
    match goal {
        Template::List(parts) => parts.iter().any(|part| mentions(part, answer)),
        Template::Hole(expr) => matches!(&expr.kind, ExprKind::Variable { name, .. } if name == answer),
        Template::Constant(_) | Template::Splice(_) => false,
    }
}

/// Returns the goal with the answer filled in.
fn fill(goal: &Template, answer: &Symbol, value: &Value) -> Template {
    match goal {
        Template::List(parts) => Template::List(parts.iter().map(|part| fill(part, answer, value)).collect()),
        Template::Hole(Expr { kind: ExprKind::Variable { name, .. }, .. }) if name == answer => {
            Template::Constant(value.clone())
        }
        other => other.clone(),
    }
}

/// Returns the procedure or primitive for a goal that differs from `goal` by words that resemble each other.
fn unused_index(library: &Library, goal: &Template) -> Option<Place> {
    let Template::List(parts) = goal else { return None };
    let resembles = |own: &Template, index: &Pattern| match (own, index) {
        (Template::Constant(Value::Symbol(own)), Pattern::Literal(Value::Symbol(word))) => {
            own == word || !near(own.printed(), [word.printed()]).is_empty()
        }
        (Template::Constant(own), Pattern::Literal(value)) => own == value,
        _ => true,
    };
    let is_similar = |index: &Pattern| match index {
        Pattern::List(found) => {
            found.len() == parts.len() && parts.iter().zip(found).all(|(own, index)| resembles(own, index))
        }
        _ => false,
    };
    let procedures = library.procedures.iter().map(|each| (&each.index, each.place));
    let mut indexes = procedures.chain(library.primitives.iter().map(|each| (&each.index, each.place)));
    indexes.find(|(index, _)| is_similar(index)).map(|(_, place)| place)
}

/// Returns the word after a keyword of the step, otherwise the activity.
fn after_keyword(findings: &mut Findings<'_>, step: &Step, keyword: &str, word: &Symbol) -> Span {
    let Some(datum) = findings.locator.datum(step.place) else { return findings.locator.span(step.place) };
    let mut found = None;
    crate::locate::each(&datum, &mut |part| {
        let items = part.as_list().unwrap_or_default();
        let after = items.iter().position(|item| item.is(keyword)).and_then(|at| items.get(at + 1));
        found = found.or_else(|| after.filter(|item| item.as_symbol() == Some(word)).map(|item| item.span));
    });
    found.unwrap_or_else(|| findings.locator.activity(step.place))
}
