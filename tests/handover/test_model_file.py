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

SCHEMA = json.loads(pathlib.Path(hard.__file__).with_name("model.schema.json").read_text())
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
    tables = definitions["LGMD2_mechanisms"]["properties"]
    assert list(tables) == list(hard.MECHANISMS)
    for declared, domains in [
        (definitions["LGMD2_parameters"], hard.DOMAINS),
        *((tables[name], domains) for name, domains in hard.MECHANISMS.items()),
    ]:
        assert declared["required"] == list(declared["properties"]) == list(domains)
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
    with pytest.raises(ValueError, match="its network is 'YueRindLGMD1'; this program runs the LGMD2 alone"):
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
        with pytest.raises(ValueError, match=f"{later} is unknown; there are format, version, parameters"):
            hard.load(tmp_path / "model.json")
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(old, SCHEMA)


def test_a_calibration_may_stand_in_it(path):
    changed(path, lambda content: content.update(calibration={"gain": 2.0, "of": ["camera"]}))
    jsonschema.validate(json.loads(path.read_text()), SCHEMA)
    assert lgmd.load(path).eye == EYE
    assert hard.load(path).fps == 50


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda content: content.update(version=99), "version is 99"),
        (lambda content: content.update(format="other"), "format is not"),
        (lambda content: content.pop("structure"), "structure is missing"),
        (lambda content: content["parameters"].pop("tau1"), "tau1 is missing"),
        (lambda content: content["parameters"].update(tau1=float("nan")), "tau1 is nan"),
        (lambda content: content["parameters"].update(tau1="30"), "tau1 is '30'"),
        (lambda content: content["parameters"].update(k=0), "k is 0; it must lie in"),
        (lambda content: content["parameters"].update(theta4=1), "theta4 is unknown"),
        (lambda content: content["parameters"].update(T_p=20), "T_p belongs to a mechanism; give it there"),
        (lambda content: content["parameters"].update(k=10**400), "parameter k is 1000"),
        (lambda content: content.update(parameters=[1, 2]), r"parameters is \[1, 2\]; give values by name"),
        (lambda content: content.update(mechanisms={"sise": {}}), "mechanism sise is unknown; there are size, shunt"),
        (lambda content: content.update(mechanisms={"lag": 3}), "mechanism lag is 3; give values by name"),
        (lambda content: content.update(mechanisms={"lag": {}}), r"mechanism lag is \{\}; give lag"),
        (lambda content: content.update(mechanisms={"lag": {"lag": 81}}), r"lag is 81; it must lie in \[0, 80\]"),
        (lambda content: content.update(mechanisms={"lag": {"lag": 9, "m": 1}}), "mechanism lag is .*; give lag"),
        (
            lambda content: content.update(mechanisms={"membrane": {"tau_cell": 20}}),
            "mechanisms has a membrane without the shunt",
        ),
        (lambda content: content.update(mechanisms=["lag"]), r"mechanisms is \['lag'\]; give"),
        (lambda content: content.update(calibration=3), "calibration is 3; give values by name"),
        (lambda content: content.update(provenance=3), "provenance is 3; give values by name"),
        (lambda content: content.update(network=3), "its network is 3; give the name of one"),
        (lambda content: content.update(network="Mine"), "its network is 'Mine'; (this program|for one of your own)"),
        (lambda content: content.update(remark="mine"), "remark is unknown; there are format, version, network"),
        (lambda content: content["structure"].update(n_p=10**30), "n_p is 1000.*; give a whole number of frames, 0 to"),
        (lambda content: content["structure"].update(N_ts=10**12), "N_ts is 1000.*; give a whole number of frames"),
        (lambda content: content["structure"].update(N_ts=True), "N_ts is True"),
        (lambda content: content["eye"].update(fps=10**400), "fps is 1000"),
        (lambda content: content["test_vector"]["frames"][3][2].__setitem__(0, 10**30), "grey levels 0..255"),
        (lambda content: content["test_vector"]["response"]["mp"].__setitem__(0, 10**400), "mp in the response"),
        (lambda content: content["structure"].update(n_p=-1), "n_p is -1"),
        (lambda content: content["structure"].update(low_pass="none"), "low_pass is 'none'"),
        (lambda content: content["eye"].update(fps=0), "fps is 0"),
        (lambda content: content["eye"].update(rows=2), "rows is 2"),
        (lambda content: content["eye"].update(degrees_per_pixel=float("inf")), "degrees_per_pixel is inf"),
        (lambda content: content["eye"].update(projection="flat"), "projection is 'flat'"),
        (lambda content: content["eye"].pop("fps"), "eye is .*; give rows, cols, degrees_per_pixel, fps"),
        (
            lambda content: (content["structure"].update(n_p=2), content["parameters"].update(u=-5)),
            "u is -5 with n_p = 2: the persistence",
        ),
        (lambda content: content.pop("provenance"), "provenance is missing"),
        (lambda content: content.pop("test_vector"), "test_vector is missing"),
        (lambda content: content["test_vector"].pop("frames"), "test_vector does not hold fps, tolerance, frames"),
        (lambda content: content["test_vector"].update(fps=25), "the fps of test_vector is 25"),
        (lambda content: content["test_vector"].update(tolerance=1), "the tolerance of test_vector is 1"),
        (lambda content: content["test_vector"].update(tolerance=float("nan")), "the tolerance of test_vector is nan"),
        (lambda content: content["test_vector"]["frames"][3][2].pop(), "the frames of test_vector are not whole"),
        (lambda content: content["test_vector"]["frames"][3][2].__setitem__(0, 256), "grey levels 0..255"),
        (lambda content: content["test_vector"]["frames"][3][2].__setitem__(0, 1.5), "grey levels 0..255"),
        (lambda content: content["test_vector"]["frames"][3][2].__setitem__(0, None), "grey levels 0..255"),
        (lambda content: content["test_vector"]["response"].pop("mp"), "the response of test_vector does not hold mp"),
        (lambda content: content["test_vector"]["response"]["mp"].pop(), "mp in the response of test_vector"),
        (lambda content: content["test_vector"]["response"]["ffi"].__setitem__(0, float("nan")), "ffi in the response"),
        (lambda content: content["test_vector"]["response"]["spikes"].__setitem__(0, "0"), "spikes in the response"),
        (lambda content: content["test_vector"]["response"]["collision"].__setitem__(0, 0.5), "collision in the resp"),
    ],
)
@pytest.mark.parametrize("load", [lgmd.load, hard.load])
def test_a_file_that_is_not_in_order_is_refused(path, load, change, message):
    changed(path, change)
    with pytest.raises(ValueError, match=message) as error:
        load(path)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda content: content["parameters"].pop("T_de"), "parameter T_de is missing"),
        (lambda content: content["parameters"].update(T_d=3), "parameter T_d is unknown; choose 'T_de'"),
        (lambda content: content["parameters"].update(T_de="3"), "parameter T_de is '3'"),
        (lambda content: content["parameters"].update(T_de=10**400), "parameter T_de is 1000"),
        (lambda content: content["parameters"].update(T_de=True), "parameter T_de is True"),
        (lambda content: content["parameters"].update(T_de=-1.0), "T_de is -1"),
        (lambda content: content["parameters"].update(T_de=7.0), "its test vector does not come out"),
        (lambda content: content["structure"].update(N_sp=0), "N_sp is 0"),
        (lambda content: content["structure"].update(N_sp=10**12), "N_sp is 1000"),
        (lambda content: content["structure"].update(N_ts=3), "N_ts"),
        (lambda content: content.update(mechanisms={"size": {}}), "mechanism size is unknown; a YueRindLGMD1 has none"),
        (lambda content: content.update(mechanisms=3), "mechanisms is 3"),
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
    with pytest.raises(ValueError, match="not a hand-over file"):
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
    with pytest.raises(ValueError, match="provenance has"):
        lgmd.save(MODEL, path, provenance=provenance)
    assert path.read_bytes() == before


def test_a_batch_is_refused_and_leaves_the_old_file(path):
    before = path.read_bytes()
    batch = jax.vmap(lambda theta2: lgmd.LGMD2(lgmd.Parameters(theta2=theta2)))(jnp.ones(3))
    with pytest.raises(ValueError, match=r"theta1 has shape \(3,\)"):
        lgmd.save(batch, path)
    assert path.read_bytes() == before
    assert [file.name for file in path.parent.iterdir()] == ["model.json"]
