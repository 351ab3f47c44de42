"""Pictures of a calibration on matplotlib's axes; ``pip install touchcal[plot]`` brings what they need.

::

    import matplotlib.pyplot as plt
    from touchcal import plots

    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(15, 5), layout="constrained")
    plots.parameters(calibration, left)
    plots.residuals(calibration, middle)
    plots.workspace(calibration, right)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

import touchcal

if TYPE_CHECKING:
    import matplotlib.axes

__all__ = ["parameters", "residuals", "workspace"]

_BEFORE, _AFTER = "#9aa5b1", "#1f6feb"
"""Colours of the nominal and the calibrated arm."""


def _check_axes(ax: matplotlib.axes.Axes) -> None:
    if not hasattr(ax, "axvspan"):
        raise TypeError(f"argument 'ax': expected one matplotlib Axes, found {type(ax).__name__}")


def parameters(calibration: touchcal.Calibration, ax: matplotlib.axes.Axes, *, most: int = 40) -> None:
    """Draws each parameter over its standard deviation, with a band of two of them: what lies beyond is hardly zero.

    Parameters that the data do not determine are left out, as their values are those of their priors.

    Args:
        calibration: the result.
        ax: matplotlib axes to draw on.
        most: parameters drawn; of more, those with the largest ratios, in their order.
    """
    _check_axes(ax)
    all_ratios = {
        parameter.name: parameter.value / parameter.sigma
        for parameter in calibration.parameters
        if parameter.identifiable and parameter.sigma
    }
    largest = set(sorted(all_ratios, key=lambda name: -abs(all_ratios[name]))[:most])
    ratios = {name: ratio for name, ratio in all_ratios.items() if name in largest}
    rows = range(len(ratios))
    ax.axvspan(-2, 2, color="#eef1f4", zorder=0)
    ax.axvline(0, color="black", linewidth=0.8)
    ax.hlines(rows, 0, list(ratios.values()), color=_AFTER, linewidth=1)
    ax.plot(list(ratios.values()), rows, "o", color=_AFTER, markersize=4)
    # Names of joints and fixtures are no formulas.
    ax.set_yticks(rows, list(ratios), fontsize="small", parse_math=False)
    ax.set_ylim(len(ratios) - 0.5, -0.5)
    farthest = max(map(abs, ratios.values()), default=0)
    marks = [2, *(10**k for k in range(1, 13) if 10**k <= farthest)]
    ticks = [-mark for mark in reversed(marks)] + [0, *marks]
    ax.set_xscale("symlog", linthresh=2)
    ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks], minor=False)
    ax.set_xticks([], minor=True)
    ax.set_xlabel("estimate / standard deviation (1)")
    ax.set_title("Parameters" if len(ratios) == len(all_ratios) else f"{len(ratios)} of {len(all_ratios)} parameters")


def residuals(
    calibration: touchcal.Calibration,
    ax: matplotlib.axes.Axes,
    *,
    fixture: str | None = None,
    bins: int = 40,
) -> None:
    """Draws histograms of the distances of contacts from touching, by the nominal and by the calibrated arm.

    The axis of distances is logarithmic; distances below a ten-thousandth of the largest one are in the first bin.

    Args:
        calibration: the result.
        ax: matplotlib axes to draw on.
        fixture: name of the fixture whose contacts are drawn; default: all.
        bins: number of bins.

    Raises:
        KeyError: if there is no fixture of that name.
    """
    _check_axes(ax)
    if not isinstance(calibration, touchcal.Calibration):
        raise TypeError(f"argument 'calibration': expected a Calibration, which has its contacts, found {type(calibration).__name__}")
    if fixture is not None and fixture not in calibration.postfit.per_fixture:
        names = ", ".join(calibration.postfit.per_fixture)
        raise KeyError(f"expected the name of a fixture ({names}), found {fixture!r}")
    contacts = calibration.contacts_to_pandas()
    if fixture is not None:
        contacts = contacts[contacts["fixture"] == fixture]
    before, after = (1e3 * contacts[column].to_numpy() for column in ("before", "after"))
    largest = max(float(np.max(before, initial=0)), float(np.max(after, initial=0)), 1e-6)
    edges = np.geomspace(1e-4 * largest, largest, bins + 1)
    for distances, label, color in ((before, "before", _BEFORE), (after, "after", _AFTER)):
        rms = float(np.sqrt(np.mean(distances**2))) if len(distances) else 0.0
        shown = np.clip(distances, edges[0], edges[-1])
        ax.hist(shown, edges.tolist(), color=color, alpha=0.7, label=f"{label}: {rms:.3g} mm rms")
    ax.set_xscale("log")
    ax.set_xlabel("distance from contact (mm)")
    ax.set_ylabel("contacts")
    ax.set_title("Distances from contact" + (f", {fixture}" if fixture else ""), parse_math=False)
    ax.legend()


def workspace(calibration: touchcal.Calibration, ax: matplotlib.axes.Axes) -> None:
    """Draws the tool's expected error across the workspace, of the nominal and of the calibrated arm.

    Bars are root mean squares as `WorkspaceUncertainty` has them, on a logarithmic axis: of the position in base and of distances
    between two positions in mm, of the rotation in degrees.

    Args:
        calibration: the result.
        ax: matplotlib axes to draw on.

    Raises:
        InputError: if the uncertainty is not known, because contacts are measured by a projection.
    """
    _check_axes(ax)
    known = calibration.workspace_uncertainty
    if known is None:
        raise touchcal.InputError("the calibration has no `workspace_uncertainty`: its contacts are measured by a projection")
    names = ["position\n(mm)", "distance\n(mm)", "rotation\n(deg)"]
    before = [1e3 * known.nominal_position, 1e3 * known.nominal_distance, np.degrees(known.nominal_angle)]
    after = [1e3 * known.position, 1e3 * known.distance, np.degrees(known.angle)]
    places = np.arange(len(names))
    for values, offset, label, color in ((before, -0.2, "before", _BEFORE), (after, 0.2, "after", _AFTER)):
        bars = ax.bar(places + offset, values, 0.4, color=color, label=label)
        ax.bar_label(bars, [f"{value:.2g}" for value in values], padding=2)
    ax.set_yscale("log")
    ax.margins(y=0.15)
    ax.set_xticks(places, names)
    ax.set_ylabel("expected error, rms (mm or deg)")
    ax.set_title("Tool across the workspace")
    ax.legend()
