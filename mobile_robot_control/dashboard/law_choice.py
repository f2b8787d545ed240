"""A law chosen on the page: its shipped set as one change, which can be undone."""

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from mobile_robot_control.settings.files import Values
from mobile_robot_control.settings.law_sets import LAW, POSITION, differing, groups_set_by_user, set_for

Change = Callable[[str, Mapping[str, Any]], Awaitable[None]]


def law_changes(law: str, present: Values, whole: bool) -> Values:
    """
    Return the changes by node that choose a law.

    Parameters
    ----------
    law : str
        Chosen one.
    present : dict of str to dict
        Parameters by node.
    whole : bool
        Whether groups of gains that the user has set are replaced, too.

    Returns
    -------
    dict of str to dict
        The shipped set of the law, where it is for this robot and its rates; otherwise the law alone.

    """
    shipped = set_for(law, present)
    if shipped is None:
        return {POSITION: {LAW: law}}
    users = set() if whole else groups_set_by_user(present)
    changes = {node: {name: value for name, value in values.items() if (node, name.partition('.')[0]) not in users}
               for node, values in differing(shipped, present).items()}
    return {node: values for node, values in changes.items() if values}


async def change_all(changes: Values, present: Values, change: Change) -> Values:
    """Make changes by node, all or none of them; return the values before."""
    before = {node: {name: present[node][name] for name in values if name in present.get(node, {})}
              for node, values in changes.items()}
    changed: list[str] = []
    try:
        for node, values in changes.items():
            await change(node, values)
            changed.append(node)
    except Exception:
        for node in changed:
            await change(node, before[node])
        raise
    return before


class LawChoice:
    """
    The last choice of a law on the page.

    Parameters
    ----------
    present : callable
        Returns the parameters by node.
    change : callable
        Changes parameters of a node, all or none of them; raises if it is refused.

    """

    def __init__(self, present: Callable[[], Awaitable[Values]], change: Change) -> None:
        self._present, self._change = present, change
        self._before: Values = {}

    async def choose(self, law: str, whole: bool) -> None:
        """Change to a law, '' for the present one, with its shipped set; with `whole`, over gains of the user."""
        present = await self._present()
        law = law or present.get(POSITION, {}).get(LAW, '')
        # the first time, all sets are read
        changes = await asyncio.to_thread(law_changes, law, present, whole)
        if changes:
            self._before = await change_all(changes, present, self._change)

    async def undo(self) -> None:
        """Give back the law and the gains before the last choice."""
        before, self._before = self._before, {}
        await change_all(before, await self._present(), self._change)

    def forget(self) -> None:
        """Undo nothing more: all parameters have been set anew."""
        self._before = {}

    def shown(self, present: Values) -> dict[str, str]:
        """
        Return what the page shows of the law's gains, ready for JSON.

        `gains` is 'shipped', 'changed', or '' for a law without a set for this robot; `file` has the set; `before` is
        the law before the last choice, '' if there is nothing to undo.
        """
        law: str = present.get(POSITION, {}).get(LAW, '')
        shipped = set_for(law, present)
        return {'gains': '' if shipped is None else 'changed' if differing(shipped, present) else 'shipped',
                'file': '' if shipped is None else shipped.given,
                'before': str(self._before.get(POSITION, {}).get(LAW, law)) if self._before else ''}
