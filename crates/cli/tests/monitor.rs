//! `apex monitor` and `apex export`: conditions over inputs, records and logs, real ones where they are available.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a file that cannot be read is a failed test")]

mod common;

use common::{Desk, Said};
use std::path::Path;

/// Real logs for tests; they are not a part of the project.
const LOGS: &str = "/work/shared/data/flight-logs";

/// Returns the path of a real log; without real logs prints a note and returns `None`.
fn log(name: &str) -> Option<String> {
    let path = Path::new(LOGS).join(name);
    if path.is_file() {
        return Some(path.display().to_string());
    }
    eprintln!("skipped: {} is not here", path.display());
    None
}

const GAPPED: &str = r#"{"t": 0, "measurement": "(roll-angle uav)", "value": 20}
{"t": 1, "measurement": "(roll-angle uav)", "value": 20}
{"t": 3.4, "measurement": "(roll-angle uav)", "value": 21}
{"t": 4, "event": "(go 1)"}
"#;

const STEEP: &str = "(:episode (roll-angle uav) :quality (:max-gap 1s) :value (> 15) :timing (:duration (>= 5s)))";

fn desk() -> Desk {
    let desk = Desk::new();
    desk.write("i.jsonl", GAPPED);
    desk
}

/// Results that were printed, by the condition's number.
fn results(said: &Said, condition: u64) -> usize {
    let of = |line: &&str| {
        line.contains(&format!("\"condition\":{condition},")) && line.contains("\"telling\":\"recognised\"") // english: allow
    };
    said.out.lines().filter(of).count()
}

#[test]
fn results_and_verdicts_are_reported_with_their_reasons() {
    let said =
        desk().apex(&["monitor", STEEP, "(:in-order (roll-angle ?who > 20) (go ?n))", "--inputs", "i.jsonl"]).well();
    assert!(said.out.contains("2: 3.4s to 4s (0.600 s), recognised at 4s, ?who = uav, ?n = 1\n"), "{}", said.out);
    assert!(said.out.contains("  because (roll-angle uav) = 21 at 3.4s, (go 1) at 4s\n"), "{}", said.out);
    assert!(said.out.contains("1: unknown up to 4s, 0 results\n"), "{}", said.out);
    assert!(said.out.contains("a gap of P2.4S > P1S cut it before"), "{}", said.out);
}

#[test]
fn the_largest_sampling_gap_of_a_result_is_reported() {
    let desk = Desk::new();
    let sample = |t: u32| format!("{{\"t\": {t}, \"measurement\": \"(roll-angle uav)\", \"value\": 20}}\n");
    desk.write("i.jsonl", &[1, 2, 3, 4, 5, 6, 20, 21].map(sample).concat());
    let condition = "(:episode (roll-angle uav) :quality :no-constraints :value (> 15))";
    let said = desk.apex(&["monitor", condition, "--inputs", "i.jsonl"]).well();
    assert!(said.out.contains("\n  no sample of (roll-angle uav) for 14.000 s, from 6s to 20s\n"), "{}", said.out);
    let lines = desk.apex(&["monitor", condition, "--inputs", "i.jsonl", "--json"]).well().json_lines();
    assert_eq!(lines[0]["gaps"], serde_json::json!([]), "one sample");
    let gap = serde_json::json!({
        "variable": "(roll-angle uav)", "start_s": 6.0, "end_s": 20.0, "length_s": 14.0,
        "start_ns": 6_000_000_000_i64, "end_ns": 20_000_000_000_i64, "length_ns": 14_000_000_000_i64,
    });
    assert_eq!(lines[1]["gaps"], serde_json::json!([gap]));
}

#[test]
fn standard_input_is_reported_as_it_comes_and_json_reports_the_same() {
    let said = desk().apex_hearing(&["monitor", "(go ?n)"], GAPPED);
    assert_eq!(said.out, "at 4s, ?n = 1\n  because (go 1) at 4s\nsatisfied up to 4s, 1 result\n");
    let said = desk().apex(&["monitor", "(go ?n)", "--json", "--inputs", "i.jsonl"]).well();
    let lines: Vec<serde_json::Value> = said.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines[0]["bindings"]["n"], "1");
    assert_eq!(lines[0]["recognised_at_s"], 4.0);
    assert_eq!(lines[1]["verdict"], "satisfied");
}

#[test]
fn a_library_declares_units_and_functions_and_conditions_come_from_files() {
    let desk = desk();
    desk.write("d.pdl", "(state-variable (roll-angle ?a) :unit deg) (defconstant steep 20deg)");
    desk.write("c.pdl", "; two of them\n(roll-angle uav > steep)\n(:delay 2s)\n");
    let arguments =
        ["monitor", "--condition-file", "c.pdl", "--library", "d.pdl", "--inputs", "i.jsonl", "--created", "1"];
    let said = desk.apex(&arguments).well();
    assert!(said.out.contains("1: at 3.4s\n  because (roll-angle uav) = 21deg at 3.4s"), "{}", said.out);
    assert!(said.out.contains("2: at 3s\n"), "{}", said.out);
}

#[test]
fn mistakes_say_what_to_do() {
    let desk = desk();
    desk.apex(&["monitor", "--inputs", "i.jsonl"]).complained(2, &["there is no condition to watch", "--fields"]);
    desk.apex(&["monitor", "(roll-angle uav > ", "--inputs", "i.jsonl"])
        .complained(2, &["<condition 1>:1:", "never closed"]);
    desk.apex(&["monitor", "(a b)", "--inputs", "nothing.ulg"]).complained(2, &["cannot read nothing.ulg"]);
    desk.apex(&["monitor", "(a b)", "--mapping", "i.jsonl", "--inputs", "i.jsonl"]).complained(2, &["i.jsonl"]);
    desk.apex(&["monitor", "--fields", "--inputs", "i.jsonl"]).complained(2, &["`--fields` is for logs"]);
    desk.write("x.dat", "something");
    desk.apex(&["monitor", "(a b)", "--inputs", "x.dat"]).complained(2, &["the format of x.dat is not known"]);
    desk.write("x.mcap", "\u{89}");
    desk.apex(&["monitor", "(a b)", "--inputs", "x.mcap"]).complained(2, &["x.mcap needs a mapping"]);
    let said = desk.apex(&["monitor", "(rol uav > 3)", "--expect", "satisfied", "--inputs", "i.jsonl"]);
    said.complained(
        1,
        &["there is no sample of (rol uav)", "it has (roll-angle uav)", "not every verdict is `satisfied`"],
    );
    // A variable without samples is not reported as absent.
    desk.write("f.csv", "time,roll\n0,1\n1,2\n");
    let of_log = ["monitor", "(rol aircraft-1 > 3)", "--expect", "not-satisfied", "--inputs", "f.csv"];
    desk.apex(&of_log).complained(1, &["not every verdict is `not-satisfied`", "without a sample of (rol aircraft-1)"]);
    desk.apex(&["monitor", "f.csv", "(roll aircraft-1 > 3)"])
        .complained(2, &["`f.csv` is a file, not a condition", "--inputs f.csv"]);
}

#[test]
fn tables_need_no_mapping_and_take_one() {
    let desk = Desk::new();
    desk.write("f.csv", "time_ms,Roll Deg,rssi\n0,1,-50\n500,0.3,-61\n1000,0.4,\n");
    let said =
        desk.apex(&["monitor", "(roll-deg aircraft-1 < 0.5)", "(rssi aircraft-1 < -60)", "--inputs", "f.csv"]).well();
    assert!(said.out.contains("1: satisfied up to 1s, 2 results"), "{}", said.out);
    assert!(said.out.contains("2: satisfied up to 1s, 1 result\n"), "{}", said.out);
    desk.write("m.pdl", "(state-variable (roll-angle ?a) :unit deg)\n(map \"Roll Deg\" (roll-angle uav) :unit rad)\n");
    let said = desk.apex(&["monitor", "(roll-angle uav > 20deg)", "--inputs", "f.csv", "--mapping", "m.pdl"]).well();
    assert!(said.out.contains("= 57.2957795131deg at 0s"), "{}", said.out);
    assert!(said.out.contains("2 results"), "{}", said.out);
    let said = desk.apex(&["monitor", "--fields", "--inputs", "f.csv", "--mapping", "m.pdl"]).well();
    assert!(said.out.contains("-> (roll-angle uav)"), "{}", said.out);
}

#[test]
fn a_flight_record_is_watched_in_terms_of_its_own_program() {
    let desk = Desk::with_flight();
    let said = desk.apex(&["monitor", "(calibration-due ?camera)", "(altitude ?who > 30m)", "--inputs", "flight.apex"]);
    assert!(
        said.out.contains("1: at 40s, ?camera = camera-1\n  because (calibration-due camera-1) at 40s"),
        "{}",
        said.out
    );
    assert!(said.out.contains("2: satisfied"), "{} {}", said.out, said.err);
}

#[test]
fn messages_and_samples_of_the_program_are_events_of_its_record() {
    let desk = Desk::new();
    let program = "(state-variable (heat ?part) :type real)
(procedure (index (do-domain)) (step a (tell)) (step done (terminate) (waitfor (end ?a))))
(primitive (index (tell)) (duration 2s) (on-end (inform (said 5)) (publish (heat engine) 7)))\n";
    desk.write("p.pdl", program);
    desk.apex(&["run", "p.pdl", "--record", "r.apex"]);
    let said = desk.apex(&["monitor", "(said ?n)", "(heat engine > 5)", "--inputs", "r.apex"]);
    assert!(said.out.contains("1: at 2s, ?n = 5\n  because (said 5) at 2s"), "{} {}", said.out, said.err);
    assert!(said.out.contains("2: satisfied"), "{} {}", said.out, said.err);
}

#[test]
fn what_became_of_each_sample_is_in_the_table() {
    let desk = Desk::new();
    desk.write("d.pdl", "(state-variable (x ?a) :unit m :lateness 2s)");
    let lines = [(1, "5"), (2, "6"), (2, "7"), (2, "7"), (9, "8"), (8, "1"), (3, "2"), (10, "\"far\"")];
    let line =
        |(at, value): &(i32, &str)| format!("{{\"t\": {at}, \"measurement\": \"(x uav)\", \"value\": {value}}}\n");
    // Standard input keeps the order of arrival.
    let input: String = lines.iter().map(line).collect();
    let said = desk.apex_hearing(&["export", "-", "--library", "d.pdl"], &input);
    let statuses: Vec<&str> = said.out.lines().skip(1).filter_map(|line| line.rsplit(',').next()).collect();
    let expected = ["kept", "kept", "replaced", "repeated", "kept", "inserted", "late", "refused"];
    assert_eq!(statuses, expected, "{}", said.out);
    assert!(said.out.contains("\n6,8000000000,9000000000,sample,(x uav),1,m,,inserted\n"), "{}", said.out);
    desk.write("i.jsonl", GAPPED);
    desk.apex(&["export", "i.jsonl", "--out", "t.parquet"]).complained(0, &["4 rows in t.parquet"]);
    let bytes = std::fs::read(desk.path("t.parquet")).unwrap();
    assert!(bytes.starts_with(b"PAR1") && bytes.ends_with(b"PAR1"));
    desk.apex(&["export", "i.jsonl", "--format", "parquet"]).complained(2, &["needs a file"]);
    desk.apex(&["export", "i.jsonl", "--out", "i.jsonl"]).complained(2, &["overwrite its source"]);
}

/// The expected counts come from a plain scan of the files' bytes, independent of these readers.
#[test]
fn rolls_above_fifteen_degrees_are_found_in_real_logs() {
    let right = "(:episode (roll-angle aircraft-1) :quality (:max-gap 1s) :value (> 15deg))";
    let left = "(:episode (roll-angle aircraft-1) :quality (:max-gap 1s) :value (< -15deg))";
    for (name, to_the_right, to_the_left) in [
        ("frr_ekf_failure.ulg", 3, 5),
        ("frr_gps_interference.ulg", 0, 0),
        ("mcap_test_ulog.ulg", 1, 0),
        ("pyulog_sample_log_small.ulg", 0, 0),
        ("vtol.tlog", 60, 5),
        ("ap_tradheli_brownout.log", 2, 0),
    ] {
        let Some(path) = log(name) else { continue };
        let said = Desk::new().apex(&["monitor", right, left, "--json", "--inputs", &path]);
        assert_eq!((results(&said, 1), results(&said, 2)), (to_the_right, to_the_left), "{name}: {}", said.err);
    }
    let Some(path) = log("frr_ekf_failure.ulg") else { return };
    let said = Desk::new().apex(&["monitor", right, "--inputs", &path]).well();
    assert!(said.out.contains("19.147946s to 24.597885s (5.450 s)"), "{}", said.out);
    assert!(said.out.contains("from 19.147946s to 24.597885s, 110 samples"), "{}", said.out);
}

#[test]
fn dips_of_the_signal_are_found_in_a_real_log() {
    let Some(path) = log("frr_gps_interference.ulg") else { return };
    let dips = "(:episode (rssi aircraft-1) :quality :no-constraints :value (< -60))";
    let said = Desk::new().apex(&["monitor", "(rssi aircraft-1 < -60)", dips, "--json", "--inputs", &path]);
    assert_eq!((results(&said, 1), results(&said, 2)), (20, 12), "{}", said.err);
}

#[test]
fn a_real_log_that_is_cut_gives_what_is_left_and_says_where() {
    let Some(path) = log("frr_ekf_failure.ulg") else { return };
    let desk = Desk::new();
    let bytes = std::fs::read(path).unwrap();
    std::fs::write(desk.path("cut.ulg"), &bytes[..1_000_000]).unwrap();
    let right = "(:episode (roll-angle aircraft-1) :quality (:max-gap 1s) :value (> 15deg))";
    let said = desk.apex(&["monitor", right, "--inputs", "cut.ulg"]);
    let said = said.complained(0, &["cut.ulg: byte 999981: the log ends within a message"]);
    assert!(said.out.contains("2 results"), "{}", said.out);
}

#[test]
fn a_file_that_is_not_a_log_ends_with_two() {
    let desk = Desk::new();
    let noise: Vec<u8> = (0..4_000_u32).map(|number| (number.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    std::fs::write(desk.path("noise.ulg"), &noise).unwrap();
    std::fs::write(desk.path("noise.bin"), &noise).unwrap();
    desk.write("README.tlog", "# A project\n\nThis is text, and no telemetry.\n");
    desk.write("notes.log", "What we did today, in short.\nNothing of note, really.\n");
    desk.write("speeds.csv", "speed,roll\n1,2\n");
    for name in ["noise.ulg", "noise.bin", "README.tlog", "notes.log", "speeds.csv"] {
        for options in [["--expect", "not-satisfied"].as_slice(), &[]] {
            let said = desk.apex(&[["monitor", "(v uav > 15)", "--inputs", name].as_slice(), options].concat());
            assert_eq!(said.code, Some(2), "{name}: {}{}", said.out, said.err);
            assert!(said.err.contains(&format!("{name} holds no readable message of format ")), "{name}: {}", said.err);
        }
        assert_eq!(desk.apex(&["monitor", "--fields", "--inputs", name]).code, Some(2), "{name}");
    }
}

/// Returns a roll at 10 Hz: above 15 from 1 s to 2 s, and again from 4 s to 5 s.
fn two_banks() -> String {
    let roll = |tenth: u32| if (10..=20).contains(&tenth) || (40..=50).contains(&tenth) { 20 } else { 0 };
    let rows = (0..80).map(|tenth| format!("{}.{},{}\n", tenth / 10, tenth % 10, roll(tenth)));
    format!("t,roll\n{}", rows.collect::<String>())
}

const BANKED: &str = "(:episode (roll aircraft-1) :quality (:max-gap 1s) :value (> 15))";

#[test]
fn a_span_of_a_log_is_watched() {
    let desk = Desk::new();
    desk.write("a.csv", &two_banks());
    let spans: [(&[&str], &str); 4] = [
        (&[], "1s to 2s (1.000 s)|4s to 5s (1.000 s)|satisfied up to 7.9s, 2 results"),
        (&["--from", "1500ms"], "1.5s to 2s (0.500 s)|4s to 5s (1.000 s)|satisfied up to 7.9s, 2 results"),
        (&["--until", "4.3"], "1s to 2s (1.000 s)|4s to 4.3s (0.300 s)|satisfied up to 4.3s, 2 results"),
        (&["--from", "2.5", "--until", "3.5"], "not-satisfied up to 3.5s, 0 results"),
    ];
    for (options, expected) in spans {
        let said = desk.apex(&[["monitor", BANKED, "--inputs", "a.csv"].as_slice(), options].concat()).well();
        for line in expected.split('|') {
            assert!(said.out.contains(line), "{options:?}: {}", said.out);
        }
    }
    let beyond = desk.apex(&["monitor", BANKED, "--inputs", "a.csv", "--from", "1h"]);
    beyond.complained(2, &["the input ends at 7.9s, before `--from", "give an earlier `--from`"]);
    let said = desk.apex(&["monitor", BANKED, "--inputs", "a.csv", "--from", "3", "--until", "2"]);
    said.complained(2, &["`--until", "is before `--from"]);
}

#[test]
fn several_logs_are_watched_into_one_table() {
    let desk = Desk::new();
    desk.write("a.csv", &two_banks());
    desk.write("b,c.csv", "time (ms);roll\n0;0\n100,25;20\n200;20\n300;0\n");
    let inputs = ["--inputs", "a.csv", "--inputs", "b,c.csv", "--results", "r.csv"];
    let said = desk.apex(&[["monitor", BANKED].as_slice(), inputs.as_slice()].concat()).well();
    assert!(said.out.contains("b,c.csv: 0.10025s to 0.2s"), "{}", said.out);
    let table = desk.read("r.csv");
    let rows: Vec<&str> = table.lines().collect();
    assert_eq!(rows[0], "input,condition,start_ns,end_ns,duration_ns,recognised_at_ns,bindings,evidence");
    assert!(rows[1].starts_with("a.csv,1,1000000000,2000000000,1000000000,1000000000,,"), "{table}");
    assert!(rows[3].starts_with("\"b,c.csv\",1,100250000,200000000,99750000,100250000,,"), "{table}");
    assert_eq!(rows.len(), 4);
    let said = desk.apex(&[["monitor", BANKED, "--json"].as_slice(), inputs.as_slice()].concat()).well();
    let lines = said.json_lines();
    let last = lines.iter().rfind(|line| line["telling"] == "closed").unwrap(); // english: allow
    assert_eq!((&last["input"], &last["start_ns"]), (&"b,c.csv".into(), &100_250_000.into()));
    assert_eq!((&last["duration_ns"], &lines.last().unwrap()["until_ns"]), (&99_750_000.into(), &300_000_000.into()));
    // The command fails if one of several inputs does not meet `--expect`.
    desk.write("calm.csv", "t,roll\n0,0\n1,0\n");
    let said = desk.apex(&["monitor", BANKED, "--inputs", "a.csv", "--inputs", "calm.csv", "--expect", "satisfied"]);
    assert_eq!(said.code, Some(1), "{}", said.err);
    let said = desk.apex(&["monitor", BANKED, "--inputs", "a.csv", "--results", "a.csv"]);
    said.complained(2, &["would overwrite its source"]);
}

#[test]
fn derived_variables_are_declared_on_the_command_line_and_drawn() {
    let desk = Desk::new();
    desk.write("a.csv", "t,want,roll,mode\n0,0,0,1\n1,20,3,1\n2,20,8,1\n3,20,19,2\n4,0,18,2\n5,0,2,2\n");
    let error = "(state-variable (roll-error ?a) :derived (abs (- (want ?a) (roll ?a))) :join (:hold 1s))";
    let off = "(:episode (roll-error aircraft-1) :quality (:max-gap 1s) :value (> 10) :timing (:duration (>= 1s)))";
    let changed = "(state-variable (new-mode ?a) :derived (changed (mode ?a)))";
    let options = ["--declare", error, "--declare", changed, "--inputs", "a.csv"];
    let watch = ["monitor", off, "(new-mode aircraft-1 = t)"];
    let said = desk.apex(&[watch.as_slice(), &options, &["--plot", "a.svg", "--results", "r.parquet"]].concat()).well();
    assert!(said.out.contains("1: 1s to 2s (1.000 s)"), "{}", said.out);
    assert!(said.out.contains("2: at 3s"), "{}", said.out);
    let picture = desk.read("a.svg");
    assert!(picture.starts_with("<svg") && picture.contains("(roll-error aircraft-1)"), "{picture}");
    assert!(std::fs::read(desk.path("r.parquet")).unwrap().starts_with(b"PAR1"));
    let said = desk.apex(&[
        "monitor",
        "(:episode (:and (want a > 1) (roll a > 1)) :quality :no-constraints)",
        "--inputs",
        "a.csv",
    ]);
    said.complained(2, &["`(:and ..)` is not a state variable", ":derived (and"]);
    let said = desk.apex(&["monitor", off, "--inputs", "a.csv", "--plot", "a.png"]);
    said.complained(2, &["is not a name of an SVG file", "end the name in .svg"]);
    let said = desk.apex(&["monitor", off, "--inputs", "a.csv", "--results", "r.xlsx"]);
    said.complained(2, &["`--results r.xlsx` is not a name of a table", "end the name in .csv or .parquet"]);
    assert!(!desk.path("r.xlsx").exists());
}

#[test]
fn a_field_of_the_mapping_that_the_log_lacks_is_named() {
    let desk = Desk::new();
    desk.write("a.csv", "t,roll\n0,0\n1,20\n2,0\n");
    let watch = ["monitor", "(bank uav > 15)", "--inputs", "a.csv", "--mapping", "m.pdl"];
    desk.write("m.pdl", "(map \"Roll\" (bank uav))\n(map \"roll_deg\" (bank uav))\n(map \"other\" (pitch uav))");
    let said = desk.apex(&watch);
    assert!(
        said.err.contains("takes (bank uav) from `Roll` or `roll_deg`, which this log does not have"),
        "{}",
        said.err
    );
    assert!(!said.err.contains("pitch"), "{}", said.err);
    desk.write("m.pdl", "(map \"roll\" (bank uav))");
    let said = desk.apex(&watch).well();
    assert!(said.out.contains("satisfied up to 2s, 1 result"), "{} {}", said.out, said.err);
    desk.write("m.pdl", "(map \"roll\" (bank uav) :scale 0)");
    desk.apex(&watch).complained(2, &["a scale of 0 makes every value 0"]);
}

#[test]
fn fields_of_a_mapping_that_are_not_read_and_units_that_differ_are_named() {
    let desk = Desk::new();
    desk.write("a.csv", "t,roll,bank\n0,0,3\n1,20,3\n");
    desk.write(
        "m.pdl",
        "(map \"roll\" (roll uav)) ; the first\n  (map \"bank\" (roll uav))\n(map \"bank\" (other uav))",
    );
    let said = desk.apex(&["monitor", "(roll uav > 15)", "--inputs", "a.csv", "--mapping", "m.pdl"]);
    let expected =
        "note: m.pdl:2:3: the log has `bank`, which is not read: an earlier entry takes (roll uav) from `roll`";
    assert!(said.err.contains(expected), "{}", said.err);
    assert!(said.out.contains("1 result"), "{}", said.out);
    let rows = "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\nFMT, 130, 45, ATT, Qf, TimeUS,Roll\n\
                FMT, 131, 45, UNIT, QbZ, TimeUS,Id,Label\nFMT, 132, 45, MULT, Qbd, TimeUS,Id,Mult\n\
                FMT, 133, 45, FMTU, QBNN, TimeUS,FmtType,UnitIds,MultIds\nUNIT, 1, 115, s\nUNIT, 1, 100, deg\n\
                MULT, 1, 70, 1e-6\nMULT, 1, 48, 1\nFMTU, 1, 130, sd, F0\nATT, 1000000, 20\nATT, 2000000, 20\n";
    desk.write("a.log", rows);
    desk.write("m.pdl", "(state-variable (roll-angle ?a) :unit deg)\n(map \"ATT.Roll\" (roll-angle uav) :unit rad)");
    let watch = ["monitor", "(roll-angle uav > 15deg)", "--inputs", "a.log", "--mapping", "m.pdl"];
    let said = desk.apex(&watch);
    let expected = "note: m.pdl:2:1: the log states `deg` for `ATT.Roll`, and the mapping rad, which counts";
    assert!(said.err.contains(expected), "{}", said.err);
    desk.write("m.pdl", "(state-variable (height ?a) :unit m)\n(map \"ATT.Roll\" (height uav))");
    let said = desk.apex(&["monitor", "(height uav > 15m)", "--inputs", "a.log", "--mapping", "m.pdl"]);
    assert!(
        said.err.contains("m.pdl:2:1: the log states `deg` for `ATT.Roll`, but (height uav) is declared"),
        "{}",
        said.err
    );
    desk.write("m.pdl", "(state-variable (roll-angle ?a) :unit deg)\n(map \"ATT.Roll\" (roll-angle uav))");
    let said = desk.apex(&watch).well();
    assert!(!said.err.contains("the log states"), "{}", said.err);
}

#[test]
fn civil_time_is_reported_where_the_input_knows_it() {
    let desk = Desk::new();
    desk.write("a.csv", "time_ms,roll\n1700000000000,0\n1700000001500,20\n1700000002000,0\n");
    let said = desk.apex(&["monitor", "(roll aircraft-1 > 15)", "--inputs", "a.csv", "--utc"]).well();
    assert!(said.out.contains("at 1.5s [2023-11-14T22:13:21.5Z]"), "{}", said.out);
    let said =
        desk.apex(&["monitor", "(roll aircraft-1 > 15)", "--inputs", "a.csv", "--utc", "--log-time", "--json"]).well();
    assert_eq!(said.json_lines()[0]["start_utc"], "2023-11-14T22:13:21.5Z");
    desk.write("b.csv", "t,roll\n0,0\n1,20\n");
    let said = desk.apex(&["monitor", "(roll aircraft-1 > 15)", "--inputs", "b.csv", "--utc"]);
    said.complained(2, &["the civil time of this input is not known"]);
    // A flight record knows the start of its mission.
    let mission = common::mission("diagnosis");
    desk.apex(&["fly", &mission, "--until", "20s", "--record", "r.apex", "--no-progress"]).well();
    let said = desk.apex(&["monitor", "(payload-voltage aircraft-1 > 20)", "--inputs", "r.apex", "--utc"]).well();
    assert!(said.out.contains("[2026-05-12T17:00:05Z]"), "{}", said.out);
}

#[test]
fn columns_that_no_condition_reads_change_no_result() {
    let desk = Desk::new();
    desk.write("a.csv", "t,roll,late\n0,,1\n1,20,\n2,20,\n3,0,\n9,,1\n");
    for condition in
        ["(:episode (roll aircraft-1) :quality (:max-gap 1s) :value (> 15))", "(:not (late aircraft-1 > 5))"]
    {
        let own = desk.apex(&["monitor", condition, "--inputs", "a.csv"]).well().out;
        // A condition that is judged at every instant requires all data to be read.
        let with_all = desk.apex(&["monitor", condition, "(:function (> +met+ 90s))", "--inputs", "a.csv"]).well().out;
        let of_first: String =
            with_all.lines().filter_map(|line| line.strip_prefix("1: ")).map(|line| format!("{line}\n")).collect();
        let plain: String =
            own.lines().filter(|line| !line.starts_with("  ")).map(|line| format!("{line}\n")).collect();
        assert_eq!(plain, of_first);
        assert!(plain.contains("up to 9s"), "{plain}");
    }
}

#[test]
fn an_own_mapping_is_added_to_what_ships_and_printed() {
    let desk = Desk::new();
    desk.write(
        "own.pdl",
        "(map \"GPS.Spd\" (ground-speed aircraft-1) :unit m/s :scale 2) (map \"X.y\" (own aircraft-1))",
    );
    desk.write("a.log", "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\nFMT, 130, 45, ATT, Qf, TimeUS,Roll\nATT, 1000000, 20\n");
    let said = desk.apex(&["monitor", "--show-mapping", "--mapping", "own.pdl", "--inputs", "a.log"]).well();
    assert!(said.out.contains("(map \"X.y\" (own aircraft-1))"), "{}", said.out);
    assert!(said.out.contains("(map \"ATT.Roll\" (roll-angle aircraft-1)"), "{}", said.out);
    assert_eq!(said.out.matches("(ground-speed aircraft-1)").count(), 1, "{}", said.out);
    desk.write("printed.pdl", &said.out);
    let again = desk.apex(&["monitor", "--show-mapping", "--mapping", "printed.pdl", "--inputs", "a.log"]).well();
    assert_eq!(again.out, said.out);
}
