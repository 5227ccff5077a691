//! Primitives (`pdl.md`, Primitives).

use super::special::local_name;
use super::{Lowering, Scope};
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::read::{Datum, DatumKind};
use crate::vocabulary::PRIMITIVE_CLAUSES;
use apex_model::expression::Expr;
use apex_model::procedure::{Hooks, Primitive};
use apex_model::symbol::Symbol;

impl Lowering {
    /// Lowers `(primitive (index PATTERN) CLAUSE..)`.
    pub(crate) fn primitive(&mut self, datum: &Datum) -> Option<Primitive> {
        let (index, mut clauses) = self.split_index(datum, datum.tail(), PRIMITIVE_CLAUSES, "primitive")?;
        clauses.retain(|clause| !super::procedure::is_documentation(clause));
        self.scope = Scope::of_tasks();
        let index = self.index_pattern(index)?;
        let mut complete = self.check_clauses(&clauses, PRIMITIVE_CLAUSES, "a primitive");
        let mut primitive = Primitive {
            index,
            profile: Vec::new(),
            locals: Vec::new(),
            duration: None,
            update: None,
            hooks: Hooks::default(),
            on_completion: Vec::new(),
            returns: None,
            bundle: self.bundle.clone(),
            place: datum.span.place(),
        };
        // Locals are lowered first, because every other clause may use them.
        let (locals, others): (Vec<&Datum>, Vec<&Datum>) =
            clauses.iter().partition(|clause| clause.head_name() == "locals");
        // A misspelt `locals` is one mistake: the uses of its variables are not reported too.
        for item in
            others.iter().filter(|clause| !PRIMITIVE_CLAUSES.contains(&clause.head_name())).flat_map(|c| c.tail())
        {
            if let Some([name, _]) = item.as_list() {
                self.scope.locals.extend(local_name(name));
            }
        }
        for clause in locals.into_iter().chain(others) {
            complete &= self.primitive_clause(clause, &mut primitive).is_some();
        }
        self.finish_scope(complete);
        complete.then_some(primitive)
    }

    fn primitive_clause(&mut self, clause: &Datum, primitive: &mut Primitive) -> Option<()> {
        match clause.head_name() {
            "profile" => primitive.profile.extend(self.profile(clause)?),
            "locals" => {
                for item in clause.tail() {
                    let (name, value) = self.local(item)?;
                    self.scope.locals.push(name.clone());
                    primitive.locals.push((name, value));
                }
            }
            "duration" => {
                let datum = self.only("duration", clause.tail(), clause.span)?;
                primitive.duration = Some(self.pure("a duration clause", |lowering| lowering.span_of_time(datum))?);
            }
            "update" => primitive.update = Some(self.update(clause)?),
            "on-completion" => primitive.on_completion.extend(self.body(clause.tail())?),
            "return" => primitive.returns = Some(self.only_expression(clause)?),
            "on-enablement" | "on-start" | "on-end" | "on-suspend" | "on-resume" => {
                self.hook(clause, &mut primitive.hooks)?;
            }
            // Unknown clauses have been reported.
            _ => {}
        }
        Some(())
    }

    fn local(&mut self, item: &Datum) -> Option<(Symbol, Expr)> {
        if let Some([name, value]) = item.as_list()
            && let Some(name) = local_name(name)
        {
            return Some((name, self.pure_expression(value, "a locals clause")?));
        }
        let diagnostic =
            Diagnostic::error(codes::MALFORMED, item.span, "this is not a variable with its initial value")
                .help("its shape is `(locals (NAME VALUE) ..)`");
        self.refuse(diagnostic)
    }

    /// Lowers `(update [INTERVAL] FORM..)`.
    fn update(&mut self, clause: &Datum) -> Option<(Option<Expr>, Vec<Expr>)> {
        let is_interval = |datum: &Datum| {
            matches!(
                datum.kind,
                DatumKind::Duration(_)
                    | DatumKind::Quantity(_)
                    | DatumKind::Indexical(_)
                    | DatumKind::Integer(_)
                    | DatumKind::Real(_)
            )
        };
        match clause.tail().split_first() {
            Some((interval, forms)) if is_interval(interval) => {
                let interval = self.pure("an update clause", |lowering| lowering.interval_or_frequency(interval));
                let forms = self.body(forms);
                Some((Some(interval?), forms?))
            }
            _ => Some((None, self.body(clause.tail())?)),
        }
    }
}
