//! Data with places: the text's contents before names are resolved.

use crate::diagnostic::Span;
use apex_model::quantity::Quantity;
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use apex_model::value::Value;
use std::sync::Arc;

/// A datum with its place.
#[derive(Clone, Debug)]
pub(crate) struct Datum {
    pub(crate) kind: DatumKind,
    pub(crate) span: Span,
}

/// Kind of a datum.
#[derive(Clone, Debug)]
pub(crate) enum DatumKind {
    Integer(i64),
    Real(f64),
    Quantity(Quantity),
    Duration(Duration),
    Text(Arc<str>),
    /// A name; keywords keep their colon.
    Symbol(Symbol),
    /// `?x`, stored without `?`.
    Variable(Symbol),
    /// `<?x>`, stored without its marks.
    Bound(Symbol),
    /// `?`
    Anonymous,
    /// `+x+`, stored without its marks.
    Indexical(Symbol),
    /// A list; `nil` is the empty list.
    List(Vec<Datum>),
    /// `'x`
    Quote(Box<Datum>),
    /// A backquote and its datum.
    Quasi(Box<Datum>),
    /// `,x`
    Unquote(Box<Datum>),
    /// `,@x`
    Splice(Box<Datum>),
    /// `#'x`
    Function(Box<Datum>),
}

impl Datum {
    pub(crate) fn as_list(&self) -> Option<&[Datum]> {
        match &self.kind {
            DatumKind::List(items) => Some(items),
            _ => None,
        }
    }

    pub(crate) fn as_symbol(&self) -> Option<&Symbol> {
        match &self.kind {
            DatumKind::Symbol(symbol) => Some(symbol),
            _ => None,
        }
    }

    /// Returns true if this is the symbol with the folded name `name`.
    pub(crate) fn is(&self, name: &str) -> bool {
        self.as_symbol().is_some_and(|symbol| symbol.is(name))
    }

    /// Returns the folded keyword without its colon.
    pub(crate) fn keyword(&self) -> Option<&str> {
        self.as_symbol().and_then(|symbol| symbol.folded().strip_prefix(':')).filter(|name| !name.is_empty())
    }

    /// Returns the symbol that a list begins with.
    pub(crate) fn head(&self) -> Option<&Symbol> {
        self.as_list().and_then(<[Datum]>::first).and_then(Datum::as_symbol)
    }

    /// Returns the folded name that a list begins with, or nothing.
    pub(crate) fn head_name(&self) -> &str {
        self.head().map_or("", Symbol::folded)
    }

    /// Returns the place of the first item of a list; for any other datum its own place.
    pub(crate) fn head_span(&self) -> Span {
        self.as_list().and_then(<[Datum]>::first).map_or(self.span, |first| first.span)
    }

    /// Returns the items after the first of a list.
    pub(crate) fn tail(&self) -> &[Datum] {
        self.as_list().and_then(|items| items.get(1..)).unwrap_or_default()
    }

    /// Returns the variable's name, for `?x` and `<?x>`.
    pub(crate) fn as_variable(&self) -> Option<&Symbol> {
        match &self.kind {
            DatumKind::Variable(name) | DatumKind::Bound(name) => Some(name),
            _ => None,
        }
    }

    /// Returns the datum as a value, nothing evaluated: variables and indexicals become symbols as written.
    pub(crate) fn to_value(&self) -> Value {
        let marked = |mark: &str, inner: &Datum| Value::list([Value::symbol(mark), inner.to_value()]);
        match &self.kind {
            DatumKind::Integer(integer) => Value::Integer(*integer),
            DatumKind::Real(real) => Value::Real(*real),
            DatumKind::Quantity(quantity) => Value::Quantity(*quantity),
            DatumKind::Duration(duration) => Value::Duration(*duration),
            DatumKind::Text(text) => Value::Text(text.clone()),
            DatumKind::Symbol(symbol) => Value::Symbol(symbol.clone()),
            DatumKind::Variable(name) => Value::symbol(&format!("?{name}")),
            DatumKind::Bound(name) => Value::symbol(&format!("<?{name}>")),
            DatumKind::Anonymous => Value::symbol("?"),
            DatumKind::Indexical(name) => Value::symbol(&format!("+{name}+")),
            DatumKind::List(items) => Value::list(items.iter().map(Datum::to_value)),
            DatumKind::Quote(inner) => marked("quote", inner),
            DatumKind::Quasi(inner) => marked("quasiquote", inner),
            DatumKind::Unquote(inner) => marked("unquote", inner),
            DatumKind::Splice(inner) => marked("unquote-splicing", inner),
            DatumKind::Function(inner) => marked("function", inner),
        }
    }

    /// Returns true if the variable `name` occurs anywhere inside.
    pub(crate) fn mentions(&self, name: &Symbol) -> bool {
        match &self.kind {
            DatumKind::Variable(other) | DatumKind::Bound(other) => other == name,
            DatumKind::List(items) => items.iter().any(|item| item.mentions(name)),
            DatumKind::Quote(inner)
            | DatumKind::Quasi(inner)
            | DatumKind::Unquote(inner)
            | DatumKind::Splice(inner)
            | DatumKind::Function(inner) => inner.mentions(name),
            _ => false,
        }
    }

    /// Returns true if a variable or indexical occurs anywhere inside; a literal has none.
    pub(crate) fn has_holes(&self) -> bool {
        match &self.kind {
            DatumKind::Variable(_)
            | DatumKind::Bound(_)
            | DatumKind::Anonymous
            | DatumKind::Indexical(_)
            | DatumKind::Unquote(_)
            | DatumKind::Splice(_) => true,
            DatumKind::List(items) => items.iter().any(Datum::has_holes),
            DatumKind::Quote(inner) | DatumKind::Quasi(inner) | DatumKind::Function(inner) => inner.has_holes(),
            _ => false,
        }
    }
}
