"""How far an object is from the eye while it approaches, in multiples of its own half-size: the laws of approach.

A full angle is 2 atan(l/d), so only the ratio of distance d and half-size l is seen.
"""

import abc

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax._types import Scalar, Times, is_concrete
from lgmd2jax.stimuli._arguments import positive
from lgmd2jax.stimuli._units import Centimetres

_GRAVITY_CM = 981.0  # cm/s2


class Distance(eqx.Module):
    """The distance of an object from the eye over time, in half-sizes (d/l). One of your own is a subclass.

    Times are in ms; at 0 the object would touch the eye.
    """

    @abc.abstractmethod
    def __call__(self, time: Times) -> Times:
        """The distance in half-sizes at each time; it falls with time, or stands."""

    @abc.abstractmethod
    def reached(self, distance: Scalar) -> Scalar:
        """The time in ms at which a distance is reached; the start of motion for one that is never so large."""


class ConstantVelocity(Distance):
    """d/l = -t / (l/|v|)."""

    l_over_v: Scalar

    def __call__(self, time):
        return -time / self.l_over_v

    def reached(self, distance):
        return -distance * self.l_over_v


class AngleGrowth(Distance):
    """The full angle grows by `growth` deg/s and is `stop_angle` degrees at time 0."""

    growth: Scalar
    stop_angle: Scalar

    def __call__(self, time):
        half = jnp.radians(self.stop_angle + self.growth * time / 1000) / 2
        return 1 / jnp.tan(jnp.clip(half, 1e-4, np.pi / 2 - 1e-4))

    def reached(self, distance):
        return (2 * jnp.degrees(jnp.arctan2(1, distance)) - self.stop_angle) / self.growth * 1000


@checked
class Rolling(Distance):
    """A ball rolls from rest down a straight slope, at whose foot the eye is: acceleration 5/7 g height/length.

    **Arguments:** in cm:

    - `slope_height_cm`, `slope_length_cm`: of the slope; the ball starts at its top and stands there before.
    - `radius_cm`: of the ball.

    **Raises:** `ValueError` for a size that is not positive, and for a slope higher than long.
    """

    slope_height_cm: Scalar = eqx.field(default=30.0, converter=lambda x: positive("slope_height_cm", x, Centimetres))
    slope_length_cm: Scalar = eqx.field(default=100.0, converter=lambda x: positive("slope_length_cm", x, Centimetres))
    radius_cm: Scalar = eqx.field(default=2.5, converter=lambda x: positive("radius_cm", x, Centimetres))

    def __check_init__(self):
        height, length = self.slope_height_cm, self.slope_length_cm
        if is_concrete(height, length) and height > length:
            raise ValueError(f"slope_height_cm is {height:g} on a slope of {length:g} cm; a slope is longer than high")

    def __call__(self, time):
        before = jnp.minimum(-time / 1000, self._final_speed / self._acceleration)
        return (self._final_speed - self._acceleration * before / 2) * before / self.radius_cm

    def reached(self, distance):
        to_go = jnp.minimum(distance * self.radius_cm, self.slope_length_cm)
        speed = self._final_speed
        return -2000 * to_go / (speed + jnp.sqrt(jnp.maximum(speed**2 - 2 * self._acceleration * to_go, 0)))

    @property
    def _acceleration(self):
        return 5 / 7 * _GRAVITY_CM * self.slope_height_cm / self.slope_length_cm

    @property
    def _final_speed(self):
        return jnp.sqrt(2 * self._acceleration * self.slope_length_cm)


@checked
class Tabulated(Distance):
    """Any approach, as a table that is interpolated linearly; the object stands before and after.

    ```python
    looming(eye, distance=Tabulated([-1000, -200, 0], [40, 2, 0.5]))    # fast, then slower
    ```

    **Arguments:**

    - `time_ms`: ascending, with 0 where the object would touch the eye.
    - `distance`: in half-sizes, falling.

    **Raises:** `ValueError` for a table of another shape or order.
    """

    time_ms: Float[Array, " point"] = eqx.field(converter=lambda x: jnp.asarray(x, dtype=float))
    distance: Float[Array, " point"] = eqx.field(converter=lambda x: jnp.asarray(x, dtype=float))

    def __check_init__(self):
        if self.time_ms.ndim != 1 or self.time_ms.shape != self.distance.shape or self.time_ms.size < 2:
            raise ValueError(
                f"time_ms has shape {self.time_ms.shape} and distance {self.distance.shape}; give two equal columns"
            )
        for name, column, sign in (("time_ms", self.time_ms, 1), ("distance", self.distance, -1)):
            if is_concrete(column) and not np.all(sign * np.diff(column) > 0):
                raise ValueError(
                    f"{name} does not {'rise' if sign > 0 else 'fall'} from point to point; sort the table"
                )

    def __call__(self, time):
        return jnp.interp(time, self.time_ms, self.distance)

    def reached(self, distance):
        return jnp.interp(-distance, -self.distance, self.time_ms)


DISTANCES: dict[str, type[Distance]] = {"rolling": Rolling, "tabulated": Tabulated}
"""The laws of approach by the `kind` that a protocol gives its `distance`."""
