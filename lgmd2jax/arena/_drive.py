"""The closed loop: a robot sees, decides, moves.

From the paper: the robot drives straight on until an alarm, turns to a random side by more than 180 degrees, and drives
on; a camera of 72 x 99 pixels, 70 degrees wide, 30 frames per second; a minute. The rest is this project's choice. The
paper gives no speed: here the robot drives 6 cm/s (it can do 35, Arvin et al. 2014). It turns by 180 to 270 degrees, so
that it comes to face the half behind it. A contact is counted once and answered with the same turn. The detector sees
nothing in a turn and starts anew with the first frame of the drive after it.
"""

import math
from typing import Any, Literal

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax._eye import Eye
from lgmd2jax._types import Key, Scalar
from lgmd2jax.arena._camera import EYE, Scene, film, render
from lgmd2jax.arena._detectors import AbstractDetector, Evidence
from lgmd2jax.arena._layout import ROBOT_RADIUS_CM, SIDE_CM

SECONDS = 60.0
SPEED_CM_S = 6.0
TURNING_DEG_S = 270.0
Turn = Literal["random", "away"]
TURNS: dict[Turn, tuple[float, float]] = {"random": (180.0, 270.0), "away": (45.0, 135.0)}  # degrees

_KEEP = 0.9  # of the evidence of both sides, from one frame to the next: a frame alone tells the side from noise badly
_SHEET = 256  # pixels of noise along each side, of which a frame takes a random part


class Pose(eqx.Module):
    """Where the robot's centre is, in cm, and where it looks, in radians from the x axis to the y axis."""

    place: Float[Array, "*time 2"]
    heading: Float[Array, "*time"]


class Trip(eqx.Module):
    """What a robot did, frame by frame.

    - `pose`: where each frame was taken.
    - `alarm`: whether the detector raised an alarm on a drive.
    - `contact`: whether the robot ran into something; true once for each contact.
    - `driven_cm`: distance to the next frame; 0 in a turn.
    """

    pose: Pose
    alarm: Bool[Array, "*time"]
    contact: Bool[Array, "*time"]
    driven_cm: Float[Array, "*time"]


class _Robot(eqx.Module):
    """What changes from frame to frame.

    `evidence`: of both sides, averaged over the last frames of a drive. `to_turn`: angle in radians that is left of a
    turn.
    """

    pose: Pose
    detector: Any
    evidence: Evidence
    to_turn: Scalar
    turned: Bool[Array, ""]  # in the frame before, or not driven yet
    touching: Bool[Array, ""]


@checked
def drive(
    detector: AbstractDetector,
    scene: Scene,
    start: Pose,
    key: Key,
    *,
    turn: Turn = "random",
    seconds: float = SECONDS,
    eye: Eye = EYE,
) -> Trip:
    """Let one robot drive in one arena; `run` does so for many.

    **Arguments:**

    - `scene`: the arena, `Scene.of(random_layout(seed))` for example. `start`: the robot's first pose in it.
    - `key`: of the camera's noise, and of the turns.
    - `turn`: at an alarm, `"random"` by 180 to 270 degrees to a random side, as in the paper; `"away"` by 45 to 135
      degrees, from the side of more evidence.
    - `seconds`: how long the robot drives. `eye`: its camera.
    """
    steps = round(seconds * eye.fps)
    low, high = map(math.radians, TURNS[turn])
    # In float32, so that the chances are the same whatever JAX's default precision is.
    angle, side, row, col = jax.random.uniform(key, (4, steps), jnp.float32)
    chance = (
        low + (high - low) * angle,
        jnp.where(side < 0.5, jnp.float32(-1), 1),
        (row * (_SHEET - eye.rows)).astype(int),
        (col * (_SHEET - eye.cols)).astype(int),
        jnp.arange(steps, dtype=jnp.float32) / np.float32(eye.fps),
    )
    noise = jnp.asarray(np.random.default_rng(0).standard_normal((_SHEET, _SHEET)), jnp.float32)
    stride, rotation = SPEED_CM_S / eye.fps, np.float32(np.radians(TURNING_DEG_S) / eye.fps)

    def step(robot: _Robot, chance) -> tuple[_Robot, Trip]:
        angle, random_side, row, col, time = chance
        image = render(eye, scene, robot.pose.place, robot.pose.heading)
        frame = film(scene, image, jax.lax.dynamic_slice(noise, (row, col), image.shape), time)
        turning = robot.to_turn != 0
        fresh = detector.rest(frame)
        anew = turning | robot.turned
        state = jax.tree.map(lambda fresh, kept: jnp.where(anew, fresh, kept), fresh, robot.detector)
        state, alarm, now = detector.step(state, frame)
        evidence = jnp.where(anew, 0, _KEEP * robot.evidence) + (1 - _KEEP) * now
        alarm = alarm & ~turning
        ahead = robot.pose.place + stride * direction(robot.pose.heading)
        blocked = ~is_free(scene, ahead)
        runs_into = blocked & ~turning & ~alarm
        drives = ~(turning | alarm | blocked)
        side = random_side if turn == "random" else _away(evidence, random_side)
        to_turn = jnp.where(alarm | runs_into, side * angle, robot.to_turn)
        rotated = jnp.clip(to_turn, -rotation, rotation)
        pose = Pose(jnp.where(drives, ahead, robot.pose.place), robot.pose.heading + rotated)
        trip = Trip(robot.pose, alarm, runs_into & ~robot.touching, jnp.where(drives, stride, 0))
        return _Robot(pose, state, evidence, to_turn - rotated, turning, ~drives & (robot.touching | runs_into)), trip

    frame = render(eye, scene, start.place, start.heading)
    nothing, yes = jnp.zeros((), jnp.float32), jnp.ones((), bool)
    robot = _Robot(start, detector.rest(frame), jnp.zeros(2, jnp.float32), nothing, yes, ~yes)
    return jax.lax.scan(step, robot, chance)[1]


def direction(heading: Scalar) -> Float[Array, "2"]:
    """The unit vector of a heading."""
    return jnp.stack([jnp.cos(heading), jnp.sin(heading)])


def is_free(scene: Scene, place: Float[Array, "2"]) -> Bool[Array, ""]:
    """Whether the robot's centre may be there."""
    inside = jnp.all((place >= ROBOT_RADIUS_CM) & (place <= SIDE_CM - ROBOT_RADIUS_CM))
    distance = jnp.sqrt(((scene.centres - place[None]) ** 2).sum(axis=1))
    return inside & jnp.all(distance >= scene.radii + ROBOT_RADIUS_CM)


def _away(evidence: Evidence, otherwise: Scalar) -> Scalar:
    """To the left (positive angles) where there is more on the right."""
    left, right = evidence
    return jnp.where(left == right, otherwise, jnp.sign(right - left))
