//! Source texts to a checked library: reading, following requirements, collecting names, lowering, cross checks.

use crate::analysis::{analyse, analyse_conditions};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity, Span};
use crate::fix::Fix;
use crate::host::{HostSignature, host_names};
use crate::interfaces;
use crate::loose;
use crate::lower::{Lowering, Names};
use crate::read::{Datum, DatumKind, read_file};
use crate::requirement::{Requirement, Unresolved};
use crate::suggest::{renames, renames_marked};
use crate::vocabulary::FORMS;
use apex_model::condition::Condition;
use apex_model::library::Library;
use apex_model::source::SourceFile;
use apex_model::symbol::Symbol;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// A text to check and the name to print for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceText {
    /// A path as given by the user, or another name that describes the source of the text.
    pub name: String,
    /// The text.
    pub text: String,
}

impl HostSignature {
    /// Returns a pure function called `name` of `parameters_min` to `parameters_max` arguments.
    pub fn pure((name, parameters_min, parameters_max): (&str, usize, Option<usize>)) -> HostSignature {
        HostSignature { name: name.to_string(), parameters_min, parameters_max, pure: true }
    }
}

/// Options of a check.
pub struct CheckOptions<'a> {
    /// True if the text is a part of something larger: undefined names and missing libraries become notes, and a library is produced
    /// nevertheless.
    pub fragment: bool,
    /// Functions of the host program.
    pub host: &'a [HostSignature],
    /// Returns required texts.
    pub resolve: &'a mut dyn FnMut(Requirement) -> Result<SourceText, Unresolved>,
}

/// Result of a check.
#[derive(Clone, Debug)]
pub struct Checked {
    /// Everything that could be read. Usable for a flight only if there are no errors.
    pub library: Library,
    /// Messages in order of place.
    pub diagnostics: Vec<Diagnostic>,
}

impl Checked {
    /// Returns true if any message is an error.
    pub fn has_errors(&self) -> bool {
        self.diagnostics.iter().any(|diagnostic| diagnostic.severity == Severity::Error)
    }
}

/// Maximum number of texts loaded for one library. Each text is loaded once, which ends a cycle of requirements; this limit ends a
/// growing chain.
const SOURCES_MAX: usize = 1_000;

/// Checks `sources` and everything that they require. It never fails: errors are in the diagnostics.
pub fn check(sources: Vec<SourceText>, options: CheckOptions<'_>) -> Checked {
    check_with(sources, options, true)
}

/// Checks forms and names like [`check`], but not the behaviour of the complete program: steps that can never begin, endless loops and
/// the like are accepted. For programs that are meant to get stuck.
pub fn check_forms(sources: Vec<SourceText>, options: CheckOptions<'_>) -> Checked {
    check_with(sources, options, false)
}

fn check_with(sources: Vec<SourceText>, options: CheckOptions<'_>, foresee: bool) -> Checked {
    let mut loader = Loader::default();
    let fragment = options.fragment;
    let names = host_names(options.host);
    for source in sources {
        loader.load(source, fragment, options.resolve);
    }
    loader.finish(names, fragment, foresee, &[]).0
}

/// Reads texts and what they require, then makes a library of them.
#[derive(Default)]
pub(crate) struct Loader {
    library: Library,
    /// Top-level data of each file.
    files: Vec<Vec<Datum>>,
    /// Files with errors of syntax: further messages about them would be about the same error.
    flawed: BTreeSet<u32>,
    diagnostics: Vec<Diagnostic>,
    requested: BTreeSet<Requirement>,
    /// Files loaded as libraries, and the files that these require.
    foreign: BTreeSet<u32>,
    /// True if a text is missing that may define names.
    incomplete: bool,
}

impl Loader {
    /// Reads a text and, before it, the texts that it requires.
    pub(crate) fn load(
        &mut self,
        source: SourceText,
        fragment: bool,
        resolve: &mut dyn FnMut(Requirement) -> Result<SourceText, Unresolved>,
    ) {
        let mut pending = vec![(source, false)];
        while let Some((source, is_library)) = pending.pop() {
            if self.library.sources.iter().any(|known| *known.name == source.name) {
                continue;
            }
            let requirements = self.read(source, is_library, fragment);
            for (requirement, span) in requirements.into_iter().rev() {
                if !self.requested.insert(requirement.clone()) {
                    continue;
                }
                let is_library = is_library || matches!(requirement, Requirement::Library(_));
                match resolve(requirement.clone()) {
                    Ok(text) if self.files.len() + pending.len() < SOURCES_MAX => pending.push((text, is_library)),
                    Ok(_) => self.missing(&requirement, span, "too many files are required".into(), fragment),
                    Err(unresolved) => self.missing(&requirement, span, unresolved, fragment),
                }
            }
        }
    }

    /// Reads a text and returns its requirements.
    pub(crate) fn read(&mut self, source: SourceText, is_library: bool, fragment: bool) -> Vec<(Requirement, Span)> {
        let number = u32::try_from(self.files.len()).unwrap_or(u32::MAX);
        if is_library {
            self.foreign.insert(number);
        }
        let read = read_file(number, &source.text);
        // After a string without end, all later data are unreliable.
        let garbled = read.diagnostics.iter().any(|each| each.code == codes::UNCLOSED_STRING);
        for mut diagnostic in read.diagnostics {
            if fragment && diagnostic.code == codes::UNMATCHED_CLOSE {
                diagnostic.severity = Severity::Warning;
            }
            if diagnostic.severity == Severity::Error {
                self.flawed.insert(number);
                self.incomplete = true;
            }
            self.diagnostics.push(diagnostic);
        }
        self.incomplete |= lacks_libraries(&read.data);
        let requirements = if garbled { Vec::new() } else { requirements(&read.data, &source.name) };
        self.library.sources.push(SourceFile { name: Arc::from(&*source.name), text: Arc::from(source.text) });
        self.files.push(read.data);
        requirements
    }

    /// Returns the number of texts that were read.
    pub(crate) fn texts_read(&self) -> usize {
        self.files.len()
    }

    /// Removes everything that was read from this text on: it is not a part of the library.
    pub(crate) fn split_off(&mut self, first: usize) -> Vec<Vec<Datum>> {
        self.files.split_off(first)
    }

    fn missing(&mut self, requirement: &Requirement, span: Span, unresolved: Unresolved, fragment: bool) {
        let what = match requirement {
            Requirement::Library(name) => format!("library \"{name}\" cannot be loaded"),
            Requirement::File { name, .. } => format!("file \"{name}\" cannot be loaded"),
        };
        self.incomplete = true;
        let severity = if fragment { Severity::Note } else { Severity::Error };
        let diagnostic = Diagnostic::new(severity, codes::REQUIREMENT_MISSING, span, what);
        let fixes = self.renames(requirement, span, &unresolved.names);
        self.diagnostics.push(diagnostic.fixes(fixes).reason(unresolved.reason));
    }

    /// Returns fixes for a misspelt name, from the names that exist.
    fn renames(&self, requirement: &Requirement, span: Span, names: &[String]) -> Vec<Fix> {
        let (Requirement::Library(name) | Requirement::File { name, .. }) = requirement;
        let source = usize::try_from(span.file).ok().and_then(|file| self.library.sources.get(file));
        let start = usize::try_from(span.start).ok();
        let quoted = source
            .zip(start)
            .and_then(|(source, start)| source.text.get(start..))
            .is_some_and(|text| text.starts_with('"'));
        renames_marked(span, name, names.iter().map(String::as_str), |name| {
            if quoted { format!("\"{name}\"") } else { name.to_string() }
        })
    }

    /// Returns the library of all texts; `texts` are those that [`Loader::split_off`] removed, which contain conditions.
    pub(crate) fn finish(
        mut self,
        names: Names,
        fragment: bool,
        foresee: bool,
        texts: &[Vec<Datum>],
    ) -> (Checked, Vec<Condition>) {
        let mut lowering = Lowering::new(names, fragment);
        lowering.texts = self.library.sources.iter().map(|source| Arc::clone(&source.text)).collect();
        let mut files = std::mem::take(&mut self.files);
        if fragment {
            files = files.into_iter().map(loose::gather).collect();
        }
        let mut refused = false;
        for form in files.iter().flatten() {
            refused |= lowering.collect(form, &mut self.library).is_none();
        }
        let callers = lower_functions(&mut lowering, &files, &mut self.library);
        lowering.derivations(files.iter().flatten(), &mut self.library);
        lowering.computed_constants(files.iter().flatten(), &callers, &mut self.library);
        for file in files {
            self.lower_file(&mut lowering, file);
        }
        let conditions: Vec<Condition> = texts.iter().flat_map(|text| lowering.lone_conditions(text)).collect();
        // Definitions in a rejected form are not reported as missing again.
        if !self.incomplete && !refused {
            lowering.report_unknown_names();
        }
        let is_whole = !self.incomplete && !lowering.refused_form;
        if is_whole && lowering.unindexed.is_empty() {
            lowering.report_unserved_goals(&self.library);
        } else if is_whole {
            lowering.suggest_index(&self.library);
        }
        if !self.incomplete {
            lowering.check_wholes(&self.library);
            lowering.report_same_indexes();
            lowering.report_unknown_company(&self.library);
        }
        if is_whole && lowering.unindexed.is_empty() {
            lowering.report_words_like_variables();
        }
        let no_errors = |all: &[Diagnostic]| all.iter().all(|each| each.severity != Severity::Error);
        if foresee && !self.incomplete && no_errors(&self.diagnostics) && no_errors(&lowering.diagnostics) {
            let found = match texts {
                [] => analyse(&self.library, &lowering.names, fragment, &self.foreign),
                _ => analyse_conditions(&self.library, &conditions, &lowering.names),
            };
            self.diagnostics.extend(found);
            if texts.is_empty() {
                self.diagnostics.extend(interfaces::check(&self.library));
            }
        }
        let flawed = &self.flawed;
        self.diagnostics.extend(lowering.diagnostics.into_iter().filter(|each| !flawed.contains(&each.span.file)));
        // Notes are meant for the author of a text; in a program that only uses a library, notes about the library would be noise.
        let foreign = &self.foreign;
        self.diagnostics.retain(|each| each.severity != Severity::Note || !foreign.contains(&each.span.file));
        self.diagnostics.sort_by_key(|each| (each.span.file, each.span.line, each.span.column, each.severity));
        (Checked { library: self.library, diagnostics: self.diagnostics }, conditions)
    }

    /// Lowers all forms of a file. Each form is dropped once it is lowered, so that long programs are not in memory twice.
    fn lower_file(&mut self, lowering: &mut Lowering, forms: Vec<Datum>) {
        lowering.bundle = None;
        for form in forms {
            let form = &form;
            let (served, unindexed) = (lowering.served.len(), lowering.unindexed.len());
            match form.head_name() {
                "procedure" => self.library.procedures.extend(lowering.procedure(form).map(Arc::new)),
                "primitive" => self.library.primitives.extend(lowering.primitive(form).map(Arc::new)),
                "solver" => self.library.solvers.extend(lowering.solver(form)),
                "defindexical" => self.library.indexicals.extend(lowering.indexical_definition(form)),
                "agent" => {
                    let agent = lowering.agent(form, &self.library);
                    self.library.agents.extend(agent);
                }
                "defapplication" => {
                    lowering.application(form, &mut self.library);
                }
                "router" => {
                    lowering.router(form, &mut self.library);
                }
                "in-apex-bundle" => enter_bundle(lowering, form),
                "defun"
                | "declare-command"
                | "declare-event"
                | "declare-function"
                | "defconstant"
                | "state-variable"
                | "resource"
                | "require-apex-file"
                | "require-apex-library" => {}
                _ => unknown_form(lowering, form),
            }
            let serves = matches!(form.head_name(), "procedure" | "primitive" | "solver");
            let is_unindexed = lowering.unindexed.len() > unindexed;
            lowering.refused_form |= serves && !is_unindexed && lowering.served.len() == served;
        }
    }
}

/// Lowers all functions, then determines which of them have effects through the functions that they call. Returns the callers of each.
fn lower_functions(
    lowering: &mut Lowering,
    files: &[Vec<Datum>],
    library: &mut Library,
) -> BTreeMap<Symbol, Vec<Symbol>> {
    let mut callers: BTreeMap<Symbol, Vec<Symbol>> = BTreeMap::new();
    let mut impure: Vec<Symbol> = Vec::new();
    for form in files.iter().flatten().filter(|form| form.head_name() == "defun") {
        let Some((name, function)) = lowering.function(form) else { continue };
        for callee in std::mem::take(&mut lowering.called) {
            callers.entry(callee).or_default().push(name.clone());
        }
        if !function.pure {
            impure.push(name.clone());
        }
        library.functions.entry(name).or_insert(function);
    }
    let mut seen: BTreeSet<Symbol> = impure.iter().cloned().collect();
    while let Some(name) = impure.pop() {
        if let Some(callable) = lowering.names.functions.get_mut(&name) {
            callable.pure = false;
        }
        if let Some(function) = library.functions.get_mut(&name) {
            function.pure = false;
        }
        for caller in callers.get(&name).into_iter().flatten() {
            if seen.insert(caller.clone()) {
                impure.push(caller.clone());
            }
        }
    }
    callers
}

/// Returns true if the application has an option for libraries or files without values: definitions may then be missing, which is not
/// reported.
fn lacks_libraries(forms: &[Datum]) -> bool {
    let lacks = |items: &[Datum]| {
        items.iter().enumerate().any(|(at, item)| {
            matches!(item.keyword(), Some("libraries" | "files"))
                && items.get(at + 1).is_none_or(|next| next.keyword().is_some())
        })
    };
    forms.iter().any(|form| form.head_name() == "defapplication" && lacks(form.tail()))
}

/// Returns the requirements of a file, in order.
fn requirements(forms: &[Datum], from: &str) -> Vec<(Requirement, Span)> {
    let library = |name: String| Requirement::Library(name);
    let file = |name: String| Requirement::File { name, from: from.to_string() };
    let mut found = Vec::new();
    for form in forms {
        match form.head_name() {
            "require-apex-library" => found.extend(names_of(form.tail()).map(|(name, span)| (library(name), span))),
            "require-apex-file" => found.extend(names_of(form.tail()).map(|(name, span)| (file(name), span))),
            "defapplication" => {
                let items = form.tail();
                // A misspelt option is reported later; the files that it names are loaded nevertheless, so that no further errors follow.
                let option = |name: &str| {
                    let is_meant = |word: &str| {
                        word == name
                            || crate::suggest::is_certain(word, &crate::suggest::near(word, ["libraries", "files"]))
                                && crate::suggest::nearest(word, ["libraries", "files"]) == Some(name)
                    };
                    let lacks_colon = |item: &Datum| item.is(name);
                    let named = |item: &Datum| item.keyword().is_some_and(is_meant) || lacks_colon(item);
                    let at = items.iter().position(named);
                    at.and_then(|at| items.get(at + 1)).map(std::slice::from_ref).unwrap_or_default()
                };
                found.extend(names_of(option("libraries")).map(|(name, span)| (library(name), span)));
                found.extend(names_of(option("files")).map(|(name, span)| (file(name), span)));
            }
            _ => {}
        }
    }
    found
}

/// Returns strings and symbols, alone or in lists. A list without its end would include the following options: it ends before them.
fn names_of(data: &[Datum]) -> impl Iterator<Item = (String, Span)> + '_ {
    let items = |datum| Datum::as_list(datum).unwrap_or(std::slice::from_ref(datum));
    let names = data.iter().flat_map(move |datum| items(datum).iter().take_while(|item| item.keyword().is_none()));
    names.filter_map(|datum| match &datum.kind {
        DatumKind::Text(text) => Some((text.to_string(), datum.span)),
        DatumKind::Symbol(name) => Some((name.to_string(), datum.span)),
        _ => None,
    })
}

/// Handles `(in-apex-bundle :name)`: the forms after it belong to the bundle; the default bundle has no name.
fn enter_bundle(lowering: &mut Lowering, form: &Datum) {
    match form.tail() {
        [Datum { kind: DatumKind::Symbol(name), .. }] => {
            let name = name.printed().trim_start_matches(':');
            lowering.bundle = (!name.eq_ignore_ascii_case("default")).then(|| Symbol::new(name));
            lowering.bundle_names.extend(lowering.bundle.clone());
        }
        _ => {
            let diagnostic = Diagnostic::error(codes::MALFORMED, form.span, "this `in-apex-bundle` names no bundle")
                .help("its shape is `(in-apex-bundle :name)`");
            lowering.report(diagnostic);
        }
    }
}

fn unknown_form(lowering: &mut Lowering, form: &Datum) {
    let diagnostic = match form.head() {
        Some(head) => {
            let message = format!("no top-level form is called `{head}`");
            let diagnostic = Diagnostic::error(codes::UNKNOWN_FORM, form.span, message);
            let span = form.head_span();
            diagnostic.fixes_or_help(renames(span, head.printed(), FORMS.iter().copied()), || {
                if head.is("step") {
                    "a step must be inside a procedure; perhaps a `)` before it is superfluous".to_string()
                } else {
                    format!("top-level forms are {}", FORMS.join(" "))
                }
            })
        }
        None => Diagnostic::error(codes::UNKNOWN_FORM, form.span, "this is not a top-level form")
            .help("a file is a sequence of forms such as `(procedure ..)`"),
    };
    lowering.report(diagnostic);
    lowering.refused_form = true;
}
