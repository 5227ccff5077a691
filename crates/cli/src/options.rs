//! The command line, declared for clap.

mod diagnose;
mod fly;
mod fork;
mod integrity;
mod plan;
mod profile;
mod solver;
mod vehicle;

pub use diagnose::DiagnoseOptions;
pub use fly::FlyOptions;
pub use fork::ForkOptions;
pub use integrity::{ConvertOptions, RecoverOptions, VerifyOptions};
pub use plan::{PlanFormat, PlanOptions};
pub use profile::{
    ProfileBuildOptions, ProfileCommand, ProfileCompareOptions, ProfileMergeOptions, ProfileShowOptions,
    ProfileUpdateOptions, ProfileWorkOptions,
};

pub use solver::{SolverOptions, SolverProgramOptions};
pub use vehicle::VehicleOptions;

use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// Help that belongs to no option.
const AFTER_HELP: &str = "\
Times: 90 (seconds), 20s, 2h, P1M30S, 1:30:00
Exit codes: 0 success; 1 failure (a disk, a port, a difference in replay); 2 invalid input";

/// Apex: an autonomy executive for aerial observation missions.
#[derive(Parser)]
#[command(name = "apex", version, about, propagate_version = true, after_help = AFTER_HELP)]
pub struct Options {
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands of `apex`.
#[derive(Subcommand)]
pub enum Command {
    /// Check PDL files: syntax, names, dimensions, goals that nothing serves, steps that can never begin.
    Check(CheckOptions),
    /// Explain a code of the checker's messages, or a word of PDL and its libraries.
    Explain(ExplainOptions),
    /// Format PDL files in place.
    Fmt(FormatOptions),
    /// Run a PDL program without a vehicle and print its trace.
    Run(RunOptions),
    /// Fly a mission in simulated time and write its flight record.
    Fly(FlyOptions),
    /// Re-execute a flight record and compare every decision byte for byte.
    Replay(ReplayOptions),
    /// Check that a flight record is unchanged, and its positions against the requirements of its mission.
    Verify(VerifyOptions),
    /// Save the intact part of a damaged or cut-off flight record to a new one.
    Recover(RecoverOptions),
    /// Convert a flight record of the preceding format version to the present one.
    Convert(ConvertOptions),
    /// Print what a recorded flight achieved, computed again from its record alone.
    Score(ScoreOptions),
    /// Continue a recorded flight from an instant with other inputs, wind, seed or plan, and compare both reports.
    Fork(ForkOptions),
    /// Explain a flight: why a task started, waits, was interrupted, ended; which task holds a resource; why a command was sent.
    Why(WhyOptions),
    /// Explain what did not happen: why something was not created, started, resumed, chosen, granted, visited.
    WhyNot(WhyNotOptions),
    /// Print what happened in a flight, filtered.
    Trace(TraceOptions),
    /// Watch conditions over a log, a flight record or lines of JSON, and print every result.
    Monitor(MonitorOptions),
    /// Write the samples and events of a flight record or log as a table, CSV or Parquet.
    Export(ExportOptions),
    /// Plan a mission, a problem or a test mission without flying, and print the plan.
    Plan(PlanOptions),
    /// Measure planners on test missions, and print the profile table.
    #[command(subcommand)]
    Profile(ProfileCommand),
    /// Check vehicle files and print derived figures: endurance, range, reserve, turns, pixels, swaths.
    Vehicle(VehicleOptions),
    /// Diagnose test outcomes with a dependency model, or print its testability or its PDL.
    Diagnose(DiagnoseOptions),
    /// Answer one planning problem on standard input as a solver program does; started by Apex.
    Solver(SolverOptions),
    /// Open Sherpa, the web page, on a flight record, or fly missions for programs that ask over HTTP.
    Serve(ServeOptions),
}

impl Command {
    /// Returns the solver programs that the user names.
    pub fn solver_programs(&self) -> &[String] {
        let programs = match self {
            Command::Fly(options) => &options.programs,
            Command::Fork(options) => &options.programs,
            Command::Plan(options) => &options.programs,
            Command::Run(options) => &options.programs,
            Command::Serve(options) => &options.programs,
            _ => return &[],
        };
        &programs.solver_programs
    }
}

/// `apex check`
#[derive(Args)]
pub struct CheckOptions {
    /// PDL files, or mission folders; with `--fix`, `-` fixes standard input to standard output.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Apply the safe fixes to the files and to the files next to them that they require, and check the result.
    #[arg(long)]
    pub fix: bool,
    /// Change no file: print what `--fix` would change, as a unified difference.
    #[arg(long, requires = "fix")]
    pub dry_run: bool,
    /// The files are pieces of a larger application: undefined names are notes.
    #[arg(long)]
    pub fragment: bool,
    /// Print how far back each clause reads, the data that are kept for it, and the clauses without a bound.
    #[arg(long, conflicts_with = "fix")]
    pub memory: bool,
    /// Print diagnostics (and with `--memory` what is kept) as JSON, one object per line.
    #[arg(long)]
    pub json: bool,
}

/// `apex explain`
#[derive(Args)]
pub struct ExplainOptions {
    /// Codes as `apex check` prints them, such as E0203, or words such as `sqrt` and `take-off`; without any, all codes are listed.
    pub codes: Vec<String>,
}

/// `apex fmt`
#[derive(Args)]
pub struct FormatOptions {
    /// PDL files; `-` formats standard input to standard output.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Change nothing; fail when a file is not formatted.
    #[arg(long)]
    pub check: bool,
}

/// `apex run`
#[derive(Args)]
pub struct RunOptions {
    /// The program.
    pub program: PathBuf,
    /// Inputs as JSON lines; `-` is standard input.
    #[arg(long, value_name = "FILE")]
    pub inputs: Option<PathBuf>,
    /// Answers of the operator to `(ask operator ..)`, as JSON lines.
    #[arg(long, value_name = "FILE")]
    pub answers: Option<PathBuf>,
    /// Run by the wall clock, ask questions on the terminal and take answers and events from it.
    #[arg(long)]
    pub interactive: bool,
    /// Simulated seconds per second of wall time; a real-time program has 1.
    #[arg(long, allow_hyphen_values = true, value_name = "FACTOR")]
    pub pace: Option<f64>,
    /// Take inputs, or an external simulator, from this port of 127.0.0.1 instead of standard input; 0 takes any free port.
    #[arg(long, value_name = "NUMBER")]
    pub listen: Option<u16>,
    /// Stop at this mission time: seconds, or a duration such as `20s`, `P1M30S`.
    #[arg(long, allow_hyphen_values = true, value_name = "TIME")]
    pub until: Option<String>,
    /// Exit with 1 unless the application ends without a failed initial task.
    #[arg(long, value_name = "OUTCOME", value_parser = ["success"])]
    pub expect: Option<String>,
    /// Output of the trace; `-` is standard output (the default).
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
    /// Print the trace as text for operators instead of JSON lines.
    #[arg(long)]
    pub text: bool,
    /// Also write a flight record.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Wait for the disk with each commit of the record, so that a power cut loses nothing that was sent.
    #[arg(long, requires = "record")]
    pub power_safe: bool,
    /// Folder on another disk in which the record continues when its own disk accepts no more data.
    #[arg(long, value_name = "FOLDER", requires = "record")]
    pub spare_folder: Option<PathBuf>,
    /// Sign the record with the key in this file when it is closed: 64 hexadecimal digits, as `openssl rand -hex 32` writes them.
    #[arg(long, value_name = "FILE", requires = "record")]
    pub sign: Option<PathBuf>,
    #[command(flatten)]
    pub programs: SolverProgramOptions,
}

/// `apex replay`
#[derive(Args)]
pub struct ReplayOptions {
    /// The flight record.
    pub record: PathBuf,
    /// Print the result as JSON.
    #[arg(long)]
    pub json: bool,
}

/// `apex score`
#[derive(Args)]
pub struct ScoreOptions {
    /// The flight record.
    pub record: PathBuf,
    /// Print the report as JSON.
    #[arg(long)]
    pub json: bool,
}

/// `apex why`
#[derive(Args)]
pub struct WhyOptions {
    /// The flight record.
    pub record: PathBuf,
    /// A task by its number (`T12`; `pilot/T12` where several agents run), its tag, or words of its goal; a resource or a diagnosed
    /// component by its name; or a command (`command 7`, or words of it).
    #[arg(value_name = "WHAT")]
    pub task: String,
    /// Options of the explanation.
    #[command(flatten)]
    pub explanation: ExplanationOptions,
}

/// `apex why-not`
#[derive(Args)]
pub struct WhyNotOptions {
    /// The flight record.
    pub record: PathBuf,
    /// A task, a step's tag, a goal such as `(take picture ?x)`, a procedure (`mission.pdl:36`), a resource, a target.
    pub what: String,
    /// Options of the explanation.
    #[command(flatten)]
    pub explanation: ExplanationOptions,
}

/// Instant and format of an explanation.
#[derive(Args)]
pub struct ExplanationOptions {
    /// The instant: seconds, `1:30:00`, or a duration; default is the end.
    #[arg(long, allow_hyphen_values = true, value_name = "TIME")]
    pub at: Option<String>,
    /// Depth of the chain of causes, back to inputs.
    #[arg(long, value_name = "NUMBER", default_value_t = apex_runtime::explain::DEPTH_DEFAULT)]
    pub depth: usize,
    /// Print as JSON.
    #[arg(long)]
    pub json: bool,
}

/// `apex trace`
#[derive(Args)]
pub struct TraceOptions {
    /// The flight record.
    pub record: PathBuf,
    /// Only these kinds, separated by commas: created, transition, event, measurement, selected, command, print, ..
    #[arg(long = "type", value_delimiter = ',', value_name = "KIND,..")]
    pub kinds: Vec<String>,
    /// Only this agent's lines, if several run.
    #[arg(long, value_name = "NAME")]
    pub agent: Option<String>,
    /// Only lines about this task (`T12`, `pilot/T12`), goal text or state variable.
    #[arg(long, value_name = "TEXT")]
    pub object: Option<String>,
    /// Only lines from this mission time on.
    #[arg(long, allow_hyphen_values = true, value_name = "TIME")]
    pub from: Option<String>,
    /// Only lines up to this mission time.
    #[arg(long, allow_hyphen_values = true, value_name = "TIME")]
    pub to: Option<String>,
    /// Only tasks of the procedure at this place, `file.pdl` or `file.pdl:14`.
    #[arg(long, value_name = "PLACE")]
    pub procedure: Option<String>,
    /// Print JSON lines.
    #[arg(long)]
    pub json: bool,
}

/// `apex monitor`
#[derive(Args)]
pub struct MonitorOptions {
    /// Conditions, such as '(roll-angle aircraft-1 > 15deg)'.
    #[arg(value_name = "CONDITION")]
    pub conditions: Vec<String>,
    /// A file of conditions; may be given several times.
    #[arg(long, value_name = "FILE")]
    pub condition_file: Vec<PathBuf>,
    /// Inputs to watch: JSON lines, a flight record, or a log (.ulg, .bin, .log, .tlog, .mcap, .csv); default is standard input. May be
    /// given several times: each is watched separately, and each line names it.
    #[arg(long, value_name = "FILE")]
    pub inputs: Vec<PathBuf>,
    /// Leave out what was measured or happened before; evidence counts from here on.
    #[arg(long, allow_hyphen_values = true, value_name = "TIME")]
    pub from: Option<String>,
    /// Leave out what was measured or happened later; verdicts are those of this instant.
    #[arg(long, allow_hyphen_values = true, value_name = "TIME")]
    pub until: Option<String>,
    /// Print civil time (UTC) in addition to mission time, if the log contains it.
    #[arg(long)]
    pub utc: bool,
    /// Draw the variables, their limits and the intervals of the results: an SVG file.
    #[arg(long, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// Write all final results as a table, too: one row per result, instants and durations in nanoseconds. CSV, or Parquet
    /// where the name ends in .parquet.
    #[arg(long, value_name = "FILE")]
    pub results: Option<PathBuf>,
    /// Instant from which evidence counts; default is the input's first instant.
    #[arg(long, allow_hyphen_values = true, value_name = "TIME")]
    pub created: Option<String>,
    /// PDL with declarations of state variables, functions and constants; may be given several times.
    #[arg(long, value_name = "FILE")]
    pub library: Vec<PathBuf>,
    /// PDL declarations as text, such as '(state-variable (roll-error ?a) :derived (abs (- (want ?a) (roll ?a))) :join (:hold 1s))'.
    #[arg(long, value_name = "PDL")]
    pub declare: Vec<String>,
    /// Assignment of the fields of a log to state variables; added to the mapping that ships for the log's format.
    #[arg(long, value_name = "FILE")]
    pub mapping: Option<PathBuf>,
    /// Print the mapping in use as PDL, and watch nothing.
    #[arg(long)]
    pub show_mapping: bool,
    /// Use the clock of the log for all instants; default is the time since the beginning of the log.
    #[arg(long)]
    pub log_time: bool,
    /// List the fields of the log, with counts, rates and ranges, and the state variables to which they are mapped.
    #[arg(long)]
    pub fields: bool,
    /// End with exit code 1 unless this is the verdict of every condition.
    #[arg(long, value_name = "VERDICT", value_parser = ["satisfied", "not-satisfied", "unknown"])]
    pub expect: Option<String>,
    /// Print JSON lines.
    #[arg(long)]
    pub json: bool,
}

/// `apex export`
#[derive(Args)]
pub struct ExportOptions {
    /// A flight record, a log (.ulg, .bin, .log, .tlog, .mcap, .csv) or JSON lines; `-` is standard input.
    pub inputs: PathBuf,
    /// Format of the table; default is that of the name of `--out`, or CSV.
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<ExportFormat>,
    /// Output of the table; default is standard output, for CSV.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// PDL with declarations of state variables; a record brings its own.
    #[arg(long, value_name = "FILE")]
    pub library: Vec<PathBuf>,
    /// Assignment of the fields of a log to state variables; default is the mapping that ships for the log's format.
    #[arg(long, value_name = "FILE")]
    pub mapping: Option<PathBuf>,
    /// Use the clock of the log for all instants; default is the time since the beginning of the log.
    #[arg(long)]
    pub log_time: bool,
}

/// Formats of tables.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum ExportFormat {
    /// Comma-separated values.
    Csv,
    /// Apache Parquet.
    Parquet,
}

/// `apex serve`
#[derive(Args)]
pub struct ServeOptions {
    /// The flight record; can be left out with `--missions`.
    pub record: Option<PathBuf>,
    /// Another flight record that the page can show next to the first one; can be given several times.
    #[arg(long, value_name = "RECORD", requires = "record")]
    pub with: Vec<PathBuf>,
    /// Let programs and pages with access to this server fly the missions in this folder: its sub-folders with a `mission.pdl`.
    #[arg(long, value_name = "FOLDER")]
    pub missions: Option<PathBuf>,
    /// The folder of the records of these flights; default is the current folder.
    #[arg(long, value_name = "FOLDER", requires = "missions")]
    pub records: Option<PathBuf>,
    /// The port.
    #[arg(long, default_value_t = 8040, value_name = "NUMBER")]
    pub port: u16,
    /// The address; any other than 127.0.0.1 admits other machines, with tokens and encryption.
    #[arg(long, default_value = "127.0.0.1", value_name = "ADDRESS")]
    pub address: String,
    /// Tokens, each in a line `ROLE NAME SECRET`; roles are observer, operator, pilot-in-command. Left out with another address, tokens
    /// are made for this run and printed.
    #[arg(long, value_name = "FILE")]
    pub tokens: Option<PathBuf>,
    /// A certificate chain (PEM); without this option, an address other than 127.0.0.1 gets one for this run.
    #[arg(long, value_name = "FILE", requires = "tls_key")]
    pub tls_cert: Option<PathBuf>,
    /// The private key of the certificate (PEM).
    #[arg(long, value_name = "FILE", requires = "tls_cert")]
    pub tls_key: Option<PathBuf>,
    /// Another host name by which browsers may address this server; can be given several times.
    #[arg(long, value_name = "NAME")]
    pub host_name: Vec<String>,
    /// The agent to show, if several run; default is the first.
    #[arg(long, value_name = "NAME", requires = "record")]
    pub agent: Option<String>,
    #[command(flatten)]
    pub programs: SolverProgramOptions,
    /// Open the page in the default browser.
    #[arg(long)]
    pub open: bool,
}
