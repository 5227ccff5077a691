//! Signatures of the host program's functions, for the checker.

use crate::diagnostic::Span;
use crate::lower::{Callable, Names};
use apex_model::symbol::Symbol;

/// A function of the host program that PDL may call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HostSignature {
    /// Its name.
    pub name: String,
    /// Least number of arguments.
    pub parameters_min: usize,
    /// Maximum number of arguments; `None` if it is unlimited.
    pub parameters_max: Option<usize>,
    /// True if it has no effect; it may then occur in conditions.
    pub pure: bool,
}

/// Returns the host program's functions as names that text may use.
pub(crate) fn host_names(host: &[HostSignature]) -> Names {
    let mut names = Names::default();
    for signature in host {
        let callable = Callable {
            min: signature.parameters_min,
            max: signature.parameters_max,
            pure: signature.pure,
            place: None,
        };
        match signature.name.strip_prefix('+').and_then(|name| name.strip_suffix('+')) {
            Some(name) if !name.is_empty() => {
                names.indexicals.insert(Symbol::new(name), Span::default());
            }
            _ => {
                names.functions.insert(Symbol::new(&signature.name), callable);
            }
        }
    }
    names
}
