"""The frames of poses: the newest transform of each, and the pose of one in another."""

from mobile_robot_control.messages.parsing import Link, RefusedMessageError
from mobile_robot_control.quantities import Pose
from mobile_robot_control.reference.localisation import SAME, composed


class Frames:
    """
    The newest transform of each frame: the one way of transforms for nodes, replays and tests.

    Parameters
    ----------
    outer, inner : str
        The frame of paths, and that of odometry, some transforms below it.

    """

    def __init__(self, outer: str, inner: str) -> None:
        self._outer, self._inner = outer, inner
        self._links: dict[str, Link] = {}
        self._static: set[str] = set()

    def take_transforms(self, links: list[Link], static: bool = False) -> bool:
        """
        Take transforms; return whether one of them leads from the outer to the inner frame.

        Raises RefusedMessageError for a second value with the stamp of the first one, or an earlier stamp.
        """
        for link in links:
            before = self._links.get(link.child)
            if before is not None and not static and link.child not in self._static:
                if link.stamp < before.stamp:
                    raise RefusedMessageError('stamp does not advance', f'{link.parent} -> {link.child} has one of '
                                              f'{(before.stamp - link.stamp) / 1e9:.3f} s before; is its time reset?')
                if link.stamp == before.stamp and link != before:
                    raise RefusedMessageError('two values for one stamp', f'{link.parent} -> {link.child} has another '
                                              f'value at {link.stamp / 1e9:.3f} s: do two nodes publish it?')
            self._links[link.child] = link
            if static:
                self._static.add(link.child)
        return bool({link.child for link in links} & {link.child for link in self._chain()})

    def forget_transforms(self) -> None:
        """Forget the transforms of /tf."""
        self._links = {child: link for child, link in self._links.items() if child in self._static}

    def _chain(self) -> list[Link]:
        """Return the transforms from the inner frame up to the outer one; [] where one is missing."""
        chain: list[Link] = []
        frame = self._inner
        while frame != self._outer:
            link = self._links.get(frame)
            if link is None or len(chain) > len(self._links):
                return []
            chain.append(link)
            frame = link.parent
        return chain

    def correction(self) -> tuple[int, Pose] | None:
        """Return the stamp [ns] of the newest moving transform, and the pose of the inner frame in the outer one."""
        chain = self._chain()
        if not chain:
            return None
        pose = SAME
        for link in chain:
            pose = composed(link.pose, pose)
        return max((link.stamp for link in chain if link.child not in self._static), default=0), pose

    def missing_transform(self) -> str:
        """Return what is missing between the frames, in words; '' if nothing is."""
        if self._chain():
            return ''
        links = ', '.join(f'{link.parent} -> {link.child}' for link in self._links.values()) or 'nothing'
        return f'there is no transform from {self._outer} to {self._inner} on /tf, which has {links}'
