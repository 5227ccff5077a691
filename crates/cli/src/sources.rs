//! Finding and checking PDL: files, shipped libraries, host function signatures, diagnostics on the terminal.

use crate::output;
use crate::trouble::{Outcome, Trouble, read_text};
use apex_executive::Agent;
use apex_model::host::HostFunctions;
use apex_model::library::{AgentDeclaration, Library};
use apex_model::source::SourceFile;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_pdl::{Checked, CheckedConditions, HostSignature, Requirement, SourceText};
use rust_embed::RustEmbed;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The PDL libraries that ship with the product.
#[derive(RustEmbed)]
#[folder = "../../library"]
#[include = "*.pdl"]
struct Shipped;

/// Signatures of the functions that the command registers for PDL.
pub fn host_signatures() -> Vec<HostSignature> {
    apex_geo::functions::host_signatures().into_iter().map(HostSignature::pure).collect()
}

/// The functions that the command registers for PDL.
pub fn host_functions() -> HostFunctions {
    apex_geo::functions::host_functions()
}

/// `mission.pdl` in a folder, or the file itself.
pub fn program_path(path: &Path) -> PathBuf {
    if path.is_dir() { path.join("mission.pdl") } else { path.to_path_buf() }
}

/// Checks one program with everything it requires; relative requirements are looked for beside it.
///
/// # Errors
/// The program cannot be read. Mistakes inside are diagnostics of the result.
pub fn check_program(path: &Path, fragment: bool) -> Outcome<Checked> {
    check_program_with(path, fragment, &mut read_text)
}

/// As [`check_program`], reading files through `read`. A source that was read so is named by its path.
///
/// # Errors
/// As [`check_program`].
pub fn check_program_with(
    path: &Path,
    fragment: bool,
    read: &mut dyn FnMut(&Path) -> Outcome<String>,
) -> Outcome<Checked> {
    let path = program_path(path);
    let text = read(&path)?;
    let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
    Ok(check_text_with(SourceText { name: path.display().to_string(), text }, &folder, fragment, read))
}

/// Checks a text that requires files of `folder`, reading them through `read`. What cannot be read is a diagnostic of the result.
pub fn check_text_with(
    source: SourceText,
    folder: &Path,
    fragment: bool,
    read: &mut dyn FnMut(&Path) -> Outcome<String>,
) -> Checked {
    check_sources(vec![source], fragment, &mut |requirement| resolve(folder, requirement, read))
}

/// Checks texts, asking `resolve` for everything they require.
pub fn check_sources(
    sources: Vec<SourceText>,
    fragment: bool,
    resolve: &mut dyn FnMut(Requirement) -> Result<SourceText, String>,
) -> Checked {
    let host = host_signatures();
    let mut checked = apex_pdl::check(sources, apex_pdl::CheckOptions { fragment, host: &host, resolve });
    if !fragment && !checked.has_errors() && !checked.library.constants.is_empty() {
        let library = Arc::new(checked.library.clone());
        apex_pdl::report_constants(&mut checked, apex_executive::failing_constants(&library, host_functions()));
    }
    checked
}

/// Checks texts that require files of `folder`, or one another.
pub fn check_texts(texts: Vec<SourceText>, folder: &Path) -> Checked {
    let known = texts.clone();
    check_sources(texts, false, &mut |requirement| resolve_among(&known, folder, requirement))
}

/// Checks conditions in terms of what `texts` declare.
pub fn check_conditions(texts: Vec<SourceText>, conditions: Vec<SourceText>, folder: &Path) -> CheckedConditions {
    let host = host_signatures();
    let known = texts.clone();
    let resolve = &mut |requirement| resolve_among(&known, folder, requirement);
    apex_pdl::check_conditions(texts, conditions, apex_pdl::CheckOptions { fragment: false, host: &host, resolve })
}

/// A required text among `known` ones, else beside them, else one that ships.
fn resolve_among(known: &[SourceText], folder: &Path, requirement: Requirement) -> Result<SourceText, String> {
    let wanted = match &requirement {
        Requirement::File { name, .. } => name.clone(),
        Requirement::Library(name) => format!("{name}.pdl"),
    };
    match known.iter().find(|text| Path::new(&text.name).ends_with(&wanted)) {
        Some(text) => Ok(text.clone()),
        None => resolve(folder, requirement, &mut read_text),
    }
}

/// Checks a program, prints its diagnostics and returns its library if it has no errors.
///
/// # Errors
/// The program cannot be read or has errors; they have been printed.
pub fn load_program(path: &Path) -> Outcome<Arc<Library>> {
    let checked = check_program(path, false)?;
    print_warnings_and_errors(&checked);
    if checked.has_errors() { Err(Trouble::told()) } else { Ok(Arc::new(checked.library)) }
}

/// Prints what a person who runs the program must know: not the notes.
pub fn print_warnings_and_errors(checked: &Checked) {
    let serious: Vec<_> =
        checked.diagnostics.iter().filter(|each| each.severity != apex_pdl::Severity::Note).cloned().collect();
    if !serious.is_empty() {
        let rendered = apex_pdl::render(&serious, &checked.library.sources, std::io::stderr().is_terminal());
        output::complain(rendered.trim_end_matches('\n'));
    }
}

/// Loads the program stored in a flight record, for replay and explanations. What the program requires is looked for
/// among the recorded texts only, so a record explains itself wherever it is.
///
/// # Errors
/// A sentence when the stored sources no longer check, which means that another version wrote the record.
pub fn load_recorded(sources: &[SourceFile]) -> Result<(Arc<Library>, AgentDeclaration, HostFunctions), String> {
    let text_of = |source: &SourceFile| SourceText { name: source.name.to_string(), text: source.text.to_string() };
    let Some(program) = sources.first() else { return Err("the record holds no PDL".to_string()) };
    let checked = check_sources(vec![text_of(program)], false, &mut |requirement| {
        let wanted = match requirement {
            Requirement::File { name, .. } => name,
            Requirement::Library(name) => format!("{name}.pdl"),
        };
        let found = sources.iter().find(|source| Path::new(&*source.name).ends_with(&wanted));
        found.map(text_of).ok_or_else(|| format!("`{wanted}` is not in the record"))
    });
    if checked.has_errors() {
        let rendered = apex_pdl::render(&checked.diagnostics, &checked.library.sources, false);
        return Err(format!("its PDL no longer checks with this version of apex:\n{rendered}"));
    }
    let declaration = agent_of(&checked.library);
    Ok((Arc::new(checked.library), declaration, host_functions()))
}

/// The agents of a program, ready for their first steps, in the order of their declarations.
///
/// # Errors
/// A host function that is declared and not there.
pub fn crew_of(library: &Arc<Library>) -> Outcome<Vec<Agent>> {
    let load =
        |declaration: &AgentDeclaration| apex_executive::load(Arc::clone(library), declaration, host_functions());
    let crew: Result<Vec<Agent>, String> = library.crew().iter().map(load).collect();
    crew.map_err(|reason| Trouble::user("the program cannot be executed").because(reason))
}

/// The agent that flies the vehicle: the first that is declared.
pub fn agent_of(library: &Library) -> AgentDeclaration {
    library.agents.first().cloned().unwrap_or_else(AgentDeclaration::of_program)
}

fn resolve(
    folder: &Path,
    requirement: Requirement,
    read: &mut dyn FnMut(&Path) -> Outcome<String>,
) -> Result<SourceText, String> {
    match requirement {
        Requirement::File { name, .. } => {
            let path = folder.join(&name);
            read_required(&path, read)
        }
        Requirement::Library(name) => {
            let file = format!("{name}.pdl");
            let local = folder.join("library").join(&file);
            if local.is_file() {
                return read_required(&local, read);
            }
            match Shipped::get(&file) {
                Some(shipped) => Ok(SourceText {
                    name: format!("library/{file}"),
                    text: String::from_utf8_lossy(&shipped.data).into_owned(),
                }),
                None => Err(format!("no library `{name}`; shipped are {}", shipped_names().join(", "))),
            }
        }
    }
}

fn read_required(path: &Path, read: &mut dyn FnMut(&Path) -> Outcome<String>) -> Result<SourceText, String> {
    let text = read(path).map_err(|trouble| match trouble.reason {
        Some(reason) => format!("{}: {reason}", trouble.message),
        None => trouble.message,
    })?;
    Ok(SourceText { name: path.display().to_string(), text })
}

fn shipped_names() -> Vec<String> {
    let mut names: Vec<String> =
        Shipped::iter().filter_map(|file| file.strip_suffix(".pdl").map(str::to_string)).collect();
    names.sort();
    names
}

/// Reads an instant of mission time as people type it: `90`, `20s`, `P1M30S`, `1:30:00`.
///
/// # Errors
/// Says what was given and what is understood.
pub fn parse_time(text: &str, option: &str) -> Outcome<Time> {
    let bad = || {
        Trouble::user(format!("`{option} {text}` is no time"))
            .help("write seconds (90), a duration (20s, 2h, P1M30S), or hours:minutes:seconds (1:30:00)")
    };
    let time = if text.contains(':') {
        clock_time(text)
    } else {
        match apex_pdl::read_value(text) {
            Ok(Value::Duration(Duration(nanoseconds))) => Some(Time(nanoseconds)),
            Ok(Value::Integer(seconds)) => Some(Time::from_seconds(seconds as f64)),
            Ok(Value::Real(seconds)) if seconds.is_finite() => Some(Time::from_seconds(seconds)),
            _ => None,
        }
    };
    match time.ok_or_else(bad)? {
        early if early < Time::ZERO => {
            Err(Trouble::user(format!("`{option} {text}` is before the start")).help("mission time begins at 0"))
        }
        time => Ok(time),
    }
}

/// A length above 0 in metres, written as in PDL.
///
/// # Errors
/// Says what was given and what is understood.
pub fn parse_length_m(text: &str, option: &str) -> Outcome<f64> {
    use apex_model::quantity::Dimension;
    let value = apex_pdl::read_value(text).ok();
    match value.as_ref().and_then(Value::as_number) {
        Some((metres, Dimension::LENGTH | Dimension::NONE)) if metres > 0.0 && metres.is_finite() => Ok(metres),
        _ => Err(Trouble::user(format!("`{option} {text}` is no length above 0"))
            .help("write metres (60), or a length with its unit (60m, 200ft)")),
    }
}

/// `1:30:00` or `1:30`: hours, minutes and seconds, or minutes and seconds.
fn clock_time(text: &str) -> Option<Time> {
    let parts: Vec<f64> = text.split(':').map(str::parse).collect::<Result<_, _>>().ok()?;
    let rest_in_range = parts.iter().skip(1).all(|part| (0.0..60.0).contains(part));
    let first_in_range = parts.first().is_some_and(|part| (0.0..1e6).contains(part));
    let seconds = parts.iter().fold(0.0, |seconds, part| seconds * 60.0 + part);
    (parts.len() <= 3 && first_in_range && rest_in_range).then(|| Time::from_seconds(seconds))
}
