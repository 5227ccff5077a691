//! Classes of live sources: their precedence, and the rate of inputs that each may send.

/// Class of a live source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SourceClass {
    /// An operator of the run.
    Operator,
    /// A program that watches over the safety of the vehicle.
    Safing,
    /// The vehicle or its simulator.
    Vehicle,
    /// All other sources: weather, traffic, sensors on the ground.
    Feed,
}

/// Number of ranks of classes; sources of a lower rank are heard first.
pub(super) const RANKS: usize = 3;

impl SourceClass {
    /// All classes.
    pub const ALL: [SourceClass; 4] =
        [SourceClass::Operator, SourceClass::Safing, SourceClass::Vehicle, SourceClass::Feed];

    /// Returns the class as written in an introduction.
    pub fn word(self) -> &'static str {
        match self {
            SourceClass::Operator => "operator",
            SourceClass::Safing => "safing",
            SourceClass::Vehicle => "vehicle",
            SourceClass::Feed => "feed",
        }
    }

    /// Returns the class called `word`.
    pub fn of_word(word: &str) -> Option<SourceClass> {
        SourceClass::ALL.into_iter().find(|class| class.word() == word)
    }

    /// Returns true if a source that introduced itself with this class may acknowledge commands: the vehicle executes them.
    pub(super) fn may_acknowledge(self) -> bool {
        self == SourceClass::Vehicle
    }

    /// Returns true if such a source may answer questions, which are to the operator.
    pub(super) fn may_answer(self) -> bool {
        self == SourceClass::Operator
    }

    /// Returns true if such a source may end the run.
    pub(super) fn may_stop(self) -> bool {
        matches!(self, SourceClass::Operator | SourceClass::Safing)
    }

    /// Operators and safing are heard before vehicles, vehicles before feeds.
    pub(super) fn rank(self) -> usize {
        match self {
            SourceClass::Operator | SourceClass::Safing => 0,
            SourceClass::Vehicle => 1,
            SourceClass::Feed => 2,
        }
    }

    /// Returns the inputs per second of wall time that the run accepts from one source. An autopilot reports some thousands of values a
    /// second.
    pub fn source_rate(self) -> u32 {
        match self {
            SourceClass::Operator | SourceClass::Safing => 10_000,
            SourceClass::Vehicle => 20_000,
            SourceClass::Feed => 2_000,
        }
    }

    /// Returns the number of inputs per second that the run takes from all sources of the class's rank together.
    pub(super) fn rank_rate(self) -> u32 {
        match self {
            SourceClass::Operator | SourceClass::Safing => 20_000,
            SourceClass::Vehicle => 40_000,
            SourceClass::Feed => 5_000,
        }
    }

    /// Returns true if a limit on the number of connections does not apply: a flood of feeds must not keep operators out.
    pub(super) fn is_always_admitted(self) -> bool {
        self.rank() == 0
    }
}
