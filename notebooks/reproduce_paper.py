# %% [markdown]
# # The paper reproduced: synthetic stimuli
# Fu, Hu & Yue, arXiv 1801.06452, Figs. 5 to 9: the LGMD2 with Table I and the LGMD1 of Yue & Rind on the same axes.
# Below each figure stands what the paper claims, what was measured, and whether it holds; all 32 claims are in
# [claims.md](claims.md). The LGMD1's FFI forbids its spikes and leaves the SMP that is drawn here.

# %%
from notebooks import plots
from notebooks.paper_claims import T_SP, shown, synthetic, told


def both(*conditions):
    return {name: {net: shown(net, "paper", name) for net in ("LGMD2", "LGMD1")} for name in conditions}


# %% [markdown]
# ## Approach and recession (Fig. 5)

# %%
plots.networks(both("dark approach and recession", "light approach and recession"), T_SP)

# %%
told(1, 2, 3, 4, 5)

# %% [markdown]
# ## Contrast and speed (Fig. 6)

# %%
peaks = synthetic.peaks_by_contrast_and_speed()
plots.by_contrast(peaks, synthetic.CONTRASTS, synthetic.EDGE_SPEEDS, T_SP)

# %%
told(6, 7)

# %% [markdown]
# ## Translation (Fig. 7a, b)

# %%
plots.networks(both(*synthetic.TRANSLATIONS), T_SP)

# %%
told(8, 9, 10)

# %% [markdown]
# ## Elongation and shortening (Fig. 7c, d)

# %%
plots.networks(both(*synthetic.EDGES), T_SP)

# %%
told(11, 12)

# %% [markdown]
# ## Luminance of a sub-field (Fig. 8)
# A quarter of the field, by ramps of one second; then by steps, which the paper's text does not tell apart.

# %%
steps = [name.replace("1000 ms", "0 ms") for name in synthetic.LIGHTS]
plots.networks(both(*synthetic.LIGHTS, *steps), T_SP)

# %%
told(13)

# %% [markdown]
# ## Gratings (Fig. 9)

# %%
plots.gratings({name: shown("LGMD2", "paper", name) for name in synthetic.GRATINGS}, T_SP)

# %%
told(14)
