"""The network in OpenCV and NumPy: a call for each operation on a frame, in float32, in place where possible."""

import cv2
import numpy as np

from benchmarks._cell import REST, cell_step
from lgmd2jax.hard import Response

_LATERAL = np.array([[0.125, 0.25, 0.125], [0.25, 0, 0.25], [0.125, 0.25, 0.125]], np.float32)


def respond(frames, parameters, fps) -> Response:
    """The response to a clip; OpenCV takes as many threads as it likes."""
    interval, pixels = 1000 / fps, frames[0].size
    potentials, cell, now = _Pixels(frames[0], parameters, interval), REST, []
    for frame in frames:
        mp, f = potentials.step(frame)
        cell, collision = cell_step(cell, mp, f, parameters, interval, pixels)
        now.append(Response(mp, cell.ffi, cell.smp, cell.smp_adapted, cell.spikes[3], collision))
    return Response.over_time(now)


class _Pixels:
    """Eqs 1-11 and 13, with the maps kept from frame to frame."""

    def __init__(self, frame, parameters, interval):
        self.v, self.a = parameters, float(interval / (interval + parameters.tau1))
        self.below_T_s = float(np.nextafter(np.float32(parameters.T_s), np.float32(-np.inf)))
        self.before = frame
        self.on, self.off, self.d_on, self.d_off = np.zeros((4, *frame.shape), np.float32)
        self.p, self.wave, self.s, self.s_on, self.s_off = np.empty((5, *frame.shape), np.float32)

    def step(self, frame):
        v, p, s, s_on, s_off = self.v, self.p, self.s, self.s_on, self.s_off
        cv2.subtract(frame, self.before, dst=p, dtype=cv2.CV_32F)
        self.before = frame
        cv2.threshold(p, 0, 0, cv2.THRESH_TOZERO, dst=self.wave)
        cv2.scaleAdd(self.on, v.sigma1, self.wave, dst=self.on)
        cv2.subtract(self.wave, p, dst=self.wave)
        cv2.scaleAdd(self.off, v.sigma1, self.wave, dst=self.off)
        cv2.accumulateWeighted(self.on, self.d_on, self.a)
        cv2.accumulateWeighted(self.off, self.d_off, self.a)
        cv2.filter2D(self.d_on, -1, _LATERAL, dst=s_on, borderType=cv2.BORDER_REPLICATE)
        cv2.filter2D(self.d_off, -1, _LATERAL, dst=s_off, borderType=cv2.BORDER_REPLICATE)
        cv2.scaleAdd(s_on, -v.w_bias, self.on, dst=s_on)
        cv2.scaleAdd(self.off, -v.w_bias, s_off, dst=s_off)
        cv2.multiply(s_on, s_off, dst=s, scale=v.theta3)
        cv2.scaleAdd(s_on, v.theta1, s, dst=s)
        cv2.scaleAdd(s_off, v.theta2, s, dst=s)
        # THRESH_TOZERO passes what is above its threshold; eq. 9 passes what is on it too.
        cv2.threshold(s, self.below_T_s, 0, cv2.THRESH_TOZERO, dst=s)
        return cv2.sumElems(s)[0], cv2.norm(p, cv2.NORM_L1) / p.size
