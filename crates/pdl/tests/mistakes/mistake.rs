//! One mistake: a changed text, and the lines on which a message about it is right.

use super::program::Program;
use super::tree::line_of;
use std::ops::Range;

/// A mistake made in one text.
pub struct Mistake {
    pub text: String,
    /// Lines of that text at which the message may be; several if two places contradict each other and either may be wrong.
    pub lines: Vec<u32>,
    /// Permitted lines in other files of the program.
    pub elsewhere: Vec<(String, u32)>,
    /// Description of the change, for reports.
    pub what: String,
}

/// Replaces one range. The permitted line is that of the change.
pub fn replace(program: &Program<'_>, range: Range<usize>, by: &str) -> Mistake {
    let was = &program.text[range.clone()];
    let what = format!("{} -> {}", shown(was), shown(by));
    let line = line_of(program.text, range.start);
    replaced(program, &[(range, by.to_string())], vec![line], what)
}

/// Replaces several ranges; `lines` are those of the text before.
pub fn replaced(program: &Program<'_>, edits: &[(Range<usize>, String)], lines: Vec<u32>, what: String) -> Mistake {
    let mut edits = edits.to_vec();
    edits.sort_by_key(|(range, _)| std::cmp::Reverse(range.start));
    let mut text = program.text.to_string();
    for (range, by) in edits {
        text.replace_range(range, &by);
    }
    Mistake { text, lines, elsewhere: Vec::new(), what }
}

/// Removes a range and, with it, a line that becomes empty.
pub fn remove(program: &Program<'_>, range: Range<usize>, what: &str) -> Mistake {
    let mut range = range;
    let before = program.text[..range.start].trim_end().len();
    // Text before the range keeps its line; the blanks in between are removed too.
    range.start = before;
    let what = format!("{what}: {}", shown(&program.text[range.clone()]));
    let line = line_of(program.text, before);
    let mut text = program.text.to_string();
    text.replace_range(range, "");
    Mistake { text, lines: vec![line], elsewhere: Vec::new(), what }
}

fn shown(text: &str) -> String {
    let line = text.trim().lines().next().unwrap_or_default();
    if line.is_empty() { "nothing".to_string() } else { format!("`{line}`") }
}
