"""A stimulus as a video for a laboratory's display: its frame rate, its gamma, and a patch for the photodiode."""

import os
from fractions import Fraction

import numpy as np
from jaxtyping import UInt8

from lgmd2jax._arguments.checked import checked
from lgmd2jax._files.atomic import replaced
from lgmd2jax._pyav import pyav
from lgmd2jax.stimuli import Stimulus

_PATCH = 0.08  # of the picture's height, at least two pixels


@checked
def save_display_video(
    stimulus: Stimulus,
    path: str | os.PathLike,
    *,
    fps: float | int | None = None,
    gamma: float | int = 2.2,
    scale: int = 8,
    patch: bool = True,
) -> None:
    """Write a stimulus as it is to be played on a display, without loss, in 8 bits.

    Grey levels stand for luminance, 255 for the display's white; the file holds the display's values,
    255 (level/255)^(1/gamma). A frame of the display shows the last frame of the stimulus before it. In a corner, below
    left, a patch for the photodiode is white in every other frame of the display, and black in between, so that the
    recording tells when each frame was shown; it covers what the stimulus shows there, and is to be
    covered for the animal.

    **Arguments:**

    - `path`: of the file, .mkv for one without loss; .mp4 is also possible.
    - `fps`: of the display, by default the stimulus's own.
    - `gamma`: of the display, measured; 1 for one that was linearised.
    - `scale`: pixels of the display along the side of a pixel of the stimulus.
    - `patch`: whether there is one.

    **Raises:** `ValueError` without the extra `video`, for numbers that are not positive, and for another suffix.
    """
    for name, value in (("fps", fps), ("gamma", gamma), ("scale", scale)):
        if value is not None and not value > 0:
            raise ValueError(f"{name} is {value}; give a positive number")
    if os.path.splitext(path)[1].lower() not in (".mkv", ".mp4"):
        raise ValueError(f"cannot write {path}; end its name in .mkv or .mp4")
    av = pyav("writing video needs")
    pictures, rate = display_frames(stimulus, fps, gamma), float(stimulus.fps if fps is None else fps)
    side = max(round(_PATCH * pictures.shape[1]), 2)
    with replaced(path) as temporary, av.open(os.fspath(temporary), "w") as container:
        stream = container.add_stream("libx264rgb", rate=Fraction(rate).limit_denominator(1001), options={"crf": "0"})
        stream.pix_fmt = "rgb24"
        stream.height, stream.width = (size * scale for size in pictures.shape[1:])
        for number, picture in enumerate(pictures):
            picture = picture.copy()
            if patch:
                picture[-side:, :side] = 255 * (number % 2 == 0)
            large = np.kron(picture, np.ones((scale, scale), np.uint8))
            frame = av.VideoFrame.from_ndarray(np.repeat(large[..., None], 3, axis=2), format="rgb24")
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))


def display_frames(
    stimulus: Stimulus, fps: float | int | None = None, gamma: float | int = 2.2
) -> UInt8[np.ndarray, "time row col"]:
    """What a display shows, in its own values: the stimulus at the times of its frames, held in between."""
    time, frames = np.asarray(stimulus.time, float), np.asarray(stimulus.frames, float)
    if fps is not None:
        count = int((time[-1] - time[0]) * fps / 1000 + 1 + 1e-6)
        shown = time[0] + 1000 / fps * np.arange(count)
        frames = frames[np.searchsorted(time, shown + 1e-6, side="right") - 1]
    return np.rint(255 * (np.clip(frames, 0, 255) / 255) ** (1 / gamma)).astype(np.uint8)


def luminance_of(pictures: UInt8[np.ndarray, "time row col"], gamma: float | int = 2.2) -> np.ndarray:
    """The grey levels, by luminance, of what a display shows."""
    return 255 * (pictures / 255) ** gamma
