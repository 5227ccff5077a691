//! A running solver program: in a separate process group, with limits on processor time, memory and output. It is killed, with everything
//! that it started, when its reader is dropped.

use super::protocol::{STOP_LINE, excerpt};
use crate::limits::{SOLVER_ERROR_BYTES_MAX, SOLVER_LAST_WORDS, SOLVER_LINE_BYTES_MAX, SOLVER_OUTPUT_BYTES_MAX};
use std::collections::VecDeque;
use std::ffi::OsString;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Maximum number of lines that may wait to be read; the program blocks while there are more.
const LINES_WAITING_MAX: usize = 4;
/// Wall time within which a program that has closed its output, but has other open files, must end.
const END_PATIENCE: Duration = Duration::from_millis(500);
/// Wall time that the system may take to end a program without open files, and this process to read its last output: a busy computer
/// takes seconds.
const EXIT_PATIENCE: Duration = Duration::from_secs(10);

/// Limits of a running program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProcessLimits {
    /// Memory that it may use, in bytes.
    pub memory_bytes: u64,
    /// Processor time of all its threads together.
    pub processor: Duration,
}

/// Result of a read of the program's output.
pub(super) enum Heard {
    /// A line, without its end.
    Line(Vec<u8>),
    /// The program has sent no line yet.
    Nothing,
    /// The program exceeded a limit: description of the excess.
    TooMuch(String),
    /// Its output has ended.
    End,
}

/// The end of the output on standard error.
#[derive(Debug, Default)]
struct LastWords {
    bytes: VecDeque<u8>,
    count: u64,
}

/// A running program. Dropping it kills the program.
pub(super) struct Running {
    child: Child,
    limits: ProcessLimits,
    lines: Receiver<Result<Vec<u8>, String>>,
    to_say: Sender<String>,
    last_words: Arc<Mutex<LastWords>>,
    memory_peak: u64,
    /// The thread that reads its last output.
    errors: Option<JoinHandle<()>>,
}

impl Running {
    /// Starts a program. Its limits are set before it receives its problem.
    ///
    /// # Errors
    /// Why it cannot be started.
    pub(super) fn start(program: &[OsString], limits: ProcessLimits) -> Result<Running, String> {
        let (name, arguments) = program.split_first().ok_or("its command is empty")?;
        let shown = name.to_string_lossy();
        let mut command = Command::new(name);
        command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = command.spawn().map_err(|error| format!("`{shown}` cannot be started: {error}"))?;
        let pipes = (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let (Some(input), Some(output), Some(errors)) = pipes else {
            return Err(format!("`{shown}` was started without its pipes"));
        };
        let last_words = Arc::new(Mutex::new(LastWords::default()));
        let (line, lines) = sync_channel(LINES_WAITING_MAX);
        let (to_say, say) = channel();
        let words = Arc::clone(&last_words);
        let mut running = Running { child, limits, lines, to_say, last_words, memory_peak: 0, errors: None };
        running.limit().map_err(|error| format!("`{shown}` cannot be limited: {error}"))?;
        // The threads end with the program's pipes.
        let begin = |part: &str, work: Box<dyn FnOnce() + Send>| {
            let thread = thread::Builder::new().name(format!("solver {part}")).spawn(work);
            thread.map_err(|error| format!("no thread could be started for `{shown}`: {error}"))
        };
        begin("input", Box::new(move || write_lines(input, &say)))?;
        begin("output", Box::new(move || read_lines(output, &line)))?;
        running.errors = Some(begin("errors", Box::new(move || read_errors(errors, &words)))?);
        Ok(running)
    }

    /// Limits memory, processor time, files and priority.
    #[cfg(target_os = "linux")]
    fn limit(&self) -> Result<(), std::io::Error> {
        use rustix::process::{Pid, Resource, Rlimit, prlimit, setpriority_process};
        let pid = i32::try_from(self.child.id()).ok().and_then(Pid::from_raw);
        let set = |resource, most: u64| {
            let limit = Rlimit { current: Some(most), maximum: Some(most) };
            prlimit(pid, resource, limit).map(|_| ()).map_err(std::io::Error::from)
        };
        // A program that grows slowly is detected at its limit and reported; this system limit stops one that grows at once.
        set(Resource::Data, self.limits.memory_bytes.saturating_add(self.limits.memory_bytes / 4))?;
        set(Resource::Cpu, self.limits.processor.as_secs().saturating_add(1))?;
        set(Resource::Core, 0)?;
        // The flight has precedence over its planners.
        let _ = setpriority_process(pid, 10);
        Ok(())
    }

    /// Does nothing: other systems cannot limit another process.
    #[cfg(not(target_os = "linux"))]
    fn limit(&self) -> Result<(), std::io::Error> {
        Ok(())
    }

    /// Sends a line without waiting until the program reads it.
    pub(super) fn say(&self, line: String) {
        // A program that has ended is noticed at its output.
        let _ = self.to_say.send(line);
    }

    /// Requests the program to end soon.
    pub(super) fn ask_to_stop(&self) {
        self.say(STOP_LINE.to_string());
    }

    /// Returns the next line, if one arrives within `patience`.
    pub(super) fn hear(&self, patience: Duration) -> Heard {
        match self.lines.recv_timeout(patience) {
            Ok(Ok(line)) => Heard::Line(line),
            Ok(Err(flood)) => Heard::TooMuch(flood),
            Err(RecvTimeoutError::Timeout) => Heard::Nothing,
            Err(RecvTimeoutError::Disconnected) => Heard::End,
        }
    }

    /// Returns a violation of the protocol that its lines do not show.
    pub(super) fn violation(&mut self) -> Option<String> {
        let written = self.last_words.lock().unwrap_or_else(PoisonError::into_inner).count;
        if written > SOLVER_ERROR_BYTES_MAX {
            return Some(format!("wrote more than {} MiB to standard error", SOLVER_ERROR_BYTES_MAX >> 20));
        }
        let resident = resident_bytes(self.child.id()).unwrap_or(0);
        self.memory_peak = self.memory_peak.max(resident);
        (resident > self.limits.memory_bytes)
            .then(|| format!("took more than {} MiB of memory", self.limits.memory_bytes >> 20))
    }

    /// Describes its end without an answer, with its last output.
    pub(super) fn end(&mut self) -> String {
        let since = Instant::now();
        let status = loop {
            match self.child.try_wait() {
                Ok(Some(status)) => break Some(status),
                Ok(None) if since.elapsed() < self.patience() => thread::sleep(Duration::from_millis(2)),
                Ok(None) | Err(_) => break None,
            }
        };
        let how = match status {
            None => "closed its output without an answer".to_string(),
            Some(status) => self.words_of(status),
        };
        if status.is_some() {
            // Processes that the program started would keep the pipe of its error output open.
            self.kill_group();
        }
        // The thread that reads the error output may be behind; it ends with the pipe.
        let patience = if status.is_some() { EXIT_PATIENCE } else { END_PATIENCE };
        while !self.errors.as_ref().is_none_or(JoinHandle::is_finished) && since.elapsed() < patience {
            thread::sleep(Duration::from_millis(2));
        }
        let mut words = self.last_words.lock().unwrap_or_else(PoisonError::into_inner);
        let text = String::from_utf8_lossy(words.bytes.make_contiguous()).into_owned();
        let last: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        let from = last.len().saturating_sub(3);
        match last.get(from..).unwrap_or_default() {
            [] => how,
            last => format!("{how}; its last output: `{}`", excerpt_of(&last.join(" / "))),
        }
    }

    /// Returns the wall time within which a program that has closed its output must end.
    fn patience(&self) -> Duration {
        if has_no_files(self.child.id()) { EXIT_PATIENCE } else { END_PATIENCE }
    }

    /// Kills the program and the processes that it started.
    fn kill_group(&self) {
        #[cfg(unix)]
        if let Some(group) = i32::try_from(self.child.id()).ok().and_then(rustix::process::Pid::from_raw) {
            // A failure means that the group has ended already.
            let _ = rustix::process::kill_process_group(group, rustix::process::Signal::KILL);
        }
    }

    fn words_of(&self, status: ExitStatus) -> String {
        #[cfg(unix)]
        if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
            let limits = self.limits;
            return match signal {
                // SIGXCPU, or SIGKILL at the same limit: systems differ.
                24 => format!("took more than {} s of processor time", limits.processor.as_secs().max(1)),
                6 => {
                    "was ended by signal 6 (SIGABRT: an abort, a stack that overflowed, or memory that it did not get)"
                        .to_string()
                }
                11 => "was ended by signal 11 (SIGSEGV: a wrong address, or a stack that overflowed)".to_string(),
                9 => "was ended by signal 9 (SIGKILL)".to_string(),
                other => format!("was ended by signal {other}"),
            };
        }
        match status.code() {
            Some(code) => format!("ended with exit code {code} and without an answer"),
            None => "ended without an answer".to_string(),
        }
    }
}

fn excerpt_of(text: &str) -> String {
    let shown: String = text.chars().take(400).flat_map(char::escape_debug).collect();
    if text.chars().nth(400).is_some() { format!("{shown}..") } else { shown }
}

impl Drop for Running {
    /// Kills the program and the processes that it started, and leaves no zombie.
    fn drop(&mut self) {
        self.kill_group();
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Returns true for a process that is ending, because it has closed all of its files. False if the system does not report it.
fn has_no_files(process: u32) -> bool {
    cfg!(target_os = "linux")
        && std::fs::read_dir(format!("/proc/{process}/fd")).map_or(true, |mut files| files.next().is_none())
}

/// Returns the resident memory of a process in bytes; `None` if the system does not report it.
fn resident_bytes(process: u32) -> Option<u64> {
    let told = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = told.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.split_whitespace().next()?.parse::<u64>().ok().map(|kibibytes| kibibytes << 10)
}

fn write_lines(mut input: ChildStdin, say: &Receiver<String>) {
    while let Ok(line) = say.recv() {
        let written =
            input.write_all(line.as_bytes()).and_then(|()| input.write_all(b"\n")).and_then(|()| input.flush());
        if written.is_err() {
            // A program that does not read its input may still answer.
            return;
        }
    }
}

/// Hands on the lines of a program up to the limits.
fn read_lines(output: impl Read, lines: &SyncSender<Result<Vec<u8>, String>>) {
    let mut output = BufReader::new(output);
    let mut left = SOLVER_OUTPUT_BYTES_MAX;
    loop {
        let mut line = Vec::new();
        let most = left.min(SOLVER_LINE_BYTES_MAX);
        let Ok(read) = output.by_ref().take(most + 1).read_until(b'\n', &mut line) else { return };
        left = left.saturating_sub(read as u64);
        let said = match read as u64 {
            0 => return,
            read if read <= most => Ok(line),
            _ if most < SOLVER_LINE_BYTES_MAX => Err(format!("sent more than {} MiB", SOLVER_OUTPUT_BYTES_MAX >> 20)),
            _ => Err(format!(
                "sent a line of more than {} MiB: `{}`",
                SOLVER_LINE_BYTES_MAX >> 20,
                excerpt(&String::from_utf8_lossy(line.get(..200).unwrap_or_default()))
            )),
        };
        let is_over = said.is_err();
        if lines.send(said).is_err() || is_over {
            return;
        }
    }
}

/// Keeps the last part of a program's standard error.
fn read_errors(mut errors: impl Read, words: &Mutex<LastWords>) {
    let mut chunk = vec![0; 1 << 16];
    while let Ok(read) = errors.read(&mut chunk) {
        let Some(bytes) = chunk.get(..read).filter(|bytes| !bytes.is_empty()) else { return };
        let mut words = words.lock().unwrap_or_else(PoisonError::into_inner);
        words.count += read as u64;
        words.bytes.extend(bytes);
        let over = words.bytes.len().saturating_sub(SOLVER_LAST_WORDS);
        words.bytes.drain(..over);
    }
}
