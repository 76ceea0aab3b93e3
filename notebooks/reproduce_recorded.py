# %% [markdown]
# # The paper reproduced: real scenes
# Figs. 10 to 13. What the paper filmed is replaced: photographs, a camera with noise, and repeats that
# differ in noise and in the phase of the camera's clock. Sizes, speeds and grey levels that the text does not tell are
# assumed.

# %%
from notebooks import plots
from notebooks.paper_claims import T_SP, recorded, shown, told

LEVELS = (T_SP, T_SP + 0.1)

# %% [markdown]
# ## Approach and recession over a photograph (Fig. 10)

# %%
approach = shown("LGMD2", "cluttered", "approach over camera", recorded.FEWER, **recorded.WINDOW)
recession = shown("LGMD2", "cluttered", "recession over camera", recorded.FEWER, end_ms=1500)
plots.adaptation({"approach over a photograph": approach, "recession": recession}, LEVELS)

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
