# %% [markdown]
# # A robot in the paper's arena
# The loop is closed: what a camera sees moves a robot, which changes what the camera sees. White walls and 10 to 20
# cylinders with dark patterns, 110 x 110 cm, a robot of 4 cm, a camera of 72 x 99 pixels at 30 frames a second.

# %%
import jax
import jax.numpy as jnp
import numpy as np

from lgmd2jax import arena
from notebooks import plots

layout = arena.random_layout(0)
print(f"{len(layout.radii)} obstacles; noise of {layout.noise:.1f} grey levels, {layout.flicker:.1%} flicker")

# %% [markdown]
# What the camera sees every 3 cm of the first drive, without noise.

# %%
start = arena.Start.of(0)
see = jax.jit(lambda place: arena.render(arena.EYE, start.scene, place, start.pose.heading))
ahead = np.array([np.cos(layout.heading), np.sin(layout.heading)])
places = [layout.start + 3 * step * ahead for step in range(4)]
images = [np.asarray(see(jnp.asarray(place, jnp.float32))) for place in places]
plots.pictures({f"{3 * step} cm": np.stack(3 * [image / 255], axis=-1) for step, image in enumerate(images)})

# %% [markdown]
# Without a detector the robot turns where it ran into something. With the fitted LGMD2 it turns at its alarms.

# %%
detectors = arena.detectors()
layouts, blind = arena.run(detectors["none"], range(4))
plots.trajectories(layouts, blind, "no detector")

# %%
layouts, seeing = arena.run(detectors["lgmd2"], range(4))
plots.trajectories(layouts, seeing, "the fitted LGMD2")

# %% [markdown]
# All detectors in eight arenas; `lgmd2jax arena --seeds 100` takes a hundred. Coverage tells a robot that drives from
# one that spins.

# %%
outcomes = {name: arena.Outcome.of(*arena.run(detector, range(8))) for name, detector in detectors.items()}
for name, outcome in outcomes.items():
    print(f"{name:11} {outcome.collisions_per_metre!s:24} collisions a metre, coverage {outcome.coverage!s}")

# %% [markdown]
# A second policy turns away from the side of more evidence, by 45 to 135 degrees, instead of to a random one.

# %%
away = arena.Outcome.of(*arena.run(detectors["lgmd2"], range(8), turn="away"))
print(f"lgmd2, away {away.collisions_per_metre!s:24} collisions a metre, coverage {away.coverage!s}")
