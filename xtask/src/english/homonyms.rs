//! One type name for one thing: a name that three or more modules define is a homonym.

use crate::finding::Finding;
use crate::mask;
use crate::prose::ALLOW;
use crate::tree::Text;
use std::collections::BTreeMap;

pub(super) const RULE: &str = "homonyms";
/// Modules that may define the same name.
const MODULES_MAX: usize = 2;
const KEYWORDS: &[&str] = &["struct", "enum", "trait", "type", "union"];

/// Finds every definition of a type name that more than [`MODULES_MAX`] modules define; tests are excluded.
pub(super) fn check(texts: &[Text]) -> Vec<Finding> {
    let mut definitions: BTreeMap<String, Vec<(&str, usize)>> = BTreeMap::new();
    for text in texts.iter().filter(|text| text.path.ends_with(".rs") && !is_test(&text.path)) {
        for (line, name) in types(&text.body) {
            definitions.entry(name).or_default().push((&text.path, line));
        }
    }
    let homonyms = definitions.into_iter().filter(|(_, places)| places.len() > MODULES_MAX);
    let finding = |name: &str, (path, line): (&str, usize)| {
        Finding::new(path, line, RULE, format!("`{name}` is the name of types in three or more modules"))
    };
    homonyms.flat_map(|(name, places)| places.into_iter().map(move |place| finding(&name, place))).collect()
}

fn is_test(path: &str) -> bool {
    path.starts_with("spec/") || path.split('/').any(|part| matches!(part, "tests" | "tests.rs" | "examples"))
}

/// Returns lines and names of the types that a text defines outside functions, implementations and its unit tests.
fn types(body: &str) -> Vec<(usize, String)> {
    let code = mask::code_only(body);
    let mut found = Vec::new();
    for (index, (code, line)) in code.lines().zip(body.lines()).enumerate() {
        if code.starts_with("mod tests") {
            break;
        }
        if let Some(name) = defined(code)
            && !line.contains(ALLOW)
        {
            found.push((index + 1, name.to_string()));
        }
    }
    found
}

/// Returns the name of the type that a line without indentation defines.
fn defined(line: &str) -> Option<&str> {
    let visible = line.strip_prefix("pub").unwrap_or(line);
    let visible = visible.strip_prefix('(').and_then(|rest| rest.split_once(')')).map_or(visible, |(_, rest)| rest);
    let (keyword, rest) = visible.trim_start_matches(' ').split_once(' ')?;
    let is_indented = line.starts_with(' ');
    let name = rest.split(|c: char| !c.is_alphanumeric() && c != '_').next()?;
    (!is_indented && KEYWORDS.contains(&keyword) && !name.is_empty()).then_some(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(bodies: &[(&str, &str)]) -> Vec<String> {
        let texts: Vec<Text> = bodies.iter().map(|(path, body)| Text::sample(path, body)).collect();
        check(&texts).into_iter().map(|finding| finding.path).collect()
    }

    #[test]
    fn a_name_in_three_modules_is_found_in_each() {
        let one = "pub(crate) struct Place {}\n";
        assert!(names(&[("a.rs", one), ("b.rs", one)]).is_empty());
        assert_eq!(names(&[("a.rs", one), ("b.rs", "enum Place {}\n"), ("c.rs", "pub type Place = u8;\n")]).len(), 3);
    }

    #[test]
    fn tests_members_and_comments_do_not_count() {
        let one = "struct Place;\n";
        let rest = "impl A {\n    type Place = u8;\n}\n// struct Place;\nmod tests {\n}\nstruct Place;\n";
        assert!(names(&[("a.rs", one), ("b.rs", one), ("c.rs", rest), ("c/tests/d.rs", one)]).is_empty());
        assert!(names(&[("a.rs", one), ("b.rs", one), ("c.rs", "struct Place; // english: allow\n")]).is_empty());
    }
}
