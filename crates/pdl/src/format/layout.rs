//! Line breaks: a form stays on one line if it fits, otherwise its parts are placed below each other.

use super::LINE_CHARACTERS_MAX;
use super::items::{DatumNode, Entry, Piece};

/// Returns the laid-out text of top-level entries, and the line of each step in it, from 1.
pub(super) fn lay_out(entries: &[Entry]) -> (String, Vec<u32>) {
    let mut page = Page { text: String::new(), column: 0, line: 1, line_ended: false, steps: Vec::new() };
    for (index, entry) in entries.iter().enumerate() {
        let trailing_comment = index > 0 && !entry.own_line && entry.node().is_none() && !page.line_ended;
        if trailing_comment {
            page.put(" ");
        } else if index > 0 {
            page.new_line(0, entry.blank_before);
        }
        page.entry(entry, 0);
    }
    if !entries.is_empty() {
        page.text.push('\n');
    }
    (page.text, page.steps)
}

fn line_breaks(text: &str) -> u32 {
    text.bytes().filter(|byte| *byte == b'\n').fold(0, |count, _| count + 1)
}

struct Page {
    text: String,
    /// Number of characters on the current line.
    column: usize,
    /// Number of the current line, from 1.
    line: u32,
    /// True if a `;` comment has been written: nothing may follow on this line.
    line_ended: bool,
    /// Lines on which steps begin.
    steps: Vec<u32>,
}

impl Page {
    fn put(&mut self, text: &str) {
        self.text.push_str(text);
        self.line += line_breaks(text);
        match text.rsplit_once('\n') {
            Some((_, last)) => self.column = last.chars().count(),
            None => self.column += text.chars().count(),
        }
    }

    fn new_line(&mut self, indent: usize, blank: bool) {
        self.text.push_str(if blank { "\n\n" } else { "\n" });
        self.line += 1 + u32::from(blank);
        self.text.extend(std::iter::repeat_n(' ', indent));
        self.column = indent;
        self.line_ended = false;
    }

    fn fits(&self, width: Option<usize>, trailing: usize) -> bool {
        width.is_some_and(|width| self.column + width + trailing <= LINE_CHARACTERS_MAX)
    }

    fn entry(&mut self, entry: &Entry, trailing: usize) {
        match &entry.piece {
            Piece::Datum(node) => self.node(node, trailing),
            Piece::LineComment(text) => {
                self.put(text);
                self.line_ended = true;
            }
            Piece::BlockComment(text) => self.put(text),
        }
    }

    /// Writes a datum; `trailing` characters will follow on its last line.
    fn node(&mut self, node: &DatumNode, trailing: usize) {
        match node {
            DatumNode::Atom(text) => self.put(text),
            DatumNode::Prefixed(prefix, inner) => {
                self.put(prefix);
                self.node(inner, trailing);
            }
            DatumNode::List(entries, width) => {
                if node.head().is_some_and(|head| head == "step") {
                    self.steps.push(self.line);
                }
                if self.fits(*width, trailing) && !always_broken(node, entries) {
                    self.flat(entries);
                } else {
                    self.broken(entries, node.head().as_deref().unwrap_or(""), trailing);
                }
            }
        }
    }

    fn flat(&mut self, entries: &[Entry]) {
        self.put("(");
        for (index, entry) in entries.iter().enumerate() {
            if index > 0 {
                self.put(" ");
            }
            match &entry.piece {
                Piece::Datum(DatumNode::List(inner, _)) => self.flat(inner),
                Piece::Datum(DatumNode::Prefixed(prefix, inner)) => {
                    self.put(prefix);
                    self.flat_node(inner);
                }
                _ => self.entry(entry, 0),
            }
        }
        self.put(")");
    }

    fn flat_node(&mut self, node: &DatumNode) {
        match node {
            DatumNode::List(entries, _) => self.flat(entries),
            DatumNode::Prefixed(prefix, inner) => {
                self.put(prefix);
                self.flat_node(inner);
            }
            DatumNode::Atom(text) => self.put(text),
        }
    }

    /// Lays out a form on several lines: its head and the items that belong to it on the first line, all others below.
    fn broken(&mut self, entries: &[Entry], head: &str, trailing: usize) {
        let start = self.column;
        let is_data = entries.first().and_then(Entry::node).is_none_or(|node| node.atom().is_none());
        let indent = start + if is_data { 1 } else { 2 };
        let header = header_count(entries, head);
        self.put("(");
        let mut aligned = indent;
        let mut option = false;
        for (index, entry) in entries.iter().enumerate() {
            let after = if index + 1 == entries.len() { trailing + 1 } else { 0 };
            let previous = index.checked_sub(1).and_then(|before| entries.get(before));
            let is_value = option && previous.is_some_and(takes_keyword);
            let leads = index >= header && !is_value && entry.node().is_some_and(leads);
            let place = match previous {
                None if entry.node().is_none() => BreakKind::SameLine,
                None => BreakKind::Here,
                Some(previous) => self.place(
                    entry,
                    previous,
                    Role { in_header: index < header, leads, is_value: option && !leads, after },
                ),
            };
            match place {
                BreakKind::Here => {}
                BreakKind::SameLine => self.put(" "),
                BreakKind::Aligned => self.new_line(aligned, entry.blank_before),
                BreakKind::Below => self.new_line(indent, entry.blank_before),
            }
            if leads {
                let column = self.column + entry.flat_width().unwrap_or(0) + 1;
                aligned = if column > LINE_CHARACTERS_MAX / 2 { indent + 2 } else { column };
            }
            option = leads;
            self.entry(entry, after);
        }
        if self.line_ended {
            self.new_line(indent, false);
        }
        self.put(")");
    }

    /// Returns the position of `entry` after `previous`.
    fn place(&self, entry: &Entry, previous: &Entry, role: Role) -> BreakKind {
        let Some(node) = entry.node() else {
            return if self.line_ended || entry.own_line { BreakKind::Below } else { BreakKind::SameLine };
        };
        if role.leads {
            return BreakKind::Below;
        }
        if self.line_ended {
            return BreakKind::Aligned;
        }
        let fits = self.fits(entry.flat_width().map(|width| width + 1), role.after);
        if role.is_value {
            // The value of an option begins on the option's line; if it must be broken, it is broken there.
            let start = self.column + 1 < LINE_CHARACTERS_MAX * 3 / 4;
            return if fits || start { BreakKind::SameLine } else { BreakKind::Aligned };
        }
        let is_long_list =
            node.atom().is_none() && node.flat_width().is_none_or(|width| width > LINE_CHARACTERS_MAX / 2);
        if role.in_header && (fits || is_long_list) {
            return BreakKind::SameLine;
        }
        let both_atoms = node.atom().is_some() && previous.node().is_some_and(|before| before.atom().is_some());
        if both_atoms && fits { BreakKind::SameLine } else { BreakKind::Aligned }
    }
}

/// Role of an entry in its list.
#[derive(Clone, Copy)]
struct Role {
    /// True if it may be on the first line.
    in_header: bool,
    /// True if the item is the keyword of an option.
    leads: bool,
    /// True if an option's keyword precedes it.
    is_value: bool,
    /// Number of characters that follow it on its line.
    after: usize,
}

#[derive(Clone, Copy, PartialEq)]
enum BreakKind {
    /// Directly after the opening parenthesis.
    Here,
    /// After a blank.
    SameLine,
    /// On a new line below the first value of the option to which it belongs; without an option like `Below`.
    Aligned,
    /// On a new line below the head.
    Below,
}

/// Returns true for atoms that stay with the item that follows them.
fn leads(node: &DatumNode) -> bool {
    node.is_keyword() || matches!(node.atom(), Some("=>" | ">>"))
}

/// Returns true for options whose value may be a keyword.
fn takes_keyword(entry: &Entry) -> bool {
    let name = entry.node().and_then(DatumNode::atom).map(str::to_lowercase);
    matches!(name.as_deref(), Some(":quality" | ":estimation" | ":type" | ":use-bundles"))
}

/// Returns true for forms that are easier to read on several lines even if they fit on one.
fn always_broken(node: &DatumNode, entries: &[Entry]) -> bool {
    let lists = |name: &str| {
        entries.iter().any(|entry| entry.node().and_then(DatumNode::head).is_some_and(|head| head == name))
    };
    match node.head().as_deref() {
        Some("procedure") => lists("step"),
        Some("primitive") => entries.len() > 2,
        Some("defapplication") => entries.len() > 2,
        _ => false,
    }
}

/// Forms that may have a tag as their first argument.
const TAGGED: &[&str] = &["step", ":episode", ":measurement", ":atomic-episode", ":cyclic"];

/// Returns the number of entries of a broken form that may be on its first line, the head included.
fn header_count(entries: &[Entry], head: &str) -> usize {
    let is_plain_atom = |entry: &Entry| entry.node().is_some_and(|node| node.atom().is_some() && !leads(node));
    let atoms = 1 + entries.iter().skip(1).take_while(|entry| is_plain_atom(entry)).count();
    match head {
        "procedure" => {
            1 + entries.iter().skip(1).take_while(|entry| entry.node().is_some_and(DatumNode::is_keyword)).count()
        }
        head if TAGGED.contains(&head) => {
            let result = entries.get(atoms + 1).and_then(Entry::node).and_then(DatumNode::atom) == Some("=>");
            atoms + if result { 3 } else { 1 }
        }
        "defun" => 3,
        "let" | "let*" | "lambda" | "if" | "when" | "unless" | "case" | "declare-command" | "declare-event"
        | "declare-function" | "state-variable" | "command" | "inform" | "solver" | "index" => atoms + 1,
        _ => atoms,
    }
}
