//! Applications (`pdl.md`, Applications).

use super::Lowering;
use super::clauses::{KeywordGroup, groups};
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::read::{Datum, DatumKind};
use crate::suggest::{is_certain, near, renames, renames_marked};
use apex_model::library::{Application, Library};
use apex_model::symbol::Symbol;
use apex_model::value::Value;

/// Options whose messages go to an external simulator.
const CUES: &[&str] = &["init", "start", "step", "stop", "reset"];
const KINDS: &[&str] = &["native-sim", "realtime", "foreign-sim"];

/// Options that the front end or the flying command reads.
const OPTIONS: &[&str] = &[
    "agents",
    "airfields",
    "airspace",
    "cloud-forecast",
    "costs",
    "diagnosis",
    "duration",
    "end-margin",
    "failure",
    "files",
    "forecast",
    "images-on-ground",
    "init",
    "landing-distance",
    "libraries",
    "link-map",
    "lost-link",
    "modems",
    "obstacle-margin",
    "people",
    "requirements",
    "reset",
    "routers",
    "scenario",
    "seed",
    "start",
    "step",
    "stop",
    "targets",
    "terrain",
    "type",
    "value-unit",
    "vehicle",
    "weather",
    "world",
    "zone-margin",
];

impl Lowering {
    /// Lowers `(defapplication "NAME" :type T :agents (..) ..)`.
    pub(crate) fn application(&mut self, form: &Datum, library: &mut Library) -> Option<()> {
        const SHAPE: &str = "(defapplication \"NAME\" [:type T] [:libraries (..)] [:agents (..)] ..)";
        if self.report_missing_colon(form.tail(), OPTIONS, "an application") {
            return None;
        }
        let (before, options) = groups(form.tail());
        let name = match before {
            [Datum { kind: DatumKind::Text(name), .. }] => name.clone(),
            [Datum { kind: DatumKind::Symbol(name), .. }] => name.printed().into(),
            _ => return self.missing_part(form.span, "this application has no name", SHAPE),
        };
        if let Some(first) = &library.application {
            let message = format!("a second application; the first is \"{}\"", first.name);
            let diagnostic = Diagnostic::error(codes::DUPLICATE_DEFINITION, form.span, message)
                .help("load one application at a time");
            return self.refuse(diagnostic);
        }
        let mut kept = Vec::new();
        let mut kind = Symbol::new("native-sim");
        let mut complete = true;
        for (index, group) in options.iter().enumerate() {
            if let Some(earlier) = options.iter().take(index).find(|earlier| earlier.name == group.name) {
                self.report_twice(&format!("option `:{}`", group.name), earlier.span, group.span);
                complete = false;
                continue;
            }
            match group.name {
                _ if !self.is_application_option(group) => complete = false,
                "type" => match self.application_kind(group.values, form) {
                    Some(found) => kind = found,
                    None => complete = false,
                },
                "agents" => complete &= self.agents(group.values, library).is_some(),
                "routers" => complete &= self.routers(group.values, library).is_some(),
                other => {
                    let value = match group.values {
                        [] => Value::nil(),
                        [one] => one.to_value(),
                        several => Value::list(several.iter().map(Datum::to_value)),
                    };
                    kept.push((Symbol::new(other), value));
                }
            }
        }
        complete.then_some(())?;
        self.check_cues(&options, &kind)?;
        let option_places = options.iter().map(|group| (Symbol::new(group.name), group.span.place())).collect();
        library.application = Some(Application { name, kind, options: kept, option_places, place: form.span.place() });
        Some(())
    }

    /// Checks that options for an external simulator are given only with one. A `:start` with text is a mission's civil time.
    fn check_cues(&mut self, options: &[KeywordGroup<'_>], kind: &Symbol) -> Option<()> {
        if kind.is("foreign-sim") {
            return Some(());
        }
        let is_text = |group: &KeywordGroup<'_>| matches!(group.values, [Datum { kind: DatumKind::Text(_), .. }]);
        let stray =
            options.iter().find(|group| CUES.contains(&group.name) && !(group.name == "start" && is_text(group)));
        let Some(group) = stray else { return Some(()) };
        let message = format!("`:{}` is sent to an external simulator, and this application has none", group.name);
        let diagnostic = Diagnostic::error(codes::UNKNOWN_OPTION, group.span, message)
            .reason(format!("its type is {kind}"))
            .help("write `:type foreign-sim`, or let a step of the initial task do it");
        self.refuse(diagnostic)
    }

    /// Returns true unless the option is misspelt or lacks its value. Options that the checker does not know are for the host program.
    fn is_application_option(&mut self, group: &super::clauses::KeywordGroup<'_>) -> bool {
        let mark = |name: &str| format!(":{name}");
        let known = OPTIONS.contains(&group.name);
        let found = near(group.name, OPTIONS.iter().copied());
        if !known && is_certain(group.name, &found) {
            let message = format!("an application has no option `:{}`", group.name);
            let fixes = renames_marked(group.span, group.name, OPTIONS.iter().copied(), mark);
            self.report(Diagnostic::error(codes::UNKNOWN_OPTION, group.span, message).fixes(fixes));
            return false;
        }
        if known && group.values.is_empty() {
            let message = format!("option `:{}` has no value", group.name);
            self.report(
                Diagnostic::error(codes::MALFORMED, group.span, message).help("write its value after it, or remove it"),
            );
            return false;
        }
        if let ("duration" | "end-margin" | "images-on-ground", [only]) = (group.name, group.values) {
            return self.literal_duration(only).is_some();
        }
        group.values.iter().for_each(|value| self.check_quantity_names(value));
        true
    }

    fn application_kind(&mut self, values: &[Datum], form: &Datum) -> Option<Symbol> {
        let datum = self.only(":type", values, form.span)?;
        match datum.as_symbol().map(|name| name.folded().trim_start_matches(':')) {
            Some(name) if KINDS.contains(&name) => Some(Symbol::new(name)),
            other => {
                let diagnostic =
                    Diagnostic::error(codes::UNKNOWN_OPTION, datum.span, "this is not a type of application");
                let fixes = renames(datum.span, other.unwrap_or_default(), KINDS.iter().copied());
                self.refuse(diagnostic.fixes_or_help(fixes, || format!("types are {}", KINDS.join(" "))))
            }
        }
    }

    /// Lowers one router or a list of routers.
    fn routers(&mut self, values: &[Datum], library: &mut Library) -> Option<()> {
        for value in values {
            let forms = match value.as_list() {
                Some(forms) if Lowering::is_nested(value) => forms,
                _ => std::slice::from_ref(value),
            };
            for form in forms {
                if form.head_name() != "router" {
                    return self.missing_part(form.span, "this is not a router", "(router NAME [:carries (TOPIC..)])");
                }
                self.router(form, library)?;
            }
        }
        Some(())
    }

    /// Lowers one agent or a list of agents.
    fn agents(&mut self, values: &[Datum], library: &mut Library) -> Option<()> {
        for value in values {
            let forms = match value.as_list() {
                Some(forms) if Lowering::is_nested(value) => forms,
                _ => std::slice::from_ref(value),
            };
            for form in forms {
                if form.head_name() != "agent" {
                    return self.missing_part(
                        form.span,
                        "this is not an agent",
                        "(agent NAME [:initial-task GOAL] ..)",
                    );
                }
                let agent = self.agent(form, library)?;
                library.agents.push(agent);
            }
        }
        Some(())
    }
}
