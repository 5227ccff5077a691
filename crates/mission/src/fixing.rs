//! Applies the safe fixes to a program and the files that it requires, in passes.

use crate::error::MissionResult;
use crate::files::read_text;
use apex_pdl::{Applicability, Checked, Diagnostic, Fix, Severity};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Maximum number of passes. Each may uncover further mistakes.
const PASSES_MAX: usize = 20;
/// A text that may be changed.
pub struct Text {
    /// As it was read.
    pub before: String,
    /// With the fixes so far.
    pub now: String,
}

/// Applied fix, for the report.
pub struct Made {
    /// Place in the program.
    pub place: String,
    /// Code of the diagnostic.
    pub code: &'static str,
    /// Title of the fix.
    pub title: String,
}

/// A program while it is being fixed.
#[derive(Default)]
pub struct Program {
    /// Texts read from files, by the names that the program uses. Shipped libraries are not among them.
    pub texts: BTreeMap<PathBuf, Text>,
    /// The only text that is changed; `None` permits all.
    pub only: Option<PathBuf>,
    /// Applied fixes, in order.
    pub made: Vec<Made>,
}

/// A way to read a file of the program.
pub type Reader<'r> = &'r mut dyn FnMut(&Path) -> MissionResult<String>;

impl Program {
    /// Checks and fixes until no safe fix remains. A pass that increases the number of errors is undone, unless it fixed the text's
    /// structure: errors behind a missing `)` are visible only afterwards.
    ///
    /// # Errors
    /// A file cannot be read.
    pub fn mend(&mut self, mut check: impl FnMut(Reader<'_>) -> MissionResult<Checked>) -> MissionResult<Checked> {
        let mut checked = check(&mut |path| self.read(path))?;
        for _ in 0..PASSES_MAX {
            let Some((texts, made)) = self.fixed(&checked) else { break };
            let before: BTreeMap<PathBuf, String> =
                texts.into_iter().map(|(path, text)| (path.clone(), self.exchange(&path, text))).collect();
            let again = check(&mut |path| self.read(path))?;
            if errors(&again) > errors(&checked) {
                before.into_iter().for_each(|(path, text)| drop(self.exchange(&path, text)));
                break;
            }
            self.made.extend(made);
            checked = again;
        }
        Ok(checked)
    }

    fn read(&mut self, path: &Path) -> MissionResult<String> {
        if let Some(known) = self.texts.get(path) {
            return Ok(known.now.clone());
        }
        let text = read_text(path)?;
        self.texts.insert(path.to_path_buf(), Text { before: text.clone(), now: text.clone() });
        Ok(text)
    }

    fn exchange(&mut self, path: &Path, text: String) -> String {
        self.texts.get_mut(path).map(|known| std::mem::replace(&mut known.now, text)).unwrap_or_default()
    }

    /// Returns the texts after one pass, and the applied fixes; `None` if there is no safe fix.
    fn fixed(&self, checked: &Checked) -> Option<(BTreeMap<PathBuf, String>, Vec<Made>)> {
        let path_of = |file: u32| {
            let source = checked.library.sources.get(usize::try_from(file).ok()?)?;
            let path = PathBuf::from(&*source.name);
            let is_free = self.only.as_ref().is_none_or(|only| *only == path);
            (is_free && self.texts.contains_key(&path)).then_some(path)
        };
        let is_ours = |fix: &&Fix| fix.edits.iter().all(|edit| path_of(edit.file).is_some());
        let safe = |each: &'_ Diagnostic| -> Option<Fix> {
            let mut fixes = each.fixes.iter().filter(|fix| fix.applicability == Applicability::Safe);
            fixes.find(is_ours).cloned()
        };
        let candidates: Vec<(&Diagnostic, Fix)> =
            checked.diagnostics.iter().filter_map(|each| safe(each).map(|fix| (each, fix))).collect();
        let applied = apex_pdl::apply(&checked.library.sources, candidates.iter().map(|(_, fix)| fix));
        let texts: BTreeMap<PathBuf, String> =
            applied.texts.into_iter().filter_map(|(file, text)| Some((path_of(file)?, text))).collect();
        let made = applied.made.iter().filter_map(|number| candidates.get(*number)).map(|(each, fix)| Made {
            place: checked.library.describe_place(each.span.place()),
            code: each.code,
            title: fix.title.clone(),
        });
        (!texts.is_empty()).then(|| (texts, made.collect()))
    }
}

/// Returns the numbers of errors of the text's structure and of other errors.
fn errors(checked: &Checked) -> (usize, usize) {
    let errors = checked.diagnostics.iter().filter(|each| each.severity == Severity::Error);
    let (structure, others): (Vec<&Diagnostic>, Vec<&Diagnostic>) =
        errors.partition(|each| each.code.starts_with("E00"));
    (structure.len(), others.len())
}
