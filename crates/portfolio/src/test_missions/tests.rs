//! Test missions: their properties, reading of their names, and golden hashes.

use crate::cell::{Cell, Spread};
use apex_model::problem::CostFunction;
use std::collections::BTreeSet;

/// Returns one line for each cell: its name, and the hash over the hashes of its first 50 missions.
fn golden() -> String {
    Cell::all().into_iter().map(|cell| format!("{cell} {}\n", cell.hash(50))).collect()
}

#[test]
fn missions_do_not_drift() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/data/test-missions.txt");
    let now = golden();
    if std::env::var("UPDATE").is_ok_and(|value| value == "1") {
        std::fs::write(path, &now).unwrap();
    }
    let committed = std::fs::read_to_string(path).unwrap();
    let different = now.lines().zip(committed.lines()).filter(|(now, then)| now != then).count();
    assert!(
        different == 0 && now.lines().count() == committed.lines().count(),
        "{different} cells have other missions than the committed hashes say; a new generator needs a new version"
    );
}

#[test]
fn names_of_cells_are_read_back() {
    let cells = Cell::all();
    assert_eq!(cells.len(), 243);
    assert_eq!(cells.iter().collect::<BTreeSet<_>>().len(), 243);
    for cell in cells {
        assert_eq!(cell.to_string().parse(), Ok(cell));
    }
    assert_eq!("small-fixed-uniform-100-globular".parse::<Cell>().unwrap().mission(1).targets.len(), 100);
    let refused = |text: &str| text.parse::<Cell>().unwrap_err();
    assert!(refused("small").contains("write SCALE-RATE-COST-COUNT-SPACE"));
    assert!(refused("huge-fixed-fixed-4-uniform").contains("large, medium or small"));
    assert!(refused("small-fixed-wild-4-uniform").contains("wild is not a spread of costs"));
    assert!(refused("small-fixed-fixed-0-uniform").contains("a number from 1 to"));
    assert!(refused("small-fixed-fixed-4-square").contains("two-cluster, globular or uniform"));
}

#[test]
fn the_subset_is_balanced() {
    let subset = Cell::subset();
    assert_eq!(subset.len(), 27);
    let levels =
        |cell: &Cell| [cell.scale as usize, cell.rate as usize, cell.cost as usize, cell.count, cell.space as usize];
    for (one, other) in (0..5).flat_map(|one| (one + 1..5).map(move |other| (one, other))) {
        let mut pairs: Vec<(usize, usize)> =
            subset.iter().map(|cell| (levels(cell)[one], levels(cell)[other])).collect();
        pairs.sort_unstable();
        let different: BTreeSet<(usize, usize)> = pairs.iter().copied().collect();
        assert_eq!(different.len(), 9, "features {one} and {other}");
        assert!(different.iter().all(|pair| pairs.iter().filter(|found| *found == pair).count() == 3));
    }
}

#[test]
fn missions_are_what_their_cell_says() {
    for cell in Cell::all() {
        let problem = cell.mission(3);
        apex_planning::validate::surveillance(&problem).unwrap();
        assert_eq!(problem.targets.len(), cell.count);
        let importance: Vec<f64> = problem
            .targets
            .iter()
            .map(|target| match target.cost {
                CostFunction::Saturating { maximum, .. } => maximum,
                _ => f64::NAN,
            })
            .collect();
        match cell.cost {
            Spread::Fixed => assert!(importance.iter().all(|cost| *cost == 1.0)),
            Spread::Uniform => assert!(importance.iter().all(|cost| (0.1..1.9).contains(cost))),
            Spread::Clustered => {
                assert_eq!(importance.iter().filter(|cost| (0.18..0.22).contains(*cost)).count(), cell.count / 2);
                assert_eq!(importance.iter().filter(|cost| (1.62..1.98).contains(*cost)).count(), cell.count / 2);
            }
        }
        let farthest_s = problem.travel.between_s.iter().flatten().copied().fold(0.0, f64::max);
        assert!(farthest_s * 20.0 <= cell.scale.side_m() * std::f64::consts::SQRT_2);
    }
}
