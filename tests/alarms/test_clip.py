"""Labels of a clip: which frames count, and what is no label."""

import numpy as np
import pytest

from lgmd2jax.alarms import LabelledClip

FRAMES = np.zeros((20, 3, 4), np.uint8)


def test_labels_count_the_frames_of_the_file_also_where_repeats_were_dropped():
    index = np.array([0, 1, 3, 4, 6, 7, 9])
    clip = LabelledClip.of(
        "c", FRAMES[:7], 21.0, windows=[(3, 5)], silent=[(0, 1), (7, 9)], index=index, time=index * 33.0
    )
    assert clip.in_windows().tolist() == [[False, False, True, True, False, False, False]]
    assert clip.in_silence().tolist() == [True, True, False, False, False, True, True]
    assert clip.silent_minutes == pytest.approx((1000 / 21 + 33 + 33 + 66) / 60_000)  # as the times say


def test_frames_without_a_value_everywhere_are_refused():
    holes = np.zeros((20, 3, 4))
    holes[4, 1, 1] = np.nan
    for frames in (holes, np.ma.masked_invalid(holes)):
        with pytest.raises(ValueError, match="c: frames holds NaN, infinite or masked pixels"):
            LabelledClip.of("c", frames, 20)


@pytest.mark.parametrize(("contact", "ms"), [(10, 500.0), (19, 950.0), (22, 1100.0)])
def test_contact_may_come_after_the_end(contact, ms):
    assert LabelledClip.of("c", FRAMES, 20, contact=contact).contact_ms == pytest.approx(ms)


@pytest.mark.parametrize(
    ("labels", "message"),
    [
        ({"windows": [(5, 3)]}, r"c: alarm 5 to 3 is reversed; write the first frame first"),
        ({"silent": [(5, 20)]}, r"c: silent 5 to 20 lies outside of the clip, whose frames are 0 to 19"),
        ({"windows": [(5, 9)], "silent": [(9, 12)]}, r"c: alarm up to 9 and silent from 9 overlap"),
        ({"windows": [(5, 9), (7, 12)]}, r"alarm up to 9 and alarm from 7 overlap"),
        ({"windows": [(12, 15), (5, 9)], "contact": 4}, r"c: contact is frame 4, before an alarm is wanted, from 5 on"),
        ({"windows": [(5,)]}, r"c: alarm holds \(5,\); write pairs of frames"),
        ({"windows": [(2, 2)], "index": np.arange(0, 40, 2) + (np.arange(20) > 0)}, r"holds only repeated frames"),
    ],
)
@pytest.mark.usefixtures("untyped")
def test_what_is_no_label_is_refused(labels, message):
    with pytest.raises(ValueError, match=message):
        LabelledClip.of("c", FRAMES, 20, **labels)
