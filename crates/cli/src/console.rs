//! Operators and programs that send lines while a run continues: lines from standard input or a port, questions on the terminal,
//! Ctrl-C.

mod complaints;
mod hearing;

use crate::error::{CliError, CliResult};
use crate::output;
use apex_runtime::Control;
use apex_runtime::live::{LiveSources, SourceClass};
use apex_runtime::live_lines::OpenQuestions;
use hearing::{Hearing, hear, hear_connection};
use std::net::{Ipv4Addr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, sync_channel};

/// Words to the run that wait for it: wake-ups, the end of standard input, Ctrl-C.
const WAITING_MAX: usize = 100;
/// Connections at a time, those included that the run has not admitted: each has a thread.
const CONNECTIONS_MAX: usize = 96;

/// Listens to standard input, or to `port`, and to Ctrl-C; what is said comes out of the sources, and the rest of the receiver.
///
/// # Errors
/// The port cannot be had, or the system gives no signal handler.
pub fn listen(open: &OpenQuestions, stdin: bool, port: Option<u16>) -> CliResult<(LiveSources, Receiver<Control>)> {
    let (say, controls) = sync_channel(WAITING_MAX);
    let stop = say.clone();
    ctrlc::set_handler(move || {
        // There is nothing to end cleanly: the run is over already.
        if stop.send(Control::Stop).is_err() {
            std::process::exit(130);
        }
    })
    .map_err(|error| CliError::failure("cannot listen to Ctrl-C").because(error))?;
    let wake = say.clone();
    // A full channel has woken the run already.
    let sources = LiveSources::new(move || wake.try_send(Control::Look).unwrap_or_default());
    if let Some(port) = port {
        accept(bind(port)?, &sources, open);
    }
    let (open, others, heard) = (open.clone(), port.is_some(), sources.clone());
    std::thread::spawn(move || {
        if stdin && let Ok(source) = heard.admit(SourceClass::Operator) {
            hear(std::io::stdin().lock(), &Hearing { source: &source, open: &open, answers: None });
        }
        if !others {
            // The run may be over: then the line is dropped.
            say.send(Control::Quiet).unwrap_or_default();
        }
    });
    Ok((sources, controls))
}

/// Hears every connection on a separate thread, up to the limit.
fn accept(listener: TcpListener, sources: &LiveSources, open: &OpenQuestions) {
    let (sources, open, connections) = (sources.clone(), open.clone(), Arc::new(AtomicUsize::new(0)));
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let (sources, open, connections) = (sources.clone(), open.clone(), Arc::clone(&connections));
            if connections.fetch_add(1, Ordering::AcqRel) >= CONNECTIONS_MAX {
                connections.fetch_sub(1, Ordering::AcqRel);
                hearing::refuse(&stream, &format!("{CONNECTIONS_MAX} connections are open, which is the limit"));
                continue;
            }
            std::thread::spawn(move || {
                hear_connection(&stream, &sources, &open);
                connections.fetch_sub(1, Ordering::AcqRel);
            });
        }
    });
}

/// Returns a port of this machine; says which one it is.
///
/// # Errors
/// Another program has it.
pub fn bind(port: u16) -> CliResult<TcpListener> {
    let refused = |error| {
        CliError::failure(format!("cannot listen on 127.0.0.1:{port}"))
            .because(error)
            .help("stop the program that uses the port, or choose another one with `--listen` (0 takes any free one)")
    };
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(refused)?;
    if let Ok(address) = listener.local_addr() {
        output::print_error(format_args!("listening on {address}"));
    }
    Ok(listener)
}
