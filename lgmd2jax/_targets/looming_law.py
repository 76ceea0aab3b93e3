"""How a LGMD answers an approaching object: eta, the product of angular speed and an exponential of the angle."""

import dataclasses
import math

import numpy as np
from jaxtyping import Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax._channels import Channel
from lgmd2jax._targets.rest import resting
from lgmd2jax._targets.target import Target
from lgmd2jax.stimuli import Stimulus

_REFERENCE_MS = 40.0  # l/|v| at which the peak is `peak`
_SAME_ANGLE = 0.1  # degrees; far above rounding, far below what another course makes


@checked
@dataclasses.dataclass(frozen=True, kw_only=True)
class LoomingLaw:
    """eta(t) = C theta'(t - delta) exp(-alpha theta(t - delta)) above rest, theta the full angle of the object.

    It peaks alpha l/|v| - delta before collision, delta after an angle of 2 atan(1/alpha), whatever l/|v|. The object
    stands before `start_angle` and after `stop_angle` of the stimulus: theta' is 0 there. C makes the peak
    `peak` (l/|v| / 40 ms)^exponent, since eta's own falls as 1/(l/|v|) and recorded ones do not.

    **Arguments:**

    - `peak`: of the response above rest at l/|v| 40 ms, in the unit of the channel.
    - `alpha`: slope of the law of peak times; recorded 2.75 to 7.6.
    - `delta`: delay of the cell in ms; recorded 15 to 35.
    - `exponent`: of the amplitude over l/|v|; recorded -.05 (3 to 20 ms) and -.18 (10 to 80 ms).
    - `channel`, `rest`: as of `Rest`.

    **Raises:** `ValueError` for a peak or alpha that is not positive, for what is not finite, and as `Rest`.

    Source: Hatsopoulos, Gabbiani & Laurent 1995; Gabbiani, Krapp & Laurent 1999, whose own fit is the default.
    """

    peak: float | int
    alpha: float | int = 4.4
    delta: float | int = 18.7
    exponent: float | int = 0.0
    channel: Channel = "smp_adapted"
    rest: float | int | None = None

    def __post_init__(self):
        resting(self.channel, self.rest)
        for name in ("peak", "alpha", "delta", "exponent"):
            value = getattr(self, name)
            if not math.isfinite(value):
                raise ValueError(f"{name} is {value}; give a finite number")
            if name in ("peak", "alpha") and value <= 0:
                raise ValueError(f"{name} is {value}; give a positive number")

    @checked
    def on(self, stimulus: Stimulus) -> Target:
        """The target at the frames of the stimulus.

        **Raises:** `ValueError` for another stimulus than an approach at constant velocity, straight to the eye.
        """
        return Target(self.channel, self.values(np.asarray(stimulus.time, dtype=float), *course(stimulus))).on(stimulus)

    def values(
        self, time: Float[np.ndarray, " time"], l_over_v: float, start: float, stop: float
    ) -> Float[np.ndarray, " time"]:
        """The law at any `time`, in ms from collision, for an object that moves from `start` to `stop` degrees."""
        angle = full_angle(time - self.delta, l_over_v)
        eta = angular_speed(angle, l_over_v) * np.exp(-self.alpha * angle)
        moves = (angle >= np.radians(start)) & (angle < np.radians(stop))
        best = 2 * math.atan(1 / self.alpha)
        top = angular_speed(best, l_over_v) * math.exp(-self.alpha * best)
        peak = self.peak * (l_over_v / _REFERENCE_MS) ** self.exponent
        return resting(self.channel, self.rest) + peak * np.where(moves, eta, 0.0) / top


def full_angle(time: Float[np.ndarray, " time"], l_over_v: float) -> Float[np.ndarray, " time"]:
    """Full angle in radians of an object of half-size l at `time` ms from collision; it passes pi there."""
    return 2 * np.arctan2(l_over_v, -time)


def angular_speed(angle: Float[np.ndarray, " *time"] | float, l_over_v: float) -> Float[np.ndarray, " *time"] | float:
    """Of the full angle, in rad/ms, by the angle itself in radians: theta' = 2 (l/|v|)/(t^2 + (l/|v|)^2)."""
    return 2 / l_over_v * np.sin(angle / 2) ** 2


def course(stimulus: Stimulus) -> tuple[float, float, float]:
    """l/|v| in ms, first and last full angle in degrees, of an approach at constant velocity, straight to the eye."""
    time = np.asarray(stimulus.time, dtype=float)
    try:
        l_over_v, start, stop = (float(stimulus.parameters[name]) for name in ("l_over_v", "start_angle", "stop_angle"))
        angle = np.asarray(stimulus.courses["full_angle_deg"])
    except KeyError as error:
        raise ValueError(f"the looming law needs a looming stimulus with l_over_v; this one has no {error}") from None
    expected = np.clip(np.degrees(full_angle(time, l_over_v)), start, stop)
    if np.max(np.abs(angle - expected)) > _SAME_ANGLE:
        first = int(np.argmax(np.abs(angle - expected) > _SAME_ANGLE))
        raise ValueError(
            f"the looming law is one of an approach straight to the eye, of which the full angle at {time[first]:g} ms "
            f"is {expected[first]:.4g} degrees; in this stimulus it is {angle[first]:.4g}"
        )
    return l_over_v, start, stop
