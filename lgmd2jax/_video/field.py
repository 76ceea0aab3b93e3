"""Whether the model sees a clip in the field of view of its eye: a film that was held upright has another one."""

from lgmd2jax._eye import Eye
from lgmd2jax._video.orientation import Window

_NEAR = 1.5  # factor of the rows to a column; the usual formats lie as near to each other


def other_field(shape: tuple[int, int], eye: Eye) -> bool:
    """Whether frames of so many rows and columns are far from the shape of an eye's."""
    ratio = shape[0] * eye.cols / (shape[1] * eye.rows)
    return not 1 / _NEAR <= ratio <= _NEAR


def field_remark(size: tuple[int, int], window: Window, shape: tuple[int, int], eye: Eye | None) -> str | None:
    """What to say of a picture that is seen in another field than the eye's, with the crop to the middle that mends it.

    **Arguments:** `size`: of the picture. `window`: what is used of it. `shape`: what the model sees of that.
    """
    if eye is None or not other_field(shape, eye):
        return None
    (rows, cols), crop = shape, _crop_to(size, window, shape, eye)
    return (
        f"the model sees {rows} x {cols} pixels, but the eye has {eye.rows} x {eye.cols}, and an object fills another "
        f'share of such a field; crop = "{crop}" (--crop {crop}) takes the middle in the shape of the eye'
    )


def _crop_to(size: tuple[int, int], window: Window, shape: tuple[int, int], eye: Eye) -> str:
    """The middle of what is used of the picture, in the shape of an eye."""
    ratio = shape[0] * eye.cols / (shape[1] * eye.rows)
    lengths = []
    for part, edge, excess in zip(window, size, (ratio, 1 / ratio), strict=True):
        first, end, _ = part.indices(edge)
        margin = round((end - first) * (1 - 1 / excess) / 2) if excess > 1 else 0
        lengths.append(f"{first + margin}:{end - margin}")
    return ",".join(lengths)
