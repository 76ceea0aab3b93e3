"""The kinds of film: scenes by chance, half of them collisions, with sizes and speeds that vehicles and robots meet."""

import dataclasses
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from lgmd2jax.stimuli._film_scene import OBJECTS, Camera, Motion, Objects, Scene, Surface, patterns
from lgmd2jax.stimuli._shot import Course, Shot

Moving = Course | float | int
Range = tuple[float | int, float | int]
_BEHIND = -50.0  # m: where an object is that is not seen
_AFTER_MS = 70.0  # of a collision that are still shown: the first jolt
_WAY = 3.0  # m: a camera that goes less far meets no shadow
_NOWHERE = 1e5  # m: where a shadow is that nobody meets
_CAR = 1.8, 1.5  # m, width and height


class Thing(NamedTuple):
    """An upright thing: where its middle is in each frame, in m, its half-sides, and how it looks."""

    right: Moving
    height: Moving
    ahead: Moving
    width: float
    tall: float
    look: dict[str, float]


class Film(NamedTuple):
    """A scene, what moves in it, and the time until something is hit, in s; infinite where nothing is."""

    scene: Scene
    motion: Motion
    left: Course


# Light and surroundings


def _film(shot: Shot, camera: Camera, things: list[Thing], left: Course | None = None, **changes: float | int) -> Film:
    """A film with everything by chance but the camera's course and the things.

    **Arguments:** `left`: until contact, by which the camera is thrown about; none by default.
    """
    night = shot.often(0.1)
    light = shot.log(0.12, 0.4) if night else shot.log(0.75, 1.3)
    indoors = changes.pop("indoors", shot.often(0.2))
    wall_at = (shot.log(2, 7), -shot.log(2, 7)) if indoors else (shot.log(8, 60), -shot.log(8, 60))
    values = {
        "wall_at": wall_at,
        "wall_tall": shot.log(2.5, 20) if shot.often(0.75) else 0.01,
        "skyline": shot.between(0.02, 0.35),
        "lines": shot.between(120, 240) if shot.often(0.5) and not indoors else 0.0,
        "sky": shot.between(5, 25) if night else shot.between(120, 240),
        "light": light,
        "beam": shot.between(0.5, 1.5) if night else 0.0,
        **_shade(shot, camera),
        "lamps": shot.between(150, 400) if night and shot.often(0.7) else 0.0,
        "haze": shot.log(60, 800),
        "bonnet": 0.0,
        "bonnet_level": shot.log(10, 90),
    } | changes
    every = (things + [Thing(0.0, 0.0, _BEHIND, 1.0, 1.0, _look(shot))] * OBJECTS)[:OBJECTS]
    scene = Scene(
        objects=_objects(every, night),
        ground=_surface(shot, (50, 120), (0.06, 0.25), (0.5, 3.0)),
        wall=_surface(shot, (40, 130), (0.1, 0.4), (0.8, 6.0)),
        far=_surface(shot, (40, 150), (0.15, 0.5), (0.15, 0.6)),
        **{name: _single(value) for name, value in values.items()},
    )
    if left is not None:
        camera = _jolted(shot, camera, left)
    right, height, ahead = (
        np.stack([_single(shot.still + course) for course in courses], axis=1)
        for courses in zip(*((thing.right, thing.height, thing.ahead) for thing in every), strict=True)
    )
    motion = Motion(camera, right, height, ahead)
    return Film(scene, motion, np.full_like(shot.time, np.inf) if left is None else left)


def _shade(shot: Shot, camera: Camera) -> dict[str, float]:
    """A shadow on the camera's way, of a bridge or of trees; most often none."""
    way = float(camera.ahead[-1])  # since time 0, which does not depend on the frame rate as the first frame does
    start = way * shot.between(0, 1)
    if not shot.often(0.35) or way <= _WAY:
        start = _NOWHERE
    return {"shade_from": start, "shade_to": start + shot.log(2, 20), "shade": shot.between(0.3, 0.7)}


def _surface(shot: Shot, level: Range, contrast: Range, grain: Range) -> Surface:
    pattern = np.asarray(shot.chance.integers(len(patterns())))
    return Surface(_single(shot.between(*level)), _single(shot.between(*contrast)), _single(shot.log(*grain)), pattern)


def _objects(things: list[Thing], night: bool) -> Objects:
    def looks(name: str):
        return _single([thing.look[name] for thing in things])

    return Objects(
        width=_single([thing.width for thing in things]),
        tall=_single([thing.tall for thing in things]),
        shape=looks("shape"),
        underside=looks("underside"),
        lamps=looks("lamps") * night,
        surface=Surface(looks("level"), looks("contrast"), looks("grain"), looks("pattern").astype(int)),
    )


def _single(values: Any) -> np.ndarray:
    """In single precision, in which scenes are drawn."""
    return np.asarray(values, np.float32)


def _look(shot: Shot, dark: float = 0.6, lamps: float = 0.9, size: float = 1.5, **changes: Any) -> dict[str, float]:
    """How a thing looks: how often it is dark, how often lamps are lit at night, and its size in m, for its pattern."""
    level = shot.between(25, 85) if shot.often(dark) else shot.between(85, 190)
    return {
        "level": level,
        "contrast": shot.between(0.25, 0.6),
        "grain": size * shot.log(0.15, 0.6),
        "pattern": int(shot.chance.integers(len(patterns()))),
        "shape": shot.log(4, 12),
        "underside": shot.between(0.1, 0.6) if shot.often(0.7) else 1.0,
        "lamps": shot.between(200, 500) if shot.often(lamps) else 0.0,
    } | changes


def _car(shot: Shot, right: Moving, ahead: Moving, **changes: float | int) -> Thing:
    """A car, a van or a lorry on the ground."""
    size = shot.log(0.9, 1.15) if shot.often(0.75) else shot.log(1.2, 1.8)
    width, tall = size * _CAR[0] / 2, size * _CAR[1] / 2 * shot.log(0.95, 1.5)
    return Thing(right, tall, ahead, width, tall, _look(shot, **changes))


def _person(shot: Shot, right: Moving, ahead: Moving) -> Thing:
    tall = shot.between(0.8, 0.95)
    return Thing(
        right, tall, ahead, shot.between(0.22, 0.35), tall, _look(shot, lamps=0.0, size=0.8, shape=shot.log(2.5, 5))
    )


# Cameras


def _camera(
    shot: Shot,
    height: float | int,
    ahead: Moving = 0.0,
    *,
    yaw: Moving = 0.0,
    pitch: float | int = 0.0,
    shake: float | int = 0.0,
) -> Camera:
    """**Arguments:** m and degrees; `shake`: the root mean square of its unrest, in degrees."""
    turns = ((yaw, 0.7), (pitch, 1.0), (0.0, 0.4))  # and how much of the shake goes into each
    angles = [np.radians(turn + shot.sway(share * shake, 0.7, 6.0)) for turn, share in turns]
    return Camera(*(_single(shot.still + course) for course in (0.0, height, ahead, *angles)))


def _jolted(shot: Shot, camera: Camera, left: Course) -> Camera:
    """The camera that is thrown about once contact is made."""
    since = np.maximum(-left, 0)
    kick = np.radians(shot.log(1, 5)) * np.exp(-since / 0.12) * np.cos(2 * np.pi * shot.between(3, 8) * since)
    kick = np.where(left <= 0, kick, 0)
    share = shot.between(-1, 1)
    return dataclasses.replace(camera, pitch=_single(camera.pitch + kick), yaw=_single(camera.yaw + share * kick))


def _in_a_vehicle(shot: Shot, ahead: Moving, yaw: Moving = 0.0) -> Camera:
    """A camera behind a windscreen."""
    height, pitch, shake = shot.log(0.9, 1.8), shot.between(-6, 4), shot.log(0.03, 0.25)
    return _camera(shot, height, ahead, yaw=yaw, pitch=pitch, shake=shake)


def _bonnet(shot: Shot) -> float:
    return shot.between(0.05, 0.35) if shot.often(0.5) else 0.0


def _course(shot: Shot, speed: Moving) -> Course:
    """The way that is gone since time 0, in m, at a speed in m/s."""
    return np.cumsum((speed + shot.still) * np.diff(shot.time, prepend=0))


def _until_contact(shot: Shot) -> Course:
    """The time left until contact, in s: the film ends shortly after it."""
    return shot.time[-1] - _AFTER_MS / 1000 - shot.time


def _closing(left: Course, speed: float | int, gap: float | int, brakes: float | int) -> Course:
    """A distance that is `gap` at contact and closes at `speed` then; before it was faster, if somebody brakes."""
    ahead = np.maximum(left, 0)
    return gap + speed * ahead + brakes * ahead**2 / 2


# Collisions


def _run_into(shot: Shot) -> Film:
    """The vehicle drives at something that stands or is slower."""
    left = _until_contact(shot)
    speed = shot.log(3, 14)
    distance = _closing(left, speed, shot.log(0.8, 3.0), shot.between(0, 4))
    own = speed + shot.between(0, 8) * shot.chance.integers(2)
    travelled = _course(shot, np.where(left > 0, own, 0.1 * own))
    place = shot.between(-1.0, 1.0)
    camera = _in_a_vehicle(shot, travelled)
    things = [_car(shot, place, travelled + distance)]
    things += _traffic(shot, 2)
    return _film(shot, camera, things, left, bonnet=_bonnet(shot))


def _robot_into(shot: Shot) -> Film:
    """A small robot or a drone runs into a post, a wall, a person or a frame."""
    left = _until_contact(shot)
    speed = shot.log(0.8, 4)
    distance = _closing(left, speed, shot.log(0.1, 0.4), 0.0)
    travelled = _course(shot, np.where(left > 0, speed, 0.0))
    height = shot.log(0.1, 1.8)
    camera = _camera(shot, height, travelled, shake=shot.log(0.03, 0.4), pitch=shot.between(-5, 5))
    width, tall = shot.log(0.12, 1.2), shot.log(0.15, 1.2)
    middle = max(height + shot.between(-0.5, 0.5) * tall, tall) if shot.often(0.7) else height
    thing = Thing(
        shot.between(-0.5, 0.5) * width,
        middle,
        travelled + distance,
        width,
        tall,
        _look(shot, lamps=0.05, size=width, shape=shot.log(2, 12)),
    )
    return _film(shot, camera, [thing], left, indoors=shot.often(0.5))


def _struck(shot: Shot) -> Film:
    """A camera that stands, in front of a car or behind one, is hit by a vehicle."""
    left = _until_contact(shot)
    distance = _closing(left, shot.log(2.5, 10), shot.log(0.5, 2.5), shot.between(0, 5))
    camera = _camera(shot, shot.log(0.3, 1.6), pitch=shot.between(-5, 5), shake=shot.log(0.02, 0.3))
    things = [_car(shot, shot.between(-0.9, 0.9) + shot.between(-0.5, 0.5) * np.maximum(left, 0), distance)]
    things += _traffic(shot, 1)
    return _film(shot, camera, things, left, bonnet=_bonnet(shot))


def _from_the_side(shot: Shot) -> Film:
    """Somebody crosses and is hit, or hits."""
    left = _until_contact(shot)
    speed, across = shot.log(3, 10), shot.log(2, 8) * shot.side()
    distance = _closing(left, speed, shot.log(0.8, 3.0), 0.0)
    travelled = _course(shot, np.where(left > 0, speed, 0.2 * speed)) if shot.often(0.7) else shot.still
    camera = _in_a_vehicle(shot, travelled)
    things = [_car(shot, shot.between(-1, 1) + across * np.maximum(left, 0), travelled + distance)]
    return _film(shot, camera, things, left, bonnet=_bonnet(shot))


def _thrown(shot: Shot) -> Film:
    """A ball, a balloon, debris or an animal flies at the camera."""
    left = _until_contact(shot)
    distance = _closing(left, shot.log(2.5, 12), shot.log(0.08, 0.5), 0.0)
    own = shot.between(0, 8) if shot.often(0.4) else 0.0
    travelled = _course(shot, own)
    height, size = shot.log(0.5, 1.8), shot.log(0.1, 0.45)
    camera = _camera(shot, height, travelled, pitch=shot.between(-4, 10), shake=shot.log(0.03, 0.6))
    rise = shot.between(-0.5, 1.0) * np.maximum(left, 0)
    aside = shot.between(-0.2, 0.2) + shot.between(-0.5, 0.5) * np.maximum(left, 0)
    thing = Thing(
        aside,
        height + rise,
        travelled + distance,
        size,
        size * shot.log(0.7, 1.4),
        _look(shot, lamps=0.0, size=size, shape=shot.log(2, 6)),
    )
    return _film(shot, camera, [thing], left)


# What is no collision


def _traffic(shot: Shot, most: int) -> list[Thing]:
    """Cars in the other lanes: they come, are overtaken, or stand at the kerb."""
    things = []
    for _ in range(int(shot.chance.integers(most + 1))):
        side, speed = shot.side(), shot.between(-15, 5)
        start = shot.between(5, 60)
        things.append(_car(shot, side * shot.between(2.8, 6), start + _course(shot, speed), dark=0.5))
    return things


def _drive(shot: Shot) -> Film:
    """Driving behind somebody, past others, through bends and the shadows of bridges."""
    speed = shot.log(1, 9)
    travelled = _course(shot, speed * (1 + 0.2 * shot.sway(1.0, 0.1, 0.5)))
    bend = shot.between(-15, 15) if shot.often(0.4) else 0.0
    turn = bend * np.clip((shot.time - shot.between(0, 0.6) * shot.lasts) / shot.between(0.8, 2), 0, 1)
    camera = _in_a_vehicle(shot, travelled, turn)
    things = []
    if shot.often(0.7):
        gap = shot.log(5, 40) + max(shot.between(-0.08, 0.15), -0.08) * speed * shot.time
        things.append(_car(shot, shot.between(-0.6, 0.6), travelled + np.maximum(gap, 4)))
    if shot.often(0.2):
        at = shot.between(10, 60)
        tall = shot.between(0.5, 1.2)
        things.append(Thing(0.0, shot.between(4.5, 6) + tall, at, 25.0, tall, _look(shot, lamps=0.0, size=4.0)))
    things += _traffic(shot, 3)
    return _film(shot, camera, things, None, bonnet=_bonnet(shot))


def _passing_by(shot: Shot) -> Film:
    """Traffic or people cross before a camera that stands."""
    height, down = shot.log(0.4, 6), shot.between(0, 20)
    camera = _camera(shot, height, pitch=-down, yaw=shot.between(-30, 30), shake=shot.log(0.01, 0.15))
    things = []
    for _ in range(int(shot.chance.integers(1, OBJECTS + 1))):
        away, side = shot.log(3, 25), shot.side()
        when, slant = shot.between(-0.5, shot.lasts + 0.5), shot.between(-0.4, 0.4)
        if shot.often(0.5):
            speed = side * shot.between(0.6, 2.2)
            things.append(_person(shot, speed * (shot.time - when), away + slant * speed * (shot.time - when)))
        else:
            speed = side * shot.log(2, 10)
            ahead = max(away, 4.0) + slant * speed * (shot.time - when)
            things.append(_car(shot, speed * (shot.time - when), np.maximum(ahead, 3.0)))
    return _film(shot, camera, things)


def _walk_up(shot: Shot) -> Film:
    """A person or a slow vehicle comes up and stays away by seconds, or draws away."""
    camera = _camera(shot, shot.log(0.5, 3), pitch=-shot.between(0, 12), shake=shot.log(0.01, 0.4))
    speed = shot.between(0.5, 1.4)
    ahead = 2.2 * speed + shot.log(0.5, 6) + speed * (shot.time[-1] - shot.time)
    if shot.often(0.4):
        start, fast = shot.log(0.6, 4), shot.log(1, 10)
        ahead = start + fast * np.maximum(shot.time - shot.between(0.1, 0.5) * shot.lasts, 0)
    thing = (_person if shot.often(0.6) else _car)(shot, shot.between(-1, 1), ahead)
    return _film(shot, camera, [thing, *_traffic(shot, 1)])


def _miss(shot: Shot) -> Film:
    """Something comes as fast as in a collision, and passes a body's width aside."""
    when = shot.between(1.2, shot.lasts + 0.2)
    speed = shot.log(3, 15)
    own = shot.often(0.6)
    travelled = _course(shot, speed if own else 0.0)
    ahead = travelled + speed * (when - shot.time) + 0.3
    camera = _in_a_vehicle(shot, travelled)
    aside = shot.side() * shot.between(2.4, 4.5)
    return _film(shot, camera, [_car(shot, aside, ahead)], bonnet=_bonnet(shot))


def _turning(shot: Shot) -> Film:
    """A camera in the hand, on a robot or under a drone turns and sways in a scene."""
    start, lasts = shot.between(0, 0.7) * shot.lasts, shot.between(0.3, 2.5)
    turn = shot.log(2, 15) * shot.side() * lasts * np.clip((shot.time - start) / lasts, 0, 1)
    own = shot.log(0.2, 3) if shot.often(0.5) else 0.0
    camera = _camera(
        shot,
        ahead=_course(shot, own),
        height=shot.log(0.2, 3),
        yaw=turn,
        pitch=shot.between(-8, 8),
        shake=shot.log(0.02, 0.25),
    )
    things = [_person(shot, shot.between(-4, 4), own * shot.time[-1] + shot.between(3, 10)) for _ in range(2)]
    return _film(shot, camera, things)


COLLISIONS: dict[str, Callable[[Shot], Film]] = {
    "runs into": _run_into,
    "robot": _robot_into,
    "struck": _struck,
    "side": _from_the_side,
    "thrown": _thrown,
}
OTHERS: dict[str, Callable[[Shot], Film]] = {
    "drive": _drive,
    "passing by": _passing_by,
    "walk up": _walk_up,
    "miss": _miss,
    "turning": _turning,
}
