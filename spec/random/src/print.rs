//! Programs and inputs as texts: PDL for the real checker, JSON lines for a page.

use apex_reference::program::{
    Activity, Clauses, Condition, Expr, Form, Hooks, Kind, Need, Primitive, Priority, Procedure, Program, Relation,
    Repetition, SECOND, Span, Step, Term,
};
use apex_reference::{Input, Said, Value};
use std::fmt::Write;

/// Returns the program as PDL.
pub fn program(program: &Program) -> String {
    let mut text = String::new();
    for resource in &program.resources {
        let kind = match (resource.depletable, resource.name.starts_with('r')) {
            (true, _) => format!(" :depletable {}", resource.amount),
            (false, true) => String::new(),
            (false, false) => format!(" :capacity {}", resource.amount),
        };
        let whole = resource.part_of.as_ref().map(|whole| format!(" :part-of {whole}")).unwrap_or_default();
        let _ = writeln!(text, "(resource {}{kind}{whole})", resource.name);
    }
    for each in &program.procedures {
        let _ = writeln!(text, "{}", procedure(each));
    }
    for each in &program.primitives {
        let _ = writeln!(text, "{}", primitive(each));
    }
    text
}

/// Returns the inputs as JSON lines, by the time at which they happened.
pub fn inputs(inputs: &[Input]) -> String {
    let mut text = String::new();
    for input in inputs {
        let t = input.at as f64 / SECOND as f64;
        let _ = match &input.said {
            Said::Message(words) => writeln!(text, "{{\"t\": {t}, \"event\": \"{}\"}}", list(words)),
            Said::Sample(attribute, object, value) => {
                writeln!(
                    text,
                    "{{\"t\": {t}, \"measurement\": \"({attribute} {object})\", \"value\": {}}}",
                    value_of(value)
                )
            }
        };
    }
    text
}

fn procedure(procedure: &Procedure) -> String {
    let kind = match procedure.kind {
        Kind::Concurrent => "",
        Kind::Sequential => " :sequential",
        Kind::Ranked => " :ranked",
        Kind::SoftSequential => " :soft-seq",
    };
    let mut text = format!("(procedure{kind} (index {})", phrase(&procedure.index));
    let mut clauses = needs(&procedure.profile);
    clauses += &optional("interrupt-cost", procedure.interrupt_cost.as_ref().map(expr));
    clauses += &optional("expected-duration", procedure.expected.map(span));
    clauses += &transitions(&procedure.clauses);
    clauses += &hooks(&procedure.hooks);
    if !clauses.is_empty() {
        let _ = write!(text, "\n {clauses}");
    }
    for each in &procedure.steps {
        let _ = write!(text, "\n  {}", step(each));
    }
    text + ")"
}

fn primitive(primitive: &Primitive) -> String {
    let mut text = format!("(primitive (index {}){}", phrase(&primitive.index), needs(&primitive.profile));
    if !primitive.locals.is_empty() {
        let locals = primitive.locals.iter().map(|(name, first)| format!("({name} {})", expr(first)));
        let _ = write!(text, " (locals {})", locals.collect::<Vec<_>>().join(" "));
    }
    text += &optional("duration", primitive.duration.as_ref().map(expr));
    if let Some((interval, body)) = &primitive.update {
        let _ = write!(text, " (update {} {})", span(*interval), forms(body, &primitive.locals));
    }
    text += &hooks_with(&primitive.hooks, &primitive.locals);
    if !primitive.on_completion.is_empty() {
        let _ = write!(text, " (on-completion {})", forms(&primitive.on_completion, &primitive.locals));
    }
    text + &optional("return", primitive.returns.as_ref().map(|expr| local_expr(expr, &primitive.locals))) + ")"
}

fn step(step: &Step) -> String {
    let mut text = format!("(step {} {}", step.tag, activity(&step.activity));
    if let Some(name) = &step.binds {
        let _ = write!(text, " => ?{name}");
    }
    if !step.waitfor.is_empty() {
        let _ = write!(text, " (waitfor {})", conditions(&step.waitfor));
    }
    for (name, value) in &step.select {
        let _ = write!(text, " (select ?{name} {})", expr(value));
    }
    if let Some((name, items)) = &step.forall {
        let _ = write!(text, " (forall ?{name} in {})", expr(items));
    }
    for each in &step.priority {
        let _ = match each {
            Priority::Number(number) => write!(text, " (priority {})", expr(number)),
            Priority::Urgency(urgency, importance) => {
                write!(text, " (priority :urgency {urgency} :importance {importance})")
            }
        };
    }
    text += &optional("rank", step.rank.as_ref().map(expr));
    text += &optional("interrupt-cost", step.interrupt_cost.as_ref().map(expr));
    text += &step.repetition.as_ref().map(repetition).unwrap_or_default();
    text += &needs(&step.profile);
    text += &hooks(&step.hooks);
    text += &transitions(&step.clauses);
    text + &optional("on-failure", step.on_failure.as_ref().map(activity)) + ")"
}

fn repetition(clause: &Repetition) -> String {
    let mut text = format!(" ({}", if clause.responding { "responding" } else { "repeating" });
    for (word, test) in [("while", &clause.while_true), ("until", &clause.until)] {
        if let Some(test) = test {
            let _ = write!(text, " :{word} {}", expr(test));
        }
    }
    if clause.enabled {
        text += " :enabled t";
    }
    for (word, length) in [("with-recovery", clause.recovery), ("with-min-interval", clause.minimum_interval)] {
        if let Some(length) = length {
            let _ = write!(text, " :{word} {}", span(length));
        }
    }
    if !clause.for_new.is_empty() {
        let names: Vec<String> = clause.for_new.iter().map(|name| format!("?{name}")).collect();
        let _ = write!(text, " :for-new {}", names.join(" "));
    }
    if clause.drop_missed {
        text += " :missed-messages drop";
    }
    text + ")"
}

fn activity(activity: &Activity) -> String {
    match activity {
        Activity::Goal(words) => phrase(words),
        Activity::Terminate { tag, outcome, value } => {
            let tag = tag.as_ref().map(|tag| format!(" ?{tag}")).unwrap_or_default();
            let outcome = outcome.as_ref().map(|outcome| format!(" {outcome}")).unwrap_or_default();
            let value = value.as_ref().map(|value| format!(" >> {}", expr(value))).unwrap_or_default();
            format!("(terminate{tag}{outcome}{value})")
        }
        Activity::Reset(tag) => format!("(reset ?{tag})"),
        Activity::Suspend(tag) => format!("(suspend ?{tag})"),
        Activity::Resume(tag) => format!("(resume ?{tag})"),
        Activity::Reprioritize(tag) => format!("(reprioritize ?{tag})"),
        Activity::Inform(words) => format!("(inform {})", phrase(words)),
        Activity::Cogevent(words) => format!("(cogevent {})", phrase(words)),
        Activity::Print(value) => format!("(print {})", expr(value)),
        Activity::Hold(name) => format!("(hold-resource {name})"),
        Activity::Release(name) => format!("(release-resource {name})"),
        Activity::EndApplication => "(end-application)".into(),
    }
}

fn transitions(clauses: &Clauses) -> String {
    let mut text = optional("end-when", clauses.end_when.as_ref().map(condition));
    text += &optional("restart-when", clauses.restart_when.as_ref().map(condition));
    if let Some((when, until)) = &clauses.suspend_when {
        let _ = write!(text, " (suspend-when {} until {})", condition(when), condition(until));
    }
    text += &optional("resume-when", clauses.resume_when.as_ref().map(condition));
    text += &optional("skip-when", clauses.skip_when.as_ref().map(condition));
    text += &optional("exit-when", clauses.exit_when.as_ref().map(condition));
    text += &optional("precondition", clauses.precondition.as_ref().map(condition));
    text + &optional("invariant", clauses.invariant.as_ref().map(condition))
}

fn hooks(hooks: &Hooks) -> String {
    hooks_with(hooks, &[])
}

fn hooks_with(hooks: &Hooks, locals: &[(String, Expr)]) -> String {
    let all = [
        ("on-start", &hooks.on_start),
        ("on-end", &hooks.on_end),
        ("on-suspend", &hooks.on_suspend),
        ("on-resume", &hooks.on_resume),
    ];
    let filled = all.into_iter().filter(|(_, body)| !body.is_empty());
    filled.map(|(word, body)| format!(" ({word} {})", forms(body, locals))).collect()
}

/// Locals are written without question mark.
fn forms(body: &[Form], locals: &[(String, Expr)]) -> String {
    body.iter().map(|each| form(each, locals)).collect::<Vec<_>>().join(" ")
}

fn form(form: &Form, locals: &[(String, Expr)]) -> String {
    let local = |expr| local_expr(expr, locals);
    match form {
        Form::Inform(words) => format!("(inform {})", phrase(words)),
        Form::Print(value) => format!("(print {})", local(value)),
        Form::Set(name, value) if locals.iter().any(|(each, _)| each == name) => {
            format!("(setq {name} {})", local(value))
        }
        Form::Set(name, value) => format!("(setq ?{name} {})", local(value)),
        Form::Publish(attribute, object, value) => format!("(publish ({attribute} {object}) {})", local(value)),
        Form::Complete(value) => {
            format!("(complete{})", value.as_ref().map(|value| format!(" {}", local(value))).unwrap_or_default())
        }
        Form::When(test, form) => format!("(when {} {})", local(test), self::form(form, locals)),
    }
}

fn needs(profile: &[Need]) -> String {
    if profile.is_empty() {
        return String::new();
    }
    let entries = profile.iter().map(|need| match need.amount {
        Some(amount) => format!("({} {amount})", term(&need.resource)),
        None => term(&need.resource),
    });
    let option = if profile.iter().any(|need| need.refuse_if_busy) { " :refuse-if-busy" } else { "" };
    format!(" (profile {}{option})", entries.collect::<Vec<_>>().join(" "))
}

fn conditions(parts: &[Condition]) -> String {
    parts.iter().map(condition).collect::<Vec<_>>().join(" ")
}

fn condition(condition: &Condition) -> String {
    match condition {
        Condition::Event(words) => phrase(words),
        Condition::Measurement(attribute, object, relation, number) => {
            format!("({attribute} {} {} {number})", term(object), relation_word(*relation))
        }
        Condition::Sample(attribute, object, name) => format!("({attribute} {} = ?{name})", term(object)),
        Condition::Ended(tag) => format!("(end ?{tag})"),
        Condition::State(Some(tag), word) if ["failed", "succeeded", "skipped"].contains(&word.as_str()) => {
            format!("({word} ?{tag})")
        }
        Condition::State(Some(tag), word) => format!("(state ?{tag} = {word})"),
        Condition::State(None, word) => format!("(task-state +this-task+ = {word})"),
        Condition::And(parts) => format!("(:and {})", conditions(parts)),
        Condition::Or(parts) => format!("(:or {})", conditions(parts)),
        Condition::InOrder(parts) => format!("(:in-order {})", conditions(parts)),
        Condition::Not(part) => format!("(:not {})", self::condition(part)),
        Condition::Delay(least, most) => {
            format!("(:delay {}{})", span(*least), most.map(|most| format!(" {}", span(most))).unwrap_or_default())
        }
    }
}

fn relation_word(relation: Relation) -> &'static str {
    match relation {
        Relation::Equal => "=",
        Relation::Less => "<",
        Relation::AtMost => "<=",
        Relation::More => ">",
        Relation::AtLeast => ">=",
    }
}

fn optional(word: &str, body: Option<String>) -> String {
    body.map(|body| format!(" ({word} {body})")).unwrap_or_default()
}

fn expr(expr: &Expr) -> String {
    local_expr(expr, &[])
}

fn local_expr(expr: &Expr, locals: &[(String, Expr)]) -> String {
    let inner = |expr| local_expr(expr, locals);
    match expr {
        Expr::Is(value @ (Value::Word(_) | Value::List(_))) => format!("'{}", value_of(value)),
        Expr::Is(value) => value_of(value),
        Expr::Variable(name) if locals.iter().any(|(each, _)| each == name) => name.clone(),
        Expr::Variable(name) => format!("?{name}"),
        Expr::Sum(a, b) => format!("(+ {} {})", inner(a), inner(b)),
        Expr::Difference(a, b) => format!("(- {} {})", inner(a), inner(b)),
        Expr::Compare(relation, a, b) => format!("({} {} {})", relation_word(*relation), inner(a), inner(b)),
        Expr::If(test, a, b) => format!("(if {} {} {})", inner(test), inner(a), inner(b)),
        Expr::Current(attribute, object) => format!("(current-value '{attribute} '{object})"),
        Expr::MissionTime => "+met+".into(),
        Expr::StateOf(tag) => format!("(task-state ?{tag})"),
        Expr::First(list) => format!("(first {})", inner(list)),
    }
}

fn term(term: &Term) -> String {
    match term {
        Term::Is(value) => value_of(value),
        Term::Variable(name) => format!("?{name}"),
        Term::Anything => "?".into(),
    }
}

fn phrase(words: &[Term]) -> String {
    format!("({})", words.iter().map(term).collect::<Vec<_>>().join(" "))
}

fn list(words: &[Value]) -> String {
    format!("({})", words.iter().map(value_of).collect::<Vec<_>>().join(" "))
}

fn value_of(value: &Value) -> String {
    match value {
        Value::Span(length) => span(*length),
        Value::List(items) => list(items),
        other => other.to_string(),
    }
}

/// Returns a span as in `2.5s`.
fn span(length: Span) -> String {
    format!("{}s", length as f64 / SECOND as f64)
}
