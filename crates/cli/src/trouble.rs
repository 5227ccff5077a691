//! What goes wrong at the command line: one type, two exit codes, messages for people.

use std::fmt;
use std::process::ExitCode;

/// A failure of a command, ready to be printed.
#[derive(Debug)]
pub struct Trouble {
    /// True: the user's input is at fault (exit code 2); false: something failed (exit code 1).
    pub of_user: bool,
    /// What happened and where, one line; empty when diagnostics have been printed already.
    pub message: String,
    /// Why, if known.
    pub reason: Option<String>,
    /// What to do.
    pub help: Option<String>,
}

impl Trouble {
    /// The user's input is wrong.
    pub fn user(message: impl Into<String>) -> Trouble {
        Trouble { of_user: true, message: message.into(), reason: None, help: None }
    }

    /// The world is at fault: a disk, a port, a record that no longer matches.
    pub fn failure(message: impl Into<String>) -> Trouble {
        Trouble { of_user: false, message: message.into(), reason: None, help: None }
    }

    /// Diagnostics have been printed; only the exit code is left to give.
    pub fn told() -> Trouble {
        Trouble::user("")
    }

    /// Adds the reason.
    pub fn because(mut self, reason: impl fmt::Display) -> Trouble {
        self.reason = Some(reason.to_string());
        self
    }

    /// Adds what to do.
    pub fn help(mut self, help: impl Into<String>) -> Trouble {
        self.help = Some(help.into());
        self
    }

    /// 2 for the user's mistakes, 1 for failures.
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(if self.of_user { 2 } else { 1 })
    }
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "error: {}", self.message)?;
        if let Some(reason) = &self.reason {
            write!(f, "\n  why: {reason}")?;
        }
        if let Some(help) = &self.help {
            write!(f, "\n  help: {help}")?;
        }
        Ok(())
    }
}

/// What commands return.
pub type Outcome<T = ()> = Result<T, Trouble>;

/// Reads a text file.
///
/// # Errors
/// Says which file, why it cannot be read, and what to do.
pub fn read_text(path: &std::path::Path) -> Outcome<String> {
    let bytes = read_bytes(path)?;
    String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        Trouble::user(format!("{} is not text", path.display()))
            .because(format!("byte {valid} is not UTF-8"))
            .help("save the file as UTF-8")
    })
}

/// Reads a file.
///
/// # Errors
/// Says which file, why it cannot be read, and what to do.
pub fn read_bytes(path: &std::path::Path) -> Outcome<Vec<u8>> {
    if path.is_dir() {
        return Err(Trouble::user(format!("{} is a folder", path.display())).help("name a file in it"));
    }
    std::fs::read(path).map_err(|error| unreadable(path, &error))
}

/// A file that cannot be read: looked for in vain, or not for us.
pub fn unreadable(path: &std::path::Path, error: &std::io::Error) -> Trouble {
    let help = match error.kind() {
        std::io::ErrorKind::PermissionDenied => "ask its owner for the right to read it".to_string(),
        _ => nearby_help(path),
    };
    Trouble::user(format!("cannot read {}", path.display())).because(error).help(help)
}

/// How many names a message lists at most.
const NEARBY_MAX: usize = 6;

/// Names files and missions of the same folder that look alike, or says where a relative path was looked for.
pub fn nearby_help(path: &std::path::Path) -> String {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or_else(|| std::path::Path::new("."));
    let extension = path.extension();
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .filter(|candidate| candidate.extension() == extension || candidate.join("mission.pdl").is_file())
        .filter_map(|candidate| candidate.file_name().map(|name| name.to_string_lossy().into_owned()))
        .filter(|name| !name.starts_with('.'))
        .collect();
    let wanted = path.file_stem().map(|stem| stem.to_string_lossy().to_lowercase()).unwrap_or_default();
    // Names that begin alike first: most wrong names are misspelt or cut short.
    names.sort_by_key(|name| (usize::MAX - alike(&name.to_lowercase(), &wanted), name.clone()));
    names.truncate(NEARBY_MAX);
    let folder_name =
        if folder == std::path::Path::new(".") { "this folder".into() } else { folder.display().to_string() };
    match (folder.is_dir(), names.is_empty()) {
        (false, _) => format!("the folder {} does not exist; check the path", folder.display()),
        (true, true) => format!("there is nothing like it in {folder_name}; check the path"),
        (true, false) => format!("{folder_name} holds {}", names.join(", ")),
    }
}

/// How many characters two names have in common at their beginnings.
fn alike(a: &str, b: &str) -> usize {
    a.chars().zip(b.chars()).take_while(|(a, b)| a == b).count()
}
