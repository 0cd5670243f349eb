"""Planesman for Python: an underwater vehicle with its controllers and its digital hydraulic actuator, simulated; models
identified from any bag.

- data: `read_bag`, `list_fields`, `Samples`
- simulation: `simulate`, `Flight`, `Loop` (tick by tick, with your own control law), `STATES`, `transfer_function`, `TransferFunction`, `parameters`, `parameter_file`
- identification: `fit`, `fit_several`, `fit_equations`, `Model`, `Uncertainty`, `FrequencyResponse`
- many simulations or fits, on one machine or a cluster: `sweep`, `fit_all`
- the two historical reports: `reproduce`

SI everywhere; angles in rad, depth positive down, pitch positive bow up, plane angles positive to dive. An invalid argument
raises `PlanesmanError`, a `ValueError`, with the message that the program `planesman` prints. All work releases the
interpreter's lock.
"""

from importlib.metadata import version as _version

from planesman._native import PlanesmanError
from planesman._options import FitOptions
from planesman.data import Samples, list_fields, read_bag
from planesman.identification import FrequencyResponse, Model, Uncertainty, fit, fit_equations, fit_several
from planesman.many import fit_all, sweep
from planesman.reports import reproduce
from planesman.simulation import STATES, Flight, Loop, TransferFunction, parameter_file, parameters, simulate, transfer_function

__version__ = _version("planesman")

__all__ = [
    "STATES",
    "FitOptions",
    "Flight",
    "FrequencyResponse",
    "Loop",
    "Model",
    "PlanesmanError",
    "Samples",
    "TransferFunction",
    "Uncertainty",
    "fit",
    "fit_all",
    "fit_equations",
    "fit_several",
    "list_fields",
    "parameter_file",
    "parameters",
    "read_bag",
    "reproduce",
    "simulate",
    "sweep",
    "transfer_function",
]
