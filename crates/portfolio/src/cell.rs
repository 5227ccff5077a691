//! The space of the paper's Figure 4: 243 cells of missions of surveillance.
//!
//! A cell fixes five features: the number of targets, their distribution, the size of the map, and the variation between targets of the
//! rate at which costs accumulate and of their importance. Test missions are drawn from cells; given missions are assigned to them.

use apex_planning::validate::TARGETS_MAX;
use std::fmt;
use std::str::FromStr;

/// Counts of targets of the 243 cells.
pub const COUNTS: [usize; 3] = [4, 8, 16];

/// The size of the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Scale {
    /// A side of 16 km: a tour takes much of the mission.
    Large,
    /// A side of 4 km.
    Medium,
    /// A side of 1 km: many tours fit.
    Small,
}

/// Distribution of a quantity over targets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Spread {
    /// Half of the targets have little of it, half have much.
    Clustered,
    /// All targets have the same amount.
    Fixed,
    /// Each target has a random amount between little and much.
    Uniform,
}

/// Distribution of targets in space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Space {
    /// In two clusters.
    TwoClusters,
    /// In one cluster.
    Globular,
    /// Anywhere on the map.
    Uniform,
}

/// One cell of the space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Cell {
    /// Size of the map.
    pub scale: Scale,
    /// Spread of the rate at which the cost of ignorance gathers.
    pub rate: Spread,
    /// Spread of importance: the cost of an event that is never found.
    pub cost: Spread,
    /// Number of targets.
    pub count: usize,
    /// Distribution of the targets in space.
    pub space: Space,
}

impl Scale {
    /// Every scale, in the order of the rows of Figure 4.
    pub const ALL: [Scale; 3] = [Scale::Large, Scale::Medium, Scale::Small];

    /// Returns the side of the square map.
    pub fn side_m(self) -> f64 {
        match self {
            Scale::Large => 16_000.0,
            Scale::Medium => 4_000.0,
            Scale::Small => 1_000.0,
        }
    }

    /// Returns its word in names of cells.
    pub fn word(self) -> &'static str {
        match self {
            Scale::Large => "large",
            Scale::Medium => "medium",
            Scale::Small => "small",
        }
    }
}

impl Spread {
    /// Every spread.
    pub const ALL: [Spread; 3] = [Spread::Clustered, Spread::Fixed, Spread::Uniform];

    /// Returns its word in names of cells.
    pub fn word(self) -> &'static str {
        match self {
            Spread::Clustered => "clustered",
            Spread::Fixed => "fixed",
            Spread::Uniform => "uniform",
        }
    }
}

impl Space {
    /// Every distribution, in the order of the columns of Figure 4.
    pub const ALL: [Space; 3] = [Space::TwoClusters, Space::Globular, Space::Uniform];

    /// Returns its word in names of cells.
    pub fn word(self) -> &'static str {
        match self {
            Space::TwoClusters => "two-cluster",
            Space::Globular => "globular",
            Space::Uniform => "uniform",
        }
    }
}

impl Cell {
    /// Returns all 243, by scale, rate, cost, count and space.
    pub fn all() -> Vec<Cell> {
        let mut cells = Vec::with_capacity(243);
        for scale in Scale::ALL {
            for rate in Spread::ALL {
                for cost in Spread::ALL {
                    for count in COUNTS {
                        cells.extend(Space::ALL.map(|space| Cell { scale, rate, cost, count, space }));
                    }
                }
            }
        }
        cells
    }

    /// Returns 27 cells that represent all: every pair of levels of any two of count, scale, space and the two spreads occurs equally often
    /// (an orthogonal array of strength two).
    pub fn subset() -> Vec<Cell> {
        let level = |number: usize| (number / 9, number / 3 % 3, number % 3);
        let kept = |(index, cell): (usize, Cell)| {
            let (scale, rate, rest) = (index / 81, index / 27 % 3, index % 27);
            let (cost, count, space) = level(rest);
            ((scale + rate + count) % 3 == cost && (scale + 2 * rate + count) % 3 == space).then_some(cell)
        };
        Cell::all().into_iter().enumerate().filter_map(kept).collect()
    }
}

impl Cell {
    /// Returns its words, each with the name of the classifier that determines it.
    pub fn words(&self) -> [(&'static str, String); 5] {
        let Cell { scale, rate, cost, count, space } = self;
        [
            ("scale", scale.word().to_string()),
            ("rate", rate.word().to_string()),
            ("cost", cost.word().to_string()),
            ("count", count.to_string()),
            ("space", space.word().to_string()),
        ]
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Cell { scale, rate, cost, count, space } = self;
        write!(f, "{}-{}-{}-{count}-{}", scale.word(), rate.word(), cost.word(), space.word())
    }
}

impl FromStr for Cell {
    type Err = String;

    /// Reads `SCALE-RATE-COST-COUNT-SPACE`, for example `small-clustered-fixed-8-two-cluster`. The count is free.
    fn from_str(text: &str) -> Result<Cell, String> {
        let parts: Vec<&str> = text.splitn(5, '-').collect();
        let [scale, rate, cost, count, space] = parts.as_slice() else {
            return Err(format!(
                "{text} is not a cell: write SCALE-RATE-COST-COUNT-SPACE, for example small-clustered-fixed-8-two-cluster"
            ));
        };
        let spread = |what: &str, word: &str| {
            Spread::ALL.into_iter().find(|spread| spread.word() == word).ok_or_else(|| {
                format!("{word} is not a spread of {what} (in {text}): it is clustered, fixed or uniform")
            })
        };
        let scale = Scale::ALL.into_iter().find(|known| known.word() == *scale);
        let count = count.parse().ok().filter(|count| (1..=TARGETS_MAX).contains(count));
        let space = Space::ALL.into_iter().find(|known| known.word() == *space);
        Ok(Cell {
            scale: scale
                .ok_or_else(|| format!("{text} does not begin with a scale, which is large, medium or small"))?,
            rate: spread("rates", rate)?,
            cost: spread("costs", cost)?,
            count: count.ok_or_else(|| {
                format!("{text} has no count of targets, which is a number from 1 to {}", TARGETS_MAX)
            })?,
            space: space.ok_or_else(|| {
                format!("{text} does not end with a space, which is two-cluster, globular or uniform")
            })?,
        })
    }
}
