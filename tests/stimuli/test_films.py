"""Films: the same scene at any frame rate, contact where geometry says, objects as large as they are far."""

import dataclasses

import jax
import numpy as np
import pytest

from benchmarks.film_statistics import Measured
from lgmd2jax import Eye, stimuli
from lgmd2jax.alarms import LabelledClip, Rendering
from lgmd2jax.stimuli._film_camera import _as_h264, _exposure
from lgmd2jax.stimuli._film_kinds import COLLISIONS, OTHERS, Thing, _camera, _film, _look
from lgmd2jax.stimuli._film_scene import coarse, draw
from lgmd2jax.stimuli._flash import flashed
from lgmd2jax.stimuli._flutter import fluttered
from lgmd2jax.stimuli._shot import Shot

EYE = Eye(rows=10, cols=18, degrees_per_pixel=4.0, fps=30.0, projection="pinhole")
LASTS = 1.2  # s
QUICK, SLOW = ("runs into", "side", "walk up"), pytest.mark.slow  # each kind draws by a program of its own


def shot(seed: int, fps: float) -> Shot:
    return Shot(np.random.default_rng(seed), LASTS - np.arange(round(LASTS * fps))[::-1] / fps)


@pytest.mark.parametrize("kind", [kind if kind in QUICK else pytest.param(kind, marks=SLOW) for kind in stimuli.FILMS])
def test_a_scene_is_the_same_at_any_frame_rate(kind):
    """Every second frame at 30 frames a second is one at 15, until contact changes the speed between two."""
    slow, fast = ((COLLISIONS | OTHERS)[kind](shot(3, fps)) for fps in (15.0, 30.0))
    np.testing.assert_allclose(slow.left, fast.left[1::2])
    few, many = draw(EYE, slow.scene, slow.motion), draw(EYE, fast.scene, fast.motion)[1::2]
    assert few.std() > 3
    before = slow.left > 0.1
    assert np.abs(few - many)[before].mean() < 0.02 * few.std()


@pytest.mark.parametrize("kind", COLLISIONS)
def test_something_comes_ever_nearer_until_contact(kind):
    film = COLLISIONS[kind](shot(5, 30.0))
    away = film.motion.ahead[:, 0] - film.motion.camera.ahead
    assert np.all(np.diff(away[film.left > 0]) < 0)
    assert 0 < away[-1] < 4
    assert film.left[-1] == pytest.approx(-0.07)
    assert all(np.isinf(OTHERS[other](shot(5, 30.0)).left).all() for other in OTHERS)


def test_an_object_is_as_large_as_it_is_far():
    """Half-sides of .5 m at 4 m fill 2 arctan(1/8) of the field, in both directions."""
    plain = shot(0, 30.0)
    look = _look(plain, level=2.0, contrast=0.0, underside=1.0, lamps=0.0, shape=30.0)
    thing = Thing(0.0, 1.0, 4.0, 0.5, 0.5, look)
    film = _film(plain, _camera(plain, 1.0), [thing], light=1.0, beam=0.0, haze=1e6, sky=200.0, lines=0.0, skyline=2.0)
    grey = dataclasses.replace(film.scene.ground, level=np.asarray(200, np.float32), contrast=np.asarray(0, np.float32))
    scene = dataclasses.replace(film.scene, ground=grey, wall=grey, far=grey)
    light = draw(EYE, scene, film.motion)[0]
    covered = ((200 - light) / 198).clip(0, 1)
    side = 2 * 0.5 / 4.0 * EYE.focal_px * 2  # pixels of the finer raster
    assert covered.sum() == pytest.approx(side**2, rel=0.03)
    rows, cols = np.nonzero(covered > 0.5)
    assert (rows.mean(), cols.mean()) == pytest.approx((9.5, 17.5), abs=0.1)
    assert coarse(light[None]).shape == (1, EYE.rows, EYE.cols)


def test_a_shadow_falls_on_everything_within_it_and_on_nothing_else():
    """Ground, walls, objects and bonnet keep the share .5 of their light; the sky and the picture far away keep all."""
    plain = shot(0, 30.0)
    thing = Thing(0.0, 1.0, 4.0, 1.0, 1.0, _look(plain, lamps=0.0, shape=30.0))
    still = {"light": 1.0, "beam": 0.0, "haze": 1e9, "lines": 0.0, "lamps": 0.0, "bonnet": 0.2, "shade": 0.5}
    film = _film(plain, _camera(plain, 1.0), [thing], None, wall_tall=3.0, indoors=True, skyline=0.3, **still)

    def light(shade_from: float, shade_to: float):
        place = {"shade_from": np.asarray(shade_from, np.float32), "shade_to": np.asarray(shade_to, np.float32)}
        return draw(EYE, dataclasses.replace(film.scene, **place), film.motion)[0]

    bright, dark = light(1e5, 1e5 + 1), light(-1e5, 1e5)
    kept = dark / bright
    assert np.all((kept > 0.499) & (kept < 1.001))  # between them are rays that pass an edge
    assert np.mean((kept < 0.501) | (kept > 0.999)) > 0.9
    np.testing.assert_allclose(kept[-4:], 0.5, rtol=1e-5)  # bonnet
    np.testing.assert_allclose(kept[8:15, 17:19], 0.5, atol=1e-3)  # the thing
    assert np.all(kept[0, 16:20] == 1)  # sky
    beyond = light(8.0, 1e5)  # which begins behind the thing
    np.testing.assert_allclose(beyond[-4:], bright[-4:])
    np.testing.assert_allclose(beyond[8:15, 17:19], bright[8:15, 17:19])
    assert np.any(beyond != bright)


@pytest.mark.parametrize("kind", stimuli.FILMS)
def test_chance_and_shadows_do_not_depend_on_the_frame_rate(kind):
    """As much chance is used, and a shadow lies where it lies, but for the speed that contact changes in a frame."""
    for seed in range(40):
        shots = shot(seed, 8.0), shot(seed, 60.0)
        slow, fast = ((COLLISIONS | OTHERS)[kind](each).scene for each in shots)
        assert shots[0].chance.bit_generator.state == shots[1].chance.bit_generator.state
        assert slow.shade_from == pytest.approx(fast.shade_from, rel=0.1)


def test_shadows_lie_on_the_way_of_cameras_that_move():
    """On a third of their ways; a camera that stands has none."""
    moving = [COLLISIONS["side"](shot(seed, 30.0)) for seed in range(60)]
    ways = np.array([np.ptp(film.motion.camera.ahead) for film in moving])
    begins = np.array([film.scene.shade_from for film in moving])
    assert np.all(begins[ways < 3] == 1e5)
    shaded = begins[ways > 3] < 1e5
    assert 0.15 < shaded.mean() < 0.6
    assert np.all(begins[ways > 3][shaded] <= ways[ways > 3][shaded])


def test_a_ray_sees_the_mean_of_its_footprint():
    """Of a picture with nine texels in a ray: the mean of rays that each see one. Without it they correlate by .48."""
    plain = Shot(np.random.default_rng(0), np.zeros(1))
    film = _film(plain, _camera(plain, 1.0), [], sky=200.0, skyline=2.0, wall_tall=0.01, light=1.0)
    contrast, grain = np.asarray(0.1, np.float32), np.asarray(0.03, np.float32)
    rough = np.asarray(25)  # a picture without large even parts
    far = dataclasses.replace(film.scene.far, contrast=contrast, grain=grain, pattern=rough)
    nothing = dataclasses.replace(film.scene.ground, contrast=np.asarray(0, np.float32))
    scene = dataclasses.replace(film.scene, far=far, ground=nothing)
    fine_eye = dataclasses.replace(EYE, rows=80, cols=144, degrees_per_pixel=0.5)
    above, fine = (draw(eye, scene, film.motion)[0][: eye.rows // 2] for eye in (EYE, fine_eye))
    mean = fine.reshape(len(above), 8, above.shape[1], 8).mean(axis=(1, 3))
    assert np.corrcoef(above.ravel(), mean.ravel())[0, 1] > 0.9
    assert above.std() == pytest.approx(mean.std(), rel=0.25)


def test_leaves_stir_alike_at_any_frame_rate_and_in_a_part_of_the_field():
    restless = 0
    for seed in range(20):
        slow, fast = (fluttered(np.full((round(LASTS * fps), 20, 36), 100.0), shot(seed, fps)) for fps in (15.0, 30.0))
        np.testing.assert_allclose(slow, fast[1::2])
        stirs = fast.std(axis=0) > 0.1
        restless += stirs.any()
        assert stirs.mean() < 0.9
    assert 4 <= restless <= 12  # of 20, a half wanted


def test_flashes_are_of_the_whole_field_at_any_frame_rate_and_pass():
    seen = 0
    for seed in range(20):
        slow, fast = (flashed(np.full((round(LASTS * fps), 20, 36), 100.0), shot(seed, fps)) for fps in (15.0, 30.0))
        np.testing.assert_allclose(slow, fast[1::2])
        changes = np.abs(fast - 100)
        if changes.max() == 0:
            continue
        seen += 1
        brightest = changes.max(axis=(1, 2)).argmax()
        assert changes[brightest].min() >= 0.09 * changes[brightest].max()
        assert (changes[brightest] == changes[brightest, :1]).all()  # in all rows alike
        assert fast.min() >= 20
    assert 3 <= seen <= 11  # of 20, .3 wanted


def test_exposure_evens_out_a_change_of_light_and_keeps_its_pace_at_any_frame_rate():
    for seed in range(10):
        gains = {}
        for fps in (30.0, 60.0):
            film = shot(seed, fps)
            gains[fps] = _exposure(np.where(film.time < 0.3, 50.0, 100.0), film)
        assert gains[30.0][0] == 1
        assert np.all(np.diff(gains[30.0]) <= 0)
        assert 0.5 < gains[30.0][-1] <= 1
        np.testing.assert_allclose(gains[30.0], gains[60.0][1::2], atol=0.03)
    still = shot(0, 30.0)
    np.testing.assert_allclose(_exposure(np.full_like(still.time, 80.0), still), 1.0)


def test_equal_keys_give_equal_films():
    first, again, other = (stimuli.random_film(EYE, jax.random.key(seed), duration_ms=600) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first.stimulus.frames, again.stimulus.frames)
    assert first.kind == again.kind
    assert first.stimulus.frames.shape != other.stimulus.frames.shape or np.any(
        np.asarray(first.stimulus.frames != other.stimulus.frames)
    )
    levels = np.asarray(first.stimulus.frames)
    assert np.all((levels == np.round(levels)) & (levels >= 0) & (levels <= 255))


def test_equal_frames_give_equal_bits():
    """As a fit that goes on must see the clips that it began with. By x264's vector code one in seven differed."""
    rng = np.random.default_rng(0)
    drift = np.cumsum(rng.normal(0, 3, (90, 60, 108)), axis=0)
    film = np.clip(128 + 0.2 * np.cumsum(drift, axis=2) + rng.normal(0, 2, drift.shape), 0, 255).astype(np.uint8)
    assert len({_as_h264(film, 10).tobytes() for _ in range(40)}) == 1


def test_half_of_the_films_are_collisions_and_they_are_labelled():
    clips = list(Rendering(10, 0, world="films", duration_ms=2500).clips(EYE))
    assert [bool(clip.windows) for clip in clips] == [False, True] * 5
    assert {clip.name.split(" ", 1)[1] for clip in clips} == set(stimuli.FILMS)
    assert len({clip.fps for clip in clips}) > 2
    for clip in clips:
        if clip.windows:
            assert 0.9 < clip.interval[clip.in_windows()[0]].sum() / 1000 < 1.2  # 1 s before contact, 70 ms after


MISTAKES = {
    "kind": (lambda: stimuli.random_film(EYE, jax.random.key(0), kind="drives"), "kind is 'drives'; choose 'drive'"),
    "odd": (lambda: stimuli.random_film(Eye(9, 18, 4.0, 30.0), jax.random.key(0)), "eye has 9 x 18 pixels; films need"),
    "short": (lambda: stimuli.random_film(EYE, jax.random.key(0), fps=10, duration_ms=150), "time for 2 frames"),
    "rate": (lambda: stimuli.random_film(EYE, jax.random.key(0), fps=0), "fps is 0"),
    "count": (lambda: stimuli.films(EYE, jax.random.key(0), 0), "count is 0; give a whole number of films"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_misuse_is_refused(mistake):
    call, message = MISTAKES[mistake]
    with pytest.raises(ValueError, match=message):
        call()


def test_the_statistics_know_a_shift_of_the_picture():
    """A quarter of a pixel a frame, 24 frames a second."""
    place = np.arange(40.0)
    waves = np.sin(place[:, None] / 3) + np.sin(place[None] / 4)
    frames = np.stack([100 + 30 * (np.sin(place[:, None] / 3) + np.sin((place[None] - t / 4) / 4)) for t in range(6)])
    measured = Measured(LabelledClip.of("drift", frames, 24.0))
    assert waves.shape == (40, 40)
    np.testing.assert_allclose(measured.own_motion(), 6.0, rtol=0.03)
    assert np.all(measured.coarse_share() > 0.9)
