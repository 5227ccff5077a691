//! The checked library: everything an agent knows before it starts (`pdl.md`, Text, Procedures, Primitives, Applications).

use crate::agent_limits::Limits;
use crate::derivation::Derivation;
use crate::expression::{Expr, Parameters, Template};
use crate::interface::{InterfaceDeclaration, NameKind};
use crate::pattern::Pattern;
use crate::procedure::{Primitive, Procedure};
use crate::quantity::Dimension;
use crate::source::{Place, SourceFile};
use crate::symbol::Symbol;
use crate::value::Value;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Checked definitions. The PDL front end builds them; all later code relies on their correctness.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Library {
    /// Source texts, in load order; [`Place::file`] indexes them.
    pub sources: Vec<SourceFile>,
    /// Procedures in library order.
    pub procedures: Vec<Arc<Procedure>>,
    /// Primitives in library order.
    pub primitives: Vec<Arc<Primitive>>,
    /// Declared solvers in library order.
    pub solvers: Vec<SolverDeclaration>,
    /// `(state-variable ..)` declarations by attribute.
    pub state_variables: BTreeMap<Symbol, StateVariableDeclaration>,
    /// The state variables that are computed from others, by attribute.
    #[serde(default)]
    pub derivations: BTreeMap<Symbol, Derivation>,
    /// `(resource ..)` declarations by name.
    pub resources: BTreeMap<Symbol, ResourceDeclaration>,
    /// `(defindexical +name+ EXPR)`, by name without the plus signs.
    pub indexicals: BTreeMap<Symbol, Expr>,
    /// `(defconstant name EXPR)` whose value is computed, by the name as written. Loading an agent computes them.
    pub constants: BTreeMap<Symbol, Expr>,
    /// `(defun name (parameter..) body..)`.
    pub functions: BTreeMap<Symbol, Function>,
    /// Declared host functions (`(declare-function ..)`).
    pub host_functions: BTreeMap<Symbol, HostDeclaration>,
    /// Kinds of the objects of state variables, by attribute, if the declaration names one: `(state-variable (fuel ?aircraft))`.
    #[serde(default)]
    pub objects: BTreeMap<Symbol, NameKind>,
    /// `(declare-event ..)` by the message's first word.
    #[serde(default)]
    pub events: BTreeMap<Symbol, InterfaceDeclaration>,
    /// `(declare-command ..)` by the command's name.
    #[serde(default)]
    pub commands: BTreeMap<Symbol, InterfaceDeclaration>,
    /// `(defapplication ..)`, if any.
    pub application: Option<Application>,
    /// `(agent ..)` forms, outside and inside of the application, in order.
    pub agents: Vec<AgentDeclaration>,
    /// `(router NAME ..)` declarations by name; the router `default` exists without one.
    pub routers: BTreeMap<Symbol, RouterDeclaration>,
}

impl Library {
    /// Returns the agents to run: the declared ones in order, otherwise the one of [`AgentDeclaration::of_program`].
    pub fn crew(&self) -> Vec<AgentDeclaration> {
        if self.agents.is_empty() { vec![AgentDeclaration::of_program()] } else { self.agents.clone() }
    }

    /// Returns the parts of a resource and their parts, in order of their names; empty for most resources.
    pub fn parts_of<'a>(&'a self, resource: &Symbol) -> Vec<&'a Symbol> {
        let mut parts: BTreeSet<&Symbol> = BTreeSet::new();
        let mut open = vec![resource.clone()];
        while let Some(whole) = open.pop() {
            let own = self.resources.iter().filter(|(_, each)| each.part_of.as_ref() == Some(&whole));
            let own: Vec<&Symbol> = own.map(|(name, _)| name).filter(|name| *name != resource).collect();
            open.extend(own.into_iter().filter(|name| parts.insert(name)).cloned());
        }
        parts.into_iter().collect()
    }

    /// Returns true if several agents are declared, so that messages of one may concern others.
    pub fn has_several_agents(&self) -> bool {
        self.agents.len() > 1
    }

    /// Returns the place as text, `file.pdl:14:3`, as in every message.
    pub fn describe_place(&self, place: Place) -> String {
        let name = usize::try_from(place.file).ok().and_then(|index| self.sources.get(index));
        match name {
            Some(source) => format!("{}:{}:{}", source.name, place.line, place.column),
            None => format!("{}:{}", place.line, place.column),
        }
    }
}

/// `(defun ..)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Function {
    /// The parameters.
    pub parameters: Parameters,
    /// The body.
    pub body: Vec<Expr>,
    /// True if it calls nothing that publishes, prints, assigns task variables or sends commands.
    pub pure: bool,
    /// Place in the source.
    pub place: Place,
}

/// A function of the host program that PDL may call:
/// `(declare-function (NAME parameter..) [:pure t|nil] [:command t|nil])`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HostDeclaration {
    /// Parameter names; a last `&rest` name takes all further arguments.
    pub parameters: Vec<Symbol>,
    /// True if the function is pure; only pure functions may occur in conditions.
    pub pure: bool,
    /// True if a call sends `(NAME argument..)` to the vehicle as a command instead of computing a value.
    pub command: bool,
    /// Place in the source.
    pub place: Place,
}

/// `(state-variable (ATTR ?object) :unit U :type T ..)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StateVariableDeclaration {
    /// Canonical name of the unit of bare numbers that are compared with the variable or published to it.
    pub unit: Option<Symbol>,
    /// The unit's dimension.
    pub dimension: Dimension,
    /// `real`, `integer`, `symbol`, `string`, `location`, `boolean`; `None` for any type.
    pub value_type: Option<Symbol>,
    /// `:lateness D`: greatest delay of a sample that is still inserted in order.
    pub lateness: Option<Value>,
    /// `:rate R`: samples per second to expect, for memory estimates.
    pub rate_per_s: Option<f64>,
    /// Place in the source.
    pub place: Place,
}

/// `(resource NAME [:capacity N | :depletable Q | :renewable Q] [:part-of RESOURCE])`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResourceDeclaration {
    /// Exclusive, shared or consumed.
    pub kind: ResourceKind,
    /// The resource of which this one is a part: a task that takes that resource takes this one, too.
    #[serde(default)]
    pub part_of: Option<Symbol>,
    /// Place in the source.
    pub place: Place,
}

/// Rule by which a resource is claimed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ResourceKind {
    /// One holder at a time (the default).
    Unitary,
    /// This number of units at a time.
    Capacity(u32),
    /// Reserved at engagement, consumed at the end.
    Depletable(Value),
    /// A depletable amount that `(replenish NAME ..)` restores, up to this amount.
    Renewable(Value),
}

/// Attribute of the state variable that holds the remaining amount of a renewable resource, `(resource-level fuel)`.
pub const RESOURCE_LEVEL: &str = "resource-level";

/// `(solver NAME (index PATTERN) ..)`: a planner's invocation pattern.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolverDeclaration {
    /// Name of the solver in the runtime's pool; `auto` lets the profile table choose.
    pub name: Symbol,
    /// Goals it can plan for.
    pub index: Pattern,
    /// Deliberation time; `None` for the runtime's default.
    pub budget: Option<Expr>,
    /// A goal pursued while the plan is late.
    pub meanwhile: Option<Template>,
    /// Place in the source.
    pub place: Place,
}

/// `(agent NAME ..)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AgentDeclaration {
    /// The agent's name.
    pub name: Symbol,
    /// The goal of its root task: `(do-domain)` if the declaration states none.
    pub initial_task: Value,
    /// Bundles that the agent uses; empty means all.
    pub bundles: Vec<Symbol>,
    /// Routers on which it publishes or to which it subscribes, in written order.
    pub routers: Vec<RouterUse>,
    /// Its workload, 1 to 9: the greater, the more importance counts in comparison with urgency.
    pub workload: f64,
    /// Its limits, if it lowers any.
    #[serde(default)]
    pub limits: Limits,
    /// Place in the source.
    pub place: Place,
}

/// The workload of an agent that names none.
pub const DEFAULT_WORKLOAD: f64 = 5.0;

/// The router of every agent whose declaration has no `:routers`.
pub const DEFAULT_ROUTER: &str = "default";

impl AgentDeclaration {
    /// Returns the agent of a program that declares none: it is called `agent` and pursues `(do-domain)`.
    pub fn of_program() -> AgentDeclaration {
        AgentDeclaration {
            name: Symbol::new("agent"),
            initial_task: Value::list([Value::symbol("do-domain")]),
            bundles: Vec::new(),
            routers: vec![RouterUse::everything(Symbol::new(DEFAULT_ROUTER), Place::default())],
            workload: DEFAULT_WORKLOAD,
            limits: Limits::default(),
            place: Place::default(),
        }
    }
}

/// Use of a router by an agent: `NAME`, or `(NAME [:publish TOPICS] [:subscribe TOPICS])`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RouterUse {
    /// The router.
    pub router: Symbol,
    /// Topics that the agent publishes on it.
    pub publish: Topics,
    /// Topics that the agent receives from it.
    pub subscribe: Topics,
    /// Place in the source.
    pub place: Place,
}

impl RouterUse {
    /// Returns the use of `router` for all topics, in both directions.
    pub fn everything(router: Symbol, place: Place) -> RouterUse {
        RouterUse { router, publish: Topics::All, subscribe: Topics::All, place }
    }
}

/// Messages and samples that a router carries, or that an agent publishes or receives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Topics {
    /// Everything.
    All,
    /// Messages that match one of these patterns, and samples of state variables whose form `(ATTRIBUTE OBJECT)` matches.
    Matching(Vec<Pattern>),
}

/// `(router NAME [:carries TOPICS])`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RouterDeclaration {
    /// Topics that it forwards.
    pub carries: Topics,
    /// Place in the source.
    pub place: Place,
}

/// `(defapplication "NAME" ..)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Application {
    /// The title.
    pub name: Arc<str>,
    /// `native-sim`, `realtime` or `foreign-sim`.
    pub kind: Symbol,
    /// Every other keyword in written order, without the colon, with its raw datum
    /// (`:vehicle`, `:targets`, `:airspace`, `:weather`, `:libraries`, `:files`, `:init`, ..).
    pub options: Vec<(Symbol, Value)>,
    /// Place of every option, including those not in `options`.
    #[serde(default)]
    pub option_places: Vec<(Symbol, Place)>,
    /// Place in the source.
    pub place: Place,
}

impl Application {
    /// Returns the datum of option `name` (folded, without the colon), if given.
    pub fn option(&self, name: &str) -> Option<&Value> {
        self.options.iter().find(|(key, _)| key.is(name)).map(|(_, value)| value)
    }

    /// Returns the place of option `name`, otherwise that of the application.
    pub fn option_place(&self, name: &str) -> Place {
        self.option_places.iter().find(|(key, _)| key.is(name)).map_or(self.place, |(_, place)| *place)
    }
}
