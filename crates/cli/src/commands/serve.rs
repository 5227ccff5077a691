//! `apex serve`: Sherpa on a flight record, finished or still being written.

use crate::options::ServeOptions;
use crate::trouble::{Outcome, Trouble};
use crate::{output, recording, sources};
use std::net::IpAddr;
use std::path::Path;
use std::sync::Arc;

/// Serves until Ctrl-C.
pub fn run(options: &ServeOptions) -> Outcome {
    let address: IpAddr = options.address.parse().map_err(|error| {
        Trouble::user(format!("`--address {}` is no address", options.address))
            .because(error)
            .help("write an IP address of this machine, for example 127.0.0.1")
    })?;
    // Opened once here so that a wrong file is told before a port is taken.
    let reader = recording::open(&options.record)?;
    let called = |name: &String| reader.agent_called(name).map_err(|error| Trouble::user(error.to_string()));
    let agent = options.agent.as_ref().map(called).transpose()?.unwrap_or(0);
    let open = options.open;
    serve(&options.record, agent, address, options.port, move |url| {
        // The page is served whether anybody reads this line or not.
        output::print_line(format_args!("Sherpa: {url}  (Ctrl-C ends it)")).ok();
        if open {
            open_browser(url);
        }
    })
}

/// Serves what agent number `agent` of `record` did at `address:port`; calls `ready` with the page's address.
pub fn serve(
    record: &Path,
    agent: usize,
    address: IpAddr,
    port: u16,
    ready: impl FnOnce(&str) + Send + 'static,
) -> Outcome {
    apex_server::serve(apex_server::ServeOptions {
        record: record.to_path_buf(),
        agent,
        address,
        port,
        load: Some(Arc::new(sources::load_recorded)),
        ready: Box::new(ready),
    })
    .map_err(|error| Trouble::failure(error.to_string()))
}

/// Asks the desktop for its browser; where there is none the printed address is enough.
fn open_browser(url: &str) {
    let program = if cfg!(target_os = "macos") { "open" } else { "xdg-open" };
    let started = std::process::Command::new(program)
        .arg(url)
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn();
    if let Err(error) = started {
        output::complain(format_args!(
            "note: no browser could be opened ({program}: {error}); open the address yourself"
        ));
    }
}
