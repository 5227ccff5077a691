//! Measures how implausible a balanced form is as PDL: misplaced items, and lines that contradict their indentation. Used only to choose
//! among repairs; lowering decides the meaning of a form.

use crate::suggest::{is_certain, near};
use crate::vocabulary::{FORMS, PRIMITIVE_CLAUSES, PROCEDURE_CLAUSES, STEP_CLAUSES};
use apex_model::builtins::built_in;

/// A token that matters for structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Piece<'t> {
    pub(super) kind: PieceKind,
    pub(super) text: &'t str,
    pub(super) start: usize,
    /// Length in the text as written, in bytes.
    pub(super) length: usize,
    /// Column from 1, if it is the first item of its line.
    pub(super) first_column: Option<usize>,
    pub(super) column: usize,
    pub(super) line: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PieceKind {
    Open,
    Close,
    Other,
}

/// Cost of an item that cannot occur in its place.
const MISPLACED: usize = 4;
/// Cost of a line whose indentation contradicts its nesting.
const MISALIGNED: usize = 3;
/// Cost of a function with too few or too many arguments; the word may also belong to a goal.
const ARITY: usize = 1;

/// Returns true for a form that occurs only at the top level. An agent occurs in applications too.
pub(super) fn is_form(word: &str) -> bool {
    FORMS.contains(&word) && word != "agent"
}

/// Returns the clause or form that this misspelt word certainly means; `None` if the word itself is one, or is a function.
pub(super) fn clause_meant(word: &str) -> Option<&'static str> {
    let known = || STEP_CLAUSES.iter().chain(PROCEDURE_CLAUSES).chain(PRIMITIVE_CLAUSES).chain(FORMS).copied();
    if built_in(word).is_some() || known().any(|name| name == word) {
        return None;
    }
    let found = near(word, known());
    found.first().filter(|_| is_certain(word, &found)).map(|first| first.name)
}

/// Returns true if this is a clause that only steps have.
fn of_steps(word: &str) -> bool {
    STEP_CLAUSES.contains(&word) && !of_procedures(word)
}

/// Returns true if this is a clause of procedures or primitives.
fn of_procedures(word: &str) -> bool {
    PROCEDURE_CLAUSES.contains(&word) || PRIMITIVE_CLAUSES.contains(&word)
}

/// Clauses that contain conditions.
const AROUND_CONDITIONS: &[&str] = &[
    "waitfor",
    "end-when",
    "terminate",
    "when",
    "until",
    "restart",
    "restart-when",
    "resume",
    "resume-when",
    "suspend",
    "suspend-when",
    ":and",
    ":or",
    ":not",
    ":in-order",
];
const EPISODES: &[&str] = &[":episode", ":measurement", ":estimation"];

/// A list that is open.
struct List<'t> {
    head: &'t str,
    column: usize,
    /// Column of the first item that begins a line.
    body: Option<usize>,
    items: usize,
    lists: usize,
    atoms_after_list: usize,
}

/// Returns the cost of a sequence of pieces; 0 for a plausible form. Unmatched parentheses cost more than anything else.
pub(super) fn cost<'t>(pieces: impl Iterator<Item = Piece<'t>>) -> usize {
    let mut stack: Vec<List<'t>> = Vec::new();
    let mut cost = 0;
    let mut previous_open = false;
    for piece in pieces {
        if piece.kind != PieceKind::Close {
            cost += misaligned(&piece, &mut stack);
        }
        match piece.kind {
            PieceKind::Open => {
                if let Some(parent) = stack.last_mut() {
                    parent.items += 1;
                    parent.lists += 1;
                }
                let column = piece.column;
                stack.push(List { head: "", column, body: None, items: 0, lists: 0, atoms_after_list: 0 });
            }
            PieceKind::Close => match stack.pop() {
                Some(list) => cost += closed(&list),
                None => cost += 1000,
            },
            PieceKind::Other if previous_open => {
                let parent =
                    stack.len().checked_sub(2).and_then(|at| stack.get(at)).map(|list| (list.head, list.items));
                cost += headed(piece.text, parent);
                if let Some(list) = stack.last_mut() {
                    list.head = piece.text;
                }
            }
            PieceKind::Other => cost += item(piece.text, stack.last_mut()),
        }
        previous_open = piece.kind == PieceKind::Open;
    }
    cost + 1000 * stack.len()
}

/// Returns the cost of a line whose first column contradicts its list.
fn misaligned(piece: &Piece<'_>, stack: &mut [List<'_>]) -> usize {
    let Some(column) = piece.first_column else { return 0 };
    let Some(list) = stack.last_mut() else { return if column > 1 { MISALIGNED } else { 0 } };
    if column <= list.column {
        return MISALIGNED;
    }
    let body = *list.body.get_or_insert(column);
    if body == column { 0 } else { MISALIGNED }
}

/// Returns the cost of a list with head `head` inside a list with the head and the number of items (itself included) in `parent`.
fn headed(head: &str, parent: Option<(&str, usize)>) -> usize {
    let Some((outer, items)) = parent else {
        return if is_form(head) || head == "agent" { 0 } else { MISPLACED };
    };
    let fits = match outer {
        "procedure" | "primitive" | "solver" if items > 1 || of_procedures(head) => of_procedures(head),
        "step" if items > 2 => of_steps(head) || (of_procedures(head) && !matches!(head, "step" | "index")),
        _ if is_form(head) || matches!(head, "step" | "index") || of_steps(head) => outer == "step" && of_steps(head),
        _ if EPISODES.contains(&head) || matches!(head, ":and" | ":or" | ":not" | ":in-order") => {
            AROUND_CONDITIONS.contains(&outer)
        }
        _ => true,
    };
    if fits { 0 } else { MISPLACED }
}

/// Returns the cost of an item that is not a list and not the first item of its list.
fn item(text: &str, list: Option<&mut List<'_>>) -> usize {
    let Some(list) = list else { return MISPLACED };
    let after_list = list.lists > 0;
    list.items += 1;
    list.atoms_after_list += usize::from(after_list);
    let fits = match list.head {
        "procedure" | "primitive" => text.starts_with(':') && !after_list,
        "step" => list.items == 1 || (after_list && (text == "=>" || text.starts_with('?'))),
        _ if matches!(text, ":value" | ":timing" | ":quality") => EPISODES.contains(&list.head),
        _ if matches!(text, ":unit" | ":rate" | ":derived" | ":join") => list.head == "state-variable",
        _ => !(of_steps(text) || is_form(text) || matches!(text, "step" | "index")),
    };
    if fits { 0 } else { MISPLACED }
}

/// Returns the cost of a list that has ended: for items that it lacks or has too many.
fn closed(list: &List<'_>) -> usize {
    let exactly = |count: usize| if list.items == count { 0 } else { MISPLACED };
    match list.head {
        "index" => exactly(1) + if list.lists == 1 { 0 } else { MISPLACED },
        "step" if list.lists == 0 => MISPLACED,
        "end" | "duration" | "inform" | "return" | "rank" => exactly(1),
        "waitfor" | "profile" | "on-start" | "procedure" | "primitive" if list.items == 0 => MISPLACED,
        "select" | "defindexical" | "defconstant" => exactly(2),
        "forall" => exactly(3),
        "if" if list.items < 2 => ARITY,
        "defun" if list.items < 3 => MISPLACED,
        "command" if list.lists != 1 => MISPLACED,
        "require-apex-library" | "in-apex-bundle" => exactly(1),
        head => match built_in(head) {
            Some(function) if list.items < function.arguments_min => ARITY,
            Some(function) if function.arguments_max.is_some_and(|most| list.items > most) => ARITY,
            _ => 0,
        },
    }
}
