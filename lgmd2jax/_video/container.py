"""Files and streams as PyAV opens them, whatever the encoding of their titles."""

from typing import Any


def open_container(place: str, **settings: Any) -> Any:
    """`av.open` for reading, with its settings and errors; titles that are not UTF-8 have their odd letters replaced.

    Before its release 19 PyAV refused such a file, of which older cameras write many, unless told not to; since then it
    replaces them by itself and does not take the setting.
    """
    import av

    if int(av.__version__.split(".")[0]) < 19:
        settings["metadata_errors"] = "replace"
    return av.open(place, **settings)
