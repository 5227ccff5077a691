//! Reduces a failing case for as long as it fails: first whole parts are removed, then parts of parts, until nothing more can be removed.

use crate::compare::{Verdict, judge};
use crate::generate::Case;
use apex_reference::program::{Activity, Clauses, Condition, Hooks, Primitive, Procedure, Repetition, SECOND, Step};

/// Maximum number of attempts.
const ATTEMPTS_MAX: usize = 3_000;

/// Returns the smallest case found that still differs, or on which an assertion still fails.
pub fn shrink(case: &Case) -> Case {
    let fails = |case: &Case| std::panic::catch_unwind(|| judge(case)).map_or(true, is_different);
    let mut smallest = case.clone();
    let mut attempts = 0;
    'again: loop {
        for candidate in smaller(&smallest) {
            attempts += 1;
            if attempts > ATTEMPTS_MAX {
                return smallest;
            }
            if fails(&candidate) {
                smallest = candidate;
                continue 'again;
            }
        }
        return smallest;
    }
}

fn is_different(verdict: Verdict) -> bool {
    matches!(verdict, Verdict::Different(_))
}

/// Returns all cases that are a little smaller, the most promising first.
fn smaller(case: &Case) -> Vec<Case> {
    let mut cases = Vec::new();
    for inputs in without_each(&case.inputs) {
        cases.push(Case { inputs, ..case.clone() });
    }
    let mut add = |change: &dyn Fn(&mut Case)| {
        let mut candidate = case.clone();
        change(&mut candidate);
        if candidate != *case {
            cases.push(candidate);
        }
    };
    let program = &case.program;
    for number in 0..program.procedures.len().max(program.primitives.len()) {
        add(&|case| remove(&mut case.program.procedures, number));
        add(&|case| remove(&mut case.program.primitives, number));
    }
    add(&|case| case.program.resources.clear());
    for (number, procedure) in program.procedures.iter().enumerate() {
        for smaller in smaller_procedures(procedure) {
            add(&|case| set(&mut case.program.procedures, number, smaller.clone()));
        }
    }
    for (number, primitive) in program.primitives.iter().enumerate() {
        for smaller in smaller_primitives(primitive) {
            add(&|case| set(&mut case.program.primitives, number, smaller.clone()));
        }
    }
    for number in 0..case.inputs.len() {
        add(&|case| case.inputs.get_mut(number).into_iter().for_each(|input| input.at = input.arrives));
    }
    cases
}

fn remove<T>(list: &mut Vec<T>, number: usize) {
    if number < list.len() {
        list.remove(number);
    }
}

fn set<T>(list: &mut [T], number: usize, value: T) {
    if let Some(slot) = list.get_mut(number) {
        *slot = value;
    }
}

/// Returns the list without its first half, its second half, and each of its items.
fn without_each<T: Clone>(list: &[T]) -> Vec<Vec<T>> {
    let (first, second) = list.split_at(list.len() / 2);
    let mut lists = if list.len() > 3 { vec![first.to_vec(), second.to_vec()] } else { Vec::new() };
    for number in 0..list.len() {
        let mut fewer = list.to_vec();
        fewer.remove(number);
        lists.push(fewer);
    }
    lists
}

fn smaller_procedures(procedure: &Procedure) -> Vec<Procedure> {
    let mut all = Vec::new();
    let mut add = |change: &dyn Fn(&mut Procedure)| {
        let mut candidate = procedure.clone();
        change(&mut candidate);
        all.push(candidate);
    };
    for steps in without_each(&procedure.steps) {
        add(&|each| each.steps = steps.clone());
    }
    add(&|each| each.clauses = Clauses::default());
    add(&|each| each.hooks = Hooks::default());
    add(&|each| each.profile.clear());
    add(&|each| each.interrupt_cost = None);
    add(&|each| each.expected = None);
    add(&|each| each.kind = apex_reference::program::Kind::Concurrent);
    for clauses in smaller_clauses(&procedure.clauses) {
        add(&|each| each.clauses = clauses.clone());
    }
    for hooks in smaller_hooks(&procedure.hooks) {
        add(&|each| each.hooks = hooks.clone());
    }
    for profile in without_each(&procedure.profile) {
        add(&|each| each.profile = profile.clone());
    }
    for (number, step) in procedure.steps.iter().enumerate() {
        for smaller in smaller_steps(step) {
            add(&|each| set(&mut each.steps, number, smaller.clone()));
        }
    }
    all
}

fn smaller_steps(step: &Step) -> Vec<Step> {
    let mut all = vec![Step::plain(&step.tag, step.activity.clone())];
    let mut add = |change: &dyn Fn(&mut Step)| {
        let mut candidate = step.clone();
        change(&mut candidate);
        all.push(candidate);
    };
    add(&|each| each.clauses = Clauses::default());
    add(&|each| each.hooks = Hooks::default());
    add(&|each| each.repetition = None);
    add(&|each| each.on_failure = None);
    add(&|each| each.waitfor.clear());
    add(&|each| each.priority.clear());
    add(&|each| each.rank = None);
    add(&|each| each.interrupt_cost = None);
    add(&|each| each.profile.clear());
    add(&|each| each.binds = None);
    add(&|each| each.forall = None);
    add(&|each| each.select.clear());
    if let Some(clause) = &step.repetition {
        add(&|each| each.repetition = Some(Repetition { responding: clause.responding, ..Repetition::default() }));
        add(&|each| each.repetition.iter_mut().for_each(|clause| clause.minimum_interval = None));
        add(&|each| each.repetition.iter_mut().for_each(|clause| clause.recovery = None));
        add(&|each| each.repetition.iter_mut().for_each(|clause| clause.for_new.clear()));
        add(&|each| each.repetition.iter_mut().for_each(|clause| clause.enabled = false));
        add(&|each| each.repetition.iter_mut().for_each(|clause| clause.drop_missed = false));
    }
    for clauses in smaller_clauses(&step.clauses) {
        add(&|each| each.clauses = clauses.clone());
    }
    for hooks in smaller_hooks(&step.hooks) {
        add(&|each| each.hooks = hooks.clone());
    }
    for waitfor in without_each(&step.waitfor) {
        add(&|each| each.waitfor = waitfor.clone());
    }
    for (number, condition) in step.waitfor.iter().enumerate() {
        for smaller in smaller_conditions(condition) {
            add(&|each| set(&mut each.waitfor, number, smaller.clone()));
        }
    }
    if !matches!(step.activity, Activity::Goal(_)) {
        add(&|each| {
            each.activity = Activity::Print(apex_reference::program::Expr::Is(apex_reference::Value::Number(1.0)))
        });
    }
    all
}

fn smaller_primitives(primitive: &Primitive) -> Vec<Primitive> {
    let mut all = vec![Primitive {
        index: primitive.index.clone(),
        duration: primitive.duration.clone(),
        profile: primitive.profile.clone(),
        ..Primitive::default()
    }];
    let mut add = |change: &dyn Fn(&mut Primitive)| {
        let mut candidate = primitive.clone();
        change(&mut candidate);
        all.push(candidate);
    };
    add(&|each| each.hooks = Hooks::default());
    add(&|each| each.on_completion.clear());
    add(&|each| each.returns = None);
    add(&|each| each.update = None);
    add(&|each| each.duration = None);
    add(&|each| each.profile.clear());
    for profile in without_each(&primitive.profile) {
        add(&|each| each.profile = profile.clone());
    }
    for hooks in smaller_hooks(&primitive.hooks) {
        add(&|each| each.hooks = hooks.clone());
    }
    let second = apex_reference::program::Expr::Is(apex_reference::Value::Span(SECOND));
    add(&|each| each.duration = each.duration.as_ref().map(|_| second.clone()));
    all
}

fn smaller_clauses(clauses: &Clauses) -> Vec<Clauses> {
    let mut all = vec![
        Clauses { end_when: None, ..clauses.clone() },
        Clauses { restart_when: None, ..clauses.clone() },
        Clauses { suspend_when: None, ..clauses.clone() },
        Clauses { resume_when: None, ..clauses.clone() },
        Clauses { skip_when: None, ..clauses.clone() },
        Clauses { exit_when: None, ..clauses.clone() },
        Clauses { precondition: None, ..clauses.clone() },
        Clauses { invariant: None, ..clauses.clone() },
    ];
    for condition in clauses.end_when.iter().flat_map(smaller_conditions) {
        all.push(Clauses { end_when: Some(condition), ..clauses.clone() });
    }
    for condition in clauses.restart_when.iter().flat_map(smaller_conditions) {
        all.push(Clauses { restart_when: Some(condition), ..clauses.clone() });
    }
    all
}

fn smaller_hooks(hooks: &Hooks) -> Vec<Hooks> {
    vec![
        Hooks { on_start: Vec::new(), ..hooks.clone() },
        Hooks { on_end: Vec::new(), ..hooks.clone() },
        Hooks { on_suspend: Vec::new(), ..hooks.clone() },
        Hooks { on_resume: Vec::new(), ..hooks.clone() },
    ]
}

fn smaller_conditions(condition: &Condition) -> Vec<Condition> {
    match condition {
        Condition::And(parts) | Condition::Or(parts) | Condition::InOrder(parts) => {
            let mut all = parts.clone();
            for (number, part) in parts.iter().enumerate() {
                for smaller in smaller_conditions(part) {
                    let mut fewer = parts.clone();
                    set(&mut fewer, number, smaller);
                    all.push(match condition {
                        Condition::And(_) => Condition::And(fewer),
                        Condition::Or(_) => Condition::Or(fewer),
                        _ => Condition::InOrder(fewer),
                    });
                }
            }
            all
        }
        _ => Vec::new(),
    }
}
