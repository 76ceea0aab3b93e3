"""Small protocols, labels and recipes that several tests and benchmarks carry out."""

TWO_LOOMS = """
[eye]
rows = 10
cols = 12
degrees_per_pixel = 8
fps = 50

[[target]]
model = "preset:lgmd2"
parameters = { k = 0.4, T_ffi = 12, T_s = 5, tau3 = 250 }
channel = "smp_adapted"

[[condition]]
name = "loom {l_over_v}"
family = "looming"
l_over_v = [20, 40]
contrast = -0.9
start_ms = -500
end_ms = 200
"""
# What is fitted to them, without a search.
FREE_K_AND_TAU3 = """
protocol = "looms.toml"
[parameters]
T_ffi = 12
T_s = 5
[free]
k = { low = 0.1, high = 2, scale = "log" }
tau3 = { low = 100, high = 1000 }
"""
CLIPS_EYE = """
[eye]
rows = 12
cols = 18
degrees_per_pixel = 4
fps = 30
projection = "pinhole"
"""
SIX_CLIPS = f"""{CLIPS_EYE}
[rendered]
count = 6
seed = 2
"""
