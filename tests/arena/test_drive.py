"""The closed loop: what a robot can do in any arena, and what its chances depend on."""

import dataclasses
import itertools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax.arena import FrameDifference, NetworkDetector, NoDetector, Outcome, Pose, Start, run, trips
from lgmd2jax.arena._drive import SPEED_CM_S, TURNING_DEG_S, _away
from lgmd2jax.arena._layout import ROBOT_RADIUS_CM, SIDE_CM

EYE = lgmd.Eye.from_field_of_view(6, 9, 70.0, 30.0, "pinhole")
SEEDS, SECONDS = range(3), 20.0


@pytest.fixture(scope="module")
def without():
    """Robots that see nothing."""
    return run(NoDetector(), SEEDS, seconds=SECONDS, eye=EYE)


@pytest.fixture(scope="module")
def with_difference():
    """Robots that see a little."""
    detector = FrameDifference(jnp.asarray(6.0, jnp.float32))
    return run(detector, SEEDS, seconds=SECONDS, eye=EYE)


@pytest.fixture(params=["without", "with_difference"])
def driven(request):
    return request.getfixturevalue(request.param)


def test_a_robot_is_never_inside_of_anything(driven):
    layouts, trips = driven
    for layout, places in zip(layouts, np.asarray(trips.pose.place, float), strict=True):
        assert ((places > ROBOT_RADIUS_CM - 1e-3) & (places < SIDE_CM - ROBOT_RADIUS_CM + 1e-3)).all()
        distance = np.linalg.norm(places[:, None] - layout.centres, axis=2)
        assert (distance > layout.radii + ROBOT_RADIUS_CM - 1e-3).all()


def test_the_way_is_speed_times_the_time_of_driving(driven):
    _, trips = driven
    way = np.linalg.norm(np.diff(np.asarray(trips.pose.place, float), axis=1), axis=2)
    drives = np.asarray(trips.driven_cm[:, :-1]) > 0
    np.testing.assert_allclose(way[drives], SPEED_CM_S / EYE.fps, rtol=1e-3)
    assert (way[~drives] == 0).all()
    assert 0.3 < drives.mean() < 1


def test_it_turns_where_it_stands_by_more_than_half_a_circle_after_each_alarm_and_contact(driven):
    _, trips = driven
    heading, driven_cm = np.asarray(trips.pose.heading, float), np.asarray(trips.driven_cm)
    begins = np.asarray(trips.alarm | trips.contact)
    for robot in range(len(heading)):
        turning = np.diff(heading[robot]) != 0
        assert (driven_cm[robot, :-1][turning] == 0).all()
        first = np.flatnonzero(np.diff(turning.astype(int), prepend=0) == 1)
        last = np.flatnonzero(np.diff(turning.astype(int), append=0) == -1)
        for start, end in zip(first, last, strict=True):
            angle = abs(np.degrees(heading[robot, end + 1] - heading[robot, start]))
            whole = end + 1 < len(turning)  # not cut by the end of the trip
            assert not whole or angle >= 180 - 1e-3
            steps = np.abs(np.degrees(np.diff(heading[robot, start : end + 2])))
            assert (steps <= TURNING_DEG_S / EYE.fps + 1e-3).all()
        assert set(np.flatnonzero(begins[robot])) - {len(turning)} <= set(np.flatnonzero(turning))


def test_a_contact_counts_once(without):
    """Until the robot has moved again, it is the same contact."""
    _, trips = without
    assert trips.contact.sum() > len(SEEDS)
    for contacts, driven_cm in zip(np.asarray(trips.contact), np.asarray(trips.driven_cm), strict=True):
        at = np.flatnonzero(contacts)
        for one, other in itertools.pairwise(at):
            assert driven_cm[one:other].sum() > 0


def test_a_robot_that_faces_a_wall_has_one_contact_however_often_it_turns():
    """From a corner of which most turns lead into a wall at once."""
    start = Start.of(0)
    corner = Pose(jnp.full(2, ROBOT_RADIUS_CM + 0.01, jnp.float32), jnp.asarray(np.pi, jnp.float32))
    trip = trips(NoDetector(), jax.tree.map(lambda leaf: leaf[None], dataclasses.replace(start, pose=corner)), eye=EYE)
    first_way = np.argmax(np.asarray(trip.driven_cm[0]) > 0)
    assert first_way > 0
    assert int(trip.contact[0, :first_way].sum()) == 1


def test_alarms_prevent_contacts(without, with_difference):
    few, many = (Outcome.of(*each) for each in (with_difference, without))
    assert few.alarms.sum() > 0
    assert many.alarms.sum() == 0
    assert few.contacts.sum() < many.contacts.sum()


def test_a_seed_is_the_same_whatever_is_beside_it(with_difference):
    detector = FrameDifference(jnp.asarray(6.0, jnp.float32))
    _, alone = run(detector, [1], seconds=SECONDS, eye=EYE)
    assert eqx.tree_equal(jax.tree.map(lambda leaf: leaf[1:2], with_difference[1]), alone)


def test_vmapped_robots_do_what_single_ones_do(with_difference):
    detector = FrameDifference(jnp.asarray(6.0, jnp.float32))
    starts = Start.stacked(SEEDS)

    @jax.jit
    def at_once(scene, pose, key):
        return jax.vmap(lambda *start: lgmd.arena.drive(detector, *start, seconds=SECONDS, eye=EYE))(scene, pose, key)

    vmapped = at_once(starts.scene, starts.pose, starts.key)
    np.testing.assert_allclose(vmapped.pose.place, with_difference[1].pose.place, atol=1e-3)


@pytest.mark.parametrize("network", [lgmd.LGMD2(), lgmd.YueRindLGMD1()], ids=["LGMD2", "LGMD1"])
def test_a_network_raises_the_alarms_that_it_raises_on_the_same_frames(network):
    detector = NetworkDetector.of(network, EYE)
    frames = np.random.default_rng(0).uniform(0, 255, (12, 6, 9)).round().astype(np.float32)
    state, alarms = detector.rest(jnp.asarray(frames[0])), []
    for frame in frames:
        state, alarm, evidence = detector.step(state, jnp.asarray(frame))
        alarms.append(bool(alarm))
        assert evidence.shape == (2,)
    assert alarms == np.asarray(detector.network(frames).collision >= 0.5).tolist()


def test_it_turns_away_from_the_side_of_more_evidence():
    left, right = (jnp.asarray(values) for values in ([3.0, 1.0], [1.0, 3.0]))
    assert (_away(left, jnp.ones(())), _away(right, -jnp.ones(()))) == (-1, 1)  # positive angles turn to the left
    assert _away(jnp.ones(2), -jnp.ones(())) == -1
