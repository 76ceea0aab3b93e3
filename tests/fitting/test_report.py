"""What a report says, that text and HTML say the same, and that its numbers are those of the fit."""

import dataclasses
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from hypothesis import given, strategies as st

import lgmd2jax as lgmd
from lgmd2jax._reports.digits import measured, rounded
from lgmd2jax._reports.section import WIDTH, Section, as_html, as_text
from lgmd2jax.fitting import Fit, Free, Linear, Profile, Supplement, Tie
from tests.fitting.fits import curve, fit_with, run

THREE = Free(theta2=None, tau1=None, T_sp=None)


def text(fit: Fit, supplement: Supplement | None = None) -> str:
    return as_text(fit.sections(supplement))


def html(fit: Fit) -> str:
    return as_html(fit.sections())


def section(report: str, title: str) -> list[str]:
    """The lines below a title."""
    (block,) = [block for block in report.split("\n\n") if block.startswith(title)]
    return block.splitlines()[1:]


def row(report: str, title: str, name: str) -> str:
    (line,) = [line for line in section(report, title) if line.split()[:1] == [name]]
    return line


class Reader(HTMLParser):
    """Collects the words of a page, and what it refers to; tags must nest."""

    def __init__(self, page: str):
        super().__init__()
        self.open, self.words, self.references, self.headers = [], [], [], []
        self.feed(page)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.references += [value for name, value in attrs if name in ("src", "href", "data", "action")]
        if tag == "th":
            self.headers.append(dict(attrs)["scope"])
        if tag not in ("img", "meta"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words += data.split()


# Numbers


@pytest.mark.parametrize(
    ("value", "error", "shown"),
    [
        (3.14159, 0.0271, "3.142 +- 0.027"),
        (3.14159, 0.0999, "3.14 +- 0.10"),
        (523.4, 12.3, "523 +- 12"),
        (12345.0, 1234.0, "12300 +- 1200"),
        (0.00123, 0.00005, "0.001230 +- 0.000050"),
        (3.04e-5, 1.2e-6, "3.04e-5 +- 0.12e-5"),
        (-2.0e7, 3e5, "-2.000e7 +- 0.030e7"),
        (0.0, 0.5, "0.00 +- 0.50"),
        (-0.001, 30.0, "0.00 +- 30.00"),
        (0.05, 3.2, "0.050 +- 3.200"),
        (3.0, 1e-12, "3 +- 1e-12"),
        (3.21, np.inf, "3.21"),
        (3.21, np.nan, "3.21"),
        (0.0, 0.0, "0"),
    ],
)
def test_a_value_has_the_digits_that_its_error_justifies(value, error, shown):
    assert measured(value, error) == shown


@given(st.floats(-1e8, 1e8), st.floats(1e-9, 1e8))
def test_what_is_shown_is_the_value_and_its_error_to_a_tenth_of_it(value, error):
    shown = measured(value, error)
    number, _, its_error = shown.partition(" +- ")
    assert float(number) == pytest.approx(value, abs=0.051 * error, rel=1e-5)
    assert float(its_error) == pytest.approx(error, rel=0.06 if error > 1e-5 * abs(value) else 0.5)
    assert len(shown) <= 30


def test_an_end_of_an_interval_keeps_its_own_digits():
    assert rounded(0.0312, 3.0, 2.6) == "0.031"
    assert rounded(41.26, 3.0, 2.6) == "41.3"


# Status


def parts(fit) -> list[str]:
    head, _, warning = text(fit).split("\n\n")[0].partition("\n  - ")
    assert warning.startswith("Not valid: ") == ("NOT VALID" in head)
    return head.removeprefix("Fit: ").replace("\n", " ").split(" | ")


def test_a_good_fit_says_so():
    good = ["valid", "converged", "errors unknown: scaled to the misfit", "targets: 1 good", "none at a bound"]
    good += ["all determined", "soft and hard agree"]
    assert parts(fit_with(THREE, [curve()])) == good
    known = fit_with(THREE, [curve()], absolute=True, misfit=0.7)
    assert parts(known) == [*good[:2], "misfit consistent with the errors", *good[3:]]


def test_a_fit_whose_misfit_no_chance_explains_is_not_valid():
    fit = fit_with(THREE, [curve()], absolute=True, misfit=1e4)
    times = np.sqrt(fit.uncertainty.reduced_chi2)
    assert parts(fit)[0] == "NOT VALID"
    assert f"misfit {times:.3g} times the errors" in parts(fit)
    assert any("not consistent with the errors" in remark for remark in fit.remarks())
    assert not any("not consistent" in remark for remark in fit_with(THREE, [curve()], absolute=True).remarks())


def test_where_errors_are_unknown_a_fit_that_misses_a_target_is_not_valid():
    flat = curve(hard=np.full(30, 0.55))
    assert parts(fit_with(THREE, [curve(), flat]))[0] == "NOT VALID"
    assert "targets: 1 good, 1 missed" in parts(fit_with(THREE, [curve(), flat]))
    believed = fit_with(THREE, [curve(), flat], absolute=True, misfit=0.7)  # its errors are so wide
    assert parts(believed)[0] == "valid"


@pytest.mark.parametrize(
    ("losses", "said"),
    [
        ((1.0, 1.001, 5.0), "the model cannot meet them within its bounds, as 2 of 3 descents agree"),
        ((1.0, 1.001, 5.0, 6.0), "a wider search may do better, as 2 of 4 descents ended here"),
        ((1.0, 3.0, 5.0), "a wider search may do better, as 1 of 3 descents ended here"),
        ((1.0,), "a wider search may do better, as 1 of 1 descents ended here"),
    ],
)
def test_that_a_target_cannot_be_met_takes_descents_that_agree(losses, said):
    missed = curve(hard=np.full(30, 0.55))
    fit = fit_with(THREE, [curve(), missed, missed], runs=[run(loss, free=3) for loss in losses])
    told = f"2 of 3 targets are missed, and {said}: loom (smp_adapted). The table says by how much."
    assert told in fit.remarks()
    chosen = dataclasses.replace(
        fit, stats={"choice": {"candidates": 9, "score": 1, "least_loss": 1, "score_of_least_loss": 0}}
    )
    assert any("missed, for the candidate was not chosen by its loss: loom" in remark for remark in chosen.remarks())


def test_the_status_says_what_is_wrong():
    apart = curve(hard=curve().soft + 0.1)
    jacobian = np.random.default_rng(0).normal(size=(50, 3)) * [1, 0, 1]
    fit = fit_with(THREE, [curve(), apart], z=[0.5, 0.5, 1.0], jacobian=jacobian, result="stopped by hand")
    assert parts(fit) == [
        "NOT VALID",
        "stopped by hand",
        "errors unknown: scaled to the misfit",
        "targets: 1 good, 1 fair",
        "at a bound: T_sp",
        "undetermined: tau1",
        "soft and hard differ in 1 of 2 curves",
    ]


def test_without_standard_errors_a_fit_is_not_valid_and_says_why():
    fit = fit_with(THREE, [curve()], jacobian=np.eye(3))
    assert fit.uncertainty.reason
    assert "NOT VALID" in parts(fit)
    assert f"no standard errors: {fit.uncertainty.reason}" in parts(fit)
    for name in fit.free.names:
        assert "unknown" in row(text(fit), "Free parameters", name)
        assert "+-" not in row(text(fit), "Free parameters", name)


# Parameters


def test_every_free_parameter_stands_with_value_error_interval_unit_start_and_bounds():
    fit = fit_with(THREE, [curve()])
    for i, parameter in enumerate(fit.free.parameters):
        line = row(text(fit), "Free parameters", parameter.name)
        (match,) = re.finditer(r"(\S+) \+- (\S+)\s+(\S+) \.\. (\S+)", line)
        value, error, low, high = match.groups()
        its_error = fit.uncertainty.standard_errors[i]
        assert float(value) == pytest.approx(fit.values[parameter.name], abs=0.06 * its_error)
        assert float(error) == pytest.approx(its_error, rel=0.06)
        np.testing.assert_allclose([float(low), float(high)], fit.uncertainty.intervals[i], atol=0.06 * its_error)
        assert f"{fit.start[parameter.name]:.4g}" in line
        assert f"{parameter.low:g} .. {parameter.high:g}" in line
    assert " ms " in row(text(fit), "Free parameters", "tau1")


def test_a_parameter_without_influence_is_undetermined_and_not_exact():
    jacobian = np.random.default_rng(0).normal(size=(50, 3)) * [1, 0, 1]
    report = text(fit_with(THREE, [curve()], jacobian=jacobian))
    line = row(report, "Free parameters", "tau1")
    assert "undetermined" in line
    assert "+-" not in line
    assert "+-" in row(report, "Free parameters", "theta2")


@pytest.mark.parametrize(("z", "flag"), [(0.0, "at lower bound"), (0.5, None), (1.0, "at upper bound")])
def test_what_lies_on_a_bound_is_flagged(z, flag):
    lines = section(text(fit_with(THREE, [curve()], z=[z, 0.5, 0.5])), "Free parameters")
    assert [line for line in lines if "bound" in line][1:] == [
        line for line in lines if line.startswith("  theta2") and flag
    ]
    assert flag is None or any(line.endswith(flag) for line in lines)


def test_priors_and_ties_are_told():
    fit = fit_with(Free(theta2=Linear(1, 6, prior=(3, 0.5)), theta1=Tie("theta2", 0.5)), [curve()])
    assert row(text(fit), "Free parameters", "theta2").endswith("prior 3 +- 0.5")
    assert row(text(fit), "Tied", "theta1").split()[1:] == ["1.75", "tied:", "theta1", "=", "0.5", "theta2"]


def test_the_observation_is_told_where_there_is_a_rate():
    free = Free(theta2=None, gain=(50, 150))
    report = text(fit_with(free, [curve(channel="rate")], observation=lgmd.Observation(baseline=4.6)))
    assert row(report, "Tied", "baseline").split()[1:] == ["4.6", "spikes/s", "fixed"]
    assert {line.split()[0] for line in section(report, "Tied")[2:]} == {"baseline", "latency", "smoothing"}
    assert "baseline" not in text(fit_with(THREE, [curve()]))


# Curves, statistics, search


def test_curves_have_their_channel_r2_rmse_and_gap():
    weight = np.where(np.arange(30) < 10, 0.0, 1.0)
    shown = curve(channel="rate", weight=weight, hard=curve().target + 0.1)
    counted = shown.target[10:]
    line = row(text(fit_with(THREE, [shown])), "Curves", "loom").split()
    assert line[1] == "rate"
    assert float(line[2]) == pytest.approx(
        1 - np.mean((shown.soft - shown.target)[10:] ** 2) / np.var(counted), abs=6e-4
    )
    assert float(line[3]) == pytest.approx(1 - 0.01 / np.var(counted), abs=6e-4)
    assert float(line[5]) == pytest.approx(0.1)
    assert float(line[6]) == pytest.approx(shown.rmse("silence"), rel=6e-3)
    assert line[7] == "spikes/s"
    assert line[9] == shown.grade
    gap = np.sqrt(np.mean((shown.soft - shown.hard)[10:] ** 2)) / np.ptp(counted)
    assert float(line[8].rstrip("%")) == pytest.approx(100 * gap, abs=0.06)


def test_a_flat_target_has_no_r2():
    flat = curve(target=np.full(30, 0.5))
    assert row(text(fit_with(THREE, [flat])), "Curves", "loom").split()[2:4] == ["flat", "flat"]


def test_statistics_count_what_has_weight_and_independent_samples():
    weight = np.where(np.arange(30) < 10, 0.0, 2.0)
    fit = fit_with(THREE, [curve(), curve("recede", weight=weight)])
    lines = "\n".join(section(text(fit), "Goodness"))
    u = fit.uncertainty
    for name, value in {
        "data points": 50,
        "independent samples": 25,
        "free parameters": 3,
        "chi2": u.chi2,
        "reduced chi2": u.reduced_chi2,
        "AIC": u.aic,
        "BIC": u.bic,
    }.items():
        (match,) = re.finditer(rf"(?<!reduced ){name} +(\S+)", lines)
        assert float(match.group(1)) == pytest.approx(value, rel=1e-3), name


def test_the_search_is_counted():
    runs = [run(1.0, free=3), run(1.001, free=3), run(5.0, free=3)]
    report = " ".join(
        "\n".join(
            section(text(fit_with(THREE, [curve()], runs=runs, screened=np.arange(1.0, 65.0).tolist())), "Search")
        ).split()
    )
    assert "64 starts screened, 3 descended; the best was found 2 of 3 times." in report
    assert "15 steps of the solver, at temperatures 0.5, 0.2." in report


def test_the_count_of_the_best_has_an_old_name():
    fit = fit_with(THREE, [curve()], runs=[run(1.0, free=3), run(1.001, free=3), run(5.0, free=3)])
    with pytest.warns(DeprecationWarning, match=r"Fit.found is now Fit.best_count"):
        assert fit.found == fit.best_count == 2


def test_correlations_are_those_above_one_half_largest_first():
    free = Free(**dict.fromkeys(["theta2", "tau1", "T_sp", "k", "tau3", "w_bias"]))
    jacobian = np.random.default_rng(0).normal(size=(50, 6))
    for i, mixed in enumerate((2.0, 1.0, 0.8)):  # three pairs that trade off
        jacobian[:, 2 * i] += mixed * jacobian[:, 2 * i + 1]
    fit = fit_with(free, [curve()], jacobian=jacobian)
    matrix = np.abs(fit.uncertainty.correlation[np.triu_indices(6, 1)])
    rows = [line.split() for line in section(text(fit), "Correlations")[2:]]
    shown = [float(value) for *_, value in (cells for cells in rows if cells[0] != "-")]
    expected = np.sort(matrix[matrix > 0.5])[::-1]
    assert len(expected) >= 3
    np.testing.assert_allclose(np.abs(shown), expected[:10], atol=6e-4)
    (i, j) = (free.names.index(name) for name in rows[0][:2])
    assert fit.uncertainty.correlation[i, j] == pytest.approx(shown[0], abs=6e-4)


def test_at_most_ten_correlations_are_shown_and_the_rest_is_counted():
    names = ["theta2", "tau1", "T_sp", "k", "tau3", "w_bias", "tau2"]
    fit = fit_with(Free(**dict.fromkeys(names)), [curve()])
    fit.uncertainty.correlation[:] = 0.9
    lines = section(text(fit), "Correlations")
    assert len(lines) == 2 + 10 + 1
    assert lines[-1] == "  - 11 more are above 0.5."


def test_uncorrelated_parameters_have_no_such_section():
    fit = fit_with(THREE, [curve()], jacobian=np.eye(40, 3) * 5)
    assert "Correlations" not in text(fit)


# What a recipe adds


def test_profiles_predictions_and_truth_are_told_where_they_are_given():
    fit = fit_with(THREE, [curve()])
    points = np.array([1.0, 2.0])
    supplement = Supplement(
        profiles={"theta2": Profile(points, points, (2.8123, 6.0), (False, True), 3.84)},
        left_out={"loom": 0.9123, "flat": np.nan},
        truth={"theta2": 3.0},
    )
    report = text(fit, supplement)
    assert row(report, "Profile", "theta2").split()[1:4] == ["2.81", "..", "open"]
    assert "Open:" in report
    assert row(report, "Each condition", "loom").split() == ["loom", "0.912"]
    assert row(report, "Each condition", "flat").split() == ["flat", "flat"]
    *_, of_range, in_errors = row(report, "Known truth", "theta2").split()
    assert float(of_range.rstrip("%")) == pytest.approx(100 * (3.5 - 3.0) / 5)
    assert float(in_errors) == pytest.approx(0.5 / fit.uncertainty.standard_errors[0], abs=0.006)
    for title in ("Profile", "Each condition", "Known truth"):
        assert title not in text(fit)


def test_remarks_stand_at_the_end_a_point_each():
    fit = fit_with(THREE, [curve(hard=curve().soft + 0.1)])
    lines = section(text(fit), "Remarks")
    assert " ".join(line.strip() for line in lines) == " ".join(f"- {sentence}" for sentence in fit.remarks())
    assert text(fit).endswith(lines[-1])


# Layout


@pytest.mark.parametrize("name", ["approach " * 20, "a" * 150, "loom"])
def test_no_line_is_too_wide_and_no_word_is_lost(name):
    everything = Free(**dict.fromkeys(lgmd.symbols()))
    fit = fit_with(everything, [curve(name.strip()), curve(name.strip(), "spikes")], z=[1.0] * len(everything))
    report = text(fit)
    assert max(map(len, report.splitlines())) <= WIDTH
    assert report.replace(" ", "").count("a") >= 2 * name.count("a")


def test_cells_that_do_not_fit_are_wrapped():
    report = as_text([Section("Title", ("words", "number|"), (("some words " * 20, "1.5"), ("few", "22")))])
    lines = report.splitlines()
    assert " ".join(line[2:].rsplit("  ", 1)[0].strip() for line in lines[3:-1]).split() == ["some", "words"] * 20
    assert lines[3].endswith("   1.5")
    assert lines[-1].startswith("  few ")
    assert lines[-1].endswith("    22")


def test_html_says_what_the_text_says():
    fit = fit_with(Free(theta2=None, gain=None, theta1=Tie("theta2")), [curve(channel="rate"), curve("recede")])
    page = Reader(html(fit))
    plain = [word for word in text(fit).split() if word != "-" and set(word) != {"-"}]
    typeset = {"+-": "±", "..": "…", "R2": "R²", "chi2": "χ²"}
    assert page.words == [typeset.get(word, word) for word in plain]
    assert set(page.headers) == {"row", "col"}
    assert page.references == []


def test_html_escapes_names_and_brings_no_colour():
    page = html(fit_with(THREE, [curve("<script>alert(1)</script> & co")]))
    assert "<script>" not in page
    assert "&lt;script&gt;alert(1)&lt;/script&gt; &amp; co" in page
    assert not re.search(r"#[0-9a-f]{3,6}\b|background|rgb|color:", page)
    assert as_html([]) == ""


def test_a_fit_shows_itself():
    fit = fit_with(THREE, [curve()])
    assert repr(fit) == fit.summary() == text(fit)
    assert fit._repr_html_() == html(fit)
    assert fit.summary(Supplement(left_out={"loom": 0.5})) == text(fit, Supplement(left_out={"loom": 0.5}))
