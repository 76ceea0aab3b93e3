"""What a fit is asked to draw: its curves, what they leave over, a profile. Each returns matplotlib axes."""

import os

import matplotlib.pyplot as plt
import numpy as np
from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lgmd2jax._channels import TARGETS
from lgmd2jax._figures.fit import curves_size, draw_curves
from lgmd2jax._figures.style import BLUE, COLOURS, GREY, STYLE, VERMILION, check_figure_path
from lgmd2jax._files.atomic import replaced
from lgmd2jax.fitting import Fit, Profile
from lgmd2jax.fitting._residuals import residuals_of

_NOISE = 1.96  # standard errors within which 95 % of the autocorrelations of white noise lie


def plot_curves(fit: Fit, path: str | os.PathLike | None) -> Axes:
    """Target, soft and hard model of every condition; the first panel, whose figure holds them all."""
    with style.context(STYLE):
        figure = new_figure(path, *curves_size(fit.curves))
        draw_curves(figure, fit.curves, "curves")
        return written(figure, path)


def plot_residuals(fit: Fit, path: str | os.PathLike | None) -> Axes:
    """The residuals of the model over time, and their autocorrelation; a colour a curve, a row a channel."""
    with style.context(STYLE):
        figure = new_figure(path, 9.0, 0.8 + 2.4 * len(fit.channels))
        rows = figure.subplots(len(fit.channels), 2, squeeze=False, width_ratios=(1.6, 1))
        for (over_time, alike), channel in zip(rows, fit.channels, strict=True):
            curves = [curve for curve in fit.curves if curve.channel == channel]
            for curve, colour in zip(curves, len(curves) * COLOURS, strict=False):
                rest = residuals_of(curve, fit.kind)
                over_time.plot(rest.time, rest.values, color=colour, label=curve.condition)
                lags = rest.interval * np.arange(len(rest.time))
                alike.plot(lags, rest.autocorrelation, color=colour)
                alike.axhspan(*(sign * _NOISE / np.sqrt(len(lags)) for sign in (-1, 1)), color=GREY, alpha=0.06)
            over_time.axhline(0, color=GREY, linewidth=0.8)
            alike.axhline(0, color=GREY, linewidth=0.8)
            described = TARGETS[channel]
            unit = f" ({described.unit})" if described.unit != "1" else ""
            if any(curve.exposure is not None for curve in curves):
                unit = " (deviance, s.e.)"
            over_time.set(xlabel="time (ms)", ylabel=f"{described.label}, residual{unit}")
            alike.set(xlabel="lag (ms)", ylabel="autocorrelation", ylim=(-1.05, 1.05))
            over_time.legend(fontsize=7)
        rows[0, 0].set_title(f"{fit.kind} model less target", loc="left")
        rows[0, 1].set_title("grey: 95 % of white noise", loc="left")
        return written(figure, path)


def plot_profile(fit: Fit, name: str, profile: Profile, path: str | os.PathLike | None, ax: Axes | None) -> Axes:
    """The rise of chi2 as one parameter is moved, beside the parabola of its standard error."""
    with style.context(STYLE):
        figure, axes = None, ax
        if axes is None:
            figure = new_figure(path, 4.6, 3.4)
            axes = figure.subplots()
        i = fit.free.names.index(name)
        value, error = fit.uncertainty.values[i], fit.uncertainty.standard_errors[i]
        axes.plot(profile.values, profile.rise, "o", color=BLUE, markersize=3.5)
        axes.plot(*_between(profile), color=BLUE, label="profile")
        if np.isfinite(error) and error > 0:
            places = np.linspace(profile.values[0], profile.values[-1], 200)
            parabola = np.square((places - value) / error)
            shown = parabola <= 1.5 * max(profile.limit, profile.rise.max())
            axes.plot(places[shown], parabola[shown], color=GREY, linestyle="--", label="standard error")
        axes.axhline(profile.limit, color=VERMILION, linewidth=0.9)
        for end, is_open in zip(profile.interval, profile.is_open, strict=True):
            if not is_open:
                axes.axvline(end, color=VERMILION, linewidth=0.9, linestyle=":")
        unit = fit.free.parameters[i].symbol.unit
        axes.set(xlabel=name if unit == "1" else f"{name} ({unit})", ylabel="rise of χ²")
        axes.legend()
        return axes if figure is None else written(figure, path)


def _between(profile: Profile) -> tuple[np.ndarray, np.ndarray]:
    """The rise also between its points, where its root, negative below the best value, is nearly a straight line."""
    best = profile.values[np.argmin(profile.rise)]
    roots = np.sign(profile.values - best) * np.sqrt(np.maximum(profile.rise, 0))
    places = np.linspace(profile.values[0], profile.values[-1], 200)
    return places, np.square(np.interp(places, profile.values, roots))


def new_figure(path: str | os.PathLike | None, width: float, height: float) -> Figure:
    """A figure of pyplot, which notebooks and windows show by themselves; one of its own where a file is all."""
    if path is None:
        return plt.figure(figsize=(width, height), layout="constrained")
    check_figure_path(path)
    return Figure(figsize=(width, height), layout="constrained")


def written(figure: Figure, path: str | os.PathLike | None) -> Axes:
    """The first panel of a figure that is complete, which is written where there is a path."""
    if path is not None:
        with replaced(path) as temporary:
            figure.savefig(temporary)
    return figure.axes[0]
