"""Protocols: what a TOML file says is what is rendered, and what it gets wrong is said in one line."""

import itertools
import textwrap

import imageio.v3 as iio
import jax
import numpy as np
import pytest

from lgmd2jax import stimuli
from lgmd2jax._eye import Eye
from lgmd2jax._protocol.condition import Condition
from lgmd2jax._protocol.protocol import load_protocol

EYE = Eye(rows=12, cols=16, degrees_per_pixel=6.0, fps=50.0)


@pytest.fixture
def load(tmp_path):
    """Load a protocol from text, below a small eye."""

    def load(text, eye="[eye]\nrows = 12\ncols = 16\ndegrees_per_pixel = 6\nfps = 50\n"):
        (tmp_path / "trial.toml").write_text(eye + textwrap.dedent(text), encoding="utf-8")
        return load_protocol(tmp_path / "trial.toml")

    return load


def test_a_condition_is_what_the_file_says(load):
    protocol = load("""
        [[condition]]
        name = "dark"
        family = "looming"
        l_over_v = 40
        contrast = -0.9
    """)
    assert protocol.name == "trial"
    assert protocol.conditions == (Condition("dark", EYE, "looming", {"l_over_v": 40, "contrast": -0.9}),)


def test_lists_expand_to_their_product_in_the_order_written(load):
    protocol = load("""
        [[condition]]
        name = "{contrast} {l_over_v} {eye[fps]} {background[image]}"
        family = "looming"
        contrast = [-0.5, 0.1]
        l_over_v = [40.0, 20, 12.5]
        eye = { fps = [50, 100] }
        background = { kind = "photograph", image = ["brick", "gravel"] }
    """)
    grid = itertools.product(["-0.5", "0.1"], ["40", "20", "12.5"], ["50", "100"], ["brick", "gravel"])
    assert [condition.name for condition in protocol.conditions] == [" ".join(point) for point in grid]
    last = protocol.conditions[-1]
    assert (last.parameters["contrast"], last.parameters["l_over_v"], last.eye.fps) == (0.1, 12.5, 100)
    np.testing.assert_array_equal(last.parameters["background"].image, stimuli.Photograph("gravel").image)


def test_families_are_an_axis_too(load):
    protocol = load("""
        [[condition]]
        name = "{family}"
        family = ["looming", "receding"]
        l_over_v = 40
    """)
    assert [condition.family for condition in protocol.conditions] == ["looming", "receding"]


def test_a_vector_is_a_list_within_a_list(load):
    (condition,) = load("""
        [[condition]]
        name = "any course"
        family = "looming"
        distance = { kind = "tabulated", time_ms = [[-500, 0]], distance = [[50, 1]] }
    """).conditions
    np.testing.assert_array_equal(condition.parameters["distance"].time_ms, [-500.0, 0.0])
    np.testing.assert_array_equal(condition.parameters["distance"].distance, [50.0, 1.0])


@pytest.mark.parametrize(
    ("table", "eye"),
    [
        ("[eye]\npreset = 'locust'", Eye.preset("locust")),
        ("[eye]\npreset = 'paper'", Eye.preset("paper")),
        ("[eye]\npreset = 'locust'\nfps = 200", Eye(48, 64, 2.0, 200.0)),
        ("[eye]\nrows=9\ncols=8\ndegrees_per_pixel=1\nfps=30\nprojection='pinhole'", Eye(9, 8, 1.0, 30.0, "pinhole")),
    ],
)
def test_eyes(load, table, eye):
    protocol = load("\n[[condition]]\nname = 'a'\nfamily = 'looming'\n", eye=table)
    assert protocol.conditions[0].eye == eye


def test_a_condition_may_see_with_another_eye(load):
    conditions = load("""
        [[condition]]
        name = "at the common rate"
        family = "looming"
        [[condition]]
        name = "faster"
        family = "looming"
        eye.fps = 200
    """).conditions
    assert [condition.eye for condition in conditions] == [EYE, Eye(12, 16, 6.0, 200.0)]


def test_targets_are_read_with_names_filled_beside_the_protocol(load, tmp_path):
    (tmp_path / "targets").mkdir()
    rows = "".join(f"{t},{1 + t / 400},{4 + t / 200}\n" for t in range(-400, 1, 10))
    (tmp_path / "targets" / "psth.csv").write_text("t,rate_lv3.75_mean,rate_lv15_mean\n" + rows)
    first, second = load("""
        [[condition]]
        name = "{l_over_v}"
        family = "looming"
        l_over_v = [3.75, 15]
        contrast = -0.9
        start_ms = -400
        end_ms = 100
        [[condition.target]]
        channel = "rate"
        file = "targets/psth.csv"
        column = "rate_lv{l_over_v}_mean"
        interpolate = true
        [[condition.target]]
        law = "rest"
        channel = "smp"
    """).conditions
    for condition, values in ((first, [0, 1]), (second, [2, 4])):
        stimulus = condition.render()
        rate, rest = (target.on(stimulus) for target in condition.targets)
        time = np.asarray(stimulus.time)
        np.testing.assert_allclose(rate.values, np.interp(time, [-400, 0], values))
        np.testing.assert_array_equal(rate.scale, time <= 0)
        assert rest.channel == "smp"
        np.testing.assert_array_equal(rest.values, 0.5)


def test_images_are_found_beside_the_protocol(load, tmp_path):
    iio.imwrite(tmp_path / "lawn.png", np.arange(64, dtype=np.uint8).reshape(8, 8))
    (condition,) = load("""
        [[condition]]
        name = "a"
        family = "looming"
        background = { kind = "photograph", image = "lawn.png" }
    """).conditions
    np.testing.assert_allclose(condition.parameters["background"].image, np.arange(64).reshape(8, 8))


def test_rendering_is_the_family_under_the_name_of_the_condition(load):
    (condition,) = load("""
        [[condition]]
        name = "mine"
        family = "looming"
        l_over_v = 40
        contrast = -0.9
        start_ms = -300
        end_ms = 0
    """).conditions
    stimulus = condition.render()
    direct = stimuli.looming(EYE, l_over_v=40, contrast=-0.9, start_ms=-300.0, end_ms=0.0)
    assert stimulus.name == "mine"
    np.testing.assert_array_equal(stimulus.frames, direct.frames)
    np.testing.assert_array_equal(stimulus.time, direct.time)


def test_a_camera_films_the_stimulus_by_its_seed(load):
    conditions = load("""
        [[condition]]
        name = "{camera[seed]}"
        family = "looming"
        l_over_v = 40
        contrast = -0.9
        start_ms = -300
        end_ms = 0
        camera = { noise = 3, seed = [1, 2] }
    """).conditions
    one, two = (np.asarray(condition.render().frames) for condition in conditions)
    plain = stimuli.looming(EYE, l_over_v=40, contrast=-0.9, start_ms=-300.0, end_ms=0.0)
    direct = stimuli.camera(plain, jax.random.key(1), noise=3)
    np.testing.assert_array_equal(one, direct.frames)
    assert np.any(one != two)
    np.testing.assert_array_equal(one, conditions[0].render().frames)


def test_what_does_not_make_a_stimulus_names_its_condition(load, untyped):
    (condition,) = load("[[condition]]\nname = 'x'\nfamily = 'looming'\nl_over_v = -1\ncontrast = -0.9").conditions
    with pytest.raises(ValueError, match=r"^condition 'x': l_over_v is -1"):
        condition.render()


MISTAKES = {
    "[[condition]]\nname='a'\nfamily='looming'\nstart_ms=1979-05-27": "start_ms = .*: must be a number",
    "[[condition]]\nname='a'\nfamily='looming'\nstart_ms=inf": "start_ms = inf: must be a finite number",
    "[[condition]]\nname='a'\nfamily='looming'\nl_over_v=[1, nan]": r"l_over_v\[1\] = nan: must be a finite number",
    "[[condition]]\nname='a'\nfamily=['looming', 'turning']\nl_over_v=3": r"condition\[0\]: l_over_v: unknown key",
    "[[target]]\nlaw='rest'\nerror=-1\n[[condition]]\nname='a'\nfamily='looming'": (
        r"trial\.toml: target\[0\]\.error = -1: must be above 0$"
    ),
    "[[condition]\n": r"trial\.toml is not a TOML file: .*line 6",
    "": "trial.toml: condition is missing",
    "[condition]": r"condition = \{\}: must be a list; write each table under \[\[condition\]\]",
    "[[conditions]]": r"conditions = \[\{\}\]: unknown key; did you mean 'condition'",
    "[[condition]]\nname = 'a'": r"condition\[0\]\.family is missing; choose '",
    "[[condition]]\nfamily = 'looming'": r"condition\[0\]\.name is missing",
    "[[condition]]\nname='a'\nfamily='loming'": r"\[0\]\.family = 'loming': choose 'looming'",
    "[[condition]]\nname='a'\nfamily='looming'\nl_ovr_v=40": "l_ovr_v = 40: unknown key; did you mean 'l_over_v'",
    "[[condition]]\nname='a'\nfamily='looming'\ntargets=3": r"\.targets = 3: unknown key; did you mean 'target'",
    "[[condition]]\nname='a'\nfamily='looming'\ntarget=3": r"condition\[0\]\.target = 3: must be a list",
    "[[condition]]\nname='a'\nfamily='looming'\nl_over_v=[]": r"l_over_v = \[\]: must hold 1 or more",
    "[[condition]]\nname='a'\nfamily='looming'\nl_over_v=[[1, 2]]": r"l_over_v\[0\] = \[1, 2\]: must be a number",
    "[[condition]]\nname='a'\nfamily='looming'\nl_over_v='fast'": "l_over_v = 'fast': must be a number",
    "[[condition]]\nname='a'\nfamily='looming'\nl_over_v=true": "l_over_v = true: must be a number",
    "[[condition]]\nname='a'\nfamily='looming'\nl_over_v={a=1}": "l_over_v = .*: must be a number",
    "[[condition]]\nname='a'\nfamily='looming'\nshape=3": "shape = 3: must be a text",
    "[[condition]]\nname='a'\nfamily='looming'\nchecks=2.5": "checks = 2.5: must be a whole number",
    "[[condition]]\nname='a'\nfamily='looming'\nbackground={image='brick'}": r"background\.kind is missing; choose",
    "[[condition]]\nname='a'\nfamily='looming'\nbackground={kind='foto'}": "kind = 'foto': choose 'photograph'",
    "[[condition]]\nname='a'\nfamily='looming'\nbackground={kind='photograph', imgae='a'}": (
        r"background\.imgae = 'a': unknown key; did you mean 'image'"
    ),
    "[[condition]]\nname='a'\nfamily='looming'\ndistance={kind='tabulated', time_ms=[[0, 1]]}": (
        r"distance\.distance is missing"
    ),
    "[[condition]]\nname='a'\nfamily='looming'\ndistance={kind='tabulated', time_ms=[['a']], distance=[[1]]}": (
        r"distance\.time_ms\[0\]\[0\] = 'a': must be a number"
    ),
    "[[condition]]\nname='a'\nfamily='looming'\ncamera=3": "camera = 3: must be a table",
    "[[condition]]\nname='a'\nfamily='looming'\ncamera={nose=3}": "nose = 3: unknown key; did you mean 'noise'",
    "[[condition]]\nname='a'\nfamily='looming'\ncamera={seed=-1}": r"camera\.seed = -1: must be 0 or more",
    "[[condition]]\nname='a'\nfamily='looming'\neye={fsp=3}": r"eye\.fsp = 3: unknown key; did you mean 'fps'",
    "[[condition]]\nname='a'\nfamily='looming'\neye={fps=-3}": r"eye\.fps = -3: must be above 0",
    "[[condition]]\nname='a'\nfamily='looming'\neye={fps='x'}": r"eye\.fps = 'x': must be a number",
    "[[condition]]\nname='a'\nfamily='looming'\neye={preset='fly'}": r"eye\.preset = 'fly': choose '",
    "[[condition]]\nname='a {spped}'\nfamily='translating'": r"a placeholder of 'a \{spped\}' is not filled",
    "[[condition]]\nname='a {'\nfamily='looming'": r"'a \{' is not a format string",
    "[[condition]]\nname='a {}'\nfamily='looming'": r"a placeholder of 'a \{\}' is not filled",
    "[[condition]]\nname='a'\nfamily='looming'\n[[condition.target]]\nlaw='rest'\n"
    "[[condition.target]]\nfile='{speed}'\nchannel='smp'\ncolumn='a'": (
        r"condition\[0\]\.target\[1\]: a placeholder of '\{speed\}'"
    ),
    "[[condition]]\nname='a'\nfamily='looming'\n[[condition.target]]\nchannel='smp'": (
        r"condition\[0\]\.target\[0\] = .*: give one of file, spikes, law, model as its source"
    ),
    "[[condition]]\nname='a'\nfamily='looming'\n[[condition.target]]\nfile='n.csv'\nchannel='smp'\ncolumn='x'": (
        r"condition\[0\]\.target\[0\]: file = 'n.csv': cannot be read"
    ),
    "[[condition]]\nname='a'\nfamily='looming'\n[[condition.target]]\nlaw='rest'\nchanel='smp'": (
        r"condition\[0\]\.target\[0\]\.chanel = 'smp': unknown key; did you mean 'channel'"
    ),
    "[[condition]]\nname='a'\nfamily='looming'\nl_over_v=[1, 2]": "2 conditions are named 'a'; .*placeholders",
    "[[condition]]\nname='a'\nfamily='looming'\n[[condition]]\nname='a'\nfamily='receding'": "2 conditions are named",
    "[[condition]]\nname='a'\nfamily='looming'\n[[condition]]\nname='b'\nfamily='lomi'": r"\[1\]\.family = 'lomi'",
}


@pytest.mark.parametrize("text", MISTAKES)
def test_mistakes_are_named_in_one_line(load, untyped, text):
    with pytest.raises(ValueError, match=MISTAKES[text]) as caught:
        load(text)
    assert "trial.toml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_eye_is_needed(load, untyped):
    with pytest.raises(ValueError, match="eye is missing"):
        load("[[condition]]\nname = 'a'\nfamily = 'looming'", eye="")
    with pytest.raises(ValueError, match=r"condition\[0\]: eye\.fps is missing; add it, or start from one"):
        load("[[condition]]\nname='a'\nfamily='looming'", eye="[eye]\nrows=12\ncols=16\ndegrees_per_pixel=2\n")


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(FileNotFoundError, match="no such file"):
        load_protocol(tmp_path / "nothing.toml")
    with pytest.raises(FileNotFoundError, match="is a folder"):
        load_protocol(tmp_path)
    (tmp_path / "picture.toml").write_bytes(b"\x89PNG\xff")
    with pytest.raises(ValueError, match=r"picture\.toml is not a TOML file"):
        load_protocol(tmp_path / "picture.toml")
