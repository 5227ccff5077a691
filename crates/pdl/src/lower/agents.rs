//! Agents, routers and the references between them by name (`pdl.md`, Applications).

use super::clauses::{groups, values_of};
use super::{Goal, Lowering, Scope};
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::read::{Datum, DatumKind};
use crate::suggest::renames_marked;
use crate::vocabulary::AGENT_OPTIONS;
use apex_model::expression::Template;
use apex_model::library::{
    AgentDeclaration, DEFAULT_ROUTER, DEFAULT_WORKLOAD, Library, RouterDeclaration, RouterUse, Topics,
};
use apex_model::quantity::Dimension;
use apex_model::symbol::Symbol;
use apex_model::value::Value;

const AGENT_SHAPE: &str =
    "(agent NAME [:initial-task GOAL] [:use-bundles (..)] [:routers (..)] [:workload 1..9] [:limits (..)])";
const ROUTER_SHAPE: &str = "(router NAME [:carries (TOPIC..)])";

/// A name that another form must define.
pub(crate) struct NameUse {
    kind: NameKind,
    name: Symbol,
    span: Span,
    /// True if the name is written with a colon.
    marked: bool,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum NameKind {
    Agent,
    Router,
    Bundle,
}

impl Lowering {
    /// Records that `datum`, if it is a constant name, must name something of this kind.
    pub(crate) fn use_name(&mut self, kind: NameKind, datum: &Datum) {
        let inner = match &datum.kind {
            DatumKind::Quote(inner) => inner,
            _ => datum,
        };
        if let Some(name) = inner.as_symbol().filter(|name| !self.scope.is_local(name)) {
            self.named.push(NameUse { kind, name: name.clone(), span: inner.span, marked: false });
        }
    }

    /// Lowers `(agent NAME [:initial-task GOAL] [:use-bundles (..)] [:routers (..)] [:workload 1..9] [:limits (..)])`.
    pub(crate) fn agent(&mut self, form: &Datum, library: &Library) -> Option<AgentDeclaration> {
        if self.report_missing_colon(form.tail(), &["initial-task", "use-bundles", "routers"], "an agent") {
            return None;
        }
        let (before, options) = groups(form.tail());
        let [named @ Datum { kind: DatumKind::Symbol(name), span }] = before else {
            return self.missing_part(form.span, "this agent has no name", AGENT_SHAPE);
        };
        if library.agents.iter().any(|agent| agent.name == *name) {
            let message = format!("agent `{name}` is defined twice");
            return self
                .refuse(Diagnostic::error(codes::DUPLICATE_DEFINITION, *span, message).help("rename one of them"));
        }
        self.check_groups(&options, AGENT_OPTIONS, "`agent`")?;
        let task = self.optional(&options, "initial-task", |lowering, datum| lowering.initial_task(datum))?;
        let (initial_task, source) = match task {
            Some(source) => (source.to_value(), source),
            None => (Value::list([Value::symbol("do-domain")]), named.clone()),
        };
        self.goals.push(Goal { template: Template::Constant(initial_task.clone()), span: source.span });
        let mut bundles = self.bundles(values_of(&options, "use-bundles"));
        if bundles.iter().any(|bundle| bundle.is("all")) {
            bundles.clear();
        }
        let place = form.span.place();
        let routers = match options.iter().find(|group| group.name == "routers") {
            Some(group) => self.router_uses(group.values)?,
            None => vec![RouterUse::everything(Symbol::new(DEFAULT_ROUTER), place)],
        };
        let workload = self.optional(&options, "workload", |lowering, datum| lowering.workload(datum))?;
        let workload = workload.unwrap_or(DEFAULT_WORKLOAD);
        let limits =
            self.optional(&options, "limits", |lowering, datum| lowering.agent_limits(datum))?.unwrap_or_default();
        Some(AgentDeclaration { name: name.clone(), initial_task, bundles, routers, workload, limits, place })
    }

    fn workload(&mut self, datum: &Datum) -> Option<f64> {
        let number = datum.to_value().as_number().filter(|(_, dimension)| *dimension == Dimension::NONE);
        match number {
            Some((workload, _)) if (1.0..=9.0).contains(&workload) => Some(workload),
            _ => {
                let message = "a workload is a number from 1 to 9";
                let diagnostic = Diagnostic::error(codes::MALFORMED, datum.span, message);
                self.refuse(diagnostic.help("1: urgency decides; 9: importance decides; without `:workload` it is 5"))
            }
        }
    }

    fn initial_task(&mut self, datum: &Datum) -> Option<Datum> {
        let inner = match &datum.kind {
            DatumKind::Quote(inner) => inner,
            _ => datum,
        };
        if inner.head().is_none() || inner.has_holes() {
            let diagnostic =
                Diagnostic::error(codes::MALFORMED, datum.span, "an initial task is a goal without variables")
                    .help("for example `:initial-task (fly mission)`");
            return self.refuse(diagnostic);
        }
        Some(inner.clone())
    }

    /// Returns the names in a list or in a row, without colons.
    fn bundles(&mut self, values: &[Datum]) -> Vec<Symbol> {
        let mut names = Vec::new();
        for value in values {
            let name = match &value.kind {
                DatumKind::Symbol(name) => Symbol::new(name.printed().trim_start_matches(':')),
                DatumKind::Text(text) => Symbol::new(text),
                DatumKind::List(items) => {
                    names.extend(self.bundles(items));
                    continue;
                }
                _ => {
                    let diagnostic = Diagnostic::error(codes::MALFORMED, value.span, "this is not a name of a bundle");
                    self.report(diagnostic.help("for example `:use-bundles (:default :camera)`"));
                    continue;
                }
            };
            self.named.push(NameUse {
                kind: NameKind::Bundle,
                name: name.clone(),
                span: value.span,
                marked: value.keyword().is_some(),
            });
            names.push(name);
        }
        names
    }

    /// Lowers `(NAME | (NAME [:publish TOPICS] [:subscribe TOPICS]) ..)`.
    fn router_uses(&mut self, values: &[Datum]) -> Option<Vec<RouterUse>> {
        let items = match values {
            [only] if only.as_list().is_some() && only.tail().first().and_then(Datum::keyword).is_none() => {
                only.as_list().unwrap_or_default()
            }
            several => several,
        };
        self.all(items, |lowering, item| {
            let place = item.span.place();
            if let Some(name) = item.as_symbol() {
                let router = Symbol::new(name.printed().trim_start_matches(':'));
                lowering.named.push(NameUse {
                    kind: NameKind::Router,
                    name: router.clone(),
                    span: item.span,
                    marked: item.keyword().is_some(),
                });
                return Some(RouterUse::everything(router, place));
            }
            let shape = "NAME or (NAME [:publish (TOPIC..)] [:subscribe (TOPIC..)])";
            let Some(router) = item.head().cloned() else {
                return lowering.missing_part(item.span, "this is not a use of a router", shape);
            };
            let (before, options) = groups(item.tail());
            if !before.is_empty() || options.is_empty() {
                return lowering.missing_part(item.span, "this use of a router has the wrong parts", shape);
            }
            lowering.check_groups(&options, &["publish", "subscribe"], "a use of a router")?;
            lowering.named.push(NameUse {
                kind: NameKind::Router,
                name: router.clone(),
                span: item.head_span(),
                marked: false,
            });
            let nothing = Topics::Matching(Vec::new());
            let publish = lowering.optional(&options, "publish", Lowering::topics)?.unwrap_or(nothing.clone());
            let subscribe = lowering.optional(&options, "subscribe", Lowering::topics)?.unwrap_or(nothing);
            Some(RouterUse { router, publish, subscribe, place })
        })
    }

    /// Lowers `(router NAME [:carries TOPICS])`.
    pub(crate) fn router(&mut self, form: &Datum, library: &mut Library) -> Option<()> {
        let (before, options) = groups(form.tail());
        let [Datum { kind: DatumKind::Symbol(name), span }] = before else {
            return self.missing_part(form.span, "this router has no name", ROUTER_SHAPE);
        };
        if library.routers.contains_key(name) {
            let message = format!("router `{name}` is defined twice");
            return self
                .refuse(Diagnostic::error(codes::DUPLICATE_DEFINITION, *span, message).help("rename one of them"));
        }
        self.check_groups(&options, &["carries"], "`router`")?;
        let carries = self.optional(&options, "carries", Lowering::topics)?.unwrap_or(Topics::All);
        library.routers.insert(name.clone(), RouterDeclaration { carries, place: form.span.place() });
        Some(())
    }

    /// Lowers `all`, or a list of patterns; a bare name matches everything that begins with it.
    fn topics(&mut self, datum: &Datum) -> Option<Topics> {
        if datum.is("all") || datum.is(":all") || datum.is("t") {
            return Some(Topics::All);
        }
        let Some(items) = datum.as_list() else {
            return self.missing_part(
                datum.span,
                "these are not topics",
                "`all` or (TOPIC..), a topic as `(altitude ?)`",
            );
        };
        self.scope = Scope::of_tasks();
        let patterns = self.all(items, |lowering, item| match item.as_symbol() {
            Some(_) => lowering.pattern(item).map(|head| {
                let rest = apex_model::pattern::Pattern::Segment { variable: None, minimum: 0, maximum: None };
                apex_model::pattern::Pattern::List(vec![head, rest])
            }),
            None => lowering.pattern(item),
        });
        self.scope = Scope::default();
        patterns.map(Topics::Matching)
    }

    /// Reports names of agents, routers and bundles that nothing defines. Names of agents are checked only if some are declared, because
    /// a library does not know the agents that will use it.
    pub(crate) fn report_unknown_company(&mut self, library: &Library) {
        let bundles: Vec<&str> = self.bundle_names.iter().map(|name| name.printed()).collect();
        let mut found = Vec::new();
        for NameUse { kind, name, span, marked } in &self.named {
            let (code, what, known): (_, _, Vec<&str>) = match kind {
                NameKind::Agent => {
                    (codes::UNKNOWN_AGENT, "agent", library.agents.iter().map(|each| each.name.printed()).collect())
                }
                NameKind::Router => {
                    (codes::UNKNOWN_ROUTER, "router", library.routers.keys().map(Symbol::printed).collect())
                }
                NameKind::Bundle => (codes::UNKNOWN_BUNDLE, "bundle", bundles.clone()),
            };
            let always = match kind {
                NameKind::Agent => known.is_empty(),
                NameKind::Router => name.is(DEFAULT_ROUTER),
                NameKind::Bundle => name.is("default") || name.is("all"),
            };
            if always || known.iter().any(|each| *name == Symbol::new(each)) {
                continue;
            }
            let message = format!("no {what} is called `{name}`");
            let diagnostic = Diagnostic::new(self.undefined(), code, *span, message);
            let list = || match known.as_slice() {
                [] => "there is none".to_string(),
                some => format!("there are {}", some.join(", ")),
            };
            let mark = |name: &str| if *marked { format!(":{name}") } else { name.to_string() };
            let fixes = renames_marked(*span, name.printed(), known.iter().copied(), mark);
            found.push(diagnostic.fixes_or_help(fixes, list));
        }
        found.into_iter().for_each(|diagnostic| self.report(diagnostic));
    }
}
