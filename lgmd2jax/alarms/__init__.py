"""Fits to labelled clips: an alarm in time, silence otherwise.

`load_footage` reads clips with their labels, `fit` fits a model to them, `watch` says what a model does on them.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
