"""What is drawn on the frames of a clip."""

import numpy as np

import lgmd2jax as lgmd
from lgmd2jax._video.clip import Frame
from lgmd2jax._video.image_pixels import ImagePixels
from lgmd2jax._video.overlay import Overlay
from lgmd2jax._video.trace import Row


def test_the_overlay_draws_on_pictures_of_any_size():
    for rows, cols in ((3, 3), (31, 7), (240, 432)):
        overlay = Overlay((rows, cols), lgmd.LGMD2())
        picture = np.full((rows, cols, 3), 200, np.uint8)
        for i in range(300):
            row = Row(i, i * 33.0, 0.0, 0.0, 0.9, 0.5 + 0.4 * (i % 2), i % 3, i % 2)
            drawn = overlay.draw(
                Frame(i, i * 33.0, 33.0, ImagePixels(picture, 255.0), picture[..., 0] * 1.0, False), row
            )
            assert drawn.shape == picture.shape
        assert (picture == 200).all()
        assert len(overlay._past) <= 4000 / 33 + 2


def test_the_border_of_an_alarm_hides_no_label():
    """In a film that is held upright too, where the sides are short."""
    for rows, cols in ((1080, 1920), (1920, 1080)):
        overlay = Overlay((rows, cols), lgmd.LGMD2())
        picture = np.full((rows, cols, 3), 200, np.uint8)
        quiet, alarm = (
            overlay.draw(
                Frame(i, i * 33.0, 33.0, ImagePixels(picture, 255.0), picture[..., 0] * 1.0, False),
                Row(i, i * 33.0, 0.0, 0.0, 0.9, 0.9, 0, i),
            )
            for i in (0, 1)
        )
        in_label = (quiet == 0).all(axis=-1)[: rows // 2]  # its black ground
        border = (alarm == alarm[0, 0]).all(axis=-1)[: rows // 2, : cols // 2]
        assert in_label.any()
        assert not (in_label[:, : cols // 2] & border).any()
