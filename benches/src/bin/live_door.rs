//! Measures the wait of an operator's messages while other sources flood the live port of `apex run --listen`, and the lateness of
//! deadlines: `cargo run --release -p apex-benches --bin live_door -- target/release/apex [SECONDS]`.
//!
//! There are two floods of 150,000 lines per second each: valid measurements of ten variables, and lines that cannot be parsed. An operator
//! sends twenty messages a second on a separate connection; the program prints each one, and prints every 100 ms. A latency extends from
//! the message's last byte to the printed line on the pipe.

#![allow(clippy::print_stdout, reason = "a measurement prints its figures")]

use std::collections::BTreeMap;
use std::error::Error;
use std::io::{BufRead, BufReader, Write};
use std::net::{SocketAddr, TcpStream};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

const PROGRAM: &str = "(defapplication \"Door\" :type realtime :agents ((agent pilot)))
(state-variable (roll-angle ?object) :unit deg)
(procedure (index (do-domain))
  (step hear (print \"order\" ?n) (waitfor (order ?n)) (repeating))
  (step deadline (print \"deadline\") (waitfor (:delay 100ms)) (repeating))
  (step guard (print \"rolled\") (repeating)
    (waitfor (:episode (roll-angle uav-1) :quality (:max-gap 1s) :value (> 80deg)))))
";
/// Lines per second of each flood.
const FLOOD_PER_SECOND: u64 = 150_000;
/// Number of blocks per second in which flood lines are written.
const BLOCKS_PER_SECOND: u64 = 100;
/// An operator's message acts, and a deadline is met, within this time.
const BAR_MS: f64 = 50.0;
/// Time between two messages of the operator: not a multiple of the time between two blocks of the floods.
const MESSAGE_PERIOD: Duration = Duration::from_millis(47);

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let apex = words.next().ok_or("usage: live_door APEX [SECONDS]")?;
    let seconds: u64 = words.next().map_or(Ok(20), |text| text.parse())?;
    let folder = std::env::temp_dir().join(format!("apex-live-door-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    std::fs::write(folder.join("door.pdl"), PROGRAM)?;
    let measured = measure(&apex, &folder, seconds);
    std::fs::remove_dir_all(&folder)?;
    measured
}

fn measure(apex: &str, folder: &std::path::Path, seconds: u64) -> Result<(), Box<dyn Error>> {
    let mut run = Command::new(apex)
        .args(["run", "door.pdl", "--listen", "0", "--record", "door.apex"])
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()?;
    let mut errors = BufReader::new(run.stderr.take().ok_or("no standard error")?);
    let mut line = String::new();
    errors.read_line(&mut line)?;
    let server: SocketAddr = line.trim().rsplit(' ').next().ok_or("no port")?.parse()?;
    // The program's error messages about invalid lines are read and counted.
    let messages = Arc::new(AtomicU64::new(0));
    let counted = Arc::clone(&messages);
    std::thread::spawn(move || errors.lines().for_each(|_| _ = counted.fetch_add(1, Ordering::Relaxed)));
    let printed = prints(&mut run)?;
    let (over, valid, malformed) = (Arc::new(AtomicBool::new(false)), Arc::default(), Arc::default());
    let values = (0..1_500)
        .map(|index| format!("{{\"measurement\": \"(roll-angle uav-{})\", \"value\": {}}}\n", index % 10, index % 60));
    flood(server, introduction("nav", "vehicle"), values.collect(), &over, &valid)?;
    let garbage = (0..1_500).map(|index| format!("{{\"measurement\": (roll-angle {index}, oops\n"));
    flood(server, introduction("noise", "feed"), garbage.collect(), &over, &malformed)?;
    let (before, began) = ((valid.load(Ordering::Relaxed), malformed.load(Ordering::Relaxed)), Instant::now());
    let sent = speak(server, seconds)?;
    let passed_s = began.elapsed().as_secs_f64();
    let rate = |now: &AtomicU64, before: u64| (now.load(Ordering::Relaxed) - before) as f64 / passed_s;
    println!(
        "valid {:.0} lines/s, malformed {:.0} lines/s, {} messages on standard error",
        rate(&valid, before.0),
        rate(&malformed, before.1),
        messages.load(Ordering::Relaxed)
    );
    over.store(true, Ordering::Relaxed);
    std::thread::sleep(Duration::from_millis(500));
    run.kill()?;
    run.wait()?;
    report(&sent, &printed.iter().collect::<Vec<_>>())
}

fn introduction(name: &str, class: &str) -> String {
    format!("{{\"source\": \"{name}\", \"class\": \"{class}\"}}\n")
}

/// Returns the printed texts with the time at which each came.
fn prints(run: &mut Child) -> Result<Receiver<(Instant, String)>, Box<dyn Error>> {
    let out = BufReader::new(run.stdout.take().ok_or("no standard output")?);
    let (say, printed) = channel();
    std::thread::spawn(move || {
        for line in out.lines().map_while(Result::ok).filter(|line| line.contains(r#""kind":"print""#)) {
            // The goal contains the same words, escaped.
            let text = line.split_once(r#""text":""#).and_then(|(_, rest)| rest.split('"').next());
            let Some(words) = text else { continue };
            if say.send((Instant::now(), words.to_owned())).is_err() {
                return;
            }
        }
    });
    Ok(printed)
}

/// Writes `lines` repeatedly at the flood's rate; `written` counts them.
fn flood(
    server: SocketAddr,
    first: String,
    lines: String,
    over: &Arc<AtomicBool>,
    written: &Arc<AtomicU64>,
) -> Result<(), Box<dyn Error>> {
    let mut stream = TcpStream::connect(server)?;
    stream.write_all(first.as_bytes())?;
    let (over, written) = (Arc::clone(over), Arc::clone(written));
    let (ready, started) = mpsc::channel();
    std::thread::spawn(move || {
        let began = Instant::now();
        for block in 1.. {
            if over.load(Ordering::Relaxed) || stream.write_all(lines.as_bytes()).is_err() {
                return;
            }
            written.fetch_add(FLOOD_PER_SECOND / BLOCKS_PER_SECOND, Ordering::Relaxed);
            let due = Duration::from_secs(1) * block / BLOCKS_PER_SECOND as u32;
            std::thread::sleep(due.saturating_sub(began.elapsed()));
            if block == BLOCKS_PER_SECOND as u32 {
                ready.send(()).unwrap_or_default();
            }
        }
    });
    // The measurement starts after one second of flood.
    started.recv_timeout(Duration::from_secs(30)).unwrap_or_default();
    Ok(())
}

/// Sends numbered messages as an operator; the time at which each was written.
fn speak(server: SocketAddr, seconds: u64) -> Result<Vec<Instant>, Box<dyn Error>> {
    let mut stream = TcpStream::connect(server)?;
    stream.set_nodelay(true)?;
    stream.write_all(introduction("tower", "operator").as_bytes())?;
    let (began, mut sent) = (Instant::now(), Vec::new());
    while began.elapsed() < Duration::from_secs(seconds) {
        std::thread::sleep(MESSAGE_PERIOD);
        stream.write_all(format!("(order {})\n", sent.len()).as_bytes())?;
        sent.push(Instant::now());
    }
    Ok(sent)
}

fn report(sent: &[Instant], printed: &[(Instant, String)]) -> Result<(), Box<dyn Error>> {
    let (first, last) = (sent.first().ok_or("nothing was sent")?, sent.last().ok_or("nothing was sent")?);
    let orders: BTreeMap<usize, Instant> = printed
        .iter()
        .filter_map(|(at, words)| Some((words.strip_prefix("order ")?.trim().parse().ok()?, *at)))
        .collect();
    let late =
        |number: usize, at: &Instant| Some(orders.get(&number)?.saturating_duration_since(*at).as_secs_f64() * 1e3);
    let mut waits_ms: Vec<f64> = sent.iter().enumerate().filter_map(|(number, at)| late(number, at)).collect();
    println!("operator: {} messages, {} acted upon", sent.len(), waits_ms.len());
    println!("operator: {}", percentiles(&mut waits_ms));
    let operator_ms = share(&waits_ms, 0.99);
    let beats: Vec<&Instant> = printed
        .iter()
        .filter(|(at, words)| words == "deadline" && (first..=last).contains(&at))
        .map(|(at, _)| at)
        .collect();
    let over_ms = |pair: &[&Instant]| match pair {
        [before, after] => after.saturating_duration_since(**before).as_secs_f64() * 1e3 - 100.0,
        _ => 0.0,
    };
    let mut beyond_ms: Vec<f64> = beats.windows(2).map(over_ms).collect();
    let missed = beyond_ms.iter().filter(|beyond| **beyond > BAR_MS).count();
    println!("deadlines: {}, {missed} missed by more than {BAR_MS} ms, {}", beats.len(), percentiles(&mut beyond_ms));
    if waits_ms.len() < sent.len() {
        return Err("messages of the operator were lost".into());
    }
    if missed > 0 || beats.is_empty() || operator_ms > BAR_MS {
        return Err(format!("the bar is {BAR_MS} ms at p99 and no missed deadline").into());
    }
    Ok(())
}

fn percentiles(values: &mut [f64]) -> String {
    values.sort_by(f64::total_cmp);
    let at = |part: f64| share(values, part);
    format!("median {:.1} ms, p99 {:.1} ms, worst {:.1} ms", at(0.5), at(0.99), at(1.0))
}

/// Returns the value below which this share of the sorted values lies.
fn share(sorted: &[f64], share: f64) -> f64 {
    sorted.get(((sorted.len().max(1) - 1) as f64 * share) as usize).copied().unwrap_or(f64::NAN)
}
