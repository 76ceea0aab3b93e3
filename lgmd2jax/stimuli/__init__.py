"""Everything that is shown to a locust: renderers in JAX, pure functions of array parameters.

Each family is called as `family(eye, *, ...)` and returns a `Stimulus`. Numbers may be traced, so that a family jits,
vmaps and differentiates; what shapes the result (window, names, number of checks) is plain Python.

`encounters(eye, key, count)` makes random clips from these families, as a camera delivers them: collisions of dark
objects with the time to contact, and as many clips without one. `films(eye, key, count)` makes them with the statistics
of real films: cameras in traffic, on robots and in hands, in a street of three dimensions.
"""

# All at once, since a family is known by name once its module is loaded.
from lgmd2jax.stimuli._background import (
    BACKGROUNDS as BACKGROUNDS,
    Background as Background,
    Panorama as Panorama,
    Photograph as Photograph,
    Uniform as Uniform,
)
from lgmd2jax.stimuli._camera import camera as camera
from lgmd2jax.stimuli._distance import (
    DISTANCES as DISTANCES,
    Distance as Distance,
    Rolling as Rolling,
    Tabulated as Tabulated,
)
from lgmd2jax.stimuli._elongation import elongating as elongating, shortening as shortening
from lgmd2jax.stimuli._encounter import (
    ENCOUNTERS as ENCOUNTERS,
    Encounter as Encounter,
    encounter as encounter,
    encounters as encounters,
    random_encounter as random_encounter,
)
from lgmd2jax.stimuli._family import FAMILIES as FAMILIES
from lgmd2jax.stimuli._film import FILMS as FILMS, films as films, random_film as random_film
from lgmd2jax.stimuli._grating import grating as grating
from lgmd2jax.stimuli._looming import (
    approach_recession as approach_recession,
    looming as looming,
    receding as receding,
)
from lgmd2jax.stimuli._luminance import luminance as luminance
from lgmd2jax.stimuli._stimulus import Stimulus as Stimulus
from lgmd2jax.stimuli._texture import PHOTOGRAPHS as PHOTOGRAPHS
from lgmd2jax.stimuli._translation import translating as translating
from lgmd2jax.stimuli._turning import turning as turning
