//! Inference of the types of goal variables from their uses: as arguments of declared commands and messages, as durations, and
//! as arguments of goals whose variables have a type already.

use super::calls::{Call, Calls, Receiver};
use crate::analysis::kinds::Kind;
use crate::analysis::methods::{Method, Methods};
use crate::analysis::walk;
use crate::matching::View;
use apex_model::expression::{Expr, ExprKind, Template};
use apex_model::interface::{ArgumentType, NameKind};
use apex_model::library::Library;
use apex_model::pattern::Pattern;
use apex_model::procedure::{Activity, BuiltInActivity};
use apex_model::quantity::Dimension;
use apex_model::symbol::Symbol;
use std::collections::BTreeMap;

/// Maximum number of passes. Each pass carries types from a goal to the goals that call it; longer chains stay untyped.
const ROUNDS_MAX: usize = 32;

/// Type of a variable, or the fact that its uses contradict each other.
#[derive(Clone, PartialEq)]
enum TypeUse {
    Type(ArgumentType),
    Contradictory,
}

/// The types of the variables of indexes.
pub(super) struct Types<'l> {
    found: BTreeMap<(Method, &'l Symbol), TypeUse>,
    /// Gives the index of each method.
    library: &'l Library,
}

impl<'l> Types<'l> {
    pub(super) fn new(library: &'l Library, methods: &Methods<'l>, calls: &Calls<'l>) -> Types<'l> {
        let mut types = Types { found: BTreeMap::new(), library };
        types.durations();
        types.objects();
        for _ in 0..ROUNDS_MAX {
            let mut changed = false;
            for call in &calls.all {
                let Some(owner) = call.owner else { continue };
                for (number, item) in call.items.iter().enumerate().skip(1) {
                    if let Some(variable) = variable(*item)
                        && has_variable(methods.index(owner), variable)
                        && let Some(wanted) = types.wanted(call, number)
                    {
                        changed |= types.note(owner, variable, wanted);
                    }
                }
            }
            if !changed {
                break;
            }
        }
        types
    }

    /// Types the variables of `(duration ?d)` and of the time limit of questions as durations.
    fn durations(&mut self) {
        let time = || ArgumentType::Quantity(Dimension::TIME);
        for (number, primitive) in self.library.primitives.iter().enumerate() {
            if let Some(variable) = primitive.duration.as_ref().and_then(of_expression)
                && has_variable(Some(&primitive.index), variable)
            {
                self.note(Method::Primitive(number), variable, time());
            }
        }
        for (number, procedure) in self.library.procedures.iter().enumerate() {
            for step in &procedure.steps {
                if let Activity::BuiltIn(BuiltInActivity::AskOperator, arguments) = &step.activity
                    && let Some(variable) = arguments.get(2).and_then(of_expression)
                    && has_variable(Some(&procedure.index), variable)
                {
                    self.note(Method::Procedure(number), variable, time());
                }
            }
        }
    }

    /// Types the objects of state variables: `?modem` is a radio if a condition uses `(signal-level ?modem)`.
    fn objects(&mut self) {
        let library = self.library;
        for (number, procedure) in library.procedures.iter().enumerate() {
            let mut uses: Vec<(NameKind, &'l Symbol)> = Vec::new();
            walk::conditions_of(procedure, &mut |condition| {
                let Some(variable) = walk::variable_of(condition) else { return };
                if let (Some(kind), Pattern::Variable(name) | Pattern::BoundVariable(name)) =
                    (library.objects.get(&variable.attribute), &variable.object)
                {
                    uses.push((*kind, name));
                }
            });
            uses.retain(|(_, name)| has_variable(Some(&procedure.index), name));
            for (kind, name) in uses {
                self.note(Method::Procedure(number), name, ArgumentType::Named(kind));
            }
        }
    }

    /// Records a use; returns true if it adds information.
    fn note(&mut self, owner: Method, variable: &'l Symbol, wanted: ArgumentType) -> bool {
        match self.found.get(&(owner, variable)) {
            Some(TypeUse::Contradictory) => false,
            Some(TypeUse::Type(known)) if *known == wanted => false,
            Some(TypeUse::Type(_)) => {
                self.found.insert((owner, variable), TypeUse::Contradictory);
                true
            }
            None => {
                self.found.insert((owner, variable), TypeUse::Type(wanted));
                true
            }
        }
    }

    /// Returns the type that argument `number` of the call must have; `None` if it is unknown.
    pub(super) fn wanted(&self, call: &Call<'l>, number: usize) -> Option<ArgumentType> {
        match &call.receiver {
            Receiver::Message => None,
            Receiver::Declared(declaration) => {
                let before = number.checked_sub(1)?;
                let keyword =
                    |at: usize| call.items.get(at)?.value()?.as_symbol().filter(|name| name.folded().starts_with(':'));
                // Options follow the parameters: from the first keyword on, a value belongs to the keyword before it.
                let in_options = (1..=number).any(|at| keyword(at).is_some());
                let parameter = match in_options {
                    true => keyword(before)
                        .and_then(|name| declaration.options.iter().find(|option| option.name == *name))?,
                    false => declaration.parameters.get(before)?,
                };
                (parameter.argument_type != ArgumentType::Any).then(|| parameter.argument_type.clone())
            }
            Receiver::Goal(serving) => {
                let (first, others) = serving.split_first()?;
                let wanted = self.of_index(*first, number)?;
                others.iter().all(|method| self.of_index(*method, number).as_ref() == Some(&wanted)).then_some(wanted)
            }
        }
    }

    /// Returns the variables of the method's index whose dimension is known.
    pub(super) fn dimensions(&self, method: Method) -> BTreeMap<&'l Symbol, Kind> {
        let of_method = self.found.iter().filter(|((owner, _), _)| *owner == method);
        of_method
            .filter_map(|((_, name), found)| match found {
                TypeUse::Type(ArgumentType::Quantity(dimension)) => Some((*name, Kind::Number(*dimension))),
                _ => None,
            })
            .collect()
    }

    /// Returns the type of the variable at position `number` of a method's index.
    fn of_index(&self, method: Method, number: usize) -> Option<ArgumentType> {
        let index = match method {
            Method::Procedure(procedure) => &self.library.procedures.get(procedure)?.index,
            Method::Primitive(primitive) => &self.library.primitives.get(primitive)?.index,
            Method::Solver(_) => return None,
        };
        let Pattern::List(parts) = index else { return None };
        if parts.iter().any(|part| matches!(part, Pattern::Segment { .. } | Pattern::Guard(_))) {
            return None;
        }
        let (Pattern::Variable(name) | Pattern::Is { variable: name, .. }) = parts.get(number)? else { return None };
        match self.found.get(&(method, name))? {
            TypeUse::Type(found) => Some(found.clone()),
            TypeUse::Contradictory => None,
        }
    }
}

/// Returns the variable of an argument that is nothing but a variable.
fn variable(item: View<'_>) -> Option<&Symbol> {
    match item {
        View::Template(Template::Hole(expr)) => of_expression(expr),
        _ => None,
    }
}

fn of_expression(expr: &Expr) -> Option<&Symbol> {
    match &expr.kind {
        ExprKind::Variable { name, .. } => Some(name),
        _ => None,
    }
}

fn has_variable(index: Option<&Pattern>, variable: &Symbol) -> bool {
    let Some(Pattern::List(parts)) = index else { return false };
    parts.iter().any(|part| match part {
        Pattern::Variable(name) | Pattern::Is { variable: name, .. } => name == variable,
        _ => false,
    })
}
