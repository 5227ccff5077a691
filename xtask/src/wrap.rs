//! `cargo xtask wrap PATH ..` wraps paragraphs and list items of Markdown that have a line of more than 140 columns.
//!
//! Tables, headings, quotations, HTML and code fences stay unchanged; code spans and links are never broken.

use crate::english::COLUMNS_MAX;
use crate::prose::ALLOW;
use regex::Regex;
use std::fs;
use std::path::Path;

/// A code span, link or comment with all adjacent characters, or a word.
const ATOM: &str = r"(?:`+[^`]*`+|!?\[[^\]]*\]\([^)]*\)|<!--.*?-->|\S)+";
/// The marker of a list item with the spaces around it.
const ITEM: &str = r"^\s*([-*+]|\d+[.)])\s+";
/// A line that begins with bold words begins a separate part.
const PART: &str = "**";
/// An atom that would begin another block at the start of a line.
const BLOCK_START: &str = r"^([-+*>#|]|\d+[.)]$)";

/// Wraps the Markdown files below `paths`, which are files or folders seen from `root`.
///
/// # Errors
/// A path that is not in the repository, or a file that cannot be read or written.
pub(crate) fn run(root: &Path, files: &[String], paths: &[&str]) -> Result<String, String> {
    let wrapper = Wrapper::new()?;
    let mut wrapped = Vec::new();
    for path in paths {
        let path = path.trim_end_matches('/');
        let below = |file: &&String| *file == path || file.starts_with(&format!("{path}/"));
        let mut found = files.iter().filter(below).peekable();
        if found.peek().is_none() {
            return Err(format!("`{path}` is not a file or folder of the repository"));
        }
        for file in found.filter(|file| file.ends_with(".md")) {
            let body = fs::read_to_string(root.join(file)).map_err(|error| format!("cannot read {file}: {error}"))?;
            let new = wrapper.wrap(&body);
            if new != body {
                fs::write(root.join(file), new).map_err(|error| format!("cannot write {file}: {error}"))?;
                wrapped.push(file.as_str());
            }
        }
    }
    Ok(format!("wrapped {} files {}", wrapped.len(), wrapped.join(" ")))
}

struct Wrapper {
    atom: Regex,
    item: Regex,
    block_start: Regex,
}

impl Wrapper {
    fn new() -> Result<Wrapper, String> {
        let compile = |pattern: &str| Regex::new(pattern).map_err(|error| error.to_string());
        Ok(Wrapper { atom: compile(ATOM)?, item: compile(ITEM)?, block_start: compile(BLOCK_START)? })
    }

    fn wrap(&self, body: &str) -> String {
        let (mut out, mut block) = (Vec::new(), Vec::new());
        let mut is_fenced = false;
        for line in body.split('\n') {
            let is_fence = line.trim_start().starts_with("```");
            is_fenced ^= is_fence;
            let stays = is_fenced || is_fence || is_fixed(line);
            if stays || self.item.is_match(line) || line.starts_with(PART) {
                self.flush(&mut block, &mut out);
            }
            if stays {
                out.push(line.to_string());
            } else {
                block.push(line);
            }
        }
        self.flush(&mut block, &mut out);
        out.join("\n")
    }

    /// Moves a finished block to `out`, wrapped if a line is too long and no line ends with a forced break.
    fn flush(&self, block: &mut Vec<&str>, out: &mut Vec<String>) {
        let is_long = |line: &&str| line.chars().count() > COLUMNS_MAX && !line.contains(ALLOW);
        let has_break = |line: &&str| line.ends_with("  ") || line.ends_with('\\');
        if block.iter().any(is_long) && !block.iter().any(has_break) {
            out.extend(self.refill(block));
        } else {
            out.extend(block.iter().map(ToString::to_string));
        }
        block.clear();
    }

    fn refill(&self, block: &[&str]) -> Vec<String> {
        let first = block.first().copied().unwrap_or_default();
        let marker = self.item.find(first).map_or("", |found| found.as_str());
        let margin = |line: &str| line.len() - line.trim_start().len();
        let indent = block.get(1).map_or(marker.len().max(margin(first)), |line| margin(line));
        let text = block.join(" ");
        let mut lines = Vec::new();
        let mut line = if marker.is_empty() { " ".repeat(margin(first)) } else { marker.to_string() };
        let mut is_empty = true;
        for atom in self.atom.find_iter(text.get(marker.len()..).unwrap_or_default()).map(|found| found.as_str()) {
            let is_full = line.chars().count() + 1 + atom.chars().count() > COLUMNS_MAX;
            if is_full && !is_empty && !self.block_start.is_match(atom) {
                lines.push(std::mem::replace(&mut line, " ".repeat(indent)));
                is_empty = true;
            }
            line.push_str(if is_empty { "" } else { " " });
            line.push_str(atom);
            is_empty = false;
        }
        lines.push(line);
        lines
    }
}

/// Returns true for a blank line, a row of a table, a heading, a quotation or HTML.
fn is_fixed(line: &str) -> bool {
    let text = line.trim_start();
    text.is_empty() || text.starts_with(['|', '#', '>']) || line.starts_with('<')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wrapped(body: &str) -> String {
        Wrapper::new().unwrap().wrap(body)
    }

    #[test]
    fn paragraphs_and_items_are_wrapped_with_their_indent() {
        let words = "word ".repeat(40);
        let found = wrapped(&format!("{words}\n\n- {words}\n- short\n"));
        let lines: Vec<&str> = found.lines().collect();
        assert!(lines.iter().all(|line| line.chars().count() <= COLUMNS_MAX), "{found}");
        assert_eq!(lines.len(), 6, "{found}");
        assert!(lines[3].starts_with("- word") && lines[4].starts_with("  word") && lines[5] == "- short", "{found}");
        assert_eq!(wrapped(&found), found);
    }

    #[test]
    fn bold_words_at_the_start_of_a_line_stay_there() {
        let words = "word ".repeat(40);
        let found = wrapped(&format!("{words}\n**Part.** {words}\n"));
        assert!(found.lines().any(|line| line.starts_with("**Part.** word")), "{found}");
    }

    #[test]
    fn spans_stay_whole_and_fixed_lines_as_they_are() {
        let span = format!("{} `a b c d e f g h i j k l m`", "x".repeat(120));
        assert!(wrapped(&span).ends_with("\n`a b c d e f g h i j k l m`"), "{}", wrapped(&span));
        let words = "word ".repeat(40);
        for fixed in [format!("| {words}|\n"), format!("```\n{words}\n```\n"), format!("# {words}\n"), "a\nb\n".into()]
        {
            assert_eq!(wrapped(&fixed), fixed);
        }
    }
}
