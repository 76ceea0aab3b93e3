"""Documents with anything in them, some hundreds: `python -m benchmarks.fuzz` tries 20,000, and pictures and clips."""

import pytest

from benchmarks.fuzz import document_kinds, fuzz, picture_kinds


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(
    ("kinds_in", "count"), [(document_kinds, 300), (picture_kinds, 60)], ids=["documents", "pictures"]
)
def test_a_mutant_is_taken_or_refused_in_a_sentence_that_names_its_file(tmp_path, monkeypatch, kinds_in, count):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "whole").mkdir()
    outcomes = fuzz(kinds_in(tmp_path / "whole"), tmp_path / "whole", count)
    assert outcomes.total() == count
    assert {verdict for _, verdict in outcomes} == {"taken", "refused"}
