"""The published JSON Schemas: as the readers check, and every shipped document fits its own."""

import json
import tomllib

import jsonschema
import pytest

from lgmd2jax._files.catalogue import folder
from lgmd2jax._schemas.__main__ import FOLDER, SCHEMAS, published
from lgmd2jax._schemas.check import check

SHIPPED = [
    *(("recipe", path) for path in folder("fits").glob("*.toml")),
    *(("labels" if path.stem in ("video", "crash") else "protocol", path) for path in folder("stimuli").glob("*.toml")),
    *(("model", path) for path in folder("fits").glob("*/model.json")),
    *(("fit", path) for path in folder("fits").glob("*/fit.json") if path.parent.name != "video"),  # that is of alarms
]


@pytest.mark.parametrize("name", SCHEMAS)
def test_what_is_published_is_what_is_checked(name):
    """Where this fails: python -m lgmd2jax._schemas"""
    assert (FOLDER / f"{name}.json").read_text(encoding="utf-8") == published(name)


@pytest.mark.parametrize(("name", "path"), [pair for pair in SHIPPED if pair[1].suffix == ".toml"])
def test_the_first_line_tells_an_editor_the_schema(name, path):
    first = path.read_text(encoding="utf-8").partition("\n")[0]
    assert first == f"#:schema ../lgmd2jax/schemas/{name}.json"


@pytest.mark.parametrize(("name", "path"), SHIPPED, ids=lambda value: getattr(value, "name", value))
def test_every_shipped_document_fits_both(name, path):
    text = path.read_text(encoding="utf-8")
    document = tomllib.loads(text) if path.suffix == ".toml" else json.loads(text)
    check(SCHEMAS[name], document)
    jsonschema.validate(document, json.loads(published(name)))
    document["another"] = 1
    if name != "fit":  # whose notes are free
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(document, json.loads(published(name)))
