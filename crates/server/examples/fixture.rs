//! Writes a fictitious flight record for work on the page: `cargo run -p apex-server --example fixture -- FILE.apex`. With `--live
//! SECONDS` it writes the flight in pieces over that time, as `apex fly` does.

#[path = "../tests/flight/mod.rs"]
mod flight;

use flight::Writer;
use flight::story::Story;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

const STEPS_PER_SECOND: i64 = 4;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.as_slice() {
        [file] => {
            flight::write_complete(Path::new(file));
            ExitCode::SUCCESS
        }
        [file, live, seconds] if live == "--live" => {
            write_slowly(Path::new(file), seconds.parse().unwrap_or(60));
            ExitCode::SUCCESS
        }
        _ => {
            eprintln!("usage: fixture FILE.apex [--live SECONDS]");
            ExitCode::from(2)
        }
    }
}

fn write_slowly(file: &Path, seconds: i64) {
    let story = Story::western_states();
    let mut writer = Writer::new(file, &story);
    let steps = (seconds * STEPS_PER_SECOND).max(1);
    let slice = story.end_ns() / steps + 1;
    for step in 0..steps {
        writer.write(&story, step * slice, (step + 1) * slice);
        std::thread::sleep(Duration::from_millis(1_000 / STEPS_PER_SECOND as u64));
    }
    writer.complete(&story);
}
