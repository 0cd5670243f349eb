#!/usr/bin/env python3
"""Loads a model file as python-control takes it and tells what it finds as one JSON object.

    load_model.py MODEL.json

What MATLAB does with the same three lists, `tf(num, den, sample_time)`, is what `control.tf` does.
"""

import json
import sys

import control
import numpy


def numbers(values) -> list[list[float]]:
    return [[value.real, value.imag] for value in numpy.asarray(values, dtype=complex)]


def main() -> None:
    with open(sys.argv[1]) as file:
        model = json.load(file)
    sampled = control.tf(model["num"], model["den"], model["sample_time"])
    continuous = control.tf(model["continuous"]["num"], model["continuous"]["den"])
    held = control.sample_system(continuous, model["sample_time"], method="zoh")
    omega = numpy.logspace(-1, 1, 20)
    print(
        json.dumps(
            {
                "poles": numbers(sampled.poles()),
                "zeros": numbers(sampled.zeros()),
                "steady_state_gain": float(numpy.real(sampled.dcgain())),
                "continuous_poles": numbers(continuous.poles()),
                "continuous_steady_state_gain": float(numpy.real(continuous.dcgain())),
                "response": numbers(sampled(numpy.exp(1j * omega * model["sample_time"]))),
                "held_response": numbers(held(numpy.exp(1j * omega * model["sample_time"]))),
            }
        )
    )


if __name__ == "__main__":
    main()
