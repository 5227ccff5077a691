//! Index of the state variables of a library: the rules for recording samples of an attribute, and the derivations that read them. Built
//! once, because a flight records millions of samples; derived from the library alone.

use apex_model::derivation::Derivation;
use apex_model::library::{Library, StateVariableDeclaration};
use apex_model::quantity::{Unit, unit_named};
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use rustc_hash::FxBuildHasher;
use std::collections::HashMap;

/// A derivation and one of its inputs, by position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct InputReader {
    /// Position among [`VariableIndex::ranked`].
    pub(crate) derivation: usize,
    /// Position among the inputs of the derivation.
    pub(crate) input: usize,
}

/// Rules for the samples of an attribute.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct AttributeRules {
    /// Unit of a bare number.
    pub(crate) unit: Option<&'static Unit>,
    /// Lateness as declared.
    pub(crate) lateness: Option<Value>,
    /// Derivations that read the attribute, in order of rank, each with the input.
    pub(crate) readers: Vec<InputReader>,
}

/// A derivation in order of rank.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RankedDerivation {
    /// Attribute of the derived variable.
    pub(crate) attribute: Symbol,
    /// True if the variable holds numbers: `nil` then means that the value is unknown.
    pub(crate) holds_numbers: bool,
}

/// Rules by attribute, and derivations by rank.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VariableIndex {
    attributes: HashMap<Symbol, AttributeRules, FxBuildHasher>,
    ranked: Vec<RankedDerivation>,
}

impl VariableIndex {
    /// Returns the index of `library`.
    pub(crate) fn new(library: &Library) -> VariableIndex {
        let mut index = VariableIndex::default();
        for (attribute, declared) in &library.state_variables {
            let unit = declared.unit.as_ref().and_then(|unit| unit_named(unit.printed()));
            let rules = AttributeRules { unit, lateness: declared.lateness.clone(), readers: Vec::new() };
            index.attributes.insert(attribute.clone(), rules);
        }
        let mut ranked: Vec<(&Symbol, &Derivation)> = library.derivations.iter().collect();
        ranked.sort_by_key(|(_, derivation)| derivation.rank);
        for (number, (attribute, derivation)) in ranked.into_iter().enumerate() {
            for (input, read) in derivation.inputs.iter().enumerate() {
                let rules = index.attributes.entry(read.attribute.clone()).or_default();
                rules.readers.push(InputReader { derivation: number, input });
            }
            let declared = library.state_variables.get(attribute);
            let holds_numbers = declared.is_some_and(holds_numbers);
            index.ranked.push(RankedDerivation { attribute: attribute.clone(), holds_numbers });
        }
        index
    }

    /// Returns the rules of an attribute; `None` if it is neither declared nor read by a derivation.
    pub(crate) fn rules(&self, attribute: &Symbol) -> Option<&AttributeRules> {
        self.attributes.get(attribute)
    }

    /// Returns the derivations that read the attribute, in order of rank.
    pub(crate) fn readers(&self, attribute: &Symbol) -> &[InputReader] {
        if self.ranked.is_empty() { &[] } else { self.rules(attribute).map_or(&[], |rules| &rules.readers) }
    }

    /// Returns all derivations in order of rank.
    pub(crate) fn ranked(&self) -> &[RankedDerivation] {
        &self.ranked
    }
}

fn holds_numbers(declared: &StateVariableDeclaration) -> bool {
    let is_number = |word: &Symbol| ["real", "integer", "number"].contains(&word.folded());
    declared.unit.is_some() || declared.value_type.as_ref().is_some_and(is_number)
}
