"""The channels of a response: what each is called, its unit, where it rests and how far it goes."""

from collections.abc import Mapping
from typing import Literal, NamedTuple

# Those that a curve can be recorded in. The rate is the adapted potential through an `Observation`.
Channel = Literal["smp", "smp_adapted", "spikes", "rate"]


class Description(NamedTuple):
    """What is known of a channel.

    - `unit`: as in the files, "1" for none. `meaning`: with its equation.
    - `label`: at the axis of a figure.
    - `rest`: without a stimulus; None where the network has no value of its own for that.
    - `span`: how far it can go; None without a limit.
    """

    unit: str
    meaning: str
    label: str
    rest: float | None = None
    span: float | None = None


# What a network answers, frame by frame.
RESPONSE: Mapping[str, Description] = {
    "mp": Description("grey level", "summed potential MP (eq. 11)", "MP"),
    "ffi": Description("grey level", "delayed feed-forward inhibition (eq. 14)", "FFI"),
    "smp": Description("1", "membrane potential U before adaptation (eq. 12)", "SMP", 0.5, 0.5),
    "smp_adapted": Description("1", "membrane potential U' after adaptation (eq. 15)", "adapted SMP", 0.5, 0.5),
    "spikes": Description("spikes", "spikes in each frame (eq. 16)", "spikes a frame", 0.0, 2.0),
    "collision": Description("1", "collision alarm (eq. 17)", "alarm", 0.0, 1.0),
}
# What a fit compares with: panels of a figure stand in this order.
TARGETS: Mapping[Channel, Description] = {
    "rate": Description("spikes/s", "firing rate", "firing rate"),
    "smp_adapted": RESPONSE["smp_adapted"],
    "smp": RESPONSE["smp"],
    "spikes": RESPONSE["spikes"]._replace(unit="spikes/frame"),
}
