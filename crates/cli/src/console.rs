//! Operators and programs that send lines while a run continues: lines from standard input or a port, questions on the terminal,
//! Ctrl-C.

use crate::error::{CliError, CliResult};
use crate::output;
use apex_runtime::Control;
use apex_runtime::live::{LineReader, LiveSources, SourceClass, hear_connections, hear_lines};
use apex_runtime::live_lines::OpenQuestions;
use std::net::{Ipv4Addr, TcpListener};
use std::sync::mpsc::{Receiver, sync_channel};

/// Maximum number of waiting control messages: wake-ups, the end of standard input, Ctrl-C.
const WAITING_MAX: usize = 100;

/// Reads standard input, or `port`, and handles Ctrl-C; inputs arrive through the sources, control messages through the receiver.
///
/// # Errors
/// The port is in use, or the system refuses a signal handler.
pub fn listen(open: &OpenQuestions, stdin: bool, port: Option<u16>) -> CliResult<(LiveSources, Receiver<Control>)> {
    let (say, controls) = sync_channel(WAITING_MAX);
    let stop = say.clone();
    ctrlc::set_handler(move || {
        // No receiver is left: the run is over, and only the process remains to be ended.
        if stop.send(Control::Stop).is_err() {
            std::process::exit(130);
        }
    })
    .map_err(|error| CliError::failure("cannot listen to Ctrl-C").because(error))?;
    let wake = say.clone();
    // If the channel is full, the messages in it will wake the run.
    let sources = LiveSources::new(move || wake.try_send(Control::Look).unwrap_or_default());
    let reader = LineReader {
        open: open.clone(),
        read_value: |text| apex_pdl::read_value(text).map_err(|diagnostic| diagnostic.message),
        note: |line| output::print_error(line),
    };
    if let Some(port) = port {
        hear_connections(bind(port)?, &sources, &reader);
    }
    let (others, heard) = (port.is_some(), sources.clone());
    std::thread::spawn(move || {
        if stdin && let Ok(source) = heard.admit(SourceClass::Operator) {
            hear_lines(std::io::stdin().lock(), &source, &reader);
        }
        if !others {
            // If the run is over, no receiver takes the message, which is then dropped.
            say.send(Control::Quiet).unwrap_or_default();
        }
    });
    Ok((sources, controls))
}

/// Binds a port of this machine and prints its number.
///
/// # Errors
/// Another program uses the port.
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
