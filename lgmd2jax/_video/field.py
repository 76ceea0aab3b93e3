"""Whether the model sees a clip in the field of view of its eye: a film that was held upright has another one."""

from lgmd2jax._eye import Eye
from lgmd2jax._video.clip import Clip

_NEAR = 1.5  # factor of the rows to a column; the usual formats lie as near to each other


def other_field(shape: tuple[int, int], eye: Eye) -> bool:
    """Whether frames of so many rows and columns are far from the shape of an eye's."""
    ratio = shape[0] * eye.cols / (shape[1] * eye.rows)
    return not 1 / _NEAR <= ratio <= _NEAR


def field_remark(clip: Clip, eye: Eye) -> str | None:
    """What to say of a clip in another field than the eye's, with the crop to the middle that mends it."""
    if not other_field(clip.shape, eye):
        return None
    (rows, cols), crop = clip.shape, _crop_to(clip, eye)
    return (
        f"the model sees {rows} x {cols} pixels, but the eye has {eye.rows} x {eye.cols}, and an object fills another "
        f'share of such a field; crop = "{crop}" (--crop {crop}) takes the middle in the shape of the eye'
    )


def _crop_to(clip: Clip, eye: Eye) -> str:
    """The middle of what is used of the picture, in the shape of an eye."""
    ratio = clip.shape[0] * eye.cols / (clip.shape[1] * eye.rows)
    lengths = []
    for part, edge, excess in zip(clip.window, clip.size, (ratio, 1 / ratio), strict=True):
        first, end, _ = part.indices(edge)
        margin = round((end - first) * (1 - 1 / excess) / 2) if excess > 1 else 0
        lengths.append(f"{first + margin}:{end - margin}")
    return ",".join(lengths)
