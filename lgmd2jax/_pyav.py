"""PyAV, which is an extra, and files and streams as it opens them for reading."""

from typing import Any


def pyav(what: str, extra: str = "video") -> Any:
    """PyAV, the module `av`.

    **Raises:** `ValueError` where it is not installed, which says `what` needs it, such as `"reading video needs"`, and
    in which extra it comes.
    """
    try:
        import av
    except ImportError:
        raise ValueError(f"{what} PyAV: pip install 'lgmd2jax[{extra}]'") from None
    return av


def open_container(av: Any, place: str, **settings: Any) -> Any:
    """`av.open` for reading, with its settings and errors; titles that are not UTF-8 have their odd letters replaced.

    Before its release 19 PyAV refused such a file, of which older cameras write many, unless told not to; since then it
    replaces them by itself and does not take the setting.
    """
    if int(av.__version__.split(".")[0]) < 19:
        settings["metadata_errors"] = "replace"
    return av.open(place, **settings)
