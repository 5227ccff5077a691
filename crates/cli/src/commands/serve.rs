//! `apex serve`: serves Sherpa for a flight record, finished or still being written, and flies missions for other programs.

use crate::error::{CliError, CliResult};
use crate::options::ServeOptions;
use crate::{output, recording, sources};
use apex_mission::deliberation::PlanningResources;
use apex_planning::Registry;
use apex_server::{AccessFiles, AccessOptions, FlightDoor, FlightOptions, ReadDatum};
use std::net::{IpAddr, SocketAddr};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Serves until Ctrl-C.
pub fn run(options: &ServeOptions, planners: &Arc<Registry>) -> CliResult {
    if options.record.is_none() && options.missions.is_none() {
        return Err(CliError::user("`apex serve` needs a flight record or a folder of missions")
            .help("write `apex serve RECORD`, or `apex serve --missions FOLDER`"));
    }
    let address: IpAddr = options.address.parse().map_err(|error| {
        CliError::user(format!("`--address {}` is not an address", options.address))
            .because(error)
            .help("write an IP address of this machine, for example 127.0.0.1")
    })?;
    let record =
        options.record.as_deref().map(|record| Ok::<_, CliError>((record, agent_of(record, options)?))).transpose()?;
    let flights = options.missions.as_deref().map(|missions| flights(missions, options, planners)).transpose()?;
    let open = options.open;
    for other in &options.with {
        recording::open(other)?;
        apex_mission::recording::protect(other);
    }
    let served = Served { record, door: None, others: options.with.clone(), flights };
    let files = AccessFiles {
        tokens: options.tokens.as_deref(),
        certificate: options.tls_cert.as_deref().zip(options.tls_key.as_deref()),
        host_names: &options.host_name,
    };
    let (access, said) = files.prepare(address)?;
    serve(served, planners, access, SocketAddr::new(address, options.port), move |url| {
        // The page is served even if this line cannot be written.
        output::print_line(format_args!("Sherpa: {url}  (Ctrl-C ends it)")).ok();
        said.into_iter().for_each(|line| output::print_line(line).unwrap_or_default());
        if open {
            open_browser(url);
        }
    })
}

/// Returns the number of the agent to show. Opens the record so that a wrong file is reported before a port is taken.
fn agent_of(record: &Path, options: &ServeOptions) -> CliResult<usize> {
    let reader = recording::open(record)?;
    apex_mission::recording::protect(record);
    let called = |name: &String| reader.agent_called(name).map_err(|error| CliError::user(error.to_string()));
    Ok(options.agent.as_ref().map(called).transpose()?.unwrap_or(0))
}

/// Returns the options with which the server flies `missions`.
fn flights(missions: &Path, options: &ServeOptions, planners: &Arc<Registry>) -> CliResult<FlightOptions> {
    let folder = |path: PathBuf, option: &str, help: &str| {
        if path.is_dir() {
            return Ok(path);
        }
        Err(CliError::user(format!("`{option} {}` is not a folder", path.display())).help(help))
    };
    let records = options.records.clone().unwrap_or_else(|| PathBuf::from("."));
    Ok(FlightOptions {
        missions: folder(
            missions.to_path_buf(),
            "--missions",
            "name the folder whose sub-folders are missions, for example `missions`",
        )?,
        records: folder(records, "--records", "make the folder, or choose another one")?,
        read: read_datum(),
        means: PlanningResources::of(planners),
    })
}

/// Returns a reader for PDL forms received over HTTP.
pub fn read_datum() -> ReadDatum {
    Arc::new(|text| apex_pdl::read_value(text).map_err(|diagnostic| diagnostic.message))
}

/// Records and missions of a server.
pub struct Served<'a> {
    /// The record's file, and the number of the agent to show.
    pub record: Option<(&'a Path, usize)>,
    /// The connection to the run that writes the record, if it is in progress.
    pub door: Option<FlightDoor>,
    /// Further records that the page can show.
    pub others: Vec<PathBuf>,
    /// Means of flying missions, if the server may.
    pub flights: Option<FlightOptions>,
}

/// Serves at `address:port`; calls `ready` with the page's address.
pub fn serve(
    served: Served<'_>,
    planners: &Arc<Registry>,
    access: AccessOptions,
    address: SocketAddr,
    ready: impl FnOnce(&str) + Send + 'static,
) -> CliResult {
    let Served { record, door, others, flights } = served;
    apex_server::serve(apex_server::ServeOptions {
        record: record.map(|(record, _)| record.to_path_buf()),
        agent: record.map_or(0, |(_, agent)| agent),
        address: address.ip(),
        port: address.port(),
        load: Some(Arc::new(sources::load_recorded)),
        door,
        others,
        what_if: Some((PlanningResources::of(planners), read_datum())),
        flights,
        access,
        ready: Box::new(ready),
    })
    .map_err(|error| CliError::failure(error.to_string()))
}

/// Requests the desktop to open its browser; without one the printed address suffices.
fn open_browser(url: &str) {
    let program = if cfg!(target_os = "macos") { "open" } else { "xdg-open" };
    let started = std::process::Command::new(program)
        .arg(url)
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn();
    if let Err(error) = started {
        output::print_error(format_args!(
            "note: no browser could be opened ({program}: {error}); open the address yourself"
        ));
    }
}
