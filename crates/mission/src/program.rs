//! Finds and checks PDL programs: files, shipped libraries, host function signatures.

use crate::error::{MissionError, MissionResult};
use crate::files::read_text;
use crate::lost_link;
use crate::vehicle;
use apex_executive::Agent;
use apex_model::host::HostFunctions;
use apex_model::library::{AgentDeclaration, Library};
use apex_model::source::SourceFile;
use apex_pdl::{Checked, CheckedConditions, HostSignature, Requirement, SourceText, Unresolved};
use rust_embed::RustEmbed;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The files of `library/`: the PDL libraries that ship with the product, and some data next to them, for which a filter would cost the
/// compilation of a matcher of file names.
#[derive(RustEmbed)]
#[folder = "../../library"]
struct Shipped;

/// Signatures of the functions that the command registers for PDL.
pub fn host_signatures() -> Vec<HostSignature> {
    apex_geo::functions::host_signatures().into_iter().map(HostSignature::pure).collect()
}

/// Returns the functions that the command registers for PDL.
pub fn host_functions() -> HostFunctions {
    apex_geo::functions::host_functions()
}

/// Returns `mission.pdl` in a folder, or the file itself.
pub fn program_path(path: &Path) -> PathBuf {
    if path.is_dir() { path.join("mission.pdl") } else { path.to_path_buf() }
}

/// Checks one program with everything that it requires; relative requirements are searched next to it.
///
/// # Errors
/// The program cannot be read. Mistakes inside are diagnostics of the result.
pub fn check_program(path: &Path, fragment: bool) -> MissionResult<Checked> {
    check_program_with(path, fragment, &mut read_text)
}

/// Like [`check_program`], reading files through `read`. A source read in this way is named by its path.
///
/// # Errors
/// Like [`check_program`].
pub fn check_program_with(
    path: &Path,
    fragment: bool,
    read: &mut dyn FnMut(&Path) -> MissionResult<String>,
) -> MissionResult<Checked> {
    let path = program_path(path);
    let text = read(&path)?;
    let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
    Ok(check_text_with(SourceText { name: path.display().to_string(), text }, &folder, fragment, read))
}

/// Checks a text that requires files of `folder`, reading them through `read`. A file that cannot be read gives a diagnostic.
pub fn check_text_with(
    source: SourceText,
    folder: &Path,
    fragment: bool,
    read: &mut dyn FnMut(&Path) -> MissionResult<String>,
) -> Checked {
    let checked = check_sources(vec![source.clone()], fragment, &mut |requirement| resolve(folder, requirement, read));
    // The vehicle and the figures of lost links are named in the program: only now are the figures known that its libraries need.
    let vehicle = vehicle::figures_for(&checked.library, folder, read);
    let lost = lost_link::figures_for(&checked.library);
    if vehicle.is_none() && lost.is_none() {
        return checked;
    }
    check_sources(vec![source], fragment, &mut |requirement| {
        let figures = match &requirement {
            Requirement::Library(name) if name == vehicle::FIGURES_LIBRARY => vehicle.clone(),
            Requirement::Library(name) if name == lost_link::FIGURES_LIBRARY => lost.clone(),
            _ => None,
        };
        figures.map_or_else(|| resolve(folder, requirement, read), Ok)
    })
}

/// Checks texts; `resolve` returns the texts that they require.
pub fn check_sources(
    sources: Vec<SourceText>,
    fragment: bool,
    resolve: &mut dyn FnMut(Requirement) -> Result<SourceText, Unresolved>,
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

/// Checks conditions in the terms that `texts` declare.
pub fn check_conditions(texts: Vec<SourceText>, conditions: Vec<SourceText>, folder: &Path) -> CheckedConditions {
    let host = host_signatures();
    let known = texts.clone();
    let resolve = &mut |requirement| resolve_among(&known, folder, requirement);
    apex_pdl::check_conditions(texts, conditions, apex_pdl::CheckOptions { fragment: false, host: &host, resolve })
}

/// Returns a required text: among the `known` ones, otherwise next to them, otherwise from the shipped libraries.
fn resolve_among(known: &[SourceText], folder: &Path, requirement: Requirement) -> Result<SourceText, Unresolved> {
    let wanted = match &requirement {
        Requirement::File { name, .. } => name.clone(),
        Requirement::Library(name) => format!("{name}.pdl"),
    };
    match known.iter().find(|text| Path::new(&text.name).ends_with(&wanted)) {
        Some(text) => Ok(text.clone()),
        None => resolve(folder, requirement, &mut read_text),
    }
}

/// Checks a program; the result contains its diagnostics and, if there are no errors, its library.
///
/// # Errors
/// The program cannot be read, or has errors: they are the error's diagnostics.
pub fn load_program(path: &Path) -> MissionResult<Checked> {
    let checked = check_program(path, false)?;
    if !checked.has_errors() {
        return Ok(checked);
    }
    let mut error = MissionError::program(format!("{} has errors", program_path(path).display()));
    error.diagnostics = Some(Box::new(checked));
    Err(error)
}

/// Loads the program stored in a flight record, for replay and explanations. Required texts are searched only among the recorded ones, so
/// that a record is independent of other files.
///
/// # Errors
/// A message if the stored sources no longer check, which means that another version wrote the record.
pub fn load_recorded(sources: &[SourceFile]) -> Result<(Arc<Library>, AgentDeclaration, HostFunctions), String> {
    let text_of = |source: &SourceFile| SourceText { name: source.name.to_string(), text: source.text.to_string() };
    let Some(program) = sources.first() else { return Err("the record holds no PDL".to_string()) };
    let checked = check_sources(vec![text_of(program)], false, &mut |requirement| {
        let wanted = match requirement {
            Requirement::File { name, .. } => name,
            Requirement::Library(name) => format!("{name}.pdl"),
        };
        let found = sources.iter().find(|source| Path::new(&*source.name).ends_with(&wanted));
        found.map(text_of).ok_or_else(|| format!("`{wanted}` is not in the record").into())
    });
    if checked.has_errors() {
        let rendered = apex_pdl::render(&checked.diagnostics, &checked.library.sources, false);
        return Err(format!("its PDL no longer checks with this version of apex:\n{rendered}"));
    }
    let declaration = agent_of(&checked.library);
    Ok((Arc::new(checked.library), declaration, host_functions()))
}

/// Returns the agents of a program, ready for their first steps, in the order of their declarations.
///
/// # Errors
/// If the program declares a host function that does not exist.
pub fn crew_of(library: &Arc<Library>) -> MissionResult<Vec<Agent>> {
    crew_with(library, &host_functions())
}

/// Like [`crew_of`], with these host functions.
///
/// # Errors
/// Like [`crew_of`].
pub(crate) fn crew_with(library: &Arc<Library>, functions: &HostFunctions) -> MissionResult<Vec<Agent>> {
    let load =
        |declaration: &AgentDeclaration| apex_executive::load(Arc::clone(library), declaration, functions.clone());
    let crew: Result<Vec<Agent>, String> = library.crew().iter().map(load).collect();
    crew.map_err(|reason| MissionError::program("the program cannot be executed").because(reason))
}

/// Returns the agent that flies the vehicle: the first that is declared.
pub fn agent_of(library: &Library) -> AgentDeclaration {
    library.agents.first().cloned().unwrap_or_else(AgentDeclaration::of_program)
}

fn resolve(
    folder: &Path,
    requirement: Requirement,
    read: &mut dyn FnMut(&Path) -> MissionResult<String>,
) -> Result<SourceText, Unresolved> {
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
                None => {
                    let names = shipped_names();
                    Err(Unresolved { reason: format!("no library `{name}`; shipped are {}", names.join(", ")), names })
                }
            }
        }
    }
}

fn read_required(path: &Path, read: &mut dyn FnMut(&Path) -> MissionResult<String>) -> Result<SourceText, Unresolved> {
    let text = read(path).map_err(|error| match error.reason {
        Some(reason) => format!("{}: {reason}", error.message),
        None => error.message,
    })?;
    Ok(SourceText { name: path.display().to_string(), text })
}

fn shipped_names() -> Vec<String> {
    let mut names: Vec<String> =
        Shipped::iter().filter_map(|file| file.strip_suffix(".pdl").map(str::to_string)).collect();
    names.sort();
    names
}
