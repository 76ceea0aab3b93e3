"""The LGMD1 of Yue & Rind, with which the paper compares: no ON and OFF pathways, no adaptation, and a G layer.

As public codes agree on it. I is inhibition, S what it leaves of P, G what grouping makes of S.
"""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax._eye import Eye
from lgmd2jax._network import medulla, retina
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._network.lobula import gated
from lgmd2jax._network.maps import bordered, pool
from lgmd2jax._network.parameter_set import ParameterSet, declares, scalar
from lgmd2jax._network.stages import AbstractCell, AbstractPixels, Levels, Response, Sums
from lgmd2jax._network.structure import counts
from lgmd2jax._network.thresholds import Hard, Thresholds
from lgmd2jax._types import Map, Scalar, unless_nan

_SOURCE = "Yue & Rind 2006, the value that public codes agree on; bounds are this project's"
_PRIOR = "1 in Yue & Rind 2006, who have no such factor; bounds as of the LGMD2"


@checked
class YueRindParameters(ParameterSet):
    """The parameters of `YueRindLGMD1`: the paper's symbols for what the LGMD2 has too, Yue & Rind's for the rest.

    The defaults are the published values. `symbols(YueRindParameters)` says what each means, in which unit, where it
    may lie and where a fit searches. Of C_de and T_de only T_de/C_de counts, and C_omega, T_de and k times one factor
    change next to nothing: a fit that frees T_de and k holds C_de and C_omega.

    **Raises:** `ValueError` for a value outside its domain, when the value is concrete (not traced).
    """

    u: Float[Array, ""] = eqx.field(
        default=1.0,
        converter=scalar,
        metadata=declares(
            "decay of the photoreceptors' persistence over a frame",
            "1",
            "(-inf, inf)",
            (0.0, 3.0),
            _SOURCE,
            stage="pixels",
            per_frame="persistence",
        ),
    )
    W_I: Float[Array, ""] = eqx.field(
        default=0.3,
        converter=scalar,
        metadata=declares(
            "weight of the inhibition in the S layer", "1", "[0, inf)", (0.05, 1.0), _SOURCE, stage="pixels"
        ),
    )
    Delta_C: Float[Array, ""] = eqx.field(
        default=0.01,
        converter=scalar,
        metadata=declares(
            "added to the scale of grouping, which is then never 0",
            "grey level",
            "(0, inf)",
            (1e-3, 1.0),
            _SOURCE,
            scale="log",
            stage="pixels",
            per_frame="change",
        ),
    )
    C_omega: Float[Array, ""] = eqx.field(
        default=4.0,
        converter=scalar,
        metadata=declares(
            "by what the largest group is divided, as the scale of grouping",
            "1",
            "(0, inf)",
            (1.0, 16.0),
            _SOURCE,
            "log",
            stage="pixels",
        ),
    )
    C_de: Float[Array, ""] = eqx.field(
        default=0.5,
        converter=scalar,
        metadata=declares(
            "weight of G where it is compared with T_de", "1", "(0, inf)", (0.1, 1.0), _SOURCE, "log", stage="pixels"
        ),
    )
    T_de: Float[Array, ""] = eqx.field(
        default=15.0,
        converter=scalar,
        metadata=declares(
            "threshold of the G layer",
            "grey level",
            "[0, inf)",
            (1.0, 60.0),
            _SOURCE,
            "log",
            stage="pixels",
            per_frame="change",
        ),
    )
    T_ffi: Float[Array, ""] = eqx.field(
        default=10.0,
        converter=scalar,
        metadata=declares(
            "feed-forward inhibition from which there is no spike, at the start",
            "grey level",
            "(0, inf)",
            (1.0, 60.0),
            _SOURCE,
            "log",
            per_frame="change",
            of_field=True,
        ),
    )
    alpha_ffi: Float[Array, ""] = eqx.field(
        default=0.02,
        converter=scalar,
        metadata=declares("share of that threshold in its next value", "1", "[0, 1)", (0.0, 0.5), _SOURCE),
    )
    k: Float[Array, ""] = eqx.field(
        default=1.0,
        converter=scalar,
        metadata=declares(
            "mean potential of a pixel that maps to sigma(1)",
            "grey level",
            "(0, inf)",
            (0.1, 2.0),
            _PRIOR,
            "log",
            per_frame="change",
            of_field=True,
        ),
    )
    T_sp: Float[Array, ""] = eqx.field(
        default=0.86,
        converter=scalar,
        metadata=declares("spiking threshold (.78 and .8 are in use too)", "1", "(0.5, 1)", (0.6, 0.95), _SOURCE),
    )


class YueRindLayers(eqx.Module):
    """The maps of one frame, in grey levels, for `record` to choose from; `YueRindLGMD1` has their equations.

    - `p`: P, the change of luminance with its persistence. `inhibition`: I. `s`: S.
    - `c_e`: C_e, the 3x3 mean of S. `g`: G. `g_kept`: G after its threshold, the map of which K sums up abs(G).
    - `f`: abs(P) of the frame before, the map whose mean is F.
    """

    p: Map
    inhibition: Map
    s: Map
    c_e: Map
    g: Map
    g_kept: Map
    f: Map

    @property
    def mp(self) -> Map:
        """The map whose sum is K."""
        return retina.magnitude(self.g_kept)


class YueRindPixelState(eqx.Module):
    """What the pixels keep from one frame to the next."""

    luminance: Map
    p: Map


class YueRindPixels(AbstractPixels):
    """From frames to K and F."""

    parameters: YueRindParameters
    thresholds: Thresholds

    def rest(self, frame: Map) -> YueRindPixelState:
        return YueRindPixelState(frame, jnp.zeros_like(frame))

    def step(self, state, frame, interval):
        v = self.parameters
        p = retina.photoreceptors(frame - state.luminance, state.p[None], retina.persistence(v.u, 1))
        inhibition = medulla.lateral(bordered(state.p))
        s = p - v.W_I * inhibition
        c_e = medulla.g_layer(bordered(s))
        omega = v.Delta_C + jnp.max(retina.magnitude(c_e)) / v.C_omega
        g = s * c_e / omega
        g_kept = g * self.thresholds.s(v.C_de * g, v.T_de)
        k = pool(retina.magnitude(g_kept))
        f = unless_nan(k, retina.mean_change(state.p))  # of the frame before, but NaN in the same
        layers = YueRindLayers(p, inhibition, s, c_e, g, g_kept, retina.magnitude(state.p))
        return YueRindPixelState(frame, p), Sums(k, f), layers


class YueRindCellState(eqx.Module):
    """What the cell keeps: the threshold T of the FFI, and the spikes of the last frames."""

    threshold: Scalar
    spikes: Float[Array, " N_sp_less_one"]


class YueRindCell(AbstractCell):
    """From K and F to spikes and alarm."""

    parameters: YueRindParameters
    thresholds: Thresholds
    N_sp: int = eqx.field(static=True)

    def rest(self) -> YueRindCellState:
        return YueRindCellState(self.parameters.T_ffi, jnp.zeros(self.N_sp - 1, self.parameters.dtype))

    def step(self, state, sums, interval, pixels):
        v, one = self.parameters, jnp.ones_like(sums.mp)
        threshold = v.T_ffi + v.alpha_ffi * state.threshold
        kappa = gated(retina.magnitude(sums.mp) / (pixels * v.k), one)
        # The gate lets a tie pass, but F = T forbids a spike: hence the number just below T.
        passes = self.thresholds.ffi(sums.f, threshold * (1 - jnp.finfo(sums.f.dtype).eps))
        spikes = passes * self.thresholds.spikes(kappa, v.T_sp, one)  # kappa < 1 never reaches a second one
        window = jnp.append(state.spikes, spikes)
        collision = self.thresholds.collision(window.sum(), jnp.full_like(sums.f, self.N_sp))
        return YueRindCellState(threshold, window[1:]), Response(*sums, kappa, kappa, spikes, collision)


@checked
class YueRindLGMD1(AbstractNetwork):
    """The LGMD1 network of Yue & Rind 2006, which is called, fitted and characterised as an `LGMD2` is.

    ```python
    lgmd1 = YueRindLGMD1(eye=eye)
    response = lgmd1(frames, fps)
    ```

    P(t) = L(t) - L(t-1) + p_1 P(t-1) with p_1 = 1/(1 + exp(u)); I = W * P(t-1); S = P - W_I I. Grouping: C_e is the 3x3
    mean of S, omega = Delta_C + max abs(C_e)/C_omega, G = S C_e/omega, kept where C_de G >= T_de. K = sum abs(G),
    kappa = 1/(1 + exp(-K/(n k))). There is a spike where kappa >= T_sp, but none where F = mean abs(P(t-1)) reaches
    T(t) = T_ffi + alpha_ffi T(t-1), with T(-1) = T_ffi.

    What a `Response` holds, so that curves of both networks may stand on one pair of axes:

    - `mp`: K, which is what the sigmoid sees. `ffi`: F(t) as it is compared with T(t), one frame old and not delayed.
    - `smp` and `smp_adapted`: both kappa, since the LGMD1 does not adapt. Here FFI forbids spikes and leaves the
      potential, where the LGMD2's falls to rest: compare potentials of small motion, spikes of what fills the field.
      `characterise` reads potentials, so that the properties do not see this FFI.
    - `spikes`: 0 or 1. `collision`: whether the last N_sp frames all had a spike.

    Nothing in it depends on the length of a frame. Its values belong to a frame rate all the same: `at_frame_rate`.

    **Arguments:**

    - `parameters`: those published; they belong to a frame rate and a field of view.
    - `thresholds`: as of an `LGMD2`. Of the widths, `s` is that of T_de.
    - `N_sp`: successive spikes that make an alarm.
    - `eye`: the sampling that the parameters belong to; where it is given, `fps` may be left out of a call.

    **Raises:** `ValueError` for structure that does not exist and for persistence that is not stable.
    """

    parameters: YueRindParameters = eqx.field(default_factory=YueRindParameters)
    thresholds: Thresholds = eqx.field(default_factory=Hard)
    N_sp: int = counts(4, "spikes", least=1, at_interval=lambda spikes, ratio: max(round(spikes / ratio), 1))
    eye: Eye | None = eqx.field(default=None, static=True)

    @property
    def pixels(self) -> YueRindPixels:
        return YueRindPixels(self.parameters, self.thresholds)

    @property
    def cell(self) -> YueRindCell:
        return YueRindCell(self.parameters, self.thresholds, self.N_sp)

    @property
    def ablations(self):
        return {"ffi": {"T_ffi": 1e9}, "lateral": {"W_I": 0.0}}

    @property
    def levels(self) -> Levels:
        """T is what it settles at, within two frames."""
        v = self.parameters
        return Levels((float(v.T_sp),), float(v.T_ffi / (1 - v.alpha_ffi)))

    def conflicts(self):
        return retina.unstable_persistence(self.parameters.u, 1)
