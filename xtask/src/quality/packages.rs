//! Third-party packages: licences from `cargo metadata`, and bills of materials (CycloneDX).

use super::rows;
use crate::workspace::Workspace;
use serde::Deserialize;
use std::collections::BTreeMap;

/// The part of a bill of materials that the page counts.
#[derive(Deserialize)]
struct Bom {
    #[serde(rename = "bomFormat")]
    format: String,
    #[serde(rename = "specVersion")]
    version: String,
    components: Vec<serde_json::Value>,
}

/// Returns a line about the bill of materials in the file `name`.
///
/// # Errors
/// The text is not a bill of materials.
pub(super) fn bom(name: &str, json: &str) -> Result<String, String> {
    let bom: Bom = serde_json::from_str(json).map_err(|error| format!("{name}: {error}"))?;
    Ok(format!("- `{name}`: {} {}, {} components\n", bom.format, bom.version, bom.components.len()))
}

/// Returns a table of licence expressions with the number of packages of each.
pub(super) fn licences(workspace: &Workspace) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for package in &workspace.foreign {
        *counts.entry(package.license.as_deref().unwrap_or("none stated")).or_default() += 1;
    }
    let lines: Vec<String> = counts.iter().map(|(licence, count)| format!("{licence}\t{count}")).collect();
    let total = format!("all\t{}", workspace.foreign.len());
    rows::table(&["licence", "packages"], &(lines.join("\n") + "\n" + &total))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace::Foreign;

    #[test]
    fn components_of_a_bill_are_counted() {
        let json = r#"{"bomFormat": "CycloneDX", "specVersion": "1.5", "components": [{}, {}]}"#;
        assert_eq!(bom("a.cdx.json", json), Ok("- `a.cdx.json`: CycloneDX 1.5, 2 components\n".to_string()));
        assert!(bom("a.cdx.json", "[]").is_err_and(|message| message.starts_with("a.cdx.json: ")));
    }

    #[test]
    fn packages_are_counted_by_licence() {
        let package = |name: &str, license: Option<&str>| Foreign {
            name: name.into(),
            version: "1.0.0".into(),
            license: license.map(str::to_string),
            source: "registry".into(),
        };
        let foreign = vec![package("a", Some("MIT")), package("b", Some("MIT")), package("c", None)];
        let text = licences(&Workspace { members: Vec::new(), foreign });
        assert!(text.contains("| MIT | 2 |\n| none stated | 1 |\n| all | 3 |\n"), "{text}");
    }
}
