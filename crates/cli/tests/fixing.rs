//! `apex check --fix`: files that it changes, files that it leaves unchanged; no file is ever half written.

mod common;

use common::Desk;

const MISSPELT: &str =
    "; Grüße an alle\n(primitive (index (greet ?who))\n  (on-strat (prnt \"hello\" ?who))) ; bleibt\n";
const MENDED: &str =
    "; Grüße an alle\n(primitive (index (greet ?who))\n  (on-start (print \"hello\" ?who))) ; bleibt\n";

#[test]
fn safe_fixes_are_made_pass_after_pass_and_reported() {
    let desk = Desk::new();
    desk.write("a.pdl", MISSPELT);
    desk.apex(&["check", "--fix", "a.pdl"]).well().told(&[
        "fixed a.pdl:3:3 [E0106]: replace `on-strat` by `on-start`",
        "fixed a.pdl:3:14 [E0201]: replace `prnt` by `print`",
        "a.pdl: 2 fixes made; 0 procedures, 1 primitive, 0 errors",
    ]);
    assert_eq!(desk.read("a.pdl"), MENDED);
    assert_eq!(desk.names(), ["a.pdl"]);
    desk.apex(&["check", "--fix", "a.pdl"]).well().told(&["a.pdl: 0 fixes made; "]);
}

#[test]
fn what_is_left_is_reported_and_decides_how_it_ends() {
    let desk = Desk::new();
    desk.write(
        "a.pdl",
        "(procedure (index (do-domain))\n  (step s (make coffee) (witfor (go)))\n  (end-when (stop)))\n",
    );
    let said = desk.apex(&["check", "--fix", "a.pdl"]).complained(2, &[]);
    said.told(&["fixed a.pdl:2:25", "error[E0208]", "a.pdl: 1 fix made; 1 procedure, 0 primitives, 1 error,"]);
}

#[test]
fn words_behind_a_missing_parenthesis_are_fixed_in_the_same_run() {
    let desk = Desk::new();
    let right = "(procedure :sequential (index (do-domain))\n  (step greet (greet you))\n  (step wait (greet me) (waitfor (end ?greet)))\n  (step stop (terminate)))\n\n(primitive (index (greet ?who))\n  (duration 5s)\n  (on-start (print \"hello\" ?who)))\n";
    let wrong = right
        .replace("(step greet (greet you))", "(step greet (greet you)")
        .replace("(waitfor", "(witfor")
        .replace("duration", "durtion")
        .replace("on-start", "on-strat");
    desk.write("a.pdl", &wrong);
    desk.apex(&["check", "--fix", "a.pdl"]).well().told(&["a.pdl: 4 fixes made; 1 procedure, 1 primitive, 0 errors"]);
    assert_eq!(desk.read("a.pdl"), right);
}

#[test]
fn a_dry_run_changes_nothing_and_prints_a_difference() {
    let desk = Desk::new();
    desk.write("a.pdl", MISSPELT);
    let said = desk.apex(&["check", "--fix", "--dry-run", "a.pdl"]).complained(0, &["a.pdl: 2 fixes possible; "]);
    said.told(&["--- a.pdl\n+++ a.pdl\n@@", "\n-  (on-strat (prnt", "\n+  (on-start (print"]);
    assert_eq!(desk.read("a.pdl"), MISSPELT);
    desk.apex(&["check", "--dry-run", "a.pdl"]).complained(2, &["--fix"]);
}

#[test]
fn standard_input_goes_to_standard_output() {
    let desk = Desk::new();
    let said = desk.apex_hearing(&["check", "--fix", "-"], MISSPELT).complained(0, &["standard input: 2 fixes made"]);
    assert_eq!(said.out, MENDED);
}

#[test]
fn line_ends_and_byte_order_marks_stay() {
    let desk = Desk::new();
    for marked in [MISSPELT.replace('\n', "\r\n"), format!("\u{feff}{MISSPELT}")] {
        desk.write("a.pdl", &marked);
        desk.apex(&["check", "--fix", "a.pdl"]).well();
        assert_eq!(desk.read("a.pdl"), marked.replace("on-strat", "on-start").replace("prnt", "print"));
    }
}

#[test]
fn required_files_are_fixed_and_shipped_libraries_are_not() {
    let desk = Desk::new();
    desk.write("main.pdl", "(require-apex-library \"vehicle\")\n(require-apex-file \"part.pdl\")\n");
    desk.write("part.pdl", "(procedure (index (do-domain)) (step s (take of to 5m)) (end-when (stop)))\n");
    desk.apex(&["check", "--fix", "main.pdl"]).well().told(&["fixed part.pdl:1:", "replace `of` by `off`"]);
    assert!(desk.read("part.pdl").contains("(take off to 5m)"));
    assert_eq!(desk.names(), ["main.pdl", "part.pdl"]);
}

#[cfg(unix)]
#[test]
fn the_mode_of_a_file_and_the_link_to_it_stay() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let desk = Desk::new();
    desk.write("real.pdl", MISSPELT);
    std::fs::set_permissions(desk.path("real.pdl"), std::fs::Permissions::from_mode(0o640)).unwrap();
    symlink("real.pdl", desk.path("a.pdl")).unwrap();
    desk.apex(&["check", "--fix", "a.pdl"]).well();
    assert_eq!(desk.read("real.pdl"), MENDED);
    assert!(std::fs::symlink_metadata(desk.path("a.pdl")).unwrap().is_symlink());
    assert_eq!(std::fs::metadata(desk.path("real.pdl")).unwrap().permissions().mode() & 0o777, 0o640);
}

#[test]
fn a_read_only_file_is_left_alone() {
    let desk = Desk::new();
    desk.write("a.pdl", MISSPELT);
    let mut permissions = std::fs::metadata(desk.path("a.pdl")).unwrap().permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(desk.path("a.pdl"), permissions).unwrap();
    desk.apex(&["check", "--fix", "a.pdl"]).complained(1, &["cannot write a.pdl", "read-only", "unchanged"]);
    assert_eq!(desk.read("a.pdl"), MISSPELT);
}

#[test]
fn as_json_fixes_come_before_what_is_left() {
    let desk = Desk::new();
    desk.write("a.pdl", MISSPELT);
    let lines = desk.apex(&["check", "--fix", "--json", "a.pdl"]).well().json_lines();
    assert_eq!(lines[0]["fixed"], "replace `on-strat` by `on-start`");
    assert_eq!((&lines[0]["code"], &lines[0]["place"]), (&"E0106".into(), &"a.pdl:3:3".into()));
}
