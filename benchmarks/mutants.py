"""Whether the tests notice a wrong line: each mutant changes one, and a test that is named must then fail.

python -m benchmarks.mutants          all of them
python -m benchmarks.mutants 2 7      these alone

A mutant is made in a temporary copy; the tree stays as it is.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
_COPIED = ("lgmd2jax", "tests", "stimuli", "fits", "benchmarks")
_NETWORK, _FITTING = "lgmd2jax/_network", "lgmd2jax/fitting"
_LOOPS = "tests/network/test_network.py::test_agrees_with_loops_over_pixels"


class Mutant(NamedTuple):
    """A wrong line, in place of a right one that the file holds once, and the test that must fail."""

    file: str
    right: str
    wrong: str
    test: str


MUTANTS = (
    # Those that no test noticed once.
    Mutant(
        f"{_FITTING}/_uncertainty/profile.py",
        "stats.f.ppf(confidence, 1, u.degrees_of_freedom)",
        "stats.chi2.ppf(confidence, 1)",
        "tests/fitting/test_profile.py::test_of_linear_curves_the_interval_is_that_of_the_covariance",
    ),
    Mutant(
        f"{_FITTING}/_problem.py",
        "multiply(jnp.sqrt(variance))",
        "multiply(variance)",
        "tests/fitting/test_problem.py::test_a_prior_keeps_its_width_when_chi2_is_divided_by_the_variance",
    ),
    Mutant(
        f"{_FITTING}/_problem.py",
        "scale / np.sqrt(thinning",
        "scale * np.sqrt(thinning",
        "tests/fitting/test_problem.py::test_the_error_of_a_frame_counts_its_neighbours",
    ),
    Mutant(
        f"{_FITTING}/_uncertainty/linearity.py",
        "_FACTOR = 1.5",
        "_FACTOR = 4",
        "tests/fitting/test_linearity.py::test_a_known_nonlinearity_is_named_where_chi2_rises_by_half_more",
    ),
    Mutant(
        f"{_FITTING}/_solver/gain_ratio.py",
        " & (damping > _DAMPED * curvature)",
        "",
        "tests/fitting/test_gain_ratio.py::test_a_whole_step_does_not_grow_however_good",
    ),
    Mutant(
        f"{_FITTING}/_solver/levenberg_marquardt.py",
        "return jnp.where(diff >= upper - y, upper, jnp.where(diff <= lower - y, lower, moved))",
        "return moved",
        "tests/fitting/test_bounded.py::test_a_step_onto_a_bound_ends_on_it_exactly",
    ),
    Mutant(
        "lgmd2jax/_characterise/properties.py",
        '"(A-R)/(A+R) of integrals", 0.75,',
        '"(A-R)/(A+R) of integrals", 0.5,',
        "tests/characterise/test_bounds.py::test_a_row_holds_just_inside_of_each_bound_and_not_outside",
    ),
    Mutant(
        f"{_NETWORK}/abstract.py",
        "abs(fps / self.eye.fps - 1) > 0.01",
        "abs(fps / self.eye.fps - 1) > 0.1",
        "tests/network/test_model.py::test_another_frame_rate_is_warned_of_from_a_hundredth_on",
    ),
    # The network.
    Mutant(f"{_NETWORK}/medulla.py", "nearest / 4 + diagonal / 8", "nearest / 4 + diagonal / 4", _LOOPS),
    Mutant(f"{_NETWORK}/medulla.py", "spread_off - w_bias * off", "off - w_bias * spread_off", _LOOPS),
    Mutant(f"{_NETWORK}/medulla.py", "theta3 * s_on * s_off", "theta3 * s_on * s_on", _LOOPS),
    Mutant(
        f"{_NETWORK}/thresholds.py",
        "(u > T_sp + sigma_sp)",
        "(u >= T_sp + sigma_sp)",
        "tests/network/test_thresholds.py::test_ties",
    ),
    Mutant(
        f"{_NETWORK}/lobula.py",
        "m * (jnp.log(threshold) - jnp.log(ffi + _LEAST))",
        "(jnp.log(threshold) - jnp.log(ffi + _LEAST))",
        "tests/network/test_mechanisms.py::test_a_steep_shunt_is_the_gate",
    ),
    Mutant(
        "lgmd2jax/hard.py",
        'sum(window) >= v["N_sp"]',
        'sum(window) > v["N_sp"]',
        "tests/network/test_network.py::test_numpy_model_agrees_with_loops_over_pixels",
    ),
    # The solver.
    Mutant(
        f"{_FITTING}/_solver/gain_ratio.py",
        "jnp.where(accept, 2, 2 * state.shrink)",
        "jnp.where(accept, 2, 2)",
        "tests/fitting/test_gain_ratio.py::test_successive_rejections_shrink_ever_faster",
    ),
    Mutant(
        f"{_FITTING}/_solver/levenberg_marquardt.py",
        "jnp.where(finite, r, jnp.nan)",
        "jnp.where(finite, r, r)",
        "tests/fitting/test_bounded.py::test_a_jacobian_that_is_not_finite_is_rejected",
    ),
    Mutant(
        f"{_FITTING}/_solver/box_descent.py",
        "held = (low == high) | ((low == 0) & (gradient > 0)) | ((high == 0) & (gradient < 0))",
        "held = low == high",
        "tests/fitting/test_bounded.py::test_many_active_bounds_end_where_no_feasible_step_leads_down",
    ),
    Mutant(
        f"{_FITTING}/_search/search.py",
        "_ATOL * min(1.0, space.scale)",
        "_ATOL",
        "tests/fitting/test_fit.py::test_small_weights_do_not_end_a_descent_early",
    ),
    # Statistics.
    Mutant(
        f"{_FITTING}/_uncertainty/covariance.py",
        "norm if absolute else",
        "norm if not absolute else",
        "tests/fitting/test_uncertainty.py::test_intervals_cover_the_truth_as_often_as_they_say",
    ),
    Mutant(
        f"{_FITTING}/_uncertainty/covariance.py",
        "max(count - priors, 0)",
        "count",
        "tests/fitting/test_uncertainty.py::test_a_prior_is_data_with_an_error_of_its_own",
    ),
    Mutant(
        "lgmd2jax/_targets/spike_trains.py",
        "np.sqrt(np.maximum(drawn, poisson))",
        "np.sqrt(drawn)",
        "tests/targets/test_spike_trains.py::test_few_animals_leave_no_frame_with_all_the_weight",
    ),
    Mutant(
        f"{_FITTING}/_curve.py",
        "if miss > _HALF * silence:",
        "if miss > silence:",
        "tests/fitting/test_curve.py",
    ),
    Mutant(
        f"{_FITTING}/_report.py",
        "u.chi2, degrees) >= _CHANCE",
        "u.chi2, degrees) >= 0",
        "tests/fitting/test_report.py::test_a_fit_whose_misfit_no_chance_explains_is_not_valid",
    ),
)


def outcome(mutant: Mutant) -> str:
    """`"dies"` where the test fails, else `"LIVES"`, or what kept the test from running.

    **Raises:** `ValueError` where the file does not hold the right line once.
    """
    with tempfile.TemporaryDirectory() as place:
        copy = Path(place)
        for name in _COPIED:
            shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copy(ROOT / "pyproject.toml", copy)
        path = copy / mutant.file
        source = path.read_text(encoding="utf-8")
        if source.count(mutant.right) != 1:
            raise ValueError(f"{mutant.file} holds {mutant.right!r} {source.count(mutant.right)} times; name one line")
        path.write_text(source.replace(mutant.right, mutant.wrong), encoding="utf-8")
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", mutant.test]
        environment = {**os.environ, "PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}
        done = subprocess.run(command, cwd=copy, env=environment, capture_output=True, text=True, check=False)
    if done.returncode == 1 and "failed" in done.stdout:
        return "dies"
    return "LIVES" if done.returncode == 0 else f"no test ran: {(done.stdout + done.stderr).strip()[-300:]}"


def main(arguments: Sequence[str] | None = None) -> int:
    """Print a line for each mutant. The status is 1 where one lives."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("numbers", nargs="*", type=int, help="which mutants, from 1 on; by default all")
    numbers = parser.parse_args(arguments).numbers or range(1, len(MUTANTS) + 1)
    dead = 0
    for number in numbers:
        mutant, start = MUTANTS[number - 1], time.monotonic()
        result = outcome(mutant)
        dead += result == "dies"
        change = f"{mutant.right[:48]!r} -> {mutant.wrong[:48]!r}"
        print(f"{number:3} {result:5} {time.monotonic() - start:4.0f} s  {mutant.file}: {change}", flush=True)
    print(f"{dead} of {len(numbers)} mutants die")
    return int(dead < len(numbers))


if __name__ == "__main__":
    sys.exit(main())
