//! Retention (M&I)
//! What: computes how far back the conditions and queries of a library look, so that histories are always long enough.
//! Runs: once, when an agent is loaded.
//! Reads: library.
//! Writes: histories, by the demands that `apex check --memory` prints.
//! Bound: linear in the library.
//! PDL: `:timestamp`, `:timing`, `value-at`, `mean-over`, .., `:lateness`.
//! Paper: section IV, policies on logged data quantity.

use crate::expression::arithmetic::duration;
use crate::monitoring::memory::demand::{Demand, Reach, Subject, Why};
use crate::monitoring::memory::histories::obey;
use crate::monitoring::memory::reach;
use crate::state::histories::history::Histories;
use crate::state::index::{LibraryIndex, ProcedureIndex};
use apex_forms::print::Style::Brief;
use apex_model::condition::{
    Condition, ConditionKind, Constraint, EpisodeCondition, Estimation, MeasurementCondition, Quality, Timing,
    VariablePattern,
};
use apex_model::derivation::{Derivation, Join};
use apex_model::expression::{Expr, ExprKind, Template};
use apex_model::library::{Library, StateVariableDeclaration};
use apex_model::pattern::Pattern;
use apex_model::procedure::{
    Activity, Hooks, LogPolicy, Primitive, PriorityClause, Procedure, Repetition, Step, Transitions,
};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use apex_model::value::Value;
use std::sync::Arc;

/// Prepares `histories` for the depth to which the conditions and queries of `library` look back. `index` is that of the library, if it
/// exists.
pub(crate) fn prepare(histories: &mut Histories, library: &Library, index: Option<&LibraryIndex>) {
    let mut survey = Survey { library, index, wordless: true, demands: Vec::new() };
    survey.everything();
    obey(histories, survey.demands);
}

/// Returns the maximum lateness of samples of the variable.
pub(crate) fn lateness(declaration: &StateVariableDeclaration) -> Option<Duration> {
    let late = declaration.lateness.as_ref().and_then(|value| duration(value).ok());
    late.filter(|late| *late > Duration::ZERO)
}

/// Returns the demands of each clause of `library`, in the order of definitions.
pub(crate) fn demands(library: &Library) -> Vec<Demand> {
    let mut survey = Survey { library, index: None, wordless: false, demands: Vec::new() };
    survey.everything();
    survey.demands
}

/// Returns the demands of one condition.
pub(crate) fn demands_of(library: &Library, condition: &Condition) -> Vec<Demand> {
    let mut survey = Survey { library, index: None, wordless: true, demands: Vec::new() };
    survey.condition(condition);
    survey.demands
}

/// Prepares `histories` for one more condition.
pub(crate) fn prepare_condition(histories: &mut Histories, library: &Library, condition: &Condition) {
    obey(histories, demands_of(library, condition));
}

/// Walks through definitions and collects the clauses that look back.
pub(crate) struct Survey<'a> {
    pub(crate) library: &'a Library,
    /// Index of the procedures, if it exists.
    index: Option<&'a LibraryIndex>,
    /// True if the texts of the demands are not used.
    wordless: bool,
    demands: Vec<Demand>,
}

impl Survey<'_> {
    /// Adds the demands of everything that the library defines, in order.
    fn everything(&mut self) {
        let library = self.library;
        for (attribute, declaration) in &library.state_variables {
            if let Some(late) = lateness(declaration) {
                let text = || format!("(state-variable ({attribute} ..) :lateness {late})");
                self.demand(
                    Subject::Attribute(attribute.clone()),
                    Reach::Unbounded,
                    Why::Lateness,
                    text,
                    declaration.place,
                );
            }
        }
        for (attribute, derivation) in &library.derivations {
            self.derivation(attribute, derivation);
        }
        for (number, procedure) in library.procedures.iter().enumerate() {
            self.procedure(number, procedure);
        }
        library.primitives.iter().for_each(|primitive| self.primitive(primitive));
        library.indexicals.values().for_each(|expr| self.expr(expr));
        library.functions.values().for_each(|function| self.exprs(&function.body));
    }

    /// Adds the inputs of a derived variable: for a line the samples between the neighbours, otherwise the newest two, which are always
    /// kept.
    fn derivation(&mut self, attribute: &Symbol, derivation: &Derivation) {
        self.expr(&derivation.value);
        let Join::Interpolate(most) = derivation.join else { return };
        for input in &derivation.inputs {
            let text = || format!("(state-variable ({attribute} ..) :derived .. :join (:interpolate {most}))");
            let reach = Reach::Span(most + most);
            self.demand(Subject::Attribute(input.attribute.clone()), reach, Why::Join, text, derivation.place);
        }
    }

    pub(crate) fn demand(&mut self, subject: Subject, reach: Reach, why: Why, text: impl Fn() -> String, place: Place) {
        let text = if self.wordless { String::new() } else { text() };
        self.demands.push(Demand { subject, reach, why, text, place });
    }

    /// Adds a demand of all samples of the attribute.
    fn whole(&mut self, variable: &VariablePattern, why: Why, text: impl Fn() -> String, place: Place) {
        self.demand(Subject::Attribute(variable.attribute.clone()), Reach::Unbounded, why, text, place);
    }

    /// Adds the demand of constraints on time: their span, or no bound if they state no earliest time.
    fn times(
        &mut self,
        subject: Subject,
        constraints: &[Constraint],
        why: Why,
        text: impl Fn() -> String,
        place: Place,
    ) {
        match reach::of_constraints(constraints, self.library) {
            Some(span) => self.demand(subject, Reach::Span(span), Why::Window, text, place),
            None => self.demand(subject, Reach::Unbounded, why, text, place),
        }
    }

    fn log(&mut self, policy: &LogPolicy, place: Place) {
        let symbol = |part: Option<&Template>| match part {
            Some(Template::Constant(Value::Symbol(name))) => Some(name.clone()),
            _ => None,
        };
        let (head, word) = match &policy.subject {
            Template::Constant(form) => (
                form.head().cloned(),
                form.as_list().and_then(|parts| parts.get(1)).and_then(Value::as_symbol).cloned(),
            ),
            Template::List(parts) => (symbol(parts.first()), symbol(parts.get(1))),
            Template::Hole(_) | Template::Splice(_) => (None, None),
        };
        let reach = Reach::Log { time: policy.time_limit, count: policy.count_limit };
        let text = || format!("(log {})", Brief.template(&policy.subject));
        let subject = match (head, word) {
            (Some(head), Some(word)) if head.is(":events") => Subject::MessagesOf(word),
            (head, _) => head.map_or(Subject::EveryAttribute, Subject::Attribute),
        };
        self.demand(subject, reach, Why::Log, text, place);
    }

    fn procedure(&mut self, number: usize, procedure: &Procedure) {
        self.pattern(&procedure.index);
        self.all(procedure.expected_duration.iter().chain(&procedure.interrupt_cost));
        self.transitions(&procedure.transitions);
        self.hooks(&procedure.hooks);
        procedure.profile.iter().for_each(|need| {
            self.template(&need.resource);
            self.all(&need.amount);
        });
        procedure.log.iter().for_each(|policy| self.log(policy, procedure.place));
        procedure.steps.iter().for_each(|step| self.step(step));
        let known = self.index.and_then(|index| index.procedures.get(number)).map(Arc::clone);
        let index = known.unwrap_or_else(|| Arc::new(ProcedureIndex::new(procedure)));
        for (step, known) in procedure.steps.iter().zip(&index.steps) {
            if !known.condition_awaits.is_empty() {
                step.waitfor.iter().for_each(|condition| self.since_creation(condition));
            }
        }
    }

    /// Adds the demand of a condition that counts from the creation of its task but can be watched only later: all data that it could
    /// refer to are kept until then.
    fn since_creation(&mut self, condition: &Condition) {
        match &condition.kind {
            ConditionKind::Event { pattern, timing } => {
                let text = || Brief.event(pattern, timing);
                self.demand(Subject::Messages, Reach::Unbounded, Why::SinceCreation, text, condition.place);
            }
            ConditionKind::Measurement(measurement) => {
                let text = || Brief.measurement(measurement);
                self.whole(&measurement.variable, Why::SinceCreation, text, condition.place);
            }
            ConditionKind::Episode(episode) => {
                self.whole(&episode.variable, Why::SinceCreation, || Brief.episode(episode), condition.place);
            }
            ConditionKind::And(parts, _)
            | ConditionKind::Or(parts, _)
            | ConditionKind::InOrder(parts, _)
            | ConditionKind::Allen { parts, .. } => parts.iter().for_each(|part| self.since_creation(part)),
            ConditionKind::Not(part) | ConditionKind::Absent(part, _) => self.since_creation(part),
            ConditionKind::Probing { condition, .. } => self.since_creation(condition),
            ConditionKind::Cyclic(_)
            | ConditionKind::Delay(..)
            | ConditionKind::Timestamp(..)
            | ConditionKind::TaskEnded(_)
            | ConditionKind::TaskState { .. }
            | ConditionKind::Function(_) => {}
        }
    }

    fn primitive(&mut self, primitive: &Primitive) {
        self.pattern(&primitive.index);
        primitive.locals.iter().for_each(|(_, expr)| self.expr(expr));
        self.all(primitive.duration.iter().chain(&primitive.returns));
        if let Some((interval, forms)) = &primitive.update {
            self.all(interval);
            self.exprs(forms);
        }
        self.hooks(&primitive.hooks);
        self.exprs(&primitive.on_completion);
    }

    fn step(&mut self, step: &Step) {
        self.activity(&step.activity);
        step.on_failure.iter().for_each(|activity| self.activity(activity));
        step.waitfor.iter().for_each(|condition| self.condition(condition));
        step.select.iter().chain(step.forall.as_deref()).for_each(|(_, expr)| self.expr(expr));
        for clause in &step.priority {
            match clause {
                PriorityClause::Number(number) => self.expr(number),
                PriorityClause::UrgencyImportance(urgency, importance) => self.all([urgency, importance]),
            }
        }
        self.all(step.rank.as_deref().into_iter().chain(step.interrupt_cost.as_deref()));
        for repetition in step.repeating.as_deref().into_iter().chain(step.responding.as_deref()) {
            let Repetition { while_true, until, enabled, recovery, minimum_interval, for_new: _, drop_missed: _ } =
                repetition;
            self.all(while_true.iter().chain(until).chain(enabled).chain(recovery).chain(minimum_interval));
        }
        step.profile.iter().for_each(|need| {
            self.template(&need.resource);
            self.all(&need.amount);
        });
        self.transitions(&step.transitions);
        self.hooks(&step.hooks);
    }

    fn activity(&mut self, activity: &Activity) {
        match activity {
            Activity::Goal(template) => self.template(template),
            Activity::Terminate { task, outcome, value } => {
                self.all([task, outcome, value].into_iter().flatten().map(AsRef::as_ref))
            }
            Activity::BuiltIn(_, arguments) => self.exprs(arguments),
        }
    }

    fn transitions(&mut self, transitions: &Transitions) {
        // The newest samples, which `precondition` and `invariant` read, are always kept.
        let Transitions { end_when, restart_when, resume_when, suspend_when, suspend_until, .. } = transitions;
        let all = end_when.iter().chain(restart_when).chain(resume_when).chain(suspend_when).chain(suspend_until);
        let all = all.chain(&transitions.skip_when).chain(&transitions.exit_when);
        all.for_each(|condition| self.condition(condition));
    }

    fn hooks(&mut self, hooks: &Hooks) {
        [&hooks.on_start, &hooks.on_end, &hooks.on_suspend, &hooks.on_resume]
            .into_iter()
            .for_each(|forms| self.exprs(forms));
    }

    fn measurement(&mut self, measurement: &MeasurementCondition, place: Place) {
        if !measurement.timestamp.is_empty() {
            let subject = Subject::Attribute(measurement.variable.attribute.clone());
            let text = || Brief.measurement(measurement);
            self.times(subject, &measurement.timestamp, Why::AnyTime, text, place);
        }
        self.pattern(&measurement.variable.object);
        [&measurement.value, &measurement.object, &measurement.timestamp]
            .into_iter()
            .for_each(|each| self.constraints(each));
        match &measurement.estimation {
            Some(Estimation::Persist(timeout)) => self.all(timeout),
            Some(Estimation::LinearRegression(options)) => {
                // A fit interval that is stated may begin before the task.
                if let Some((_, start)) = options.iter().find(|(name, _)| name.is("start")) {
                    let subject = Subject::Attribute(measurement.variable.attribute.clone());
                    let text = || Brief.measurement(measurement);
                    match reach::before_now(start, self.library) {
                        Some(span) => self.demand(subject, Reach::Span(span), Why::Window, text, place),
                        None => self.demand(subject, Reach::Unbounded, Why::FitInterval, text, place),
                    }
                }
                options.iter().for_each(|(_, expr)| self.expr(expr));
            }
            None => {}
        }
    }

    fn episode(&mut self, episode: &EpisodeCondition, place: Place) {
        if !episode.timing.start.is_empty() || !episode.timing.end.is_empty() {
            // A run is judged by its own start, which may lie before every limit.
            self.whole(&episode.variable, Why::EpisodeTimes, || Brief.episode(episode), place);
        }
        if let Quality::MaximumGap(gap) = &episode.quality {
            self.expr(gap);
        }
        self.pattern(&episode.variable.object);
        [&episode.value, &episode.first_value, &episode.last_value, &episode.object]
            .into_iter()
            .for_each(|each| self.constraints(each));
        self.timing(&episode.timing);
        // A `:custom` trend reads the values of the whole run.
        if episode.trend.iter().any(|(name, _)| name.is("custom")) {
            self.whole(&episode.variable, Why::Values, || Brief.episode(episode), place);
        }
        episode.stats.iter().chain(&episode.trend).for_each(|(_, constraints)| self.constraints(constraints));
    }

    fn condition(&mut self, condition: &Condition) {
        match &condition.kind {
            ConditionKind::Measurement(measurement) => self.measurement(measurement, condition.place),
            ConditionKind::Episode(episode) => self.episode(episode, condition.place),
            ConditionKind::Event { pattern, timing } => {
                if !timing.start.is_empty() || !timing.end.is_empty() {
                    let limits: Vec<Constraint> = timing.start.iter().chain(&timing.end).cloned().collect();
                    let text = || Brief.event(pattern, timing);
                    self.times(Subject::Messages, &limits, Why::EventTimes, text, condition.place);
                }
                self.pattern(pattern);
                self.timing(timing);
            }
            ConditionKind::And(parts, constraints)
            | ConditionKind::Or(parts, constraints)
            | ConditionKind::InOrder(parts, constraints)
            | ConditionKind::Allen { parts, constraints, .. } => {
                parts.iter().for_each(|part| self.condition(part));
                self.exprs(constraints);
            }
            ConditionKind::Not(part) => self.condition(part),
            ConditionKind::Absent(part, _) => {
                self.beside_late(part, condition.place);
                self.condition(part);
            }
            ConditionKind::Probing { condition, .. } => self.condition(condition),
            ConditionKind::Delay(from, to) | ConditionKind::Timestamp(from, to) => {
                self.expr(from);
                self.all(to);
            }
            ConditionKind::TaskEnded(_) => {}
            ConditionKind::TaskState { task, state } => {
                self.expr(task);
                self.pattern(state);
            }
            ConditionKind::Function(expr) => self.expr(expr),
            ConditionKind::Cyclic(wanted) => {
                self.whole(&wanted.variable, Why::Cycles, || Brief.cyclic(wanted), condition.place);
                wanted.options.iter().for_each(|(_, constraints)| self.constraints(constraints));
            }
        }
    }

    fn timing(&mut self, timing: &Timing) {
        [&timing.start, &timing.end, &timing.duration].into_iter().for_each(|each| self.constraints(each));
    }

    fn constraints(&mut self, constraints: &[Constraint]) {
        for constraint in constraints {
            match constraint {
                Constraint::Compare { right, tolerance, .. } => {
                    self.expr(right);
                    self.all(tolerance);
                }
                Constraint::Matches(pattern) => self.pattern(pattern),
                Constraint::Predicate(_, arguments) => self.exprs(arguments),
                Constraint::Range(least, most) => self.all(least.iter().chain(most)),
            }
        }
    }

    fn pattern(&mut self, pattern: &Pattern) {
        match pattern {
            Pattern::Computed(expr) | Pattern::Guard(expr) => self.expr(expr),
            Pattern::List(parts) | Pattern::And(parts) | Pattern::Or(parts) => {
                parts.iter().for_each(|part| self.pattern(part));
            }
            Pattern::Not(part) => self.pattern(part),
            Pattern::Literal(_)
            | Pattern::Variable(_)
            | Pattern::BoundVariable(_)
            | Pattern::Anonymous
            | Pattern::Segment { .. }
            | Pattern::Is { .. } => {}
        }
    }

    fn template(&mut self, template: &Template) {
        match template {
            Template::Constant(_) => {}
            Template::Hole(expr) | Template::Splice(expr) => self.expr(expr),
            Template::List(parts) => parts.iter().for_each(|part| self.template(part)),
        }
    }

    fn exprs(&mut self, exprs: &[Expr]) {
        self.all(exprs);
    }

    fn all<'e>(&mut self, exprs: impl IntoIterator<Item = &'e Expr>) {
        exprs.into_iter().for_each(|expr| self.expr(expr));
    }

    fn expr(&mut self, expr: &Expr) {
        match &expr.kind {
            ExprKind::Call { function, arguments } => {
                self.query(function, arguments, expr);
                self.exprs(arguments);
            }
            ExprKind::FunctionName(function) => self.query(function, &[], expr),
            ExprKind::If(test, then, otherwise) => self.all([&**test, &**then].into_iter().chain(otherwise.as_deref())),
            ExprKind::Cond(clauses) => clauses.iter().for_each(|(test, forms)| {
                self.expr(test);
                self.exprs(forms);
            }),
            ExprKind::Case(key, clauses) => {
                self.expr(key);
                clauses.iter().for_each(|(_, forms)| self.exprs(forms));
            }
            ExprKind::And(parts) | ExprKind::Or(parts) | ExprKind::Sequence(parts) => self.exprs(parts),
            ExprKind::Let { bindings, body, .. } => {
                bindings.iter().for_each(|(_, initial)| self.expr(initial));
                self.exprs(body);
            }
            ExprKind::Lambda { parameters, body } => {
                self.all(parameters.optional.iter().filter_map(|(_, default)| default.as_ref()));
                self.exprs(body);
            }
            ExprKind::Assign { value, .. } => self.expr(value),
            ExprKind::Template(template) => self.template(template),
            ExprKind::Constant(_)
            | ExprKind::Variable { .. }
            | ExprKind::Local(_)
            | ExprKind::Indexical(_)
            | ExprKind::Named(_) => {}
        }
    }
}
