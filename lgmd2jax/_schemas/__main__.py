"""`python -m lgmd2jax._schemas` writes the schemas anew as JSON, for editors and for other programs."""

import json
from pathlib import Path
from typing import Any

from lgmd2jax._schemas.fit import FIT
from lgmd2jax._schemas.labels import LABELS
from lgmd2jax._schemas.model_file import MODEL_FILE
from lgmd2jax._schemas.protocol import PROTOCOL
from lgmd2jax._schemas.recipes import RECIPE

FOLDER = Path(__file__).parents[1] / "schemas"
SCHEMAS = {"protocol": PROTOCOL, "recipe": RECIPE, "labels": LABELS, "model": MODEL_FILE, "fit": FIT}


def published(name: str) -> str:
    """The text of a JSON Schema."""
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": f"lgmd2jax {name}"}
    content = _plain(SCHEMAS[name].json_schema())
    return json.dumps(head | {key: value for key, value in content.items() if key != "title"}, indent=1) + "\n"


def _plain(schema: Any) -> Any:
    """Without what pydantic makes of our names, and without defaults, which the documents' readers have."""
    if isinstance(schema, list):
        return [_plain(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    kept = {key: _plain(value) for key, value in schema.items() if not (key == "title" and isinstance(value, str))}
    return {key: value for key, value in kept.items() if not (key == "default" and value is None)}


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for each in SCHEMAS:
        (FOLDER / f"{each}.json").write_text(published(each), encoding="utf-8")
        print(FOLDER / f"{each}.json")
