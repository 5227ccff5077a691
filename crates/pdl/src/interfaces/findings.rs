//! Collector of diagnostics about goals, messages and commands, with the texts in which their places are found.

use crate::diagnostic::Diagnostic;
use crate::locate::Locator;
use apex_model::library::Library;
use apex_model::source::{Place, SourceFile};

/// Maximum number of messages; the first ones are kept.
const MESSAGES_MAX: usize = 200;

/// Collects diagnostics.
pub(super) struct Findings<'l> {
    pub(super) locator: Locator<'l>,
    pub(super) diagnostics: Vec<Diagnostic>,
}

impl<'l> Findings<'l> {
    /// Returns an empty collection of findings about these texts.
    pub(super) fn new(sources: &'l [SourceFile]) -> Findings<'l> {
        Findings { locator: Locator::new(sources), diagnostics: Vec::new() }
    }

    pub(super) fn add(&mut self, diagnostic: Diagnostic) {
        if self.diagnostics.len() < MESSAGES_MAX {
            self.diagnostics.push(diagnostic);
        }
    }
}

/// Returns true for a text that came from the libraries of Apex.
pub(super) fn is_shipped(library: &Library, place: Place) -> bool {
    let source = usize::try_from(place.file).ok().and_then(|file| library.sources.get(file));
    source.is_some_and(|source| source.name.starts_with("library/"))
}
