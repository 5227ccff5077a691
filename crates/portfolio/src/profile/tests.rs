//! Profiles: written and read back, completed, rejected if invalid; the shipped profile is consistent.

use super::*;
use crate::profile::verdict::Verdict;
use proptest::prelude::*;

fn planner(name: &str) -> Planner {
    Planner { name: name.into(), version: "1.0".into() }
}

/// Returns two cells, three missions, two budgets; the second planner costs a tenth more.
fn small() -> Profile {
    let cells = [Cell::all()[0], Cell::all()[242]];
    let mut profile = Profile::empty(&cells, 3, &[1_000, 10_000]);
    let costs = |factor: f64| {
        let budget = |less: f64| [1.0, 2.5, 3.0].map(|cost| file::rounded(factor * cost - less)).to_vec();
        vec![vec![budget(0.0), budget(0.25)], vec![budget(0.125), budget(0.125)]]
    };
    profile.put(planner("quick"), costs(100.0));
    profile.put(planner("slow"), costs(110.0));
    profile
}

#[test]
fn a_profile_is_read_back_and_completed() {
    let mut profile = small();
    let text = profile.to_string();
    assert_eq!(text.parse(), Ok(profile.clone()));
    assert!(text.contains("\nquick 10000 =\n"), "equal costs are written once: {text}");
    let again = profile.rows.iter().map(|row| row.costs[0].clone()).collect();
    profile.put(planner("slow"), again);
    assert_eq!((profile.planners.len(), profile.rows[0].costs(1, 0)), (2, profile.rows[0].costs(0, 0)));
    assert_eq!(profile.outdated(), None);
    profile.rows[1].hash = "0".into();
    assert!(profile.outdated().unwrap().contains("small-uniform-uniform-16-uniform"));
}

#[test]
fn broken_profiles_are_refused_with_their_place() {
    let text = small().to_string();
    let refused = |from: &str, to: &str| text.replacen(from, to, 1).parse::<Profile>().unwrap_err().to_string();
    for (from, to, expected) in [
        ("format 1", "format 9", "2:8: invalid value for format (expected 1)"),
        ("missions 3", "missions many", "4:10: invalid value for missions (expected a number from 1 to 10000)"),
        ("budgets 1000 10000", "budgets 1000 10", "5:14: 10 is not a budget (budgets are work units above 0, rising)"),
        ("planner slow", "planner quick", "7:9: quick is given twice (each planner has one line)"), // english: allow
        ("cell large-", "cell huge-", "8:6: huge-clustered-clustered-4-two-cluster is not a cell"),
        ("quick 1000 1.000000e2", "quick 1000 cheap", "9:12: cheap is not a cost (costs are finite numbers above 0)"),
        ("quick 1000 1.000000e2", "quick 1000 -1", "9:12: -1 is not a cost"),
        ("quick 1000 1.000000e2 ", "quick 1000 ", "the line has 2 costs for 3 missions"),
        ("slow 1000 ", "slow 7 ", "11:1: this line is not expected here (expected the costs of slow at 1000 units"),
        ("quick 1000 1.0", "quick 1000 = 1.0", "9:12: = is not a cost"),
    ] {
        let message = refused(from, to);
        assert!(message.starts_with(expected) || message.contains(expected), "{from} -> {to}: {message}");
    }
    let half = text.get(..text.len() / 2).unwrap();
    assert!(half.parse::<Profile>().is_err());
    assert!("".parse::<Profile>().unwrap_err().to_string().contains("it ends too early"));
    assert!("{}".parse::<Profile>().unwrap_err().to_string().contains("this is not a profile of planners"));
}

proptest! {
    #[test]
    fn no_text_panics(cut in 0..2000usize, garbage in "\\PC{0,12}") {
        let text = small().to_string();
        let cut = text.char_indices().map(|(at, _)| at).take_while(|at| *at <= cut).last().unwrap_or(0);
        let (before, after) = text.split_at(cut);
        let _ = format!("{before}{garbage}{after}").parse::<Profile>();
        let _ = conclusion::read(&format!("{before}{garbage}{after}"));
    }
}

#[test]
fn conclusions_are_read_back() {
    let profile = small();
    let all = conclusion::conclusions(&profile);
    assert_eq!(all.len(), 4);
    // Three missions are too few for Wilcoxon: 2 of 8 choices of signs.
    assert_eq!((all[0].best.as_str(), all[0].verdict, all[0].effect_percent), ("quick", Verdict::Undecided, 9.1));
    assert_eq!(conclusion::read(&conclusion::written(&profile)), Ok(all));
    let foreign = conclusion::read("# x\ncell,budget\nnowhere,1,a,better,b,2").unwrap_err();
    assert_eq!((foreign.line, foreign.message.contains("heading")), (2, true), "{foreign}");
    let heading = "cell,budget_units,best,verdict,next,effect_percent";
    let broken = conclusion::read(&format!("# x\n{heading}\nnowhere,1,a,better,b,2")).unwrap_err();
    assert_eq!(broken.line, 3);
    assert!(broken.message.contains("nowhere is not a cell"), "{broken}");
}

#[test]
fn what_is_measured_is_valid_and_never_worse_with_more_work() {
    let cell: Cell = "medium-clustered-uniform-8-globular".parse().unwrap();
    for name in ["two-opt", "wam", "anytime", "nearest-neighbour"] {
        let solver = apex_solvers::solver(name).unwrap();
        let measured = measure::mission(&cell, 0, solver.as_ref(), &[1_000, 20_000]).unwrap();
        assert!(measured.costs[1] <= measured.costs[0], "{name}: {measured:?}");
        assert_eq!(measured, measure::mission(&cell, 0, solver.as_ref(), &[1_000, 20_000]).unwrap());
    }
    let refused =
        measure::mission(&cell, 0, apex_solvers::solver("single-visit").unwrap().as_ref(), &[10]).unwrap_err();
    assert!(refused.starts_with("single-visit on mission medium-clustered-uniform-8-globular@0"), "{refused}");
}

#[test]
fn the_shipped_profile_is_whole_and_the_table_follows_from_it() {
    let profile: Profile = SHIPPED.parse().unwrap();
    assert_eq!(profile.rows.iter().map(|row| row.cell).collect::<Vec<_>>(), Cell::all());
    assert_eq!((profile.missions, profile.outdated()), (50, None));
    assert!(conclusion::written(&profile) == crate::table::PROFILE, "write it again with `apex profile update`");
}

#[test]
fn the_picture_has_a_square_for_every_cell() {
    let profile = small();
    let picture = picture::svg(&[picture::best(&profile, 0), picture::best(&profile, 1)]);
    assert_eq!(picture.matches("<title>").count(), 4);
    assert!(picture.contains("quick 9.1 % before slow") && picture.ends_with("</svg>\n"));
    assert!(picture::beside_figure_4(&profile, 0).is_err(), "neither planner of the figure was measured");
}
