"""The figures of a fit: what is drawn where. Pixels were looked at."""

import contextlib
import itertools

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure

from lgmd2jax._figures import fit as _figures_fit
from lgmd2jax._figures.fit import diagnostics_figure, fit_figure
from lgmd2jax._figures.style import BLACK, BLUE, VERMILION
from lgmd2jax.fitting import Free
from tests.fitting.fits import curve, fit_with, run

THREE = Free(theta2=None, tau1=None, T_sp=None)
FAMILIES = ("loom dark 40 ms", "loom light 40 ms", "recede", "translate", "grating")


@pytest.fixture
def figures(monkeypatch):
    """The figures that were drawn, laid out but not written."""
    made = []

    @contextlib.contextmanager
    def drawn(path, width, height):
        figure = Figure(figsize=(width, height), layout="constrained")
        yield figure
        figure.draw_without_rendering()
        made.append(figure)

    monkeypatch.setattr(_figures_fit, "drawn", drawn)
    return made


def lines(axes) -> dict:
    return {line.get_label(): line for line in axes.get_lines()}


def titled(figure, title: str):
    (axes,) = [axes for axes in figure.axes if title in axes.get_title() + axes.get_title(loc="left")]
    return axes


def two_channels(names=FAMILIES):
    return [
        it
        for i, name in enumerate(names)
        for it in (curve(name, seed=i), curve(name, "spikes", target=np.repeat([0.0, 2.0, 0.0], 10), seed=i))
    ]


# Curves


def test_every_curve_has_a_panel_with_target_soft_and_hard(figures):
    curves = two_channels()
    fit_figure("any.png", curves, "lgmd2")
    panels = figures[0].axes
    assert len(panels) == len(curves)
    shown = {tuple(lines(axes)["soft"].get_ydata()) for axes in panels}
    assert shown == {tuple(it.soft) for it in curves}
    for name in FAMILIES:
        drawn = lines(titled(figures[0], name))
        (it,) = [it for it in curves if it.condition == name and it.channel == "smp_adapted"]
        np.testing.assert_array_equal(drawn["target"].get_ydata(), it.target)
        np.testing.assert_array_equal(drawn["soft"].get_xdata(), it.time)
        np.testing.assert_array_equal(drawn["soft"].get_ydata(), it.soft)
        np.testing.assert_array_equal(drawn["hard, handed over"].get_ydata(), it.hard)


def test_target_soft_and_hard_differ_in_colour_and_in_line(figures):
    fit_figure("any.png", [curve()], "one")
    drawn = lines(figures[0].axes[0])
    looks = [
        (drawn[name].get_color(), drawn[name].get_linewidth(), drawn[name].is_dashed())
        for name in ("target", "soft", "hard, handed over")
    ]
    assert [colour for colour, *_ in looks] == [BLACK, BLUE, VERMILION]
    assert len({tuple(style) for _, *style in looks}) == 3


def test_the_target_is_drawn_where_it_counts_and_not_elsewhere(figures):
    weight = np.where(np.arange(30) < 10, 0.0, 1.0)
    fit_figure("any.png", [curve(weight=weight)], "masked")
    np.testing.assert_array_equal(np.isnan(lines(figures[0].axes[0])["target"].get_ydata()), weight == 0)


def test_values_without_neighbours_are_dots(figures):
    """A line between values of which none is next to the other would be invisible."""
    weight = np.where(np.isin(np.arange(30), [0, 7, 8, 29]), 1.0, 0.0)
    fit_figure("any.png", [curve(weight=weight)], "sparse")
    (dots,) = [line for line in figures[0].axes[0].get_lines() if line.get_marker() == "."]
    np.testing.assert_array_equal(dots.get_xdata(), 10.0 * (np.array([0, 29]) - 15))


def test_a_band_is_shaded_and_has_no_line(figures):
    """An open side reaches to the border of the panel; what does not count is not shaded."""
    low, upper = np.full(30, 0.5), np.where(np.arange(30) < 20, 0.7, np.inf)
    weight = np.where(np.arange(30) < 5, 0.0, 1.0)
    fit_figure("any.png", [curve("a", target=low, upper=upper, weight=weight), curve("b")], "banded")
    axes = titled(figures[0], "a\n")
    (shade,) = [area for area in axes.collections if area.get_label() == "target band"]
    corners = shade.get_paths()[0].vertices
    assert corners[:, 0].min() == 10.0 * (5 - 15)
    assert corners[:, 1].min() == 0.5
    assert corners[:, 1].max() == pytest.approx(axes.get_ylim()[1])
    assert 0.7 in corners[:, 1]
    assert "target" not in lines(axes)
    assert "within (soft" in axes.get_title(loc="left")
    assert "target band" not in {area.get_label() for area in titled(figures[0], "b\n").collections}
    (legend,) = figures[0].legends
    assert {"target", "target band"} <= {words.get_text() for words in legend.get_texts()}


def test_rows_are_left_out_where_no_condition_has_the_channel(figures):
    names = [f"loom {number}" for number in range(7)]
    fit_figure("any.png", [curve(name) for name in names], "one channel")
    fit_figure("any.png", [*two_channels(names[:1]), *(curve(name) for name in names[1:])], "spikes once")
    fit_figure("any.png", two_channels(names), "spikes throughout")
    one, once, throughout = (figure.get_figheight() for figure in figures)
    assert once - one == pytest.approx((throughout - one) / 2)


def test_axes_have_units_and_channels_share_their_range(figures):
    fit_figure("any.png", [curve("a", "rate"), curve("b", "rate", soft=np.full(30, 3.0)), *two_channels()], "all")
    panels = figures[0].axes
    labels = {axes.get_ylabel() for axes in panels}
    assert {"firing rate (spikes/s)", "adapted SMP", "spikes a frame"} <= labels
    assert "time (ms)" in {axes.get_xlabel() for axes in panels}
    assert titled(figures[0], "a\n").get_ylim() == titled(figures[0], "b\n").get_ylim()
    assert titled(figures[0], "b\n").get_ylim()[1] > 3
    assert titled(figures[0], "recede").get_ylim()[1] < 1.2


def test_one_legend_names_each_line_once(figures):
    sem = np.full(30, 0.02)
    fit_figure("any.png", [curve(sem=sem), curve("b", sem=sem)], "two")
    (legend,) = figures[0].legends
    names = [words.get_text() for words in legend.get_texts()]
    assert sorted(names) == sorted({"target, s.e.m.", "soft, 95 % band", "target", "soft", "hard, handed over"})


def test_a_band_without_end_does_not_flatten_the_curves(figures):
    bands = [np.full(30, 1e9), np.full(30, np.inf), np.full(30, np.nan)]
    fit_figure("any.png", [curve(str(i), band=band) for i, band in enumerate(bands)], "wide")
    assert all(axes.get_ylim()[1] < 1.2 for axes in figures[0].axes)


def test_where_soft_and_hard_differ_the_panel_says_so(figures):
    fit_figure("any.png", [curve("good"), curve("bad", hard=curve().soft + 0.3)], "gap")
    texts = [[words.get_text() for words in axes.texts] for axes in figures[0].axes]
    assert texts[0] == []
    assert texts[1] == [f"soft ≠ hard, {curve(hard=curve().soft + 0.3).gap:.0%}"]
    assert "on 2 targets: 1 good, 1 missed" in figures[0].get_suptitle()
    assert [axes.get_title(loc="left").split("\n")[1].split(":")[0] for axes in figures[0].axes] == ["good", "missed"]


def test_names_may_repeat(figures):
    fit_figure("any.png", [curve("looming", seed=seed) for seed in range(4)], "same")
    assert len(figures[0].axes) == 4
    assert len({tuple(lines(axes)["soft"].get_ydata()) for axes in figures[0].axes}) == 4


@pytest.mark.parametrize("count", [1, 6, 13])
def test_panels_stay_large_enough_to_read(figures, count):
    fit_figure("any.png", two_channels([f"condition {i} with quite a name" for i in range(count)]), "many")
    figure = figures[0]
    assert len(figure.axes) == 2 * count
    boxes = [axes.get_window_extent().transformed(figure.dpi_scale_trans.inverted()) for axes in figure.axes]
    assert min(box.width for box in boxes) > 1.6
    assert min(box.height for box in boxes) > 0.5
    whole = [axes.get_tightbbox() for axes in figure.axes]  # with titles and labels
    assert not any(one.overlaps(other) for one, other in itertools.combinations(whole, 2))


# Diagnostics


def test_the_waterfall_shows_starts_and_descents(figures):
    runs = [run(1.0, free=3), run(1.001, free=3), run(5.0, free=3)]
    diagnostics_figure("any.png", fit_with(THREE, [curve()], runs=runs, screened=[2.0, 3.0, 50.0]))
    screened, descended = titled(figures[0], "3 starts screened"), titled(figures[0], "best found 2 of 3 times")
    np.testing.assert_array_equal(screened.get_lines()[0].get_ydata(), [2, 3, 50])
    np.testing.assert_array_equal(lines(descended)["start"].get_ydata(), [20, 20, 20])
    np.testing.assert_array_equal(lines(descended)["end"].get_ydata(), [1, 1.001, 5])
    assert screened.get_yscale() == descended.get_yscale() == "log"
    assert screened.get_ylim() == descended.get_ylim()


def test_the_history_begins_anew_at_each_temperature(figures):
    runs = [run(1.0, ((9.0, 4.0), (3.0, 2.0, 1.0)), 3), run(2.0, ((8.0, 7.0, 6.0),), 3)]
    diagnostics_figure("any.png", fit_with(THREE, [curve()], runs=runs))
    (history,) = [axes for axes in figures[0].axes if axes.get_xlabel() == "step of the solver"]
    drawn = [
        (list(it.get_xdata()), list(it.get_ydata()))
        for it in history.get_lines()
        if len(it.get_ydata()) > 2 or it.get_color() == BLUE
    ]
    assert drawn == [([1, 2, 3], [8, 7, 6]), ([1, 2], [9, 4]), ([5, 6, 7], [3, 2, 1])]
    (above,) = history.child_axes
    assert [words.get_text() for words in above.get_xticklabels()] == ["0.5", "0.2"]
    assert list(above.get_xticks()) == [0, 4]


def test_correlations_stand_in_their_cells_and_what_is_undetermined_is_empty(figures):
    jacobian = np.random.default_rng(0).normal(size=(50, 3)) * [1, 0, 1]
    fit = fit_with(THREE, [curve()], jacobian=jacobian)
    diagnostics_figure("any.png", fit)
    axes = titled(figures[0], "correlation")
    shown = np.ma.filled(axes.get_images()[0].get_array(), np.nan)
    np.testing.assert_array_equal(shown, fit.uncertainty.correlation)
    cells = {tuple(words.get_position()): words.get_text() for words in axes.texts}
    assert set(cells) == {(0, 2), (2, 0)}
    assert float(cells[0, 2]) == pytest.approx(fit.uncertainty.correlation[0, 2], abs=0.051)
    assert "undetermined" in axes.get_title()


def test_the_spectrum_names_its_directions_from_stiff_to_sloppy(figures):
    jacobian = np.random.default_rng(0).normal(size=(50, 3)) * [0.1, 10, 1]
    fit = fit_with(THREE, [curve()], jacobian=jacobian)
    diagnostics_figure("any.png", fit)
    axes = titled(figures[0], "sensitivity spectrum")
    (points,) = [line for line in axes.get_lines() if line.get_marker() == "o"]
    np.testing.assert_array_equal(points.get_xdata(), fit.uncertainty.spectrum)
    names = [words.get_text() for words in axes.get_yticklabels()]
    assert names == ["stiffest: 1.0 tau1", "1.0 T_sp", "sloppiest: 1.0 theta2"]
    assert axes.get_ylim()[0] > axes.get_ylim()[1]  # the stiffest at the top


def test_the_gap_of_every_curve_is_a_bar_and_large_ones_stand_out(figures):
    curves = [curve("good", hard=curve().soft + 0.01), curve("bad", hard=curve().soft + 0.1)]
    diagnostics_figure("any.png", fit_with(THREE, curves))
    axes = titled(figures[0], "gap of soft and hard")
    np.testing.assert_allclose([bar.get_width() for bar in axes.patches], [100 * it.gap for it in curves])
    assert [bool(bar.get_hatch()) for bar in axes.patches] == [False, True]
    assert [words.get_text() for words in axes.get_yticklabels()] == ["good, adapted SMP", "bad, adapted SMP"]


def test_a_fit_that_was_stopped_early_or_is_perfect_can_be_drawn(figures):
    early = run(0.0, (), 1)
    fit = fit_with(
        Free(theta2=None),
        [curve(soft=curve().target, hard=curve().target, band=np.zeros(30))],
        jacobian=np.zeros((50, 1)),
        runs=[early],
        screened=[0.0, 0.0, np.inf],
        result="stopped by hand",
    )
    diagnostics_figure("any.png", fit)
    assert "NOT VALID" in figures[0].get_suptitle()


# Files


def test_figures_are_written_and_leave_matplotlibs_settings_alone(tmp_path):
    before = dict(mpl.rcParams)
    fit = fit_with(THREE, two_channels(FAMILIES[:2]))
    fit_figure(tmp_path / "fit.png", fit.curves, "lgmd2")
    diagnostics_figure(tmp_path / "diagnostics.png", fit)
    for name in ("fit.png", "diagnostics.png"):
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")
    assert dict(mpl.rcParams) == before


def test_the_same_fit_gives_the_same_file(tmp_path):
    for name in ("one.png", "two.png"):
        fit_figure(tmp_path / name, [curve()], "same")
    assert (tmp_path / "one.png").read_bytes() == (tmp_path / "two.png").read_bytes()
