//! States the layout of an agent's state, which snapshots in a record have.

mod fingerprint;

fn main() {
    fingerprint::set("APEX_STATE_LAYOUT", &["../model/src", "../executive/src"]);
}
