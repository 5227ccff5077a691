//! Declarations: functions, indexicals, constants, state variables, resources, solvers.
//!
//! `collect` runs over all files first, so that the order of definitions does not matter; bodies are lowered afterwards.

use super::clauses::{groups, values_of};
use super::parameters::argument_counts;
use super::{Callable, Lowering, Scope};
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::read::{Datum, DatumKind};
use crate::suggest::{renames, unit_renames};
use apex_model::expression::{Expr, ExprKind};
use apex_model::interface::NameKind;
use apex_model::library::{
    Function, HostDeclaration, Library, ResourceDeclaration, ResourceKind, SolverDeclaration, StateVariableDeclaration,
};
use apex_model::quantity::{Dimension, unit_named};
use apex_model::symbol::Symbol;
use apex_model::value::Value;

const VALUE_TYPES: &[&str] = &["real", "integer", "number", "symbol", "string", "location", "boolean", "list"];

impl Lowering {
    /// Records the name that a declaration defines; lowers the declaration if it has no body.
    pub(crate) fn collect(&mut self, form: &Datum, library: &mut Library) -> Option<()> {
        match form.head_name() {
            "defun" => self.collect_function(form),
            "declare-function" => self.declare_function(form, library),
            "defindexical" => {
                let name = match form.tail() {
                    [Datum { kind: DatumKind::Indexical(name), .. }, _] => name.clone(),
                    [Datum { kind: DatumKind::Symbol(name), .. }, _] => name.clone(),
                    _ => {
                        let shape = "(defindexical +name+ EXPRESSION)";
                        return self.missing_part(form.span, "this `defindexical` has the wrong parts", shape);
                    }
                };
                if apex_model::builtins::INDEXICALS.contains(&name.folded()) {
                    let message = format!("`+{name}+` has a built-in meaning everywhere");
                    let diagnostic = Diagnostic::error(codes::DUPLICATE_DEFINITION, form.span, message);
                    return self.refuse(diagnostic.help("choose another name"));
                }
                let first = self.names.indexicals.get(&name).copied();
                self.define(&format!("+{name}+"), first, form.span)?;
                self.names.indexicals.insert(name, form.span);
                Some(())
            }
            "defconstant" => self.collect_constant(form),
            "state-variable" => self.declare_state_variable(form, library),
            "resource" => self.declare_resource(form, library),
            "declare-event" | "declare-command" => self.declare_interface(form, library),
            _ => Some(()),
        }
    }

    /// Rejects a second definition of a name.
    pub(super) fn define(&mut self, name: &str, first: Option<Span>, second: Span) -> Option<()> {
        let Some(first) = first else { return Some(()) };
        let diagnostic = Diagnostic::error(codes::DUPLICATE_DEFINITION, second, format!("`{name}` is defined twice"))
            .label(first, "first defined here")
            .help("rename or remove one of them");
        self.refuse(diagnostic)
    }

    fn define_function(&mut self, name: &Symbol, callable: Callable, span: Span) -> Option<()> {
        if self.names.function(name).is_some_and(|(_, known)| known.place.is_none())
            && !self.names.functions.contains_key(name)
            || apex_model::builtins::SPECIAL_FORMS.binary_search(&name.folded()).is_ok()
        {
            let message = format!("`{name}` is a built-in function");
            let diagnostic = Diagnostic::error(codes::DUPLICATE_DEFINITION, span, message).help("choose another name");
            return self.refuse(diagnostic);
        }
        let first = self.names.functions.get(name).and_then(|known| known.place);
        self.define(name.printed(), first, span)?;
        self.names.functions.insert(name.clone(), callable);
        Some(())
    }

    fn collect_function(&mut self, form: &Datum) -> Option<()> {
        let [name, parameters, ..] = form.tail() else {
            return self.missing_part(
                form.span,
                "this `defun` has the wrong parts",
                "(defun NAME (PARAMETER..) FORM..)",
            );
        };
        let Some(symbol) = name.as_symbol() else {
            return self.missing_part(name.span, "a function's name is a symbol", "(defun NAME (PARAMETER..) FORM..)");
        };
        let (min, max) = argument_counts(parameters.as_list().unwrap_or_default());
        let callable = Callable { min, max, pure: true, place: Some(name.span) };
        self.define_function(symbol, callable, name.span)
    }

    fn declare_function(&mut self, form: &Datum, library: &mut Library) -> Option<()> {
        const SHAPE: &str = "(declare-function (NAME PARAMETER..) [:pure t|nil] [:command t|nil])";
        let (before, options) = groups(form.tail());
        let [signature] = before else {
            return self.missing_part(form.span, "this `declare-function` has the wrong parts", SHAPE);
        };
        let Some(name) = signature.head().cloned() else {
            return self.missing_part(signature.span, "a signature begins with the function's name", SHAPE);
        };
        self.check_groups(&options, &["pure", "command"], "`declare-function`")?;
        let truth = |lowering: &mut Lowering, datum: &Datum| lowering.literal_truth(datum);
        let command = self.optional(&options, "command", truth)?.unwrap_or(false);
        let pure = self.optional(&options, "pure", truth)?.unwrap_or(!command) && !command;
        let parameters = self.all(signature.tail(), |lowering, datum| match super::special::local_name(datum) {
            Some(name) => Some(name),
            None => lowering.missing_part(datum.span, "a parameter is a name", SHAPE),
        })?;
        let rest = parameters.iter().position(|parameter| parameter.is("&rest"));
        let optional = parameters.iter().position(|parameter| parameter.is("&optional"));
        let plain = parameters.iter().filter(|parameter| !parameter.folded().starts_with('&')).count();
        let min = optional.or(rest).unwrap_or(plain);
        let max = rest.is_none().then_some(plain);
        let span = signature.span;
        // A signature of the host program may be declared once more in PDL.
        if self.names.functions.get(&name).is_some_and(|known| known.place.is_none()) {
            self.names.functions.remove(&name);
        }
        self.define_function(&name, Callable { min, max, pure, place: Some(span) }, span)?;
        let declaration = HostDeclaration { parameters, pure, command, place: span.place() };
        library.host_functions.insert(name, declaration);
        Some(())
    }

    fn literal_truth(&mut self, datum: &Datum) -> Option<bool> {
        match &datum.kind {
            DatumKind::List(items) if items.is_empty() => Some(false),
            DatumKind::Symbol(name) if name.is("t") => Some(true),
            _ => self.refuse(Diagnostic::error(codes::MALFORMED, datum.span, "write `t` or `nil` here")),
        }
    }

    fn declare_state_variable(&mut self, form: &Datum, library: &mut Library) -> Option<()> {
        const SHAPE: &str = "(state-variable (ATTRIBUTE ?object) [:unit U] [:type T] [:lateness D] [:rate R] [:derived EXPRESSION [:join J]])";
        const OPTIONS: &[&str] = &["unit", "type", "lateness", "rate", "derived", "join"];
        if self.report_missing_colon(form.tail(), OPTIONS, "a state variable") {
            return None;
        }
        let (before, options) = groups(form.tail());
        let [variable] = before else {
            return self.missing_part(form.span, "this `state-variable` has the wrong parts", SHAPE);
        };
        let attribute = match variable.head().or(variable.as_symbol()) {
            Some(attribute) => attribute.clone(),
            None => return self.missing_part(variable.span, "a state variable begins with its attribute", SHAPE),
        };
        self.check_groups(&options, OPTIONS, "`state-variable`")?;
        if let Some(join) = options.iter().find(|group| group.name == "join")
            && options.iter().all(|group| group.name != "derived")
        {
            let diagnostic = Diagnostic::error(codes::DERIVATION, join.span, "`:join` is given without `:derived`");
            return self.refuse(diagnostic.help("it says how the inputs of a derived state variable are joined"));
        }
        let unit = self.optional(&options, "unit", Lowering::unit)?.flatten();
        let value_type = self.optional(&options, "type", Lowering::value_type)?;
        let lateness = self.optional(&options, "lateness", Lowering::literal_duration)?;
        let rate_per_s = self.optional(&options, "rate", Lowering::rate_per_s)?;
        let first = self.names.state_variables.get(&attribute).map(|(_, span)| *span);
        self.define(attribute.printed(), first, form.span)?;
        let dimension =
            unit.as_ref().and_then(|unit| unit_named(unit.printed())).map_or(Dimension::NONE, |unit| unit.dimension);
        let declaration = StateVariableDeclaration {
            unit,
            dimension,
            value_type,
            lateness: lateness.map(Value::Duration),
            rate_per_s,
            place: form.span.place(),
        };
        let object = variable.tail().first().and_then(Datum::as_variable);
        if let Some(kind) = object.and_then(|object| NameKind::of_word(object.folded())) {
            library.objects.insert(attribute.clone(), kind);
        }
        self.names.state_variables.insert(attribute.clone(), (declaration.clone(), form.span));
        library.state_variables.insert(attribute, declaration);
        Some(())
    }

    fn unit(&mut self, datum: &Datum) -> Option<Option<Symbol>> {
        let name = match &datum.kind {
            DatumKind::List(items) if items.is_empty() => return Some(None),
            DatumKind::Symbol(name) => name.printed(),
            DatumKind::Text(name) => name,
            _ => return self.refuse(Diagnostic::error(codes::UNKNOWN_UNIT, datum.span, "this is not a unit")),
        };
        if let Some(unit) = unit_named(name) {
            return Some(Some(Symbol::new(unit.name)));
        }
        let diagnostic = Diagnostic::error(codes::UNKNOWN_UNIT, datum.span, format!("`{name}` is not a known unit"))
            .fixes(unit_renames(datum.span, name, str::to_string));
        self.refuse(diagnostic)
    }

    fn value_type(&mut self, datum: &Datum) -> Option<Symbol> {
        match datum.as_symbol().or_else(|| super::pattern::function_name(datum)) {
            Some(name) if VALUE_TYPES.contains(&name.folded()) => Some(name.clone()),
            _ => {
                let diagnostic = Diagnostic::error(codes::MALFORMED, datum.span, "this is not a type of values");
                let name = datum.as_symbol().map_or("", Symbol::printed);
                let fixes = renames(datum.span, name, VALUE_TYPES.iter().copied());
                self.refuse(diagnostic.fixes_or_help(fixes, || format!("types are {}", VALUE_TYPES.join(" "))))
            }
        }
    }

    fn rate_per_s(&mut self, datum: &Datum) -> Option<f64> {
        let rate = match datum.to_value() {
            Value::Duration(interval) => Some(1.0 / interval.seconds()),
            value => value
                .as_number()
                .filter(|(_, dimension)| matches!(*dimension, Dimension::NONE | Dimension::FREQUENCY))
                .map(|(rate, _)| rate),
        };
        match rate.filter(|rate| rate.is_finite() && *rate > 0.0) {
            Some(rate) => Some(rate),
            None => {
                let diagnostic = Diagnostic::error(
                    codes::MALFORMED,
                    datum.span,
                    "a rate is a positive number of samples per second",
                )
                .help("write `10` or `10Hz`");
                self.refuse(diagnostic)
            }
        }
    }

    fn declare_resource(&mut self, form: &Datum, library: &mut Library) -> Option<()> {
        const SHAPE: &str =
            "(resource NAME [:capacity N | :depletable QUANTITY | :renewable QUANTITY] [:part-of RESOURCE])";
        let (before, options) = groups(form.tail());
        let [Datum { kind: DatumKind::Symbol(name), span }] = before else {
            return self.missing_part(form.span, "this `resource` has the wrong parts", SHAPE);
        };
        self.check_groups(&options, &["capacity", "depletable", "renewable", "part-of"], "`resource`")?;
        let kinds = ["capacity", "depletable", "renewable"].map(|kind| values_of(&options, kind));
        let kind = match kinds {
            [[], [], []] => ResourceKind::Unitary,
            [[capacity], [], []] => match capacity.kind {
                DatumKind::Integer(units) if units > 0 && u32::try_from(units).is_ok() => {
                    ResourceKind::Capacity(u32::try_from(units).unwrap_or(u32::MAX))
                }
                _ => {
                    let message = "a capacity is a positive whole number";
                    return self.refuse(Diagnostic::error(codes::MALFORMED, capacity.span, message));
                }
            },
            [[], [amount], []] => ResourceKind::Depletable(self.resource_amount(amount)?),
            [[], [], [amount]] => ResourceKind::Renewable(self.resource_amount(amount)?),
            _ => return self.missing_part(form.span, "this `resource` has the wrong parts", SHAPE),
        };
        let part_of = match values_of(&options, "part-of") {
            [] => None,
            [Datum { kind: DatumKind::Symbol(whole), span: whole_span }] => {
                self.check_part(name, &kind, (whole, *whole_span))?;
                Some(whole.clone())
            }
            _ => return self.missing_part(form.span, "this `resource` has the wrong parts", SHAPE),
        };
        let first = self.names.resources.get(name).map(|(_, span)| *span);
        self.define(name.printed(), first, *span)?;
        self.names.resources.insert(name.clone(), (kind.clone(), *span));
        library.resources.insert(name.clone(), ResourceDeclaration { kind, part_of, place: form.span.place() });
        Some(())
    }

    fn resource_amount(&mut self, amount: &Datum) -> Option<Value> {
        let value = amount.to_value();
        if value.as_number().is_some_and(|(number, _)| number >= 0.0) {
            return Some(value);
        }
        let diagnostic = Diagnostic::error(codes::MALFORMED, amount.span, "an amount is a number or quantity");
        self.refuse(diagnostic.help("for example `:depletable 180kg`"))
    }

    /// Checks a resource that is a part: it must be neither depletable nor a part of itself. The declaration of its whole is checked at
    /// the end.
    fn check_part(&mut self, name: &Symbol, kind: &ResourceKind, (whole, span): (&Symbol, Span)) -> Option<()> {
        let message = match kind {
            ResourceKind::Depletable(_) | ResourceKind::Renewable(_) => {
                "a resource that is used up cannot be a part of another one"
            }
            _ if name == whole => "a resource cannot be a part of itself",
            _ => {
                self.wholes.push((name.clone(), whole.clone(), span));
                return Some(());
            }
        };
        self.refuse(Diagnostic::error(codes::MALFORMED, span, message))
    }

    /// Checks that wholes are declared, are unitary, and do not belong to their parts.
    pub(crate) fn check_wholes(&mut self, library: &Library) {
        for (part, whole, span) in std::mem::take(&mut self.wholes) {
            let message = match library.resources.get(&whole).map(|declared| &declared.kind) {
                None => format!("resource `{whole}` is not declared"),
                Some(ResourceKind::Unitary) if library.parts_of(&part).contains(&&whole) => {
                    format!("`{whole}` is itself a part of `{part}`")
                }
                Some(ResourceKind::Unitary) => continue,
                Some(_) => format!("`{whole}` is shared by amounts, and has no parts"),
            };
            let known = library.resources.iter().filter(|(name, _)| **name != part);
            let fixes = renames(span, whole.printed(), known.map(|(name, _)| name.printed()));
            let diagnostic = Diagnostic::error(codes::MALFORMED, span, message);
            self.report(diagnostic.fixes_or_help(fixes, || format!("declare `(resource {whole})`")));
        }
    }

    /// Lowers the body of a `defun`; purity is settled by [`Lowering::settle_purity`].
    pub(crate) fn function(&mut self, form: &Datum) -> Option<(Symbol, Function)> {
        let [Datum { kind: DatumKind::Symbol(name), .. }, parameters, body @ ..] = form.tail() else { return None };
        self.scope = Scope::default();
        self.called.clear();
        self.had_effect = false;
        // A string before other forms describes the function.
        let body = match body {
            [Datum { kind: DatumKind::Text(_), .. }, rest @ ..] if !rest.is_empty() => rest,
            all => all,
        };
        let (parameters, body) = self.parameters_and_body(parameters, body)?;
        let function = Function { parameters, body, pure: !self.had_effect, place: form.span.place() };
        Some((name.clone(), function))
    }

    /// Lowers the expression of a `defindexical`.
    pub(crate) fn indexical_definition(&mut self, form: &Datum) -> Option<(Symbol, Expr)> {
        let [Datum { kind: DatumKind::Indexical(name) | DatumKind::Symbol(name), .. }, value] = form.tail() else {
            return None;
        };
        self.scope = Scope::default();
        let expr = self.pure_expression(value, "an indexical")?;
        Some((name.clone(), expr))
    }

    /// Lowers `(solver [NAME] (index PATTERN) [:budget E] [:meanwhile GOAL])`; options may also be clauses.
    pub(crate) fn solver(&mut self, form: &Datum) -> Option<SolverDeclaration> {
        const CLAUSES: &[&str] = &["index", "budget", "meanwhile"];
        let (name, rest) = match form.tail() {
            [Datum { kind: DatumKind::Symbol(name), .. }, rest @ ..] if !name.folded().starts_with(':') => {
                (name.clone(), rest)
            }
            all => (Symbol::new("auto"), all),
        };
        let (before, options) = groups(rest);
        self.check_groups(&options, &["budget", "meanwhile"], "`solver`")?;
        let (index, clauses) = self.split_index(form, before, CLAUSES, "solver")?;
        self.scope = Scope::of_tasks();
        self.is_solver = true;
        let index = self.index_pattern(index);
        self.is_solver = false;
        let index = index?;
        if !self.check_clauses(&clauses, CLAUSES, "a solver") {
            return None;
        }
        let clause = |name: &str| clauses.iter().find(|clause| clause.head_name() == name);
        let of_clause = |name: &str| clause(name).map_or(&[][..], |clause| clause.tail());
        let budget = values_of(&options, "budget").iter().chain(of_clause("budget")).next();
        let meanwhile = values_of(&options, "meanwhile").iter().chain(of_clause("meanwhile")).next();
        let budget = match budget {
            Some(datum) => Some(self.pure("a solver's budget", |lowering| lowering.span_of_time(datum))?),
            None => None,
        };
        if let Some(budget) = &budget
            && let ExprKind::Constant(Value::Duration(span)) = &budget.kind
            && span.0 <= 0
        {
            let place = values_of(&options, "budget").first().map_or(form.span, |datum| datum.span);
            let diagnostic =
                Diagnostic::error(codes::DURATION_EXPECTED, place, "a solver's budget is greater than zero");
            return self.refuse(diagnostic.help("write how long it may take, for example `:budget 2s`"));
        }
        let meanwhile = match meanwhile {
            Some(datum) => Some(self.goal(datum)?),
            None => None,
        };
        self.finish_scope(true);
        Some(SolverDeclaration { name, index, budget, meanwhile, place: form.span.place() })
    }
}
