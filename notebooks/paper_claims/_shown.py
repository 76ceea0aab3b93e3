"""What a network does in one condition of a protocol, once or over repeats that differ in the camera's noise."""

import dataclasses
import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

import lgmd2jax as lgmd

ROBOT_T_SP, T_SP = 0.65, 0.78  # the paper: on the robot, and off line
REST = 0.505  # SMP: .5, and what rounding and a decay leave
_PHASES = 5  # of a frame, in which an event may fall: nothing releases a ball in step with a camera
_LENGTH = 32  # clips are held to a multiple of so many frames, so that few lengths are compiled; the network is causal


@dataclasses.dataclass(frozen=True)
class Seen:
    """The channels over time, a row a repeat.

    - `moving`: whether the scene has changed and will change; what the gate does as it reopens comes after.
    - `course`: what was shown over time, under its name and unit.
    """

    time: Float[np.ndarray, " time"]
    moving: Bool[np.ndarray, "repeat time"]
    course: tuple[str, Float[np.ndarray, " time"]]
    mp: Float[np.ndarray, "repeat time"]
    ffi: Float[np.ndarray, "repeat time"]
    smp: Float[np.ndarray, "repeat time"]
    smp_adapted: Float[np.ndarray, "repeat time"]
    spikes: Float[np.ndarray, "repeat time"]
    collision: Float[np.ndarray, "repeat time"]

    def during(self, channel: str, otherwise: float = 0.0) -> Float[np.ndarray, "repeat time"]:
        """A channel while the scene changes."""
        return np.where(self.moving, getattr(self, channel), otherwise)

    @property
    def burst(self) -> float:
        """The highest U' once the scene stands again, of all repeats."""
        later = np.arange(self.time.size) > np.argmax(np.cumsum(self.moving, axis=1), axis=1)[:, None]
        return float(np.where(later, self.smp_adapted, 0).max())

    def peak(self, channel: str = "smp_adapted") -> float:
        """The highest value while the scene changes, mean over repeats."""
        return float(self.during(channel).max(axis=1).mean())

    def spread(self, channel: str = "smp_adapted") -> float:
        """Standard deviation of that value over repeats."""
        return float(self.during(channel).max(axis=1).std())

    @property
    def peak_time(self) -> float:
        """When U' peaks while the scene changes, in ms, mean over repeats."""
        return float(self.time[self.during("smp_adapted").argmax(axis=1)].mean())

    @property
    def spike_counts(self) -> Float[np.ndarray, " repeat"]:
        """Spikes while the scene changes."""
        return self.during("spikes").sum(axis=1)

    @property
    def alarms(self) -> float:
        """Share of repeats with an alarm while the scene changes."""
        return float((self.during("collision") > 0.5).any(axis=1).mean())

    def above(self, level: float, channel: str = "smp_adapted") -> float:
        """For how long a channel is above a level, to the end of the clip, in ms, mean over repeats."""
        return float((getattr(self, channel) > level).sum(axis=1).mean() * (self.time[1] - self.time[0]))


def see(model: lgmd.AbstractNetwork, condition: lgmd.Condition, repeats: int = 1) -> Seen:
    """Show a condition. One that is filmed has other noise in every repeat, and another phase of the camera's clock."""
    camera = condition.camera
    settings = None if camera is None else {key: value for key, value in camera.items() if key != "seed"}
    phases = 1 if settings is None else min(repeats, _PHASES)
    eye = dataclasses.replace(condition.eye, fps=phases * condition.eye.fps)
    still = dataclasses.replace(condition, eye=eye, camera=None).render()
    count = len(still.time) // phases
    clips = np.stack([np.asarray(still.frames)[phase : phases * count : phases] for phase in range(phases)])
    changes = np.abs(np.diff(clips, axis=1, prepend=clips[:, :1])).max(axis=(2, 3)) > 1e-6
    moving = np.maximum.accumulate(changes, axis=1) & np.maximum.accumulate(changes[:, ::-1], axis=1)[:, ::-1]
    held = np.pad(clips, ((0, 0), (0, -count % _LENGTH), (0, 0), (0, 0)), mode="edge")
    which = np.arange(1 if settings is None else repeats) % phases
    keys = jax.random.split(jax.random.key(0), len(which))
    seen = jax.device_get(_filmed(model, jnp.asarray(held), condition.eye.fps, keys, jnp.asarray(which), settings))
    time = np.asarray(still.time)[: phases * count : phases]
    label, course = next(iter(still.courses.items()), ("", still.time))
    course = label, np.asarray(course)[: phases * count : phases]
    channels = {it.name: getattr(seen, it.name)[:, :count] for it in dataclasses.fields(Seen)[3:]}
    return Seen(time, moving[which], course, **channels)


@eqx.filter_jit
def _filmed(model, clips, fps, keys, which, settings) -> lgmd.Response:
    """One repeat after the other, which a CPU does faster than all at once."""

    def one(repeat):
        key, phase = repeat
        frames = clips[phase]
        if settings is not None:
            still = lgmd.Stimulus(frames, fps, jnp.arange(len(frames)) * 1000 / fps)
            frames = lgmd.stimuli.camera(still, key, **settings).frames
        return model(frames, fps)

    return jax.lax.map(one, (keys, which))


@functools.cache
def conditions(protocol: str) -> dict[str, lgmd.Condition]:
    """The conditions of a shipped protocol, by name."""
    return {condition.name: condition for condition in lgmd.load_protocol(protocol).conditions}


@functools.cache
def network(name: str, eye: lgmd.Eye) -> lgmd.AbstractNetwork:
    """A network of Table I, or without a mechanism, or with other parameters, by the name that the table gives it."""
    table = lgmd.LGMD2()
    return {
        "LGMD2": lambda: table,
        "LGMD2 without SFA": lambda: lgmd.ablate(table, "sfa"),
        "LGMD2 without FFI": lambda: lgmd.ablate(table, "ffi"),
        "LGMD1": lgmd.YueRindLGMD1,
        "LGMD1 without FFI": lambda: lgmd.ablate(lgmd.YueRindLGMD1(), "ffi"),
        "balanced": lambda: lgmd.LGMD2(lgmd.preset("balanced")),
        "light-selective": lambda: lgmd.LGMD2(lgmd.preset("light_selective")),
        "robot": lambda: lgmd.LGMD2(lgmd.Parameters(T_sp=ROBOT_T_SP)),
        "robot, N_sp 4": lambda: lgmd.LGMD2(lgmd.Parameters(T_sp=ROBOT_T_SP, N_sp=4)),
        "robot, theta1 .1": lambda: lgmd.LGMD2(lgmd.Parameters(T_sp=ROBOT_T_SP, theta1=0.1)),
        "LGMD2, n_p 1": lambda: lgmd.LGMD2(n_p=1),
        "robot, n_p 1": lambda: lgmd.LGMD2(lgmd.Parameters(T_sp=ROBOT_T_SP), n_p=1),
        "fitted": lambda: _fitted(eye),
    }[name]()


def _fitted(eye: lgmd.Eye) -> lgmd.AbstractNetwork:
    """The shipped fit, taken to another frame rate and field of view: k and A_ffi go as one by the field's area."""
    own, home = lgmd.load_fit("lgmd2").model, next(iter(conditions("lgmd2").values())).eye
    share = np.prod(home.field_of_view) / np.prod(eye.field_of_view)
    scaled = lgmd.at_frame_rate(own, eye.fps)
    p = scaled.parameters
    return dataclasses.replace(
        scaled, eye=None, parameters=dataclasses.replace(p, k=share * p.k, A_ffi=share * p.A_ffi)
    )


@functools.cache
def shown(name: str, protocol: str, condition: str, repeats: int = 1, fps: float | None = None, **changes) -> Seen:
    """What a network does in a condition of a protocol, if wanted at another frame rate or with changed numbers."""
    it = conditions(protocol)[condition]
    eye = it.eye if fps is None else dataclasses.replace(it.eye, fps=fps)
    it = dataclasses.replace(it, eye=eye, parameters={**it.parameters, **changes})
    return see(network(name, eye), it, repeats)
