"""The Basic Model Interface (BMI 2.0, Hutton, Piper & Tucker 2020): a simulation as a model that others step (EspalierBmi), and a BMI
model as an environment that plants ask (environment_of). Needs NumPy."""

from .environments import environment_of as environment_of
from .grids import BmiError as BmiError
from .simulation import EspalierBmi as EspalierBmi
