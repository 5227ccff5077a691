//! Names that PDL text may use: functions, indexicals, constants, state variables, resources.

use crate::diagnostic::Span;
use apex_model::builtins::{self, BUILT_INS, INDEXICALS};
use apex_model::library::{ResourceKind, StateVariableDeclaration};
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::collections::BTreeMap;

/// Signature of a function, for checks of its calls.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Callable {
    pub(crate) min: usize,
    pub(crate) max: Option<usize>,
    pub(crate) pure: bool,
    /// Place of the definition; `None` for built-in and host functions.
    pub(crate) place: Option<Span>,
}

/// Definitions of all files of one library.
#[derive(Default)]
pub(crate) struct Names {
    /// Functions of the library and of the host program.
    pub(crate) functions: BTreeMap<Symbol, Callable>,
    /// Indexicals without plus signs.
    pub(crate) indexicals: BTreeMap<Symbol, Span>,
    /// Constants by name as written, plus signs included.
    pub(crate) constants: BTreeMap<Symbol, (Value, Span)>,
    /// Constants that are computed, by name as written, plus signs included.
    pub(crate) computed: BTreeMap<Symbol, Span>,
    /// State variables by attribute.
    pub(crate) state_variables: BTreeMap<Symbol, (StateVariableDeclaration, Span)>,
    /// Resources by name.
    pub(crate) resources: BTreeMap<Symbol, (ResourceKind, Span)>,
}

impl Names {
    /// Returns the function called `name`, under the name to store.
    pub(crate) fn function(&self, name: &Symbol) -> Option<(Symbol, Callable)> {
        if let Some(found) = builtins::built_in(name.folded()) {
            let callable =
                Callable { min: found.arguments_min, max: found.arguments_max, pure: found.pure, place: None };
            let canonical = if name.is(found.name) { name.clone() } else { Symbol::new(found.name) };
            return Some((canonical, callable));
        }
        self.functions.get(name).map(|callable| (name.clone(), *callable))
    }

    /// Returns true if `name` is the name of a function or special form.
    pub(crate) fn is_operator(&self, name: &Symbol) -> bool {
        builtins::SPECIAL_FORMS.binary_search(&name.folded()).is_ok()
            || builtins::built_in(name.folded()).is_some()
            || self.functions.contains_key(name)
    }

    /// Returns true if `+name+` is a constant rather than an indexical.
    pub(crate) fn computed_or_literal(&self, name: &Symbol) -> bool {
        let written = Symbol::new(&format!("+{name}+"));
        self.constants.contains_key(&written) || self.computed.contains_key(&written)
    }

    /// Returns true if `name` is an indexical that every agent has, or one of the library.
    pub(crate) fn is_indexical(&self, name: &Symbol) -> bool {
        INDEXICALS.binary_search(&name.folded()).is_ok() || self.indexicals.contains_key(name)
    }

    /// Returns all names that may head a call, for suggestions.
    pub(crate) fn operators(&self) -> impl Iterator<Item = &str> {
        BUILT_INS
            .iter()
            .map(|each| each.name)
            .chain(builtins::ALIASES.iter().map(|(alias, _)| *alias))
            .chain(builtins::SPECIAL_FORMS.iter().copied())
            .chain(self.functions.keys().map(Symbol::printed))
    }

    /// Returns all indexicals, for suggestions.
    pub(crate) fn indexical_names(&self) -> impl Iterator<Item = &str> {
        INDEXICALS.iter().copied().chain(self.indexicals.keys().map(Symbol::printed))
    }
}
