"""The picture of one run: path and reference, errors and torques over time."""

from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mobile_robot_control.simulation.closed_loop import Sample

# Okabe and Ito's colours, told apart by everybody
_REFERENCE, _ROBOT, _RIGHT, _LEFT = '#999999', '#0072B2', '#D55E00', '#009E73'


def draw(samples: Sequence[Sample], title: str, file: Path) -> None:
    """
    Draw a run.

    Parameters
    ----------
    samples : sequence of Sample
        In order of time, one at least.
    title : str
        Above the picture.
    file : Path
        PNG or SVG, by its ending.

    """
    figure = Figure(figsize=(11.0, 6.5), layout='constrained')
    axes = figure.subplot_mosaic([['path', 'position'], ['path', 'heading'], ['path', 'torque']], width_ratios=[1, 1.1])
    figure.suptitle(title)
    ticks = [sample.tick for sample in samples if sample.tick.time == sample.time]
    _draw_path(axes['path'], samples)
    times = [tick.time for tick in ticks]
    position = axes['position']
    position.plot(times, [100.0 * tick.error.longitudinal for tick in ticks], color=_RIGHT, label='$e_1$, ahead')
    position.plot(times, [100.0 * tick.error.lateral for tick in ticks], color=_LEFT, label='$e_2$, to the left')
    position.set_ylabel('position error [cm]')
    axes['heading'].plot(times, [tick.error.heading for tick in ticks], color=_ROBOT, label='$e_3$')
    axes['heading'].set_ylabel('heading error [rad]')
    torque = axes['torque']
    # the effort at a stamp was held over the step before it
    begun = [sample.time for sample in samples[:-1]]
    for wheel, color, style in (('right', _RIGHT, '-'), ('left', _LEFT, '--')):
        torque.step(begun, [getattr(sample.applied, wheel) for sample in samples[1:]], where='post', color=color,
                    linestyle=style, label=f'{wheel} wheel')
    torque.set_ylabel('wheel torque [N m]')
    torque.set_xlabel('time [s]')
    for name in ('position', 'heading', 'torque'):
        axes[name].grid(alpha=0.3)
        # above the axes, where no line can be
        axes[name].legend(loc='lower right', bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False)
        axes[name].sharex(torque)
    figure.align_ylabels([position, axes['heading'], torque])
    figure.savefig(file, dpi=120)


def _draw_path(axes: Axes, samples: Sequence[Sample]) -> None:
    ticks = [sample.tick for sample in samples]
    axes.plot([tick.reference.pose.x for tick in ticks], [tick.reference.pose.y for tick in ticks],
              color=_REFERENCE, linewidth=4.0, label='reference')
    axes.plot([tick.pose.x for tick in ticks], [tick.pose.y for tick in ticks], color=_ROBOT, label='robot')
    start = ticks[0].pose
    axes.plot(start.x, start.y, 'o', color=_ROBOT, label='start')
    axes.set_aspect('equal', adjustable='datalim')
    axes.set_xlabel('x [m]')
    axes.set_ylabel('y [m]')
    axes.grid(alpha=0.3)
    axes.legend(loc='lower left', bbox_to_anchor=(0.0, 1.0), ncols=3, frameon=False)
