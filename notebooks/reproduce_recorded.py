# %% [markdown]
# # The paper reproduced: real scenes and the robot
# Figs. 10 to 13 and 15 to 19. What the paper filmed is replaced: photographs, a camera with noise, and repeats that
# differ in noise and in the phase of the camera's clock. Sizes, speeds and grey levels that the text does not tell are
# assumed.

# %%
from notebooks import plots
from notebooks.paper_claims import ROBOT_T_SP, T_SP, recorded, robot, shown, told

LEVELS, ROBOT_LEVELS = (T_SP, T_SP + 0.1), (ROBOT_T_SP, ROBOT_T_SP + 0.1)

# %% [markdown]
# ## Approach and recession over a photograph (Fig. 10)

# %%
names = ("approach over camera", "recession over camera")
plots.adaptation({name: shown("LGMD2", "cluttered", name, recorded.FEWER) for name in names}, LEVELS)

# %%
told(15, 16)

# %% [markdown]
# ## Angles of approach, ten repeats (Fig. 11)

# %%
plots.repeats(recorded.approaches(), LEVELS, recorded.T_FFI, "approach at four angles to the line of sight")

# %%
told(17)

# %% [markdown]
# ## Translation over clutter, five repeats (Fig. 12)

# %%
plots.repeats(recorded.translations(), LEVELS, recorded.T_FFI, "translation over a photograph, by mean speed")

# %%
told(18, 19)

# %% [markdown]
# ## The eye turns (Fig. 13)

# %%
turns = {
    f"{s} deg/s": shown("LGMD2", "cluttered", f"turning left at {s} deg/s", recorded.FEWER) for s in recorded.TURNS
}
plots.repeats(turns, LEVELS, recorded.T_FFI, "a turn to the left in a cluttered scene")

# %%
told(20)

# %% [markdown]
# ## The robot: approach from overhead (Fig. 15)

# %%
plots.adaptation(
    {f"slope of {h} cm": it for h, it in zip(robot.SLOPES_CM, robot.overhead(), strict=True)}, ROBOT_LEVELS
)

# %%
told(21)

# %% [markdown]
# ## The robot: five balls, before bright and before dark ground (Fig. 17)

# %%
plots.repeats(robot.balls("bright"), ROBOT_LEVELS, recorded.T_FFI, "balls of five grey levels on 230")

# %%
plots.repeats(robot.balls("dim"), ROBOT_LEVELS, recorded.T_FFI, "balls of five grey levels on 10")

# %%
told(22, 23)

# %% [markdown]
# ## The robot: translations by speed and by distance (Figs. 18, 19)

# %%
plots.adaptation(robot.crossings(), ROBOT_LEVELS)

# %%
plots.adaptation(robot.crossings(**robot.PALE_AND_SLOW), ROBOT_LEVELS)

# %%
told(24, 25)
