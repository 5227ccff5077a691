//! The prose of a text: comments and string literals of code, and Markdown outside code fences, line by line.

use crate::mask;
use crate::tree::Text;
use regex::Regex;
use std::sync::LazyLock;

/// Exempts its line from the rules for texts.
pub(crate) const ALLOW: &str = "english: allow";
/// Comments and literals of TypeScript and Svelte within one line; short literals in single quotes are rarely prose.
const SCRIPT_PROSE: &str = r#"//.*|"(?:\\.|[^"\\])*"|'(?:\\.|[^'\\\n]){3,}'|`[^`\n]*`|/\*.*?\*/"#;

static SCRIPT: LazyLock<Option<Regex>> = LazyLock::new(|| Regex::new(SCRIPT_PROSE).ok());

/// Returns the lines of `text` that have prose, numbered from 1, with that prose.
pub(crate) fn lines(text: &Text) -> Vec<(usize, String)> {
    let ending = text.path.rsplit_once('.').map_or("", |(_, ending)| ending);
    let lines = match ending {
        "rs" => mask::prose_only(&text.body).lines().map(str::to_string).collect(),
        "md" => markdown(&text.body),
        "py" | "pyi" => python(&text.body),
        "ts" | "svelte" | "mjs" => text.body.lines().map(script).collect(),
        _ => Vec::new(),
    };
    let numbered = lines.into_iter().enumerate().map(|(index, line)| (index + 1, line));
    numbered.filter(|(_, line)| !line.trim().is_empty()).collect()
}

/// Returns Markdown with the lines of code fences emptied.
fn markdown(body: &str) -> Vec<String> {
    let mut fenced = false;
    let keep = |line: &str| {
        let fence = line.trim_start().starts_with("```");
        fenced ^= fence;
        if fenced || fence { String::new() } else { line.to_string() }
    };
    body.lines().map(keep).collect()
}

/// Returns lines of Python that hold a comment or belong to a documentation string.
fn python(body: &str) -> Vec<String> {
    let mut in_text = false;
    let keep = |line: &str| {
        let quotes = line.matches("\"\"\"").count();
        let prose = in_text || quotes > 0 || line.contains('#');
        in_text ^= quotes % 2 == 1;
        if prose { line.to_string() } else { String::new() }
    };
    body.lines().map(keep).collect()
}

fn script(line: &str) -> String {
    if line.trim_start().starts_with('*') {
        return line.to_string();
    }
    let found = SCRIPT.iter().flat_map(|pattern| pattern.find_iter(line));
    found.map(|each| each.as_str()).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(path: &str, body: &str) -> Vec<(usize, String)> {
        lines(&Text::sample(path, body)).into_iter().map(|(line, prose)| (line, prose.trim().to_string())).collect()
    }

    #[test]
    fn code_is_not_prose() {
        let rust = found("a.rs", "let told = 1; // one\n/* two\nthree */ told();\nf(\"four\", '5');\n");
        assert_eq!(rust.iter().map(|(line, _)| *line).collect::<Vec<_>>(), [1, 2, 3, 4]);
        assert!(rust.iter().all(|(_, prose)| !prose.contains("told")), "{rust:?}");
        assert_eq!(found("a.md", "one\n```\ntold\n```\ntwo\n"), [(1, "one".into()), (5, "two".into())]);
        assert_eq!(found("a.py", "told = 1\n# one\n\"\"\"two\nthree\"\"\"\ntold()\n").len(), 3);
        assert_eq!(found("a.ts", "told(\"one\") // two\n * three\ntold();\n").len(), 2);
        assert_eq!(found("a.toml", "# told\n"), []);
    }
}
