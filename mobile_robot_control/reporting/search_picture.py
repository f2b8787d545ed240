"""The picture of a search: best and mean by generation, and the loop before and after."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from mobile_robot_control.simulation.closed_loop import Sample
from mobile_robot_control.tuning.search import Generation

# Okabe and Ito's colours, told apart by everybody
_REFERENCE, _COLORS = '#999999', ('#D55E00', '#0072B2')


def draw_search(history: Sequence[Generation], loops: Mapping[str, Sequence[Sample]], title: str, file: Path) -> None:
    """
    Draw a search.

    Parameters
    ----------
    history : sequence of Generation
        One at least.
    loops : mapping of str to sequence of Sample
        Two runs of the same length by name: before and after.
    title : str
        Above the picture.
    file : Path
        PNG or SVG, by its ending.

    """
    figure = Figure(figsize=(11.0, 7.0), layout='constrained')
    axes = figure.subplot_mosaic([['search', 'position'], ['path', 'heading'], ['path', 'torque']],
                                 width_ratios=[1, 1.1])
    figure.suptitle(title)
    _draw_history(axes['search'], history)
    for (name, samples), color in zip(loops.items(), _COLORS, strict=True):
        ticks = [sample.tick for sample in samples if sample.tick.time == sample.time]
        times = [tick.time for tick in ticks]
        distances = [100.0 * (tick.error.longitudinal**2 + tick.error.lateral**2) ** 0.5 for tick in ticks]
        axes['position'].plot(times, distances, color=color, label=name)
        axes['heading'].plot(times, [tick.error.heading for tick in ticks], color=color)
        axes['torque'].plot([sample.time for sample in samples[:-1]],
                            [max(map(abs, sample.applied)) for sample in samples[1:]], color=color, linewidth=0.8)
        axes['path'].plot([tick.pose.x for tick in ticks], [tick.pose.y for tick in ticks], color=color)
        reference = [tick.reference.pose for tick in ticks]
    axes['path'].plot([pose.x for pose in reference], [pose.y for pose in reference], color=_REFERENCE, linewidth=4.0,
                      zorder=0, label='reference')
    axes['path'].set_aspect('equal', adjustable='datalim')
    axes['path'].set_xlabel('x [m]')
    axes['path'].set_ylabel('y [m]')
    axes['path'].legend(loc='lower left', bbox_to_anchor=(0.0, 1.0), frameon=False)
    axes['position'].set_ylabel('distance [cm]')
    axes['position'].legend(loc='lower right', bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False)
    axes['heading'].set_ylabel('heading error [rad]')
    axes['torque'].set_ylabel('larger |torque| [N m]')
    axes['torque'].set_yscale('log')
    axes['torque'].set_xlabel('time [s]')
    for name in ('position', 'heading', 'torque', 'path'):
        axes[name].grid(alpha=0.3)
    for name in ('position', 'heading'):
        axes[name].sharex(axes['torque'])
    figure.align_ylabels([axes['position'], axes['heading'], axes['torque']])
    figure.savefig(file, dpi=120)


def _draw_history(axes: Axes, history: Sequence[Generation]) -> None:
    numbers = [generation.number for generation in history]
    axes.plot(numbers, [generation.mean for generation in history], color=_REFERENCE, label='mean of the generation')
    axes.plot(numbers, [generation.best for generation in history], color=_COLORS[1], label='best so far')
    axes.set_yscale('log')
    axes.set_xlabel('generation')
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_ylabel('objective')
    axes.legend(loc='lower right', bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False)
    axes.grid(alpha=0.3, which='both')
