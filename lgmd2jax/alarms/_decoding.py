"""Clips decoded once: grey and small, kept in the user's cache for the next fit."""

import dataclasses
import hashlib
from pathlib import Path

import numpy as np
from jaxtyping import Float, Float32, Int
from platformdirs import user_cache_path

from lgmd2jax._files.atomic import replaced
from lgmd2jax._video.clip import Clip


@dataclasses.dataclass(frozen=True)
class DecodedClip:
    """The frames of a clip without repeated ones, with the place in the file and the time in ms of each."""

    frames: Float32[np.ndarray, "time row col"]
    index: Int[np.ndarray, " time"]
    time: Float[np.ndarray, " time"]
    fps: float

    def time_of(self, frame: int) -> float:
        """When a frame of the file is shown, in ms."""
        return float(np.interp(frame, self.index, self.time))

    def frame_at(self, time: float) -> int:
        """The frame of the file that is nearest to a time, within the clip."""
        return round(float(np.interp(time, self.time, self.index)))


def decode(clip: Clip, path: Path, drop_duplicates: bool) -> DecodedClip:
    """Read the frames of a clip, from the cache where the same file was read in the same way before."""
    cached = user_cache_path("lgmd2jax") / "clips" / f"{_digest(clip, path, drop_duplicates)}.npz"
    if cached.is_file():
        with np.load(cached) as kept:
            return DecodedClip(kept["frames"], kept["index"], kept["time"], float(kept["fps"]))
    clip = clip.without_repeats() if drop_duplicates else clip
    frames = [frame for frame in clip if not frame.repeated]
    result = DecodedClip(
        frames=np.stack([frame.grey for frame in frames]).astype(np.float32),
        index=np.array([frame.index for frame in frames]),
        time=np.array([frame.time for frame in frames], float),
        fps=clip.effective_fps,
    )
    cached.parent.mkdir(parents=True, exist_ok=True)
    with replaced(cached) as temporary:
        np.savez(temporary, **dataclasses.asdict(result))
    return result


def _digest(clip: Clip, path: Path, drop_duplicates: bool) -> str:
    """Of all that the frames depend on. A folder counts by the pictures in it."""
    files = sorted(path.iterdir()) if path.is_dir() else [path]
    stamps = [(file.name, file.stat().st_size, file.stat().st_mtime_ns) for file in files]
    settings = clip.fps, clip.told, clip.window, clip.shape, drop_duplicates
    return hashlib.sha256(repr((str(path.resolve()), stamps, settings)).encode()).hexdigest()[:32]
