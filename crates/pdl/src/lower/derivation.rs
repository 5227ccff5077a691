//! Derived state variables: `(state-variable (ATTR ?object) .. :derived EXPR [:join J])`.
//!
//! State variables in the expression become inputs: each is replaced by a variable, and the rest is lowered as any pure
//! expression is.

use super::clauses::groups;
use super::{Lowering, Scope};
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::read::{Datum, DatumKind};
use apex_model::derivation::{Derivation, DerivationInput, Join, Reading};
use apex_model::library::Library;
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use apex_model::value::Value;
use std::collections::BTreeMap;

const JOINS: &str = "`:join (:hold 1s)`: the latest values, at most 1 s old; `:join :hold`: the latest values, however old; `:join (:interpolate 1s)`: on the line between samples at most 1 s apart";

impl Lowering {
    /// Lowers the derivations of all files; every declaration has been collected.
    pub(crate) fn derivations<'d>(&mut self, forms: impl Iterator<Item = &'d Datum>, library: &mut Library) {
        let mut spans = BTreeMap::new();
        for form in forms.filter(|form| form.head_name() == "state-variable") {
            let (before, options) = groups(form.tail());
            let ([variable], Some(group)) = (before, options.iter().find(|group| group.name == "derived")) else {
                continue;
            };
            let join = options.iter().find(|group| group.name == "join");
            let (Some(attribute), Some(value)) = (variable.head(), self.only(":derived", group.values, group.span))
            else {
                continue;
            };
            let join = match join.map(|join| self.only(":join", join.values, join.span).and_then(|one| self.join(one)))
            {
                None => None,
                Some(None) => continue,
                Some(read) => read,
            };
            if let Some(derivation) = self.derivation(variable, value, join) {
                spans.insert(attribute.clone(), value.span);
                library.derivations.insert(attribute.clone(), derivation);
            }
        }
        self.rank_derivations(&spans, library);
        inherit_lateness(library);
    }

    fn join(&mut self, datum: &Datum) -> Option<Join> {
        let limit = |lowering: &mut Lowering, datum: &Datum| {
            lowering.literal_duration(datum).filter(|limit| {
                let positive = *limit > Duration::ZERO;
                if !positive {
                    let message = format!("the limit of `:join` is {limit}, expected a duration above zero");
                    let help = "write a duration above zero: `:join (:hold 1s)`";
                    lowering.report(Diagnostic::error(codes::DERIVATION, datum.span, message).help(help));
                }
                positive
            })
        };
        match (datum.keyword(), datum.as_list()) {
            (Some("hold"), _) => Some(Join::Hold(None)),
            (_, Some([word])) if word.is(":hold") => Some(Join::Hold(None)),
            (_, Some([word, most])) if word.is(":hold") => Some(Join::Hold(Some(limit(self, most)?))),
            (_, Some([word, most])) if word.is(":interpolate") => Some(Join::Interpolate(limit(self, most)?)),
            _ => self.refuse(Diagnostic::error(codes::DERIVATION, datum.span, "this is not a join").help(JOINS)),
        }
    }

    fn derivation(&mut self, variable: &Datum, value: &Datum, join: Option<Join>) -> Option<Derivation> {
        let Some([_, Datum { kind: DatumKind::Variable(object), .. }]) = variable.as_list() else {
            let diagnostic =
                Diagnostic::error(codes::DERIVATION, variable.span, "a derived state variable has one object variable")
                    .help("its shape is `(state-variable (ATTRIBUTE ?object) :derived EXPRESSION)`");
            return self.refuse(diagnostic);
        };
        let mut inputs = Inputs { object: object.clone(), found: Vec::new() };
        let replaced = self.with_inputs(value, &mut inputs)?;
        let inputs = inputs.found;
        if !inputs.iter().any(|input| matches!(input.object, Pattern::Variable(_))) {
            let message = format!("the expression reads no state variable of `?{object}`");
            let diagnostic = Diagnostic::error(codes::DERIVATION, value.span, message)
                .reason("a sample of one of them says for which object a value is computed")
                .help(format!("name one, for example `(abs (- (desired-roll ?{object}) (roll ?{object})))`"));
            return self.refuse(diagnostic);
        }
        let several = |input: &DerivationInput| {
            inputs.first().is_some_and(|first| (&first.attribute, &first.object) != (&input.attribute, &input.object))
        };
        if join.is_none() && inputs.iter().any(several) {
            let diagnostic = Diagnostic::error(
                codes::DERIVATION,
                value.span,
                "this reads several state variables and has no `:join`",
            )
            .reason("their samples come at different instants: how old may the value of one be when another comes?")
            .help(format!("add one of {JOINS}"));
            return self.refuse(diagnostic);
        }
        self.scope = Scope::of_tasks();
        let lowered = self.pure_expression(&replaced, "a derived state variable");
        self.scope = Scope::default();
        let (object, join) = (object.clone(), join.unwrap_or(Join::Hold(None)));
        Some(Derivation { object, inputs, value: lowered?, join, rank: 0, place: value.span.place() })
    }

    /// Returns `datum` with a variable in the place of each state variable.
    fn with_inputs(&mut self, datum: &Datum, inputs: &mut Inputs) -> Option<Datum> {
        let Some(items) = datum.as_list() else {
            return match &datum.kind {
                DatumKind::Variable(name) if *name != inputs.object => {
                    let message = format!("nothing binds `?{name}`");
                    let help = format!("the object is `?{}`", inputs.object);
                    self.refuse(Diagnostic::error(codes::UNBOUND_VARIABLE, datum.span, message).help(help))
                }
                _ => Some(datum.clone()),
            };
        };
        let reading = match datum.head_name() {
            "value-of" => Some(Reading::Value),
            "previous" => Some(Reading::Previous),
            "rate-of" => Some(Reading::Rate),
            "changed" => Some(Reading::Changed),
            _ => None,
        };
        if let (Some(reading), [_, variable]) = (reading, items) {
            return self.input(variable, reading, datum.span, inputs);
        }
        if let Some(reading) = reading {
            let message = format!("`{}` takes one state variable", datum.head_name());
            let help =
                format!("for example `({} (altitude ?{}))`; {}", datum.head_name(), inputs.object, meaning(reading));
            return self.refuse(Diagnostic::error(codes::DERIVATION, datum.span, message).help(help));
        }
        if self.is_state_variable(items) {
            return self.input(datum, Reading::Value, datum.span, inputs);
        }
        let is_let = ["let", "let*"].contains(&datum.head_name());
        let mut replaced = Vec::new();
        for (index, item) in items.iter().enumerate() {
            replaced.push(match item.as_list() {
                Some(bindings) if is_let && index == 1 => {
                    let bindings = self.all(bindings, |lowering, binding| match binding.as_list() {
                        Some([name, value]) => {
                            let parts = vec![name.clone(), lowering.with_inputs(value, inputs)?];
                            Some(Datum { kind: DatumKind::List(parts), span: binding.span })
                        }
                        _ => Some(binding.clone()),
                    })?;
                    Datum { kind: DatumKind::List(bindings), span: item.span }
                }
                _ => self.with_inputs(item, inputs)?,
            });
        }
        Some(Datum { kind: DatumKind::List(replaced), span: datum.span })
    }

    /// Returns true for `(ATTR OBJ)`: a name that is not a function's, with an object.
    fn is_state_variable(&self, items: &[Datum]) -> bool {
        let [Datum { kind: DatumKind::Symbol(attribute), .. }, object] = items else { return false };
        let is_object = matches!(object.kind, DatumKind::Variable(_) | DatumKind::Symbol(_));
        let is_word = attribute.is("t") || attribute.is("otherwise") || attribute.folded().starts_with(':');
        is_object && !is_word && !self.names.is_operator(attribute)
    }

    fn input(&mut self, variable: &Datum, reads: Reading, span: Span, inputs: &mut Inputs) -> Option<Datum> {
        let Some([Datum { kind: DatumKind::Symbol(attribute), .. }, object]) = variable.as_list() else {
            let message = "a state variable is written as `(ATTRIBUTE OBJECT)`";
            let help = format!("for example `(altitude ?{})`", inputs.object);
            return self.refuse(Diagnostic::error(codes::DERIVATION, variable.span, message).help(help));
        };
        let object = match &object.kind {
            DatumKind::Variable(name) if *name == inputs.object => Pattern::Variable(name.clone()),
            DatumKind::Symbol(_) | DatumKind::Integer(_) | DatumKind::Text(_) => Pattern::Literal(object.to_value()),
            _ => {
                let message = format!("the object of an input is `?{}` or a name", inputs.object);
                return self.refuse(Diagnostic::error(codes::DERIVATION, object.span, message));
            }
        };
        let known = |each: &DerivationInput| (&each.attribute, &each.object, each.reads) == (attribute, &object, reads);
        let name = match inputs.found.iter().find(|each| known(each)) {
            Some(known) => known.name.clone(),
            None => {
                let name = Symbol::new(&format!("input-{}", inputs.found.len() + 1));
                let input = DerivationInput { name: name.clone(), attribute: attribute.clone(), object, reads };
                inputs.found.push(input);
                name
            }
        };
        Some(Datum { kind: DatumKind::Variable(name), span })
    }

    /// Sorts derivations so that inputs come before the variables that read them; a circle is an error.
    fn rank_derivations(&mut self, spans: &BTreeMap<Symbol, Span>, library: &mut Library) {
        let count = u32::try_from(library.derivations.len()).unwrap_or(u32::MAX);
        for _ in 0..=count {
            let ranks: BTreeMap<Symbol, u32> =
                library.derivations.iter().map(|(name, derivation)| (name.clone(), derivation.rank)).collect();
            for derivation in library.derivations.values_mut() {
                let below = derivation.inputs.iter().filter_map(|input| ranks.get(&input.attribute));
                derivation.rank = below.max().map_or(0, |rank| rank.saturating_add(1));
            }
        }
        let endless = |derivation: &Derivation| derivation.rank >= count;
        if let Some((name, _)) = library.derivations.iter().find(|(_, derivation)| endless(derivation))
            && let Some(span) = spans.get(name)
        {
            let message = format!("`{name}` is derived from itself, directly or by way of others");
            self.report(Diagnostic::error(codes::DERIVATION, *span, message).help("derive it from measured variables"));
            library.derivations.clear();
        }
    }

    /// Rejects an input in place of a state variable that is a condition or a call.
    pub(crate) fn refuse_expression(&mut self, attribute: &Symbol, objects: &[Datum], span: Span) -> Option<()> {
        let is_condition = attribute.folded().starts_with(':');
        let is_call = self.names.is_operator(attribute)
            && !self.names.state_variables.contains_key(attribute)
            && objects.iter().any(|item| item.as_list().is_some());
        if !is_condition && !is_call {
            return Some(());
        }
        let message = format!("`({attribute} ..)` is not a state variable");
        let diagnostic = Diagnostic::error(codes::MALFORMED_CONDITION, span, message)
            .reason("an episode, a measurement and a cycle watch one state variable")
            .help("derive one, and watch it: `(state-variable (shaking ?a) :derived (and (> (vibration ?a) 5) (> (climb-rate ?a) 0)) :join (:hold 1s))`, then `(:episode (shaking aircraft-1) :quality (:max-gap 1s) :value (= t) :timing (:duration (>= 1s)))`");
        self.refuse(diagnostic)
    }
}

/// Inputs of the expression, if they can be determined.
struct Inputs {
    object: Symbol,
    found: Vec<DerivationInput>,
}

fn meaning(reading: Reading) -> &'static str {
    match reading {
        Reading::Value => "its latest value",
        Reading::Previous => "the value before the latest",
        Reading::Rate => "the change between the latest two samples, per second",
        Reading::Changed => "true if the latest value differs from the one before",
    }
}

/// Gives a derived variable the greatest lateness of its inputs.
fn inherit_lateness(library: &mut Library) {
    let mut order: Vec<(u32, Symbol)> =
        library.derivations.iter().map(|(name, derivation)| (derivation.rank, name.clone())).collect();
    order.sort();
    for (_, name) in order {
        let Some(derivation) = library.derivations.get(&name) else { continue };
        let late = derivation.inputs.iter().filter_map(|input| {
            match library.state_variables.get(&input.attribute)?.lateness.as_ref()? {
                Value::Duration(late) => Some(*late),
                _ => None,
            }
        });
        let late = late.max();
        if let (Some(late), Some(declaration)) = (late, library.state_variables.get_mut(&name))
            && declaration.lateness.is_none()
        {
            declaration.lateness = Some(Value::Duration(late));
        }
    }
}
