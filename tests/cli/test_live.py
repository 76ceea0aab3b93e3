"""`lgmd2jax live`: streams on loopback, a pipe, a fake camera, what is dropped, how it ends, and what it refuses."""

import contextlib
import csv
import io
import os
import pathlib
import re
import signal
import socket
import threading
import time
from typing import Any

import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax import alarms, hard
from lgmd2jax._handover.model_file import as_hard
from lgmd2jax._video.live_source import Arrival
from lgmd2jax._video.orientation import Window
from lgmd2jax.cli import live, main
from lgmd2jax.cli.live_tally import COLUMNS, Moment, Tally
from lgmd2jax.cli.live_view import Screen
from tests.cli.streams import av, over_tcp, over_udp
from tests.videos import noise, write_video

ROOT = pathlib.Path(__file__).parents[2]
ROWS, COLS = 32, 48


def looms(count=45):
    """A dark disc that grows ever faster on a light ground: 8-bit RGB."""
    y, x = np.mgrid[:ROWS, :COLS]
    radius = 40 / np.maximum(count - 5 - np.arange(count), 2)
    discs = np.hypot(y - ROWS / 2, x - COLS / 2) <= radius[:, None, None]
    return np.repeat(np.where(discs, 20, 220).astype(np.uint8)[..., None], 3, -1)


def table(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def counted(said):
    """Frames that the model saw, and dropped ones, as the summary tells them."""
    found = re.search(r"(\d+) frames, (\d+) dropped", said)
    assert found
    return int(found[1]), int(found[2])


def expected(rows, pictures):
    """What the robot's program answers to the frames and intervals that a table says the model saw."""
    program = as_hard(lgmd.LGMD2())
    grey = [np.asarray(pictures[int(row["frame"])], float) for row in rows]
    return hard.Response.over_time(
        program.step(frame, float(row["interval_ms"])) for frame, row in zip(grey, rows, strict=True)
    )


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


# What it shows and writes


def test_a_stream_over_tcp_is_seen_to_its_end(place, capsys):
    with over_tcp(looms()) as url:
        assert main(["live", url, "--resize", "48", "--csv", "a.csv", "--overlay", "a.mkv"]) == 0
    said, rows = capsys.readouterr().out, table("a.csv")
    assert list(rows[0]) == list(COLUMNS)
    seen, dropped = counted(said)
    assert seen == len(rows)
    assert seen + dropped >= 35  # ffmpeg may pass over the first frames while it looks at what comes
    assert "latency  median" in said
    assert "wrote    a.csv, a.mkv" in said
    assert "ALARM" in said
    assert any(row["collision"] == "1" for row in rows)
    assert all(float(row["latency_ms"]) >= 0 for row in rows)
    for row in rows[1:]:
        assert float(row["interval_ms"]) == pytest.approx(1000 / 30, rel=0.01) or dropped
    with av.open("a.mkv") as film:
        assert sum(1 for _ in film.decode(video=0)) == seen
    assert sorted(path.name for path in place.iterdir()) == ["a.csv", "a.mkv"]


def test_a_stream_over_udp_is_seen_until_it_stops(place, capsys):
    """Datagrams have no end: what came before is written, and the exit status says that it stopped."""
    with over_udp(looms(40)) as url:
        assert main(["live", url, "--resize", "48", "--csv", "a.csv", "--timeout", "1.5"]) == 1
    told = capsys.readouterr()
    assert re.fullmatch(r"lgmd2jax: udp://\S+ is silent: no frame for 1.5 s; .+\n", told.err)
    assert len(table("a.csv")) == counted(told.out)[0] > 10


def test_a_pipe_gives_the_numbers_of_the_robots_program(place, capsys, monkeypatch):
    """All frames at once: most are dropped, and the intervals between the others are those of the film."""
    write_video(place / "film.mkv", looms(60))
    with piped((place / "film.mkv").read_bytes()):
        assert main(["live", "-", "--resize", "48", "--csv", "a.csv"]) == 0
    rows, pictures = table("a.csv"), looms(60)[..., 0]
    index = np.array([int(row["frame"]) for row in rows])
    said = capsys.readouterr().out
    seen, dropped = counted(said)
    assert seen + dropped == 60
    assert ("a file is for lgmd2jax respond" in said) == (dropped > seen)
    assert index[-1] == 59  # the newest is never dropped
    # Matroska rounds its time stamps to a millisecond.
    np.testing.assert_allclose([float(row["time_ms"]) for row in rows], (index - index[0]) * 1000 / 30, atol=1)
    answers = expected(rows, pictures)
    for name in ("mp", "ffi", "smp_adapted", "spikes"):
        np.testing.assert_allclose([float(row[name]) for row in rows], getattr(answers, name), rtol=1e-6, err_msg=name)
    sides = [[float(row[f"mp_{side}"]) for side in ("left", "centre", "right")] for row in rows]
    np.testing.assert_allclose(sides, answers.mp_sides, rtol=1e-6)


@contextlib.contextmanager
def piped(content):
    """Within the block the bytes come through standard input."""
    reader, writer = os.pipe()
    thread = threading.Thread(target=_fill, args=(writer, content), daemon=True)
    kept = os.dup(0)
    os.dup2(reader, 0)
    try:
        thread.start()
        yield
    finally:
        os.dup2(kept, 0)
        os.close(kept)
        os.close(reader)


def _fill(writer, content):
    with contextlib.suppress(BrokenPipeError), open(writer, "wb") as file:
        file.write(content)


def test_an_upright_stream_gets_a_word(place, capsys):
    write_video(place / "film.mkv", list(noise(6, (96, 54))))
    lgmd.save(lgmd.LGMD2(eye=lgmd.Eye(20, 36, degrees_per_pixel=1.95, fps=30.0)), "model.json")
    with piped((place / "film.mkv").read_bytes()):
        assert main(["live", "-", "--model", "model.json"]) == 0
    said = capsys.readouterr().err
    assert said.startswith("lgmd2jax: warning: the model sees 64 x 36 pixels, but the eye has 20 x 36")
    assert "(--crop 33:63,0:54)" in said


def test_a_camera_is_opened_by_its_number(place, monkeypatch, capsys):
    write_video(place / "film.mkv", looms(20))
    asked, real = [], av.open

    def fake(file, **options):
        asked.append((file, options["format"]))
        return real("film.mkv")

    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.setattr(av, "open", fake)
    assert main(["live", "0", "--resize", "24"]) == 0
    assert main(["live", "/dev/video2"]) == 0
    assert asked == [("/dev/video0", "v4l2"), ("/dev/video2", "v4l2")]
    assert "source   0: " in capsys.readouterr().out


def test_the_urgency_of_the_model_is_told_but_not_with_other_parameters(place, monkeypatch, capsys):
    (place / "model.json").write_bytes((ROOT / "fits/twin/model.json").read_bytes())
    alarms.Urgency(500.0, 150.0, -1.0, 4.0, 2.0, -3.0, 1.5).save(place / "model.json")
    write_video(place / "film.mkv", looms(20))
    real = av.open
    monkeypatch.setattr(av, "open", lambda *_, **__: real("film.mkv"))
    for changes, told in ([], True), (["--set", "T_sp=.7"], False):
        assert main(["live", "0", "--model", "model.json", "--csv", "a.csv", *changes]) == 0
        said = capsys.readouterr()
        assert ("urgency was calibrated without --set" in said.err) != told
        assert ("urgency 0." in said.out) == told
        assert (table("a.csv")[-1]["urgency"] != "nan") == told


# Frames are dropped rather than delayed, and the model knows how long it was


class Pixels:
    """What a frame must be able to tell."""

    size, aspect = (6, 8), 1.0

    def __init__(self, levels):
        self.levels = levels

    def grey(self, window, shape):
        return self.levels


def arrivals(stamps, arrived) -> Any:
    levels = np.random.default_rng(0).uniform(0, 255, (len(stamps), 6, 8))
    kind: Any = Pixels
    return [
        Arrival(index, time_, stamp, kind(frame))
        for index, (stamp, time_, frame) in enumerate(zip(stamps, arrived, levels, strict=True))
    ]


WHOLE: Window = (slice(None), slice(None))


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(
    ("stamps", "arrived", "intervals"),
    [
        ((0.0, 0.04, 0.1), (5.0, 5.1, 5.2), (20.0, 40.0, 60.0)),  # the source's clock, whatever the line does
        ((None, None, None), (5.0, 5.05, 5.2), (20.0, 50.0, 150.0)),
        ((7.0, 0.0, 0.03), (5.0, 5.04, 5.2), (20.0, 40.0, 30.0)),  # a clock that is set back
        ((None, None), (5.0, 5.0), (20.0, 1.0)),  # at once: an interval is never 0
    ],
)
def test_intervals_are_those_of_the_frames_that_the_model_sees(stamps, arrived, intervals):
    source, program, twin = arrivals(stamps, arrived), as_hard(lgmd.LGMD2()), as_hard(lgmd.LGMD2())
    shown = list(live.moments(program, source, "a fake", WHOLE, 8, 20.0))
    assert [moment.interval_ms for _, moment in shown] == pytest.approx(intervals)
    assert [moment.row.time_ms for _, moment in shown] == pytest.approx(np.cumsum(intervals) - 20)
    for (_, moment), arrival, interval in zip(shown, source, intervals, strict=True):
        assert moment.row.mp == pytest.approx(twin.step(arrival.pixels.levels, interval).mp)


def test_the_newest_frame_waits_and_older_ones_are_dropped(place):
    with over_tcp(looms(30), fps=100.0) as url, live.open_live(url) as source:
        indices = []
        for arrival in source:
            indices.append(arrival.number)
            time.sleep(0.1)
    assert source.dropped == indices[-1] + 1 - len(indices) > len(indices)
    assert indices == sorted(set(indices))


@pytest.mark.usefixtures("untyped")
def test_a_frame_of_another_size_is_refused():
    source = arrivals((0.0, 0.1), (0.0, 0.1))
    source[1].pixels.size = (7, 8)
    with pytest.raises(ValueError, match="a fake: frame 1 has 7 x 8 pixels, those before 6 x 8; start again"):
        list(live.moments(as_hard(lgmd.LGMD2()), source, "a fake", WHOLE, 8, 20.0))


# How it ends


class Pressing(Tally):
    """Presses Ctrl-C half a second after the first frame, when all have come; another thread receives the signal."""

    def add(self, moment):
        super().add(moment)
        if self.frames == 1:
            threading.Timer(0.5, lambda: signal.pthread_kill(threading.get_ident(), signal.SIGINT)).start()


@pytest.fixture
def obeying_ctrl_c():
    """A job in the background ignores it, and so do the tests that it runs."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("obeying_ctrl_c")
def test_ctrl_c_ends_it_well(place, capsys, monkeypatch):
    monkeypatch.setattr(live, "Tally", Pressing)
    over, begun = threading.Event(), time.monotonic()
    with over_tcp(looms(20), then=over) as url:
        assert main(["live", url, "--csv", "a.csv", "--timeout", "30"]) == 0
        over.set()
    assert time.monotonic() - begun < 15  # the line stays open for 20
    assert f"source   {url}: {len(table('a.csv'))} frames" in capsys.readouterr().out


def test_a_stream_that_stops_keeps_what_came(place, capsys):
    over = threading.Event()
    with over_tcp(looms(20), then=over) as url:
        assert main(["live", url, "--csv", "a.csv", "--timeout", ".7"]) == 1
        over.set()
    assert "is silent: no frame for 0.7 s" in capsys.readouterr().err
    assert len(table("a.csv")) > 5


def test_a_source_without_a_frame_leaves_the_files_of_an_earlier_run(place, capsys):
    """The index of an mp4 stands at its end, where a pipe cannot look for it."""
    (place / "a.csv").write_text("earlier")
    write_video(place / "film.mp4", noise(20, (240, 320)), "libx264", "yuv420p")
    with piped((place / "film.mp4").read_bytes()):
        assert main(["live", "-", "--csv", "a.csv", "--overlay", "a.mp4"]) == 1
    assert "wrote" not in capsys.readouterr().out
    assert (place / "a.csv").read_text() == "earlier"
    assert not (place / "a.mp4").exists()


def _closed_port():
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["film.mkv"], "source is 'film.mkv'; give a camera .+ for a file: lgmd2jax respond"),
        (["/dev/video98"], "there is no camera /dev/video98; see which there are: ls /dev/video"),
        ([f"tcp://127.0.0.1:{_closed_port()}"], "does not answer: nothing listens there"),
        ([f"udp://127.0.0.1:{_closed_port()}", "--timeout", ".2"], r"is silent: no frame for 0.2 s"),
        (["nonsense://1"], "nonsense://1 cannot be read: Protocol not found"),
        (["0", "--timeout", "0"], "timeout is 0; give a positive number of seconds"),
        (["0", "--resize", "0"], "resize is 0; give a width of at least 3 pixels"),
        (["0", "--csv", "a.x", "--overlay", "./a.x"], "a.x is named twice"),
        (["0", "--model", "preset:yue_rind"], "hard.py and the C code run only the LGMD2"),
        (["0", "--model", "broken.json"], "broken.json is not a JSON file"),
        (["0", "--model", "foreign.json"], "foreign.json is not a hand-over file that can be used"),
    ],
)
def test_what_cannot_be_used_is_refused_in_a_line(arguments, message, place, capsys):
    (place / "broken.json").write_text("{")
    (place / "foreign.json").write_text('{"weights": [1, 2]}')
    before = sorted(place.iterdir())
    assert main(["live", *arguments]) == 1
    told = capsys.readouterr().err
    assert re.search(message, told)
    assert told.count("\n") == 1
    assert sorted(place.iterdir()) == before


def test_bytes_that_are_no_video_are_refused(place, capsys):
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve():
            line, _ = server.accept()
            with line:
                line.sendall(b"no video at all" * 1000)

        threading.Thread(target=serve, daemon=True).start()
        assert main(["live", f"tcp://127.0.0.1:{server.getsockname()[1]}"]) == 1
    assert "sends no video that ffmpeg can read" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("number", "message"), [(16, "0 is busy: another program uses it"), (13, "0 may not be read by you")]
)
def test_a_camera_that_is_busy_or_forbidden(number, message, monkeypatch, capsys):
    def refuse(*_, **__):
        av.error.err_check(-number)

    monkeypatch.setattr(av, "open", refuse)
    assert main(["live", "0"]) == 1
    assert re.fullmatch(rf"lgmd2jax: {message}.*\n", capsys.readouterr().err)


# What is counted and drawn


def moment(time_ms, collision=0, latency=2.0, smp_adapted=0.7, **others):
    row = live.Row(0, time_ms, 1.0, 1.0, 0.7, smp_adapted, collision, collision)
    return Moment(row, 33.0, latency, (3.0, 0.0, 1.0), others.get("urgency", float("nan")))


def test_counts_do_not_grow_with_time():
    tally = Tally()
    for number in range(2000):
        tally.add(moment(number * 25.0, collision=number // 100 % 2, latency=number % 100))
    assert (tally.frames, tally.alarms) == (2000, 10)
    assert tally.fps == pytest.approx(40)
    assert tally.latency(0.5) == pytest.approx(49)
    assert tally.latency(1.0) == 99
    assert len(tally._latencies) == 100
    assert len(tally._times) <= 82


def test_the_screen_shows_trace_levels_and_alarm():
    rich_console = pytest.importorskip("rich.console")
    from rich.live import Live

    out = io.StringIO()
    console = rich_console.Console(file=out, force_terminal=True, width=100)
    with Live(console=console, auto_refresh=False) as shown:
        screen, tally = Screen(shown, (0.78,)), Tally()
        for number in range(40):
            tally.add(moment(number * 33.0))
            screen.show(moment(number * 33.0), tally, 3)
        calm = out.getvalue()
        tally.add(moment(1320.0, 1, urgency=0.91))
        screen.show(moment(1320.0, 1, urgency=0.91), tally, 3)
    assert "ALARM" not in calm
    for words in ("0.78", "dropped 3", "turn right", "SMP 0.700"):
        assert words in calm
    assert "ALARM" in out.getvalue()
    assert "urgency 0.91" in out.getvalue()
