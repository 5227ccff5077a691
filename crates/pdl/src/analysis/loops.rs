//! Diagnostics of endless loops: repetitions and recursions at one instant, steps that answer their own messages, and
//! procedures whose goals lead back to themselves.

use super::endings::{ends_procedure, is_end_of, is_endless, is_plain, is_plain_step, known_truth};
use super::horn::{Horn, HornAtom};
use super::methods::Method;
use super::{FindingCollector, Program};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity};
use crate::fix::Fix;
use crate::locate::closing;
use crate::matching::{View, must_match};
use crate::print::{pattern_text, template_text};
use apex_forms::variables;
use apex_model::condition::{ConditionKind, Timing};
use apex_model::expression::{Expr, ExprKind, Template};
use apex_model::limits::TASK_DEPTH_MAX;
use apex_model::pattern::Pattern;
use apex_model::procedure::{Activity, BuiltInActivity, Procedure, ProcedureKind, Repetition, Step};
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::collections::{BTreeMap, BTreeSet};

/// Reports all endless loops, and returns the procedures that certainly begin an endless recursion.
pub(super) fn check(program: &Program<'_>, report: &mut FindingCollector<'_>) -> BTreeSet<usize> {
    let mut reported = BTreeSet::new();
    let mut caught = recursion(program, true, &mut reported, report);
    caught.extend(recursion(program, false, &mut reported, report));
    for (number, procedure) in program.library.procedures.iter().enumerate() {
        repetitions(program, number, procedure, report);
        answers(program, number, procedure, report);
    }
    caught
}

/// Reports repeating steps whose activity takes no mission time.
fn repetitions(program: &Program<'_>, number: usize, procedure: &Procedure, report: &mut FindingCollector<'_>) {
    for (index, step) in procedure.steps.iter().enumerate() {
        let Some(clause) = step.repeating.as_deref().filter(|clause| is_endless(clause)) else { continue };
        let at_once = is_plain_step(step) && step.waitfor.is_empty() && !has_interval(clause);
        let ends = ends_procedure(&step.activity) || step.on_failure.is_some();
        if !at_once || ends || !program.endings.activity_takes_no_time(number, index) {
            continue;
        }
        let said = SentMessages::by(program, number, index);
        let announces = said.others || !said.forms.is_empty();
        // A message of the step may cause another task to end it.
        let severity = if announces { Severity::Warning } else { Severity::Error };
        let span = report.locator.clause(step.place, "repeating");
        let diagnostic =
            Diagnostic::new(severity, codes::ENDLESS_REPETITION, span, "this step repeats without end at one instant")
                .label(
                    report.locator.activity(step.place),
                    "the procedures and primitives that serve this take no time",
                )
                .help("add `:with-min-interval D`, `:until T`, or a waitfor");
        let fix = Fix::look("let time pass between repetitions").insert_before(closing(span), " :with-min-interval 1s");
        report.add(diagnostic.fix(fix));
    }
}

fn has_interval(clause: &Repetition) -> bool {
    let zero = |value: &Value| value.as_number().is_some_and(|(number, _)| number <= 0.0);
    clause.minimum_interval.as_ref().is_some_and(|interval| match &interval.kind {
        ExprKind::Constant(value) => !zero(value),
        _ => true,
    })
}

/// Returns the procedures that certainly pursue their own goal, or lead to one that does. `at_once` restricts the search to
/// loops that take no mission time. Procedures that a diagnostic names are added to `reported`.
fn recursion(
    program: &Program<'_>,
    at_once: bool,
    reported: &mut BTreeSet<usize>,
    report: &mut FindingCollector<'_>,
) -> BTreeSet<usize> {
    let mut horn = Horn::default();
    let procedures = &program.library.procedures;
    let sure: Vec<Vec<usize>> =
        procedures.iter().enumerate().map(|(number, each)| sure_goals(program, number, each, at_once)).collect();
    let escapes: Vec<HornAtom> = sure.iter().map(|steps| horn.all(steps.len())).collect();
    let serving = |procedure: usize, step: usize| -> Option<Vec<usize>> {
        let Activity::Goal(goal) = &procedures.get(procedure)?.steps.get(step)?.activity else { return None };
        let methods = program.methods.serving_step(procedure, step)?;
        methods.iter().any(|method| program.methods.surely(goal, *method)).then_some(())?;
        let only_procedures = methods.iter().map(|method| match method {
            Method::Procedure(number) => Some(*number),
            Method::Primitive(_) | Method::Solver(_) => None,
        });
        only_procedures.collect()
    };
    for ((number, steps), escape) in sure.iter().enumerate().zip(&escapes) {
        for step in steps {
            let way_out = match serving(number, *step) {
                None => horn.fact(),
                Some(served) => {
                    let node = horn.any();
                    served.iter().filter_map(|each| escapes.get(*each)).for_each(|each| horn.rule(*each, node));
                    node
                }
            };
            horn.rule(way_out, *escape);
        }
    }
    let solution = horn.solve();
    let caught = |number: usize| escapes.get(number).is_some_and(|node| !solution.holds(*node));
    let next = |number: usize| -> Option<(usize, usize)> {
        let steps = sure.get(number)?;
        steps.iter().find_map(|step| {
            let served = serving(number, *step)?;
            served.iter().all(|each| caught(*each)).then(|| served.first().map(|first| (*step, *first)))?
        })
    };
    let mut seen: BTreeMap<usize, usize> = BTreeMap::new();
    for start in (0..procedures.len()).filter(|number| caught(*number)) {
        let mut path: Vec<(usize, usize)> = Vec::new();
        let mut number = start;
        while !seen.contains_key(&number) {
            seen.insert(number, start);
            let Some((step, following)) = next(number) else { break };
            path.push((number, step));
            number = following;
        }
        if seen.get(&number) == Some(&start)
            && let Some(first) = path.iter().position(|(each, _)| *each == number)
        {
            let circle = path.split_off(first);
            if circle.iter().all(|(each, _)| !reported.contains(each)) {
                reported.extend(circle.iter().map(|(each, _)| *each));
                report_recursion(program, &circle, at_once, report);
            }
        }
    }
    (0..procedures.len()).filter(|number| caught(*number)).collect()
}

/// Returns the indices of the steps whose goals are pursued in every run of the procedure.
fn sure_goals(program: &Program<'_>, number: usize, procedure: &Procedure, at_once: bool) -> Vec<usize> {
    let is_free = if at_once { is_plain(procedure) } else { procedure.transitions.end_when.is_none() };
    let is_sequence = procedure.kind == ProcedureKind::Sequential;
    let ends_early = !is_sequence && !at_once && procedure.steps.iter().any(|step| ends_procedure(&step.activity));
    let has_goal = |step: &Step| matches!(step.activity, Activity::Goal(_));
    if !is_free || ends_early || !procedure.steps.iter().any(has_goal) {
        return Vec::new();
    }
    let results: BTreeSet<Symbol> = results_of(procedure);
    let mut sure = Vec::new();
    for (index, step) in procedure.steps.iter().enumerate() {
        let waits_for_steps = step.waitfor.iter().all(|each| is_end_of(each).is_some());
        let waits = !step.waitfor.is_empty() || !is_sequence && mentions(step, &results);
        let plain = is_plain_step(step) || !at_once && step.transitions.end_when.is_none();
        let begins = plain && step.forall.is_none() && if at_once { !waits } else { waits_for_steps };
        if is_sequence && ends_procedure(&step.activity) {
            break;
        }
        if begins && has_goal(step) {
            sure.push(index);
        }
        // In a sequence the next step begins at once only after a step that takes no time.
        let takes_no_time = program.endings.activity_takes_no_time(number, index) && step.repeating.is_none();
        if is_sequence && (!begins || at_once && !takes_no_time) {
            break;
        }
    }
    sure
}

fn results_of(procedure: &Procedure) -> BTreeSet<Symbol> {
    let mut names = BTreeSet::new();
    for pattern in procedure.steps.iter().filter_map(|step| step.binds.as_deref()) {
        variables::of_pattern(pattern, &mut |name| {
            names.insert(name.clone());
        });
    }
    names
}

fn mentions(step: &Step, names: &BTreeSet<Symbol>) -> bool {
    let mut found = false;
    if !names.is_empty() {
        let mut look = |name: &Symbol| found |= names.contains(name);
        variables::of_activity(&step.activity, &mut look);
        step.select.iter().for_each(|(_, value)| variables::of_expr(value, &mut look));
    }
    found
}

fn report_recursion(
    program: &Program<'_>,
    circle: &[(usize, usize)],
    at_once: bool,
    report: &mut FindingCollector<'_>,
) {
    let procedures = &program.library.procedures;
    let Some((first, step)) = circle.first().and_then(|(number, step)| {
        let procedure = procedures.get(*number)?;
        Some((procedure, procedure.steps.get(*step)?))
    }) else {
        return;
    };
    let index = pattern_text(&first.index);
    let span = report.locator.activity(step.place);
    let (severity, code, how) = if at_once {
        (Severity::Error, codes::ENDLESS_REPETITION, "without end, at one instant")
    } else {
        (Severity::Warning, codes::ENDLESS_RECURSION, "without end")
    };
    let message = format!("`{index}` pursues itself {how}");
    let mut diagnostic = Diagnostic::new(severity, code, span, message);
    for (number, step) in circle.iter().skip(1) {
        let Some(step) = procedures.get(*number).and_then(|procedure| procedure.steps.get(*step)) else { continue };
        if let Activity::Goal(goal) = &step.activity {
            let label = format!("through `{}` here", template_text(goal));
            diagnostic = diagnostic.label(report.locator.activity(step.place), label);
        }
    }
    let reason =
        format!("each task begins the next one as its subtask, and tasks are nested {TASK_DEPTH_MAX} deep at most");
    diagnostic = diagnostic.reason(reason).help(if at_once {
        "write a procedure for the case in which the recursion ends, or let the step wait for a condition"
    } else {
        "to repeat an activity, give its step the clause `(repeating)`"
    });
    report.add(diagnostic);
}

/// Reports steps that answer a message by sending a message that they, or steps that they trigger, answer again.
fn answers(program: &Program<'_>, number: usize, procedure: &Procedure, report: &mut FindingCollector<'_>) {
    let mut given = BTreeSet::new();
    variables::of_pattern(&procedure.index, &mut |name| {
        given.insert(name.clone());
    });
    let mut reactive: Vec<(usize, &Pattern, Vec<Template>)> = Vec::new();
    for (index, step) in procedure.steps.iter().enumerate() {
        let Some(awaited) = answered_form(step, &given) else { continue };
        if program.endings.activity_takes_no_time(number, index) && !ends_procedure(&step.activity) {
            reactive.push((index, awaited, SentMessages::by(program, number, index).forms));
        }
        if reactive.len() == REACTIVE_MAX {
            break;
        }
    }
    let follows = |from: usize| -> Option<usize> {
        let (_, _, said) = reactive.get(from)?;
        reactive.iter().position(|(_, awaited, _)| said.iter().any(|form| must_match(View::Template(form), awaited)))
    };
    let mut seen: BTreeMap<usize, usize> = BTreeMap::new();
    for start in 0..reactive.len() {
        let mut path = Vec::new();
        let mut next = Some(start);
        while let Some(at) = next {
            if let Some(walk) = seen.get(&at) {
                if *walk == start {
                    let first = path.iter().position(|each| *each == at).unwrap_or(0);
                    report_answers(procedure, &reactive, &path.split_off(first), report);
                }
                break;
            }
            seen.insert(at, start);
            path.push(at);
            next = follows(at);
        }
    }
}

/// Maximum number of steps of one procedure whose messages are compared with each other.
const REACTIVE_MAX: usize = 100;

/// Returns the message pattern that starts the step each time a message matches; `None` if the step also needs anything else.
fn answered_form<'p>(step: &'p Step, given: &BTreeSet<Symbol>) -> Option<&'p Pattern> {
    let clause = step.repeating.as_deref().or(step.responding.as_deref())?;
    let [condition] = step.waitfor.as_slice() else { return None };
    let ConditionKind::Event { pattern, timing } = &condition.kind else { return None };
    let bounded =
        !is_endless(clause) || !clause.for_new.is_empty() || has_interval(clause) || **timing != Timing::default();
    let mut fixed = false;
    variables::of_pattern(pattern, &mut |name| fixed |= given.contains(name));
    let free = !bounded && !fixed && is_plain_step(step) && step.forall.is_none() && step.on_failure.is_none();
    (free && known_truth(clause.enabled.as_ref()) != Some(true)).then_some(pattern)
}

fn report_answers(
    procedure: &Procedure,
    reactive: &[(usize, &Pattern, Vec<Template>)],
    circle: &[usize],
    report: &mut FindingCollector<'_>,
) {
    let steps: Vec<&Step> = circle.iter().filter_map(|at| procedure.steps.get(reactive.get(*at)?.0)).collect();
    let Some((first, others)) = steps.split_first() else { return };
    let names: Vec<String> = steps.iter().map(|step| format!("`{}`", step.tag)).collect();
    let message = match names.as_slice() {
        [one] => format!("{one} answers its own message, without end at one instant"),
        several => format!("{} answer each other's messages, without end at one instant", several.join(" and ")),
    };
    let span = report.locator.clause(first.place, "waitfor");
    let mut diagnostic = Diagnostic::error(codes::ENDLESS_REPETITION, span, message)
        .label(report.locator.activity(first.place), "this sends a message that the step answers");
    for other in others {
        diagnostic = diagnostic.label(report.locator.clause(other.place, "waitfor"), "this step answers that message");
    }
    report.add(diagnostic.help("let the answer be another message, or add `:for-new ?x` or `:while TEST`"));
}

/// Messages that a step sends while it is executed.
#[derive(Default)]
struct SentMessages {
    /// Messages that the step certainly sends.
    forms: Vec<Template>,
    /// True if the step may send further messages or end other tasks.
    others: bool,
    /// Methods that enclose the inspected step: a recursive method is inspected once.
    stack: Vec<Method>,
    /// Number of steps inspected so far.
    steps: usize,
}

/// Maximum number of descendants of a step that are inspected for messages.
const SAYING_MAX: usize = 1_000;

impl SentMessages {
    fn by(program: &Program<'_>, procedure: usize, step: usize) -> SentMessages {
        let mut said = SentMessages::default();
        said.step(program, procedure, step);
        said
    }

    fn step(&mut self, program: &Program<'_>, procedure: usize, number: usize) {
        self.steps += 1;
        let step = program.library.procedures.get(procedure).and_then(|each| each.steps.get(number));
        let Some(step) = step.filter(|_| self.steps < SAYING_MAX) else {
            self.others = true;
            return;
        };
        self.body(&step.hooks.on_start);
        self.body(&step.hooks.on_end);
        match &step.activity {
            Activity::BuiltIn(BuiltInActivity::Inform | BuiltInActivity::Cogevent, arguments) => {
                self.others |= arguments.len() > 1;
                self.forms.extend(arguments.first().filter(|_| arguments.len() == 1).and_then(form));
            }
            Activity::BuiltIn(BuiltInActivity::Print, _) | Activity::Terminate { task: None, .. } => {}
            Activity::BuiltIn(..) | Activity::Terminate { .. } => self.others = true,
            Activity::Goal(goal) => match program.methods.serving_step(procedure, number).unwrap_or_default() {
                [method] if program.methods.surely(goal, *method) => self.method(program, *method),
                _ => self.others = true,
            },
        }
    }

    fn method(&mut self, program: &Program<'_>, method: Method) {
        if self.stack.contains(&method) {
            self.others = true;
            return;
        }
        self.stack.push(method);
        match method {
            Method::Procedure(number) => {
                if let Some(served) = program.library.procedures.get(number) {
                    self.body(&served.hooks.on_start);
                    (0..served.steps.len()).for_each(|index| self.step(program, number, index));
                }
            }
            Method::Primitive(number) => {
                if let Some(served) = program.library.primitives.get(number) {
                    self.body(&served.hooks.on_start);
                    self.body(&served.on_completion);
                }
            }
            Method::Solver(_) => self.others = true,
        }
        self.stack.pop();
    }

    /// Adds the messages of a hook. Only direct calls certainly run; any other expression sets `others`.
    fn body(&mut self, body: &[Expr]) {
        for expr in body {
            match &expr.kind {
                ExprKind::Call { function, arguments } => match (function.folded(), arguments.as_slice()) {
                    ("inform" | "cogevent", [message]) => self.forms.extend(form(message)),
                    ("print", _) => {}
                    _ => self.others = true,
                },
                ExprKind::Constant(_) => {}
                _ => self.others = true,
            }
        }
    }
}

fn form(message: &Expr) -> Option<Template> {
    match &message.kind {
        ExprKind::Constant(value) => Some(Template::Constant(value.clone())),
        ExprKind::Template(template) => Some((**template).clone()),
        _ => None,
    }
}
