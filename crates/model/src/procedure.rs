//! Procedures, steps and primitives after checking (`pdl.md`, Procedures, Steps, Primitives). Paper: section III.
//!
//! Solver plans become the same [`Procedure`] type.

use crate::condition::Condition;
use crate::expression::{Expr, Template};
use crate::pattern::Pattern;
use crate::source::Place;
use crate::symbol::Symbol;
use crate::time::Duration;
use serde::{Deserialize, Serialize};

/// Order in which a procedure executes its steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ProcedureKind {
    /// All steps at once, unless waitfors order them.
    Concurrent,
    /// Each step after the end of the preceding one.
    Sequential,
    /// All at once, conflicts resolved by rank 1..n in written order.
    Ranked,
    /// In written order where resources conflict (`soft-seq` of the original Apex).
    SoftSequential,
}

/// A stored or generated procedure: the template of a controller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Procedure {
    /// Order of the steps.
    pub kind: ProcedureKind,
    /// The class of goals that it serves.
    pub index: Pattern,
    /// Resources that its task needs to be ongoing.
    pub profile: Vec<ResourceNeed>,
    /// Logging policies open while its task lives.
    pub log: Vec<LogPolicy>,
    /// Estimate of its duration.
    pub expected_duration: Option<Expr>,
    /// Added to the task's priority while it is ongoing; `None` is the default 0.1.
    pub interrupt_cost: Option<Expr>,
    /// Transition clauses at procedure level.
    pub transitions: Transitions,
    /// Hooks at procedure level.
    pub hooks: Hooks,
    /// The steps in written order. `terminate` steps are steps too.
    pub steps: Vec<Step>,
    /// The bundle it belongs to.
    pub bundle: Option<Symbol>,
    /// Place in the source.
    pub place: Place,
}

/// `(profile ..)` entry: a resource and how much of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResourceNeed {
    /// The name, possibly a variable bound by the index.
    pub resource: Template,
    /// Units of a capacity or amount of a depletable resource; `None` takes the whole resource.
    pub amount: Option<Expr>,
    /// `:refuse-if-busy`: the task fails instead of waiting for the resource.
    #[serde(default)]
    pub refuse_if_busy: bool,
    /// Place in the source.
    pub place: Place,
}

/// `(log ..)` clause.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LogPolicy {
    /// The state variable, `(ATTR OBJ)`, or messages by their first word, `(:events HEAD)`.
    pub subject: Template,
    /// Least time between two kept samples or messages.
    pub frequency_limit: Option<Duration>,
    /// Greatest age of kept samples or messages, in comparison with the newest one.
    pub time_limit: Option<Duration>,
    /// Maximum number of kept samples or messages.
    pub count_limit: Option<u64>,
}

/// Clauses that change the state of a task while it lives.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Transitions {
    /// `end-when`, `(terminate (when C))`.
    pub end_when: Option<Box<Condition>>,
    /// `restart-when`.
    pub restart_when: Option<Box<Condition>>,
    /// `resume-when`.
    pub resume_when: Option<Box<Condition>>,
    /// `suspend-when C [until C]`.
    pub suspend_when: Option<Box<Condition>>,
    /// The `until` of `suspend-when`.
    pub suspend_until: Option<Box<Condition>>,
    /// `skip-when`, of steps only: the task is not begun.
    pub skip_when: Option<Box<Condition>>,
    /// `exit-when`: the task ends without success or failure.
    pub exit_when: Option<Box<Condition>>,
    /// `precondition`: must hold as the task begins; judged at instants, not watched.
    pub precondition: Option<Box<Condition>>,
    /// `invariant`: must hold while the task is ongoing; judged at instants, not watched.
    pub invariant: Option<Box<Condition>>,
}

/// Forms evaluated at moments of a task's life, in order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Hooks {
    /// `on-start`, and a primitive's `on-enablement`.
    pub on_start: Vec<Expr>,
    /// `on-end`: at termination, whatever the outcome.
    pub on_end: Vec<Expr>,
    /// `on-suspend`.
    pub on_suspend: Vec<Expr>,
    /// `on-resume`.
    pub on_resume: Vec<Expr>,
}

/// One step of a procedure: the template of a task. Rarely used fields are boxed, because a program may have a hundred thousand steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Its name; also the variable `?tag` that holds its task.
    pub tag: Symbol,
    /// Activity of the step.
    pub activity: Activity,
    /// `=> ?v`: the pattern to which the task's value is bound in the parent's context.
    pub binds: Option<Box<Pattern>>,
    /// Preconditions; empty means none. All must hold.
    pub waitfor: Vec<Condition>,
    /// `select` clauses in order.
    pub select: Vec<(Symbol, Expr)>,
    /// `forall ?x in LIST`.
    pub forall: Option<Box<(Symbol, Expr)>>,
    /// Priority clauses; the task takes the greatest.
    pub priority: Vec<PriorityClause>,
    /// `rank`.
    pub rank: Option<Box<Expr>>,
    /// `interrupt-cost`.
    pub interrupt_cost: Option<Box<Expr>>,
    /// `repeating`.
    pub repeating: Option<Box<Repetition>>,
    /// `responding`.
    pub responding: Option<Box<Repetition>>,
    /// Resources that the step itself needs.
    pub profile: Vec<ResourceNeed>,
    /// Transition clauses at step level.
    pub transitions: Transitions,
    /// Hooks at step level.
    pub hooks: Hooks,
    /// Goal to pursue if the step fails.
    pub on_failure: Option<Box<Activity>>,
    /// Place in the source.
    pub place: Place,
}

impl Step {
    /// Returns a step that executes `activity` at once, without clauses.
    pub fn plain(tag: Symbol, activity: Activity, place: Place) -> Step {
        Step {
            tag,
            activity,
            binds: None,
            waitfor: Vec::new(),
            select: Vec::new(),
            forall: None,
            priority: Vec::new(),
            rank: None,
            interrupt_cost: None,
            repeating: None,
            responding: None,
            profile: Vec::new(),
            transitions: Transitions::default(),
            hooks: Hooks::default(),
            on_failure: None,
            place,
        }
    }
}

/// Activity of a step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Activity {
    /// A goal, matched against procedures, primitives and solvers.
    Goal(Template),
    /// `(terminate [task] [outcome] [>> value])`; without a task it ends the procedure.
    Terminate {
        /// The task to end; `None` is the step's parent.
        task: Option<Box<Expr>>,
        /// The outcome; `None` is success.
        outcome: Option<Box<Expr>>,
        /// The value passed to the parent.
        value: Option<Box<Expr>>,
    },
    /// Another built-in activity; its arguments are expressions.
    BuiltIn(BuiltInActivity, Vec<Expr>),
}

/// Activities that need no procedure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum BuiltInActivity {
    /// `(reset TASK)`
    Reset,
    /// `(suspend TASK)`
    Suspend,
    /// `(resume TASK)`
    Resume,
    /// `(reprioritize TASK)`
    Reprioritize,
    /// `(cogevent FORM [AGENT])`
    Cogevent,
    /// `(inform FORM [ROUTER])`: sends the form as an event to this agent, to outside and along its routers.
    Inform,
    /// `(hold-resource R..)`
    HoldResource,
    /// `(release-resource R..)`
    ReleaseResource,
    /// `(print ..)`
    Print,
    /// `(end-application)`
    EndApplication,
    /// `(ask operator ..)`: its arguments are question, options, by (nil if absent), and the default if there is one.
    AskOperator,
    /// `(plan GOAL ..)`: arguments are goal, solver and budget (nil if absent).
    Plan,
}

impl BuiltInActivity {
    /// Returns the activity's name in PDL: the first of its [`words`](BuiltInActivity::words).
    pub fn word(self) -> &'static str {
        self.words().0.first().copied().unwrap_or_default()
    }

    /// Returns the words that the activity begins with in PDL, and the keywords of its last arguments.
    pub fn words(self) -> (&'static [&'static str], &'static [&'static str]) {
        match self {
            BuiltInActivity::Reset => (&["reset"], &[]),
            BuiltInActivity::Suspend => (&["suspend"], &[]),
            BuiltInActivity::Resume => (&["resume"], &[]),
            BuiltInActivity::Reprioritize => (&["reprioritize"], &[]),
            BuiltInActivity::Cogevent => (&["cogevent"], &[]),
            BuiltInActivity::Inform => (&["inform"], &[]),
            BuiltInActivity::HoldResource => (&["hold-resource"], &[]),
            BuiltInActivity::ReleaseResource => (&["release-resource"], &[]),
            BuiltInActivity::Print => (&["print"], &[]),
            BuiltInActivity::EndApplication => (&["end-application"], &[]),
            BuiltInActivity::AskOperator => (&["ask", "operator"], &[":options", ":by", ":default"]),
            BuiltInActivity::Plan => (&["plan"], &[":with", ":budget"]),
        }
    }
}

/// `priority` clause.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum PriorityClause {
    /// A number or expression.
    Number(Expr),
    /// Urgency and importance, each 0..10.
    UrgencyImportance(Expr, Expr),
}

/// Options of `repeating` and `responding`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Repetition {
    /// The step repeats only while this is true.
    pub while_true: Option<Expr>,
    /// The step repeats only until this is true.
    pub until: Option<Expr>,
    /// `:enabled`: the new instance starts enabled, when the expression (default true) holds.
    pub enabled: Option<Expr>,
    /// `:with-recovery`: priority recovers over this span.
    pub recovery: Option<Expr>,
    /// `:with-min-interval`.
    pub minimum_interval: Option<Expr>,
    /// `:for-new`: one instance for each new combination of these variables.
    pub for_new: Vec<Symbol>,
    /// `:missed-messages drop`: messages that arrive while the step is busy are not answered.
    pub drop_missed: bool,
}

/// A primitive: the template of a command to the controlled system.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Primitive {
    /// The class of goals that it serves.
    pub index: Pattern,
    /// Resources that its task needs.
    pub profile: Vec<ResourceNeed>,
    /// Variables of the primitive with initial values, in order.
    pub locals: Vec<(Symbol, Expr)>,
    /// Duration of its task.
    pub duration: Option<Expr>,
    /// Interval and forms that are evaluated at each interval while the task is ongoing; `None` for the agent's default interval.
    pub update: Option<(Option<Expr>, Vec<Expr>)>,
    /// `on-start`/`on-enablement`, `on-end`, `on-suspend`, `on-resume`.
    pub hooks: Hooks,
    /// Forms evaluated at completion, not at other ends.
    pub on_completion: Vec<Expr>,
    /// The value of its task.
    pub returns: Option<Expr>,
    /// The bundle it belongs to.
    pub bundle: Option<Symbol>,
    /// Place in the source.
    pub place: Place,
}
