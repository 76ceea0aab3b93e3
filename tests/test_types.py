"""Keys of JAX, and what users give in their place."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax._types import check_key

EYE = lgmd.Eye(rows=6, cols=8, degrees_per_pixel=10.0, fps=50.0)


@pytest.mark.parametrize("key", [jax.random.key(0), jax.random.PRNGKey(1)])
def test_keys_of_both_kinds_pass(key):
    check_key(key)
    jax.jit(lambda key: check_key(key))(key)


def takers():
    stimulus = lgmd.stimuli.looming(EYE, l_over_v=20.0, contrast=-0.9, start_ms=-300.0, end_ms=60.0)
    pairs = [(stimulus, lgmd.Rest())]
    return {
        "fit": lambda key: lgmd.fit(lgmd.LGMD2(), pairs, lgmd.Free(k=None), key=key),
        "alarms": lambda key: lgmd.alarms.fit(lgmd.LGMD2(), [], lgmd.Free(k=None), key=key),
        "camera": lambda key: lgmd.stimuli.camera(stimulus, key),
        "encounters": lambda key: list(lgmd.stimuli.encounters(EYE, key, 1)),
        "target": lambda key: lgmd.ModelTarget(model=lgmd.LGMD2(), noise=0.1, key=key),
    }


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize("key", [0, np.random.default_rng(0), np.zeros(2, np.uint32), jnp.zeros(3), "seed"])
@pytest.mark.parametrize("name", takers())
def test_what_is_no_key_is_refused(name, key):
    with pytest.raises(ValueError, match=r"^key is .*; give one of JAX's, such as jax.random.key\(0\)$"):
        takers()[name](key)
