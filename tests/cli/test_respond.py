"""`lgmd2jax respond`: the model on clips, what it writes and prints, and what it refuses."""

import csv
import json
import re
import xml.etree.ElementTree

import imageio.v3 as iio
import jax.numpy as jnp
import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

import lgmd2jax as lgmd
from lgmd2jax._figures.response import BLUE, GREEN, SKY, VERMILION, response_figure
from lgmd2jax._video.clip import Frame, open_clip
from lgmd2jax._video.grey import grey
from lgmd2jax._video.snapshots import Snapshot
from lgmd2jax._video.trace import Rows, Trace
from lgmd2jax.cli import main
from lgmd2jax.cli.respond import responses
from tests.clips import ROUNDING
from tests.videos import damaged, write_video

av = pytest.importorskip("av", reason="reading video needs the extra 'video'")

SVG = "{http://www.w3.org/2000/svg}"
COLUMNS = ["frame", "time_ms", "mp", "ffi", "smp", "smp_adapted", "spikes", "collision"]


def loom(count=40, rows=41, cols=55):
    """A dark disc that grows ever faster on a light ground, then stands: 8-bit RGB."""
    y, x = np.mgrid[:rows, :cols]
    distance = np.hypot(y - rows // 2, x - cols // 2)
    radius = 40 / np.maximum(count - 8 - np.arange(count), 2)
    discs = np.where(distance <= radius[:, None, None], 20, 220).astype(np.uint8)
    return np.repeat(discs[..., None], 3, -1)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder of images that approach, with an empty folder beside it as the current one."""
    images = tmp_path / "loom"
    images.mkdir()
    for i, picture in enumerate(loom()):
        iio.imwrite(images / f"{i}.png", picture)
    results = tmp_path / "results"
    results.mkdir()
    monkeypatch.chdir(results)
    return images


def table(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def listed(folder):
    return sorted(path.name for path in folder.iterdir())


# What it computes


def test_streaming_a_clip_is_the_whole_clip_call(folder):
    frames = jnp.stack([jnp.asarray(grey(picture)) for picture in loom()])
    for model in (lgmd.LGMD2(), lgmd.LGMD2(lgmd.preset("balanced"), n_p=1)):
        whole = model(frames, 30.0)
        rows = Rows()
        for _, row in responses(model, open_clip(folder, fps=30.0)):
            rows.append(row)
        trace = rows.trace()
        for name in COLUMNS[2:]:
            np.testing.assert_allclose(getattr(trace, name), getattr(whole, name), rtol=ROUNDING, err_msg=name)
        assert trace.collision.any()


def test_real_intervals_reach_the_model(folder):
    def slowed(frames):
        for frame in frames:
            yield Frame(frame.index, frame.time, 2 * frame.interval, frame.pixels, frame.grey, False)

    model, clip = lgmd.LGMD2(), open_clip(folder, fps=30.0)
    fast, slow = ([row for _, row in responses(model, frames)] for frames in (clip, slowed(clip)))
    half = [row for _, row in responses(model, open_clip(folder, fps=15.0))]
    assert [row[2:] for row in slow] == [row[2:] for row in half] != [row[2:] for row in fast]


def test_a_repeated_frame_does_not_reach_the_model(folder):
    def stuttered(frames):
        for frame in frames:
            yield frame
            yield Frame(frame.index, frame.time, frame.interval, frame.pixels, frame.grey, repeated=True)

    model, clip = lgmd.LGMD2(), open_clip(folder, fps=30.0)
    plain = [row for _, row in responses(model, clip)]
    assert [row for frame, row in responses(model, stuttered(clip)) if not frame.repeated] == plain


# What it writes


def test_it_writes_the_table_and_the_figure_and_says_so(folder, tmp_path, capsys):
    assert main(["respond", str(folder), "--fps", "30"]) == 0
    assert listed(tmp_path / "results") == ["loom.csv", "loom.png"]
    rows = table("loom.csv")
    assert list(rows[0]) == COLUMNS
    assert [int(row["frame"]) for row in rows] == list(range(40))
    assert float(rows[3]["time_ms"]) == pytest.approx(100)
    assert {row["collision"] for row in rows} == {"0", "1"}
    assert {row["spikes"] for row in rows} == {"0", "1", "2"}
    whole = lgmd.LGMD2()(jnp.stack([jnp.asarray(grey(picture)) for picture in loom()]), 30.0)
    np.testing.assert_allclose([float(row["smp"]) for row in rows], whole.smp, rtol=ROUNDING + 1e-8)
    said = capsys.readouterr().out
    peak = int(np.argmax(whole.smp))
    alarm = np.flatnonzero(whole.collision)
    for line in [
        "40 frames of 41 rows x 55 columns at 30 fps",
        "it sees 41 rows x 55 columns, grey by ITU-R 601",
        "preset:lgmd2",
        f"SMP       at most {float(whole.smp.max()):.3f} (frame {peak}, {peak * 1000 / 30:.0f} ms)",
        f"spikes    {int(whole.spikes.sum())}\n",
        f"alarm     frames {alarm[0]}-",
        "wrote     loom.csv, loom.png",
    ]:
        assert line in said


def test_every_file_goes_where_it_is_sent(folder, tmp_path, capsys):
    names = {"--csv": "a.csv", "--figure": "b.svg", "--overlay": "c.mp4"}
    sent = [str(word) for option, name in names.items() for word in (option, tmp_path / name)]
    assert main(["respond", str(folder), "--fps", "30", *sent]) == 0
    assert listed(tmp_path / "results") == []
    said = capsys.readouterr().out
    assert all(name in said for name in names.values())
    rows = table(tmp_path / "a.csv")
    smp, silent = [float(row["smp_adapted"]) for row in rows], [row["collision"] == "0" for row in rows]
    assert len(smp) == 40
    np.testing.assert_allclose(curve_of(tmp_path / "b.svg", smp), smp, atol=1e-3)
    film = iio.imread(tmp_path / "c.mp4", plugin="pyav")
    assert len(film) == 40
    clear = np.s_[2:15, 48:53]  # of the trace in the lower half, of the border and of the frame's number
    np.testing.assert_allclose(film[silent][:, *clear], loom()[silent][:, *clear], atol=25)
    blueness = (film[..., 2].astype(int) - film[..., 0])[:, 17:41]
    assert np.all(blueness[2:].max(axis=(1, 2)) > 60)  # the trace, from the first frames on


def curve_of(path, values):
    """SMP after adaptation, a value a frame, as the line of a figure has it; its axis spans the range of `values`."""
    figure = xml.etree.ElementTree.parse(path).getroot()
    lines = [line.get("d", "") for line in figure.iter(f"{SVG}path") if "stroke: #0072b2" in line.get("style", "")]
    x, y = np.array(re.findall(r"[ML] (\S+) (\S+)", max(lines, key=len)), float).T
    heights = np.interp(np.linspace(x[0], x[-1], len(values)), x, -y)
    return np.interp(heights, [heights.min(), heights.max()], [min(values), max(values)])


def test_the_figure_shows_potentials_inhibition_and_an_alarm_where_there_is_one(folder):
    """By colours: both potentials, the inhibition, and the light shade of an alarm over all panels."""

    def colours(*options):
        assert main(["respond", str(folder), "--fps", "30", *options]) == 0
        pixels = iio.imread("loom.png")[..., :3].astype(int)
        known = {"smp_adapted": BLUE, "smp": SKY, "ffi": GREEN, "threshold": VERMILION}
        amounts = {name: near(pixels, to_rgb(colour)) for name, colour in known.items()}
        return amounts | {"alarm": near(pixels, 0.22 * np.array(to_rgb(VERMILION)) + 0.78)}

    def near(pixels, colour):
        return int(np.all(np.abs(pixels - 255 * np.array(colour)) < 3, axis=-1).sum())

    loud, silent = colours(), colours("--set", "N_sp=10")
    assert min(loud.values()) > 200
    assert loud["alarm"] > 20_000
    assert silent["alarm"] < 20
    assert min(amount for name, amount in silent.items() if name != "alarm") > 200


def test_the_same_clip_gives_the_same_table_and_figure(folder, tmp_path):
    def written():
        assert main(["respond", str(folder), "--fps", "30"]) == 0
        return {path.name: path.read_bytes() for path in (tmp_path / "results").iterdir()}

    assert written() == written()


def test_the_overlay_has_every_frame_and_shows_the_alarm(folder):
    assert main(["respond", str(folder), "--fps", "25", "--overlay", "loom.mp4"]) == 0
    pictures, meta = iio.imread("loom.mp4", plugin="pyav"), iio.immeta("loom.mp4", plugin="pyav")
    assert pictures.shape == (40, 42, 56, 3)  # even sizes
    assert meta["fps"] == 25
    red = pictures[:, 20, 0, 0].astype(int) - pictures[:, 20, 0, 2]
    np.testing.assert_array_equal(red > 60, [row["collision"] == "1" for row in table("loom.csv")])


def test_dropped_frames_are_missing_in_the_table_and_the_rule_is_named(folder, tmp_path, capsys):
    stuttered = tmp_path / "stutter"
    stuttered.mkdir()
    shown = np.arange(75) * 4 // 5
    noise = np.random.default_rng(0).integers(0, 256, (60, 20, 20, 3), dtype=np.uint8)
    for i, source in enumerate(shown):
        iio.imwrite(stuttered / f"{i:03}.png", noise[source])
    assert main(["respond", str(stuttered), "--fps", "30", "--drop-duplicates", "--overlay", "o.mp4"]) == 0
    kept = np.flatnonzero(np.diff(shown, prepend=-1))
    assert [int(row["frame"]) for row in table("stutter.csv")] == kept.tolist()
    assert [float(row["time_ms"]) for row in table("stutter.csv")] == pytest.approx((kept * 1000 / 30).tolist())
    said = capsys.readouterr().out
    assert "15 of 75 frames dropped, each changed by less than 0.3 of" in said
    assert "a step of the model is 41.67 ms (24 fps)" in said
    assert len(iio.imread("o.mp4", plugin="pyav")) == 75


@pytest.mark.parametrize(("asked", "width"), [([], 15), (["--resize", "30"], 30)])
def test_a_model_with_an_eye_sees_a_clip_as_wide_as_that_eye(folder, capsys, asked, width):
    model = lgmd.LGMD2(lgmd.preset("lgmd2", T_sp=0.65), eye=lgmd.Eye(11, 15, degrees_per_pixel=2.0, fps=30.0))
    lgmd.save(model, "model.json")
    assert main(["respond", str(folder), "--fps", "30", "--model", "model.json", *asked]) == 0
    clip = open_clip(folder, fps=30.0, resize=width)
    expected = [row.smp for _, row in responses(model, clip)]
    assert [float(row["smp"]) for row in table("loom.csv")] == pytest.approx(expected, abs=1e-8)
    assert f"it sees {clip.shape[0]} rows x {width} columns" in capsys.readouterr().out


def test_crop_resize_and_single_parameters_are_used(folder, capsys):
    arguments = ["respond", str(folder), "--fps", "30", "--crop", "1:,5:35", "--resize", "15"]
    assert main([*arguments, "--set", "T_sp=.6", "--set", "N_sp=3"]) == 0
    clip = open_clip(folder, fps=30.0, crop=np.s_[1:, 5:35], resize=15)
    rows = [row for _, row in responses(lgmd.LGMD2(lgmd.Parameters(T_sp=0.6, N_sp=3)), clip)]
    assert [int(row["collision"]) for row in table("loom.csv")] == [row.collision for row in rows]
    assert "preset:lgmd2, T_sp=.6, N_sp=3; it sees 20 rows x 15 columns" in capsys.readouterr().out


def test_a_model_file_is_used_and_another_frame_rate_warned_of(folder, tmp_path, capsys):
    eye = lgmd.Eye(rows=41, cols=55, degrees_per_pixel=1.0, fps=100.0)
    lgmd.save(lgmd.LGMD2(lgmd.Parameters(k=0.5), eye=eye), tmp_path / "model.json")
    assert main(["respond", str(folder), "--fps", "30", "--model", str(tmp_path / "model.json")]) == 0
    whole = lgmd.LGMD2(lgmd.Parameters(k=0.5))(jnp.stack([jnp.asarray(grey(picture)) for picture in loom()]), 30.0)
    np.testing.assert_allclose([float(row["smp"]) for row in table("loom.csv")], whole.smp, rtol=ROUNDING + 1e-8)
    assert capsys.readouterr().err == "lgmd2jax: warning: the model belongs to 100 fps, the clip has 30\n"


def test_a_clip_much_larger_than_the_eye_gets_a_word(folder, capsys):
    lgmd.save(lgmd.LGMD2(eye=lgmd.Eye(11, 15, degrees_per_pixel=2.0, fps=30.0)), "model.json")
    arguments = ["respond", str(folder), "--fps", "30", "--model", "model.json"]
    assert main([*arguments, "--resize", "55"]) == 0
    assert "warning: the model's eye has 11 x 15 pixels, and it sees 41 x 55" in capsys.readouterr().err
    assert main(arguments) == 0
    assert capsys.readouterr().err == ""


def test_one_frame_that_is_held_does_not_change_the_clock_of_the_others(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    stamps = [*np.round(np.arange(40) * 1000 / 30), 6300]
    write_video(
        tmp_path / "held.mp4", [*loom(40, 40, 56), loom(40, 40, 56)[-1]], "libx264", "yuv420p", stamps_ms=stamps
    )
    lgmd.save(lgmd.LGMD2(eye=lgmd.Eye(40, 56, degrees_per_pixel=2.0, fps=30.0)), "model.json")
    assert main(["respond", "held.mp4", "--model", "model.json"]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    assert re.search(r"at (30|29\.9\d+) fps", said.out)
    steps = re.search(r"clock     the file's time stamps: a step of the model is (\S+) to (\S+) ms", said.out)
    assert steps is not None
    assert [float(step) for step in steps.groups()] == pytest.approx([1000 / 30, 5000], abs=1.5)
    assert re.search(r"speed     \d+ frames per second, without compilation", said.out)
    assert len(table("held.csv")) == 41


def test_a_white_level_and_a_damaged_end_can_be_told(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    deep = (loom(40, 20, 28)[..., 0] / 255 * 4095).round().astype(np.uint16)
    path = write_video(tmp_path / "deep.mkv", deep, pixels="gray16le", given="gray16le")
    assert main(["respond", "deep.mkv", "--white", "4095"]) == 0
    expected = [row.smp for _, row in responses(lgmd.LGMD2(), open_clip(path, white=4095))]
    assert [float(row["smp"]) for row in table("deep.csv")] == pytest.approx(expected, abs=1e-8)
    capsys.readouterr()
    damaged(path)
    assert "--until-damage" in refused([path, "--white", "4095"], capsys)
    assert main(["respond", "deep.mkv", "--white", "4095", "--until-damage"]) == 0
    assert re.fullmatch(r"lgmd2jax: warning: .*deep\.mkv: it is damaged or truncated: .*\n", capsys.readouterr().err)
    assert 5 < len(table("deep.csv")) < 40


def test_the_figure_has_the_inhibition_in_the_unit_of_the_model(tmp_path, monkeypatch):
    figures = []
    monkeypatch.setattr(Figure, "savefig", lambda figure, path: figures.append(figure))
    half = np.full(3, 0.5)
    trace = Trace(np.arange(3), np.linspace(0, 66, 3), half, half / 4, half, half, np.arange(3) * 0, np.arange(3) * 0)
    shot = Snapshot(0, 0.0, False, loom(1)[0])
    for mechanisms in ((), ("size",)):
        response_figure(tmp_path / "response.png", trace, lgmd.LGMD2(mechanisms=mechanisms), [shot], "")
    panels = [next(axes for axes in figure.axes if axes.get_ylabel().startswith("FFI")) for figure in figures]
    assert [axes.get_ylabel() for axes in panels] == ["FFI\n(grey levels)", "FFI\nshare of the field"]
    assert [axes.texts[0].get_text() for axes in panels] == ["T_ffi", "A_ffi"]
    assert panels[1].texts[0].xy[1] == pytest.approx(0.09)


def test_matplotlib_is_left_as_it_was(tmp_path):
    before = dict(mpl.rcParams)
    zeros = np.zeros(3)
    trace = Trace(
        np.arange(3), np.linspace(0, 66, 3), zeros, zeros, zeros + 0.5, zeros + 0.5, np.arange(3) * 0, np.arange(3) * 0
    )
    shot = Snapshot(0, 0.0, False, loom(1)[0])
    response_figure(tmp_path / "rest.png", trace, lgmd.LGMD2(), [shot], "at rest")
    assert dict(mpl.rcParams) == before


# What it refuses


def refused(arguments, capsys):
    """The one line that it says, and nothing but that."""
    try:
        status = main(["respond", *map(str, arguments)])
    except SystemExit as ended:
        status = ended.code
    said = capsys.readouterr()
    assert status not in (0, None)
    assert said.out == ""
    assert re.fullmatch(r"lgmd2jax.*: .+\n", said.err)
    return said.err


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["missing.mp4"], "no such clip: missing.mp4"),
        (["{folder}"], "states no frame rate; give it: fps = 30 (--fps 30)"),
        (["{folder}", "--fps", "0"], "fps is 0"),
        (["{folder}", "--fps", "-3"], "fps is -3"),
        (["{folder}", "--fps", "fast"], "invalid float value: 'fast'"),
        (["{folder}", "--fps", "30", "--crop", "0:90,:"], "crop 0:90,: does not lie in the frame"),
        (["{folder}", "--fps", "30", "--crop", "middle"], "write TOP:BOTTOM,LEFT:RIGHT"),
        (["{folder}", "--fps", "30", "--resize", "2"], "needs at least 3 x 3"),
        (["{folder}", "--fps", "30", "--model", "{folder}/0.png"], "0.png"),
        (["{folder}", "--fps", "30", "--model", "preset:lgmd3"], "preset is 'lgmd3'; choose 'lgmd2'"),
        (["{folder}", "--fps", "30", "--set", "T_x=1"], "parameter is 'T_x'; choose"),
        (["{folder}", "--fps", "30", "--csv", "nowhere/a.csv"], "the folder nowhere does not exist"),
        (["{folder}", "--fps", "30", "--figure", "nowhere/a.png"], "the folder nowhere does not exist"),
        (["{folder}", "--fps", "30", "--overlay", "nowhere/a.mp4"], "the folder nowhere does not exist"),
        (["{folder}", "--fps", "30", "--figure", "a.xyz"], "end its name in .png"),
        (["{folder}", "--fps", "30", "--overlay", "a.xyz"], "end its name in .mp4"),
        (["{folder}", "--fps", "30", "--overlay", "a.gif"], "no gif file holds H.264; end its name in .mp4"),
        (["{folder}", "--fps", "30", "--csv", "same.png", "--figure", "same.png"], "same.png is named twice"),
        ([], "the following arguments are required: CLIP"),
    ],
)
def test_misuse_is_one_line_and_leaves_nothing(folder, tmp_path, capsys, arguments, message):
    assert message in refused([str(word).format(folder=folder) for word in arguments], capsys)
    assert listed(tmp_path / "results") == []


def test_a_clip_is_never_written_over(tmp_path, capsys):
    path = tmp_path / "clip.mkv"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("ffv1", rate=30, width=20, height=20, pix_fmt="bgr0")
        for picture in loom(5, 20, 20):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture)))
        container.mux(stream.encode(None))
    before = path.read_bytes()
    assert "named twice" in refused([path, "--overlay", path], capsys)
    assert path.read_bytes() == before


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize("options", [[], ["--drop-duplicates"]])
def test_a_fault_within_the_clip_leaves_nothing_half_written(folder, tmp_path, capsys, options):
    (tmp_path / "results" / "loom.csv").write_text("from before")
    (folder / "30.png").write_bytes((folder / "30.png").read_bytes()[:60])
    assert "30.png as an image" in refused([folder, "--fps", "30", "--overlay", "loom.mp4", *options], capsys)
    iio.imwrite(folder / "30.png", loom()[0, :9, :9])
    assert "frame 30 has 9 x 9 pixels" in refused([folder, "--fps", "30", "--overlay", "loom.mp4", *options], capsys)
    for i in range(1, 40):
        (folder / f"{i}.png").unlink()
    assert "one frame" in refused([folder, "--fps", "30", "--overlay", "loom.mp4", *options], capsys)
    assert listed(tmp_path / "results") == ["loom.csv"]
    assert (tmp_path / "results" / "loom.csv").read_text() == "from before"


# Recorded clips


@pytest.mark.parametrize(
    ("clip", "low", "high"), [("da", 0.99, 1), ("dr", 0.5, 0.505), ("la", 0.5, 0.505), ("lr", 0.99, 1)]
)
def test_table_i_on_the_authors_clips(data, clip, low, high):
    peak = max(row.smp for _, row in responses(lgmd.LGMD2(), open_clip(data / "authors_clips" / f"{clip}.avi", fps=30)))
    assert low <= peak <= high


def test_ffi_silences_the_authors_grating(data):
    clip = open_clip(data / "authors_clips" / "grating.avi", fps=30)
    assert {row.smp for _, row in responses(lgmd.LGMD2(), clip)} == {0.5}
    assert max(row.smp for _, row in responses(lgmd.ablate(lgmd.LGMD2(), "ffi"), clip)) == pytest.approx(1, abs=1e-3)


@pytest.mark.parametrize("options", [[], ["--resize", "108"], ["--resize", "108", "--drop-duplicates"]])
def test_the_alarm_falls_before_the_recorded_crash_and_not_in_traffic(data, tmp_path, monkeypatch, options):
    monkeypatch.chdir(tmp_path)
    (clip,) = (
        clip
        for clip in json.loads((data / "clips" / "annotations.json").read_text())["clips"]
        if clip["file"] == "c29.mp4"
    )
    assert clip["expected_LGMD2"] == "alarm between 149 and 174; none in 0-120"
    assert main(["respond", str(data / "clips" / "c29.mp4"), *options]) == 0
    alarms = [int(row["frame"]) for row in table("c29.csv") if row["collision"] == "1"]
    assert any(149 <= frame <= 174 for frame in alarms)
    assert min(alarms) > 120
