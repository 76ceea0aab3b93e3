"""What newer releases of JAX do in another way."""

import jax

# A step alone and in a scan over frames were compiled alike, to the bit, up to 0.10.
AFTER_JAX_0_10 = jax.__version_info__ >= (0, 11)
