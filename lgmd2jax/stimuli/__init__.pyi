# The public names. `__init__.py` loads each of them when it is first used.
from ._approach import (
    approach_recession as approach_recession,
    looming as looming,
    receding as receding,
)
from ._background import (
    BACKGROUNDS as BACKGROUNDS,
    Background as Background,
    Panorama as Panorama,
    Photograph as Photograph,
    Uniform as Uniform,
)
from ._camera import camera as camera
from ._distance import (
    DISTANCES as DISTANCES,
    Distance as Distance,
    Rolling as Rolling,
    Tabulated as Tabulated,
)
from ._elongation import elongating as elongating, shortening as shortening
from ._encounter import (
    ENCOUNTERS as ENCOUNTERS,
    Encounter as Encounter,
    encounter as encounter,
    encounters as encounters,
)
from ._family import FAMILIES as FAMILIES
from ._grating import grating as grating
from ._luminance import luminance as luminance
from ._stimulus import Stimulus as Stimulus
from ._texture import PHOTOGRAPHS as PHOTOGRAPHS
from ._translation import translating as translating
from ._turning import turning as turning
