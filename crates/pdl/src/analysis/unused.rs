//! Definitions without use: variables, and, in a program with agents, whole definitions.

use super::bound::by_pattern;
use super::methods::Method;
use super::{FindingCollector, Program, walk};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity, Span};
use crate::fix::Fix;
use crate::locate::each;
use crate::print::pattern_text;
use crate::suggest::{is_certain, near};
use apex_forms::variables;
use apex_model::condition::{Condition, ConditionKind, Constraint};
use apex_model::expression::{Expr, ExprKind, Template};
use apex_model::library::Library;
use apex_model::pattern::Pattern;
use apex_model::procedure::{Activity, BuiltInActivity, Procedure};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::collections::{BTreeMap, BTreeSet};

pub(super) fn check(program: &Program<'_>, report: &mut FindingCollector<'_>) {
    let is_own = |place: Place| !program.foreign.contains(&place.file);
    for procedure in program.library.procedures.iter().filter(|each| is_own(each.place)) {
        variables_of(procedure, report);
    }
    let in_libraries = program.library.indexicals.values().map(|expr| (expr.place, expr));
    let functions = program.library.functions.values().flat_map(|each| each.body.iter().map(|expr| (each.place, expr)));
    for (_, expr) in in_libraries.chain(functions).filter(|(place, _)| is_own(*place)) {
        walk::expr(expr, &mut |expr| unused_let(expr, report));
    }
    let names = UsedNames::of(program.library);
    parameters(program, &names, report);
    if !program.library.agents.is_empty() {
        definitions(program, &names, report);
    }
}

/// Reports parameters of functions that their bodies do not use. The callers of functions that are passed as values, serve as predicates or
/// compute `:costs` fix the number of arguments; a parameter whose name begins with `_` is meant to be unused.
fn parameters(program: &Program<'_>, names: &UsedNames<'_>, report: &mut FindingCollector<'_>) {
    let is_own = |place: Place| !program.foreign.contains(&place.file);
    for (name, function) in &program.library.functions {
        if !is_own(function.place) || names.passed.contains(name) {
            continue;
        }
        let mut used: BTreeSet<Symbol> = BTreeSet::new();
        let defaults = function.parameters.optional.iter().filter_map(|(_, default)| default.as_ref());
        walk::exprs(defaults.chain(&function.body), &mut |part| {
            if let ExprKind::Local(each) | ExprKind::Assign { name: each, of_task: false, .. } = &part.kind {
                used.insert(each.clone());
            }
        });
        let is_meant = |name: &Symbol| name.printed().starts_with('_');
        for parameter in function.parameters.names().filter(|each| !used.contains(*each) && !is_meant(each)) {
            let span = report.locator.word(function.place, parameter);
            let message = format!("parameter `{parameter}` of `{name}` is never used");
            let diagnostic = Diagnostic::new(Severity::Warning, codes::UNUSED_VARIABLE, span, message)
                .help(format!("use it in the body, or remove it; `_{parameter}` marks it as unused on purpose"));
            report.add(diagnostic);
        }
    }
}

/// Reports selected variables and results that no clause uses.
fn variables_of(procedure: &Procedure, report: &mut FindingCollector<'_>) {
    let gives = |step: &apex_model::procedure::Step| !step.select.is_empty() || step.binds.is_some();
    if procedure.steps.iter().any(gives) {
        let mut used: BTreeSet<Symbol> = BTreeSet::new();
        let mut note = |name: &Symbol| {
            used.insert(name.clone());
        };
        uses_of(procedure, &mut note);
        for step in &procedure.steps {
            for (name, _) in step.select.iter().filter(|(name, _)| !used.contains(name)) {
                let span = report.locator.variable_in_clause(step.place, "select", name);
                let message = format!("`?{name}` is never used");
                let diagnostic = Diagnostic::new(Severity::Warning, codes::UNUSED_VARIABLE, span, message)
                    .help("use it in the step, or remove the `select`");
                let clause = report.locator.clause(step.place, "select");
                let only = step.select.len() == 1;
                let fix = only.then(|| Fix::look("remove the `select`").replace(clause, ""));
                report.add(diagnostic.fixes(fix));
            }
            let results = step.binds.as_deref().map(by_pattern).unwrap_or_default();
            for name in results.surely.into_iter().filter(|name| !used.contains(name)) {
                let span = report.locator.variable(step.place, name);
                let message = format!("`?{name}` is never used");
                let diagnostic = Diagnostic::new(Severity::Warning, codes::UNUSED_VARIABLE, span, message)
                    .reason("no clause of this procedure needs the result of the step")
                    .help("remove the `=>`, or write `?` for a part that is not needed");
                let diagnostic = match misspelt_use(procedure, name, report) {
                    Some((span, other)) => diagnostic
                        .label(span, format!("`?{other}` occurs only here"))
                        .fix(Fix::look(format!("replace `?{other}` by `?{name}`")).replace(span, format!("?{name}"))),
                    None => diagnostic,
                };
                let result = report.locator.result(step.place, name);
                report.add(diagnostic.fixes(result.map(|result| Fix::look("remove the `=>`").replace(result, ""))));
            }
        }
    }
    walk::procedure(procedure, &mut |expr| unused_let(expr, report));
}

/// Returns a variable that occurs once in the procedure and is certainly a misspelling of `name`.
fn misspelt_use(procedure: &Procedure, name: &Symbol, report: &mut FindingCollector<'_>) -> Option<(Span, Symbol)> {
    let datum = report.locator.datum(procedure.place)?;
    let mut found: BTreeMap<Symbol, (usize, Span)> = BTreeMap::new();
    each(&datum, &mut |part| {
        if let Some(variable) = part.as_variable() {
            found.entry(variable.clone()).or_insert((0, part.span)).0 += 1;
        }
    });
    let is_tag = |variable: &Symbol| procedure.steps.iter().any(|step| step.tag == *variable);
    found.retain(|variable, (count, _)| *count == 1 && variable != name && !is_tag(variable));
    let nearest = near(name.printed(), found.keys().map(Symbol::printed));
    let first = nearest.first().filter(|_| is_certain(name.printed(), &nearest))?;
    let other = Symbol::new(first.name);
    found.get(&other).map(|(_, span)| (*span, other.clone()))
}

/// Collects every variable that a clause of the procedure uses; a `=>` or a `select` that gives a value is not a use.
fn uses_of(procedure: &Procedure, note: &mut dyn FnMut(&Symbol)) {
    let mut exprs: Vec<&Expr> = Vec::new();
    walk::procedure(procedure, &mut |expr| exprs.push(expr));
    for expr in exprs {
        if let ExprKind::Variable { name, .. } = &expr.kind {
            note(name);
        }
    }
    walk::transitions(&procedure.transitions).for_each(|(_, each)| variables::of_condition(each, note));
    for step in &procedure.steps {
        step.waitfor.iter().for_each(|each| variables::of_condition(each, note));
        walk::transitions(&step.transitions).for_each(|(_, each)| variables::of_condition(each, note));
        step.repeating.iter().chain(&step.responding).flat_map(|clause| &clause.for_new).for_each(&mut *note);
        // A result that must equal the variable's present value is a use of that variable.
        if let Some(Pattern::BoundVariable(name)) = step.binds.as_deref() {
            note(name);
        }
    }
}

fn unused_let(expr: &Expr, report: &mut FindingCollector<'_>) {
    let ExprKind::Let { bindings, body, .. } = &expr.kind else { return };
    for (order, (name, _)) in bindings.iter().enumerate() {
        let later = bindings.iter().skip(order + 1).map(|(_, value)| value);
        let mut used = false;
        walk::exprs(later.chain(body), &mut |part| {
            used |= match &part.kind {
                ExprKind::Local(each) | ExprKind::Assign { name: each, of_task: false, .. } => each == name,
                _ => false,
            };
        });
        if !used {
            let span = report.locator.word(expr.place, name);
            let message = format!("`{name}` is never used");
            let diagnostic = Diagnostic::new(Severity::Warning, codes::UNUSED_VARIABLE, span, message)
                .help("remove it from the `let`");
            report.add(diagnostic);
        }
    }
}

/// Reports procedures, primitives, functions, indexicals and resources of the program that nothing in it uses.
fn definitions(program: &Program<'_>, names: &UsedNames<'_>, report: &mut FindingCollector<'_>) {
    let library = program.library;
    let is_own = |place: Place| !program.foreign.contains(&place.file);
    let add = |place: Place, report: &mut FindingCollector<'_>, what: String, reason: &str| {
        let span = report.locator.head_line(place);
        let diagnostic = Diagnostic::new(Severity::Warning, codes::UNUSED_DEFINITION, span, what);
        report.add(diagnostic.reason(reason).help("remove it, or check the spelling where it should be used"));
    };
    // With solvers a plan may pursue any goal, so nothing is certainly unused.
    if library.solvers.is_empty()
        && let Some(reached) = reached(program)
    {
        let reason = "it serves no goal that an agent can pursue";
        for (number, each) in library.procedures.iter().enumerate() {
            if is_own(each.place) && !reached.contains(&Method::Procedure(number)) {
                add(each.place, report, format!("`{}` is never pursued", pattern_text(&each.index)), reason);
            }
        }
        for (number, each) in library.primitives.iter().enumerate() {
            if is_own(each.place) && !reached.contains(&Method::Primitive(number)) {
                add(each.place, report, format!("`{}` is never pursued", pattern_text(&each.index)), reason);
            }
        }
    }
    for (name, function) in &library.functions {
        if is_own(function.place) && !names.functions.contains(name) {
            add(function.place, report, format!("function `{name}` is never called"), "no expression names it");
        }
    }
    for (name, expr) in &library.indexicals {
        if is_own(expr.place) && !names.indexicals.contains(name) {
            add(expr.place, report, format!("`+{name}+` is never used"), "no expression names it");
        }
    }
    for (name, resource) in &library.resources {
        let may_be_passed = || names.any_resource && is_written_again(program, name);
        if is_own(resource.place) && !names.resources.contains(name) && !may_be_passed() {
            add(resource.place, report, format!("resource `{name}` is never needed"), "no profile names it");
        }
    }
}

/// Returns true if the program's own files have the word more often than in its declaration, so that a profile such as `(profile ?camera)`
/// may be given it.
fn is_written_again(program: &Program<'_>, name: &Symbol) -> bool {
    let is_part = |letter: char| letter.is_alphanumeric() || "-_+*?:".contains(letter);
    let own = (0..).zip(&program.library.sources).filter(|(file, _)| !program.foreign.contains(file));
    let mut words = own.flat_map(|(_, source)| source.text.split(|letter: char| !is_part(letter)));
    words.by_ref().filter(|word| word.eq_ignore_ascii_case(name.printed())).nth(1).is_some()
}

/// Returns all methods that agents may pursue; `None` if a goal may have any form.
fn reached(program: &Program<'_>) -> Option<BTreeSet<Method>> {
    let library = program.library;
    let mut reached: BTreeSet<Method> = BTreeSet::new();
    let mut open: Vec<Method> = Vec::new();
    for agent in &library.agents {
        open.extend(program.methods.serving(&Template::Constant(agent.initial_task.clone()))?);
    }
    while let Some(method) = open.pop() {
        if !reached.insert(method) {
            continue;
        }
        let Method::Procedure(number) = method else { continue };
        let procedure = library.procedures.get(number)?;
        let mut probes = Vec::new();
        walk::probes(procedure, &mut |_, goal| probes.push(goal));
        for goal in probes {
            open.extend(program.methods.serving(goal)?);
        }
        for (index, step) in procedure.steps.iter().enumerate() {
            match (&step.activity, step.on_failure.as_deref()) {
                (Activity::BuiltIn(BuiltInActivity::Plan, _), _)
                | (_, Some(Activity::BuiltIn(BuiltInActivity::Plan, _))) => {
                    return None;
                }
                (activity, handler) => {
                    if let Activity::Goal(_) = activity {
                        open.extend(program.methods.serving_step(number, index)?);
                    }
                    if let Some(Activity::Goal(goal)) = handler {
                        open.extend(program.methods.serving(goal)?);
                    }
                }
            }
        }
    }
    Some(reached)
}

/// Names that expressions and profiles use.
#[derive(Default)]
struct UsedNames<'l> {
    functions: BTreeSet<&'l Symbol>,
    /// Functions whose callers fix the number of arguments: values, predicates, and those of `:costs`.
    passed: BTreeSet<&'l Symbol>,
    indexicals: BTreeSet<&'l Symbol>,
    resources: BTreeSet<&'l Symbol>,
    /// True if a profile names a resource by a variable.
    any_resource: bool,
}

impl<'l> UsedNames<'l> {
    fn of(library: &'l Library) -> UsedNames<'l> {
        let mut names = UsedNames::default();
        let mut exprs: Vec<&Expr> = Vec::new();
        walk::library(library, &mut |expr| exprs.push(expr));
        for expr in exprs {
            match &expr.kind {
                ExprKind::Call { function, .. } => {
                    names.functions.insert(function);
                }
                ExprKind::FunctionName(function) => {
                    names.functions.insert(function);
                    names.passed.insert(function);
                }
                ExprKind::Indexical(name) => {
                    names.indexicals.insert(name);
                }
                _ => {}
            }
        }
        // `:costs ((TARGET FUNCTION) ..)`
        let costs = library.application.iter().filter_map(|application| application.option("costs")?.as_list());
        for name in costs.flatten().filter_map(|pair| pair.as_list()?.get(1)?.as_symbol()) {
            names.functions.insert(name);
            names.passed.insert(name);
        }
        for procedure in &library.procedures {
            names.predicates(&procedure.index);
            walk::conditions_of(procedure, &mut |condition| names.condition(condition));
            names.needs(&procedure.profile);
            for step in &procedure.steps {
                names.needs(&step.profile);
                step.binds.iter().for_each(|pattern| names.predicates(pattern));
                if let Activity::BuiltIn(BuiltInActivity::HoldResource, arguments) = &step.activity {
                    arguments.iter().for_each(|argument| names.held(argument));
                }
            }
        }
        for primitive in &library.primitives {
            names.predicates(&primitive.index);
            names.needs(&primitive.profile);
        }
        names
    }

    fn needs(&mut self, profile: &'l [apex_model::procedure::ResourceNeed]) {
        for need in profile {
            match &need.resource {
                Template::Constant(Value::Symbol(name)) => {
                    self.resources.insert(name);
                }
                _ => self.any_resource = true,
            }
        }
    }

    fn held(&mut self, argument: &'l Expr) {
        match &argument.kind {
            ExprKind::Constant(Value::Symbol(name)) => {
                self.resources.insert(name);
            }
            _ => self.any_resource = true,
        }
    }

    fn predicates(&mut self, pattern: &'l Pattern) {
        match pattern {
            Pattern::Is { predicate, .. } => {
                self.functions.insert(predicate);
                self.passed.insert(predicate);
            }
            Pattern::List(parts) | Pattern::And(parts) | Pattern::Or(parts) => {
                parts.iter().for_each(|part| self.predicates(part));
            }
            Pattern::Not(part) => self.predicates(part),
            _ => {}
        }
    }

    fn constraints(&mut self, constraints: &'l [Constraint]) {
        for constraint in constraints {
            match constraint {
                Constraint::Predicate(function, _) => {
                    self.functions.insert(function);
                    self.passed.insert(function);
                }
                Constraint::Matches(pattern) => self.predicates(pattern),
                Constraint::Compare { .. } | Constraint::Range(..) => {}
            }
        }
    }

    fn condition(&mut self, condition: &'l Condition) {
        match &condition.kind {
            ConditionKind::Measurement(measurement) => {
                self.predicates(&measurement.variable.object);
                for each in [&measurement.value, &measurement.object, &measurement.timestamp] {
                    self.constraints(each);
                }
            }
            ConditionKind::Episode(episode) => {
                self.predicates(&episode.variable.object);
                let timing = [&episode.timing.start, &episode.timing.end, &episode.timing.duration];
                let values = [&episode.value, &episode.first_value, &episode.last_value, &episode.object];
                values.into_iter().chain(timing).for_each(|each| self.constraints(each));
                episode.stats.iter().chain(&episode.trend).for_each(|(_, each)| self.constraints(each));
            }
            ConditionKind::Event { pattern, timing } => {
                self.predicates(pattern);
                [&timing.start, &timing.end, &timing.duration].into_iter().for_each(|each| self.constraints(each));
            }
            ConditionKind::TaskState { state, .. } => self.predicates(state),
            _ => walk::options(&condition.kind).iter().for_each(|(_, each)| self.constraints(each)),
        }
    }
}
