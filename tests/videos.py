"""Small video files and folders of images for tests."""

from fractions import Fraction

import imageio.v3 as iio
import numpy as np
import pytest


def noise(count, shape=(24, 33), seed=0):
    return np.random.default_rng(seed).integers(0, 256, (count, *shape, 3), dtype=np.uint8)


def loom(count, half_size, contact):
    """A dark disc that grows up to `contact` and stays: its half-size in pixels times frames to go."""
    rows, cols = 32, 48
    y, x = np.mgrid[:rows, :cols]
    radius = half_size / np.maximum(contact - np.arange(count), 2)
    discs = np.hypot(y - rows / 2, x - cols / 2) <= radius[:, None, None]
    return np.repeat(np.where(discs, 20, 220).astype(np.uint8)[..., None], 3, -1)


def write_video(
    path,
    pictures,
    codec="ffv1",
    pixels="bgr0",
    stamps_ms=None,
    rotation=0,
    rate=30,
    given="rgb24",
    setup=None,
    **options,
):
    """Lossless by default, with a time stamp each if they are given.

    `given`: the format of the pictures. `setup`: called with the stream before the first frame.
    """
    av = pytest.importorskip("av", reason="video needs the extra 'video'")
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=rate, options=options)
        stream.height, stream.width = pictures[0].shape[:2]
        stream.pix_fmt = pixels
        if rotation:
            if not hasattr(stream, "set_display_rotation"):
                pytest.skip("this version of PyAV reads rotated video but cannot write it")
            stream.set_display_rotation(rotation)
        if setup:
            setup(stream)
        for i, picture in enumerate(pictures):
            frame = av.VideoFrame.from_ndarray(picture, format=given)
            if stamps_ms is not None:
                stream.codec_context.time_base = frame.time_base = Fraction(1, 1000)
                frame.pts = int(stamps_ms[i])
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path


def write_folder(folder, pictures, name="{}.png"):
    folder.mkdir()
    for i, picture in enumerate(pictures):
        iio.imwrite(folder / name.format(i), picture)
    return folder


def damaged(path, share=0.6):
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    return path


def conversion(source, target, count):
    """The source frame that is shown in each frame when `source` fps are converted to `target` fps."""
    return np.arange(count) * source // target
