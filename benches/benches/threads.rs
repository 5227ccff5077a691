//! Latency across threads: one thread puts an event into the inbox, and the executive's thread steps and sends the command to the outbox.
//! The row is the time from putting the event to sending the command.
//!
//! The loop is that of real-time applications: a bounded inbox and a wall clock, parked while nothing arrives. The figures are measured
//! here instead of by criterion, because the wanted figure is the median of many single passes on a busy machine.
#![allow(
    clippy::expect_used,
    clippy::indexing_slicing,
    reason = "a measurement that cannot be set up must stop at once"
)]

use apex_benches::{agent, library, rows};
use apex_model::effect::CommandId;
use apex_model::event::EventKind;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::ports::{Input, Vehicle};
use apex_runtime::program::NoDeliberator;
use apex_runtime::{Control, RunSettings, fly};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::{Duration, Instant};

const PROGRAM: &str = "
(procedure (index (do-domain))
  (step answer (answer ?number) (waitfor (call ?number)) (responding)))
(primitive (index (answer ?number)) (on-start (command (answer ?number))) (duration 0s))
";

/// Number of measured passes from event to command.
const JOURNEYS: usize = 20_000;

/// Hands every command to another thread at once.
struct Outlet(SyncSender<Instant>);

impl Vehicle for Outlet {
    fn next_report(&self) -> Option<Time> {
        None
    }

    fn advance(&mut self, _: Time, _: &mut Vec<Input>) -> Result<(), String> {
        Ok(())
    }

    fn command(&mut self, _: CommandId, _: &Value, _: Time) {
        // The send fails only after the last measured pass, when no receiver is left.
        self.0.send(Instant::now()).unwrap_or_default();
    }

    fn withdraw(&mut self, _: CommandId, _: Time) {}
}

fn call(number: usize) -> Control {
    Control::Input(EventKind::Occurrence(Value::list([Value::symbol("call"), Value::Integer(number as i64)])))
}

/// Sends `count` events in sequence, `pause` apart. Returns the time from each event to the arrival of its command on this thread.
fn journeys(say: &SyncSender<Control>, commands: &Receiver<Instant>, count: usize, pause: Duration) -> Vec<Duration> {
    let mut times = Vec::with_capacity(count);
    for number in 0..count {
        let begun = Instant::now();
        say.send(call(number)).expect("the run continues");
        commands.recv().expect("the run answers");
        times.push(begun.elapsed());
        let rest = Instant::now();
        while rest.elapsed() < pause {
            std::hint::spin_loop();
        }
    }
    times
}

fn report(name: &str, mut times: Vec<Duration>) -> f64 {
    times.sort_unstable();
    let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize].as_secs_f64() * 1e6;
    println!("{name:<44} p50 {:>7.1} us   p90 {:>7.1} us   p99 {:>7.1} us", at(0.5), at(0.9), at(0.99));
    at(0.5) * 1e3
}

fn main() {
    let (say, controls) = sync_channel(1024);
    let (outlet, commands) = sync_channel(1024);
    let executive = std::thread::spawn(move || {
        let mut vehicle = Outlet(outlet);
        let options = RunSettings { pace: Some(1.0), controls: Some(controls), ..RunSettings::default() };
        fly(&mut agent(&library(PROGRAM)), &mut vehicle, &mut NoDeliberator, &mut [], options)
            .expect("the run ends well")
    });
    journeys(&say, &commands, 1_000, Duration::ZERO);
    report("inbox -> outbox and back, at once", journeys(&say, &commands, JOURNEYS, Duration::ZERO));
    report(
        "inbox -> outbox and back, every 200 us",
        journeys(&say, &commands, JOURNEYS / 4, Duration::from_micros(200)),
    );
    let one_way: Vec<Duration> = (0..JOURNEYS)
        .map(|number| {
            let begun = Instant::now();
            say.send(call(number)).expect("the run continues");
            commands.recv().expect("the run answers").saturating_duration_since(begun)
        })
        .collect();
    let median_ns = report("inbox -> outbox (the command is sent)", one_way);
    rows::keep("across threads", "inbox to outbox", &[(1, median_ns)]).expect("the row is written");
    say.send(Control::Stop).expect("the run continues");
    let end = executive.join().expect("the executive's thread ends well");
    assert!(end.steps > JOURNEYS as u64);
}
