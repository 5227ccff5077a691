//! The classifiers on the test missions: how often they determine the cell from which a mission was drawn.

use super::*;
use crate::cell::Cell;
use apex_model::problem::{CostFunction, EventRate};
use std::collections::BTreeMap;

/// Counts of (feature, true value, determined value) over `missions` missions of every cell.
type Confusion = BTreeMap<(&'static str, String, &'static str), u32>;

/// Returns the confusion, and how many missions of 4, 8 and 16 targets have all features right.
fn confusion(missions: u64) -> (Confusion, [u32; 3]) {
    let (mut counts, mut whole) = (BTreeMap::new(), [0; 3]);
    for cell in Cell::all() {
        for number in 100..100 + missions {
            let problem = cell.mission(number);
            let read = classify(&problem).unwrap();
            let mut right = true;
            for (feature, (name, word)) in read.iter().zip(cell.words()) {
                assert_eq!(feature.name, name);
                right &= feature.bin == word;
                *counts.entry((name, word, feature.bin)).or_insert(0) += 1;
            }
            whole[cell.count.ilog2() as usize - 2] += u32::from(right);
        }
    }
    (counts, whole)
}

#[test]
fn cells_are_recovered_from_their_missions() {
    let (counts, whole) = confusion(4);
    for ((name, word, bin), count) in &counts {
        println!("{name:>6} {word:>12} read as {bin:>12} {count:>5}");
    }
    let share = |name: &str| {
        let of = counts.iter().filter(|((feature, _, _), _)| *feature == name);
        let right: u32 = of.clone().filter(|((_, word, bin), _)| word == bin).map(|(_, count)| count).sum();
        f64::from(right) / f64::from(of.map(|(_, count)| count).sum::<u32>())
    };
    println!("all five right of 324 missions each of 4, 8 and 16 targets: {whole:?}");
    let whole = f64::from(whole.iter().sum::<u32>()) / f64::from(4 * 243_u32);
    let read = CLASSIFIERS.iter().map(|one| format!("{} {:.3}", one.name(), share(one.name()))).collect::<Vec<_>>();
    println!("{}; all five {whole:.3}", read.join(", "));
    assert_eq!(share("count"), 1.0);
    assert!(share("cost") > 0.97 && share("rate") > 0.97, "{read:?}");
    assert!(share("scale") > 0.88 && share("space") > 0.88 && whole > 0.85, "{read:?} {whole}");
}

#[test]
fn speed_and_direction_of_the_map_do_not_matter() {
    for number in 0..5 {
        let cell: Cell = "medium-uniform-clustered-16-two-cluster".parse().unwrap();
        let mut problem = cell.mission(number);
        let before = classify(&problem).unwrap();
        // The map rotated by 90 degrees and twice as large, flown at twice the speed: the same travel times.
        for target in &mut problem.targets {
            let (east, north) = (target.position.longitude_deg + 122.1, target.position.latitude_deg - 37.4);
            target.position.longitude_deg = -122.1 - 2.0 * north / 0.7944;
            target.position.latitude_deg = 37.4 + 2.0 * east * 0.7944;
        }
        let after = classify(&problem).unwrap();
        let bins = |read: &[Feature]| read.iter().map(|feature| feature.bin).collect::<Vec<_>>();
        assert_eq!(bins(&before), bins(&after));
        assert_eq!(bins(&before), ["medium", "uniform", "clustered", "16", "two-cluster"]);
    }
}

#[test]
fn counts_between_bins_go_to_the_nearer_by_ratio() {
    let bin = |count: usize| {
        let cell = Cell { count, ..Cell::all()[0] };
        classify(&cell.mission(0)).unwrap().iter().find(|feature| feature.name == "count").unwrap().bin
    };
    assert_eq!([5, 6, 11, 12, 100].map(bin), ["4", "8", "8", "16", "16"]);
}

#[test]
fn odd_missions_are_classified_too() {
    let one = Cell { count: 1, ..Cell::all()[0] }.mission(0);
    assert_eq!(classify(&one).unwrap().len(), CLASSIFIERS.len());
    // All targets at one place, without events, with costs of other kinds.
    let mut problem = Cell::all()[0].mission(0);
    let place = problem.targets[0].position;
    for target in &mut problem.targets {
        (target.position, target.rate) = (place, EventRate { steps: Vec::new() });
        target.cost = CostFunction::Linear { cost_per_s: 1.0 };
    }
    problem.travel.between_s = vec![vec![0.0; 4]; 4];
    let read = classify(&problem).unwrap();
    assert_eq!((read[1].bin, read[2].bin), ("fixed", "fixed"));
    assert!(read.iter().all(|feature| feature.reading.distances.iter().all(|distance| !distance.is_nan())), "{read:?}");
    problem.horizon_s = f64::NAN;
    assert!(classify(&problem).is_err());
}

/// A third party's classifier: true if the vehicle must return.
struct Return;

impl Classifier for Return {
    fn name(&self) -> &'static str {
        "return"
    }
    fn bins(&self) -> &'static [&'static str] {
        &["no", "yes"]
    }
    fn read(&self, given: &ClassifierInput<'_>) -> Classification {
        let asked = f64::from(u8::from(given.problem().return_to_base));
        Classification { numbers: vec![("asked for", asked)], distances: vec![asked, 1.0 - asked] }
    }
}

#[test]
fn third_parties_add_classifiers() {
    let list: Vec<&dyn Classifier> = CLASSIFIERS.iter().copied().chain([&Return as &dyn Classifier]).collect();
    let mut problem = Cell::all()[0].mission(0);
    assert_eq!(classify_with(&list, &problem).unwrap()[5].bin, "no");
    problem.return_to_base = true;
    let read = classify_with(&list, &problem).unwrap();
    assert_eq!((read[5].bin, read[5].distance("no"), read[5].distance("maybe")), ("yes", Some(1.0), None));
    assert!(described(&read).ends_with("return yes (asked for 1)"), "{}", described(&read));
}
