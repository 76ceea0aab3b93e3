"""How a threshold acts: hard as in the paper, soft, or hard with a soft slope.

This is the only place that knows. The network asks a threshold and reads the same for all three.
"""

import abc

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax._network.parameter_set import scalar
from lgmd2jax._types import Map, Scalar, is_concrete, unless_nan


@checked
class Widths(eqx.Module):
    """Widths of the soft thresholds at temperature 1.

    - `s`, `change`, `ffi`, `sfa`: as a share of T_s, of the height that counts as a change, of T_ffi (A_ffi) and of
      T_sfa, so that they follow when these scale.
    - `floor`, `spikes`: in units of the SMP.
    - `collision`: in spikes.
    """

    s: Float[Array, ""] = eqx.field(default=0.1, converter=scalar)
    change: Float[Array, ""] = eqx.field(default=0.1, converter=scalar)
    ffi: Float[Array, ""] = eqx.field(default=0.03, converter=scalar)
    sfa: Float[Array, ""] = eqx.field(default=1.0, converter=scalar)
    floor: Float[Array, ""] = eqx.field(default=0.002, converter=scalar)
    spikes: Float[Array, ""] = eqx.field(default=0.01, converter=scalar)
    collision: Float[Array, ""] = eqx.field(default=0.1, converter=scalar)


class Thresholds(eqx.Module):
    """The thresholds of the network. Each returns a float: 0 or 1 when hard, between them when soft."""

    @abc.abstractmethod
    def s(self, s: Map, T_s: Scalar) -> Map:
        """Eq. 9: passes S >= T_s."""

    @abc.abstractmethod
    def change(self, d: Map, height: Scalar) -> Map:
        """Size-coding inhibition: a delayed change D > height counts, none does not."""

    @abc.abstractmethod
    def ffi(self, ffi: Scalar, T_ffi: Scalar) -> Scalar:
        """The feed-forward gate: passes Fbar <= T_ffi."""

    @abc.abstractmethod
    def sfa(self, rise: Scalar, T_sfa: Scalar) -> Scalar:
        """Eq. 15: adaptation acts on a rise <= T_sfa."""

    @abc.abstractmethod
    def floor(self, u: Scalar) -> Scalar:
        """Eq. 15: max(U', .5)."""

    @abc.abstractmethod
    def spikes(self, u: Scalar, T_sp: Scalar, sigma_sp: Scalar) -> Scalar:
        """Eq. 16: 0 below T_sp, 1 up to T_sp + sigma_sp, 2 above."""

    @abc.abstractmethod
    def collision(self, count: Scalar, N_sp: Scalar) -> Scalar:
        """Eq. 17: count >= N_sp."""


class Hard(Thresholds):
    """The paper's thresholds. They carry no slope. NaN stays NaN."""

    def s(self, s, T_s):
        return (~(s < T_s)).astype(s.dtype)  # 1 for NaN, by which S stays NaN at the cost of a comparison alone

    def change(self, d, height):
        return unless_nan(d, (d > height).astype(d.dtype))

    def ffi(self, ffi, T_ffi):
        return unless_nan(ffi, (ffi <= T_ffi).astype(ffi.dtype))

    def sfa(self, rise, T_sfa):
        return unless_nan(rise, (rise <= T_sfa).astype(rise.dtype))

    def floor(self, u):
        return jnp.maximum(u, 0.5)

    def spikes(self, u, T_sp, sigma_sp):
        return unless_nan(u, (u >= T_sp).astype(u.dtype) + (u > T_sp + sigma_sp))

    def collision(self, count, N_sp):
        return unless_nan(count, (count >= N_sp).astype(count.dtype))


@checked
class Soft(Thresholds):
    """Every threshold a logistic step whose width is one number, the temperature, times `widths`.

    As the temperature goes to 0 this becomes `Hard` (for a whole N_sp, since soft collision steps at N_sp - 1/2).

    **Raises:** `ValueError` for a temperature that is not positive.
    """

    temperature: Float[Array, ""] = eqx.field(default=1.0, converter=scalar)
    widths: Widths = eqx.field(default_factory=Widths)

    def __check_init__(self):
        _check_temperature(self.temperature)

    def s(self, s, T_s):
        return self._step(s - T_s, self.widths.s * T_s)

    def change(self, d, height):
        width = self.widths.change * height
        # What a step gives at rest would add up, over the time that a change is held, above the threshold of the cell.
        at_rest = self._step(-height, width)
        return (self._step(d - height, width) - at_rest) / (1 - at_rest)

    def ffi(self, ffi, T_ffi):
        return self._step(T_ffi - ffi, self.widths.ffi * T_ffi)

    def sfa(self, rise, T_sfa):
        return self._step(T_sfa - rise, self.widths.sfa * jnp.abs(T_sfa))

    def floor(self, u):
        width = (self.temperature * self.widths.floor).astype(u.dtype)
        return 0.5 + width * jax.nn.softplus((u - 0.5) / width)

    def spikes(self, u, T_sp, sigma_sp):
        return self._step(u - T_sp, self.widths.spikes) + self._step(u - T_sp - sigma_sp, self.widths.spikes)

    def collision(self, count, N_sp):
        return self._step(count - (N_sp - 0.5), self.widths.collision)

    def _step(self, distance, width):
        width = (self.temperature * width).astype(distance.dtype)
        # A threshold at 0 has no width of its own: a narrow one keeps the step and its slope finite there.
        sharpness = 1 / jnp.maximum(width, 1e-12)  # of all pixels, which a division each would make slower
        return jax.nn.sigmoid(distance * sharpness)


@checked
class StraightThrough(Thresholds):
    """Each threshold has the value of `Hard` and the slope of `Soft` at this temperature.

    The gradient of the network is then the plain chain rule over hard values, not the gradient of the soft network.

    **Raises:** `ValueError` for a temperature that is not positive.
    """

    temperature: Float[Array, ""] = eqx.field(default=1.0, converter=scalar)
    widths: Widths = eqx.field(default_factory=Widths)

    def __check_init__(self):
        _check_temperature(self.temperature)

    def s(self, s, T_s):
        return self._joined("s", s, T_s)

    def change(self, d, height):
        return self._joined("change", d, height)

    def ffi(self, ffi, T_ffi):
        return self._joined("ffi", ffi, T_ffi)

    def sfa(self, rise, T_sfa):
        return self._joined("sfa", rise, T_sfa)

    def floor(self, u):
        return self._joined("floor", u)

    def spikes(self, u, T_sp, sigma_sp):
        return self._joined("spikes", u, T_sp, sigma_sp)

    def collision(self, count, N_sp):
        return self._joined("collision", count, N_sp)

    def _joined(self, threshold, *arguments):
        hard = getattr(Hard(), threshold)(*arguments)
        soft = getattr(Soft(self.temperature, self.widths), threshold)(*arguments)
        # soft - stop_gradient(soft) is exactly 0, so the value is exactly hard.
        return jax.lax.stop_gradient(hard) + (soft - jax.lax.stop_gradient(soft))


def _check_temperature(temperature) -> None:
    if is_concrete(temperature) and not np.all(np.isfinite(temperature) & (np.asarray(temperature) > 0)):
        raise ValueError(f"temperature is {temperature}; it must be positive: for thresholds without width use Hard()")
