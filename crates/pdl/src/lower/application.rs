//! Applications and agents (`pdl.md` section 8).

use super::clauses::{groups, values_of};
use super::{Goal, Lowering};
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::read::{Datum, DatumKind};
use crate::suggest::renames;
use apex_model::expression::Template;
use apex_model::library::{AgentDeclaration, Application, Library};
use apex_model::symbol::Symbol;
use apex_model::value::Value;

const KINDS: &[&str] = &["native-sim", "realtime", "foreign-sim"];

impl Lowering {
    /// Lowers `(defapplication "NAME" :type T :agents (..) ..)`.
    pub(crate) fn application(&mut self, form: &Datum, library: &mut Library) -> Option<()> {
        const SHAPE: &str = "(defapplication \"NAME\" [:type T] [:libraries (..)] [:agents (..)] ..)";
        let (before, options) = groups(form.tail());
        let name = match before {
            [Datum { kind: DatumKind::Text(name), .. }] => name.clone(),
            [Datum { kind: DatumKind::Symbol(name), .. }] => name.printed().into(),
            _ => return self.missing_part(form.span, "this application has no name", SHAPE),
        };
        if let Some(first) = &library.application {
            let message = format!("a second application; the first is \"{}\"", first.name);
            let diagnostic = Diagnostic::error(codes::DUPLICATE_DEFINITION, form.span, message)
                .help("load one application at a time");
            return self.refuse(diagnostic);
        }
        let mut kept = Vec::new();
        let mut kind = Symbol::new("native-sim");
        let mut complete = true;
        for (index, group) in options.iter().enumerate() {
            if let Some(earlier) = options.iter().take(index).find(|earlier| earlier.name == group.name) {
                self.report_twice(&format!("option `:{}`", group.name), earlier.span, group.span);
                complete = false;
                continue;
            }
            match group.name {
                "type" => match self.application_kind(group.values, form) {
                    Some(found) => kind = found,
                    None => complete = false,
                },
                "agents" => complete &= self.agents(group.values, library).is_some(),
                other => {
                    let value = match group.values {
                        [] => Value::nil(),
                        [one] => one.to_value(),
                        several => Value::list(several.iter().map(Datum::to_value)),
                    };
                    kept.push((Symbol::new(other), value));
                }
            }
        }
        complete.then_some(())?;
        library.application = Some(Application { name, kind, options: kept, place: form.span.place() });
        Some(())
    }

    fn application_kind(&mut self, values: &[Datum], form: &Datum) -> Option<Symbol> {
        let datum = self.only(":type", values, form.span)?;
        match datum.as_symbol().map(|name| name.folded().trim_start_matches(':')) {
            Some(name) if KINDS.contains(&name) => Some(Symbol::new(name)),
            other => {
                let diagnostic = Diagnostic::error(codes::UNKNOWN_OPTION, datum.span, "this is no type of application");
                let fixes = renames(datum.span, other.unwrap_or_default(), KINDS.iter().copied());
                self.refuse(diagnostic.fixes_or_help(fixes, || format!("types are {}", KINDS.join(" "))))
            }
        }
    }

    /// One agent or a list of agents.
    fn agents(&mut self, values: &[Datum], library: &mut Library) -> Option<()> {
        for value in values {
            let forms = match value.as_list() {
                Some(forms) if Lowering::is_nested(value) => forms,
                _ => std::slice::from_ref(value),
            };
            for form in forms {
                if form.head_name() != "agent" {
                    return self.missing_part(form.span, "this is no agent", "(agent NAME [:initial-task GOAL] ..)");
                }
                let agent = self.agent(form, library)?;
                library.agents.push(agent);
            }
        }
        Some(())
    }

    /// `(agent NAME [:initial-task GOAL] [:use-bundles (..)] [:routers (..)])`
    pub(crate) fn agent(&mut self, form: &Datum, library: &Library) -> Option<AgentDeclaration> {
        let (before, options) = groups(form.tail());
        let [named @ Datum { kind: DatumKind::Symbol(name), span }] = before else {
            return self.missing_part(form.span, "this agent has no name", "(agent NAME [:initial-task GOAL] ..)");
        };
        if library.agents.iter().any(|agent| agent.name == *name) {
            let message = format!("agent `{name}` is defined twice");
            return self
                .refuse(Diagnostic::error(codes::DUPLICATE_DEFINITION, *span, message).help("rename one of them"));
        }
        const KNOWN: &[&str] = &["initial-task", "use-bundles", "routers"];
        self.check_groups(&options, KNOWN, "`agent`")?;
        let task = self.optional(&options, "initial-task", |lowering, datum| lowering.initial_task(datum))?;
        let (initial_task, source) = match task {
            Some(source) => (source.to_value(), source),
            None => (Value::list([Value::symbol("do-domain")]), named.clone()),
        };
        self.goals.push(Goal { template: Template::Constant(initial_task.clone()), source });
        Some(AgentDeclaration {
            name: name.clone(),
            initial_task,
            bundles: names_in(values_of(&options, "use-bundles")),
            routers: names_in(values_of(&options, "routers")),
            place: form.span.place(),
        })
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
}

/// Names in a list or in a row, without colons.
fn names_in(values: &[Datum]) -> Vec<Symbol> {
    let mut names = Vec::new();
    for value in values {
        match &value.kind {
            DatumKind::Symbol(name) => names.push(Symbol::new(name.printed().trim_start_matches(':'))),
            DatumKind::List(items) => names.extend(names_in(items)),
            DatumKind::Text(text) => names.push(Symbol::new(text)),
            _ => {}
        }
    }
    names
}
