"""`lgmd2jax export --ros`: the package, and its node against a stand-in for rclpy."""

import importlib
import pathlib
import sys
import types
import xml.etree.ElementTree
from typing import ClassVar

import numpy as np
import pytest

from lgmd2jax import alarms, hard
from lgmd2jax._video.grey import area_average, grey
from lgmd2jax.cli import main

ROOT = pathlib.Path(__file__).parents[2]
FILES = {
    "README.md", "package.xml", "setup.py", "setup.cfg", "resource/lgmd2", "config/lgmd2.yaml", "config/model.json",
    "lgmd2/__init__.py", "lgmd2/hard.py", "lgmd2/node.py",
}  # fmt: skip
URGENCY = alarms.Urgency(500.0, 150.0, -1.0, 4.0, 2.0, -3.0, 1.5)


def listed(folder):
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    """The package of a shipped fit that was given an urgency."""
    place = tmp_path_factory.mktemp("ros")
    model = place / "model.json"
    model.write_bytes((ROOT / "fits/twin/model.json").read_bytes())
    URGENCY.save(model)
    assert main(["export", str(model), "--ros", str(place / "package")]) == 0
    assert listed(place / "package") == FILES
    assert (place / "package/config/model.json").read_bytes() == model.read_bytes()
    assert (place / "package/lgmd2/hard.py").read_bytes() == pathlib.Path(hard.__file__).read_bytes()
    return place / "package"


class Record(types.SimpleNamespace):
    """A message."""


class Status(Record):
    OK, WARN = b"\\0", b"\\1"


class Node:
    """What the node uses of rclpy's, keeping what was published."""

    settings: ClassVar[dict] = {}

    def __init__(self, name):
        self.name, self.parameters, self.published, self.logged = name, {}, [], []

    def declare_parameter(self, name, default):
        self.parameters[name] = self.settings.get(name, default)

    def get_parameter(self, name):
        return Record(value=self.parameters[name])

    def create_subscription(self, kind, topic, callback, qos):
        self.subscribed = (kind, topic, qos.depth)
        self.receive = callback

    def create_publisher(self, kind, topic, depth):
        return Record(publish=self.published.append)

    def get_logger(self):
        return Record(error=self.logged.append)


@pytest.fixture
def program(package, monkeypatch):
    """The module of the node, with stand-ins for what ROS brings."""
    stand_ins = {
        "rclpy": {"init": None, "spin": None, "try_shutdown": None},
        "rclpy.node": {"Node": Node},
        "rclpy.qos": {
            "QoSProfile": Record,
            "HistoryPolicy": Record(KEEP_LAST=1),
            "ReliabilityPolicy": Record(BEST_EFFORT=2),
        },
        "sensor_msgs": {},
        "sensor_msgs.msg": {"Image": Record},
        "diagnostic_msgs": {},
        "diagnostic_msgs.msg": {"DiagnosticArray": Record, "DiagnosticStatus": Status, "KeyValue": Record},
        "ament_index_python": {},
        "ament_index_python.packages": {"get_package_share_directory": lambda name: str(package)},
    }
    for name, content in stand_ins.items():
        module = types.ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.syspath_prepend(str(package))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    yield importlib.import_module("lgmd2.node")
    for name in [name for name in sys.modules if name.split(".")[0] == "lgmd2"]:
        del sys.modules[name]


def image(pixels, ms, encoding="mono8", padding=0):
    """A message of these pixels; rows are padded with what must not be seen."""
    rows = pixels.reshape(len(pixels), -1)
    padded = np.pad(rows, [(0, 0), (0, padding)], constant_values=255)
    stamp = Record(sec=int(ms // 1000), nanosec=round(ms % 1000 * 1e6))
    return Record(
        header=Record(stamp=stamp, frame_id="camera"),
        height=pixels.shape[0],
        width=pixels.shape[1],
        encoding=encoding,
        step=padded.shape[1],
        data=padded.tobytes(),
    )


def told(message):
    return {pair.key: float(pair.value) for pair in message.status[0].values}


def frames(count=30, rows=24, cols=32):
    """A dark square that grows, in colour."""
    generator = np.random.default_rng(0)
    pictures = generator.integers(170, 230, (1, rows, cols, 3), dtype=np.uint8).repeat(count, axis=0)
    for t in range(8, count):
        half = min((t - 6) // 2, 10)
        pictures[t, 12 - half : 12 + half, 16 - half : 16 + half] = generator.integers(0, 40, 3)
    return pictures


@pytest.mark.parametrize("encoding", ["mono8", "rgb8", "bgr8"])
def test_the_node_answers_as_hard_py_does(program, encoding, monkeypatch):
    """By the clock of the images, which is uneven, with padded rows."""
    monkeypatch.setattr(Node, "settings", {"cols": 0})
    node = program.Lgmd2()
    assert node.subscribed == (Record, "image_raw", 1)
    model = hard.load(ROOT / "fits/twin/model.json")
    model = hard.HardLGMD2(
        model.parameters, mechanisms=model.mechanisms, n_p=model.n_p, low_pass=model.low_pass, N_ts=model.N_ts,
        urgency=vars(URGENCY),
    )  # fmt: skip
    clock = 5_000.0 + np.cumsum(np.random.default_rng(1).uniform(15, 60, 30))
    for t, picture in enumerate(frames()):
        sent = picture[..., 1] if encoding == "mono8" else picture if encoding == "rgb8" else picture[..., ::-1]
        node.receive(image(sent, clock[t], encoding, padding=5))
        seen = picture[..., 1].astype(float) if encoding == "mono8" else picture @ [0.299, 0.587, 0.114]
        now = model.step(seen, clock[t] - clock[t - 1] if t else 1000 / node.parameters["fps"])
        message = node.published[-1]
        assert message.header.stamp.sec == int(clock[t] // 1000)
        assert message.status[0].level == (Status.WARN if now.collision else Status.OK)
        values = told(message)
        assert values["urgency"] == pytest.approx(now.urgency, rel=1e-5)
        assert values["mp_left"] + values["mp_centre"] + values["mp_right"] == pytest.approx(now.mp, rel=1e-5, abs=1e-6)
        assert (values["collision"], values["spikes"]) == (now.collision, now.spikes)
        assert values["smp_adapted"] == pytest.approx(now.smp_adapted, rel=1e-6)
    assert len(node.published) == 30
    assert np.ptp([told(message)["smp_adapted"] for message in node.published]) > 0.1


def test_the_model_sees_area_means_and_starts_anew_after_a_gap(program, monkeypatch):
    monkeypatch.setattr(Node, "settings", {"cols": 12})
    node, seen = program.Lgmd2(), []
    monkeypatch.setattr(node.model, "step", lambda frame, interval: seen.append((frame, interval)) or _answer())
    resets = []
    monkeypatch.setattr(node.model, "reset", lambda: resets.append(len(seen)))
    pictures = frames(5)
    for picture, ms in zip(pictures, (0.0, 40.0, 2000.0, 1900.0, 1940.0), strict=True):
        node.receive(image(picture, ms, "rgb8"))
    first = 1000 / node.parameters["fps"]
    assert [interval for _, interval in seen] == pytest.approx([first, 40, first, first, 40])
    assert resets == [2, 3]
    np.testing.assert_allclose(seen[0][0], area_average(grey(pictures[0]), (9, 12)), rtol=1e-5)
    node.receive(image(pictures[0][:, :20], 1980.0, "rgb8"))
    assert resets == [2, 3, 5]


def _answer():
    return hard.Response(0.0, 0.0, 0.5, 0.5, 0, False, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def test_an_image_that_cannot_be_read_is_passed_over_and_told_once(program):
    node, good = program.Lgmd2(), frames(2)
    for _ in range(3):
        node.receive(image(good[0][..., 0], 0.0, "16UC1"))
    short = image(good[0][..., 0], 0.0)
    short.data = short.data[:-1]
    node.receive(short)
    assert node.published == []
    assert node.logged == [
        "an image is passed over: encoding '16UC1'; send mono8, rgb8, bgr8",
        "an image is passed over: 24 x 32 pixels in 767 bytes, 32 a row",
    ]
    node.receive(image(good[0][..., 0], 0.0))
    assert len(node.published) == 1


def test_the_package_describes_itself(package):
    described = xml.etree.ElementTree.parse(package / "package.xml").getroot()
    assert described.findtext("name") == "lgmd2"
    needed = {element.text for element in described.iter("exec_depend")}
    assert needed == {"ament_index_python", "diagnostic_msgs", "python3-numpy", "rclpy", "sensor_msgs"}
    compile((package / "setup.py").read_text(), "setup.py", "exec")
    assert "lgmd2.node:main" in (package / "setup.py").read_text()
    assert "Not run on hardware" in (package / "README.md").read_text()
    parameters = (package / "config/lgmd2.yaml").read_text()
    declared = {line.split(":")[0].strip() for line in parameters.splitlines()[2:]}
    assert declared == {"model", "cols", "fps", "longest_gap_ms"}


def test_what_something_else_holds_is_not_written_over(tmp_path, capsys):
    (tmp_path / "package.xml").write_text("<package/>")
    assert main(["export", "twin", "--ros", str(tmp_path)]) == 1
    assert "holds something else than results" in capsys.readouterr().err
    assert listed(tmp_path) == {"package.xml"}
    assert main(["export", "preset:yue_rind", "--ros", str(tmp_path / "new")]) == 1
    assert "hard.py and the C code run only the LGMD2" in capsys.readouterr().err
    assert main(["export", "twin", "--ros", str(tmp_path / "new"), "--rows", "9"]) == 1
    assert listed(tmp_path) == {"package.xml"}
