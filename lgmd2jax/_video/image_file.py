"""An image file as pixels: any depth, colour mode and number of pages, as the file means them."""

import contextlib
import re
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import tifffile
from PIL import Image, ImageFile

from lgmd2jax._pyav import open_container, pyav
from lgmd2jax._video.image_pixels import ImagePixels, remarks_on_depth
from lgmd2jax._video.orientation import Orientation

TIFF = (".tif", ".tiff")
NETPBM = (".pgm", ".ppm", ".pnm")
PAGED = (*TIFF, *NETPBM, ".png", ".webp")  # formats that may hold several pictures
SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".pbm", ".webp", *NETPBM, *TIFF)

_ORIENTATION, _LARGEST_VALUE = 274, 281  # tags of EXIF and TIFF
_REDUCED, _MASK = 1, 4  # bits of TIFF's NewSubfileType
# What the libraries raise for damaged files.
_DAMAGE = (OSError, SyntaxError, ValueError, LookupError, ArithmeticError, TypeError, RuntimeError, MemoryError)
_DAMAGE += (zlib.error, struct.error, Image.DecompressionBombError)


class _Raw(NamedTuple):
    """Values as stored, with the range of their format; None where the format states none."""

    values: np.ndarray
    full: float | None
    alpha: np.ndarray | None = None  # 0 to 1
    orientation: Orientation = Orientation()


def read_image(path: Path, white: float | int | None = None) -> Iterator[ImagePixels]:
    """The pages of an image file; most have one.

    **Arguments:** `white`: the value that is white, by default the largest that the format can hold.

    **Raises:** `ValueError` that names the file, for what is no image, and for values whose white level is unknown.
    """
    suffix = path.suffix.lower()
    try:
        read = _tiff if suffix in TIFF else _netpbm if suffix in NETPBM else _pillow
        for raw in read(path):
            yield _pixels(raw, white)
    except _DAMAGE as error:
        raise ValueError(f"cannot read {path} as an image: {error}") from error


def _pixels(raw: _Raw, white: float | int | None) -> ImagePixels:
    values, remarks = raw.values, []
    if values.dtype.kind == "f" and not np.isfinite(values).all():
        raise ValueError("it holds NaN or infinite pixels; fill them first")
    if values.min() < 0:
        raise ValueError(f"it holds negative values, down to {values.min():g}; black is 0, so shift them first")
    if white is None and raw.full is None:
        raise ValueError(
            f"it holds {values.dtype.name} values, up to {values.max():g}, and no format says which of them is white; "
            "give it: white = 1.0 (--white 1)"
        )
    if white is not None and raw.full is not None and white > raw.full:
        raise ValueError(f"white is {white:g}, but its values end at {raw.full:g}")
    level = float(raw.full if white is None else white)  # pyright: ignore[reportArgumentType]
    if values.max() > level:
        bound = f"white = {white:g}; give the camera's largest value" if white else f"its own white of {level:g}"
        raise ValueError(f"it holds {values.max():g}, above {bound}")
    remarks.extend(remarks_on_depth(float(values.max()), raw.full or 0, white))
    if raw.alpha is not None and (raw.alpha < 1).any():
        remarks.append("it is transparent in places, and is shown on white")
        cover = raw.alpha if values.ndim == 2 else raw.alpha[..., None]
        values = values * cover + np.float32(level) * (1 - cover)
    return ImagePixels(raw.orientation.shown(values), level, tuple(remarks))


def _pillow(path: Path) -> Iterator[_Raw]:
    """What Pillow reads as it is stored, or as colours of 8 bits."""
    with Image.open(path) as image:
        # The further pictures of an MPO are previews and gain maps.
        for page in range(1 if image.format == "MPO" else getattr(image, "n_frames", 1)):
            yield _pillow_page(image, page, path)


def _pillow_page(image: ImageFile.ImageFile, page: int, path: Path) -> _Raw:
    image.seek(page)
    stored = str(image.tile[0][3]) if image.tile else ""
    if ";16" in stored and not image.mode.startswith("I"):
        return _deep_colours(path)
    image.load()  # turns a TIFF, and then drops its tag
    orientation = Orientation.of_exif(image.getexif().get(_ORIENTATION, 1))
    if image.mode.startswith("I"):
        return _Raw(np.asarray(image), 65535.0, None, orientation)
    if image.mode in ("1", "L") and "transparency" not in image.info:
        return _Raw(np.asarray(image.convert("L")), 255.0, None, orientation)
    if image.mode == "F":
        return _Raw(np.asarray(image), None, None, orientation)
    if image.mode == "LAB":
        raise ValueError("its colours are CIELAB; save it as RGB or grey")
    if image.has_transparency_data:
        colours = np.asarray(image.convert("RGBA"))
        return _Raw(colours[..., :3], 255.0, colours[..., 3].astype(np.float32) / 255, orientation)
    return _Raw(np.asarray(image.convert("RGB")), 255.0, None, orientation)


def _deep_colours(path: Path) -> _Raw:
    """A PNG of 16 bits a colour, which Pillow would cut to 8."""
    if path.suffix.lower() in TIFF:
        raise ValueError("its 16-bit colours are compressed; save it without compression")
    av = pyav("16-bit colours need")
    try:
        with open_container(av, f"file:{path}") as container:
            values = next(container.decode(video=0)).to_ndarray(format="rgba64le")
    except (av.error.FFmpegError, StopIteration) as error:
        raise ValueError(f"{error}") from error
    return _Raw(values[..., :3], 65535.0, values[..., 3].astype(np.float32) / 65535)


def _netpbm(path: Path) -> Iterator[_Raw]:
    """Portable grey and colour maps, which state their own white; a file may hold several."""
    data, place = path.read_bytes(), 0
    gap = rb"(?:\s|#[^\n]*\n)+"
    header = re.compile(rb"\s*P([2356])" + gap + rb"(\d+)" + gap + rb"(\d+)" + gap + rb"(\d+)\s")
    if not header.match(data):
        yield from _pillow(path)
        return
    while match := header.match(data, place):
        kind, cols, rows, full = map(int, match.groups())
        shape = (rows, cols, 3) if kind in (3, 6) else (rows, cols)
        count, place = int(np.prod(shape)), match.end()
        if kind in (2, 3):
            values, place = np.array(re.sub(rb"#[^\n]*", b"", data[place:]).split(), np.uint16), len(data)
        else:
            dtype = np.dtype(">u2" if full > 255 else np.uint8)
            values = np.frombuffer(data[place : place + count * dtype.itemsize], dtype)
            place += count * dtype.itemsize
        if len(values) != count or not 0 < full < 65536 or count == 0:
            raise ValueError(f"it announces {rows} x {cols} pixels and holds {len(values)} values; it is truncated")
        yield _Raw(values.reshape(shape), float(full))
    if data[place:].strip():
        raise ValueError("something else follows its last picture; it is damaged")


def _tiff(path: Path) -> Iterator[_Raw]:
    """The pages of a TIFF file in order, without previews and masks."""
    with contextlib.ExitStack() as stack:
        tiff, image = stack.enter_context(tifffile.TiffFile(path)), None
        _check_axes(tiff)
        if (tiff.imagej_metadata or {}).get("images", 1) > len(
            tiff.pages
        ):  # ImageJ describes the first page alone in large files
            for values in tifffile.memmap(path, mode="r"):
                yield _Raw(np.asarray(values), _full(tiff.pages[0].aspage()))
            return
        for number in range(len(tiff.pages)):
            page = tiff.pages[number].aspage()
            if page.subfiletype & (_REDUCED | _MASK):
                continue
            if _is_plain(page):
                yield _tiff_page(page)
            else:
                image = image or stack.enter_context(Image.open(path))
                yield _packed_page(page, _pillow_page(image, number, path))


def _check_axes(tiff: tifffile.TiffFile) -> None:
    series = tiff.series[0]
    extra = {axis: length for axis, length in zip(series.axes, series.shape, strict=True) if axis not in "YXS"}
    long = {axis: length for axis, length in extra.items() if length > 1}
    if len(long) > 1 or long.keys() & {"C"}:
        sizes = " x ".join(f"{length} ({axis})" for axis, length in long.items())
        raise ValueError(f"it holds {sizes} pages of channels, planes and times; save one channel, a page a frame")


def _is_plain(page: tifffile.TiffPage) -> bool:
    """Whether tifffile reads the values without further packages, and they are grey or RGB."""
    grey_or_rgb = page.photometric in (
        tifffile.PHOTOMETRIC.MINISWHITE,
        tifffile.PHOTOMETRIC.MINISBLACK,
        tifffile.PHOTOMETRIC.RGB,
    )
    known = tifffile.COMPRESSION.NONE, tifffile.COMPRESSION.ADOBE_DEFLATE, tifffile.COMPRESSION.DEFLATE
    return grey_or_rgb and page.compression in known and page.bitspersample in (8, 16, 32, 64) and page.predictor == 1


def _tiff_page(page: tifffile.TiffPage) -> _Raw:
    values, full, alpha = page.asarray().squeeze(), _full(page), None
    if page.samplesperpixel > 1:
        if page.planarconfig == tifffile.PLANARCONFIG.SEPARATE:
            values = np.moveaxis(values, 0, -1)
        colours = 3 if page.photometric == tifffile.PHOTOMETRIC.RGB else 1
        if page.extrasamples and page.extrasamples[0] != tifffile.EXTRASAMPLE.UNSPECIFIED:
            alpha = values[..., colours].astype(np.float32) / np.float32(full or 1.0)
        values = values[..., :colours].squeeze()
    if page.photometric == tifffile.PHOTOMETRIC.MINISWHITE:
        values = _from_white(values, full)
    tag = page.tags.get(_ORIENTATION)
    return _Raw(values, full, alpha, Orientation.of_exif(int(tag.value) if tag else 1))


def _packed_page(page: tifffile.TiffPage, raw: _Raw) -> _Raw:
    """A page that Pillow had to unpack, with the range that its tags state."""
    if raw.values.dtype.itemsize == 1:
        return raw
    full = _full(page)
    if page.photometric == tifffile.PHOTOMETRIC.MINISWHITE:
        raw = raw._replace(values=_from_white(raw.values, full))
    return raw._replace(full=full)


def _from_white(values: np.ndarray, full: float | None) -> np.ndarray:
    if full is None:
        raise ValueError("its 0 is white, and no format says what is black; save it with 0 for black")
    return values.dtype.type(full) - values


def _full(page: tifffile.TiffPage) -> float | None:
    """The largest value of whole numbers of up to 16 bits, or the camera's own, where a tag states a depth."""
    bits, kind = page.bitspersample, page.sampleformat
    if bits > 16 or kind not in (tifffile.SAMPLEFORMAT.UINT, tifffile.SAMPLEFORMAT.INT):
        return None
    full = 2 ** (bits - (kind == tifffile.SAMPLEFORMAT.INT)) - 1
    tag = page.tags.get(_LARGEST_VALUE)
    stated = int(np.max(tag.value)) if tag else full
    # Some writers put the picture's own largest value there; a depth is one below a power of two.
    return float(stated if 255 < stated < full and stated & (stated + 1) == 0 else full)
