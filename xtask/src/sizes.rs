//! Sizes of files and functions: a file or function that is too large is split by service before anything is added.

use crate::finding::Finding;
use crate::mask;
use crate::tree::Text;

/// Lines above which a Rust file needs an entry in [`EXCUSED`].
const FILE_LINES_MAX: usize = 450;
/// Lines above which no excuse helps.
const FILE_LINES_HARD_MAX: usize = 900;
/// Lines of code in a function's body, without blank and comment lines.
const FUNCTION_LINES_MAX: usize = 70;

/// Files over [`FILE_LINES_MAX`] lines that are accepted, each with its reason. An entry that is not needed is a finding.
const EXCUSED: &[(&str, &str)] = &[];

/// Checks files and functions of all Rust texts.
pub(crate) fn check(texts: &[Text]) -> Vec<Finding> {
    let rust = texts.iter().filter(|text| text.path.ends_with(".rs"));
    rust.flat_map(|text| check_file(text, EXCUSED).into_iter().chain(check_functions(text))).collect()
}

fn check_file(text: &Text, excused: &[(&str, &str)]) -> Option<Finding> {
    let lines = text.body.lines().count();
    let excuse = excused.iter().any(|(path, _)| *path == text.path);
    let message = if lines > FILE_LINES_HARD_MAX {
        format!("{lines} lines, the hard stop is {FILE_LINES_HARD_MAX}: split it by service")
    } else if lines > FILE_LINES_MAX && !excuse {
        format!("{lines} lines, more than {FILE_LINES_MAX}: split it, or excuse it with a reason in xtask/src/sizes.rs")
    } else if lines <= FILE_LINES_MAX && excuse {
        format!("only {lines} lines: remove its excuse from xtask/src/sizes.rs")
    } else {
        return None;
    };
    Some(Finding::new(&text.path, 1, "file-size", message))
}

fn check_functions(text: &Text) -> Vec<Finding> {
    functions(&mask::code_only(&text.body))
        .into_iter()
        .filter(|function| function.code_lines > FUNCTION_LINES_MAX)
        .map(|function| {
            let message = format!(
                "fn {} has {} lines of code, more than {FUNCTION_LINES_MAX}: move leaves out, keep the decisions here",
                function.name, function.code_lines
            );
            Finding::new(&text.path, function.line, "function-size", message)
        })
        .collect()
}

struct FunctionSize {
    name: String,
    line: usize,
    code_lines: usize,
}

/// Returns every function with a body in masked Rust text.
fn functions(masked: &str) -> Vec<FunctionSize> {
    let lines: Vec<&str> = masked.lines().collect();
    let mut found = Vec::new();
    for (index, line) in lines.iter().enumerate() {
        if let Some(name) = function_name(line)
            && let Some(last) = body_end(&lines, index, line.find(&format!("fn {name}")).unwrap_or(0))
        {
            let body = lines.get(index + 1..last).unwrap_or_default();
            let code_lines = body.iter().filter(|line| !line.trim().is_empty()).count();
            found.push(FunctionSize { name: name.to_string(), line: index + 1, code_lines });
        }
    }
    found
}

/// Returns the name after `fn ` when the line begins a function.
fn function_name(line: &str) -> Option<&str> {
    let (before, after) = line.split_once("fn ")?;
    let begins_word = before.chars().next_back().is_none_or(|c| !c.is_alphanumeric() && c != '_');
    let name = after.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default();
    (begins_word && !name.is_empty()).then_some(name)
}

/// Returns the line on which the body that begins after column `from` of line `first` closes; `None` without a body.
fn body_end(lines: &[&str], first: usize, from: usize) -> Option<usize> {
    let (mut braces, mut others) = (0usize, 0i64);
    for (index, line) in lines.iter().enumerate().skip(first) {
        let skipped = if index == first { from } else { 0 };
        for (_, character) in line.char_indices().filter(|(column, _)| *column >= skipped) {
            match character {
                '{' => braces += 1,
                '}' if braces == 1 => return Some(index),
                '}' => braces = braces.checked_sub(1)?,
                '(' | '[' => others += 1,
                ')' | ']' => others -= 1,
                ';' if braces == 0 && others == 0 => return None,
                _ => {}
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn long_function(lines: usize) -> String {
        format!("//! x\nfn short() {{}}\n\nfn long(a: [u8; 3]) {{\n{}}}\n", "    work(\"{\");\n".repeat(lines))
    }

    #[test]
    fn a_long_function_is_named_with_its_line() {
        let found = check_functions(&Text::sample("a.rs", &long_function(71)));
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].line, 4);
        assert!(found[0].message.contains("fn long has 71"), "{}", found[0]);
    }

    #[test]
    fn seventy_lines_comments_and_blanks_are_fine() {
        let body = long_function(70).replacen("    work", "\n    // {\n    work", 5);
        assert_eq!(check_functions(&Text::sample("a.rs", &body)), []);
    }

    #[test]
    fn declarations_without_a_body_do_not_swallow_the_next() {
        let body = format!("trait A {{\n    fn declared(&self);\n}}\n{}", long_function(1));
        assert_eq!(functions(&mask::code_only(&body)).len(), 2);
    }

    #[test]
    fn long_files_need_an_excuse_and_short_ones_do_not() {
        let long = Text::sample("a.rs", &"//! x\n".repeat(451));
        assert!(check_file(&long, &[]).is_some());
        assert!(check_file(&long, &[("a.rs", "a table")]).is_none());
        assert!(check_file(&Text::sample("a.rs", &"\n".repeat(901)), &[("a.rs", "a table")]).is_some());
        assert!(check_file(&Text::sample("a.rs", "//! x\n"), &[("a.rs", "a table")]).is_some());
    }
}
