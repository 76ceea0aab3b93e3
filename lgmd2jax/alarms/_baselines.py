"""Plain detectors of approach to compare a model with: each gives a number a frame, and alarms above a threshold."""

import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from jaxtyping import Float

from lgmd2jax._compute.cluster import need
from lgmd2jax.alarms._clip import LabelledClip
from lgmd2jax.alarms._evaluation import Evaluation

_AVERAGE_MS = 150.0  # about as long as an alarm of the model counts spikes


def check_packages() -> None:
    """Raise `ValueError` where the package that the flow needs is not installed: before clips are decoded."""
    need("cv2", extra="baselines")


def difference(clip: LabelledClip) -> Float[np.ndarray, " time"]:
    """The mean absolute change of grey level since the frame before."""
    frames = clip.frames.astype(np.float32)
    change = np.abs(np.diff(frames, axis=0)).mean(axis=(1, 2))
    return np.concatenate([[0.0], change.astype(float)])


def divergence(clip: LabelledClip) -> Float[np.ndarray, " time"]:
    """The largest divergence of Farneback's optical flow, in 1/s, as the mean over a square of a third of the rows.

    An object at whose image this is d fills the view in about 2/d seconds.

    **Raises:** `ValueError` where OpenCV is missing.
    """
    check_packages()
    import cv2

    frames = np.round(clip.frames).clip(0, 255).astype(np.uint8)
    side = max(3, frames.shape[1] // 3)
    largest, flow = [0.0], np.zeros((*frames.shape[1:], 2), np.float32)
    for before, now, interval in zip(frames, frames[1:], clip.interval[1:], strict=False):
        flow = cv2.calcOpticalFlowFarneback(before, now, flow, 0.5, 3, 9, 3, 5, 1.1, 0)
        expansion = np.gradient(flow[..., 0], axis=1) + np.gradient(flow[..., 1], axis=0)
        largest.append(float(cv2.blur(expansion, (side, side)).max()) * 1000 / interval)
    return np.array(largest)


BASELINES: Mapping[str, Callable[[LabelledClip], Float[np.ndarray, " time"]]] = {
    "difference": difference,
    "divergence": divergence,
}


def baseline(name: str, clips: Sequence[LabelledClip]) -> Evaluation:
    """One of the `BASELINES` on clips, averaged over the last 150 ms; it has no threshold of its own.

    **Raises:** `ValueError` where a package that it needs is missing.
    """
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        traces = pool.map(BASELINES[name], clips)
        averages = tuple(_average(trace, clip.time) for trace, clip in zip(traces, clips, strict=True))
    return Evaluation(tuple(clips), averages, np.inf)


def _average(trace: Float[np.ndarray, " time"], time: Float[np.ndarray, " time"]) -> Float[np.ndarray, " time"]:
    """The mean over the frames of the last 150 ms."""
    first = np.searchsorted(time, time - _AVERAGE_MS, side="right")
    total = np.concatenate([[0.0], np.cumsum(trace)])
    now = np.arange(1, len(total))
    return (total[now] - total[first]) / (now - first)
