//! Messages about arguments of the wrong type, and about too few or too many of them.

use super::calls::{Call, Calls, Receiver};
use super::findings::{Findings, is_shipped};
use super::types::Types;
use crate::analysis::kinds::{Kind, Kinds, is_zero};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity};
use crate::fix::Fix;
use crate::matching::View;
use crate::suggest::renames;
use apex_model::condition::ConditionKind;
use apex_model::expression::{Expr, ExprKind, Template};
use apex_model::interface::{ArgumentType, InterfaceDeclaration, NameKind};
use apex_model::library::Library;
use apex_model::pattern::Pattern;
use apex_model::quantity::Dimension;
use apex_model::symbol::Symbol;
use apex_model::value::Value;

/// Words that a command accepts in place of a named place: the present position, and straight below it.
const PLACE_WORDS: &[&str] = &["here", "down"];

pub(super) fn check(library: &Library, calls: &Calls<'_>, types: &Types<'_>, findings: &mut Findings<'_>) {
    for call in &calls.all {
        if let Receiver::Declared(declaration) = &call.receiver {
            // A program may replace a library's declaration; the library's own messages are not compared with the replacement.
            if is_shipped(library, call.place) && !is_shipped(library, declaration.place) {
                continue;
            }
            count(call, declaration, findings);
            options(call, declaration, findings);
        }
        for number in 1..call.items.len() {
            let Some(wanted) = types.wanted(call, number) else { continue };
            let Some(item) = call.items.get(number) else { continue };
            let item = selected(call, *item);
            let found = mismatch(library, &wanted, item).or_else(|| of_message(library, call, &wanted, item));
            if let Some(found) = found {
                argument(call, number, &wanted, found, findings);
            }
        }
    }
}

/// Returns the literal of the step's `select` if the argument is the variable that it computes.
fn selected<'l>(call: &Call<'l>, item: View<'l>) -> View<'l> {
    let (Some(name), Some(step)) = (variable(item), call.step) else { return item };
    match step.select.iter().rev().find(|(selected, _)| selected == name).map(|(_, expr)| &expr.kind) {
        Some(ExprKind::Constant(value)) => View::Value(value),
        _ => item,
    }
}

/// Returns the mismatch of a variable that the step's `waitfor` takes from a message whose declaration states another dimension.
fn of_message(library: &Library, call: &Call<'_>, wanted: &ArgumentType, item: View<'_>) -> Option<Mismatch> {
    let ArgumentType::Quantity(wanted) = wanted else { return None };
    let (name, step) = (variable(item)?, call.step?);
    if step.select.iter().any(|(selected, _)| selected == name) {
        return None;
    }
    let mut awaited = step.waitfor.iter().filter_map(|condition| match &condition.kind {
        ConditionKind::Event { pattern, .. } => Some(&**pattern),
        _ => None,
    });
    awaited.find_map(|pattern| {
        let Pattern::List(parts) = pattern else { return None };
        let Some(Pattern::Literal(Value::Symbol(head))) = parts.first() else { return None };
        let is_plain = |part: &Pattern| matches!(part, Pattern::Literal(_) | Pattern::Variable(_) | Pattern::Anonymous);
        let at = parts.iter().position(|part| matches!(part, Pattern::Variable(each) if each == name))?;
        let declared = library.events.get(head).filter(|_| parts.iter().take(at).all(is_plain))?;
        match declared.parameters.get(at.checked_sub(1)?)?.argument_type {
            ArgumentType::Quantity(found) if found != *wanted && found != Dimension::NONE => {
                let words = Kind::Number(found).words();
                Some(Mismatch::Other(format!("{words}, as `({head} ..)` declares `?{name}`")))
            }
            _ => None,
        }
    })
}

fn variable(item: View<'_>) -> Option<&Symbol> {
    match item {
        View::Template(Template::Hole(Expr { kind: ExprKind::Variable { name, .. }, .. })) => Some(name),
        _ => None,
    }
}

/// The reason for which an argument does not have the wanted type.
pub(super) enum Mismatch {
    /// The argument certainly has another kind, stated as text.
    Other(String),
    /// A number without unit where a quantity is wanted.
    Bare(String),
    /// Not one of the words.
    Word(Symbol),
}

/// Returns the mismatch between an argument and its type; `None` if they agree or the value is unknown.
fn mismatch(library: &Library, wanted: &ArgumentType, item: View<'_>) -> Option<Mismatch> {
    let kind = match item {
        View::Template(Template::Hole(expr)) if is_zero(expr) => return None,
        View::Template(Template::Hole(expr)) => Kinds::of(library, expr),
        _ => Kind::Unknown,
    };
    let value = item.value();
    let other = |what: &str| Some(Mismatch::Other(what.to_string()));
    match wanted {
        ArgumentType::Any => None,
        ArgumentType::Quantity(dimension) => match (value, kind) {
            (Some(value), _) => quantity(*dimension, value),
            (None, Kind::Number(found)) if found != *dimension && found != Dimension::NONE => {
                Some(Mismatch::Other(Kind::Number(found).words()))
            }
            (None, Kind::Instant) if *dimension != Dimension::TIME => other("an instant"),
            (None, Kind::Other(what)) => other(what),
            _ => None,
        },
        ArgumentType::Text => match (value, kind) {
            (Some(Value::Text(_)), _) | (None, Kind::Unknown | Kind::Other("a text")) => None,
            (Some(value), _) => Some(Mismatch::Other(format!("`{value}`"))),
            (None, kind) => Some(Mismatch::Other(kind.words())),
        },
        ArgumentType::List => match value {
            Some(Value::List(_)) | None => None,
            Some(value) => Some(Mismatch::Other(format!("`{value}`"))),
        },
        ArgumentType::OneOf(words) => match value? {
            Value::Symbol(word) if words.contains(word) => None,
            Value::Symbol(word) => Some(Mismatch::Word(word.clone())),
            value => Some(Mismatch::Other(format!("`{value}`"))),
        },
        ArgumentType::Named(name_kind) => match (value, kind) {
            (Some(Value::Symbol(_)), _) => None,
            (Some(Value::List(items)), _) if *name_kind == NameKind::Place => location(library, items),
            (Some(value), _) => Some(Mismatch::Other(format!("`{value}`"))),
            (None, Kind::Number(_) | Kind::Instant | Kind::Other("a text")) => Some(Mismatch::Other(kind.words())),
            (None, _) if *name_kind == NameKind::Place => call_without_comma(library, item),
            (None, _) => None,
        },
    }
}

/// Returns the mismatch of a location that is written as a list: latitude, longitude and possibly an altitude.
fn location(library: &Library, items: &[Value]) -> Option<Mismatch> {
    if let Some(Value::Symbol(head)) = items.first() {
        return is_function(library, head).then(|| without_comma(head));
    }
    let degrees = |at: usize| items.get(at).and_then(Value::as_number).filter(|(_, found)| *found == Dimension::NONE);
    let ((latitude, _), (longitude, _)) = (degrees(0)?, degrees(1)?);
    if latitude.abs() > 90.0 {
        return Some(Mismatch::Other(format!(
            "a list with the latitude {latitude}; latitudes are from -90 to 90, and come first"
        )));
    }
    let far = longitude.abs() > 360.0;
    far.then(|| Mismatch::Other(format!("a list with the longitude {longitude}; longitudes are from -180 to 180")))
}

/// Returns the mismatch of a list that begins with the name of a function and has holes: `(berth-of ?ship)`.
fn call_without_comma(library: &Library, item: View<'_>) -> Option<Mismatch> {
    let items = item.items()?;
    let head = items.first()?.value()?.as_symbol()?;
    is_function(library, head).then(|| without_comma(head))
}

fn is_function(library: &Library, name: &Symbol) -> bool {
    library.functions.contains_key(name)
}

fn without_comma(function: &Symbol) -> Mismatch {
    Mismatch::Other(format!("a list that begins with the function `{function}`; `,({function} ..)` calls it"))
}

fn quantity(wanted: Dimension, value: &Value) -> Option<Mismatch> {
    match value.as_number() {
        Some((0.0, _)) => None,
        Some((_, found)) if found == wanted => None,
        Some((_, Dimension::NONE)) => Some(Mismatch::Bare(value.to_string())),
        Some((_, found)) => Some(Mismatch::Other(format!("`{value}`, {}", Kind::Number(found).words()))),
        None if matches!(value, Value::Time(_)) && wanted == Dimension::TIME => None,
        None if *value == Value::nil() => None,
        None => Some(Mismatch::Other(format!("`{value}`"))),
    }
}

/// Returns the unit that a bare number most likely has: that of the type's own documentation.
fn usual_unit(wanted: &ArgumentType) -> Option<&'static str> {
    match wanted {
        ArgumentType::Quantity(Dimension::LENGTH) => Some("m"),
        ArgumentType::Quantity(Dimension::TIME) => Some("s"),
        ArgumentType::Quantity(Dimension::SPEED) => Some("m/s"),
        ArgumentType::Quantity(Dimension::ANGLE) => Some("deg"),
        _ => None,
    }
}

fn argument(call: &Call<'_>, number: usize, wanted: &ArgumentType, found: Mismatch, findings: &mut Findings<'_>) {
    let span = call.argument_span(&mut findings.locator, number);
    let head = call.head().map_or("", Symbol::printed);
    // The author's own notation, `110s`, is clearer in a message than the canonical form of the value, `P1M50S`.
    let value = call.items.get(number).and_then(|item| item.value()).map(|value| format!("`{value}`"));
    let written = findings.locator.text(span).filter(|text| !text.contains('\n')).map(|text| format!("`{text}`"));
    let as_written = |what: String| match (&value, &written) {
        (Some(value), Some(written)) => what.replace(value, written),
        _ => what,
    };
    let diagnostic = match found {
        Mismatch::Other(what) => Diagnostic::error(
            codes::ARGUMENT_TYPE,
            span,
            format!("`({head} ..)` takes {} here, but this is {}", wanted.described(), as_written(what)),
        ),
        Mismatch::Word(word) => {
            let ArgumentType::OneOf(words) = wanted else { return };
            let message = format!("`({head} ..)` takes {} here, but this is `{word}`", wanted.described());
            Diagnostic::error(codes::ARGUMENT_TYPE, span, message).fixes(renames(
                span,
                word.printed(),
                words.iter().map(Symbol::printed),
            ))
        }
        Mismatch::Bare(number) => {
            let message = format!("`{number}` has no unit, but `({head} ..)` takes {} here", wanted.described());
            let diagnostic = Diagnostic::new(Severity::Warning, codes::ARGUMENT_TYPE, span, message);
            match usual_unit(wanted) {
                Some(unit) => {
                    let fix = Fix::look(format!("write `{number}{unit}`")).insert_after(span, unit);
                    diagnostic
                        .reason(format!("a bare number counts in {unit}, whichever unit its author intended"))
                        .fix(fix)
                }
                None => diagnostic,
            }
        }
    };
    findings.add(diagnostic);
}

/// Reports options that a command or message does not declare, if it declares some.
fn options(call: &Call<'_>, declaration: &InterfaceDeclaration, findings: &mut Findings<'_>) {
    if declaration.options.is_empty() {
        return;
    }
    for (number, item) in call.items.iter().enumerate().skip(1) {
        let word = item.value().and_then(Value::as_symbol).filter(|name| name.folded().starts_with(':'));
        let Some(word) = word.filter(|word| declaration.options.iter().all(|option| option.name != **word)) else {
            continue;
        };
        let span = call.argument_span(&mut findings.locator, number);
        let head = call.head().map_or("", Symbol::printed);
        let names = declaration.options.iter().map(|option| option.name.printed());
        let all: Vec<&str> = names.clone().collect();
        let message = format!("`({head} ..)` has no option `{}`", word.printed());
        let fixes = renames(span, word.printed(), names);
        findings.add(
            Diagnostic::new(Severity::Warning, codes::ARGUMENT_TYPE, span, message)
                .fixes_or_help(fixes, || format!("its options are {}", all.join(", "))),
        );
    }
}

/// Reports too few or too many arguments.
fn count(call: &Call<'_>, declaration: &InterfaceDeclaration, findings: &mut Findings<'_>) {
    let is_keyword =
        |item: &&View<'_>| item.value().and_then(Value::as_symbol).is_some_and(|name| name.folded().starts_with(':'));
    // Options are not counted.
    let before = call.items.iter().skip(1).position(|item| is_keyword(&item));
    let given = before.filter(|_| !declaration.options.is_empty()).unwrap_or(call.items.len().saturating_sub(1));
    let most = declaration.parameters.len();
    let is_enough = given >= declaration.required || !call.is_complete;
    if is_enough && (declaration.is_open || given <= most) {
        return;
    }
    let span = call.argument_span(&mut findings.locator, 0);
    let head = call.head().map_or("", Symbol::printed);
    let takes = match (declaration.required, most) {
        (least, most) if least == most => most.to_string(),
        (least, _) if declaration.is_open => format!("at least {least}"),
        (least, most) => format!("{least} to {most}"),
    };
    let message = format!("`({head} ..)` is given {given} arguments, but takes {takes}");
    let parameters: Vec<String> = declaration.parameters.iter().map(|each| format!("?{}", each.name)).collect();
    let declared = findings.locator.span(declaration.place);
    findings.add(Diagnostic::error(codes::ARGUMENT_TYPE, span, message).label(declared, "declared here").help(
        format!("its arguments are {}", if parameters.is_empty() { "none".to_string() } else { parameters.join(" ") }),
    ));
}

/// Returns true for words that are accepted in place of the name of a place.
pub(super) fn is_place_word(word: &str) -> bool {
    PLACE_WORDS.contains(&word)
}
