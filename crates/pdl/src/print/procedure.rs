//! Procedures, primitives and plans as text.

use super::{expression_text, laid_out, laid_out_steps, pattern_text, template_text};
use apex_forms::print::{Style, form_text, joined, list_text};
use apex_model::condition::Condition;
use apex_model::expression::{Expr, ExprKind};
use apex_model::procedure::{
    Activity, BuiltInActivity, Hooks, LogPolicy, Primitive, PriorityClause, Procedure, ProcedureKind, Repetition,
    ResourceNeed, Step, Transitions,
};
use apex_model::symbol::Symbol;
use apex_model::value::Value;

/// Returns the procedure as PDL. The text does not contain its bundle, which `in-apex-bundle` sets before it.
pub fn print_procedure(procedure: &Procedure) -> String {
    let kind = match procedure.kind {
        ProcedureKind::Concurrent => "",
        ProcedureKind::Sequential => ":sequential",
        ProcedureKind::Ranked => ":ranked",
        ProcedureKind::SoftSequential => ":soft-seq",
    };
    let mut parts = vec![kind.to_string(), format!("(index {})", pattern_text(&procedure.index))];
    parts.push(profile_text(&procedure.profile));
    parts.push(log_text(&procedure.log));
    parts.push(clause("expected-duration", procedure.expected_duration.as_ref()));
    parts.push(clause("interrupt-cost", procedure.interrupt_cost.as_ref()));
    parts.extend(transitions_text(&procedure.transitions));
    parts.extend(hooks_text(&procedure.hooks));
    parts.extend(procedure.steps.iter().map(step_text));
    laid_out(list_text("procedure", parts))
}

/// Returns the primitive as PDL.
pub fn print_primitive(primitive: &Primitive) -> String {
    let mut parts = vec![format!("(index {})", pattern_text(&primitive.index)), profile_text(&primitive.profile)];
    if !primitive.locals.is_empty() {
        let local = |(name, value): &(Symbol, Expr)| format!("({name} {})", expression_text(value));
        parts.push(list_text("locals", primitive.locals.iter().map(local)));
    }
    parts.push(clause("duration", primitive.duration.as_ref()));
    let [on_start, others @ ..] = hooks_text(&primitive.hooks);
    parts.push(on_start);
    if let Some((interval, forms)) = &primitive.update {
        let interval = interval.iter().map(expression_text);
        parts.push(list_text("update", interval.chain(forms.iter().map(expression_text))));
    }
    if !primitive.on_completion.is_empty() {
        parts.push(list_text("on-completion", primitive.on_completion.iter().map(expression_text)));
    }
    parts.extend(others);
    parts.push(clause("return", primitive.returns.as_ref()));
    laid_out(list_text("primitive", parts))
}

/// Returns a plan as PDL: a sequential procedure for the goal `index`, one step for each planned activity.
/// With `repeat` the plan is a cycle: it begins again whenever it has ended.
pub fn print_plan(index: &Value, steps: &[(Symbol, Value)], repeat: bool) -> PrintedPlan {
    let step = |(tag, activity): &(Symbol, Value)| format!("(step {tag} {})", Style::Exact.literal(activity));
    let goal = Style::Exact.literal(index);
    if !repeat {
        let parts = [":sequential".to_string(), format!("(index {goal})")];
        let (text, step_lines) =
            laid_out_steps(list_text("procedure", parts.into_iter().chain(steps.iter().map(step))));
        return PrintedPlan { text, step_lines };
    }
    let cycle = format!("(one-cycle-of {goal})");
    let outer = format!("(procedure (index {goal}) (step cycle {cycle} (repeating)))");
    let parts = [":sequential".to_string(), format!("(index {cycle})")];
    let inner = list_text("procedure", parts.into_iter().chain(steps.iter().map(step)));
    let (text, mut step_lines) = laid_out_steps(format!("{outer}\n\n{inner}"));
    // The first step is the outer procedure's.
    step_lines.drain(..step_lines.len().min(1));
    PrintedPlan { text, step_lines }
}

/// A plan as text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PrintedPlan {
    /// PDL that loads again.
    pub text: String,
    /// The line of each step in the text, from 1.
    pub step_lines: Vec<u32>,
}

fn clause(name: &str, expr: Option<&Expr>) -> String {
    expr.map_or(String::new(), |expr| format!("({name} {})", expression_text(expr)))
}

fn condition_clause(name: &str, condition: Option<&Condition>) -> String {
    condition.map_or(String::new(), |condition| format!("({name} {})", Style::Exact.condition(condition)))
}

fn profile_text(needs: &[ResourceNeed]) -> String {
    if needs.is_empty() {
        return String::new();
    }
    let need = |need: &ResourceNeed| {
        let name = template_text(&need.resource);
        match &need.amount {
            Some(amount) => format!("({name} {})", expression_text(amount)),
            None => name,
        }
    };
    let (refusing, waiting): (Vec<_>, Vec<_>) = needs.iter().partition(|need| need.refuse_if_busy);
    let mut text = if waiting.is_empty() { String::new() } else { list_text("profile", waiting.into_iter().map(need)) };
    if !refusing.is_empty() {
        let entries = refusing.into_iter().map(need).chain(std::iter::once(":refuse-if-busy".to_string()));
        text = format!("{text}{}{}", if text.is_empty() { "" } else { " " }, list_text("profile", entries));
    }
    text
}

fn log_text(policies: &[LogPolicy]) -> String {
    let policy = |policy: &LogPolicy| {
        let subject = template_text(&policy.subject);
        let limits = [
            policy.frequency_limit.map_or(String::new(), |limit| format!(":frequency-limit {limit}")),
            policy.time_limit.map_or(String::new(), |limit| format!(":time-limit {limit}")),
            policy.count_limit.map_or(String::new(), |limit| format!(":count-limit {limit}")),
        ];
        if limits.iter().all(String::is_empty) { subject } else { list_text(&subject, limits) }
    };
    if policies.is_empty() { String::new() } else { list_text("log", policies.iter().map(policy)) }
}

fn transitions_text(transitions: &Transitions) -> [String; 8] {
    let suspend = match (&transitions.suspend_when, &transitions.suspend_until) {
        (Some(when), Some(until)) => {
            format!("(suspend-when {} until {})", Style::Exact.condition(when), Style::Exact.condition(until))
        }
        (when, _) => condition_clause("suspend-when", when.as_deref()),
    };
    [
        condition_clause("end-when", transitions.end_when.as_deref()),
        condition_clause("restart-when", transitions.restart_when.as_deref()),
        condition_clause("resume-when", transitions.resume_when.as_deref()),
        suspend,
        condition_clause("skip-when", transitions.skip_when.as_deref()),
        condition_clause("exit-when", transitions.exit_when.as_deref()),
        condition_clause("precondition", transitions.precondition.as_deref()),
        condition_clause("invariant", transitions.invariant.as_deref()),
    ]
}

fn hooks_text(hooks: &Hooks) -> [String; 4] {
    let hook = |name: &str, forms: &[Expr]| match forms {
        [] => String::new(),
        forms => list_text(name, forms.iter().map(expression_text)),
    };
    [
        hook("on-start", &hooks.on_start),
        hook("on-end", &hooks.on_end),
        hook("on-suspend", &hooks.on_suspend),
        hook("on-resume", &hooks.on_resume),
    ]
}

fn step_text(step: &Step) -> String {
    let mut parts = vec![step.tag.to_string(), activity_text(&step.activity)];
    parts.extend(step.binds.as_ref().map(|pattern| format!("=> {}", pattern_text(pattern))));
    if !step.waitfor.is_empty() {
        parts.push(list_text("waitfor", step.waitfor.iter().map(|condition| Style::Exact.condition(condition))));
    }
    parts.extend(step.select.iter().map(|(name, value)| format!("(select ?{name} {})", expression_text(value))));
    if let Some((name, list)) = step.forall.as_deref() {
        parts.push(format!("(forall ?{name} in {})", expression_text(list)));
    }
    parts.extend(step.priority.iter().map(|priority| match priority {
        PriorityClause::Number(number) => format!("(priority {})", expression_text(number)),
        PriorityClause::UrgencyImportance(urgency, importance) => {
            format!("(priority :urgency {} :importance {})", expression_text(urgency), expression_text(importance))
        }
    }));
    parts.push(clause("rank", step.rank.as_deref()));
    parts.push(clause("interrupt-cost", step.interrupt_cost.as_deref()));
    parts.extend(step.repeating.iter().map(|repetition| repetition_text("repeating", repetition)));
    parts.extend(step.responding.iter().map(|repetition| repetition_text("responding", repetition)));
    parts.push(profile_text(&step.profile));
    parts.extend(transitions_text(&step.transitions));
    parts.extend(hooks_text(&step.hooks));
    parts.extend(step.on_failure.iter().map(|activity| format!("(on-failure {})", activity_text(activity))));
    list_text("step", parts)
}

fn repetition_text(head: &str, repetition: &Repetition) -> String {
    let option = |name: &str, expr: &Option<Expr>| {
        expr.as_ref().map_or(String::new(), |expr| format!(":{name} {}", expression_text(expr)))
    };
    let new = match repetition.for_new.as_slice() {
        [] => String::new(),
        names => format!(":for-new {}", joined(names.iter().map(|name| format!("?{name}")))),
    };
    let parts = [
        option("while", &repetition.while_true),
        option("until", &repetition.until),
        option("enabled", &repetition.enabled),
        option("with-recovery", &repetition.recovery),
        option("with-min-interval", &repetition.minimum_interval),
        new,
        if repetition.drop_missed { ":missed-messages drop".into() } else { String::new() },
    ];
    list_text(head, parts)
}

fn activity_text(activity: &Activity) -> String {
    match activity {
        Activity::Goal(template) => template_text(template),
        Activity::Terminate { task, outcome, value } => {
            let value = value.as_ref().map_or(String::new(), |value| format!(">> {}", expression_text(value)));
            let text = |expr: &Option<Box<Expr>>| expr.as_deref().map_or(String::new(), expression_text);
            list_text("terminate", [text(task), text(outcome), value])
        }
        Activity::BuiltIn(which, arguments) => built_in_text(*which, arguments),
    }
}

fn built_in_text(which: BuiltInActivity, arguments: &[Expr]) -> String {
    let plain = |head: &str| list_text(head, arguments.iter().map(expression_text));
    let forms = |head: &str| list_text(head, arguments.iter().map(form_text));
    match which {
        BuiltInActivity::Reset => plain("reset"),
        BuiltInActivity::Suspend => plain("suspend"),
        BuiltInActivity::Resume => plain("resume"),
        BuiltInActivity::Reprioritize => plain("reprioritize"),
        BuiltInActivity::Print => plain("print"),
        BuiltInActivity::EndApplication => plain("end-application"),
        BuiltInActivity::HoldResource => forms("hold-resource"),
        BuiltInActivity::ReleaseResource => forms("release-resource"),
        BuiltInActivity::Cogevent | BuiltInActivity::Inform => {
            let (form, to) = arguments.split_at_checked(1).unwrap_or((arguments, &[]));
            let head = if which == BuiltInActivity::Inform { "inform" } else { "cogevent" };
            list_text(head, form.iter().map(form_text).chain(to.iter().map(expression_text)))
        }
        BuiltInActivity::AskOperator => {
            let names = ["question", ":options", ":by", ":default"];
            list_text("ask operator", named_arguments(&names, arguments))
        }
        BuiltInActivity::Plan => list_text("plan", named_arguments(&["goal", ":with", ":budget"], arguments)),
    }
}

/// Returns the arguments, each after its keyword; `nil` is left out.
fn named_arguments(names: &[&str], arguments: &[Expr]) -> Vec<String> {
    let is_nil = |expr: &Expr| matches!(&expr.kind, ExprKind::Constant(value) if !value.is_true());
    let text = |(name, expr): (&&str, &Expr)| match *name {
        "question" => expression_text(expr),
        "goal" => form_text(expr),
        ":default" | ":with" => format!("{name} {}", form_text(expr)),
        name => format!("{name} {}", expression_text(expr)),
    };
    names.iter().zip(arguments).filter(|(name, expr)| !name.starts_with(':') || !is_nil(expr)).map(text).collect()
}
