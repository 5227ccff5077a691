//! Tests of the bounds and their parts against naive twins, on asymmetric networks.

use super::label_completion::LabelCompletion;
use super::labels::{CompletionBound, Labelling, MultiplierRefund};
use super::latest_departures::LatestDepartures;
use super::ng_sets::Targets;
use super::pareto_front::ParetoFront;
use super::value_step::ValueStep;
use super::walks::Layout;
use super::*;
use crate::routing::network::{END, FIRST, NO_WAY, Network, Node, START};
use apex_planning::random::Generator;
use apex_planning::solver::WorkBudget;
use proptest::prelude::*;

/// Sizes with which walks over few targets revisit some, and pairs are left out.
const SMALL: MemorySizes = MemorySizes { remembered: 3, first_remembered: [1, 2, 3, 4], listed_max: 2 };

/// Returns a network of up to eight targets with one or two nodes each, wide and narrow windows, waiting, and one-way legs of any length.
/// In every second network the targets that can be visited are far apart in the list of all targets.
fn random(seed: u64) -> Network {
    let (nodes, legs, targets) = parts(seed);
    Network::given(nodes, legs, targets)
}

fn parts(seed: u64) -> (Vec<Node>, Vec<i32>, usize) {
    parts_apart(seed, if seed.is_multiple_of(2) { 1 } else { 17 })
}

/// Returns parts of a network in which only every `apart`-th target can be visited.
fn parts_apart(seed: u64, apart: u32) -> (Vec<Node>, Vec<i32>, usize) {
    let mut rng = Generator::new(seed);
    let targets = 3 + rng.below(6);
    let limit = 100 + rng.below(120) as i32;
    let terminal = |close| Node { target: u32::MAX, manoeuvre: 0, open: 0, close, value: 0.0 };
    let mut nodes = vec![terminal(0), terminal(limit)];
    for target in 0..targets as u32 {
        for manoeuvre in 0..1 + u32::from(rng.below(4) == 0) {
            let open = rng.below(limit as usize) as i32;
            let wide = rng.below(2) == 0;
            let (open, close) = if wide { (0, limit) } else { (open, open + rng.below(40) as i32) };
            let value = match seed % 3 {
                0 => 10.0 * (1 + rng.below(5)) as f64,
                1 => 0.1 * (1 + rng.below(30)) as f64,
                _ => 0.01 + rng.unit(),
            };
            let target = target * apart;
            nodes.push(Node { target, manoeuvre, open, close, value });
        }
    }
    let leg = |from: usize, to: usize, rng: &mut Generator| {
        let same = nodes[from].target == nodes[to].target;
        if same || to as u32 == START || from as u32 == END || rng.below(12) == 0 {
            return if from as u32 == START && to as u32 == END { 0 } else { NO_WAY };
        }
        3 + rng.below(45) as i32
    };
    let legs = (0..nodes.len() * nodes.len()).map(|it| leg(it / nodes.len(), it % nodes.len(), &mut rng)).collect();
    (nodes, legs, (targets - 1) * apart as usize + 1)
}

/// Returns true if the route is in time.
fn flies(network: &Network, visits: &[u32]) -> bool {
    let (mut here, mut time) = (START, 0);
    visits.iter().copied().chain([END]).all(|next| {
        time = (time + network.leg(here, next)).max(network.node(next).open);
        here = next;
        time <= network.node(next).close
    })
}

/// Returns all routes with their values.
fn routes(network: &Network) -> Vec<(f64, Vec<u32>)> {
    let (mut all, mut open) = (vec![(0.0, Vec::new())], vec![Vec::new()]);
    while let Some(visits) = open.pop() {
        let seen = |node: u32| visits.iter().any(|it| network.node(*it).target == network.node(node).target);
        for node in network.visits().filter(|node| !seen(*node)) {
            let mut longer: Vec<u32> = visits.clone();
            longer.push(node);
            if in_time(network, &longer) {
                if flies(network, &longer) {
                    all.push((longer.iter().map(|node| network.node(*node).value).sum(), longer.clone()));
                }
                open.push(longer);
            }
        }
    }
    all
}

/// Returns true if every visit is in time, the end aside.
fn in_time(network: &Network, visits: &[u32]) -> bool {
    let (mut here, mut time) = (START, 0);
    visits.iter().copied().all(|next| {
        time = (time + network.leg(here, next)).max(network.node(next).open);
        here = next;
        time <= network.node(next).close
    })
}

fn most(routes: &[(f64, Vec<u32>)]) -> f64 {
    routes.iter().map(|(value, _)| *value).fold(0.0, f64::max)
}

/// Returns multipliers of any size, some of them zero.
fn random_multipliers(network: &Network, rng: &mut Generator) -> Vec<f64> {
    let mean = network.nodes.iter().map(|node| node.value).sum::<f64>() / network.visits().len() as f64;
    (0..network.targets).map(|_| (1.5 * rng.unit() - 0.4).max(0.0) * mean).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]
    #[test]
    fn what_is_proven_is_the_most_that_any_route_is_worth(seed in 0..100_000u64, share in 0..3u32) {
        let network = random(seed);
        let best = most(&routes(&network));
        let incumbent = f64::from(share) * 0.5 * best;
        let sum: f64 = network.nodes.iter().map(|node| node.value).sum();
        for sizes in [SMALL, MemorySizes::SHIPPED] {
            let mut proof = ProofSearch::new(&network, sum, sizes).unwrap();
            let (mut reached, mut bound) = (incumbent, f64::INFINITY);
            // A search with coarse settings may leave a gap, which a search with fine settings must close.
            for is_fine in [false, true] {
                if is_fine {
                    proof.restart_fine(None);
                }
                prop_assert!(proof.run(reached, 1 << 40, &mut WorkBudget::new(1 << 40)));
                let found = proof.known();
                if let Some(route) = &found.better {
                    prop_assert!(flies(&network, route));
                    reached = proof::value_of(&network, route).unwrap();
                }
                bound = ValueStep::new(&network).below(found.bound).max(reached);
                prop_assert!(bound >= best - 1e-9, "{bound} of {best}");
            }
            prop_assert!(bound <= best + 1e-5, "{bound} of {best}");
            prop_assert!((reached - best.max(incumbent)).abs() < 1e-9, "{reached} of {best}");
        }
    }

    #[test]
    fn no_route_is_lost_where_ways_over_others_are_faster(seed in 0..100_000u64) {
        let (nodes, legs, targets) = parts(seed);
        let tight = Network::given(nodes.clone(), legs.clone(), targets);
        let mut wide = Network::given(nodes.clone(), legs, targets);
        wide.nodes = nodes;
        prop_assert_eq!(most(&routes(&tight)), most(&routes(&wide)));
    }

    #[test]
    fn no_bound_is_below_the_best_route_however_few_units_there_are(seed in 0..100_000u64, units in 0..200u64) {
        let network = random(seed);
        let best = most(&routes(&network));
        let found = highest_value(&network, 0.0, units, &mut WorkBudget::new(1 << 40));
        prop_assert!(found.bound >= best - 1e-9, "{} of {best}", found.bound);
    }

    #[test]
    fn a_question_asked_bit_by_bit_is_answered_as_one_asked_at_once(seed in 0..100_000u64, units in 1..40u64) {
        let network = random(seed);
        let best = most(&routes(&network));
        let (mut question, budget) = (BoundSearch::new(&network), &mut WorkBudget::new(1 << 40));
        let mut incumbent = 0.0;
        for ask in 0..12 {
            match ask % 3 {
                2 => question.answer(incumbent, units, budget),
                _ => question.ask_labels(incumbent, units, budget),
            }
            let told = question.told();
            prop_assert!(told.bound >= best - 1e-9, "{} of {best}", told.bound);
            if let Some(route) = told.better {
                prop_assert!(flies(&network, &route));
                let value = proof::value_of(&network, &route).unwrap();
                prop_assert!(value > incumbent && value <= best + 1e-9, "{value} after {incumbent} of {best}");
                incumbent = value;
            }
        }
        question.answer(incumbent, 1 << 30, budget);
        let told = question.told();
        prop_assert!((told.bound - best).abs() < 1e-5, "{} of {best}", told.bound);
        prop_assert_eq!(told.better.is_some(), incumbent < best - 1e-9);
    }

    #[test]
    fn of_targets_that_fit_into_no_set_walks_alone_say_what_they_can(seed in 0..100_000u64, units in 0..20_000u64) {
        let (nodes, legs, targets) = parts_apart(seed, 64);
        let network = Network::given(nodes, legs, targets);
        prop_assert_eq!(ProofSearch::new(&network, 0.0, SMALL).is_some(), targets <= 128);
        let found = highest_value(&network, 0.0, units, &mut WorkBudget::new(1 << 40));
        prop_assert!(found.bound >= most(&routes(&network)) - 1e-9);
        prop_assert!(found.better.is_none() || targets <= 128);
    }

    #[test]
    fn labels_of_either_end_find_what_no_route_beats_whatever_prices_and_memory(seed in 0..100_000u64) {
        let network = random(seed);
        let turned = network.turned();
        let mut rng = Generator::new(seed);
        let all = routes(&network);
        let best = most(&all);
        let multipliers = random_multipliers(&network, &mut rng);
        let reduced_profit = reduced_profits(&network, &multipliers);
        let shortest = network.visits().flat_map(|a| network.visits().map(move |b| (a, b))).filter(|(a, b)| a != b);
        let shortest = shortest.map(|(a, b)| network.leg(a, b)).min().unwrap();
        let layout = Layout::new(&network, 1 + rng.below(shortest as usize) as i32);
        let (completion, _) = walk_completion::WalkCompletion::new(&network, &layout, &proof::successors(&network), &multipliers);
        let cutoff = best * rng.unit();
        let refund = MultiplierRefund::All(multipliers.iter().sum());
        let (mut rest, mut steps) = (None, 0);
        for run in 0..4 {
            let network = if run % 2 == 0 { &network } else { &turned };
            let latest_departures = &LatestDepartures::new(network);
            let mut any = || Targets::from(rng.bits()) << 64 | Targets::from(rng.bits());
            let ng_sets: Vec<Targets> =
                (0..network.targets as u32).map(|target| ng_sets::bit_of(target) | any() & any()).collect();
            let completion_bound = rest.as_ref().map_or(CompletionBound::Walks(&completion), CompletionBound::Labels);
            let successors = proof::successors(network);
            let (reduced_profit, ng_sets, successors) = (reduced_profit.as_slice(), ng_sets.as_slice(), successors.as_slice());
            let search = Labelling {
                network,
                latest_departures,
                reduced_profit,
                ng_sets,
                successors,
                completion_bound,
                refund,
                cutoff,
                slack: 0.0,
            };
            let found = search.run(u64::MAX, &mut WorkBudget::new(u64::MAX)).unwrap();
            prop_assert!(found.value >= best - 1e-9, "run {run}: {} of {best}", found.value);
            prop_assert!(flies(network, &found.walk));
            // A search with unreduced values that remembers all visited targets is exact.
            if let Some(rest) = &rest {
                let (all, values) = (vec![Targets::MAX; network.targets], reduced_profits(network, &[]));
                let (reduced_profit, refund) = (values.as_slice(), MultiplierRefund::Unvisited(&multipliers));
                let completion_bound = CompletionBound::Labels(rest);
                let search = Labelling { reduced_profit, ng_sets: &all, completion_bound, refund, ..search };
                let found = search.run(u64::MAX, &mut WorkBudget::new(u64::MAX)).unwrap();
                prop_assert!((found.value - best).abs() < 1e-9, "run {run}: {} is not {best}", found.value);
            }
            rest = Some(LabelCompletion::new(network, &found.labels, reduced_profit, SMALL.listed_max, &mut steps));
        }
    }

    #[test]
    fn a_route_is_in_time_where_it_is_when_flown_backwards_from_the_end(seed in 0..100_000u64) {
        let network = random(seed);
        let turned = network.turned();
        let count = routes(&network).len();
        prop_assert_eq!(count, routes(&turned).len());
        for (_, mut route) in routes(&network) {
            route.reverse();
            prop_assert!(flies(&turned, &route));
        }
    }

    #[test]
    fn what_is_missed_is_in_no_route_that_continues(seed in 0..100_000u64) {
        let network = random(seed);
        let latest_departures = LatestDepartures::new(&network);
        for (_, route) in routes(&network) {
            let (mut here, mut time, mut missed) = (START, 0, 0);
            for next in route {
                prop_assert_eq!(missed & ng_sets::bit_of(network.node(next).target), 0);
                time = (time + network.leg(here, next)).max(network.node(next).open);
                missed = latest_departures.missed(next, time);
                here = next;
            }
        }
    }

    #[test]
    fn a_front_beats_what_one_of_all_pairs_beats(seed in 0..100_000u64) {
        let mut rng = Generator::new(seed);
        let (mut front, mut all, mut steps) = (ParetoFront::default(), Vec::<(f64, Targets)>::new(), 0);
        for _ in 0..60 {
            let (value, seen) = (rng.below(12) as f64, Targets::from(rng.below(64) as u64) << 61);
            let beaten = all.iter().any(|(other, set)| *other >= value && set & !seen == 0);
            prop_assert_eq!(front.beats(value, seen, &mut steps), beaten);
            if !beaten {
                front.insert(value, seen, &mut steps);
                all.push((value, seen));
            }
        }
    }
}

fn valued(values: &[f64]) -> ValueStep {
    let node = |target: u32, value: f64| Node { target, manoeuvre: 0, open: 0, close: 10, value };
    let nodes: Vec<Node> = [0.0, 0.0].iter().chain(values).zip(0..).map(|(value, it)| node(it, *value)).collect();
    assert_eq!(nodes.len() as u32, FIRST + values.len() as u32);
    let legs = vec![1; nodes.len() * nodes.len()];
    ValueStep::new(&Network::given(nodes, legs, values.len()))
}

#[test]
fn between_multiples_there_is_no_route() {
    let tens = valued(&[10.0, 30.0, 50.0]);
    assert_eq!((tens.below(1_207.3), tens.below(1_210.0), tens.below(1_209.999_999_999)), (1_200.0, 1_210.0, 1_210.0));
    assert!(tens.above(1190.0) > 1199.9 && tens.above(1190.0) < 1200.0);
    // The value of a plan may differ from that of every route, because the values of targets change with time.
    assert!(tens.above(1194.5) > 1199.9 && tens.above(1194.5) < 1200.0);
    let tenths = valued(&[0.3, 0.6, 1.5]);
    assert!((tenths.below(0.1 + 0.2) - 0.3).abs() < 1e-6 && tenths.below(0.1 + 0.2) >= 0.1 + 0.2);
    assert!((tenths.above(0.3) - 0.6).abs() < 1e-6 && tenths.above(0.3) < 0.6);
    let any = valued(&[0.123_456, 1.0]);
    assert!(any.above(1.0) > 1.0 && any.above(1.0) < any.below(1.0) && any.below(1.0) < 1.0 + 1e-8);
    let off = valued(&[1.0, 2.000_001]);
    assert!(off.above(1.0) < 1.000_001 && off.below(2.5) > 2.4, "nearly whole is not whole");
    // A sum of values that are nearly whole may lie a little below a multiple.
    assert_eq!(tens.below(10.0 - 5e-7), 10.0);
    assert!(tenths.below(0.3 - 5e-8) > 0.29 && tenths.below(0.3 - 5e-6) < 0.01);
}

#[test]
fn values_whose_sums_cannot_be_distinguished_have_no_step() {
    assert_eq!(valued(&[1.0; 1_000]).below(2.5), 2.0);
    assert!(valued(&[1.0; 1_001]).below(2.5) > 2.4, "remainders of more targets may add up");
    assert!(valued(&[2e9, 4e9]).below(3e9) > 2.9e9, "large values lose their last decimals");
    assert!(valued(&[-1.0, 2.0]).below(1.5) > 1.4 && valued(&[]).below(1.5) > 1.4);
}
