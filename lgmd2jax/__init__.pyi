# The public names. `__init__.py` loads each of them when it is first used.
from . import alarms as alarms, arena as arena, fitting as fitting, stimuli as stimuli
from ._characterise import (
    Characterisation as Characterisation,
    Finding as Finding,
    ablations as ablations,
    characterise as characterise,
    rasters as rasters,
)
from ._eye import Eye as Eye
from ._handover.model_file import load as load, save as save
from ._network.abstract import AbstractNetwork as AbstractNetwork, Response as Response, State as State
from ._network.lgmd2 import ABLATIONS as ABLATIONS, LGMD2 as LGMD2, MECHANISMS as MECHANISMS
from ._network.noise import inhibition_in_noise as inhibition_in_noise
from ._network.parameter_set import ParameterSet as ParameterSet, declares as declares, scalar as scalar
from ._network.parameters import (
    PRESETS as PRESETS,
    Parameters as Parameters,
    Symbol as Symbol,
    preset as preset,
    symbols as symbols,
)
from ._network.pixels import Layers as Layers
from ._network.sides import Sides as Sides, sides as sides
from ._network.stages import AbstractCell as AbstractCell, AbstractPixels as AbstractPixels, Sums as Sums
from ._network.structure import counts as counts, one_of as one_of
from ._network.thresholds import (
    Hard as Hard,
    Soft as Soft,
    StraightThrough as StraightThrough,
    Thresholds as Thresholds,
    Widths as Widths,
)
from ._network.variants import ablate as ablate, at_eye as at_eye, at_frame_rate as at_frame_rate
from ._network.yue_rind import (
    YueRindLayers as YueRindLayers,
    YueRindLGMD1 as YueRindLGMD1,
    YueRindParameters as YueRindParameters,
)
from ._protocol.condition import Condition as Condition, Protocol as Protocol
from ._protocol.protocol import load_protocol as load_protocol
from ._recipes.fit import Recipe as Recipe
from ._recipes.load import load_recipe as load_recipe
from ._recipes.sweep import SweepRecipe as SweepRecipe
from ._results.comparison import compare as compare
from ._results.fit_folder import load_fit as load_fit, save_fit as save_fit
from ._sweep import surfaces as surfaces, sweep as sweep
from ._targets.band import Band as Band
from ._targets.csv_files import read_spike_trains as read_spike_trains, read_target as read_target
from ._targets.looming_law import LoomingLaw as LoomingLaw
from ._targets.model_target import ModelTarget as ModelTarget
from ._targets.observation import Observation as Observation, observation_symbols as observation_symbols
from ._targets.rest import Onset as Onset, Rest as Rest
from ._targets.spike_trains import SpikeTrains as SpikeTrains, spike_rate as spike_rate
from ._targets.target import Target as Target
from ._targets.weighted import Weighted as Weighted
from ._trials.load import load_trials as load_trials
from ._trials.peak_line import LoomingEstimate as LoomingEstimate, PeakTimes as PeakTimes
from ._trials.trial import Trial as Trial
from ._trials.trials import Trials as Trials
from ._video.display import save_display_video as save_display_video
from .fitting import (
    AnimalFits as AnimalFits,
    Fit as Fit,
    Free as Free,
    Linear as Linear,
    Log as Log,
    Simulator as Simulator,
    Tie as Tie,
    as_simulator as as_simulator,
    discriminating_stimulus as discriminating_stimulus,
    fit as fit,
    fit_each as fit_each,
    strongest_stimulus as strongest_stimulus,
)
from .stimuli import Stimulus as Stimulus

__version__: str
