"""What is wrong in a file of trials is told in one line with its cure; nothing passes as something else."""

import copy

import numpy as np
import openpyxl
import pytest
import scipy.io

import lgmd2jax as lgmd
from lgmd2jax.cli import main
from tests.trials import synthesis
from tests.trials.synthesis import WINDOW, recordings

MATRIX = np.array([[-90.0, -30.0, 5.0, np.nan, np.nan], [-80.0, -40.0, -20.0, 10.0, np.nan]])
TIDY = "animal,trial,l_over_v_ms,spike_ms\n"
ROWS = "".join(f"A,{trial},20,{time}\n" for trial in (1, 2) for time in (-300.5, -80, -60, -55.5, 12, 300))
TRIALS = "animal,trial,l_over_v_ms,impact_s,start_s,end_s\nA,1,20,10,9,11\nA,2,20,20,19,21\n"
SPIKES = "animal,trial,spike_s\nA,1,9.9\nA,1,10.1\nA,2,19.95\n"


def seconds(text):
    """The last cell of each row, in ms, as seconds under the same header."""
    header, *rows = text.splitlines()
    cells = [row.rpartition(",") for row in rows]
    return "\n".join([header, *(f"{left},{float(time) / 1000:g}" for left, _, time in cells)]) + "\n"


CASES = {
    "no unit": (TIDY.replace("spike_ms", "spike") + ROWS, {}, r"'spike', -300.5 to 300, have no unit.*--time-unit ms"),
    "no unit, seconds": (
        seconds(TIDY.replace("spike_ms", "time") + ROWS),
        {},
        r"'time', -0.3005 to 0.3, have no unit; give it by time_unit = 's' \(--time-unit s\)",
    ),
    "seconds in a column of ms": (seconds(TIDY + ROWS), {}, "seconds were taken for ms"),
    "ms given as seconds": (
        TIDY.replace("spike_ms", "spike") + ROWS.replace("-300.5", "-30000.5").replace(",300\n", ",90000\n"),
        {"time_unit": "s"},
        "ms were taken for seconds",
    ),
    "two units": (TIDY + ROWS, {"time_unit": "s"}, "time_unit is 's', but the column is named 'spike_ms'"),
    "l/|v| in seconds": (
        TIDY.replace("l_over_v_ms", "l_over_v") + ROWS.replace(",20,", ",0.02,"),
        {},
        r"'l_over_v' holds 0.02 to 0.02, as l/\|v\| in seconds; call it l_over_v_s",
    ),
    "a clock that starts with the trial": (
        TIDY + "".join(f"A,1,20,{time}\n" for time in range(1, 2000, 150)),
        {},
        r"none of them before, .* by event \(--event\)",
    ),
    "ms in a column of seconds": (
        "animal,trial,l_over_v_ms,impact_s,spike_s\n" + "".join(f"A,1,20,10000,{time}\n" for time in range(12)),
        {},
        "from the event, .* or as on a session's clock",
    ),
    "l/|v| in seconds in the names of columns": (
        "A_lv0.02_1 (s),A_lv0.04_1 (s)\n-.1,-.2\n.3,.1\n",
        {},
        r"'l_over_v' holds 0.02 to 0.02, as l/\|v\| in seconds",
    ),
    "a column of the event beside a column a trial": (
        "A_lv20_1 (s),A_lv20_2 (s)\n-.1,-.2\n.3,.1\n",
        {"event": "A_lv20_1 (s)"},
        r"event is 'A_lv20_1 \(s\)', but each column is a trial; give its value",
    ),
    "an event that is no number": (TIDY + ROWS, {"event": "nan"}, "event is nan; give a finite number"),
    "a negative l/|v|": (TIDY + ROWS, {"l_over_v": -4}, "'l_over_v' holds -4"),
    "a trial named nan": (TIDY + ROWS + "A,nan,20,5\n", {}, "row 13 lacks its trial"),
    "a number of 5000 digits": (TIDY + ROWS + "A,2,20," + "9" * 5000, {}, "holds '9{40}' in row 13, which is no"),
    "a decimal comma in commas": (TIDY + 'A,1,20,"1,5"\nA,1,20,2.5\n', {}, r"'1,5' in row 1.*decimal = ','"),
    "not a number": (TIDY + ROWS + "A,2,20,nan\n", {}, "'nan' in row 13, which is no finite number"),
    "a row too short": (TIDY + ROWS + "A,2,20\n", {}, "row 13 has 3 cells and the header 4, separated by ','"),
    "another separator": (TIDY + ROWS, {"separator": ";"}, "there is one column, .* separated by ';'; give another"),
    "no trial": (TIDY.replace("trial", "what") + ROWS, {}, r"number of a trial; name it by trial \(--trial\)"),
    "no trial's name": (TIDY + ROWS + ",3,20,5\n", {}, "row 13 lacks its animal"),
    "two columns of time": (
        TIDY.replace("spike_ms", "spike_ms,time_ms") + ROWS.replace("\n", ",0\n"),
        {},
        r"columns 'spike_ms' and 'time_ms' may each be the time; name one by time \(--time\)",
    ),
    "two columns of one name": ("A_lv20_1 (s),A_lv20_1 (s)\n-.1,-.2\n.3,.1\n", {}, "is given twice"),
    "columns that tell no trial": (
        "first (s),second (s)\n-.1,-.2\n.3,.1\n",
        {},
        "'first .s.' names no trial; name each",
    ),
    "columns without a unit": ("A_lv20_1,A_lv20_2\n-.1,-.2\n.3,.1\n", {}, "'A_lv20_1', -0.1 to 0.3, have no unit"),
    "NaN amid a column": ("A_lv20_1 (s),A_lv20_2 (s)\n-.1,-.2\nnan,.1\n.3,.2\n", {}, "'nan' in row 2"),
    "a unit that is none": (TIDY + ROWS, {"time_unit": "h"}, "time_unit is 'h'"),
    "no file": (None, {}, "no such file"),
    "empty": ("", {}, "no rows"),
    "a header alone": (TIDY, {}, "no rows"),
    "trials without any spike": (TIDY + "A,1,20,\nA,2,20,\n", {}, "there is no spike in any trial"),
    "a window that ends before it starts": (TIDY + ROWS, {"window": (100, -100)}, r"window is \(100, -100\)"),
    "a column that is not there": (TIDY + ROWS, {"event": "impact_s"}, "no column 'impact_s'; choose"),
}


SETTINGS = ("a window that ends before it starts", "an event that is no number", "a negative l/|v|")  # of no file


def test_names_that_look_like_numbers_stay_apart(tmp_path):
    animals = ["1", "01", "1.0", "1e1", "10", "1_0"]
    rows = "".join(f"{animal},{trial},20,{5 * trial}\n" for trial, animal in enumerate(animals))
    (tmp_path / "spikes.csv").write_text(TIDY + rows)
    assert lgmd.load_trials(tmp_path / "spikes.csv").animals == ("1", "01", "1_0", "1e1", "10")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "latin-1"])
def test_text_of_other_programs(encoding, tmp_path):
    """Excel writes a mark at the beginning, which Python leaves out of UTF-16 of a given order."""
    mark = "\ufeff" if encoding.endswith("le") else ""
    (tmp_path / "spikes.csv").write_bytes((mark + TIDY + ROWS.replace("A", "\u00c4")).encode(encoding))
    if encoding == "latin-1":
        with pytest.raises(ValueError, match=r"spikes.csv: not a CSV file in UTF-8: byte 34 is 0xc4; save it as UTF-8"):
            lgmd.load_trials(tmp_path / "spikes.csv")
    else:
        assert lgmd.load_trials(tmp_path / "spikes.csv").animals == ("\u00c4",)


@pytest.mark.parametrize("case", CASES)
def test_a_table_that_is_wrong_is_refused(case, tmp_path):
    text, told, words = CASES[case]
    if text is not None:
        (tmp_path / "spikes.csv").write_text(text, encoding="utf-8")
    with pytest.raises((ValueError, FileNotFoundError), match=words) as refusal:
        lgmd.load_trials(tmp_path / "spikes.csv", **told)
    assert "spikes.csv" in str(refusal.value) or case in SETTINGS


PAIRS = {
    "two rows of a trial": (
        TRIALS + "A,2,40,20,19,21\n",
        SPIKES,
        "row 3 is of animal 'A', trial '2' again, and not alike",
    ),
    "spikes of no trial": (TRIALS, SPIKES + "A,7,12\n", "row 4 of the spikes is of animal 'A', trial '7'"),
    "a spike outside": (TRIALS, SPIKES + "A,1,13\n", "reaches from -1000 to 1000 ms, and a spike lies at 3000 ms"),
    "another clock": (
        TRIALS,
        SPIKES + "".join(f"A,1,{time}\n" for time in np.arange(5000, 5300, 20.0)),
        "session's clock|ms were taken for seconds",
    ),
    "no common column": (TRIALS, SPIKES.replace("trial", "what"), "share no column of the trial"),
    "no unit of the event": (TRIALS.replace("impact_s", "impact"), SPIKES, "'impact', 10 to 20, have no unit"),
    "a span that ends before it starts": (
        TRIALS.replace("9,11", "11,9"),
        "animal,trial,spike_s\nA,2,20\n",
        "correct its span",
    ),
}


@pytest.mark.parametrize("case", PAIRS)
def test_two_tables_that_do_not_belong_together_are_refused(case, tmp_path):
    trials, spikes, words = PAIRS[case]
    (tmp_path / "trials.csv").write_text(trials)
    (tmp_path / "spikes.csv").write_text(spikes)
    with pytest.raises(ValueError, match=words):
        lgmd.load_trials(tmp_path)


def test_what_stands_twice_and_alike_counts_once_and_is_told(tmp_path):
    (tmp_path / "trials.csv").write_text(TRIALS + "A,2,20,20,19,21\n")
    (tmp_path / "spikes.csv").write_text(SPIKES + "A,2,19.95\n")
    trials = lgmd.load_trials(tmp_path)
    assert [trial.spikes_ms.tolist() for trial in trials] == [[-100, 100], [-50]]
    assert any("1 rows of the trials appear twice" in remark for remark in trials.remarks)
    assert any("1 spikes appear twice" in remark for remark in trials.remarks)


def test_rows_in_any_order_give_the_same_trials(tmp_path):
    header, *rows = (TIDY + ROWS).splitlines()
    (tmp_path / "sorted.csv").write_text(TIDY + ROWS)
    (tmp_path / "mixed.csv").write_text("\n".join([header, *np.random.default_rng(0).permutation(rows)]))
    assert lgmd.load_trials(tmp_path / "sorted.csv") == lgmd.load_trials(tmp_path / "mixed.csv")


def test_files_that_are_none_of_their_format_are_refused(tmp_path):
    for name, words in {
        "a.mat": "not a Matlab file",
        "a.xlsx": "not an Excel workbook",
        "a.nwb": "not an NWB",
        "a.smr": "Neo",
    }.items():
        (tmp_path / name).write_bytes(b"not what it is called\x00" * 40)
        with pytest.raises(ValueError, match=rf"{name}: .*{words}"):
            lgmd.load_trials(tmp_path / name)


def test_a_matlab_file_of_something_else_is_refused(tmp_path):
    for name, content, words in (
        ("picture", {"image": np.zeros((3, 4)), "name": "x"}, "named like spike times|not trials"),
        ("lengths", {"spikes_s": np.zeros(3), "trial": np.zeros(5)}, r"spikes_s \(3\), trial \(5\)"),
        ("unit", {"spikes": np.array([-0.1, 0.2]), "trial": np.array([1, 2])}, "'spikes', -0.1 to 0.2, have no unit"),
        ("across", {"spikes_ms": MATRIX[:, :2].T, "lv_ms": [20.0, 20.0]}, "'spikes_ms' do not rise; give a row for"),
        ("zeros", {"spikes_ms": np.nan_to_num(MATRIX), "lv_ms": [20.0, 20.0]}, "do not rise.*filled up with NaN"),
        ("raster", {"spikes_ms": np.eye(2, 900), "lv_ms": [20.0, 20.0]}, "do not rise"),
        ("complex", {"spikes_ms": MATRIX + 1j, "lv_ms": [20.0, 20.0]}, "'spikes_ms' of trial 1 is complex"),
        ("gap", {"spikes_ms": MATRIX[:, [0, 4, 1]], "lv_ms": [20.0, 20.0]}, "trial 1: a spike time is not finite"),
    ):
        scipy.io.savemat(tmp_path / f"{name}.mat", content)
        with pytest.raises(ValueError, match=words):
            lgmd.load_trials(tmp_path / f"{name}.mat")


def test_a_matrix_of_a_row_a_trial_is_filled_up_with_nan(tmp_path):
    scipy.io.savemat(tmp_path / "rows.mat", {"spikes_ms": MATRIX, "lv_ms": [20.0, 40.0]})
    trials = lgmd.load_trials(tmp_path / "rows.mat")
    assert [trial.spikes_ms.tolist() for trial in trials] == [[-90.0, -30.0, 5.0], [-80.0, -40.0, -20.0, 10.0]]
    assert [trial.condition["l_over_v"] for trial in trials] == [20.0, 40.0]


def test_a_torn_hdf5_file_of_matlab_is_named(tmp_path):
    (tmp_path / "torn.mat").write_bytes(b"MATLAB 7.3 MAT-file" + bytes(3000))
    with pytest.raises(ValueError, match=r"torn\.mat: this is not a Matlab file"):
        lgmd.load_trials(tmp_path / "torn.mat")


def test_numbers_with_a_decimal_comma_as_text_in_a_workbook(tmp_path):
    book = openpyxl.Workbook()
    cells = [["trial", "l_over_v_ms", "spike_ms"], [1, 20.0, "-80,5"], [1, 20.0, -30.25], [2, 20.0, "12,0"]]
    for row in cells:
        book.active.append(row)  # pyright: ignore[reportOptionalMemberAccess]
    book.save(tmp_path / "comma.xlsx")
    with pytest.raises(ValueError, match=r"'-80,5' in row 1, .* give decimal = ','"):
        lgmd.load_trials(tmp_path / "comma.xlsx")
    trials = lgmd.load_trials(tmp_path / "comma.xlsx", decimal=",")
    assert [trial.spikes_ms.tolist() for trial in trials] == [[-80.5, -30.25], [12.0]]


def test_a_formula_without_its_value_is_no_empty_cell(tmp_path):
    """Such a row would be a trial without a spike."""
    book = openpyxl.Workbook()
    for row in (["trial", "l_over_v_ms", "spike_ms"], [1, 20.0, -80.5], [1, 20.0, "=C2+1"]):
        book.active.append(row)  # pyright: ignore[reportOptionalMemberAccess]
    book.save(tmp_path / "formula.xlsx")
    with pytest.raises(ValueError, match=r"row 3 of the sheet 'Sheet' holds the formula '=C2\+1' without its value"):
        lgmd.load_trials(tmp_path / "formula.xlsx")


def test_an_empty_workbook_is_refused(tmp_path):
    openpyxl.Workbook().save(tmp_path / "empty.xlsx")
    with pytest.raises(ValueError, match="no sheet holds a header and a row"):
        lgmd.load_trials(tmp_path / "empty.xlsx")


def test_several_neurons_or_events_must_be_chosen(tmp_path):
    own = [it for it in recordings("A", trials=1) if it.l_over_v < 30]
    block = synthesis.neo_block(own)
    block.segments[0].spiketrains.append(copy.copy(block.segments[0].spiketrains[0]))
    with pytest.raises(ValueError, match=r"2 units, 'DCMD', 'DCMD'; choose one by unit \(--unit\)"):
        lgmd.load_trials(block)
    synthesis.write_spike2(tmp_path / "A.txt", own)
    with pytest.raises(ValueError, match=r"goes on over 2 events; .* by window \(--window\)"):
        lgmd.load_trials(tmp_path / "A.txt")
    text = (tmp_path / "A.txt").read_text()
    (tmp_path / "B.txt").write_text(text.replace('"collision"', '"mark"'))
    with pytest.raises(ValueError, match=r"titled like a collision; name it by event \(--event\), one of DCMD, mark"):
        lgmd.load_trials(tmp_path / "B.txt", window=WINDOW)


def test_an_nwb_file_without_a_collision_says_how_to_name_it(tmp_path):
    own = recordings("A", trials=1)
    synthesis.write_nwb(tmp_path / "a.nwb", own, event="flash_time")
    with pytest.raises(ValueError, match=r"name it by event \(--event\), one of start_time, stop_time"):
        lgmd.load_trials(tmp_path / "a.nwb")
    assert len(lgmd.load_trials(tmp_path / "a.nwb", event="flash_time")) == len(own)


def test_units_of_one_name_are_told_apart(tmp_path):
    own = recordings("A", trials=1)
    synthesis.write_nwb(tmp_path / "a.nwb", own, units=("DCMD", "DCMD"))
    with pytest.raises(ValueError, match="there are 2 units, '0', '1'; choose one by unit"):
        lgmd.load_trials(tmp_path / "a.nwb")
    first = lgmd.load_trials(tmp_path / "a.nwb", unit="0")
    assert sum(trial.spikes_ms.size for trial in first) == sum(len(trial.spikes) for trial in own)
    block = synthesis.neo_block(own)
    for segment in block.segments:
        segment.spiketrains.append(copy.copy(segment.spiketrains[0]))
    with pytest.raises(ValueError, match="there are 2 units named 'DCMD'; give them names of their own"):
        lgmd.load_trials(block, unit="DCMD")


def test_trials_that_share_no_time_have_no_peak():
    far = tuple(
        lgmd.Trial("A", str(i), {"l_over_v": speed}, np.array([start + 1.0]), start, start + 2.0)
        for speed in (20.0, 40.0)
        for i, start in enumerate((-50.0, 50.0))
    )
    with pytest.raises(ValueError, match="20 ms: there is no time that all trials recorded"):
        lgmd.Trials(far).looming_law()


@pytest.mark.parametrize(("name", "extra"), [("a.xlsx", "excel"), ("a.nwb", "nwb"), ("a.nix", "neo")])
def test_a_missing_extra_is_named(name, extra, tmp_path, monkeypatch):
    (tmp_path / name).write_bytes(b"")
    monkeypatch.setattr("importlib.util.find_spec", lambda package: None)
    with pytest.raises(ValueError, match=rf"pip install 'lgmd2jax\[{extra}\]'"):
        lgmd.load_trials(tmp_path / name)


def test_the_command_says_it_in_one_line_and_writes_nothing(tmp_path, capsys):
    (tmp_path / "spikes.csv").write_text(TIDY.replace("spike_ms", "spike") + ROWS)
    assert main(["looming", str(tmp_path / "spikes.csv"), "--json", str(tmp_path / "law.json")]) == 1
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "--time-unit ms" in said
    assert not (tmp_path / "law.json").exists()
