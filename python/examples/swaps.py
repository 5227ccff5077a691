"""A user-defined planner in Python: it plans, and it flies."""

import random
import sys

from apex_autonomy import Environment, Mission, Planner


class Swaps(Planner):
    """Plans a cycle through all targets, and swaps two targets as long as that lowers the travel time."""

    name = "py-swaps"

    def plan(self, problem, environment: Environment) -> list[str]:
        """Return the names of the targets in the order of visits."""
        travel, targets = problem["travel"], problem["targets"]

        def lap_s(order: list[int]) -> float:
            legs = zip(order, [*order[1:], order[0]], strict=True)
            return sum(travel["between_s"][one][other] + targets[other]["dwell_s"] for one, other in legs)

        def flown(order: list[int]) -> list[str]:
            laps = int(problem["horizon_s"] // max(lap_s(order), 1.0)) + 1
            # Apex cuts off the visits beyond the horizon.
            return [targets[index]["name"] for index in order] * laps

        rng = random.Random(environment.seed)
        best = list(range(len(targets)))
        environment.report(flown(best))
        # Charges ten microseconds for each leg of the cycle.
        while len(best) > 1 and environment.charge(10 * len(best)):
            tried = best.copy()
            one, other = rng.sample(range(len(best)), 2)
            tried[one], tried[other] = tried[other], tried[one]
            if lap_s(tried) < lap_s(best):
                best = tried
                environment.report(flown(best))
        return flown(best)


if __name__ == "__main__":
    # For example: python swaps.py missions/structure-watch
    planned = Mission.load(sys.argv[1]).plan(planner=Swaps(), budget_s=0.005)
    plan = planned.answer["plan"]["Surveillance"]
    print(f"planned by {plan['solver']}:", *(visit["target"] for visit in plan["visits"]))
