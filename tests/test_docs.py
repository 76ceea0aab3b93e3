"""The documentation site: what must stand on its pages. `make docs` builds it."""

from collections import Counter

from docs._make.public_names import documented, public_names


def test_every_public_name_stands_in_the_reference_once():
    public, entries = public_names(), documented()
    assert [entry for entry, count in Counter(entries).items() if count > 1] == []
    assert [entry for entry in entries if entry not in public] == []
    shown = {id(public[entry]) for entry in entries}
    assert [name for name, value in public.items() if id(value) not in shown] == []
