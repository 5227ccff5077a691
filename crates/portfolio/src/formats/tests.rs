//! Contents and errors of benchmark files; generated files do not change.

use super::generate::{self, Day, Family, Places};
use super::*;
use proptest::prelude::*;
use sha2::{Digest, Sha256};

const SMALL: &str =
    "* a comment\n1 4 2 1\n0 200\n0 10 10 0 0 0 0 0 100\n1 13 13 5 20 1 2 1 2 30 40\n2 10 11 5 7 1 1 1 0 90\n";

fn trouble(text: &str) -> String {
    read("file", text).unwrap_err().to_string()
}

#[test]
fn toptw_is_read_as_its_users_mean_it() {
    let instance = read("small", SMALL).unwrap();
    assert_eq!((instance.name.as_str(), instance.vehicles), ("small", Some(4)));
    assert_eq!(instance.question, ProblemKind::OrienteeringWithWindows);
    let problem = &instance.problem;
    let travel = problem.travel.as_ref().unwrap();
    assert_eq!(travel.from_start_s, [4.2, 1.0], "cut to one decimal");
    assert_eq!((travel.between_s[0][1], travel.to_base_s[1]), (3.6, 1.0));
    let window = &problem.targets[0].windows[0];
    assert!(window.from_s == 30.0 && window.contains(40.0) && !window.contains(40.1), "the closing time counts");
    assert_eq!((problem.targets[0].value, problem.targets[0].manoeuvres[0].duration_s), (20.0, 5.0));
    let cordeau = SMALL.replace("13 13", "13.0001 13");
    assert_eq!(read("c", &cordeau).unwrap().problem.travel.unwrap().from_start_s[0], 4.24, "cut to two decimals");
}

#[test]
fn solomons_own_text_is_read_with_the_demand_as_profit() {
    let text = "R1\n\nVEHICLE\nNUMBER     CAPACITY\n  25         200\n\nCUSTOMER\nCUST NO.  XCOORD.   YCOORD.    DEMAND   READY TIME  DUE DATE   SERVICE   TIME\n\n    0      35  35 0 0 230 0\n    1      41  49 10 161 171 10\n";
    let instance = read("file", text).unwrap();
    assert_eq!((instance.name.as_str(), instance.vehicles), ("R1", Some(25)));
    assert_eq!(instance.problem.travel.unwrap().from_start_s, [15.2]);
    assert_eq!(instance.problem.targets[0].value, 10.0);
}

#[test]
fn oplib_and_tsplib_are_read() {
    let op = "NAME : t\nTYPE : OP\nDIMENSION : 3\nCOST_LIMIT : 14\nEDGE_WEIGHT_TYPE : EUC_2D\nNODE_COORD_SECTION\n1 0 0\n2 3 4\n3 0 9\nNODE_SCORE_SECTION\n1 0\n2 5\n3 8\nDEPOT_SECTION\n 1\n -1\nEOF\n";
    let instance = read("file", op).unwrap();
    assert_eq!((instance.name.as_str(), instance.question), ("t", ProblemKind::Orienteering));
    assert_eq!(instance.problem.end_s, Some(14.5));
    assert_eq!(instance.problem.travel.as_ref().unwrap().from_start_s, [5.0, 9.0]);
    let names: Vec<&str> = instance.problem.targets.iter().map(|target| target.name.as_str()).collect();
    assert_eq!(names, ["2", "3"]);
    let other = read("file", &op.replace("\n 1\n -1", "\n 3\n -1")).unwrap().problem;
    assert_eq!(other.travel.unwrap().from_start_s, [9.0, 6.0], "from node 3");
}

#[test]
fn every_layout_of_a_matrix_says_the_same() {
    let head = |layout: &str| {
        format!(
            "NAME: m\nTYPE: TSP\nDIMENSION: 3\nEDGE_WEIGHT_TYPE: EXPLICIT\nEDGE_WEIGHT_FORMAT: {layout}\nEDGE_WEIGHT_SECTION\n"
        )
    };
    let layouts = [
        ("FULL_MATRIX", "0 1 2\n1 0 3\n2 3 0"),
        ("UPPER_ROW", "1 2\n3"),
        ("LOWER_ROW", "1\n2 3"),
        ("UPPER_DIAG_ROW", "0 1 2\n0 3\n0"),
        ("LOWER_DIAG_ROW", "0\n1 0 2 3 0"),
        ("LOWER_COL", "1 2 3"),
        ("UPPER_COL", "1 2 3"),
        ("LOWER_DIAG_COL", "0 1 2 0 3 0"),
        ("UPPER_DIAG_COL", "0 1 0 2 3 0"),
    ];
    for (layout, numbers) in layouts {
        let problem = read("file", &format!("{}{numbers}\nEOF\n", head(layout))).unwrap().problem;
        let travel = problem.travel.unwrap();
        assert_eq!((travel.from_start_s, travel.between_s[0][1]), (vec![1.0, 2.0], 3.0), "{layout}");
    }
    let one_way =
        read("file", &format!("{}0 1 2\n7 0 3\n8 9 0\n", head("FULL_MATRIX").replace("TSP", "ATSP"))).unwrap();
    let travel = one_way.problem.travel.unwrap();
    assert_eq!((travel.from_start_s, travel.to_base_s, travel.between_s[1][0]), (vec![1.0, 2.0], vec![7.0, 8.0], 9.0));
}

#[test]
fn mistakes_are_reported_with_their_place_and_what_to_do() {
    let cases = [
        (SMALL.replace("20 1 2", "x 1 2"), "5:11: x is not a number (expected S, the profit): write a number"),
        (SMALL.replace("30 40", "40 30"), "5:25: the window of 1 closes at 30 before it opens at 40"),
        (SMALL.replace("2 10 11", "3 10 11"), "6:1: vertex 3 is out of order"),
        (SMALL.replace("1 4 2 1", "1 4 3 1"), "there are 3 vertices, and 4 are announced"),
        (SMALL.replace("1 4 2 1", "1 4 1 1"), "6:1: there are more vertices than announced"),
        (SMALL.replace("1 4 2 1", "1 4 99999999 1"), "2:5: 99999999 targets cannot be planned for"),
        (SMALL.replace("5 7 1 1 1 0 90", "5 7 1"), "6:13: the line has 6 numbers"),
        (SMALL.replace("5 20", "-5 20"), "-5 is negative (d, the service time is 0 or more)"),
        (String::new(), "the file is empty"),
        (
            "TYPE: CVRP\n".into(),
            "1:7: problems of type CVRP are not planned for (supported types are TSP, ATSP and OP)",
        ),
        ("NAME: a\nFIXED_EDGES_SECTION\n1 2\n-1".into(), "FIXED_EDGES_SECTION comes before DIMENSION"),
        ("TYPE: TSP\nDIMENSION: 3\nEDGE_WEIGHT_TYPE: XRAY1\n".into(), "3:19: unknown edge weight type XRAY1"),
        ("TYPE: TSP\nDIMENSION: 3\nEDGE_WEIGHT_TYPE: EUC_2D\n".into(), "NODE_COORD_SECTION is missing"),
        ("TYPE: TSP\nDIMENSION: 3\nNODE_COORD_SECTION\n1 0 0\n1 2 2\n".into(), "5:1: node 1 comes twice"),
    ];
    for (text, expected) in cases {
        assert!(trouble(&text).contains(expected), "{} <- {text}", trouble(&text));
    }
}

#[test]
fn our_own_instances_do_not_drift() {
    let hash = |text: &str| Sha256::digest(text.as_bytes()).iter().take(6).map(|byte| format!("{byte:02x}")).collect();
    let suite = generate::windows_suite();
    assert_eq!(suite.len(), 76);
    let all: String = suite.iter().map(|(name, text)| format!("{name}{text}")).collect();
    let hashes: Vec<String> = vec![hash(&all), hash(&generate::oplib(1000, 0.5, 1)), hash(&generate::atsp(20, 1))];
    assert_eq!(hashes, ["cdaa1a50981d", "e8393a6a09a3", "82afaa25c8be"]);
    for (name, text) in &suite {
        let instance = read(name, text).unwrap();
        assert!(is_one(text) && apex_planning::validate::single_visit(&instance.problem).is_ok(), "{name}");
        assert!(instance.problem.targets.len() >= 48);
    }
}

fn samples() -> Vec<String> {
    vec![
        SMALL.to_string(),
        generate::windows(Family::Solomon(Places::Mixed, Day::Short), 2),
        generate::windows(Family::Cordeau { targets: 48, wide: true }, 1),
        generate::oplib(12, 0.5, 1),
        generate::atsp(6, 1),
        "R1\n\nVEHICLE\nNUMBER CAPACITY\n25 200\n\nCUSTOMER\nCUST NO.\n0 35 35 0 0 230 0\n1 41 49 10 161 171 10\n"
            .to_string(),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]
    #[test]
    fn no_text_whatever_stops_the_reader(which in 0..6usize, at in 0.0..1.0f64, cut in any::<bool>(), put in "[-+0-9eE.: \n\t\u{fc}A-Z_*]{0,6}") {
        let text: Vec<char> = samples()[which].chars().collect();
        let at = (at * text.len() as f64) as usize;
        let tail: String = if cut { String::new() } else { text[(at + 1).min(text.len())..].iter().collect() };
        let changed = text[..at].iter().collect::<String>() + &put + &tail;
        let _ = is_one(&changed);
        if let Ok(instance) = read("file", &changed) {
            // Planners accept the problem, or return the reason for which they reject it.
            let _ = apex_planning::validate::single_visit(&instance.problem);
        }
    }
}
