"""The hand-over file, and the NumPy model that reads it."""

import json
import pathlib
import shutil
from importlib.metadata import version

import jax
import jax.numpy as jnp
import jsonschema
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax import hard
from tests.handover.conftest import EYE, FRAMES, LGMD1, MODEL, RICH

SCHEMA = json.loads((pathlib.Path(hard.__file__).parent / "schemas" / "model.json").read_text())
VERSION_1 = pathlib.Path(__file__).parents[1] / "golden" / "model_v1.json"


def changed(path, change):
    content = json.loads(path.read_text())
    change(content)
    path.write_text(json.dumps(content))


def test_round_trip(path):
    loaded = lgmd.load(path)
    assert loaded.eye == EYE
    assert (loaded.n_p, loaded.low_pass, loaded.N_ts) == (1, "exact", 3)
    assert jax.tree.all(jax.tree.map(jnp.array_equal, loaded.parameters, MODEL.parameters))
    np.testing.assert_array_equal(loaded(FRAMES).smp_adapted, MODEL(FRAMES).smp_adapted)


def test_soft_models_are_handed_over_hard(path, tmp_path, untyped):
    """And an eye of 50 frames per second equals one of 50.0."""
    eye = lgmd.Eye(rows=7, cols=9, degrees_per_pixel=2, fps=50)
    lgmd.save(
        lgmd.LGMD2(MODEL.parameters, lgmd.Soft(), n_p=1, low_pass="exact", N_ts=3, eye=eye), tmp_path / "soft.json"
    )
    assert (tmp_path / "soft.json").read_bytes() == path.read_bytes()


def test_single_precision_is_written_short(tmp_path, untyped):
    single = jax.tree.map(lambda leaf: leaf.astype(jnp.float32), lgmd.LGMD2())
    lgmd.save(single, tmp_path / "model.json")
    assert '"w_bias": 0.3,' in (tmp_path / "model.json").read_text()


def test_the_file_fits_its_schema(path):
    jsonschema.validate(json.loads(path.read_text()), SCHEMA)
    changed(path, lambda content: content["parameters"].update(tau1=-1))
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(json.loads(path.read_text()), SCHEMA)


def limits(domain: str) -> dict[str, float]:
    """A domain in the words of a schema."""
    low, high = domain[1:-1].split(", ")
    limits = {}
    if low != "-inf":
        limits["minimum" if domain[0] == "[" else "exclusiveMinimum"] = float(low)
    if high != "inf":
        limits["maximum" if domain[-1] == "]" else "exclusiveMaximum"] = float(high)
    return limits


def test_schema_and_numpy_model_know_the_same_parameters():
    symbols, definitions = lgmd.symbols(), SCHEMA["$defs"]
    assert {name: symbol.domain for name, symbol in symbols.items() if not symbol.mechanism} == hard.DOMAINS
    assert tuple(hard.MECHANISMS) == lgmd.MECHANISMS
    for mechanism, domains in hard.MECHANISMS.items():
        own = {name: symbol.domain for name, symbol in symbols.items() if symbol.mechanism == mechanism}
        assert own == domains
    references = definitions["LGMD2_mechanisms"]["properties"]
    assert list(references) == list(hard.MECHANISMS)
    tables = {name: definitions[reference["$ref"].removeprefix("#/$defs/")] for name, reference in references.items()}
    for declared, domains in [
        (definitions["LGMD2_parameters"], hard.DOMAINS),
        *((tables[name], domains) for name, domains in hard.MECHANISMS.items()),
    ]:
        assert declared.get("required", []) == list(declared["properties"]) == list(domains)
        assert declared["additionalProperties"] is False
        for name, domain in domains.items():
            given = {key: declared["properties"][name].get(key) for key in limits("[0, 1]") | limits("(0, 1)")}
            assert {key: limit for key, limit in given.items() if limit is not None} == limits(domain), name


def test_mechanisms_make_the_round_trip(others):
    path = others / "rich.json"
    content = json.loads(path.read_text())
    jsonschema.validate(content, SCHEMA)
    assert set(content["parameters"]) == set(hard.DOMAINS)
    assert content["mechanisms"]["lag"] == {"lag": 21.0}
    loaded = lgmd.load(path)
    assert isinstance(loaded, lgmd.LGMD2)
    assert (loaded.mechanisms, loaded.eye) == (RICH.mechanisms, EYE)
    assert jax.tree.all(jax.tree.map(jnp.array_equal, loaded.parameters, RICH.parameters))
    expected = RICH(FRAMES)
    robot = hard.load(path)(FRAMES)
    np.testing.assert_allclose(robot.smp_adapted, expected.smp_adapted, rtol=1e-10)
    np.testing.assert_array_equal(robot.spikes, expected.spikes)


def test_what_a_mechanism_does_not_use_is_not_written(tmp_path, untyped):
    """So equal models give equal files, and what is absent is off."""
    for name, lag in (("one", 10.0), ("other", 20.0)):
        lgmd.save(lgmd.LGMD2(lgmd.Parameters(lag=lag), eye=EYE), tmp_path / f"{name}.json")
    assert (tmp_path / "one.json").read_bytes() == (tmp_path / "other.json").read_bytes()
    assert "mechanisms" not in json.loads((tmp_path / "one.json").read_text())
    assert lgmd.load(tmp_path / "one.json")(FRAMES).smp.shape == (12,)


def test_the_other_network_makes_the_round_trip(others):
    path = others / "lgmd1.json"
    content = json.loads(path.read_text())
    jsonschema.validate(content, SCHEMA)
    assert (content["network"], content["structure"]) == ("YueRindLGMD1", {"N_sp": 3})
    loaded = lgmd.load(path)
    assert isinstance(loaded, lgmd.YueRindLGMD1)
    assert (loaded.N_sp, loaded.eye) == (3, EYE)
    assert jax.tree.all(jax.tree.map(jnp.array_equal, loaded.parameters, LGMD1.parameters))
    np.testing.assert_array_equal(loaded(FRAMES).spikes, LGMD1(FRAMES).spikes)
    assert lgmd.load(path, network=lgmd.YueRindLGMD1).N_sp == 3
    with pytest.raises(ValueError, match="its network is 'YueRindLGMD1', not 'LGMD2'"):
        lgmd.load(path, network=lgmd.LGMD2)
    with pytest.raises(ValueError, match="its network is 'YueRindLGMD1'; this program runs only the LGMD2"):
        hard.load(path)


def test_version_1_is_read_as_ever(tmp_path):
    content = json.loads(VERSION_1.read_text())
    assert content["version"] == 1
    jsonschema.validate(content, SCHEMA)
    model, robot = lgmd.load(VERSION_1), hard.load(VERSION_1)
    assert isinstance(model, lgmd.LGMD2)
    assert (model.mechanisms, robot.mechanisms) == ((), ())
    assert {name: float(getattr(model.parameters, name)) for name in hard.DOMAINS} == content["parameters"]
    for later in ("network", "mechanisms", "calibration"):
        old = content | {later: "LGMD2" if later == "network" else {}}
        (tmp_path / "model.json").write_text(json.dumps(old))
        with pytest.raises(ValueError, match=f"'{later}' is unknown; there are format, version, parameters"):
            hard.load(tmp_path / "model.json")
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(old, SCHEMA)


def test_a_calibration_may_stand_in_it(path):
    changed(path, lambda content: content.update(calibration={"gain": 2.0, "of": ["camera"]}))
    jsonschema.validate(json.loads(path.read_text()), SCHEMA)
    assert lgmd.load(path).eye == EYE
    assert hard.load(path).fps == 50


@pytest.mark.parametrize(
    ("change", "message", "library"),
    [
        (
            lambda content: content.update(version=99),
            "version is 99",
            "version = 99: this program reads 1 and 2; update it",
        ),
        (lambda content: content.update(format="other"), "format is not", "format = 'other': choose 'lgmd2jax-model'"),
        (lambda content: content.pop("structure"), "structure is missing", "structure is missing"),
        (lambda content: content["parameters"].pop("tau1"), "tau1 is missing", r"parameters\.tau1 is missing"),
        (
            lambda content: content["parameters"].update(tau1=float("nan")),
            "tau1 is nan",
            r"parameters\.tau1 = nan: must be a finite number",
        ),
        (
            lambda content: content["parameters"].update(tau1="30"),
            "tau1 is '30'",
            r"parameters\.tau1 = '30': must be a number",
        ),
        (
            lambda content: content["parameters"].update(k=0),
            "k is 0; it must lie in",
            r"parameters\.k = 0: must be above 0",
        ),
        (
            lambda content: content["parameters"].update(theta4=1),
            "'theta4' is unknown",
            r"parameters\.theta4 = 1: unknown key",
        ),
        (
            lambda content: content["parameters"].update(T_p=20),
            "T_p belongs to a mechanism; give it there",
            r"parameters\.T_p = 20: unknown key",
        ),
        (lambda content: content["parameters"].update(k=10**400), "parameter k is 1000", r"parameters\.k = 1"),
        (
            lambda content: content.update(parameters=[1, 2]),
            r"parameters is \[1, 2\]; give values by name",
            r"parameters = \[1, 2\]: must be a table",
        ),
        (
            lambda content: content.update(mechanisms={"sise": {}}),
            "mechanism 'sise' is unknown; there are size, shunt",
            r"mechanisms\.sise = \{\}: unknown key",
        ),
        (
            lambda content: content.update(mechanisms={"lag": 3}),
            "mechanism lag is 3; give lag",
            r"mechanisms\.lag = 3: must be a table",
        ),
        (
            lambda content: content.update(mechanisms={"lag": {}}),
            r"mechanism lag is \{\}; give lag",
            r"mechanisms\.lag\.lag is missing",
        ),
        (
            lambda content: content.update(mechanisms={"lag": {"lag": 81}}),
            r"lag is 81; it must lie in \[0, 80\]",
            r"mechanisms\.lag\.lag = 81: must be 80 or less",
        ),
        (
            lambda content: content.update(mechanisms={"lag": {"lag": 9, "m": 1}}),
            "mechanism lag is .*; give lag",
            r"mechanisms\.lag\.m = 1: unknown key",
        ),
        (
            lambda content: content.update(mechanisms={"membrane": {"tau_cell": 20}}),
            "mechanisms has a membrane, which needs the shunt",
            "mechanisms has a membrane, which needs the shunt",
        ),
        (
            lambda content: content.update(mechanisms=["lag"]),
            r"mechanisms is \['lag'\]; give",
            r"mechanisms = \['lag'\]: must be a table",
        ),
        (
            lambda content: content.update(calibration=3),
            "calibration is 3; give values by name",
            "calibration = 3: must be a table",
        ),
        (
            lambda content: content.update(provenance=3),
            "provenance is 3; give values by name",
            "provenance = 3: must be a table",
        ),
        (
            lambda content: content.update(network=3),
            "its network is 3; this program runs",
            "network = 3: must be a text",
        ),
        (
            lambda content: content.update(network="Mine"),
            "its network is 'Mine'; (this program|for one of your own)",
            r"its network is 'Mine'; for one of your own give its class, in Python: load\(path, network=Mine\) or l",
        ),
        (
            lambda content: content.update(remark="mine"),
            "'remark' is unknown; there are format, version, network",
            "remark = 'mine': unknown key",
        ),
        (
            lambda content: content["structure"].update(n_p=10**30),
            "n_p is 1000.*; give a whole number of frames, 0 to",
            r"structure\.n_p = 1",
        ),
        (
            lambda content: content["structure"].update(N_ts=10**12),
            "N_ts is 1000.*; give a whole number of frames",
            r"structure\.N_ts = 1",
        ),
        (
            lambda content: content["structure"].update(N_ts=True),
            "N_ts is True",
            r"structure\.N_ts = true: must be a whole number",
        ),
        (lambda content: content["eye"].update(fps=10**400), "fps is 1000", r"eye\.fps = 1"),
        (
            lambda content: content["test_vector"]["frames"][3][2].__setitem__(0, 10**30),
            "grey levels 0..255",
            r"test_vector\.frames\[3\]\[2\]\[0\] = 1",
        ),
        (
            lambda content: content["test_vector"]["response"]["mp"].__setitem__(0, 10**400),
            "mp in the response",
            r"test_vector\.response\.mp\[0\] = 1",
        ),
        (lambda content: content["structure"].update(n_p=-1), "n_p is -1", r"structure\.n_p = -1: must be 0 or more"),
        (
            lambda content: content["structure"].update(low_pass="none"),
            "low_pass is 'none'",
            r"structure\.low_pass = 'none': choose 'exact' or 'backward_euler'",
        ),
        (lambda content: content["eye"].update(fps=0), "fps is 0", r"eye\.fps = 0: must be above 0"),
        (lambda content: content["eye"].update(rows=2), "rows is 2", r"eye\.rows = 2: must be 3 or more"),
        (
            lambda content: content["eye"].update(degrees_per_pixel=float("inf")),
            "degrees_per_pixel is inf",
            r"eye\.degrees_per_pixel = inf: must be a finite number",
        ),
        (
            lambda content: content["eye"].update(projection="flat"),
            "projection is 'flat'",
            r"eye\.projection = 'flat': choose 'equidistant' or 'pinhole'",
        ),
        (
            lambda content: content["eye"].pop("fps"),
            "eye is .*; give rows, cols, degrees_per_pixel, fps",
            r"eye\.fps is missing",
        ),
        (
            lambda content: (content["structure"].update(n_p=2), content["parameters"].update(u=-5)),
            "u is -5 with n_p = 2: the persistence",
            "u is -5 with n_p = 2: the persistence is not stable; raise u or lower ",
        ),
        (lambda content: content.pop("provenance"), "provenance is missing", "provenance is missing"),
        (lambda content: content.pop("test_vector"), "test_vector is missing", "test_vector is missing"),
        (
            lambda content: content["test_vector"].pop("frames"),
            "test_vector does not hold fps, tolerance, frames",
            r"test_vector\.frames is missing",
        ),
        (
            lambda content: content["test_vector"].update(fps=25),
            "the fps of test_vector is 25",
            "the fps of test_vector is 25; it must be positive, and that of the eye",
        ),
        (
            lambda content: content["test_vector"].update(tolerance=1),
            "the tolerance of test_vector is 1",
            r"test_vector\.tolerance = 1: must be 0\.001 or less",
        ),
        (
            lambda content: content["test_vector"].update(tolerance=float("nan")),
            "the tolerance of test_vector is nan",
            r"test_vector\.tolerance = nan: must be a finite number",
        ),
        (
            lambda content: content["test_vector"]["frames"][3][2].pop(),
            "the frames of test_vector are not whole",
            r"the frames of test_vector are not whole grey levels 0\.\.255 of \(time, r",
        ),
        (
            lambda content: content["test_vector"]["frames"][3][2].__setitem__(0, 256),
            "grey levels 0..255",
            r"test_vector\.frames\[3\]\[2\]\[0\] = 256: must be 255 or less",
        ),
        (
            lambda content: content["test_vector"]["frames"][3][2].__setitem__(0, 1.5),
            "grey levels 0..255",
            r"test_vector\.frames\[3\]\[2\]\[0\] = 1\.5: must be a whole number",
        ),
        (
            lambda content: content["test_vector"]["frames"][3][2].__setitem__(0, None),
            "grey levels 0..255",
            r"test_vector\.frames\[3\]\[2\]\[0\] = null: must be a whole number",
        ),
        (
            lambda content: content["test_vector"]["response"].pop("mp"),
            "the response of test_vector does not hold mp",
            r"test_vector\.response\.mp is missing",
        ),
        (
            lambda content: content["test_vector"]["response"]["mp"].pop(),
            "mp in the response of test_vector",
            "mp in the response of test_vector is not a finite value for each frame",
        ),
        (
            lambda content: content["test_vector"]["response"]["ffi"].__setitem__(0, float("nan")),
            "ffi in the response",
            r"test_vector\.response\.ffi\[0\] = nan: must be a finite number",
        ),
        (
            lambda content: content["test_vector"]["response"]["spikes"].__setitem__(0, "0"),
            "spikes in the response",
            r"test_vector\.response\.spikes\[0\] = '0': must be a whole number",
        ),
        (
            lambda content: content["test_vector"]["response"]["collision"].__setitem__(0, 0.5),
            "collision in the resp",
            r"test_vector\.response\.collision\[0\] = 0\.5: must be true or false",
        ),
    ],
)
@pytest.mark.parametrize("load", [lgmd.load, hard.load])
def test_a_file_that_is_not_in_order_is_refused(path, load, change, message, library):
    """The robot's program says so in words of its own, the library by the schema."""
    changed(path, change)
    with pytest.raises(ValueError, match=library if load is lgmd.load else message) as error:
        load(path)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda content: content["parameters"].pop("T_de"), r"parameters\.T_de is missing"),
        (lambda content: content["parameters"].update(T_d=3), r"parameters\.T_d = 3: unknown key; did you mean 'T_de'"),
        (lambda content: content["parameters"].update(T_de="3"), r"parameters\.T_de = '3': must be a number"),
        (lambda content: content["parameters"].update(T_de=10**400), r"parameters\.T_de = 10+\.\.\.0+: is too large"),
        (lambda content: content["parameters"].update(T_de=True), r"parameters\.T_de = true: must be a number"),
        (lambda content: content["parameters"].update(T_de=-1.0), r"parameters\.T_de = -1"),
        (lambda content: content["parameters"].update(T_de=7.0), "the response to its test vector differs"),
        (lambda content: content["structure"].update(N_sp=0), r"structure\.N_sp = 0: must be 1 or more"),
        (lambda content: content["structure"].update(N_sp=10**12), r"structure\.N_sp = 10+: must be 10000 or less"),
        (lambda content: content["structure"].update(N_ts=3), r"structure\.N_ts = 3: unknown key"),
        (lambda content: content.update(mechanisms={"size": {}}), "mechanisms = .*: must hold 0 or fewer"),
        (lambda content: content.update(mechanisms=3), "mechanisms = 3: must be a table"),
    ],
)
def test_a_file_of_the_other_network_that_is_not_in_order_is_refused(others, tmp_path, untyped, change, message):
    shutil.copy(others / "lgmd1.json", tmp_path / "model.json")
    changed(tmp_path / "model.json", change)
    with pytest.raises(ValueError, match=message) as error:
        lgmd.load(tmp_path / "model.json")
    assert str(error.value).count("model.json is not a hand-over file that can be used") == 1


@pytest.mark.parametrize("content", ["", "[1, 2]", "{", "\x00\xff"])
@pytest.mark.parametrize("load", [lgmd.load, hard.load])
def test_what_is_not_a_hand_over_file_is_refused(tmp_path, load, content):
    (tmp_path / "model.json").write_text(content)
    with pytest.raises(ValueError, match=r"not a (hand-over|JSON) file|: document = "):
        load(tmp_path / "model.json")
    with pytest.raises(OSError, match="nowhere"):
        load(tmp_path / "nowhere.json")
    with pytest.raises(OSError, match=tmp_path.name):
        load(tmp_path)


def test_provenance_is_carried_in_an_order_of_its_own(original, tmp_path, untyped):
    lgmd.save(MODEL, tmp_path / "model.json", provenance={"seed": 3, "recipe": "mine"})
    content = json.loads((tmp_path / "model.json").read_text())
    assert list(content["provenance"]) == ["program", "recipe", "seed"]
    assert content["provenance"] == {"program": f"lgmd2jax {version('lgmd2jax')}", "recipe": "mine", "seed": 3}
    assert content | {"provenance": None} == json.loads(original.read_text()) | {"provenance": None}
    jsonschema.validate(content, SCHEMA)


@pytest.mark.parametrize("provenance", [{"program": "mine"}, {"loss": float("nan")}, {"curves": [1, 2]}, {3: "three"}])
def test_other_provenance_is_refused_and_leaves_the_old_file(path, untyped, provenance):
    before = path.read_bytes()
    with pytest.raises(ValueError, match=r"provenance( has|\[.curves.\] is)"):
        lgmd.save(MODEL, path, provenance=provenance)
    assert path.read_bytes() == before


def test_a_batch_is_refused_and_leaves_the_old_file(path):
    before = path.read_bytes()
    batch = jax.vmap(lambda theta2: lgmd.LGMD2(lgmd.Parameters(theta2=theta2)))(jnp.ones(3))
    with pytest.raises(ValueError, match=r"theta1 has shape \(3,\)"):
        lgmd.save(batch, path)
    assert path.read_bytes() == before
    assert [file.name for file in path.parent.iterdir()] == ["model.json"]
