//! Makes the reference page of the shipped libraries from their text: commands, messages, state variables, goals, functions.

use crate::read::{Datum, DatumKind, read_file};
use crate::words::{LIBRARIES, written};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Rows of the page by section.
#[derive(Default)]
struct Sections {
    commands: Vec<String>,
    messages: BTreeMap<String, MessageEntry>,
    variables: Vec<String>,
    goals: Vec<String>,
    functions: Vec<String>,
    resources: Vec<String>,
}

/// A message with its senders.
#[derive(Default)]
struct MessageEntry {
    signature: Option<String>,
    from: Option<String>,
    said_by: Vec<String>,
}

/// Returns the page in Markdown: `docs/reference/library.md`.
pub fn library_reference() -> String {
    let mut sections = Sections::default();
    for (name, text) in LIBRARIES {
        let library = name.trim_start_matches("library/").trim_end_matches(".pdl");
        for form in &read_file(0, text).data {
            sections.add(library, text, form);
        }
    }
    let mut page = String::from(
        "# Commands, messages, state variables and goals of the libraries\n\nMade from the text of `library/*.pdl` (`UPDATE=1 cargo test --package \
         apex-pdl --test library_page`). `apex explain WORD`\nprints the entries of one word with their places. Types of arguments: \
         [pdl.md](pdl.md#types-of-arguments).\n",
    );
    sections.print(&mut page);
    page
}

impl Sections {
    fn add(&mut self, library: &str, text: &str, form: &Datum) {
        let first = form.tail().first();
        let signature = || first.map_or_else(String::new, |part| written(text, part));
        match form.head_name() {
            "declare-command" => self.commands.push(format!("| `{}` |", signature())),
            "declare-event" => {
                let from = form.tail().iter().skip_while(|part| !part.is(":from")).nth(1);
                let entry = self.messages.entry(first.map_or("", |part| part.head_name()).to_string()).or_default();
                entry.signature = Some(signature());
                entry.from = from.map(|source| written(text, source));
            }
            "state-variable" => {
                let option = |name: &str| {
                    let value = form.tail().iter().skip_while(|part| !part.is(name)).nth(1);
                    value.map_or_else(|| "-".to_string(), |value| written(text, value))
                };
                let (unit, kind) = (option(":unit"), option(":type"));
                self.variables.push(format!("| `{}` | {unit} | {kind} | {library} |", signature()));
            }
            "resource" => self.resources.push(format!("| `{}` | {library} |", written(text, form))),
            "defun" => {
                let parameters = form.tail().get(1).map_or_else(String::new, |part| written(text, part));
                self.functions.push(format!("| `{}` | `{parameters}` | {library} |", signature()));
            }
            kind @ ("procedure" | "primitive" | "solver") => self.serving(library, text, kind, form),
            _ => {}
        }
    }

    fn serving(&mut self, library: &str, text: &str, kind: &str, form: &Datum) {
        let index = form.tail().iter().find(|clause| clause.head_name() == "index");
        let Some(index) = index.and_then(|clause| clause.tail().first()) else { return };
        let goal = written(text, index);
        self.goals.push(format!("| `{goal}` | {kind} | {library} |"));
        each_list(form, &mut |list| {
            let message = list.tail().first().filter(|message| message.head().is_some());
            if let Some(message) = message.filter(|_| matches!(list.head_name(), "inform" | "cogevent")) {
                note(&mut self.messages.entry(message.head_name().to_string()).or_default().said_by, &goal);
            }
        });
    }

    fn print(self, page: &mut String) {
        let mut table = |title: &str, head: &str, rows: Vec<String>| {
            let columns = head.matches('|').count().saturating_sub(1);
            let _ = write!(page, "\n## {title}\n\n{head}\n{}|\n", "|---".repeat(columns));
            for row in rows {
                let _ = writeln!(page, "{row}");
            }
        };
        table("Commands", "| command |", self.commands);
        let known =
            self.messages.into_iter().filter(|(_, message)| message.signature.is_some() || !message.said_by.is_empty());
        let rows = known.map(|(name, message)| {
            let signature = message.signature.unwrap_or_else(|| format!("({name} ..)"));
            let said: Vec<String> =
                message.from.into_iter().chain(message.said_by.iter().map(|goal| format!("`{goal}`"))).collect();
            format!("| `{signature}` | {} |", said.join(", "))
        });
        table("Messages", "| message | sent by |", rows.collect());
        table("State variables", "| state variable | unit | type | library |", self.variables);
        table("Resources", "| resource | library |", self.resources);
        table("Goals", "| goal | served by | library |", self.goals);
        table("Functions", "| function | parameters | library |", self.functions);
    }
}

fn note(list: &mut Vec<String>, goal: &str) {
    if !list.iter().any(|known| known == goal) {
        list.push(goal.to_string());
    }
}

fn each_list(datum: &Datum, visit: &mut dyn FnMut(&Datum)) {
    if let DatumKind::List(items) = &datum.kind {
        visit(datum);
        items.iter().for_each(|item| each_list(item, visit));
    }
}
