//! Dimensions of computed values: results of functions, indexicals and `let`s, requirements of clauses, and uses of goal words in
//! procedures.

use super::constant_number::constant_number;
use super::function_calls;
use super::kinds::{Kind, Kinds, ONE_DIMENSION, is_zero};
use super::methods::Method;
use super::negative_spans;
use super::{FindingCollector, Program, walk};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity};
use crate::fix::Fix;
use crate::print::pattern_text;
use crate::suggest::renames;
use apex_model::condition::{Condition, ConditionKind, Quality, Timing};
use apex_model::expression::{Expr, ExprKind, Template};
use apex_model::pattern::Pattern;
use apex_model::procedure::{Activity, BuiltInActivity, Primitive, Procedure, Step};
use apex_model::quantity::Dimension;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::collections::BTreeMap;

pub(super) fn check(program: &Program<'_>, report: &mut FindingCollector<'_>) {
    walk::library(program.library, &mut |expr| {
        sums(program, expr, report);
        alternatives(program, expr, report);
        if let Some(diagnostic) = function_calls::mismatch(program.library, expr, &mut report.locator) {
            report.add(diagnostic);
        }
    });
    for procedure in &program.library.procedures {
        walk::conditions_of(procedure, &mut |condition| {
            comparisons(program, condition, report);
            spans_of_condition(condition, &mut |span| needs_span(program, span, report));
        });
        spans_of_procedure(procedure, &mut |span| needs_span(program, span, report));
        for expr in procedure.steps.iter().flat_map(plain_numbers).chain(&procedure.interrupt_cost) {
            needs_plain_number(program, expr, report);
        }
    }
    for primitive in &program.library.primitives {
        spans_of_primitive(primitive, &mut |span| {
            needs_span(program, span, report);
            let negative = negative_spans::of_primitive(program.library, span, &mut report.locator);
            negative.into_iter().for_each(|each| report.add(each));
        });
    }
    words(program, report);
}

fn sums(program: &Program<'_>, expr: &Expr, report: &mut FindingCollector<'_>) {
    let ExprKind::Call { function, arguments } = &expr.kind else { return };
    if arguments.len() < 2 || !ONE_DIMENSION.contains(&function.folded()) {
        return;
    }
    // The values of a function's parameters are unknown here: they are checked where the function is called.
    let mut first: Option<(Dimension, &Expr)> = None;
    for argument in arguments.iter().filter(|argument| !is_zero(argument)) {
        let Kind::Number(dimension) = Kinds::of(program.library, argument) else { continue };
        match first {
            None => first = Some((dimension, argument)),
            Some((known, other)) if known != dimension => {
                let (known, found) = (Kind::Number(known).words(), Kind::Number(dimension).words());
                let message = format!("cannot apply `{function}` to {known} and {found}");
                let diagnostic = Diagnostic::error(codes::DIMENSION, report.locator.span(argument.place), message)
                    .label(report.locator.span(other.place), format!("this is {known}"))
                    .reason("only values of one dimension can be added or compared");
                return report.add(diagnostic);
            }
            Some(_) => {}
        }
    }
}

/// Reports alternatives of an `or` that are numbers of different dimensions: `(or (current-value altitude uav) 0s)`.
fn alternatives(program: &Program<'_>, expr: &Expr, report: &mut FindingCollector<'_>) {
    let ExprKind::Or(parts) = &expr.kind else { return };
    let measured = |part| match Kinds::of(program.library, part) {
        Kind::Number(dimension) if dimension != Dimension::NONE && !is_zero(part) => Some((part, dimension)),
        _ => None,
    };
    let mut parts = parts.iter().filter_map(measured);
    let Some((first, known)) = parts.next() else { return };
    let Some((other, found)) = parts.find(|(_, dimension)| *dimension != known) else { return };
    let (known, found) = (Kind::Number(known).words(), Kind::Number(found).words());
    let message = format!("the alternatives of `or` are {known} and {found}");
    let diagnostic = Diagnostic::error(codes::DIMENSION, report.locator.span(other.place), message)
        .label(report.locator.span(first.place), format!("this is {known}"))
        .reason("the alternatives of one value have one dimension");
    report.add(diagnostic);
}

/// Checks right sides of comparisons with declared state variables.
fn comparisons(program: &Program<'_>, condition: &Condition, report: &mut FindingCollector<'_>) {
    let (attribute, lists) = match &condition.kind {
        ConditionKind::Measurement(measurement) => (&measurement.variable.attribute, vec![&measurement.value]),
        ConditionKind::Episode(episode) => {
            (&episode.variable.attribute, vec![&episode.value, &episode.first_value, &episode.last_value])
        }
        _ => return,
    };
    let declared = program.library.state_variables.get(attribute);
    let Some(declared) = declared.filter(|declared| declared.unit.is_some()) else { return };
    for right in lists.into_iter().flatten().flat_map(walk::sides) {
        let found = match Kinds::of(program.library, right) {
            Kind::Number(found) => found,
            Kind::Other(what) => {
                if let ExprKind::Indexical(name) = &right.kind
                    && !report.mistyped.insert((attribute.clone(), name.clone()))
                {
                    continue;
                }
                let wanted = Kind::Number(declared.dimension).words();
                let message = format!("`({attribute} ..)` is {wanted}, but this is {what}");
                let diagnostic = Diagnostic::error(codes::VALUE_TYPE, report.locator.span(right.place), message)
                    .label(report.locator.span(declared.place), format!("declared as {wanted} here"))
                    .fixes(constants_near(program, right, report))
                    .reason("its samples are numbers in its unit; others are refused");
                report.add(diagnostic);
                continue;
            }
            Kind::Unknown | Kind::Instant => continue,
        };
        // A bare number is in the variable's unit, however it is computed.
        if found != declared.dimension && found != Dimension::NONE {
            let wanted = Kind::Number(declared.dimension).words();
            let message = format!("`({attribute} ..)` is {wanted}, but this is {}", Kind::Number(found).words());
            let diagnostic = Diagnostic::error(codes::DIMENSION, report.locator.span(right.place), message)
                .label(report.locator.span(declared.place), format!("declared as {wanted} here"))
                .help_where(right, program, report);
            let unit = declared.unit.as_ref().map(|unit| format!("its values are in {}", unit.printed()));
            report.add(Diagnostic { reason: unit, ..diagnostic });
        }
    }
}

/// Returns the constants whose name is nearly this word.
fn constants_near(program: &Program<'_>, word: &Expr, report: &mut FindingCollector<'_>) -> Vec<Fix> {
    let ExprKind::Constant(Value::Symbol(name)) = &word.kind else { return Vec::new() };
    renames(report.locator.span(word.place), name.printed(), program.library.constants.keys().map(Symbol::printed))
}

impl Diagnostic {
    /// Shows where an indexical is defined.
    fn help_where(self, expr: &Expr, program: &Program<'_>, report: &mut FindingCollector<'_>) -> Diagnostic {
        let definition = match &expr.kind {
            ExprKind::Indexical(name) => program.library.indexicals.get(name),
            _ => None,
        };
        match definition {
            Some(definition) => self.label(report.locator.span(definition.place), "defined here"),
            None => self,
        }
    }
}

/// Expressions that must yield spans of time.
fn spans_of_condition<'c>(condition: &'c Condition, visit: &mut dyn FnMut(&'c Expr)) {
    let mut timing = |timing: &'c Timing| timing.duration.iter().flat_map(walk::sides).for_each(&mut *visit);
    match &condition.kind {
        ConditionKind::Episode(episode) => {
            timing(&episode.timing);
            if let Quality::MaximumGap(gap) = &episode.quality {
                visit(gap);
            }
        }
        ConditionKind::Event { timing: limits, .. } => timing(limits),
        ConditionKind::Delay(least, most) => std::iter::once(least).chain(most).for_each(visit),
        ConditionKind::Absent(_, span) => visit(span),
        _ => {}
    }
}

fn spans_of_procedure<'c>(procedure: &'c Procedure, visit: &mut dyn FnMut(&'c Expr)) {
    procedure.expected_duration.iter().for_each(&mut *visit);
    for step in &procedure.steps {
        for clause in step.repeating.iter().chain(&step.responding) {
            clause.recovery.iter().chain(&clause.minimum_interval).for_each(&mut *visit);
        }
    }
}

fn spans_of_primitive<'c>(primitive: &'c Primitive, visit: &mut dyn FnMut(&'c Expr)) {
    primitive.duration.iter().for_each(&mut *visit);
    primitive.update.iter().flat_map(|(interval, _)| interval).for_each(visit);
}

fn needs_span(program: &Program<'_>, expr: &Expr, report: &mut FindingCollector<'_>) {
    let kind = Kinds::of(program.library, expr);
    if kind == Kind::Unknown || kind == Kind::Number(Dimension::TIME) || is_zero(expr) {
        return;
    }
    let message = format!("a duration is needed here, but this is {}", kind.words());
    let diagnostic = Diagnostic::error(codes::DURATION_EXPECTED, report.locator.span(expr.place), message)
        .help_where(expr, program, report)
        .help("write a duration with its unit: `5s`, `P1M30S`, `(1 hr 30 min)`");
    report.add(diagnostic);
}

/// Priorities, ranks and interrupt costs: numbers without a dimension.
fn plain_numbers(step: &Step) -> impl Iterator<Item = &Expr> {
    walk::priorities(&step.priority).chain(step.rank.as_deref()).chain(step.interrupt_cost.as_deref())
}

fn needs_plain_number(program: &Program<'_>, expr: &Expr, report: &mut FindingCollector<'_>) {
    let kind = Kinds::of(program.library, expr);
    if kind == Kind::Unknown || kind == Kind::Number(Dimension::NONE) {
        return;
    }
    let message = format!("a plain number is needed here, but this is {}", kind.words());
    // The clause counts as absent, or the value as without unit; neither prevents a flight.
    let diagnostic = Diagnostic::new(Severity::Warning, codes::NOT_PLAIN, report.locator.span(expr.place), message)
        .reason("priorities, ranks and interrupt costs are compared with each other, whatever they are computed from")
        .help("write a number without unit, or divide: `(in-unit QUANTITY 'm)`");
    report.add(diagnostic);
}

/// Requirement of a procedure or primitive for a word of its goals.
#[derive(Clone, Copy)]
struct Requirement {
    dimension: Dimension,
    /// True if a bare number suffices: it has the unit of a state variable.
    or_bare: bool,
    /// True if a negative value fails.
    not_negative: bool,
    place: Place,
}

type Requirements<'l> = BTreeMap<&'l Symbol, Requirement>;

/// Reports goals whose words have another dimension than the procedures that serve them need.
fn words(program: &Program<'_>, report: &mut FindingCollector<'_>) {
    let mut of_procedures: Vec<Requirements<'_>> =
        program.library.procedures.iter().map(|procedure| of_procedure(program, procedure)).collect();
    let of_primitives: Vec<Requirements<'_>> =
        program.library.primitives.iter().map(|primitive| of_primitive(program, primitive)).collect();
    // Requirements are passed up from the serving procedure, one level at a time; programs have few levels.
    for _ in 0..LEVELS_MAX {
        let mut more: Vec<(usize, &Symbol, Requirement)> = Vec::new();
        for (number, procedure) in program.library.procedures.iter().enumerate() {
            for (index, step) in procedure.steps.iter().enumerate() {
                each_word(
                    program,
                    (number, index),
                    step,
                    &of_procedures,
                    &of_primitives,
                    &mut |word, requirement, _| {
                        if let Word::Hole(Expr { kind: ExprKind::Variable { name, .. }, .. }) = word
                            && of_procedures.get(number).is_some_and(|known| !known.contains_key(name))
                            && binds(&procedure.index, name)
                        {
                            more.push((number, name, requirement));
                        }
                    },
                );
            }
        }
        if more.is_empty() {
            break;
        }
        for (number, name, requirement) in more {
            if let Some(known) = of_procedures.get_mut(number) {
                known.entry(name).or_insert(requirement);
            }
        }
    }
    for (number, procedure) in program.library.procedures.iter().enumerate() {
        for (index, step) in procedure.steps.iter().enumerate() {
            let mut wrong: Vec<(Kind, Requirement, &Pattern)> = Vec::new();
            let mut negative = None;
            each_word(
                program,
                (number, index),
                step,
                &of_procedures,
                &of_primitives,
                &mut |word, requirement, served| {
                    let word = word.selected(step);
                    wrong.extend(word.misfit(program, requirement).map(|kind| (kind, requirement, served)));
                    if requirement.not_negative && word.is_negative_span(program) {
                        negative = Some((requirement, served));
                    }
                },
            );
            for (kind, requirement, served) in wrong {
                report_word(step, kind, requirement, served, report);
            }
            if let Some((requirement, served)) = negative {
                let negative = negative_spans::of_goal(step, requirement.place, served, &mut report.locator);
                report.add(negative);
            }
        }
    }
}

/// Levels of procedures through which a word is followed.
const LEVELS_MAX: usize = 4;

fn binds(index: &Pattern, name: &Symbol) -> bool {
    matches!(index, Pattern::List(parts) if parts.iter().any(|part| matches!(part, Pattern::Variable(each) if each == name)))
}

/// A word of a goal.
#[derive(Clone, Copy)]
enum Word<'l> {
    Value(&'l Value),
    Hole(&'l Expr),
    Rest,
}

impl<'l> Word<'l> {
    fn of(part: &'l Template) -> Word<'l> {
        match part {
            Template::Constant(value) => Word::Value(value),
            Template::Hole(expr) => Word::Hole(expr),
            Template::Splice(_) | Template::List(_) => Word::Rest,
        }
    }

    fn all(goal: &'l Template) -> Vec<Word<'l>> {
        match goal {
            Template::List(parts) => parts.iter().map(Word::of).collect(),
            Template::Constant(Value::List(items)) => items.iter().map(Word::Value).collect(),
            _ => Vec::new(),
        }
    }

    /// Returns the expression of the step's `select` if the word is the variable that it computes.
    fn selected(self, step: &'l Step) -> Word<'l> {
        let Word::Hole(Expr { kind: ExprKind::Variable { name, .. }, .. }) = self else { return self };
        step.select.iter().rev().find(|(selected, _)| selected == name).map_or(self, |(_, expr)| Word::Hole(expr))
    }

    /// Returns true for a span of time below zero that is computed from literals.
    fn is_negative_span(self, program: &Program<'l>) -> bool {
        let number = match self {
            Word::Value(value) => value.as_number(),
            Word::Hole(expr) => constant_number(program.library, expr),
            Word::Rest => None,
        };
        number.is_some_and(|(number, dimension)| number < 0.0 && dimension == Dimension::TIME)
    }

    /// Returns true if the expression is not a number of this dimension. A name may have any value, such as a setting of the vehicle.
    fn misfit(self, program: &Program<'l>, needed: Requirement) -> Option<Kind> {
        let (kind, is_zero) = match self {
            Word::Value(value) => match value.as_number() {
                Some((number, dimension)) => (Kind::Number(dimension), number == 0.0),
                None => return None,
            },
            Word::Hole(expr) => (Kinds::of(program.library, expr), is_zero(expr)),
            Word::Rest => return None,
        };
        let fits = kind == Kind::Number(needed.dimension) || needed.or_bare && kind == Kind::Number(Dimension::NONE);
        (kind != Kind::Unknown && !fits && !is_zero).then_some(kind)
    }
}

/// Visits the words of a step's goal for which the method that certainly serves it needs a dimension.
fn each_word<'l>(
    program: &Program<'l>,
    (number, index): (usize, usize),
    step: &'l Step,
    of_procedures: &[Requirements<'l>],
    of_primitives: &[Requirements<'l>],
    visit: &mut dyn FnMut(Word<'l>, Requirement, &'l Pattern),
) {
    let Activity::Goal(goal) = &step.activity else { return };
    let Some([method]) = program.methods.serving_step(number, index) else { return };
    let requirements = match method {
        Method::Procedure(served) => of_procedures.get(*served),
        Method::Primitive(served) => of_primitives.get(*served),
        Method::Solver(_) => None,
    };
    let Some(requirements) = requirements.filter(|each| !each.is_empty() && program.methods.surely(goal, *method))
    else {
        return;
    };
    let Some(served @ Pattern::List(parts)) = program.methods.index(*method) else { return };
    let words = Word::all(goal);
    if parts.len() == words.len() {
        for (part, word) in parts.iter().zip(words) {
            if let Pattern::Variable(name) = part
                && let Some(requirement) = requirements.get(name)
            {
                visit(word, *requirement, served);
            }
        }
    }
}

fn report_word(step: &Step, kind: Kind, requirement: Requirement, served: &Pattern, report: &mut FindingCollector<'_>) {
    let wanted = Kind::Number(requirement.dimension).words();
    let code = if requirement.dimension == Dimension::TIME { codes::DURATION_EXPECTED } else { codes::DIMENSION };
    let index = pattern_text(served);
    let message = format!("`{index}` needs {wanted}, but a word of this goal is {}", kind.words());
    let diagnostic = Diagnostic::error(code, report.locator.activity(step.place), message)
        .label(report.locator.span(requirement.place), format!("{wanted} is needed here"))
        .help("write the value with the unit that is needed");
    report.add(diagnostic);
}

fn note<'l>(requirements: &mut Requirements<'l>, expr: &'l Expr, dimension: Dimension, or_bare: bool) {
    if let ExprKind::Variable { name, .. } = &expr.kind {
        let not_negative = false;
        requirements.entry(name).or_insert(Requirement { dimension, or_bare, not_negative, place: expr.place });
    }
}

fn of_primitive<'l>(_: &Program<'l>, primitive: &'l Primitive) -> Requirements<'l> {
    let mut requirements = BTreeMap::new();
    spans_of_primitive(primitive, &mut |span| note(&mut requirements, span, Dimension::TIME, false));
    requirements.values_mut().for_each(|each| each.not_negative = true);
    requirements
}

fn of_procedure<'l>(program: &Program<'l>, procedure: &'l Procedure) -> Requirements<'l> {
    let mut requirements = BTreeMap::new();
    spans_of_procedure(procedure, &mut |span| note(&mut requirements, span, Dimension::TIME, false));
    walk::conditions_of(procedure, &mut |condition| {
        spans_of_condition(condition, &mut |span| note(&mut requirements, span, Dimension::TIME, false));
        let (attribute, value) = match &condition.kind {
            ConditionKind::Measurement(measurement) => (&measurement.variable.attribute, &measurement.value),
            ConditionKind::Episode(episode) => (&episode.variable.attribute, &episode.value),
            _ => return,
        };
        if let Some(declared) = program.library.state_variables.get(attribute).filter(|each| each.unit.is_some()) {
            value
                .iter()
                .flat_map(walk::sides)
                .for_each(|right| note(&mut requirements, right, declared.dimension, true));
        }
    });
    for step in &procedure.steps {
        if let Activity::BuiltIn(BuiltInActivity::Plan, arguments) = &step.activity {
            arguments.get(2).into_iter().for_each(|budget| note(&mut requirements, budget, Dimension::TIME, false));
        }
    }
    requirements.retain(|name, _| binds(&procedure.index, name));
    requirements
}
