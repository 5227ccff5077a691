//! Measures monitors, and compares them with their bars and with peers.
//!
//! `monitoring traces FOLDER` writes the traces that the peers also watch; `monitoring report [PEER.json]` measures and prints Markdown
//! tables; `monitoring soak SAMPLES` prints the memory left in use after that many samples. A figure is the least processor time of
//! several runs: the cost of the work without disturbance.
#![allow(clippy::print_stdout, reason = "the table is what the program is for")]
#![allow(clippy::indexing_slicing, reason = "all lengths are constants of this file")]
#![allow(clippy::unwrap_used, reason = "a measurement that cannot be set up must stop at once")]

use apex_benches::monitoring::{
    MIXED_VARIABLES, conditions, duration_episodes, instant, mixed, noise, session, smooth, value_episodes, variable,
};
use apex_executive::MonitorSession;
use apex_model::host::HostFunctions;
use apex_model::time::Time;
use apex_model::value::Value;
use std::path::Path;
use std::process::ExitCode;
use std::sync::LazyLock;
use std::time::Instant;

/// Samples of the traces that peers watch too.
const PEER_SAMPLES: usize = 20_000;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["traces", folder] => write_traces(Path::new(folder)),
        ["report"] => report(None),
        ["soak", samples] => soak(samples.parse().unwrap()),
        ["look-back", kept] => println!("{:.1} ns per sample", look_back(kept.parse().unwrap())),
        ["report", peer] => {
            report(std::fs::read_to_string(peer).ok().and_then(|text| serde_json::from_str(&text).ok()))
        }
        _ => {
            eprintln!(
                "usage: monitoring traces FOLDER | monitoring report [PEER.json] | monitoring soak SAMPLES | monitoring look-back SAMPLES"
            );
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

fn write_traces(folder: &Path) {
    std::fs::create_dir_all(folder).unwrap();
    for (name, values) in [("smooth", smooth(PEER_SAMPLES, 0)), ("noise", noise(PEER_SAMPLES, 0))] {
        let lines: String = values.iter().map(|value| format!("{value}\n")).collect();
        std::fs::write(folder.join(name), lines).unwrap();
    }
}

/// Runs shorter than this are measured by the clock.
const SHORT_NS: f64 = 30e6;

/// Returns the processor time of this thread, in nanoseconds, so that other load on the machine does not count. If the system does not
/// provide it, returns the time since the first call.
fn worked_ns() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let worked = stat.and_then(|stat| stat.split(' ').next()?.parse().ok());
    worked.unwrap_or_else(|| START.elapsed().as_nanos() as f64)
}

/// Returns the least time of `runs` runs of `measured`, each after `set_up`, in nanoseconds.
fn least<T>(runs: usize, mut set_up: impl FnMut() -> T, mut measured: impl FnMut(&mut T)) -> f64 {
    let time = |_| {
        let mut state = set_up();
        // The clock is read inside the interval of the processor time, because the system takes microseconds to answer.
        let worked = worked_ns();
        let start = Instant::now();
        measured(&mut state);
        let passed = start.elapsed().as_nanos() as f64;
        let worked = worked_ns() - worked;
        // The system counts processor time in steps of some milliseconds, which is accurate for long runs. For a short run the clock
        // gives at least an upper bound.
        if worked < SHORT_NS { passed } else { worked.min(passed) }
    };
    (0..runs).map(time).fold(f64::INFINITY, f64::min)
}

/// Returns the nanoseconds for each sample of `values`, passed as one slice.
fn per_sample(texts: &[String], values: &[f64]) -> f64 {
    let instants: Vec<Time> = (0..values.len()).map(instant).collect();
    let ns = least(
        5,
        || session(texts),
        |session: &mut MonitorSession| {
            session.samples(&variable(0), &instants, values);
            session.take_results();
        },
    );
    ns / values.len() as f64
}

/// Returns the nanoseconds for each sample of the mixed monitors' variables, with one call for each.
fn per_sample_of_several(texts: &[String], samples: usize) -> f64 {
    let variables: Vec<_> =
        (0..MIXED_VARIABLES).map(|number| (variable(number), smooth(samples, number as u64))).collect();
    let ns = least(
        3,
        || session(texts),
        |session: &mut MonitorSession| {
            for index in 0..samples {
                for (variable, values) in &variables {
                    session.sample(variable, Value::Real(values[index]), instant(index));
                }
            }
            session.advance(instant(samples));
            session.take_results();
        },
    );
    ns / samples as f64
}

/// Returns the time of single samples that `texts` all watch, in order.
fn single_samples(texts: &[String], values: &[f64]) -> Vec<f64> {
    let mut session = session(texts);
    let variable = variable(0);
    let mut times: Vec<f64> = values
        .iter()
        .enumerate()
        .map(|(index, value)| {
            let start = Instant::now();
            session.sample(&variable, Value::Real(*value), instant(index));
            session.advance(instant(index));
            start.elapsed().as_nanos() as f64
        })
        .collect();
    session.take_results();
    times.sort_by(f64::total_cmp);
    times
}

/// Returns the nanoseconds for a sample that no condition watches, next to a thousand monitors of another variable.
fn unwatched(slices: bool) -> f64 {
    let samples = 100_000;
    let (instants, values): (Vec<Time>, Vec<f64>) = (0..samples).map(|index| (instant(index), index as f64)).unzip();
    let other = variable(5);
    let ns = least(
        5,
        || session(&value_episodes(1_000)),
        |session: &mut MonitorSession| {
            if slices {
                session.samples(&other, &instants, &values);
            } else {
                for (at, value) in instants.iter().zip(&values) {
                    session.sample(&other, Value::Real(*value), *at);
                }
            }
        },
    );
    ns / samples as f64
}

/// Returns the nanoseconds to begin one more watch in addition to `count` others.
fn creation(count: usize) -> f64 {
    let more = 1_000;
    let (_, fresh) = conditions("", &duration_episodes(more));
    let ns = least(
        5,
        || {
            let mut session = session(&duration_episodes(count));
            session.samples(&variable(0), &[instant(0), instant(1)], &[1.0, 2.0]);
            session.advance(instant(2));
            (session, fresh.clone())
        },
        |(session, fresh)| {
            for condition in fresh.drain(..) {
                session.watch(condition, instant(2)).unwrap();
            }
        },
    );
    ns / more as f64
}

/// Returns a hundred equal episodes with a minimum duration of `samples` samples.
fn bounded(samples: usize) -> Vec<String> {
    let seconds = samples as f64 * 0.02;
    (0..100)
        .map(|_| format!("(:episode (x0 uav) :quality (:max-gap 1s) :value (> 0) :timing (:duration (>= {seconds}s)))"))
        .collect()
}

/// Returns nanoseconds per episode and sample over a signal that interrupts each run just before its minimum duration: no episode is
/// decided.
fn against_duration(samples_of_bound: usize) -> f64 {
    let values: Vec<f64> =
        (0..100_000).map(|index| if index % samples_of_bound == samples_of_bound - 1 { -1.0 } else { 1.0 }).collect();
    per_sample(&bounded(samples_of_bound), &values) / 100.0
}

/// Like [`against_duration`], but with the same signal for every duration, which interrupts each run at its sixth sample, and with a
/// largest gap of two samples. No run comes near its minimum duration, so the figures show only the effect of its length. Within the
/// largest gap before the end of a duration, each sample requires a check of when the duration will have passed.
fn against_duration_alone(samples_of_bound: usize) -> f64 {
    let values: Vec<f64> = (0..100_000).map(|index| if index % 6 == 5 { -1.0 } else { 1.0 }).collect();
    let texts: Vec<String> =
        bounded(samples_of_bound).iter().map(|text| text.replace(":max-gap 1s", ":max-gap 50ms")).collect();
    per_sample(&texts, &values) / 100.0
}

/// Returns the nanoseconds for each further sample of two variables that must not be high together, after `before` such samples of each.
fn absent_together(before: usize) -> f64 {
    let text = "(:absent (:and (x0 uav > 0) (x1 uav > 0)) :for 10s)".to_string();
    let more = 1_000;
    let feed = |session: &mut MonitorSession, from: usize, count: usize| {
        for index in from..from + count {
            session.sample(&variable(0), Value::Real(5.0), instant(2 * index));
            session.sample(&variable(1), Value::Real(5.0), instant(2 * index + 1));
        }
    };
    let ns = least(
        3,
        || {
            let mut session = session(std::slice::from_ref(&text));
            feed(&mut session, 0, before);
            session
        },
        |session| feed(session, before, more),
    );
    ns / (2 * more) as f64
}

/// Conditions with arithmetic for each sample. The arithmetic is measured, so the conditions are rarely satisfied.
const NUMBERS: &[(&str, &str)] = &[
    ("persisted values", "(:measurement (x0 uav) :value (> 100) :estimation (:persist :with-timeout 1s))"),
    ("means of runs", "(:episode (x0 uav) :quality (:max-gap 1s) :value (> 0) :stats (:mean (> 100)))"),
    (
        "standard deviations over 500 samples",
        "(:episode (x0 uav) :quality (:max-gap 1s) :timing (:duration (>= 10s)) :stats (:stddev (> 100)))",
    ),
    (
        "medians over 500 samples",
        "(:episode (x0 uav) :quality (:max-gap 1s) :timing (:duration (>= 10s)) :stats (:median (> 100)))",
    ),
    (
        "slopes over 500 samples",
        "(:episode (x0 uav) :quality (:max-gap 1s) :timing (:duration (>= 10s)) :trend (:rate (> 100Hz)))",
    ),
    (
        "lines of least squares",
        "(:measurement (x0 uav > 100) :estimation (:linear-regression :minimum-points 5 :maximum-error 5))",
    ),
];

const WINGS_LEVEL: &str = "(:episode (x0 uav) :quality (:max-gap 1s) :value (:range -7 7) :timing (:duration (>= 5s)))";

/// Returns a session that keeps `kept` samples and has received that many.
fn with_history(kept: usize) -> MonitorSession {
    let seconds = kept as f64 * 0.02;
    let declarations = format!("(defun keep () (mean-over 'x0 'uav {seconds}s))");
    let (library, _) = conditions(&declarations, &[]);
    let mut session = MonitorSession::new(library, HostFunctions::default()).unwrap();
    let (instants, values): (Vec<Time>, Vec<f64>) = (0..kept).map(|index| (instant(index), 20.0)).unzip();
    session.samples(&variable(0), &instants, &values);
    session.advance(instant(kept - 1));
    session
}

/// Returns the nanoseconds for each remembered sample when a watch for level wings looks back over `kept` of them.
fn look_back(kept: usize) -> f64 {
    let (_, wings) = conditions("", &[WINGS_LEVEL.to_string()]);
    let ns = least(
        20,
        || (with_history(kept), wings.clone()),
        |(session, wings)| {
            for condition in wings.drain(..) {
                session.watch(condition, instant(0)).unwrap();
            }
        },
    );
    ns / kept as f64
}

/// Returns the nanoseconds for each further sample of level wings, with `kept` samples in the history.
fn beside_history(kept: usize) -> f64 {
    let (_, wings) = conditions("", &[WINGS_LEVEL.to_string()]);
    let more = 100_000;
    let (instants, values): (Vec<Time>, Vec<f64>) =
        (0..more).map(|index| (instant(kept + index), if index % 100 == 0 { 8.0 } else { 5.0 })).unzip();
    let ns = least(
        3,
        || {
            let mut session = with_history(kept);
            session.watch(wings[0].clone(), instant(kept)).unwrap();
            session
        },
        |session| {
            session.samples(&variable(0), &instants, &values);
        },
    );
    ns / more as f64
}

/// Returns the megabytes of memory that the process uses now, and its peak.
fn memory_mb() -> [f64; 2] {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = |key: &str| status.lines().find_map(|line| line.strip_prefix(key)).map(str::trim);
    let kibibytes = |key: &str| line(key).and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    ["VmRSS:", "VmHWM:"].map(|key| kibibytes(key).unwrap_or(f64::NAN) * 1024.0 / 1e6)
}

/// Runs monitors of all kinds with ten seconds of history, and prints the kept data, which must not grow with the samples.
fn soak(samples: usize) {
    let (texts, _) = mixed(20);
    let (library, conditions) = conditions("(defun keep () (mean-over 'x0 'uav 10s))", &texts);
    let mut session = MonitorSession::new(library, HostFunctions::default()).unwrap();
    for condition in conditions {
        session.watch(condition, Time::BEGINNING).unwrap();
    }
    let values = smooth(100_000, 0);
    let (mut done, mut results) = (0, 0);
    println!("| samples | results | kept of x0 | resident | at most |\n|---|---|---|---|---|");
    while done < samples {
        // Combinations of two variables get a sample of the second one occasionally.
        let instants: Vec<Time> = (done..done + values.len()).map(instant).collect();
        session.samples(&variable(0), &instants, &values);
        session.event(Value::symbol("tick"), instant(done + values.len() - 1));
        session.sample(&variable(1), Value::Real(values[done / values.len() % 97]), instant(done + values.len() - 1));
        done += values.len();
        results += session.take_results().len();
        if done.ilog10() > (done - values.len()).max(1).ilog10() || done % (samples / 10).max(values.len()) == 0 {
            let kept = session.histories().get(&variable(0)).map_or(0, |history| history.samples().len());
            let [now, most] = memory_mb();
            println!("| {done} | {results} | {kept} | {now:.1} MB | {most:.1} MB |");
        }
    }
}

struct MeasurementFile(Option<serde_json::Value>);

impl MeasurementFile {
    /// Prints one row: the name, measurement and bar in nanoseconds, and the peers' row for the same work.
    fn row(&self, what: &str, ns: f64, bar: Option<f64>, row: Option<&str>) {
        let verdict = match bar {
            Some(bar) if ns <= bar => "met",
            Some(_) => "MISSED",
            None => "",
        };
        let peer = |name: &str| {
            let found = self.0.as_ref()?.get(name)?.get("rows")?.get(row?)?.as_f64()?;
            Some(format!("{} ({:.0} x)", time(found), found / ns))
        };
        let bar = bar.map(time).unwrap_or_default();
        let [rtamt, reelay] = ["rtamt", "reelay"].map(|name| peer(name).unwrap_or_default());
        println!("| {what} | {bar} | {} | {verdict} | {rtamt} | {reelay} |", time(ns));
    }
}

fn time(ns: f64) -> String {
    match ns {
        ns if ns >= 1e6 => format!("{:.1} ms", ns / 1e6),
        ns if ns >= 1e3 => format!("{:.1} us", ns / 1e3),
        ns => format!("{ns:.1} ns"),
    }
}

fn report(peers: Option<serde_json::Value>) {
    let table = MeasurementFile(peers);
    let (calm, wild) = (smooth(PEER_SAMPLES, 0), noise(PEER_SAMPLES, 0));
    println!("| measured | bar | Apex | | rtamt | reelay |\n|---|---|---|---|---|---|");
    for (name, texts, bar) in [
        ("value episodes", value_episodes(1_000), Some(10.0)),
        ("duration episodes with max-gap", duration_episodes(1_000), Some(10.0)),
    ] {
        let row = name.split(' ').next();
        let (on_calm, on_wild) =
            (format!("{} smooth", row.unwrap_or_default()), format!("{} noise", row.unwrap_or_default()));
        table.row(
            &format!("1,000 {name}, each sample of a smooth signal"),
            per_sample(&texts, &calm) / 1e3,
            bar,
            Some(&on_calm),
        );
        let few = &wild[..2_000];
        table.row(&format!("1,000 {name}, each sample of noise"), per_sample(&texts, few) / 1e3, None, Some(&on_wild));
    }
    let (texts, relevant) = mixed(1_000);
    let ns = per_sample_of_several(&texts, 5_000) / relevant as f64;
    table.row("1,000 mixed monitors of 10 variables, each relevant sample", ns, Some(50.0), None);
    for (what, text) in NUMBERS {
        let texts: Vec<String> = std::iter::repeat_n((*text).to_string(), 10).collect();
        table.row(&format!("10 {what}, each sample"), per_sample(&texts, &calm) / 10.0, None, None);
    }
    let plenty = [value_episodes(5_000), duration_episodes(5_000)].concat();
    for (name, values) in [("smooth", &calm[..2_000]), ("noise", &wild[..300])] {
        let times = single_samples(&plenty, values);
        let bar = (name == "smooth").then_some(0.2e6);
        table.row(&format!("one sample with 10,000 monitors on it, {name}, p50"), times[times.len() / 2], bar, None);
        table.row(
            &format!("one sample with 10,000 monitors on it, {name}, p99"),
            times[times.len() * 99 / 100],
            None,
            None,
        );
    }
    table.row("a sample without a monitor, one call", unwatched(false), Some(100.0), None);
    table.row("a sample without a monitor, in a slice", unwatched(true), Some(100.0), None);
    for (what, text) in [("episode", &duration_episodes(1)[0]), ("measurement", &"(x0 uav > 100)".to_string())] {
        let ns = per_sample(std::slice::from_ref(text), &calm);
        table.row(&format!("one sample in a slice, one {what}"), ns, Some(100.0), None);
    }
    for count in [0, 1_000, 10_000] {
        table.row(&format!("create a monitor next to {count}"), creation(count), Some(20_000.0), None);
    }
    table.row("wings level looks back over 200 samples, each", look_back(200), Some(100.0), None);
    table.row("wings level with 200 samples of history, each further one", beside_history(200), Some(100.0), None);
    growth();
}

fn growth() {
    println!("\n| grows with | least | .. | | | most | most / least |\n|---|---|---|---|---|---|---|");
    let line = |what: &str, measured: &[(usize, f64)]| {
        let cells: Vec<String> = measured.iter().map(|(count, ns)| format!("{count}: {}", time(*ns))).collect();
        let ratio = measured.last().map_or(0.0, |last| last.1) / measured.first().map_or(1.0, |first| first.1);
        println!("| {what} | {} | {ratio:.2} |", cells.join(" | "));
    };
    let calm = smooth(5_000, 0);
    let of = |count: usize| per_sample(&duration_episodes(count), &calm) / count as f64;
    line(
        "monitors of one variable: ns per monitor and sample",
        &[1, 10, 100, 1_000, 10_000].map(|count| (count, of(count))),
    );
    line(
        "duration bound in samples: ns per monitor and sample",
        &[10, 100, 1_000, 5_000, 10_000].map(|bound| (bound, against_duration(bound))),
    );
    line(
        "duration bound in samples, the same signal: ns per monitor and sample",
        &[10, 100, 1_000, 5_000, 10_000].map(|bound| (bound, against_duration_alone(bound))),
    );
    line(
        "results of two variables that must not be together: ns for each further sample",
        &[10, 100, 500, 5_000].map(|before| (before, absent_together(before))),
    );
    line(
        "samples kept: ns for each further sample",
        &[10, 100, 1_000, 10_000, 1_000_000].map(|kept| (kept, beside_history(kept))),
    );
    line("samples looked back over: ns each", &[10, 100, 1_000, 10_000, 70_000].map(|kept| (kept, look_back(kept))));
}
