"""The network in PyTorch, eager, with autograd: hard for the response, soft for the gradient."""

from collections.abc import Callable
from typing import NamedTuple

import torch
from torch import Tensor
from torch.nn.functional import pad, softplus

from lgmd2jax.hard import Response

_ALL_THREADS = torch.get_num_threads()


class Thresholds(NamedTuple):
    """What passes at each threshold, 0 to 1, and the floor of U'."""

    s: Callable[[Tensor], Tensor]
    ffi: Callable[[Tensor], Tensor]
    sfa: Callable[[Tensor], Tensor]
    floor: Callable[[Tensor], Tensor]


@torch.no_grad()
def respond(frames, parameters, fps, threads: int | None = None) -> Response:
    """The response to a clip, with hard thresholds; on all threads where their number is not given."""
    torch.set_num_threads(threads or _ALL_THREADS)
    v = {name: torch.tensor(value) for name, value in parameters._asdict().items()}
    hard = Thresholds(
        s=lambda s: s >= v["T_s"],
        ffi=lambda ffi: ffi <= v["T_ffi"],
        sfa=lambda rise: rise <= v["T_sfa"],
        floor=lambda u: torch.clamp(u, min=0.5),
    )
    mp, ffi, smp, adapted = _clip(torch.from_numpy(frames).float(), v, 1000 / fps, hard)
    spikes = (adapted >= v["T_sp"]).int() + (adapted > v["T_sp"] + v["sigma_sp"]).int()
    collision = pad(spikes, (4, 0)).unfold(0, 5, 1).sum(1) >= v["N_sp"]
    return Response(*(channel.numpy() for channel in (mp, ffi, smp, adapted, spikes, collision)))


def gradient(frames, parameters, fps, threads: int | None = None) -> dict[str, float]:
    """The gradient of the sum of U' over a clip, with soft thresholds, by every parameter that has an effect."""
    torch.set_num_threads(threads or _ALL_THREADS)
    v = {name: torch.tensor(value, requires_grad=True) for name, value in parameters._asdict().items()}
    soft = Thresholds(
        s=lambda s: torch.sigmoid((s - v["T_s"]) / (0.1 * v["T_s"])),
        ffi=lambda ffi: torch.sigmoid((v["T_ffi"] - ffi) / (0.03 * v["T_ffi"])),
        sfa=lambda rise: torch.sigmoid((v["T_sfa"] - rise) / v["T_sfa"].abs()),
        floor=lambda u: 0.5 + 0.002 * softplus((u - 0.5) / 0.002),
    )
    _clip(torch.from_numpy(frames).float(), v, 1000 / fps, soft)[-1].sum().backward()
    return {name: float(value.grad) for name, value in v.items() if value.grad is not None}


def _clip(frames, v, interval, thresholds):
    """Eqs 1-15: MP, Fbar, U and U' over a clip."""
    p = torch.diff(frames, dim=0, prepend=frames[:1])
    mp = _pixels(p, v, interval, thresholds)
    return mp, *_cell(mp, p.abs().mean((1, 2)), v, interval, p[0].numel(), thresholds)


def _pixels(p, v, interval, thresholds):
    """Eqs 2-11. ON and OFF are the two channels of one map."""
    a = interval / (interval + v["tau1"])
    flows = delayed = torch.zeros(2, *p.shape[1:])
    mp = []
    for now in p:
        flows = torch.relu(torch.stack((now, -now))) + v["sigma1"] * flows
        delayed = torch.lerp(delayed, flows, a)
        spread = _lateral(delayed)
        s_on = flows[0] - v["w_bias"] * spread[0]
        s_off = spread[1] - v["w_bias"] * flows[1]
        s = v["theta1"] * s_on + v["theta2"] * s_off + v["theta3"] * s_on * s_off
        mp.append((s * thresholds.s(s)).sum())
    return torch.stack(mp)


def _lateral(d):
    """Eqs 5 and 6 by slices, which run two to three times as fast as `conv2d`."""
    x = pad(d[None], (1, 1, 1, 1), mode="replicate")[0]
    x = x[:, :-2] + 2 * x[:, 1:-1] + x[:, 2:]
    return (x[..., :-2] + 2 * x[..., 1:-1] + x[..., 2:]) / 8 - d / 2


def _cell(mp, f, v, interval, pixels, thresholds):
    """Eqs 12, 14 and 15: Fbar, U and U' over the clip."""
    a, kept = interval / (interval + v["tau2"]), v["tau3"] / (v["tau3"] + interval)
    ffi = [torch.zeros(())]
    for value in f.unbind():
        ffi.append(torch.lerp(ffi[-1], value, a))
    ffi = torch.stack(ffi[1:])
    smp = 0.5 + thresholds.ffi(ffi) * (torch.sigmoid(mp.abs() / (pixels * v["k"])) - 0.5)
    rise = torch.diff(smp, prepend=torch.full((1,), 0.5))
    adapted = [torch.tensor(0.5)]
    for u, d, share in zip(smp.unbind(), rise.unbind(), thresholds.sfa(rise).unbind(), strict=True):
        adapted.append(thresholds.floor(kept * (u + share * (adapted[-1] + d - u))))
    return ffi, smp, torch.stack(adapted[1:])
