"""The networks that are known by name: in hand-over files, in recipes and on the command line."""

from collections.abc import Mapping

from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.yue_rind import YueRindLGMD1

NETWORKS: Mapping[str, type[AbstractNetwork]] = {kind.__name__: kind for kind in (LGMD2, YueRindLGMD1)}
