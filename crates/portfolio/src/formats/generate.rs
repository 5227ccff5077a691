//! Generated instances in the formats of the benchmark files, for tests and measurements without a network.
//!
//! They resemble the published families (Solomon's six, Cordeau's two, OPLib, TSPLIB matrices) in size, extent, service, profits and
//! windows; none is a copy. Golden hashes in the tests detect changes.

use apex_planning::random::Generator;
use std::fmt::Write;

/// A family of instances with windows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Clustered, random or mixed places (`c`, `r`, `rc`), short (1) or long (2) day: Solomon's six, 100 targets.
    Solomon(Places, Day),
    /// `targets` targets in clusters around seeds, with narrow or wide windows: Cordeau's two families.
    Cordeau {
        /// Targets.
        targets: usize,
        /// True if windows are twice as long.
        wide: bool,
    },
}

/// Distribution of places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Places {
    /// In ten clusters.
    Clustered,
    /// Anywhere.
    Random,
    /// Half and half.
    Mixed,
}

/// Opening time of the depot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Day {
    /// A dozen visits fit.
    Short,
    /// Some dozens fit.
    Long,
}

/// Returns 76 instances like those on which planners for orienteering with time windows are compared: name and text.
pub fn windows_suite() -> Vec<(String, String)> {
    let solomon = [
        ("c1", Places::Clustered, Day::Short, 9),
        ("r1", Places::Random, Day::Short, 12),
        ("rc1", Places::Mixed, Day::Short, 8),
        ("c2", Places::Clustered, Day::Long, 8),
        ("r2", Places::Random, Day::Long, 11),
        ("rc2", Places::Mixed, Day::Long, 8),
    ];
    let mut suite = Vec::new();
    for (name, places, day, count) in solomon {
        for number in 1..=count {
            let family = Family::Solomon(places, day);
            suite.push((format!("{name}{number:02}"), windows(family, number)));
        }
    }
    let sizes = [48, 96, 144, 192, 240, 288, 72, 144, 216, 288];
    for (number, (wide, targets)) in [false, true].iter().flat_map(|wide| sizes.map(|size| (*wide, size))).enumerate() {
        let number = number as u64 + 1;
        suite.push((format!("pr{number:02}"), windows(Family::Cordeau { targets, wide }, number)));
    }
    suite
}

/// Returns the instance `number` of `family`, as TOPTW text.
pub fn windows(family: Family, number: u64) -> String {
    match family {
        Family::Solomon(places, day) => solomon(places, day, number),
        Family::Cordeau { targets, wide } => cordeau(targets, wide, number),
    }
}

fn solomon(places: Places, day: Day, number: u64) -> String {
    let long = day == Day::Long;
    let (closes, service, profits) = match (places, long) {
        (Places::Clustered, false) => (1236, 90, 5),
        (Places::Clustered, true) => (3390, 90, 5),
        (Places::Random, false) => (230, 10, 41),
        (Places::Random, true) => (1000, 10, 41),
        (Places::Mixed, false) => (240, 10, 4),
        (Places::Mixed, true) => (960, 10, 4),
    };
    // Places and profits belong to the family; windows belong to the instance.
    let of_family = match places {
        Places::Clustered => 11,
        Places::Random => 22,
        Places::Mixed => 33,
    };
    let mut chance = Generator::new(of_family);
    let at = drawn(places, &mut chance);
    let profit = |chance: &mut Generator| match profits {
        41 => 1 + chance.below(41),
        most => 10 * (1 + chance.below(most)),
    };
    let profits: Vec<usize> = at.iter().map(|_| profit(&mut chance)).collect();
    let mut chance = Generator::new(of_family * 1_000 + u64::from(long) * 500 + number);
    // Instances come in groups of four: within a group ever fewer targets have windows, and each group has wider windows than the last.
    let share = 1.0 - 0.25 * ((number - 1) % 4) as f64;
    let half_width = 0.02 * f64::from(closes) * (1.0 + 1.5 * ((number - 1) / 4) as f64);
    let mut text = format!("4 10 {} 1\n0 200\n0 50 50 0 0 0 0 0 {closes}\n", at.len());
    for (index, ((x, y), profit)) in at.iter().zip(&profits).enumerate() {
        let way = libm::hypot(x - 50.0, y - 50.0);
        let (first, last) = (libm::ceil(way), f64::from(closes) - libm::ceil(way) - f64::from(service));
        let middle = first + (last - first) * chance.unit();
        let half = half_width * (0.75 + 0.5 * chance.unit());
        let (opens, closes) = if chance.unit() < share {
            (libm::floor(middle - half).max(first), libm::floor(middle + half).min(last))
        } else {
            (0.0, last)
        };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{} {x} {y} {service} {profit} 1 1 1 {opens} {}", index + 1, closes.max(opens));
    }
    text
}

/// Returns a hundred places on whole numbers in 0..100.
fn drawn(places: Places, chance: &mut Generator) -> Vec<(f64, f64)> {
    let centres: Vec<(f64, f64)> =
        (0..10).map(|_| (10.0 + 80.0 * chance.unit(), 10.0 + 80.0 * chance.unit())).collect();
    let place = |index: usize| {
        let clustered = match places {
            Places::Clustered => true,
            Places::Random => false,
            Places::Mixed => index.is_multiple_of(2),
        };
        let centre = centres.get(index / 2 % 10).copied().filter(|_| clustered);
        let (x, y) = match centre {
            Some((x, y)) => (x + 4.0 * normal(chance), y + 4.0 * normal(chance)),
            None => (100.0 * chance.unit(), 100.0 * chance.unit()),
        };
        (libm::round(x.clamp(0.0, 100.0)), libm::round(y.clamp(0.0, 100.0)))
    };
    (0..100).map(place).collect()
}

fn cordeau(targets: usize, wide: bool, number: u64) -> String {
    let mut chance = Generator::new(44_000 + number);
    let closes = 1000.0;
    let seeds: Vec<(f64, f64)> =
        (0..2 + targets / 48).map(|_| (100.0 * chance.unit() - 50.0, 100.0 * chance.unit() - 50.0)).collect();
    let mut text = format!("4 4 {targets} 1\n0 200\n");
    let (x, y) = (20.0 * chance.unit() - 10.0, 20.0 * chance.unit() - 10.0);
    let _ = writeln!(text, "0 {x:.3} {y:.3} 0 0 0 0 0 {closes}");
    for index in 1..=targets {
        let seed = seeds.get(chance.below(seeds.len())).copied().unwrap_or((0.0, 0.0));
        let (px, py) = (seed.0 + 18.0 * normal(&mut chance), seed.1 + 18.0 * normal(&mut chance));
        let (service, profit) = (1 + chance.below(25), 1 + chance.below(25));
        let way = libm::ceil(libm::hypot(px - x, py - y));
        let width = (90.0 + 90.0 * chance.unit()) * if wide { 2.0 } else { 1.0 };
        let last = closes - way - service as f64;
        let opens = libm::floor(way + (last - way - width).max(0.0) * chance.unit());
        let shut = libm::floor((opens + width).min(last)).max(opens);
        let _ = writeln!(text, "{index} {px:.3} {py:.3} {service} {profit} 1 1 1 {opens} {shut}");
    }
    text
}

/// Returns an orienteering instance with `nodes` nodes, depot included, whose limit is about `share` of the length of a tour of all.
pub fn oplib(nodes: usize, share: f64, number: u64) -> String {
    let mut chance = Generator::new(55_000 + 7 * nodes as u64 + number);
    let side = 1000.0;
    // Beardwood, Halton, Hammersley: the length of the shortest tour of many places.
    let limit = libm::round(share * 0.7124 * libm::sqrt(nodes as f64) * side);
    let mut text = format!(
        "NAME : apex-op-{nodes}-{number}\nCOMMENT : made by Apex\nTYPE : OP\nDIMENSION : {nodes}\nCOST_LIMIT : {limit}\n\
         EDGE_WEIGHT_TYPE : EUC_2D\nNODE_COORD_SECTION\n"
    );
    for node in 1..=nodes {
        let (x, y) = (libm::round(side * chance.unit()), libm::round(side * chance.unit()));
        let _ = writeln!(text, "{node} {x} {y}");
    }
    text.push_str("NODE_SCORE_SECTION\n");
    for node in 1..=nodes {
        let score = if node == 1 { 0 } else { 1 + chance.below(100) };
        let _ = writeln!(text, "{node} {score}");
    }
    text.push_str("DEPOT_SECTION\n1\n-1\nEOF\n");
    text
}

/// Returns an asymmetric travelling salesman problem of `nodes` nodes, as a full matrix.
pub fn atsp(nodes: usize, number: u64) -> String {
    let mut chance = Generator::new(66_000 + number);
    let places: Vec<(f64, f64)> = (0..nodes).map(|_| (100.0 * chance.unit(), 100.0 * chance.unit())).collect();
    let mut text = format!(
        "NAME: apex-atsp-{nodes}-{number}\nTYPE: ATSP\nDIMENSION: {nodes}\nEDGE_WEIGHT_TYPE: EXPLICIT\n\
         EDGE_WEIGHT_FORMAT: FULL_MATRIX\nEDGE_WEIGHT_SECTION\n"
    );
    for from in &places {
        for to in &places {
            let _ = write!(
                text,
                " {}",
                libm::ceil(libm::hypot(from.0 - to.0, from.1 - to.1) * (1.0 + 0.2 * chance.unit()))
            );
        }
        text.push('\n');
    }
    text.push_str("EOF\n");
    text
}

/// Returns an approximately standard normal number: the sum of twelve uniform ones.
fn normal(chance: &mut Generator) -> f64 {
    (0..12).map(|_| chance.unit()).sum::<f64>() - 6.0
}
