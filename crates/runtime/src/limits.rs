//! Every limit of the runtime, with its reason. The executive's limits are in `apex_model::limits`.

/// Maximum number of inputs waiting in the inbox: a few batches of the largest size. A vehicle that sends more at once is faulty.
pub const INBOX_INPUTS_MAX: usize = 4 * apex_model::limits::BATCH_EVENTS_MAX;
/// Maximum number of executive steps at one instant: a command, its acknowledgement and the next command may share an instant, but not
/// endlessly.
pub const STEPS_PER_INSTANT_MAX: u64 = 10_000;
/// Maximum number of rounds at one instant in which agents answer each other; later messages of the instant are not delivered.
pub const MESSAGE_ROUNDS_MAX: u32 = 1_000;
/// Least delay of a paced step that is reported: operators do not notice less, and timers of a busy ordinary system are late by some
/// milliseconds.
pub const LATENESS_REPORTED_MIN: std::time::Duration = std::time::Duration::from_millis(50);
/// Least delay of a solver's answer, after the instant given by its charged work, that is reported: a plan is made for a place and a
/// time, and ordinary systems are late by less.
pub const ANSWER_LATE_REPORTED_MIN: apex_model::time::Duration = apex_model::time::Duration(1_000_000_000);
/// Stack of a solver's thread in bytes: recursive planners need more than the mission loop.
pub const SOLVER_STACK_BYTES: usize = 64 << 20;
/// Interval of checks of a working solver: short enough to stop one that fills the memory.
pub const SOLVER_LOOK: std::time::Duration = std::time::Duration::from_millis(10);
/// Time within which a cancelled solver must stop; well-behaved ones take some milliseconds.
pub const SOLVER_GRACE: std::time::Duration = std::time::Duration::from_secs(1);
/// Work units that a solver may charge after twice its budget, or after it was cancelled, before it is unwound.
pub const SOLVER_OVERRUN_UNITS: u64 = 1_000_000;
/// Wall time after which a solver that does not return is abandoned. Its budget is counted in work, so this limit is generous.
pub const SOLVER_TIMEOUT: std::time::Duration = std::time::Duration::from_secs(300);
/// Maximum number of abandoned solvers at one time. Each has a thread that may occupy a processor: with more, nothing else would run.
pub const SOLVERS_LEFT_BEHIND_MAX: usize = 4;
/// Bytes by which the program may grow while a solver runs: a matrix of 5,000 targets takes a fifth of it.
pub const SOLVER_MEMORY_BYTES: u64 = 1 << 30;
/// Wall time between the stop request to a solver program and its forced end: less than [`SOLVER_GRACE`], so that none is abandoned.
pub const SOLVER_STOP_TIMEOUT: std::time::Duration = std::time::Duration::from_millis(500);
/// Maximum number of bytes of one line of a solver program: a plan of 100,000 visits takes half of it.
pub const SOLVER_LINE_BYTES_MAX: u64 = 16 << 20;
/// Maximum number of bytes of all lines of a solver program for one problem: a thousand reports of plans with a thousand visits.
pub const SOLVER_OUTPUT_BYTES_MAX: u64 = 256 << 20;
/// Maximum number of bytes that a solver program may write to standard error: they are read and discarded, which takes time.
pub const SOLVER_ERROR_BYTES_MAX: u64 = 16 << 20;
/// Maximum number of bytes of standard error that are kept to explain an end without an answer.
pub const SOLVER_LAST_WORDS: usize = 4 << 10;
/// Maximum number of kept characters of a solver's reason: it enters the record and the causes of tasks.
pub const SOLVER_WORDS_MAX: usize = 2_000;
/// Maximum number of printed messages about bad input lines; a file in the wrong format has the same error in every line.
pub const INPUT_MESSAGES_MAX: usize = 20;
/// Maximum number of bytes of one line of input: far more than any message, less than a file without line ends.
pub const INPUT_LINE_BYTES_MAX: usize = 1 << 20;
/// Maximum number of ended tasks whose goals are remembered: lines about an ended task follow soon after its end.
pub const ENDED_GOALS_MAX: usize = 10_000;
/// Maximum number of live sources other than operators and safing programs at a time.
pub const LIVE_SOURCES_MAX: usize = 64;
/// Maximum number of inputs of live sources in one step: it then takes some milliseconds, and operators are served again.
pub const LIVE_TAKE_MAX: usize = 256;
/// Time between two steps with inputs of vehicles and feeds that flood the run; operators do not wait for it.
pub const LIVE_REST: std::time::Duration = std::time::Duration::from_millis(2);
/// Interval at which a run that is never idle lets its observers write their held-back data.
pub const FLUSH_INTERVAL: std::time::Duration = std::time::Duration::from_millis(20);
/// Interval of reports about lost inputs of a live source.
pub const LIVE_REPORT_INTERVAL: std::time::Duration = std::time::Duration::from_secs(1);
/// Maximum number of batches that are committed together: a crash loses no more.
pub const GROUP_BATCHES_MAX: u32 = 256;
/// Milliseconds of wall time after which even a small group is committed, so that live readers see it.
pub const GROUP_MILLISECONDS_MAX: u128 = 200;
/// Maximum number of bytes of the newest steps that are kept in memory while the disk takes none: an hour of a busy flight.
pub const RECORDING_KEPT_BYTES_MAX: usize = 64 << 20;
/// Wall time between attempts to continue a record whose disk failed.
pub const RECORDING_RETRY_INTERVAL: std::time::Duration = std::time::Duration::from_secs(1);
/// Number of attempts to continue a record in its own file before it continues in a new segment: a disk that was full only briefly leaves
/// one file.
pub const RECORDING_SEGMENT_ATTEMPTS: u32 = 2;
/// Interval at which committed groups move from the write-ahead log into the main file: a plain copy of that file lacks no more than
/// this.
pub const CHECKPOINT_INTERVAL: std::time::Duration = std::time::Duration::from_secs(1);
/// Batches between snapshots, at least.
pub const SNAPSHOT_BATCHES_MIN: u64 = 500;
/// Batches after which a snapshot is taken even if it is bigger than the input since the last one.
pub const SNAPSHOT_BATCHES_MAX: u64 = 20_000;
/// Greatest size of a snapshot in bytes: above, replaying the inputs is cheaper.
pub const SNAPSHOT_BYTES_MAX: usize = 16 << 20;
/// Maximum number of candidates that an ambiguous or unknown task name lists.
pub const CANDIDATES_MAX: usize = 12;
/// Default depth of a chain of causes: it mostly reaches a form of the program.
pub const EXPLANATION_DEPTH_DEFAULT: usize = 6;
/// Maximum number of links of one chain of causes: more than a reader needs, and few enough for a fast answer.
pub const EXPLANATION_LINKS_MAX: usize = 200;
/// Maximum number of steps that one question about a missing task inspects.
pub const MISSING_STEPS_MAX: usize = 10_000;
