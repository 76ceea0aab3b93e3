"""Fits of alarms: a known network's verdicts are found again, the margin is what it says, and descents widen it."""

import dataclasses
import io

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tqdm import tqdm

import lgmd2jax as lgmd
from lgmd2jax.alarms import LabelledClip, Rendering, evaluate, fit
from lgmd2jax.alarms._cell_search import peaks_of, sums_at
from lgmd2jax.alarms._problem import problem_of

EYE = lgmd.Eye.from_field_of_view(18, 24, 70.0, 30.0, "pinhole")
TRUTH = lgmd.LGMD2(lgmd.preset("lgmd2", T_s=6.0, T_ffi=20.0, k=0.6, tau3=300.0, T_sp=0.66, N_sp=4.0), eye=EYE)
START = lgmd.LGMD2(lgmd.preset("lgmd2", N_sp=4.0, k=1.9, T_sp=0.9), eye=EYE)
FREE = lgmd.Free(T_s=lgmd.Log(2, 30), k=lgmd.Log(0.45, 2), T_ffi=(5, 60), tau3=lgmd.Log(100, 1000), T_sp=(0.51, 0.95))
SETTINGS = {
    "key": jax.random.key(0),
    "pixel_points": 4,
    "cell_points": 128,
    "generations": 1,
    "descend": 1,
    "max_steps": 4,
}


def twins_of(clips):
    """Clips whose labels are the alarms of the true network, with a frame between that is not judged."""
    twins = []
    for clip, trace in zip(clips, evaluate(TRUTH, clips).evidence, strict=True):
        on = trace >= float(TRUTH.parameters.T_sp)
        windows = np.flatnonzero(on)
        if len(windows):
            first, last = int(windows[0]), int(windows[-1])
            silent = [pair for pair in ((10, first - 2), (last + 2, len(on) - 1)) if pair[0] <= pair[1]]
            twins.append(LabelledClip.of(clip.name, clip.frames, 30, windows=[(first, last)], silent=silent))
        else:
            twins.append(LabelledClip.of(clip.name, clip.frames, 30, silent=[(10, len(on) - 1)]))
    return twins


@pytest.fixture(scope="module")
def clips():
    return twins_of(tuple(Rendering(8, seed=5).clips(EYE)))


@pytest.fixture(scope="module")
def fitted(clips):
    return fit(START, clips, FREE, **SETTINGS)


def test_verdicts_of_a_known_network_are_found_again(clips, fitted):
    assert sum(bool(clip.windows) for clip in clips) >= 3
    assert not all(verdict.right for verdict in evaluate(START, clips).verdicts())  # the start knows nothing of them
    assert fitted.cost == 0
    assert all(verdict.right for verdict in fitted.evaluation.verdicts())
    assert 0 < fitted.right < fitted.screened == 4 * 128


def test_the_old_name_of_an_evaluation(fitted):
    with pytest.warns(DeprecationWarning, match=r"^AlarmFit.watch is now AlarmFit.evaluation;"):
        assert fitted.watch is fitted.evaluation


def test_the_margin_is_how_far_T_sp_may_move(clips, fitted):
    T_sp = float(fitted.model.parameters.T_sp)
    for share, all_right in ((0.99, True), (1.01, False)):
        moved = [evaluate(with_T_sp(fitted.model, T_sp + sign * share * fitted.margin), clips) for sign in (-1, 1)]
        assert all(all(verdict.right for verdict in each.verdicts()) for each in moved) == all_right


def with_T_sp(model, T_sp):
    return dataclasses.replace(model, parameters=dataclasses.replace(model.parameters, T_sp=T_sp))


def test_descents_and_generations_never_narrow_the_margin_and_widen_that_of_a_poor_search(clips, fitted):
    (descended,) = fitted.descended
    assert fitted.margin == descended.after >= descended.before
    (alone,) = fit(START, clips, FREE, **{**SETTINGS, "generations": 0}).descended
    assert descended.before >= alone.before
    (poor,) = fit(START, clips, FREE, **{**SETTINGS, "generations": 0, "cell_points": 4}).descended
    assert poor.after > poor.before


def test_looks_ever_closer_find_more_than_as_many_anywhere(clips, fitted):
    """Both try 512 cells at each of the same four points."""
    alone = {**SETTINGS, "generations": 0, "descend": 0}
    closer = fit(START, clips, FREE, **alone)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("lgmd2jax.alarms._starts._CLOSER", 0)
        anywhere = fit(START, clips, FREE, **{**alone, "cell_points": 512})
    assert anywhere.screened == 4 * closer.screened
    assert closer.margin > anywhere.margin


def test_what_is_left_out_is_judged_by_the_best_of_the_others(clips, fitted):
    assert list(fitted.left_out) == [clip.name for clip in clips]
    assert set(fitted.left_out.values()) <= {0, 1, 2}
    assert sum(wrong == 0 for wrong in fitted.left_out.values()) >= len(clips) / 2


def test_a_choice_without_a_clip_does_not_change_with_its_labels(clips):
    """Neither the points that were looked at nor the cells around them come from what the clip asks for."""
    number = next(i for i, clip in enumerate(clips) if clip.windows)
    clip = clips[number]
    (first, last), *_ = clip.windows
    other = LabelledClip.of(clip.name, clip.frames, 30, windows=[(12, 14)], silent=[(first, last)])
    settings = {**SETTINGS, "pixel_points": 2, "cell_points": 32, "descend": 0, "generations": 2}
    chosen = []
    for labelled in (clips, [*clips[:number], other, *clips[number + 1 :]]):
        memory = {}
        fit(START, labelled, FREE, **settings, memory=memory)
        chosen.append({i: memory[f"leaving out {i}"]["best"]["z"] for i in range(len(clips))})
    assert chosen[0][number] == chosen[1][number]
    assert chosen[0] != chosen[1]  # the others saw it


def test_clips_of_a_source_are_left_out_together_and_rendered_ones_never(clips):
    settings = {**SETTINGS, "pixel_points": 1, "cell_points": 16, "descend": 0, "generations": 0}
    sources = ["a", "b", "a", None, *[None] * (len(clips) - 4)]
    labelled = [dataclasses.replace(clip, source=source) for clip, source in zip(clips, sources, strict=True)]
    memory = {}
    result = fit(START, labelled, FREE, **settings, memory=memory)
    assert list(result.without) == ["a", "b"]
    assert set(result.left_out) == {clip.name for clip in clips[:3]}
    without = result.without["a"]
    assert [clip.name for clip in without.clips] == [clip.name for clip in clips]
    # What is chosen without a does not change with what the labels of its clips are.
    swapped = [
        dataclasses.replace(clip, windows=clip.silent, silent=clip.windows) if clip.source == "a" else clip
        for clip in labelled
    ]
    again = fit(START, swapped, FREE, **settings)
    for trace, other in zip(without.evidence, again.without["a"].evidence, strict=True):
        np.testing.assert_array_equal(trace, other)


def test_one_bar_counts_all_tasks(clips, monkeypatch):
    bars = []

    class Bar(tqdm):
        def __init__(self, *given, **settings):
            super().__init__(*given, **settings, file=io.StringIO())
            bars.append(self)

        def reset(self, total=None):
            raise AssertionError("the bar began anew")

    monkeypatch.setattr("lgmd2jax._compute.tasks.tqdm", Bar)
    fit(START, clips, FREE, **{**SETTINGS, "pixel_points": 2, "cell_points": 16, "max_steps": 1}, progress=True)
    (bar,) = bars
    assert bar.n == bar.total == 2 + 1 + 1 + len(clips)


def test_ranges_hold_the_sets_that_are_right(fitted):
    for name, (low, high) in fitted.ranges.items():
        parameter = fitted.free.parameters[fitted.free.names.index(name)]
        assert parameter.low - 1e-9 <= low <= high <= parameter.high * (1 + 1e-9)
    assert set(fitted.ranges) == set(FREE.names) - {"T_sp"}


def test_the_same_key_gives_the_same_fit_and_memory_goes_on(clips, fitted):
    memory = {}
    again = fit(START, clips, FREE, **SETTINGS, memory=memory)
    assert again.z.tolist() == fitted.z.tolist()
    assert {task.split()[0] for task in memory} == {"digest", "screening", "generation", "descending", "leaving"}
    assert fit(START, clips, FREE, **SETTINGS, memory=memory).z.tolist() == fitted.z.tolist()


def test_the_search_sees_what_the_network_does(clips):
    problem = problem_of(TRUTH, FREE, clips, 1.0, 1.0)
    z = FREE.place(TRUTH.parameters, lgmd.Observation())
    (peaks,) = np.asarray(peaks_of(problem, z, sums_at(problem, z), z[None, list(problem.cell_entries)]))
    traces = evaluate(TRUTH, clips).evidence
    for event, peak in zip(problem.events, peaks, strict=True):
        clip = clips[event.clip]
        inside = clip.in_windows().any(axis=0) if event.wanted else clip.in_silence()
        assert peak == pytest.approx(traces[event.clip][inside].max(), abs=1e-6)


def test_the_descents_slope_is_that_of_finite_differences(clips):
    """Central ones, or of one side: where two frames change places in the order of their potentials, slopes differ."""
    problem = problem_of(TRUTH, FREE, clips, 2.0, 1.0)
    z, temperature = jnp.asarray(FREE.place(TRUTH.parameters, lgmd.Observation())), jnp.asarray(0.5)
    slope = jax.jit(lambda z, along: jax.jvp(lambda z: problem.residuals(z, temperature), (z,), (along,)))
    steep = 0
    for i in range(len(z)):
        along = jnp.zeros(len(z)).at[i].set(1.0)
        here, exact = (np.asarray(array) for array in slope(z, along))
        above, below = (np.asarray(slope(z + step * along, along)[0]) for step in (1e-4, -1e-4))
        differences = np.stack([(above - below) / 2, above - here, here - below]) / 1e-4
        np.testing.assert_allclose(np.abs(differences - exact).min(axis=0), 0, atol=2e-3)
        steep += bool(np.abs(exact).max() > 1e-3)
    assert steep >= 4  # a gate that is far away has no slope


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"clips": []}, "clips is empty"),
        ({"clips": "silent"}, "no clip has a window, in which an alarm is wanted"),
        ({"pixel_points": 0}, "pixel_points is 0; give a whole number"),
        ({"descend": -1}, "descend is -1; give a whole number, 0 or more"),
        ({"miss": -1.0}, "miss is -1.0; give a positive weight"),
        ({"recorded": 0}, "recorded is 0; give a positive weight"),
        ({"model": lgmd.LGMD2(lgmd.preset("lgmd2", N_sp=4.5), eye=EYE)}, "N_sp is 4.5; an alarm counts spikes"),
        ({"free": lgmd.Free(k=(2.0, 3.0))}, "k starts at 1.9, outside of its bounds"),
    ],
)
def test_misuse(clips, changes, message):
    if changes.get("clips") == "silent":
        changes = {"clips": [LabelledClip.of("s", clips[0].frames, 30, silent=[(10, 20)])]}
    arguments = {"model": START, "clips": clips, "free": FREE, **SETTINGS, **changes}
    with pytest.raises(ValueError, match=message):
        fit(**arguments)
