//! The page's TypeScript types of operation, sessions, forks and drafts. `UPDATE=1 cargo test -p apex-server typescript` rewrites them.

use crate::access::SessionState;
use crate::answer::Remedy;
use crate::flights::Failure;
use crate::mission_facts::{MissionFacts, WantedWindow};
use crate::operation::{
    ActorState, AuthorityState, CommandState, OfferState, OpenQuestion, Operation, Planning, TargetNews, Wish,
};
use crate::shelf::{ForkRow, ShelfRow};
use crate::what_if::{DraftAnswer, DraftViolation, ForkRequest, ForkState, InputRequest, Worth};
use apex_typescript::{check, declaration};

#[test]
fn typescript_types_of_the_server_are_current() {
    let declarations = [
        declaration::<MissionFacts>(),
        declaration::<WantedWindow>(),
        declaration::<Operation>(),
        declaration::<OpenQuestion>(),
        declaration::<Planning>(),
        declaration::<TargetNews>(),
        declaration::<CommandState>(),
        declaration::<AuthorityState>(),
        declaration::<ActorState>(),
        declaration::<OfferState>(),
        declaration::<Wish>(),
        declaration::<SessionState>(),
        declaration::<ShelfRow>(),
        declaration::<ForkRow>(),
        declaration::<ForkState>(),
        declaration::<ForkRequest>(),
        declaration::<InputRequest>(),
        declaration::<Failure>(),
        declaration::<DraftAnswer>(),
        declaration::<Worth>(),
        declaration::<DraftViolation>(),
        declaration::<Remedy>(),
    ];
    check("server", "server.ts", "\nimport type { PlanInForce } from './view';\n", &declarations).unwrap();
}
