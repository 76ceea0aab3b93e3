# %% [markdown]
# # The paper reproduced: the robot
# Figs. 15 to 19, as the robot's camera sees them: 72 x 99 pixels at 30 frames per second, with noise; ten repeats in
# other noise and another phase of the camera's clock. Sizes, speeds and grey levels that the text does not tell are
# assumed.

# %%
from notebooks import plots
from notebooks.paper_claims import ROBOT_T_SP, robot, told

LEVELS, T_FFI = (ROBOT_T_SP, ROBOT_T_SP + 0.1), 10

# %% [markdown]
# ## Approach from overhead (Fig. 15)

# %%
slopes = {f"slope of {h} cm": it for h, it in zip(robot.SLOPES_CM, robot.overhead(), strict=True)}
plots.adaptation(slopes, LEVELS, since_ms=-600)

# %%
told(21)

# %% [markdown]
# ## Five balls, before bright and before dark ground (Fig. 17)

# %%
plots.repeats(robot.balls("bright"), LEVELS, T_FFI, "balls of five grey levels on 230")

# %%
plots.repeats(robot.balls("dim"), LEVELS, T_FFI, "balls of five grey levels on 10")

# %%
told(22, 23)

# %% [markdown]
# ## Translations by speed and by distance (Figs. 18, 19)

# %%
plots.adaptation(robot.crossings(), LEVELS)

# %% [markdown]
# The same with a paler ball, 130 on 220, at a fifth of the speeds.

# %%
plots.adaptation(robot.crossings(**robot.PALE_AND_SLOW), LEVELS)

# %%
told(24, 25)
