"""The shipped protocols, recipes and fits: found by a bare name, in a clone and in an installed wheel."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from lgmd2jax._files.atomic import read_toml
from lgmd2jax._words import nearest, within

Content = TypeVar("Content")
_PACKAGE = Path(__file__).parents[1]


def folder(kind: str) -> Path:
    """The folder of what is shipped: `"stimuli"` or `"fits"`. The wheel carries both; a clone has them at its root."""
    carried = _PACKAGE / "catalogue" / kind
    return carried if carried.is_dir() else _PACKAGE.parent / kind


def locate(name: str | Path, kind: str, suffix: str = ".toml") -> Path:
    """The file that is named by its path or, where it is shipped, by its bare name.

    **Arguments:**

    - `name`: a path, or the bare name of something shipped, such as `"looming"`; the path of a result folder where
      `suffix` names a file in one.
    - `kind`: the catalogue's folder, `"stimuli"` or `"fits"`.
    - `suffix`: what follows the bare name within that folder; `"/model.json"` finds the model in a result folder.

    **Raises:** `FileNotFoundError` that names what is shipped, the likeliest first.
    """
    path = Path(name)
    if path.is_file():
        return path
    bare = str(name)
    if path.name == bare:
        shipped = folder(kind) / f"{bare}{suffix}"
        if shipped.is_file():
            return shipped
    if suffix.startswith("/") and (path / suffix[1:]).is_file():
        return path / suffix[1:]
    if path.is_dir() and suffix.startswith("/"):
        there = sorted(str(file.parent) for file in path.glob(f"*{suffix}"))
        raise FileNotFoundError(f"{bare} holds no {suffix[1:]}" + (f"; choose {nearest(bare, there)}" if there else ""))
    if path.is_dir():
        raise FileNotFoundError(f"{bare} is a folder; give a file")
    shipped = (file.relative_to(folder(kind)).as_posix() for file in folder(kind).glob(f"*{suffix}"))
    known = nearest(bare, [file.removesuffix(suffix) for file in shipped])
    raise FileNotFoundError(f"no such file: {bare}" + (f"; by name there is {known}" if known else ""))


def read_named(name: str | Path, kind: str, content: Callable[[Path, dict[str, Any]], Content]) -> Content:
    """What `content` makes of the path and the tables of a TOML file that is named as for `locate`.

    **Raises:** `FileNotFoundError`; `ValueError` that names the file, for what is not TOML or not such a file.
    """
    path = locate(name, kind)
    table = read_toml(path)
    with within(str(path)):
        return content(path, table)


def beside(path: Path, name: str) -> Path | str:
    """What a file names: another one that lies beside it, else what is found by the name itself."""
    place = path.parent / name
    return place if place.is_file() else name


def results_folder(name: str | Path, output: str | Path | None = None) -> Path:
    """Where results go: `output`, else beside the file that was named, else (a shipped one) the current folder."""
    if output is not None:
        return Path(output)
    return Path(name).parent if Path(name).is_file() else Path()
