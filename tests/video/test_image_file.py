"""Image files: values at their depth, colour modes, pages, and what no picture can be made of."""

import numpy as np
import pytest
import tifffile
from PIL import Image

from lgmd2jax._video.clip import open_clip
from lgmd2jax._video.image_file import read_image
from lgmd2jax._video.remarks import ClipWarning

ALL = np.s_[:, :]


def greys(path, white=None):
    """The grey levels of each page."""
    return [pixels.grey(ALL, pixels.size) for pixels in read_image(path, white)]


def ramp(dtype, top):
    return np.linspace(0, top, 20).round().reshape(4, 5).astype(dtype)


# Depth


def test_16_bits_count_from_0_to_65535_whatever_a_picture_holds(tmp_path):
    for value in (60000, 30000, 10000, 1000, 257, 255, 200, 100, 1, 0):
        Image.fromarray(np.full((3, 4), value, np.uint16)).save(tmp_path / "x.png")
        tifffile.imwrite(tmp_path / "x.tif", np.full((3, 4), value, np.uint16))
        for name in ("x.png", "x.tif"):
            np.testing.assert_allclose(greys(tmp_path / name)[0], value / 257, rtol=1e-6)


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("compression", [None, "zlib"])
@pytest.mark.parametrize("colours", [1, 3])
def test_a_tiff_of_either_byte_order_is_read(tmp_path, order, compression, colours):
    values = ramp(np.uint16, 65000) if colours == 1 else np.stack([ramp(np.uint16, top) for top in (9e3, 6e4, 3e4)], -1)
    tifffile.imwrite(tmp_path / "x.tif", values, byteorder=order, compression=compression)
    expected = values / 257 if colours == 1 else values / 257 @ [0.299, 0.587, 0.114]
    np.testing.assert_allclose(greys(tmp_path / "x.tif")[0], expected, rtol=1e-5, atol=1e-4)


def test_pillow_reads_the_compressed_ones(tmp_path):
    Image.fromarray(ramp(np.uint16, 65000)).save(tmp_path / "x.tif", compression="tiff_lzw")
    np.testing.assert_allclose(greys(tmp_path / "x.tif")[0], ramp(np.uint16, 65000) / 257, rtol=1e-5)


@pytest.mark.parametrize(("kind", "maxval"), [(b"5", 4095), (b"5", 255), (b"5", 15), (b"6", 4095), (b"2", 4095)])
def test_netpbm_states_its_own_white(tmp_path, kind, maxval):
    values = ramp(np.uint16, maxval)
    shown = np.stack([values] * 3, -1) if kind == b"6" else values
    body = (
        " ".join(map(str, values.ravel())).encode()
        if kind == b"2"
        else shown.astype(">u2" if maxval > 255 else np.uint8).tobytes()
    )
    (tmp_path / "x.pnm").write_bytes(b"P" + kind + b"\n# a camera\n5 4\n%d\n" % maxval + body)
    np.testing.assert_allclose(greys(tmp_path / "x.pnm")[0], values * (255 / maxval), rtol=1e-5, atol=1e-4)
    np.testing.assert_allclose(greys(tmp_path / "x.pnm", white=maxval)[0], greys(tmp_path / "x.pnm")[0])


def test_a_netpbm_file_of_several_pictures_has_as_many_frames_and_none_may_be_cut(tmp_path):
    one = b"P5 3 3 255\n" + bytes(range(9))
    (tmp_path / "x.pgm").write_bytes(one + one)
    assert len(greys(tmp_path / "x.pgm")) == 2
    (tmp_path / "x.pgm").write_bytes(one + one[:-2])
    with pytest.raises(ValueError, match=r"x\.pgm as an image: .* 3 x 3 pixels and holds 7 values"):
        greys(tmp_path / "x.pgm")


def test_16_bit_colours_of_a_png_keep_their_depth(tmp_path):
    av = pytest.importorskip("av", reason="16-bit colours need the extra 'video'")
    values = np.stack([ramp(np.uint16, top) for top in (4000, 2000, 1000)], -1)
    with av.open(str(tmp_path / "x.png"), "w", format="image2") as container:
        stream = container.add_stream("png", width=5, height=4, pix_fmt="rgb48be")
        container.mux(stream.encode(av.VideoFrame.from_ndarray(values, format="rgb48le")))
        container.mux(stream.encode(None))
    expected = values @ [0.299, 0.587, 0.114]
    np.testing.assert_allclose(greys(tmp_path / "x.png")[0], expected / 257, rtol=1e-5)
    np.testing.assert_allclose(greys(tmp_path / "x.png", white=4000)[0], expected * 255 / 4000, rtol=1e-5)


def test_a_white_level_is_told_or_stated_by_a_tag(tmp_path):
    values = ramp(np.uint16, 4095)
    tifffile.imwrite(tmp_path / "x.tif", values)
    np.testing.assert_allclose(greys(tmp_path / "x.tif", white=4095)[0], values * (255 / 4095), rtol=1e-5)
    tifffile.imwrite(tmp_path / "x.tif", values, extratags=[(281, "H", 1, 4095, True)])
    np.testing.assert_allclose(greys(tmp_path / "x.tif")[0], values * (255 / 4095), rtol=1e-5)
    # The largest value of the picture itself is no depth.
    tifffile.imwrite(tmp_path / "x.tif", values, extratags=[(281, "H", 1, 4000, True)])
    np.testing.assert_allclose(greys(tmp_path / "x.tif")[0], values / 257, rtol=1e-5)


def test_12_bits_in_16_without_a_white_level_are_said(tmp_path):
    for i in range(2):
        tifffile.imwrite(tmp_path / f"{i}.tif", ramp(np.uint16, 3800))
    with pytest.warns(ClipWarning, match=r"brightest pixel is 3800 of 65535; .* 12 bits, .* white = 4095"):
        open_clip(tmp_path, fps=30)
    assert open_clip(tmp_path, fps=30, white=4095).size == (4, 5)


@pytest.mark.parametrize(
    ("values", "white", "message"),
    [
        (ramp(np.float32, 1), None, r"x\.tif as an image: it holds float32 values, up to 1, .* white = 1.0"),
        (ramp(np.uint32, 70000), None, "it holds uint32 values, up to 70000, and no format says"),
        (np.array([[0, np.nan, 1]] * 3, np.float32), 1.0, "it holds NaN"),
        (ramp(np.int16, 900) - np.int16(5), None, "it holds negative values, down to -5"),
        (ramp(np.float32, 3) / 2, 1.0, "it holds 1.5, above white = 1"),
        (ramp(np.uint8, 255), 4095, "white is 4095, but its values end at 255"),
    ],
)
def test_values_whose_level_is_unknown_are_refused_with_the_file_and_the_cure(tmp_path, values, white, message):
    tifffile.imwrite(tmp_path / "x.tif", values)
    with pytest.raises(ValueError, match=message):
        greys(tmp_path / "x.tif", white)


def test_floats_are_read_once_their_white_is_told(tmp_path):
    tifffile.imwrite(tmp_path / "x.tif", ramp(np.float32, 8) / 8)
    np.testing.assert_allclose(greys(tmp_path / "x.tif", white=1.0)[0], ramp(float, 8) / 8 * 255, rtol=1e-5)


# Colour modes


@pytest.mark.parametrize("suffix", [".jpg", ".tif"])
def test_cmyk_is_turned_into_colours(tmp_path, suffix):
    image = Image.new("RGB", (16, 16), (200, 50, 50)).convert("CMYK")
    image.save(tmp_path / f"x{suffix}")
    np.testing.assert_allclose(greys(tmp_path / f"x{suffix}")[0], 0.299 * 200 + 0.701 * 50, atol=1.5)


@pytest.mark.parametrize("bits", [8, 16])
def test_a_tiff_whose_0_is_white_is_inverted(tmp_path, bits):
    values = ramp(f"u{bits // 8}", 2**bits - 1)
    tifffile.imwrite(tmp_path / "x.tif", values, photometric="miniswhite")
    np.testing.assert_allclose(greys(tmp_path / "x.tif")[0], 255 - values * (255 / (2**bits - 1)), atol=1e-3)


@pytest.mark.parametrize("kind", ["RGBA", "LA", "P", "RGB", "RGBA16"])
def test_what_is_transparent_is_laid_on_white_and_said(tmp_path, kind):
    level = np.full((4, 4), 100, np.uint8)
    alpha = np.array([[255, 255, 0, 0]] * 4, np.uint8)
    for i in range(2):
        if kind == "RGBA16":
            deep = np.dstack([level, level, level, alpha]).astype(np.uint16) * 257
            tifffile.imwrite(tmp_path / f"{i}.tif", deep, extrasamples="unassalpha", photometric="rgb")
        elif kind in ("RGBA", "LA"):
            layers = [level] * (3 if kind == "RGBA" else 1)
            Image.fromarray(np.dstack([*layers, alpha])).save(tmp_path / f"{i}.png")
        else:
            keyed = Image.fromarray(np.where(alpha == 0, 7, level).astype(np.uint8))
            keyed = keyed if kind == "P" else keyed.convert("RGB")
            keyed.convert(kind).save(tmp_path / f"{i}.png", transparency=7 if kind == "P" else (7, 7, 7))
    with pytest.warns(ClipWarning, match="it is transparent in places, and is shown on white"):
        clip = open_clip(tmp_path, fps=30)
    np.testing.assert_allclose(next(iter(clip)).grey, [[100, 100, 255, 255]] * 4, atol=1e-3)


@pytest.mark.parametrize("number", range(1, 9))
@pytest.mark.parametrize("suffix", [".jpg", ".png", ".tif", "16.tif"])
def test_the_orientation_of_a_camera_is_undone(tmp_path, number, suffix):
    from PIL import ImageOps

    shown = np.kron(np.array([[20, 90, 160], [230, 60, 120]], np.uint8), np.ones((16, 16), np.uint8))
    exif = Image.Exif()
    exif[274] = number
    plain, path = tmp_path / "plain.png", tmp_path / f"x{suffix}"
    Image.fromarray(shown).save(plain, exif=exif)
    expected = np.asarray(ImageOps.exif_transpose(Image.open(plain)))
    if suffix == "16.tif":
        tifffile.imwrite(path, shown.astype(np.uint16) * 257, extratags=[(274, "H", 1, number, True)])
    else:
        Image.fromarray(shown).save(path, exif=exif)
    (page,) = greys(path)
    assert page.shape == expected.shape
    np.testing.assert_allclose(page, expected, atol=8 if suffix == ".jpg" else 1e-3)


# Pages


def test_pages_are_frames_also_over_several_files(tmp_path):
    pages = np.random.default_rng(0).integers(0, 256, (20, 6, 7), dtype=np.uint8)
    (tmp_path / "stacks").mkdir()
    for i in range(4):
        tifffile.imwrite(tmp_path / "stacks" / f"{i}.tif", pages[5 * i : 5 * i + 5], photometric="minisblack")
    frames = list(open_clip(tmp_path / "stacks", fps=50))
    np.testing.assert_allclose([frame.grey for frame in frames], pages, atol=1e-4)
    assert [frame.time for frame in frames] == [20.0 * i for i in range(20)]
    tifffile.imwrite(tmp_path / "one.tif", pages, photometric="minisblack", compression="zlib")
    np.testing.assert_allclose([frame.grey for frame in open_clip(tmp_path / "one.tif", fps=50)], pages, atol=1e-4)
    Image.fromarray(pages[0]).save(
        tmp_path / "lzw.tif",
        save_all=True,
        append_images=[Image.fromarray(page) for page in pages[1:]],
        compression="tiff_lzw",
    )
    np.testing.assert_allclose([frame.grey for frame in open_clip(tmp_path / "lzw.tif", fps=50)], pages, atol=1e-4)


def test_an_imagej_stack_is_read_page_by_page_and_channels_are_refused(tmp_path):
    stack = np.random.default_rng(0).integers(0, 65536, (5, 6, 7), dtype=np.uint16)
    tifffile.imwrite(tmp_path / "x.tif", stack, imagej=True, metadata={"axes": "TYX"})
    np.testing.assert_allclose(greys(tmp_path / "x.tif"), stack / 257, rtol=1e-5)
    tifffile.imwrite(tmp_path / "x.tif", stack[None, :2].repeat(3, 0), imagej=True, metadata={"axes": "TCYX"})
    with pytest.raises(ValueError, match=r"it holds 3 \(T\) x 2 \(C\) pages .* save one channel"):
        greys(tmp_path / "x.tif")


def test_previews_and_masks_of_a_tiff_are_no_frames(tmp_path):
    with tifffile.TiffWriter(tmp_path / "x.tif") as writer:
        for value, kind in ((10, 0), (99, 1), (20, 0)):
            writer.write(np.full((4, 4), value, np.uint8), subfiletype=kind, photometric="minisblack", metadata=None)
        writer.write(np.ones((4, 4), bool), subfiletype=4, metadata=None)
    np.testing.assert_allclose(np.mean(greys(tmp_path / "x.tif"), axis=(1, 2)), [10, 20], rtol=1e-5)
