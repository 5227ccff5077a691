//! The abstract syntax of programs, which the generator makes, the interpreter runs, and the printer writes as PDL.

use crate::value::Value;

/// An instant, in nanoseconds since the beginning.
pub type Time = i64;
/// A span of time in nanoseconds.
pub type Span = i64;
/// One second.
pub const SECOND: Span = 1_000_000_000;

/// A whole program. The initial goal is `(do-domain)`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Program {
    /// Declared resources; all others are unitary.
    pub resources: Vec<Resource>,
    /// Procedures in written order.
    pub procedures: Vec<Procedure>,
    /// Primitives in written order.
    pub primitives: Vec<Primitive>,
}

/// A declared resource.
#[derive(Clone, Debug, PartialEq)]
pub struct Resource {
    /// Its name.
    pub name: String,
    /// Shareable units, or the depletable amount.
    pub amount: f64,
    /// True if users use the resource up.
    pub depletable: bool,
    /// The resource of which this one is a part.
    pub part_of: Option<String>,
}

/// One word of a phrase or of a pattern.
#[derive(Clone, Debug, PartialEq)]
pub enum Term {
    /// Itself.
    Is(Value),
    /// `?x`
    Variable(String),
    /// `?`, in patterns only.
    Anything,
}

/// Order of the steps of a procedure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// All at once.
    Concurrent,
    /// In sequence.
    Sequential,
    /// All at once, ranks in written order.
    Ranked,
    /// Another name for the order above.
    SoftSequential,
}

/// A procedure.
#[derive(Clone, Debug, PartialEq)]
pub struct Procedure {
    /// The order of its steps.
    pub kind: Kind,
    /// The goals that it serves.
    pub index: Vec<Term>,
    /// Required resources.
    pub profile: Vec<Need>,
    /// Interrupt cost.
    pub interrupt_cost: Option<Expr>,
    /// Expected duration.
    pub expected: Option<Span>,
    /// Conditions that end, restart, suspend and resume the task.
    pub clauses: Clauses,
    /// Forms that run at certain moments.
    pub hooks: Hooks,
    /// Its steps.
    pub steps: Vec<Step>,
}

/// A primitive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Primitive {
    /// The goals that it serves.
    pub index: Vec<Term>,
    /// Required resources.
    pub profile: Vec<Need>,
    /// Its own variables with their first values.
    pub locals: Vec<(String, Expr)>,
    /// Duration.
    pub duration: Option<Expr>,
    /// Forms that run periodically.
    pub update: Option<(Span, Vec<Form>)>,
    /// Forms that run at certain moments.
    pub hooks: Hooks,
    /// Forms that run when the primitive is complete.
    pub on_completion: Vec<Form>,
    /// Its value.
    pub returns: Option<Expr>,
}

/// One entry of a profile.
#[derive(Clone, Debug, PartialEq)]
pub struct Need {
    /// The resource: a word or a variable.
    pub resource: Term,
    /// Required amount; `None` for all of the resource.
    pub amount: Option<f64>,
    /// The task fails if it would have to wait for its resources.
    pub refuse_if_busy: bool,
}

/// Conditions that move a task.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clauses {
    /// The task ends, with success.
    pub end_when: Option<Condition>,
    /// The task starts over.
    pub restart_when: Option<Condition>,
    /// The task is suspended by the first condition until the second one holds.
    pub suspend_when: Option<(Condition, Condition)>,
    /// The task continues.
    pub resume_when: Option<Condition>,
    /// The task is not begun; for steps only.
    pub skip_when: Option<Condition>,
    /// The task ends without success or failure.
    pub exit_when: Option<Condition>,
    /// Must hold when the task begins.
    pub precondition: Option<Condition>,
    /// Must hold while the task works.
    pub invariant: Option<Condition>,
}

/// Forms that run at certain moments of a task's life.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hooks {
    /// Forms executed at its start.
    pub on_start: Vec<Form>,
    /// Forms executed at its end, of any kind.
    pub on_end: Vec<Form>,
    /// Forms executed at its interruption.
    pub on_suspend: Vec<Form>,
    /// Forms executed when it resumes.
    pub on_resume: Vec<Form>,
}

/// A step.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Its name.
    pub tag: String,
    /// Activity.
    pub activity: Activity,
    /// `=> ?x`
    pub binds: Option<String>,
    /// Conditions that must all become true before the task is enabled.
    pub waitfor: Vec<Condition>,
    /// Computed when it is enabled.
    pub select: Vec<(String, Expr)>,
    /// One task for each item.
    pub forall: Option<(String, Expr)>,
    /// Priorities: the greatest counts.
    pub priority: Vec<Priority>,
    /// Its rank among its siblings.
    pub rank: Option<Expr>,
    /// Interrupt cost.
    pub interrupt_cost: Option<Expr>,
    /// `repeating`: the step is executed again after each end.
    pub repetition: Option<Repetition>,
    /// Required resources in addition to those of its method.
    pub profile: Vec<Need>,
    /// Forms that run at certain moments.
    pub hooks: Hooks,
    /// Conditions that move it.
    pub clauses: Clauses,
    /// Activity after a failure.
    pub on_failure: Option<Activity>,
}

impl Step {
    /// Returns a step without clauses.
    pub fn plain(tag: &str, activity: Activity) -> Step {
        Step {
            tag: tag.into(),
            activity,
            binds: None,
            waitfor: Vec::new(),
            select: Vec::new(),
            forall: None,
            priority: Vec::new(),
            rank: None,
            interrupt_cost: None,
            repetition: None,
            profile: Vec::new(),
            hooks: Hooks::default(),
            clauses: Clauses::default(),
            on_failure: None,
        }
    }
}

/// A stated priority.
#[derive(Clone, Debug, PartialEq)]
pub enum Priority {
    /// A number.
    Number(Expr),
    /// Urgency at creation, and importance.
    Urgency(f64, f64),
}

/// `repeating` and `responding`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Repetition {
    /// A new instance waits next to each enabled one, instead of the same task again.
    pub responding: bool,
    /// The step is repeated as long as this holds.
    pub while_true: Option<Expr>,
    /// The step is not repeated once this holds.
    pub until: Option<Expr>,
    /// `:enabled`: further repetitions do not wait for the conditions.
    pub enabled: bool,
    /// The span over which its priority recovers.
    pub recovery: Option<Span>,
    /// Minimum time between the starts of two repetitions.
    pub minimum_interval: Option<Span>,
    /// One instance for each combination of these variables.
    pub for_new: Vec<String>,
    /// `:missed-messages drop`: messages that arrive while the step is busy are not answered.
    pub drop_missed: bool,
}

/// Activity of a step.
#[derive(Clone, Debug, PartialEq)]
pub enum Activity {
    /// A goal for a procedure or primitive.
    Goal(Vec<Term>),
    /// `(terminate [?tag] [outcome] [>> value])`
    Terminate {
        /// Tag of the step that ends; `None`: its procedure.
        tag: Option<String>,
        /// `success`, `failure`, `cut`.
        outcome: Option<String>,
        /// The value.
        value: Option<Expr>,
    },
    /// `(reset ?tag)`
    Reset(String),
    /// `(suspend ?tag)`
    Suspend(String),
    /// `(resume ?tag)`
    Resume(String),
    /// `(reprioritize ?tag)`
    Reprioritize(String),
    /// `(inform (PHRASE))`
    Inform(Vec<Term>),
    /// `(cogevent (PHRASE))`
    Cogevent(Vec<Term>),
    /// `(print WORD)`
    Print(Expr),
    /// `(hold-resource r)`
    Hold(String),
    /// `(release-resource r)`
    Release(String),
    /// `(end-application)`
    EndApplication,
}

/// A comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    /// `=`
    Equal,
    /// `<`
    Less,
    /// `<=`
    AtMost,
    /// `>`
    More,
    /// `>=`
    AtLeast,
}

/// A condition.
#[derive(Clone, Debug, PartialEq)]
pub enum Condition {
    /// A message that matches.
    Event(Vec<Term>),
    /// A sample of `(attribute object)` that has this relation to the number.
    Measurement(String, Term, Relation, f64),
    /// A sample of `(attribute object)`; its value is bound.
    Sample(String, Term, String),
    /// The step's task has ended.
    Ended(String),
    /// The step's task is in this state (`resumed` is the change back to ongoing); `+this-task+` if none.
    State(Option<String>, String),
    /// All parts hold.
    And(Vec<Condition>),
    /// At least one of the parts.
    Or(Vec<Condition>),
    /// The condition has had no result up to now.
    Not(Box<Condition>),
    /// The parts hold in sequence.
    InOrder(Vec<Condition>),
    /// A duration since the task's creation, or since the part before.
    Delay(Span, Option<Span>),
}

/// A pure expression.
#[derive(Clone, Debug, PartialEq)]
pub enum Expr {
    /// Itself.
    Is(Value),
    /// `?x`
    Variable(String),
    /// `(+ a b)`
    Sum(Box<Expr>, Box<Expr>),
    /// `(- a b)`
    Difference(Box<Expr>, Box<Expr>),
    /// A comparison of numbers or spans.
    Compare(Relation, Box<Expr>, Box<Expr>),
    /// `(if c a b)`
    If(Box<Expr>, Box<Expr>, Box<Expr>),
    /// `(current-value 'attribute 'object)`
    Current(String, String),
    /// `+met+`
    MissionTime,
    /// `(task-state ?tag)`
    StateOf(String),
    /// `(first e)`, an error where e is not a list.
    First(Box<Expr>),
}

/// A form of a hook.
#[derive(Clone, Debug, PartialEq)]
pub enum Form {
    /// `(inform (PHRASE))`
    Inform(Vec<Term>),
    /// `(print e)`
    Print(Expr),
    /// `(setq ?x e)`: sets a variable of the task, or a local of the primitive if it has one with that name.
    Set(String, Expr),
    /// `(publish (attribute object) e)`
    Publish(String, String, Expr),
    /// `(complete [e])`
    Complete(Option<Expr>),
    /// `(when e form)`
    When(Expr, Box<Form>),
}
