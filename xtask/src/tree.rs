//! The project's texts, read once: all rules use this list.

use std::fs;
use std::path::Path;

/// Folders that hold nothing written by hand.
const SKIPPED_FOLDERS: &[&str] =
    &["target", "node_modules", "dist", ".git", ".venv", "test-results", "playwright-report", "__pycache__"];
/// Name of folders with pictures and their data.
const PICTURES: &str = "pictures";
/// Endings of texts that rules check.
const ENDINGS: &[&str] = &[".rs", ".toml", ".md", ".pdl", ".ts", ".svelte", ".mjs", ".py", ".pyi", ".tsv"];

/// One text of the project.
#[derive(Clone, Debug)]
pub(crate) struct Text {
    /// Path from the project's top folder, with `/`.
    pub(crate) path: String,
    /// The whole text.
    pub(crate) body: String,
}

impl Text {
    /// Returns a text for a rule's own tests.
    #[cfg(test)]
    pub(crate) fn sample(path: &str, body: &str) -> Text {
        Text { path: path.into(), body: body.into() }
    }
}

/// Returns all texts below `root`, in order of path.
///
/// # Errors
/// The file or folder that cannot be read.
pub(crate) fn read(root: &Path) -> Result<Vec<Text>, String> {
    let chosen = names(root)?.into_iter().filter(|path| {
        ENDINGS.iter().any(|ending| path.ends_with(ending)) && !path.split('/').any(|folder| folder == PICTURES)
    });
    let read = |path: String| match fs::read_to_string(root.join(&path)) {
        Ok(body) => Ok(Text { path, body }),
        Err(error) => Err(format!("cannot read {path}: {error}")),
    };
    chosen.map(read).collect()
}

/// Paths of all files below `root`, in order.
///
/// # Errors
/// The folder that cannot be read.
pub(crate) fn names(root: &Path) -> Result<Vec<String>, String> {
    let mut names = Vec::new();
    collect(root, "", &mut names)?;
    names.sort();
    Ok(names)
}

/// Returns the text at `path`, if there is one.
pub(crate) fn find<'a>(texts: &'a [Text], path: &str) -> Option<&'a Text> {
    texts.iter().find(|text| text.path == path)
}

/// Returns the names of the folders directly below `folder` that contain at least one text, in order.
pub(crate) fn folders_below(texts: &[Text], folder: &str) -> Vec<String> {
    let prefix = format!("{folder}/");
    let mut names: Vec<String> = texts
        .iter()
        .filter_map(|text| text.path.strip_prefix(&prefix))
        .filter_map(|rest| rest.split_once('/').map(|(name, _)| format!("{prefix}{name}")))
        .collect();
    names.sort();
    names.dedup();
    names
}

fn collect(folder: &Path, prefix: &str, names: &mut Vec<String>) -> Result<(), String> {
    let entries = fs::read_dir(folder).map_err(|error| format!("cannot read {}: {error}", folder.display()))?;
    for entry in entries {
        let entry = entry.map_err(|error| format!("cannot read {}: {error}", folder.display()))?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let kind = entry.file_type().map_err(|error| format!("cannot read {name}: {error}"))?;
        let path = format!("{prefix}{name}");
        if kind.is_dir() {
            if !SKIPPED_FOLDERS.contains(&name.as_str()) {
                collect(&entry.path(), &format!("{path}/"), names)?;
            }
        } else if kind.is_file() {
            names.push(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_listed_once() {
        let texts =
            [Text::sample("crates/a/x.rs", ""), Text::sample("crates/a/y.rs", ""), Text::sample("crates/z", "")];
        assert_eq!(folders_below(&texts, "crates"), ["crates/a"]);
    }
}
