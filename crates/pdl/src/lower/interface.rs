//! Declarations of messages and commands with the types of their arguments (`docs/reference/pdl.md`, Text).

use super::Lowering;
use super::clauses::groups;
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::read::{Datum, DatumKind};
use crate::suggest::renames;
use apex_model::interface::{ArgumentType, InterfaceDeclaration, Parameter};
use apex_model::library::Library;
use apex_model::symbol::Symbol;

const EVENT: &str =
    "(declare-event (NAME (?parameter TYPE).. [&optional (?parameter TYPE)..] [&rest ?others]) [:from SOURCE])";
const COMMAND: &str = "(declare-command (NAME (?parameter TYPE).. [&optional (?parameter TYPE)..] [&rest ?others | &key (:option TYPE)..]))";
/// Senders of messages from outside.
const SOURCES: &[&str] = &["vehicle", "mission", "operator", "world"];

impl Lowering {
    /// Lowers `(declare-event ..)` and `(declare-command ..)`.
    pub(super) fn declare_interface(&mut self, form: &Datum, library: &mut Library) -> Option<()> {
        let is_event = form.head_name() == "declare-event";
        let (shape, known): (_, &[&str]) = if is_event { (EVENT, &["from"]) } else { (COMMAND, &[]) };
        let (before, options) = groups(form.tail());
        let [signature] = before else {
            return self.missing_part(form.span, &format!("this `{}` has the wrong parts", form.head_name()), shape);
        };
        let Some(name) = signature.head().cloned() else {
            return self.missing_part(
                signature.span,
                "a declaration begins with the name of the message or command",
                shape,
            );
        };
        self.check_groups(&options, known, &format!("`{}`", form.head_name()))?;
        let from = self.optional(&options, "from", Lowering::message_source)?;
        let mut declaration = self.signature(signature.tail(), shape)?;
        declaration.from = from;
        declaration.place = signature.span.place();
        let declared = if is_event { &mut library.events } else { &mut library.commands };
        let first = declared.get(&name).map(|known| known.place);
        // A program may declare the commands of its vehicle: its declaration replaces that of a shipped library, which is read later.
        let source = usize::try_from(form.span.file).ok().and_then(|file| library.sources.get(file));
        if first.is_some() && source.is_some_and(|source| source.name.starts_with("library/")) {
            return Some(());
        }
        if let Some(first) = first {
            let message = format!("`{name}` is declared twice");
            let span = crate::diagnostic::Span {
                file: first.file,
                line: first.line,
                column: first.column,
                ..crate::diagnostic::Span::default()
            };
            let diagnostic = Diagnostic::error(codes::DUPLICATE_DEFINITION, signature.span, message)
                .label(span, "first declared here")
                .help("remove one of them");
            return self.refuse(diagnostic);
        }
        declared.insert(name, declaration);
        Some(())
    }

    fn message_source(&mut self, datum: &Datum) -> Option<Symbol> {
        match datum.as_symbol() {
            Some(name) if SOURCES.contains(&name.folded()) => Some(name.clone()),
            name => {
                let diagnostic = Diagnostic::error(codes::MALFORMED, datum.span, "unknown source of messages");
                let fixes = renames(datum.span, name.map_or("", Symbol::printed), SOURCES.iter().copied());
                self.refuse(diagnostic.fixes_or_help(fixes, || format!("sources are {}", SOURCES.join(" "))))
            }
        }
    }

    /// Returns the parameters of a declaration.
    fn signature(&mut self, items: &[Datum], shape: &str) -> Option<InterfaceDeclaration> {
        let mut declaration = InterfaceDeclaration {
            parameters: Vec::new(),
            required: 0,
            options: Vec::new(),
            is_open: false,
            from: None,
            place: apex_model::source::Place::default(),
        };
        let (mut is_optional, mut takes_options) = (false, false);
        for item in items {
            match item.as_symbol().map(Symbol::folded) {
                Some("&optional") if !is_optional && !declaration.is_open => is_optional = true,
                Some("&rest") if !declaration.is_open => declaration.is_open = true,
                Some("&key") if !declaration.is_open => (declaration.is_open, takes_options) = (true, true),
                _ if takes_options => {
                    let option = self.typed_option(item, shape)?;
                    declaration.options.push(option);
                }
                // The name after `&rest`.
                _ if declaration.is_open && item.as_variable().is_some() => {}
                _ if declaration.is_open => {
                    return self.missing_part(item.span, "nothing can follow `&rest ?others`", shape);
                }
                _ => {
                    let parameter = self.typed_parameter(item, shape)?;
                    declaration.parameters.push(parameter);
                    declaration.required += usize::from(!is_optional);
                }
            }
        }
        Some(declaration)
    }

    /// Lowers `(?name TYPE)`; `?name` alone accepts any value.
    fn typed_parameter(&mut self, item: &Datum, shape: &str) -> Option<Parameter> {
        if let Some(name) = item.as_variable() {
            return Some(Parameter { name: name.clone(), argument_type: ArgumentType::Any });
        }
        let Some([Datum { kind: DatumKind::Variable(name), .. }, argument_type]) = item.as_list() else {
            return self.missing_part(item.span, "a parameter is written `(?name TYPE)`", shape);
        };
        let argument_type = self.argument_type(argument_type)?;
        Some(Parameter { name: name.clone(), argument_type })
    }

    /// Lowers `(:name TYPE)`.
    fn typed_option(&mut self, item: &Datum, shape: &str) -> Option<Parameter> {
        let Some([name, argument_type]) = item.as_list() else {
            return self.missing_part(item.span, "an option is written `(:name TYPE)`", shape);
        };
        let Some(keyword) = name.keyword() else {
            return self.missing_part(name.span, "the name of an option begins with a colon", shape);
        };
        let name = Symbol::new(&format!(":{keyword}"));
        Some(Parameter { name, argument_type: self.argument_type(argument_type)? })
    }

    fn argument_type(&mut self, datum: &Datum) -> Option<ArgumentType> {
        if let Some(words) = datum.as_list().filter(|words| !words.is_empty()) {
            let words = self.all(words, |lowering, word| match word.as_symbol() {
                Some(word) => Some(word.clone()),
                None => {
                    let message = "a type that lists its values lists words: `(on off)`";
                    lowering.refuse(Diagnostic::error(codes::MALFORMED, word.span, message))
                }
            })?;
            return Some(ArgumentType::OneOf(words));
        }
        let name = datum.as_symbol();
        match name.and_then(|name| ArgumentType::of_word(name.folded())) {
            Some(found) => Some(found),
            None => {
                let diagnostic = Diagnostic::error(codes::MALFORMED, datum.span, "expected a type of arguments");
                let fixes = renames(datum.span, name.map_or("", Symbol::printed), ArgumentType::words());
                let words: Vec<&str> = ArgumentType::words().collect();
                self.refuse(
                    diagnostic.fixes_or_help(fixes, || format!("types are {}, or a list of words", words.join(" "))),
                )
            }
        }
    }
}
