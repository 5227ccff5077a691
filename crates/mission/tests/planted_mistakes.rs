//! Mistakes planted in shipped missions, one at a time: the check must report each at the right line. They are slips in names, units,
//! types and arguments; the unchanged mission must give no message.

#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::string_slice,
    clippy::indexing_slicing,
    reason = "a test that cannot continue fails"
)]

use apex_mission::Mission;
use apex_mission::error::MissionResult;
use apex_mission::names::check_names;
use apex_mission::program::check_program_with;
use apex_pdl::{Diagnostic, Severity};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Text before and after the slip.
type Slip = (&'static str, &'static str);

const STRUCTURE_WATCH: &[Slip] = &[
    ("return to home at 110m", "return to hmoe at 110m"),
    ("take off to 110m", "take off to 110"),
    ("take off to 110m", "take off to 110s"),
    ("take off to 110m", "take off too 110m"),
    ("(step clock (wait ?time))", "(step clock (wait 55m))"),
    ("(step clock (wait ?time))", "(step clock (wait \"55min\"))"),
    ("(step clock (wait ?time))", "(step clock (wait ?tiem))"),
    ("+forecast-wind+ 6m/s", "+forecast-wind+ 6m/"),
    ("(> +forecast-wind+)", "(> +forecast-winds+)"),
    (":value (> +forecast-wind+)", ":value (> 6m)"),
    ("(wind-speed rotorcraft-1)", "(wind-sped rotorcraft-1)"),
    ("(wind-speed rotorcraft-1)", "(wind-speed rotorcraft-2)"),
    ("(waitfor (smoke-seen ?site))", "(waitfor (smoke-sen ?site))"),
    ("(waitfor (fire-sighted ?site))", "(waitfor (fire-sighted ?site ?when))"),
    ("(waitfor (fire-sighted ?site))", "(waitfor (fire-sited ?site))"),
    ("(waitfor (end ?up))", "(waitfor (end ?upp))"),
    ("(waitfor (end ?clock))", "(waitfor (ended ?clock))"),
    ("(guard the flight)", "(guard the fligt)"),
    ("(keep in touch over 900MHzModem)", "(keep in touch with 900MHzModem)"),
    ("(keep in touch over 900MHzModem)", "(keep in touch over 90MHzModem)"),
    (":station home", ":station hom"),
    (":model rmax", ":model rmacks"),
    (":at home", ":at house"),
    ("\"sites.geojson\"", "\"site.geojson\""),
    ("\"obstacles.geojson\"", "\"obstacle.geojson\""),
    (":weather \"winds-actual.csv\"", ":weather \"winds-real.csv\""),
    ("\"world.json\"", "\"wrld.json\""),
    ("\"scenario.jsonl\"", "\"scenarios.jsonl\""),
    (":end-margin", ":end-margins"),
    (":duration 65min", ":duration 65"),
    (":duration 65min", ":duration -65min"),
    ("2026-08-18T21:00:00Z", "2026-08-38T21:00:00Z"),
    (":type native-sim", ":type nativ-sim"),
    (":full-level 1500m", ":full-level 1500s"),
    ("solver auto", "solver atuo"),
    (":budget 500ms", ":budget 500m"),
    ("(solver auto (index (patrol the structures))", "(solver auto (index (patrol the structure))"),
    (":initial-task (watch the structures for 55min)", ":initial-task (watch the structure for 55min)"),
    ("for 55min)))", "for 55m)))"),
    ("\"replanning\"", "\"replaning\""),
    ("(new-likelihood ?site 0.8))))\n\n;; Reported smoke", "(new-likelihood ?sit 0.8))))\n\n;; Reported smoke"),
    ("(new-likelihood ?site 0.8))))\n\n;; Reported smoke", "(new-likelihood 0.8))))\n\n;; Reported smoke"),
    ("(new-likelihood ?site 0.8))))\n\n;; Reported smoke", "(new-likelihood ?site high))))\n\n;; Reported smoke"),
    (":default fire)", ":default fires)"),
    (":by 90s", ":by 90m"),
    (":duration (> 1min)", ":duration (> 1m)"),
    (":quality (:no-constraints)", ":qualty (:no-constraints)"),
    (":options (fire barbecue)", ":options (fire barbeque)"),
    ("(index (believe barbecue at ?site))", "(index (believe barbecu at ?site))"), // english: allow
    ("(restart-when (new plan))", "(restart-when (new plans))"),
    ("(priority 10)", "(priority high)"),
    ("(priority 10)", "(priorty 10)"),
    ("(agent rotorcraft-1 ", "(agent rotorcraft-2 "),
    ("(step take (believe ?answer at ?site))", "(step take (believe ?anser at ?site))"), // english: allow
    ("within 2min", "within 2m"),
];

const WESTERN_STATES: &[Slip] = &[
    ("return to edwards at 7000m", "return to edward at 7000m"),
    ("return to edwards at 7000m", "return to edwards at 7000kg"),
    (":at edwards", ":at edwads"),
    (":landing-distance 220nm", ":landing-distance 220kt"),
    ("(keep in touch over satellite-link)", "(keep in touch over satelite-link)"),
    ("(off-schedule ?what)", "(of-schedule ?what)"),
    ("(observed ?)", "(observed)"),
    ("(new-target ?what)", "(new-targets ?what)"),
];

/// A mission of the tests that uses what the shipped ones do not: derived variables, resources with units, own commands and events,
/// functions, urgency, questions, commands with time limits.
const DIKE_SURVEY: &[Slip] = &[
    (":end-margin 5min", ":end-margin 5m"),
    (":zone-margin 25m", ":zone-margin -25m"),
    (":horizontal 15m", ":horizontal 15s"),
    (":clearance 32m", ":clearence 32m"),
    (":full-level 30km", ":full-level 30"),
    (":weak-for 15s", ":weak-for 15m"),
    (":default resume", ":default resum"),
    (":workload 5", ":workload 50"),
    (":budget 2s", ":budget 0s"),
    (":capacity 3", ":capacity 0"),
    (":renewable 100", ":renewabel 100"),
    (":unit m/s", ":unit m\\s"),
    (":unit m)", ":unit mm/kg)"),
    ("(rate-of (water-level ?gauge))", "(rate-of (water-lvl ?gauge))"),
    (":from operator", ":from operater"),
    ("(?level length)", "(?level lenght)"),
    ("&key (:for duration)", "&key (:for druation)"),
    ("alarm-level 4.5m", "alarm-level \"4.5m\""),
    ("alarm-level 4.5m", "alarm-level 4.5s"),
    ("patience 90s", "patience 90m"),
    ("(/ x 2)", "(/ x 0)"),
    ("(- alarm-level level)", "(- alarm-level levl)"),
    ("(> +met+ 30min)", "(> +now+ 30min)"),
    ("(> +met+ 30min)", "(> +met+ 30)"),
    ("(profile storage)", "(profile (storage 4))"),
    ("(profile storage)", "(profile storag)"),
    ("(on-failure (inform (tour-impossible)))", "(on-failure (infrom (tour-impossible)))"),
    ("(read the gauges every 2min)", "(read the gauges every 2m)"),
    ("(read the gauges every 2min) (waitfor ?up)", "(read the gauges every 2min) (waitfor ?upp)"),
    ("(waitfor (seepage ?where))", "(waitfor (sepage ?where))"),
    ("(water-level gauge-1 > alarm-level)", "(water-level gauge-1 > alarm-levle)"),
    ("(water-level gauge-1 > alarm-level)", "(water-level gauge-1 >alarm-level)"),
    ("(water-level gauge-1 > alarm-level)", "(flow gauge-1 > alarm-level)"),
    (":urgency 7 :importance 9", ":urgency 70 :importance 9"),
    (":urgency 7 :importance 9", ":urgncy 7 :importance 9"),
    ("(:max-gap 5s)", "(:max-gap 5m)"),
    (":quality (:max-gap 5s)", ":quality (:max-gaps 5s)"),
    (":timing (:duration (> 30s))", ":timing (:duration > 30s)"),
    ("(keep in touch over control-link)", "(keep in touch over controllink)"),
    ("(end ?clock) (end ?tour)", "(end ?clock) (end tour)"),
    ("(priority 10)", "(priority 10s)"),
    ("(step finish (terminate) (waitfor (end ?home)))", "(step finish (terminat) (waitfor (end ?home)))"),
    ("(step finish (terminate) (waitfor (end ?home)))", "(step finish (terminate) (waitfor (end ?finish)))"),
    ("(probe gauge-1 to 2m)", "(probe gauge-1 to 2s)"),
    ("(probe gauge-1 to 2m)", "(probe gauge-1 too 2m)"),
    ("(probe gauge-2 to 3m)", "(probe gauge-2)"),
    (":with-min-interval ?interval)", ":with-min-intervall ?interval)"),
    ("(waitfor (:and (end ?one) (end ?two)))", "(waitfor (and (end ?one) (end ?two)))"),
    ("(waitfor (:delay 35min))", "(waitfor (:delay 35m))"),
    ("(waitfor (:delay 35min))", "(waitfor (delay 35min))"),
    ("(profile winch (storage 1))", "(profile winch (storage one))"),
    ("(lower the probe to ?depth) => ?reading", "(lower the probe to ?depth) -> ?reading"),
    ("(gauge-done ?gauge ?reading)", "(gauge-done ?gauge ?readng)"),
    ("(half ?depth) 1m", "(half ?depth) 1s"),
    ("(half ?depth) 1m", "(half ?depth ?gauge) 1m"),
    ("(skip-when (:function", "(skip-if (:function"),
    ("(precondition (water-level gauge-1 < 6m))", "(precondition (water-level gauge-1 < 6kg))"),
    ("(precondition (water-level gauge-1 < 6m))", "(precondition (:delay 6s))"),
    (":options (yes no)", ":options (yes noo)"),
    (":by patience", ":by 5"),
    (":default no) => ?answer", ":default maybe) => ?answer"),
    ("(answer leak ?answer at ?where)", "(answer leak ?answer to ?where)"),
    ("(waitfor (succeeded ?record))", "(waitfor (succeded ?record))"),
    ("(waitfor (succeeded ?record))", "(waitfor (succeeded record))"),
    ("(:in-order (end ?fly) (:delay 20s))", "(:in-order (end ?fly) (delay 20s))"),
    ("(current-value water-level ?gauge)", "(current-value water-levl ?gauge)"),
    ("(current-value water-level ?gauge) 0m", "(current-value water-level ?gauge) 0s"),
    ("(margin-of (or", "(margin-off (or"),
    ("(release-resource winch)", "(release-resource wench)"),
    ("(hold-resource winch)", "(hold-resource storage 5)"),
    ("(lower-probe ?depth :for 20s)", "(lower-probe ?depth :for 20m)"),
    ("(lower-probe ?depth :for 20s)", "(lower-prob ?depth :for 20s)"),
    (":timeout 1min", ":timeout 1m"),
    ("(return +now+)", "(return +noww+)"),
    ("(raise-probe) :timeout patience", "(raise-probe 5) :timeout patience"),
    ("(index (raise the probe))", "(index (rise the probe))"),
    ("(command (fly-to ?where))", "(command (fly-to 5m))"),
    ("(profile flight-path)", "(profile flight-pth)"),
    ("(primitive (index (dash to ?where))", "(primitve (index (dash to ?where))"),
    ("(survey the dike in 40min)", "(survey the dike in 40)"),
];

/// A mission of the tests with two agents, cycles, absences, relations in time, an invariant, derived variables and published measurements.
const HARBOUR_WATCH: &[Slip] = &[
    ("(:delay 5s 60s)", "(:delay 60s 5s)"),
    ("(responding :for-new ?ship)\n    (priority 4)", "(responding :for-new ?shp)\n    (priority 4)"),
    ("(end-of ?first)", "(end-of ?third)"),
    (":period (:range 4s 12s)", ":period (:range 12s 4s)"),
    (":amplitude (> 0.5m)", ":amplitude (> 0.5s)"),
    (":cycles (>= 3)", ":cycles (>= 3s)"),
    ("(ship-arrives ? ?) :for 10min", "(ship-arrives ?) :for 10min"),
    ("?ship ?length) master)", "?ship ?length) mastr)"),
    ("(waitfor (berth given ?ship ?berth))", "(waitfor (berth givn ?ship ?berth))"),
    (",(first shifts)", ",(first shift)"),
    ("(sort lengths '>)", "(sort '> lengths)"),
    ("(if sorted (first sorted) 0m)", "(if sorted (frist sorted) 0m)"),
    ("(end-when (visibility harbour", "(end-when (visibility habour"),
    (":lateness 2s", ":lateness 2m"),
    ("(rate-of (distance-to-berth ?ship))", "(rate-of (distance-to-berth ?shp))"),
    ("(closing ?ship < -3)", "(closing ?ship < -3m)"),
    ("(distance-to-berth ?ship < 400m)", "(distance-to-berth ?ship < 400s)"),
    ("(terminate success)", "(terminate succes)"),
    ("(tape 1)", "(tape -1)"),
    ("(tape 2)", "(tape 2m)"),
    ("(lamp-heat 5)", "(lamp-heat 500)"),
    (":every 2s", ":every 2"),
    (":every 2s", ":evry 2s"),
    ("&key (:every", "&ky (:every"),
    ("(current-value draught ?ship)", "(current-value draught ?shp)"),
    ("(forall ?berth in", "(forall ?berh in"),
    ("(forall ?berth in", "(forall ?berth of"),
    ("(inform (draught ?ship = 4m))", "(inform (draught ?ship = 4s))"),
    ("(inform (draught ?ship = 4m))", "(inform (draugt ?ship = 4m))"),
    ("(inform (draught ?ship = 4m))", "(inform (draught = 4m))"),
    ("(print \"to\" ?ship ?text", "(print \"to\" ?ship ?txt"),
    ("(current-value bearing-of ?ship)", "(current-value ?ship bearing-of)"),
    ("(+ +mission-start+ 20min)", "(+ +mission-end+ 20min)"),
    ("(exit-when (:delay 39min))", "(exit-when (delay 39min))"),
    (
        "(< (or (current-value visibility harbour) 10km) least-visibility)",
        "(< (or (current-value visibility harbour) 10kg) least-visibility)",
    ),
    ("(invariant (visibility harbour > 300m))", "(invariant (visibility harbour > 300kg))"),
    ("ferry) :time-limit 5min", "ferry) :time-limt 5min"),
    ("ferry) :time-limit 5min", "ferry) :count-limit 5min"),
    ("(priority :urgency 6 :importance 7)", "(priority :urgency 6)"),
    ("(hold for mist) (waitfor", "(hold for most) (waitfor"),
    ("(land at (37.4150 -122.0480))", "(land at (-122.0480 37.4150))"),
    ("(agent master ", "(agent rotorcraft-1 "),
    (":at (37.4150 -122.0480))", ":at (137.4150 -122.0480))"),
    ("(take off to 80m)", "(take off at 80m)"),
    ("(waitfor (end ?up))", "(waitfor (end up))"),
    ("(repeating :until", "(repeats :until"),
    ("(fly to ,(berth-place", "(fly to (berth-place"),
    ("(declare-event (fog (?visibility length))", "(declare-event (fog)"),
    ("(waitfor (fog ?visibility))", "(waitfor (fog harbour ?visibility))"),
    ("(:absent (ship-arrives ? ?) :for 10min)", "(:absent :for 10min (ship-arrives ? ?))"),
    ("(:not (berth given ?ship ?))", "(not (berth given ?ship ?))"),
    ("(step each (look", "(step tell (look"),
    ("\"2026-06-01T09:00:00Z\"", "\"2026-06-01 9am\""),
    ("(return (berth-place ?berth))", "(return (berth-place ?berht))"),
    (":timeout 30s", ":timeout -30s"),
    ("(responding :for-new ?ship)\n    (priority 4)", "(responding :for-new ship)\n    (priority 4)"),
    ("(> draught 9m)", "(> depth 9m)"),
    ("(profile beacon)", "(profile beacon beacon)"),
    ("(hover for 2min)", "(hover 2min)"),
    ("(hover for 20s)", "(hover for \"20s\")"),
    ("(on-failure (inform (lamp-broken)))", "(on-failure)"),
    ("(inform (no-berth ?ship))", "(inform no-berth ?ship)"),
    ("(rank 1)", "(rank first)"),
    ("(declare-event (ship-leaves ?ship)", "(declare-event (ship-arrives ?ship)"),
    ("(defconstant shifts", "(defconstant berths"),
    ("defun is-deep (draught)", "defun is-deep draught"),
    ("(waitfor (end ?clock))", "(waitfor (start ?clock))"),
    ("(inform (swaying barge))", "(inform swaying barge)"),
    (":capacity 4", ":capacity four"),
    ("(closing ?ship < -3)", "(closing ?ship < - 3)"),
    ("(:or (end ?answer) (end ?late))", "(:or (end ?answer) (end ?lat))"),
    ("(:and (:delay 90s)", "(:and (:delay 90)"),
    ("(first sorted) 0m)", "(first sorted) 0m 1m)"),
    (":initial-task (direct traffic)", ":initial-task (direct trafic)"),
    ("ferry) :time-limit 5min", "ferry) :time-limit 5"),
    ("(look up ?berth) => ?place", "(look up ?berth) => place"),
    ("(flash 3 times at ?place)", "(flash 3s times at ?place)"),
    ("(flash 3 times at ?place)", "(flash three times at ?place)"),
    ("(priority 9)", "(priority -9 9)"),
    ("(state-variable (mood ?ship) :type symbol)", "(state-variable (mood ?ship) :type symbl)"),
    (":derived (rate-of", ":derived (rate"),
    // Words in quotes, and an instant after the end of the mission.
    ("(forall ?berth in '(north south))", "(forall ?berth in '(noth south))"),
    ("50m) 'north 'south)", "50m) 'nroth 'south)"),
    ("'((north (37", "'((noth (37"),
    ("(+ +mission-start+ 20min)", "(+ +mission-start+ 200min)"),
];

fn mission_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions").join(name).join("mission.pdl")
}

/// Returns the lines of all messages about the mission with this text, and the words of these messages.
fn said_about(path: &Path, text: &str) -> (Vec<u32>, Vec<String>) {
    let mut read = |file: &Path| -> MissionResult<String> {
        if file == path { Ok(text.to_string()) } else { apex_mission::files::read_text(file) }
    };
    let mut checked = check_program_with(path, false, &mut read).expect("the text is given");
    let mut of_data = None;
    if !checked.has_errors() {
        match Mission::of_program(path, Arc::new(checked.library.clone())) {
            Ok(mission) => checked.diagnostics.extend(check_names(&mission, &apex_solvers::shipped())),
            Err(error) => of_data = Some(error),
        }
    }
    let serious: Vec<&Diagnostic> = checked.diagnostics.iter().filter(|each| each.severity != Severity::Note).collect();
    let mut lines: Vec<u32> = Vec::new();
    let mut words: Vec<String> = Vec::new();
    for diagnostic in serious {
        let spans = std::iter::once(diagnostic.span).chain(diagnostic.labels.iter().map(|label| label.span));
        lines.extend(spans.filter(|span| span.file == 0).map(|span| span.line));
        words.push(format!("{} {}", diagnostic.code, diagnostic.message));
    }
    if let Some(error) = of_data {
        let all = error.to_string();
        // `mission.pdl:7:3`, in the headline or the reason.
        let places = all.split("mission.pdl:").skip(1);
        lines.extend(places.filter_map(|rest| rest.split(':').next()?.parse::<u32>().ok()));
        words.push(all);
    }
    (lines, words)
}

/// Plants each slip; returns those that stay silent, and those named at another line.
fn planted(path: &Path, slips: &[Slip]) -> (Vec<String>, Vec<String>) {
    let text = std::fs::read_to_string(path).expect("the mission is there");
    let mission = path.display();
    assert_eq!(said_about(path, &text).1, Vec::<String>::new(), "{mission} has no mistake");
    let (mut silent, mut elsewhere) = (Vec::new(), Vec::new());
    for (before, after) in slips {
        let at = text.find(before).unwrap_or_else(|| panic!("{mission} has no `{before}`"));
        let same = before.bytes().zip(after.bytes()).take_while(|(one, other)| one == other).count();
        let line = u32::try_from(text[..at + same].matches('\n').count() + 1).expect("few lines");
        let (lines, words) = said_about(path, &text.replacen(before, after, 1));
        if words.is_empty() {
            silent.push((*after).to_string());
        } else if !lines.contains(&line) {
            elsewhere.push(format!("{after} (line {line}): {lines:?} {words:?}"));
        }
    }
    (silent, elsewhere)
}

#[test]
fn slips_in_missions_are_named_at_their_line() {
    let (mut silent, mut elsewhere) = planted(&mission_path("structure-watch"), STRUCTURE_WATCH);
    let more = planted(&mission_path("western-states"), WESTERN_STATES);
    silent.extend(more.0);
    elsewhere.extend(more.1);
    let count = STRUCTURE_WATCH.len() + WESTERN_STATES.len();
    assert!(count >= 60);
    assert_eq!(silent, Vec::<String>::new(), "of {count} slips");
    assert!(elsewhere.len() * 20 <= count, "{} of {count} slips:\n{}", elsewhere.len(), elsewhere.join("\n"));
}

/// Every slip is found: also bare numbers as lengths in the data, and sums whose terms are known at the caller only.
#[test]
fn slips_in_expressions_and_declarations_are_named_at_their_line() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/dike-survey/mission.pdl");
    let (silent, elsewhere) = planted(&path, DIKE_SURVEY);
    assert!(DIKE_SURVEY.len() >= 75);
    assert_eq!(silent, Vec::<String>::new(), "of {} slips", DIKE_SURVEY.len());
    assert!(elsewhere.len() * 20 <= DIKE_SURVEY.len(), "{}:\n{}", elsewhere.len(), elsewhere.join("\n"));
}

#[test]
fn slips_in_conditions_and_messages_are_named_at_their_line() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/harbour-watch/mission.pdl");
    let (silent, elsewhere) = planted(&path, HARBOUR_WATCH);
    assert!(HARBOUR_WATCH.len() >= 75);
    assert_eq!(silent, Vec::<String>::new(), "of {} slips", HARBOUR_WATCH.len());
    assert!(elsewhere.len() * 20 <= HARBOUR_WATCH.len(), "{}:\n{}", elsewhere.len(), elsewhere.join("\n"));
}

/// A vehicle with commands of other arguments declares them: its declaration counts, not that of the library.
#[test]
fn a_program_replaces_the_declaration_of_a_library() {
    let said = |declaration: &str| {
        let text = format!(
            "(require-apex-library \"vehicle\")\n{declaration}\n(procedure :sequential (index (do-domain))\n  (step down (come down)))\n\
             (primitive (index (come down)) (on-start (command (land))))\n"
        );
        let source = apex_pdl::SourceText { name: "own.pdl".to_string(), text };
        let checked = apex_mission::program::check_texts(vec![source], Path::new("."));
        let serious = checked.diagnostics.into_iter().filter(|each| each.severity == Severity::Error);
        serious.map(|each| each.code).collect::<Vec<_>>()
    };
    assert_eq!(said(""), ["E0313"]);
    assert_eq!(said("(declare-command (land))"), Vec::<&str>::new());
    assert_eq!(said("(declare-command (land)) (declare-command (land))"), ["E0105"]);
}
