//! Tests of authority: the hand-over as a story, and random requests against a naive twin.

use super::*;
use proptest::prelude::*;

fn actor(name: &str) -> Actor {
    let role = match name {
        "pilot" => ActorRole::PilotInCommand,
        "guest" => ActorRole::Observer,
        _ => ActorRole::Operator,
    };
    Actor { name: name.into(), role }
}

fn at(seconds: u64) -> Duration {
    Duration::from_secs(seconds)
}

#[test]
fn authority_is_offered_and_taken_and_the_old_epoch_is_stale() {
    let (mut authority, tower, van) = (Authority::default(), actor("tower"), actor("van"));
    assert_eq!(authority.apply(&AuthorityRequest::Take, &tower, at(0)), Ok(AuthorityChange::Taken));
    assert_eq!(authority.check(&tower, Some(1)), Ok(()));
    let refused = authority.apply(&AuthorityRequest::Take, &van, at(1)).unwrap_err();
    assert!(refused.contains("tower holds authority"), "{refused}");
    assert!(authority.check(&van, None).unwrap_err().contains("tower holds authority"));
    let offer = AuthorityRequest::Offer("van".into());
    assert_eq!(authority.apply(&offer, &tower, at(2)), Ok(AuthorityChange::Offered));
    assert_eq!(authority.check(&tower, Some(1)), Ok(()), "the holder commands until the offer is taken");
    assert_eq!(authority.apply(&AuthorityRequest::Refuse, &van, at(3)), Ok(AuthorityChange::Refused));
    assert!(authority.apply(&AuthorityRequest::Take, &van, at(4)).is_err(), "a refused offer is over");
    authority.apply(&offer, &tower, at(5)).unwrap();
    assert_eq!(authority.apply(&AuthorityRequest::Take, &van, at(6)), Ok(AuthorityChange::HandedOver));
    let stale = authority.check(&tower, Some(1)).unwrap_err();
    assert_eq!(stale, "epoch 1 of authority is stale: this is epoch 2, van holds it");
    assert!(authority.check(&van, Some(1)).is_err() && authority.check(&van, Some(2)).is_ok());
    let entry = format!("{:?}", AuthorityChange::HandedOver.entry(&authority, &van));
    assert!(entry.contains("(authority 2 \"van\" operator handed-over)"), "{entry}");
}

#[test]
fn offers_end_silent_holders_lose_it_and_the_pilot_takes_it() {
    let (mut authority, tower, van, pilot) = (Authority::default(), actor("tower"), actor("van"), actor("pilot"));
    authority.apply(&AuthorityRequest::Take, &tower, at(0)).unwrap();
    authority.apply(&AuthorityRequest::Offer("van".into()), &tower, at(1)).unwrap();
    authority.hear("tower", at(60));
    assert!(authority.offer(at(60)).is_some() && authority.offer(at(61)).is_none());
    assert!(authority.apply(&AuthorityRequest::Take, &van, at(61)).is_err(), "the offer is over");
    assert!(authority.apply(&AuthorityRequest::Refuse, &van, at(61)).is_err());
    assert_eq!(authority.apply(&AuthorityRequest::Take, &van, at(90)), Ok(AuthorityChange::TakenFromSilent));
    assert_eq!(authority.apply(&AuthorityRequest::Take, &pilot, at(91)), Ok(AuthorityChange::Overridden));
    assert!(authority.apply(&AuthorityRequest::Release, &van, at(92)).unwrap_err().contains("pilot holds"));
    assert_eq!(authority.apply(&AuthorityRequest::Release, &pilot, at(93)), Ok(AuthorityChange::Released));
    assert!(authority.apply(&AuthorityRequest::Offer("van".into()), &pilot, at(94)).is_err());
    let guest = actor("guest");
    assert!(authority.apply(&AuthorityRequest::Take, &guest, at(95)).unwrap_err().contains("observer"));
    assert!(authority.check(&guest, None).is_err() && authority.check(&van, None).is_ok());
    assert_eq!(ActorRole::ALL.map(|role| ActorRole::of_word(role.word())), ActorRole::ALL.map(Some));
}

const NAMES: [&str; 4] = ["guest", "tower", "van", "pilot"];

/// Returns the holder by folding the whole history again (naive twin).
fn holder_of(accepted: &[(u64, usize, AuthorityRequest)]) -> (u64, Option<usize>) {
    accepted.iter().fold((0, None), |(epoch, holder), (_, who, request)| match request {
        AuthorityRequest::Take => (epoch + 1, Some(*who)),
        AuthorityRequest::Release => (epoch + 1, None),
        AuthorityRequest::Offer(_) | AuthorityRequest::Refuse => (epoch, holder),
    })
}

fn may_naively(
    accepted: &[(u64, usize, AuthorityRequest)],
    (now, who): (u64, usize),
    request: &AuthorityRequest,
) -> bool {
    let (_, holder) = holder_of(accepted);
    let since_take = accepted.iter().rposition(|(_, _, each)| {
        matches!(each, AuthorityRequest::Take | AuthorityRequest::Release | AuthorityRequest::Refuse)
    });
    let recent = &accepted[since_take.map_or(0, |last| last + 1)..];
    let offered = recent.iter().rev().find_map(|(at, _, each)| match each {
        AuthorityRequest::Offer(to) => Some(to == NAMES[who] && now - at < 60),
        _ => None,
    });
    let offered = offered == Some(true);
    let taken_at = accepted.iter().rev().find_map(|(at, _, each)| (*each == AuthorityRequest::Take).then_some(*at));
    match (who, request) {
        (0, _) => false,
        (_, AuthorityRequest::Take) => {
            holder != Some(who) && (holder.is_none() || offered || who == 3 || now - taken_at.unwrap_or(0) >= 30)
        }
        (_, AuthorityRequest::Offer(to)) => holder == Some(who) && to != NAMES[who],
        (_, AuthorityRequest::Refuse) => offered,
        (_, AuthorityRequest::Release) => holder == Some(who),
    }
}

proptest! {
    #[test]
    fn authority_is_its_naive_twin(steps in prop::collection::vec((0u64..40, 0usize..4, 0usize..6), 0..80)) {
        let (mut authority, mut accepted, mut now) = (Authority::default(), Vec::new(), 0);
        for (passed, who, kind) in steps {
            now += passed;
            let request = match kind {
                0 => AuthorityRequest::Refuse,
                1 => AuthorityRequest::Release,
                2 | 3 => AuthorityRequest::Take,
                other => AuthorityRequest::Offer(NAMES[other - 3].into()),
            };
            let before = authority.clone();
            let applied = authority.apply(&request, &actor(NAMES[who]), at(now));
            prop_assert_eq!(applied.is_ok(), may_naively(&accepted, (now, who), &request), "{:?} {} {:?}", applied, who, request);
            if applied.is_ok() {
                accepted.push((now, who, request));
            } else {
                prop_assert_eq!(&authority, &before);
            }
            let (epoch, holder) = holder_of(&accepted);
            let shown = authority.holder.as_ref().map(|holder| holder.name.as_str());
            prop_assert_eq!((authority.epoch, shown), (epoch, holder.map(|who| NAMES[who])));
            for (index, name) in NAMES.into_iter().enumerate() {
                let may = index > 0 && holder.is_none_or(|holder| holder == index);
                prop_assert_eq!(authority.check(&actor(name), Some(epoch)).is_ok(), may);
                prop_assert!(authority.check(&actor(name), Some(epoch + 1)).is_err());
            }
        }
    }
}
