//! People and programs that speak while a run continues: lines from standard input or a port, questions on the terminal,
//! Ctrl-C.

use crate::error::{CliError, CliResult};
use crate::output;
use apex_model::value::Value;
use apex_runtime::Control;
use apex_runtime::limits::INPUT_LINE_BYTES_MAX;
use apex_runtime::live_lines::OpenQuestions;
use std::io::{BufRead, BufReader, Read};
use std::net::{Ipv4Addr, TcpListener};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

/// Inputs that may wait for a run that is busy; the caller that sends more waits.
const WAITING_MAX: usize = 10_000;

/// Listens to standard input, or to `port`, and to Ctrl-C; everything said comes out of the receiver.
///
/// # Errors
/// The port cannot be had, or the system gives no signal handler.
pub fn listen(open: &OpenQuestions, stdin: bool, port: Option<u16>) -> CliResult<Receiver<Control>> {
    let (say, controls) = sync_channel(WAITING_MAX);
    let stop = say.clone();
    ctrlc::set_handler(move || {
        // Nobody is there to end in good order: the run is over already.
        if stop.send(Control::Stop).is_err() {
            std::process::exit(130);
        }
    })
    .map_err(|error| CliError::failure("cannot listen to Ctrl-C").because(error))?;
    if let Some(port) = port {
        let listener = bind(port)?;
        let (open, say) = (open.clone(), say.clone());
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let (open, say) = (open.clone(), say.clone());
                std::thread::spawn(move || hear(BufReader::new(stream), &open, &say));
            }
        });
    }
    let (open, others) = (open.clone(), port.is_some());
    std::thread::spawn(move || {
        if stdin {
            hear(std::io::stdin().lock(), &open, &say);
        }
        if !others {
            // The run may be over: then nobody minds.
            say.send(Control::Quiet).unwrap_or_default();
        }
    });
    Ok(controls)
}

/// A port of this machine; says which one it is.
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

fn hear(mut lines: impl BufRead, open: &OpenQuestions, say: &SyncSender<Control>) {
    loop {
        let mut bytes = Vec::new();
        let read = lines.by_ref().take(INPUT_LINE_BYTES_MAX as u64 + 1).read_until(b'\n', &mut bytes);
        if !read.is_ok_and(|count| count > 0) {
            return;
        }
        let line = String::from_utf8_lossy(&bytes).trim().to_string();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        match open.understand(&line, &read_value) {
            Ok(control) => {
                if say.send(control).is_err() {
                    return;
                }
            }
            Err(fault) => output::print_error(format_args!("  {fault}")),
        }
    }
}

fn read_value(text: &str) -> Result<Value, String> {
    apex_pdl::read_value(text).map_err(|diagnostic| diagnostic.message)
}
