//! `apex check --fix`: makes the safe fixes, pass after pass, and says what is left.

use super::check;
use crate::options::CheckOptions;
use crate::trouble::{Outcome, Trouble};
use crate::{output, replacing, sources};
use apex_mission::error::MissionResult;
use apex_mission::files::read_text;
use apex_pdl::{Applicability, Checked, Diagnostic, Fix, Severity, SourceText};
use similar::TextDiff;
use std::collections::BTreeMap;
use std::io::{IsTerminal, Read};
use std::path::{Path, PathBuf};

/// Passes over one program: a fix may uncover the next mistake, but not for ever.
const PASSES_MAX: usize = 20;
/// The file name that means standard input.
const STANDARD_INPUT: &str = "-";

/// A text that may be changed.
struct Text {
    before: String,
    now: String,
}

/// What was done, for the report.
struct Made {
    place: String,
    code: &'static str,
    title: String,
}

/// A program while it is mended.
#[derive(Default)]
struct Program {
    /// Texts read from files, by the name that the program knows them by. What ships with the command is not among them.
    texts: BTreeMap<PathBuf, Text>,
    /// Only this text is changed; none allows all of them.
    only: Option<PathBuf>,
    made: Vec<Made>,
}

/// Fixes each program by itself, with the files that it requires.
pub fn run(options: &CheckOptions) -> Outcome {
    let mut wrong = false;
    for file in &options.files {
        wrong |=
            if file.as_os_str() == STANDARD_INPUT { fix_standard_input(options)? } else { fix_files(file, options)? };
    }
    if wrong { Err(Trouble::told()) } else { Ok(()) }
}

/// Fixes a program and writes its files; true if errors are left.
fn fix_files(file: &Path, options: &CheckOptions) -> Outcome<bool> {
    let mut program = Program::default();
    let checked = program.mend(|read| sources::check_program_with(file, options.fragment, read))?;
    for (path, text) in program.texts.iter().filter(|(_, text)| text.before != text.now) {
        if options.dry_run {
            output::print(difference(&path.display().to_string(), text))?;
        } else {
            replacing::replace(path, &text.before, &text.now)?;
        }
    }
    let name = sources::program_path(file).display().to_string();
    if options.dry_run {
        // Standard output is the difference, for `patch`.
        output::complain(program.summary(&name, &checked, true));
    } else {
        program.report(&checked, options)?;
        if !options.json {
            output::print_line(program.summary(&name, &checked, false))?;
        }
    }
    Ok(checked.has_errors())
}

/// Fixes standard input to standard output; messages go to standard error.
fn fix_standard_input(options: &CheckOptions) -> Outcome<bool> {
    let mut text = String::new();
    std::io::stdin()
        .read_to_string(&mut text)
        .map_err(|error| Trouble::user("cannot read standard input").because(error))?;
    let name = PathBuf::from("<standard input>");
    // What it requires is read from files, which are not ours to change here.
    let mut program = Program { only: Some(name.clone()), ..Program::default() };
    program.texts.insert(name.clone(), Text { before: text.clone(), now: text });
    let checked = program.mend(|read| {
        let text = read(&name)?;
        let source = SourceText { name: name.display().to_string(), text };
        Ok(sources::check_text_with(source, Path::new(""), options.fragment, read))
    })?;
    let Some(text) = program.texts.get(&name) else { return Ok(checked.has_errors()) };
    output::print(if options.dry_run { difference(STANDARD_INPUT, text) } else { text.now.clone() })?;
    let rendered = apex_pdl::render(&checked.diagnostics, &checked.library.sources, std::io::stderr().is_terminal());
    output::complain(rendered.trim_end_matches('\n'));
    output::complain(program.summary("standard input", &checked, options.dry_run));
    Ok(checked.has_errors())
}

/// A way to read a file of the program.
type Reader<'r> = &'r mut dyn FnMut(&Path) -> MissionResult<String>;

impl Program {
    /// Checks and fixes until nothing safe is left to fix. A pass that leaves more errors than it found is taken back,
    /// unless it mended the text's structure: what was wrong behind a missing `)` is seen only then.
    fn mend(&mut self, mut check: impl FnMut(Reader<'_>) -> MissionResult<Checked>) -> MissionResult<Checked> {
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

    /// The texts after one pass, and what was done; none when there is nothing safe to do.
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

    fn report(&self, checked: &Checked, options: &CheckOptions) -> Outcome {
        for made in &self.made {
            if options.json {
                output::print_line(serde_json::json!({ "fixed": made.title, "code": made.code, "place": made.place }))?;
            } else {
                output::print_line(format_args!("fixed {} [{}]: {}", made.place, made.code, made.title))?;
            }
        }
        check::print(checked, options.json)
    }

    fn summary(&self, name: &str, checked: &Checked, dry: bool) -> String {
        let count = self.made.len();
        let fixes = if count == 1 { "1 fix" } else { &format!("{count} fixes") };
        let done = if dry { "possible" } else { "made" };
        format!("{name}: {fixes} {done}; {}", check::summary(checked))
    }
}

/// Errors of the text's structure, and the others.
fn errors(checked: &Checked) -> (usize, usize) {
    let errors = checked.diagnostics.iter().filter(|each| each.severity == Severity::Error);
    let (structure, others): (Vec<&Diagnostic>, Vec<&Diagnostic>) =
        errors.partition(|each| each.code.starts_with("E00"));
    (structure.len(), others.len())
}

/// The change of a text as a unified difference.
fn difference(name: &str, text: &Text) -> String {
    TextDiff::from_lines(&text.before, &text.now).unified_diff().header(name, name).to_string()
}
