//! Pages on disk, and a page as text and fenced blocks, where blocks can be rewritten without changes to the rest.

use std::fs;
use std::path::{Path, PathBuf};

/// Returns all pages below the folder of this package, in order: the Markdown files in its folders. Files directly in it are about the
/// package.
pub fn files() -> Vec<PathBuf> {
    let entries = |folder: &Path| fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let folders = entries(Path::new(env!("CARGO_MANIFEST_DIR"))).filter(|path| path.is_dir());
    // A README describes a folder; it is not a page.
    let markdown = |path: &PathBuf| {
        path.extension().is_some_and(|extension| extension == "md")
            && path.file_stem().is_none_or(|stem| stem != "README")
    };
    let mut found: Vec<PathBuf> =
        folders.flat_map(|folder| entries(&folder).collect::<Vec<_>>()).filter(markdown).collect();
    found.sort();
    found
}

/// A fenced block of a page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// The first word after the opening fence: `pdl`, `inputs`, `options`, `trace`, `why`, `check`; may be empty.
    pub kind: String,
    /// The rest of that line: the question of a `why` block.
    pub argument: String,
    /// Line of the opening fence, from 1.
    pub line: usize,
    /// The lines between the fences, each with its line end.
    pub body: String,
}

/// Reads all blocks of a page in order. A block that is never closed reaches to the end.
pub fn blocks(text: &str) -> Vec<Block> {
    let mut found: Vec<Block> = Vec::new();
    let mut open = false;
    for (index, line) in text.lines().enumerate() {
        match (line.strip_prefix("```"), open) {
            (Some(info), false) => {
                let (kind, argument) = info.trim().split_once(' ').unwrap_or((info.trim(), ""));
                let (kind, argument) = (kind.to_string(), argument.trim().to_string());
                found.push(Block { kind, argument, line: index + 1, body: String::new() });
                open = true;
            }
            (Some(_), true) => open = false,
            (None, true) => {
                if let Some(block) = found.last_mut() {
                    block.body.push_str(line);
                    block.body.push('\n');
                }
            }
            (None, false) => {}
        }
    }
    found
}

/// Returns the page with new bodies for the blocks that open at the given lines.
pub fn rewrite(text: &str, bodies: &[(usize, String)]) -> String {
    let mut page = String::new();
    let mut skipping = false;
    for (index, line) in text.lines().enumerate() {
        if skipping && line.starts_with("```") {
            skipping = false;
        }
        if skipping {
            continue;
        }
        page.push_str(line);
        page.push('\n');
        if let Some((_, body)) = bodies.iter().find(|(opening, _)| *opening == index + 1) {
            page.push_str(body);
            skipping = true;
        }
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = "# A\n\nprose\n\n```pdl\n(a)\n(b)\n```\n\n```trace\n0s end\n```\nmore\n";

    #[test]
    fn blocks_know_kind_line_and_body() {
        let found = blocks(PAGE);
        assert_eq!(found.len(), 2);
        let program = Block { kind: "pdl".into(), argument: String::new(), line: 5, body: "(a)\n(b)\n".into() };
        assert_eq!(found[0], program);
        assert_eq!((found[1].kind.as_str(), found[1].line), ("trace", 10));
    }

    #[test]
    fn a_block_may_carry_a_question() {
        let found = blocks("```why take picture@2s\n```\n");
        assert_eq!((found[0].kind.as_str(), found[0].argument.as_str()), ("why", "take picture@2s"));
    }

    #[test]
    fn rewriting_changes_one_block_only() {
        let page = rewrite(PAGE, &[(10, "1s end\n2s end\n".into())]);
        assert_eq!(page, PAGE.replace("0s end", "1s end\n2s end"));
        assert_eq!(rewrite(PAGE, &[]), PAGE);
    }
}
