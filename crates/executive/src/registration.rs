//! Registration: compares the host functions that a library declares with those that the host program registered.

use apex_model::host::HostFunctions;
use apex_model::library::Library;
use apex_model::symbol::Symbol;

/// Checks that the host has registered every function that `library` declares.
///
/// # Errors
/// Place and name of the first missing function, and the remedy.
pub(crate) fn all_registered(library: &Library, host: &HostFunctions) -> Result<(), String> {
    let missing = |name: &Symbol, command: bool| !command && host.get(name).is_none();
    match library.host_functions.iter().find(|(name, function)| missing(name, function.command)) {
        None => Ok(()),
        Some((name, function)) => Err(format!(
            "{}: the host function `{name}` is declared but not registered; register it before loading, or declare it with `:command t` if it is a command",
            library.describe_place(function.place)
        )),
    }
}
