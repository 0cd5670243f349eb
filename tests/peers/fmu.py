"""Runs FMUs in FMPy, as any importer does, and tries what none should do.

A JSON object on standard input: `runs`, each with `fmu`, `tick`, `inputs` (a list of values for each input's name, one for each tick), `outputs` (names) and,
where wanted, `start` (values of parameters by name), `parts` (steps in a tick) and `model` (a model file, to be computed by scipy on the same inputs) or
`ram` (a circuit's between closed valves, likewise under its `load_force`); `refused`: FMUs with a parameter's name, a value that is not taken and one that is;
`garbage`: FMUs to be called wrongly, within a gigabyte of memory. A JSON object on standard output: `runs`, `refused` and `garbage`.
"""

import ctypes
import json
import math
import pathlib
import resource
import shutil
import sys

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import FMU3Slave, fmi3IntermediateUpdateCallback, fmi3LogMessageCallback
from fmpy.validation import validate_fmu

GETTERS = {"Float64": "getFloat64", "Int64": "getInt64", "Boolean": "getBoolean", "String": "getString"}


class Opened:
    """An FMU unpacked, instantiated, and thrown away at the end."""

    def __init__(self, path, start=None):
        self.folder = pathlib.Path(extract(path))
        self.description = read_model_description(path, validate=False)
        self.variables = {it.name: it for it in self.description.modelVariables}
        self.messages = []
        self.fmu = FMU3Slave(
            guid=self.description.guid,
            unzipDirectory=self.folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="peer",
        )
        self.fmu.instantiate(logMessage=lambda _, status, category, text: self.messages.append(text.decode()))
        for name, value in (start or {}).items():
            self.put(name, value)

    def put(self, name, value):
        variable = self.variables[name]
        setter = GETTERS[variable.type].replace("get", "set")
        getattr(self.fmu, setter)([variable.valueReference], [value])

    def take(self, name):
        variable = self.variables[name]
        value = getattr(self.fmu, GETTERS[variable.type])([variable.valueReference])[0]
        return value.decode() if isinstance(value, bytes) else value

    def begin(self):
        self.fmu.enterInitializationMode(startTime=0.0)
        self.fmu.exitInitializationMode()

    def close(self):
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder)


def fly(opened, run, first, last, time):
    """The outputs at each tick, its inputs set, before the step; and the time at the end."""
    rows = []
    parts = run.get("parts", 1)
    for k in range(first, last):
        for name, values in run["inputs"].items():
            opened.put(name, values[k])
        rows.append([opened.take(name) for name in run["outputs"]])
        for part in range(parts):
            opened.fmu.doStep(time, run["tick"] / parts)
            time = (k + (part + 1) / parts) * run["tick"]
    return rows, time


def computed(model, inputs):
    """The outputs of a model file by scipy, from rest."""
    import scipy.signal  # where it is needed: it takes most of a second

    u = np.array(list(inputs.values()))
    if "state_space" in model:
        space = model["state_space"]
        system = scipy.signal.dlti(*(np.array(space[it], dtype=float) for it in "abcd"), dt=model["sample_time"])
        _, y, _ = scipy.signal.dlsim(system, u.T)
        return (y + [it["offset"] for it in model["outputs"]]).tolist()
    num, den = model["num"], model["den"]
    num = [0.0] * (len(den) - len(num)) + num
    x = u[0]
    curve = model.get("static_curve")
    if curve:
        level = {it["name"]: it["value"] for it in curve["parameters"]}
        assert (curve["side"], curve["kind"]) == ("input", "dead zone")
        x = np.where(x > level["upper"], x - level["upper"], np.where(x < level["lower"], x - level["lower"], 0.0))
    return [[it] for it in scipy.signal.lfilter(num, den, x - model.get("input_level", 0.0)) + model["offset"]]


def pushed(ram, tick, forces):
    """Position, velocity and pressures of a ram between closed valves, from rest, under forces that jump at the ticks: the equations of docs/circuit.md."""
    import scipy.integrate  # where it is needed, as above

    atmosphere, mass, viscous, polytropic = 101325.0, ram["mass"], ram["viscous"], ram["polytropic"]
    (area_a, volume_a), (area_b, volume_b) = ram["A"], ram["B"]

    def modulus(pressure):
        absolute = pressure + atmosphere
        air = ram["air"] * (atmosphere / absolute) ** (1 / polytropic)
        return (1 + air) / (1 / ram["bulk_modulus"] + air / (polytropic * absolute))

    def rates(_, state, force):
        x, v, p_a, p_b = state
        return [
            v,
            (p_a * area_a - p_b * area_b - viscous * v - force) / mass,
            -modulus(p_a) / (volume_a + area_a * x) * area_a * v,
            modulus(p_b) / (volume_b - area_b * x) * area_b * v,
        ]

    p_b = (ram["P"] + ram["T"]) / 2
    rows, state = [], [0.0, 0.0, p_b * area_b / area_a, p_b]
    for force in forces:
        rows.append(state)
        error = {"method": "DOP853", "rtol": 1e-12, "atol": [1e-15, 1e-13, 1e-4, 1e-4]}
        solution = scipy.integrate.solve_ivp(rates, (0.0, tick), state, args=(force,), **error)
        state = solution.y[:, -1].tolist()
    return rows


def constants(description):
    """Type, unit and start value of each parameter that is fixed."""
    fixed = [it for it in description.modelVariables if (it.causality, it.variability) == ("parameter", "fixed")]
    return {it.name: [it.type, it.unit, float(it.start)] for it in fixed}


def units(description):
    """The base units of each variable's unit: kg, m, s and rad."""
    of = {it.name: it.baseUnit for it in description.unitDefinitions}
    variables = [it for it in description.modelVariables if it.unit]
    return {it.name: [getattr(of[it.unit], base) for base in ("kg", "m", "s", "rad")] for it in variables}


def perform(run):
    problems = validate_fmu(run["fmu"])
    opened = Opened(run["fmu"], run.get("start"))
    opened.begin()
    ticks = len(next(iter(run["inputs"].values())))
    half = ticks // 2
    rows, time = fly(opened, run, 0, half, 0.0)
    kept = opened.fmu.getFMUState()
    rest, _ = fly(opened, run, half, ticks, time)
    opened.fmu.setFMUState(kept)
    again, _ = fly(opened, run, half, ticks, time)
    opened.fmu.freeFMUState(kept)
    opened.close()
    answer = {
        "problems": problems,
        "outputs": rows + rest,
        "repeats": rest == again,
        "units": units(opened.description),
        "constants": constants(opened.description),
    }
    if "ram" in run:
        answer["computed"] = pushed(run["ram"], run["tick"], run["inputs"]["load_force"])
    if "model" in run:
        with open(run["model"], encoding="utf-8") as file:
            answer["computed"] = computed(json.load(file), run["inputs"])
    return answer


def refuse(case):
    """The status of initialization with a value that is not taken, its message, and whether the FMU goes on with one that is."""
    opened = Opened(case["fmu"], {case["name"]: case["value"]})
    opened.fmu.enterInitializationMode(startTime=0.0)
    try:
        opened.fmu.exitInitializationMode()
        return None
    except FMICallException as refusal:
        status = refusal.status
    opened.put(case["name"], case["then"])
    opened.fmu.exitInitializationMode()
    opened.fmu.doStep(0.0, 0.05)
    opened.close()
    return [status, opened.messages]


def abuse(path):
    """The statuses of wrong calls by what is wrong, and a right step after them all."""
    opened = Opened(path)
    library, instance = opened.fmu.dll, opened.fmu.component
    size, real = ctypes.c_size_t, ctypes.c_double
    numbers = (ctypes.c_double * 1)()
    inputs = [it for it in opened.description.modelVariables if it.causality == "input"]
    of_input = (ctypes.c_uint * 1)(inputs[0].valueReference)
    outputs = [it for it in opened.description.modelVariables if it.causality == "output" and it.type == "Float64"]
    of_output = (ctypes.c_uint * 1)(outputs[0].valueReference)
    fixed = [it for it in opened.description.modelVariables if it.variability == "fixed" and it.type == "Float64"]

    def step(start, length):
        last = ctypes.c_double()
        return library.fmi3DoStep(instance, real(start), real(length), True, None, None, None, ctypes.byref(last))

    def put(references, value, count=1):
        numbers[0] = value
        return library.fmi3SetFloat64(instance, references, size(count), numbers, size(count))

    found = {"a step before initialization": step(0.0, 0.05)}
    opened.begin()
    found |= {
        "no instance": library.fmi3Reset(None),
        "NaN as an input": put(of_input, math.nan),
        "infinity as an input": put(of_input, math.inf),
        "an output set": put(of_output, 0.0),
        "an unknown reference": put((ctypes.c_uint * 1)(4_000_000_000), 0.0),
        "time set": put((ctypes.c_uint * 1)(0), 0.0),
        "no references": put(None, 0.0),
        "more values than there can be": put(of_input, 0.0, 2**60),
        "no values": library.fmi3GetFloat64(instance, of_output, size(1), None, size(1)),
        "a number read as text": library.fmi3GetString(instance, of_output, size(1), (ctypes.c_char_p * 1)(), size(1)),
        "other counts": library.fmi3GetFloat64(instance, of_output, size(1), numbers, size(0)),
        "a type that nothing has": library.fmi3GetFloat32(instance, of_output, size(1), None, size(1)),
        "a step back": step(0.0, -0.05),
        "a step of NaN": step(0.0, math.nan),
        "a step of no length": step(0.0, 0.0),
        "a step without end": step(0.0, 1e300),
        "a step from elsewhere": step(7.0, 0.05),
        "a step from NaN": step(math.nan, 0.05),
        "no state": library.fmi3SetFMUState(instance, None),
        "no place for a state": library.fmi3GetFMUState(instance, None),
        "a function of model exchange": library.fmi3SetTime(instance, real(0.0)),
        "initialization again": library.fmi3EnterInitializationMode(instance, False, real(0), real(0), False, real(0)),
    }
    if fixed:
        found["a fixed parameter in mid-flight"] = put((ctypes.c_uint * 1)(fixed[0].valueReference), 0.0)
    right = [put(of_input, 0.1), step(0.0, 0.05), library.fmi3SetFMUState(instance, None), step(0.05, 0.05)]
    messages = len(opened.messages)

    # As another process with damaged files would: nothing is instantiated.
    library.fmi3InstantiateCoSimulation.restype = ctypes.c_void_p
    silent = fmi3LogMessageCallback()
    flags = (False, False, False, False, None, size(0), None, silent, fmi3IntermediateUpdateCallback())
    token, place = opened.description.guid.encode(), str(opened.folder / "resources").encode()
    refused = [
        library.fmi3InstantiateCoSimulation(*arguments, *flags)
        for arguments in [(None, None, None), (b"", b"other", place), (b"", token, b"/nowhere"), (b"", token, b"\xff\xfe")]
    ]
    opened.close()
    return {
        "statuses": found,
        "right": [right[0], right[1], right[3]],
        "messages": messages,
        "instantiated": [it for it in refused if it],
    }


def main():
    asked = json.load(sys.stdin)
    answer = {
        "runs": [perform(run) for run in asked.get("runs", [])],
        "refused": [refuse(case) for case in asked.get("refused", [])],
    }
    resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30))
    answer["garbage"] = [abuse(path) for path in asked.get("garbage", [])]
    json.dump(answer, sys.stdout)


if __name__ == "__main__":
    main()
