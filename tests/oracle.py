"""The network once more, as loops over pixels straight from the equations: an oracle that shares nothing."""

import math

WEIGHTS = [[0.125, 0.25, 0.125], [0.25, 0.0, 0.25], [0.125, 0.25, 0.125]]
CHANNELS = ("mp", "ffi", "smp", "smp_adapted", "spikes", "collision")
SIDES = ("mp_sides", "f_sides")


def logistic(x):
    return 1 / (1 + math.exp(-x)) if x > 0 else math.exp(x) / (1 + math.exp(x))


def respond(frames, fps, v, temperature=None, n_p=0, low_pass="backward_euler", N_ts=4, mechanisms=(), intervals=None):
    """The channels over time and the S layer, from nested lists of grey levels and a dict of parameters.

    Without a temperature thresholds are hard. `intervals`, ms since the frame before, stand in the place of `fps`.
    """
    rows, cols = len(frames[0]), len(frames[0][0])
    intervals = [1000 / fps] * len(frames) if intervals is None else intervals
    pixels = [(x, y) for x in range(rows) for y in range(cols)]
    outer = round(cols / 3)  # columns of the left and of the right third

    def step(distance, width):
        """1 where distance >= 0."""
        if temperature is None:
            return 1.0 if distance >= 0 else 0.0
        return logistic(distance / (temperature * width))

    def coefficient(tau):
        if tau == 0:
            return 1.0
        return ti / (ti + tau) if low_pass == "backward_euler" else 1 - math.exp(-ti / tau)

    def changed(d, height):
        """Whether a pixel counts as changed: 0 or 1, or between them, and then 0 at rest."""
        if temperature is None:
            return 1.0 if d > height else 0.0
        at_rest = step(-height, 0.1 * height)
        return (step(d - height, 0.1 * height) - at_rest) / (1 - at_rest)

    def lagged(values, t):
        """The value of `lag` ms before frame t, on a line between frames; 0 before the first one."""
        moments = [sum(intervals[1 : i + 1]) for i in range(t + 1)]
        moment = moments[t] - v["lag"]
        if moment < 0:
            return 0.0
        i = max(i for i in range(t + 1) if moments[i] <= moment)
        if i == t:
            return values[t]
        return values[i] + (values[i + 1] - values[i]) * (moment - moments[i]) / (moments[i + 1] - moments[i])

    def zeros():
        return [[0.0] * cols for _ in range(rows)]

    def inside(i, size):
        return min(max(i, 0), size - 1)

    def spread(d, x, y):
        total = 0.0
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                total += WEIGHTS[i + 1][j + 1] * d[inside(x + i, rows)][inside(y + j, cols)]
        return total

    kept = 1 if "lamina" in mechanisms else n_p
    before, history = frames[0], [zeros() for _ in range(kept)]
    on, off, d_on, d_off = zeros(), zeros(), zeros(), zeros()
    held, fatigue = zeros(), zeros()
    ffi, excitation, u_before, adapted, spikes_before = 0.0, 0.0, 0.5, 0.5, [0.0] * N_ts
    told = []
    out = {name: [] for name in (*CHANNELS, *SIDES, "f", "s", "s_gated", "g", "rise", "unfloored", "d")}

    for t, (frame, ti) in enumerate(zip(frames, intervals, strict=True)):
        p = zeros()
        for x, y in pixels:  # eq. 1
            p[x][y] = frame[x][y] - before[x][y]
            if "lamina" in mechanisms:  # what came at a steady rate since the frame before, and faded since then
                left = math.exp(-ti / v["tau_lamina"])
                p[x][y] = p[x][y] / ti * v["tau_lamina"] * (1 - left) + left * history[0][x][y]
            for i in range(1, n_p + 1):
                p[x][y] += history[i - 1][x][y] / (1 + math.exp(v["u"] * i))
        before, history = frame, [p, *history][:kept]

        for x, y in pixels:  # eqs 2-4
            on[x][y] = max(p[x][y], 0.0) + v["sigma1"] * on[x][y]
            off[x][y] = max(-p[x][y], 0.0) + v["sigma1"] * off[x][y]
            d_on[x][y] += coefficient(v["tau1"]) * (on[x][y] - d_on[x][y])
            d_off[x][y] += coefficient(v["tau1"]) * (off[x][y] - d_off[x][y])

        s, gated, g = zeros(), zeros(), zeros()
        for x, y in pixels:  # eqs 5-9
            s_on = on[x][y] - v["w_bias"] * spread(d_on, x, y)
            s_off = spread(d_off, x, y) - v["w_bias"] * off[x][y]
            s[x][y] = v["theta1"] * s_on + v["theta2"] * s_off + v["theta3"] * s_on * s_off
            if "habituation" in mechanisms:  # what excited so far divides what excites now
                s[x][y] /= 1 + fatigue[x][y] / v["S_hab"]
                fatigue[x][y] += coefficient(v["tau_hab"]) * (max(s[x][y], 0.0) - fatigue[x][y])
            gated[x][y] = s[x][y] * step(s[x][y] - v["T_s"], 0.1 * v["T_s"])
        for x, y in pixels:  # eq. 10
            for i in (-1, 0, 1):
                for j in (-1, 0, 1):
                    g[x][y] += gated[inside(x + i, rows)][inside(y + j, cols)] / 9
        mp = sum(g[x][y] for x, y in pixels)  # eq. 11

        delayed = [[d_on[x][y] + d_off[x][y] for y in range(cols)] for x in range(rows)]
        if "size" in mechanisms:  # the share of the field that changed recently
            height = v["T_p"] if "lamina" in mechanisms else coefficient(v["tau1"]) * v["T_p"]
            for x, y in pixels:
                now = changed(delayed[x][y], height)
                held[x][y] = now + (1 - now) * math.exp(-ti / v["tau_hold"]) * held[x][y]
            f, threshold = sum(held[x][y] for x, y in pixels) / len(pixels), v["A_ffi"]
        else:  # eq. 13
            f, threshold = sum(abs(p[x][y]) for x, y in pixels) / len(pixels), v["T_ffi"]
        out["mp"].append(mp)
        out["f"].append(f)
        addends = held if "size" in mechanisms else [[abs(value) for value in row] for row in p]
        for name, layer, count in (("mp_sides", gated, 1), ("f_sides", addends, len(pixels))):
            shares = [0.0, 0.0, 0.0]
            for x, y in pixels:
                shares[0 if y < outer else 2 if y >= cols - outer else 1] += layer[x][y] / count
            out[name].append(shares)
        if "rate" in mechanisms:  # as in a thirtieth of a second; a share of the field is not a change
            per_time = 1000 / 30 / ti
            mp, f = mp * per_time, f if "size" in mechanisms else f * per_time
        told.append((mp, f))
        if "lag" in mechanisms:
            mp, f = (lagged(values, t) for values in zip(*told, strict=True))

        ffi += coefficient(v["tau2"]) * (f - ffi)  # eq. 14
        drive = abs(mp) / (len(pixels) * v["k"])
        if "shunt" in mechanisms:
            power = (drive + 1e-3) ** v["gamma"] - 1e-3 ** v["gamma"]
            x_now = power / (1 + ((ffi + 1e-12) / threshold) ** v["m"])
            share = coefficient(v["tau_cell"]) if "membrane" in mechanisms else 1.0
            excitation += share * (x_now - excitation)
            u = logistic(excitation)
        else:
            passes = step(threshold - ffi, 0.03 * threshold)
            u = 0.5 + passes * (logistic(drive) - 0.5)  # eq. 12

        c, rise = v["tau3"] / (v["tau3"] + ti), u - u_before  # eq. 15
        adapts = step(v["T_sfa"] - rise, abs(v["T_sfa"]))
        unfloored = adapts * c * (adapted + rise) + (1 - adapts) * c * u
        if temperature is None:
            adapted = max(unfloored, 0.5)
        else:
            z = (unfloored - 0.5) / (0.002 * temperature)
            adapted = 0.5 + 0.002 * temperature * (max(z, 0) + math.log1p(math.exp(-abs(z))))
        u_before = u

        if temperature is None:  # eq. 16
            spikes = 0.0 if adapted < v["T_sp"] else 1.0 if adapted <= v["T_sp"] + v["sigma_sp"] else 2.0
        else:
            spikes = step(adapted - v["T_sp"], 0.01) + step(adapted - v["T_sp"] - v["sigma_sp"], 0.01)
        window = [*spikes_before, spikes]  # eq. 17
        spikes_before = window[1:]
        half = 0 if temperature is None else 0.5
        collision = step(sum(window) - (v["N_sp"] - half), 0.1)

        for name, value in (
            ("ffi", ffi), ("smp", u), ("smp_adapted", adapted), ("spikes", spikes), ("collision", collision), ("s", s),
            ("s_gated", gated), ("g", g), ("rise", rise), ("unfloored", unfloored), ("d", delayed),
        ):  # fmt: skip
            out[name].append(value)
    return out
