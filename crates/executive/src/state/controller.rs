//! Controllers: the state of an ongoing task's execution (paper, section III). One kind for each kind of method.

use crate::state::bindings::Bindings;
use crate::state::children::Children;
use crate::state::resource::Need;
use crate::state::task::ProcedureRef;
use crate::state::wake::WakeKey;
use apex_model::effect::{CommandId, QuestionId, SolveRequestId};
use apex_model::procedure::BuiltInActivity;
use apex_model::task::TaskId;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use serde::{Deserialize, Serialize};
use smallvec::SmallVec;

/// Method for a task's goal: chosen when the task is enabled, kept until the task ends or starts over.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Selection {
    /// The goal with its variables filled in.
    pub goal: Value,
    /// The method.
    pub way: MethodBinding,
    /// The needs of the profile, which are granted together or not at all.
    pub needs: Vec<Need>,
    /// Added to the priority of the task while the task defends its resources.
    pub interrupt_cost: f64,
    /// Expected duration, if stated.
    pub expected: Option<Duration>,
    /// True if the work has begun and uses its granted amounts; before that, depletable amounts are not consumed.
    #[serde(default)]
    pub begun: bool,
    /// True if the task fails instead of waiting for its needs (`:refuse-if-busy`).
    #[serde(default)]
    pub refuses: bool,
}

/// Methods for a goal, each with its data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum MethodBinding {
    /// A procedure, with the bindings of its index.
    Procedure(ProcedureRef, Bindings),
    /// A primitive (its index in the library), with the bindings of its index.
    Primitive(u32, Bindings),
    /// One child task per item.
    Items(Vec<Value>),
    /// A built-in activity, whose arguments are evaluated at the start.
    BuiltIn(BuiltInActivity),
    /// The built-in activity `(terminate ..)`.
    Terminate,
    /// A procedure that a solver (the index of its declaration) must plan first.
    Solver(u32),
}

/// Controller of an ongoing task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Controller {
    /// An instance of a procedure.
    Procedure(ProcedureController),
    /// An instance of a primitive.
    Primitive(PrimitiveController),
    /// The items of a `forall`.
    Items(ItemsController),
    /// Waits for the operator.
    Question(QuestionController),
    /// Waits for a plan.
    Planning(PlanningController),
    /// A failure is being handled by another goal.
    Handling(HandlingController),
    /// A built-in activity that is complete at once.
    BuiltIn,
}

/// An instance of a procedure: one context, one child per step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProcedureController {
    /// The template.
    pub procedure: ProcedureRef,
    /// Its variables: index bindings, `=>` results. Tags are read from `current`.
    pub context: Bindings,
    /// The task that each step's tag names now.
    pub current: SmallVec<[Option<TaskId>; 1]>,
    /// All children that still exist, ended ones included.
    pub children: Children,
    /// Number of steps that the end of the procedure waits for.
    pub open: u32,
    /// In a sequence, the number of the first step that has not ended; later steps that have ended are passed when it does.
    pub turn: u32,
    /// Number of times that a repeating plan began again at `instant`.
    pub rounds: u32,
    /// The instant of `rounds`.
    pub instant: Time,
}

/// An instance of a primitive.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PrimitiveController {
    /// The template: its index in the library.
    pub primitive: u32,
    /// Bindings of its index and assignments of its forms.
    pub context: Bindings,
    /// Its `locals`.
    pub locals: Bindings,
    /// Duration, if it has one.
    pub duration: Option<Duration>,
    /// Time worked before the present stretch.
    pub worked: Duration,
    /// Beginning of the present stretch; `None` while interrupted.
    pub running_since: Option<Time>,
    /// The end of the duration.
    pub end: Option<WakeKey>,
    /// The next update.
    pub update: Option<WakeKey>,
    /// Interval of updates; `None` without updates.
    pub update_interval: Option<Duration>,
    /// Remaining time to the next update when it was interrupted.
    pub update_left: Duration,
    /// Commands without an answer.
    pub commands: Vec<CommandId>,
    /// Commands taken back by an interruption, to be sent again, with their timeouts.
    pub withdrawn: Vec<(Value, Duration)>,
    /// True if it sent commands: it then ends with their answers, unless it has a duration.
    pub commanded: bool,
    /// The last answer's value.
    pub answer: Option<Value>,
}

/// The children of a `forall`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ItemsController {
    /// Children that still exist.
    pub children: Children,
    /// Number of items that have not ended.
    pub open: u64,
    /// Number of items.
    pub items: u64,
}

/// A question to the operator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct QuestionController {
    /// The number under which the question was asked last.
    pub question: QuestionId,
    /// False while the question is withdrawn, because the task is interrupted.
    pub open: bool,
    /// The question.
    pub text: String,
    /// Choices; empty leaves the answer free.
    pub options: Vec<Value>,
    /// Deadline of the operator's answer.
    pub by: Option<Time>,
    /// Answer taken at the deadline; `None` fails the task.
    pub default: Option<Value>,
    /// The wake at that instant.
    pub wake: Option<WakeKey>,
}

/// A plan that is awaited.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanningController {
    /// The request.
    pub request: SolveRequestId,
    /// The goal that is planned for.
    pub goal: Value,
    /// Task that pursues the solver's `:meanwhile` goal until the plan arrives.
    pub meanwhile: Option<TaskId>,
    /// True if the plan is to be pursued as soon as it arrives, because the task's own goal has no procedure.
    pub pursue: bool,
    /// Time limit for the answer.
    pub patience: Duration,
    /// Wake at the time limit; `None` once there is an answer.
    pub wake: Option<WakeKey>,
    /// The plan, if it arrived while the task was interrupted.
    pub arrived: Option<ProcedureRef>,
}

/// A failure that another goal handles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HandlingController {
    /// The task that handles it.
    pub handler: TaskId,
}

impl Controller {
    /// Returns true if the task has a child.
    pub fn has_children(&self) -> bool {
        match self {
            Controller::Procedure(controller) => controller.children.iter().next().is_some(),
            Controller::Items(controller) => controller.children.iter().next().is_some(),
            Controller::Planning(controller) => controller.meanwhile.is_some(),
            Controller::Handling(_) => true,
            Controller::Primitive(_) | Controller::Question(_) | Controller::BuiltIn => false,
        }
    }

    /// Returns the children that still exist, in order of creation.
    pub fn children(&self) -> Vec<TaskId> {
        match self {
            Controller::Procedure(controller) => controller.children.iter().collect(),
            Controller::Items(controller) => controller.children.iter().collect(),
            Controller::Planning(controller) => controller.meanwhile.into_iter().collect(),
            Controller::Handling(controller) => vec![controller.handler],
            Controller::Primitive(_) | Controller::Question(_) | Controller::BuiltIn => Vec::new(),
        }
    }
}

/// A command without an answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OpenCommand {
    /// The primitive's task.
    pub task: TaskId,
    /// The command.
    pub form: Value,
    /// Instant at which it was sent.
    pub sent_at: Time,
    /// Time limit for the answer.
    pub patience: Duration,
    /// The wake at that limit.
    pub timeout: WakeKey,
}
