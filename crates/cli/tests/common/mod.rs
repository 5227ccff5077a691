//! Runs the `apex` command as a user would, in a separate folder.

#![allow(dead_code, unreachable_pub, reason = "each test file uses its part")]
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot prepare its folder has failed")]

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

/// A program that sends a greeting, waits for `(go)` and sends another one.
pub const GREETINGS: &str = r#"(procedure
  (index (do-domain))
  (step a (greet world))
  (step b (greet moon)
    (waitfor (go) (end ?a)))
  (step c (terminate)
    (waitfor (end ?b))))

(primitive
  (index (greet ?who))
  (on-start (print "hello" ?who) (inform (greeted ?who))))
"#;

/// Message that lets the greetings continue.
pub const GO: &str = "{\"t\": 7, \"event\": \"(go)\"}\n";

/// A scratch folder in which `apex` is run.
pub struct Desk {
    folder: TempDir,
}

/// Output of a command.
#[derive(Debug)]
pub struct Said {
    /// The exit code; `None` if a signal ended the command.
    pub code: Option<i32>,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl Desk {
    /// Returns an empty folder.
    pub fn new() -> Desk {
        Desk { folder: TempDir::new().unwrap() }
    }

    /// Returns a folder with `greetings.pdl` and `go.jsonl`.
    pub fn with_greetings() -> Desk {
        let desk = Desk::new();
        desk.write("greetings.pdl", GREETINGS);
        desk.write("go.jsonl", GO);
        desk
    }

    /// Returns a folder with a copy of a shipped mission, or of one of the tests, in `m`.
    pub fn with_mission(name: &str) -> Desk {
        let desk = Desk::new();
        let to = desk.path("m");
        fs::create_dir(&to).unwrap();
        let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/missions").join(name);
        let from = if own.is_dir() { own } else { missions().join(name) };
        for entry in fs::read_dir(from).unwrap() {
            let entry = entry.unwrap();
            fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
        }
        desk
    }

    /// Returns a path in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file.
    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    /// Reads a file.
    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    /// Replaces the first `from` in a file by `to`.
    pub fn change(&self, name: &str, from: &str, to: &str) {
        let text = self.read(name);
        assert!(text.contains(from), "{name} does not hold {from}");
        self.write(name, &text.replacen(from, to, 1));
    }

    /// Returns the names in the folder, in order.
    pub fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(self.folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    /// Returns the command, ready to be started in the folder.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_apex"));
        command.args(arguments).current_dir(self.folder.path()).stdin(Stdio::null()).env("RUST_BACKTRACE", "0");
        command
    }

    /// Runs the command to its end.
    pub fn apex(&self, arguments: &[&str]) -> Said {
        Said::of(self.command(arguments).output().unwrap())
    }

    /// Runs the command with `input` on standard input.
    pub fn apex_hearing(&self, arguments: &[&str], input: &str) -> Said {
        let mut command = self.command(arguments);
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        child.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
        Said::of(child.wait_with_output().unwrap())
    }

    /// Returns a flown `first-picture`, recorded in `flight.apex`.
    pub fn with_flight() -> Desk {
        let desk = Desk::new();
        let mission = mission("first-picture");
        desk.apex(&["fly", &mission, "--record", "flight.apex", "--no-progress"]).well();
        desk
    }
}

/// Returns the shipped missions.
pub fn missions() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions").canonicalize().unwrap()
}

/// Returns the folder of a shipped mission.
pub fn mission(name: &str) -> String {
    missions().join(name).display().to_string()
}

impl Said {
    fn of(output: Output) -> Said {
        Said {
            code: output.status.code(),
            out: String::from_utf8(output.stdout).unwrap(),
            err: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Checks that the command succeeded without any message on standard error.
    #[track_caller]
    pub fn well(self) -> Said {
        assert_eq!(self.code, Some(0), "{self:?}");
        assert_eq!(self.err, "", "no message");
        self
    }

    /// Checks that the command ended with `code`, did not panic, and printed each of `phrases` to standard error.
    #[track_caller]
    pub fn complained(self, code: i32, phrases: &[&str]) -> Said {
        assert_eq!(self.code, Some(code), "{}\n{}", self.out, self.err);
        assert!(!self.err.contains("panicked"), "{}", self.err);
        for phrase in phrases {
            assert!(self.err.contains(phrase), "`{phrase}` is not in:\n{}", self.err);
        }
        self
    }

    /// Checks that the command did not panic and printed each of `phrases` to standard error, whatever its exit code.
    #[track_caller]
    pub fn complained_of(self, phrases: &[&str]) -> Said {
        let code = self.code.expect("no signal ended it");
        self.complained(code, phrases)
    }

    /// Checks that each of `phrases` is on standard output.
    #[track_caller]
    pub fn told(self, phrases: &[&str]) -> Said {
        for phrase in phrases {
            assert!(self.out.contains(phrase), "`{phrase}` is not in:\n{}", self.out);
        }
        self
    }

    /// Returns the standard output as JSON lines.
    #[track_caller]
    pub fn json_lines(&self) -> Vec<serde_json::Value> {
        self.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }
}
