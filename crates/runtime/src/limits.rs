//! Every limit of the runtime, with its reason. The executive's limits are in `apex_model::limits`.

/// Inputs waiting in the inbox: a few batches of the largest size. A vehicle that says more at once is broken.
pub const INBOX_INPUTS_MAX: usize = 4 * apex_model::limits::BATCH_EVENTS_MAX;
/// Executive steps at one instant. Command, acknowledgement and next command may take no time, but not forever.
pub const STEPS_PER_INSTANT_MAX: u64 = 10_000;
/// Rounds at one instant in which agents answer each other; what they say to each other after that is not delivered.
pub const CONVERSATION_ROUNDS_MAX: u32 = 1_000;
/// A paced step that comes later than this is reported: operators do not notice less, and timers of ordinary systems are not better
/// than a few milliseconds when they are busy.
pub const LATENESS_TOLD_MIN: std::time::Duration = std::time::Duration::from_millis(50);
/// A solver's answer that comes later than this after the work that it charges is reported: a plan is made for a place and a time, and
/// ordinary systems are late by less.
pub const ANSWER_LATE_TOLD_MIN: apex_model::time::Duration = apex_model::time::Duration(1_000_000_000);
/// Stack of a solver's thread in bytes: recursive planners go deeper than the mission loop.
pub const SOLVER_STACK_BYTES: usize = 64 << 20;
/// Interval of checks of a working solver: short enough to stop one that fills the memory.
pub const SOLVER_LOOK: std::time::Duration = std::time::Duration::from_millis(10);
/// Time that a solver has to stop when cancelled; well-behaved ones take some milliseconds.
pub const SOLVER_GRACE: std::time::Duration = std::time::Duration::from_secs(1);
/// Work units that a solver may charge after its budget's double, or after it was cancelled, before it is thrown out.
pub const SOLVER_OVERRUN_UNITS: u64 = 1_000_000;
/// Wall time after which a solver that does not return is abandoned; its budget is counted in work, so this is far off.
pub const SOLVER_TIMEOUT: std::time::Duration = std::time::Duration::from_secs(300);
/// Solvers left behind at one time, each with a thread that may take a processor: with more, nothing else gets its turn.
pub const SOLVERS_LEFT_BEHIND_MAX: usize = 4;
/// Bytes by which the program may grow while a solver works: a matrix of 5,000 targets takes a fifth of it.
pub const SOLVER_MEMORY_BYTES: u64 = 1 << 30;
/// Wall time between the last word to a solver program and its end: less than [`SOLVER_GRACE`], so that none is left behind.
pub const SOLVER_STOP_PATIENCE: std::time::Duration = std::time::Duration::from_millis(500);
/// Bytes of one line of a solver program: the plan of 100,000 visits takes half of it.
pub const SOLVER_LINE_BYTES_MAX: u64 = 16 << 20;
/// Bytes of all lines of a solver program for one problem: a thousand reports of plans with a thousand visits.
pub const SOLVER_OUTPUT_BYTES_MAX: u64 = 256 << 20;
/// Bytes that a solver program may write to standard error: they are read and dropped, which takes time.
pub const SOLVER_ERROR_BYTES_MAX: u64 = 16 << 20;
/// Bytes of standard error that are kept to explain an end without an answer.
pub const SOLVER_LAST_WORDS: usize = 4 << 10;
/// Characters of a solver's reason that are kept: it enters the record and the causes of tasks.
pub const SOLVER_WORDS_MAX: usize = 2_000;
/// Messages about bad input lines that are printed; a file in the wrong format has the same fault in every line.
pub const INPUT_MESSAGES_MAX: usize = 20;
/// Bytes of one line of input: far more than any message, less than a file without line ends.
pub const INPUT_LINE_BYTES_MAX: usize = 1 << 20;
/// Ended tasks whose goals are remembered: lines about an ended task come soon after its end.
pub const ENDED_GOALS_MAX: usize = 10_000;
/// Live sources other than operators and safing programs at a time.
pub const LIVE_SOURCES_MAX: usize = 64;
/// Inputs of live sources in one step: it is over in some milliseconds, and operators are heard again.
pub const LIVE_TAKE_MAX: usize = 256;
/// Time between two steps that take from vehicles and feeds, where they flood; operators do not wait for it.
pub const LIVE_REST: std::time::Duration = std::time::Duration::from_millis(2);
/// Time after which a run that is never idle lets its observers write out what they hold back.
pub const FLUSH_INTERVAL: std::time::Duration = std::time::Duration::from_millis(20);
/// Time between two reports of what a live source has lost.
pub const LIVE_REPORT_INTERVAL: std::time::Duration = std::time::Duration::from_secs(1);
/// Batches that are committed together: a crash loses no more.
pub const GROUP_BATCHES_MAX: u32 = 256;
/// Milliseconds of wall time after which a group is committed even when it is small, so that live readers see it.
pub const GROUP_MILLISECONDS_MAX: u128 = 200;
/// Bytes of the newest steps that are kept in memory while the disk takes none: an hour of a busy flight.
pub const RECORDING_KEPT_BYTES_MAX: usize = 64 << 20;
/// Wall time between attempts to continue a record whose disk failed.
pub const RECORDING_RETRY_INTERVAL: std::time::Duration = std::time::Duration::from_secs(1);
/// Attempts to continue a record in its own file before it continues in a new segment: a disk that was full for a moment leaves one file.
pub const RECORDING_SEGMENT_ATTEMPTS: u32 = 2;
/// Interval at which committed groups move from the write-ahead log into the main file: a plain copy of it lacks no more.
pub const CHECKPOINT_INTERVAL: std::time::Duration = std::time::Duration::from_secs(1);
/// Batches between snapshots, at least.
pub const SNAPSHOT_BATCHES_MIN: u64 = 500;
/// Batches after which a snapshot is taken even when it is bigger than the input since the last one.
pub const SNAPSHOT_BATCHES_MAX: u64 = 20_000;
/// Bytes of one snapshot: beyond, restoring by replay is the better bargain.
pub const SNAPSHOT_BYTES_MAX: usize = 16 << 20;
/// Candidates that an ambiguous or unknown task name lists.
pub const CANDIDATES_MAX: usize = 12;
/// Links of a chain of causes below one another, unless asked otherwise: back to a form of the program in most cases.
pub const EXPLANATION_DEPTH_DEFAULT: usize = 6;
/// Links of one chain of causes: more than a reader needs, few enough for an answer at once.
pub const EXPLANATION_LINKS_MAX: usize = 200;
/// Steps that one question about something missing inspects.
pub const MISSING_STEPS_MAX: usize = 10_000;
