"""What every public function says of arguments that its annotations exclude; beartype is the judge of what they do.

A new public function is tried by itself. `checked` is what makes it pass.
"""

import dataclasses
import inspect
import typing
import unittest.mock
from collections.abc import Callable, Iterator

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from beartype.door import is_bearable
from beartype.roar import BeartypeException

import lgmd2jax as lgmd
from lgmd2jax._words import is_refusal

WRONG = [None, 3.5, True, "rate!", b"rate", np.array([1, "a"], object), lgmd.LGMD2, 1j, {"rate": None}]

# Classes of what the library makes.
RESULTS = """
AlarmDescent AlarmFit AlarmRecipe AnimalFits Candidate Characterisation ClipLabels Comparison Counts Curve Drive
Encounter Evaluation FalseAlarm Finding Fit HeldOutScores LabelFile LawComparison LawFit Layers Layout LoomingEstimate
Miss Outcome PeakLine PeakTimes Population Pose Posterior Profile RandomEffects Recipe Reliability Response Run Scene
Score Share Sides Simulator Start State Sums Supplement SweepRecipe Symbol TellingStimulus Training Trip Uncertainty
Urgency Verdict YueRindLayers
"""
# What the library calls, and no user does.
INNER = """
AbstractCell AbstractDetector AbstractNetwork.at_interval AbstractNetwork.in_field AbstractNetwork.respond
AbstractNetwork.sums AbstractPixels AlarmRecipe.digest AlarmRecipe.weighing AnyTarget Background
BoundedLevenbergMarquardt Distance Free.check_used_by Free.indices Free.insert Free.of Free.penalties Free.place
Free.slopes Free.tree_unflatten Free.unpacked Free.values Hard LGMD2.at_interval Layout.free LoomingLaw.values
NoDetector ParameterSet Profile.of Recipe.further Rendering.labelled Run.of Symbol Thresholds encounter scalar sides
"""
# What these classes do, the library asks them to.
CALLED = (lgmd.stimuli.Background, lgmd.stimuli.Distance, lgmd.Thresholds, lgmd.arena.AbstractDetector)

NAMED = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)


def public():
    """Functions and classes by name, with the package where two have one name."""
    every = {}
    for package in (lgmd, lgmd.stimuli, lgmd.fitting, lgmd.alarms, lgmd.arena):
        for name in dir(package):
            value = getattr(package, name)
            own = callable(value) and value.__module__.startswith("lgmd2jax") and name not in INNER.split()
            if own and every.setdefault(name, value) is not value:
                every[f"{package.__name__}.{name}"] = value
    return every


def methods(kind):
    """What a class of its own adds, as plain functions, by name."""
    for name, member in vars(kind).items():
        function = getattr(member, "method", getattr(member, "__func__", member))  # of Equinox; of a class
        if inspect.isfunction(function) and (name == "__call__" or not name.startswith("_")):
            yield name, function


def calls() -> Iterator[tuple[str, Callable]]:
    for name, value in public().items():
        if not inspect.isclass(value):
            yield name, value
            continue
        if value.__name__ not in RESULTS.split() and dataclasses.is_dataclass(value):
            yield name, value
        if not issubclass(value, CALLED):
            yield from ((f"{name}.{method}", function) for method, function in methods(value))


CALLS = {name: call for name, call in calls() if name not in [*INNER.split(), *lgmd.stimuli.FAMILIES]}


def arguments():
    for name, call in CALLS.items():
        if name.startswith("AbstractNetwork."):
            continue  # tests/network/test_model.py has its frames, rates and states
        for argument, parameter in inspect.signature(call).parameters.items():
            if parameter.annotation not in (inspect.Parameter.empty, typing.Any) and argument != "key":
                yield name, argument


def excluded(annotation):
    """Those of the wrong values that the annotation excludes; none where it says nothing that beartype understands."""
    try:
        wrong = [value for value in WRONG if not is_bearable(value, annotation)]
        number = is_bearable(3.5, annotation) and not is_bearable("rate!", annotation)
        scalar = is_bearable(jnp.zeros(()), annotation)  # whatever JAX makes one of
        nested = is_bearable(((),), annotation) and not is_bearable((2,), annotation)  # lists, also as an array
        names = is_bearable(("rate",), annotation) and not is_bearable((3,), annotation)
    except BeartypeException:
        return []
    # Python counts True among the numbers, and text as a sequence of texts.
    wrong = [value for value in wrong if not ((scalar and isinstance(value, float)) or (nested and np.ndim(value)))]
    return [*wrong, *([True] if number else []), *(["rate!"] if names and not is_bearable("", str) else [])]


ARRAYS = [
    make(np.zeros(shape, kind))
    for shape in [(), 2, 3, (3, 3), (3, 3, 3)]
    for kind in (float, int, bool)
    for make in (np.asarray, jnp.asarray)
]


def stand_in(annotation):
    """Something that the annotation takes; it is never used."""
    annotation = getattr(annotation, "__bound__", annotation)
    for value in ((), 2, "smp", (2.0, 2.0), {}, max, *ARRAYS):
        try:
            if is_bearable(value, annotation):
                return value
        except BeartypeException:
            break
    kinds = [kind for kind in (annotation, *typing.get_args(annotation)) if inspect.isclass(kind)]
    return unittest.mock.Mock(spec=kinds[0] if kinds else None)


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(("name", "argument"), [*arguments()])
def test_what_an_annotation_excludes_is_refused_in_one_line(name, argument):
    parameters = inspect.signature(CALLS[name]).parameters
    parameter = parameters[argument]
    others = {
        other.name: stand_in(other.annotation)
        for other in parameters.values()
        if other.default is other.empty and other.kind in NAMED and other is not parameter
    }
    if "key" in others:
        others["key"] = jax.random.key(0)
    for value in excluded(parameter.annotation):
        place, before, after = argument, (), {**others, argument: value}
        if parameter.kind is parameter.VAR_POSITIONAL:
            place, before, after = rf"{argument}\[0\]", (*others.values(), value), {}
        elif parameter.kind is parameter.VAR_KEYWORD:
            place, after = "anything", {**others, "anything": value}
        with pytest.raises(ValueError, match=rf"(^|: ){place}(?!\w).* (is|holds) .*; (give|choose|write) .") as error:
            CALLS[name](*before, **after)
        assert is_refusal(error.value)
        assert "\n" not in str(error.value)


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize("name", CALLS)
def test_an_argument_that_is_not_taken_is_refused_with_the_nearest_name(name):
    call = CALLS[name]
    parameters = inspect.signature(call).parameters
    known = [argument for argument in parameters if argument not in ("self", "cls")]
    if not known or any(parameter.kind is parameter.VAR_KEYWORD for parameter in parameters.values()):
        return
    with pytest.raises(ValueError, match=rf"{name.split('.')[-1]} takes no '{known[-1]}_'; choose '{known[-1]}'"):
        call(**{f"{known[-1]}_": 1})
