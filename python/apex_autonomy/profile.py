"""The profile of planners: which planner is best on which test missions at which time for deliberation."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from apex_autonomy._apex import cell_names, measured, merged_profile, profile_table
from apex_autonomy.planner import Planner, means

__all__ = ["Profile", "profile_cells"]


def profile_cells(*names: str) -> list[str]:
    """Return the names of cells of test missions; ``"all"`` and ``"subset"`` name several cells.

    Raises
    ------
    MissionError
        A cell is unknown or named twice.

    Examples
    --------
    >>> from apex_autonomy import profile_cells
    >>> len(profile_cells("all"))
    243
    """
    return cell_names(list(names))


def _names_and_own(planners: Iterable[Planner | str]) -> tuple[list[str], list[Planner]]:
    listed = list(planners)
    own = [planner for planner in listed if isinstance(planner, Planner)]
    return [planner.name if isinstance(planner, Planner) else planner for planner in listed], own


@dataclass(frozen=True)
class Profile:
    """Costs of planners on test missions (``docs/reference/profile-table.md``).

    Attributes
    ----------
    text : str
        The profile in the format of ``apex profile build``.

    Examples
    --------
    >>> from apex_autonomy import Profile
    >>> cells = ["small-fixed-fixed-4-uniform"]
    >>> profile = Profile.measure(cells, planners=["nearest-neighbour"], missions=2, budgets_s=[0.001])
    >>> "small-fixed-fixed-4-uniform" in profile.table
    True
    """

    text: str

    @staticmethod
    def measure(
        cells: Iterable[str], *, planners: Iterable[Planner | str], missions: int = 50, budgets_s: Sequence[float]
    ) -> Profile:
        """Measure planners on test missions.

        Parameters
        ----------
        cells : iterable of str
            Names of cells; ``"all"`` and ``"subset"`` name several cells.
        planners : iterable of Planner or str
            User-defined planners, or names of planners that ship with Apex.
        missions : int
            Test missions of each cell.
        budgets_s : sequence of float
            Times for deliberation, in increasing order.

        Raises
        ------
        MissionError
            An unknown cell or planner, budgets that do not increase, a planner that finds no plan or an invalid one.
        """
        names, own = _names_and_own(planners)
        return Profile(measured(None, (list(cells), missions, list(budgets_s)), names, means(own)))

    def with_planners(self, planners: Iterable[Planner | str]) -> Profile:
        """Measure more planners on the same missions; results of a planner measured before are replaced.

        Raises
        ------
        MissionError
            As for `measure`; or the profile was measured on test missions of another version.
        """
        names, own = _names_and_own(planners)
        return Profile(measured(self.text, ([], 0, []), names, means(own)))

    @staticmethod
    def merge(parts: Iterable[Profile]) -> Profile:
        """Merge profiles of different cells or planners that were measured separately.

        Raises
        ------
        MissionError
            The profiles do not belong together.
        """
        return Profile(merged_profile([part.text for part in parts]))

    @property
    def table(self) -> str:
        """The table by which planners are selected: for `plan`, `fly`, and ``apex fly --table``."""
        return profile_table(self.text)
