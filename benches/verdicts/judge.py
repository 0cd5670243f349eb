"""What a fit's JSON says of a record whose truth is known: verdict, error of the step response, intervals, causes."""

import re
from dataclasses import replace

import numpy as np
from scipy.signal import lfilter

import records
from situations import PLANTS, WELL_EXCITED, causes

NEAR = 0.05
"""The relative error of a step response up to which a model is right."""
SOLVED = 0.02
"""The same of the oracle, up to which a record carries enough."""
IN_BAND = 0.9
"""The share of the step response's points that the printed 95 % band must hold."""
POINTS = 40
SIGMAS = 1.96

SHIFTED = {"held": (0, 2), "jitter": (-1, 1), "digits lost": (-1, 1)}
"""Samples by which a logger moves the output's times, or each row's, from one to another."""
STATIC = r"^planesman: y is u times (\S+) plus"
"""How a fit is refused that would be a static gain."""
LEAST_SAMPLES = 100
"""Of a record with noise that should be called good."""

NAMED = {
    "closed loop": r"^residuals correlate with later inputs|seems closed-loop",
    "feedback alone": r"feedback of the output alone",
    "backlash": r"backlash",
    "dead zone": r"dead zone",
    "saturation": r"saturat",
    "square law": r"square law|its square",
    "not linear": r"a curve that bends|piecewise linear",
    "friction": r"dry friction",
    "drag": r"as drag does",
    "gain": r"the gain changes",
    "disturbance": r"something that is not recorded|something else acts",
    "drift": r"the output drifts",
    "quantised": r"quantis",
    "clock": r"times are in doubt",
}
"""By which words a sentence names a cause."""


def named(sentences):
    """The causes that sentences name."""
    return {cause for cause, words in NAMED.items() if any(re.search(words, it) for it in sentences)}


def of_model(model):
    """The response to an input of a model file's transfer function, with its static curve, from rest at an input of 0."""
    num, den = np.array(model["num"]), np.array(model["den"])
    num = np.r_[np.zeros(max(0, len(den) - len(num))), num]
    curve = model.get("static_curve")
    parameters = {it["name"]: it["value"] for it in curve["parameters"]} if curve else {}

    def response(u):
        x = records.curved(curve["kind"], parameters, u) if curve and curve["side"] == "input" else u
        y = lfilter(num, den, x)
        return records.curved(curve["kind"], parameters, y + model.get("offset", 0.0)) if curve and curve["side"] == "output" else y

    return response


def step_pairs(plant, u):
    """Levels of the input before and after the steps that are judged: where it has been; from rest to 1 of what would not settle before."""
    settles = len(plant.den) == 1 or np.max(np.real(np.roots(plant.den))) < -1e-9
    low, high = np.quantile(u, 0.02), np.quantile(u, 0.98)
    if not settles or not high > low:
        return [(0.0, 1.0)]
    middle = (low + high) / 2
    return [(low, middle), (low, high), (high, low)]


def step_response(respond, pair, interval, horizon, points):
    """The response to a step from one level to the other at these times behind it, s."""
    before = 0 if pair[0] == 0.0 else int(np.ceil(4 * horizon / interval))
    after = int(np.ceil(horizon / interval)) + 2
    y = respond(np.repeat(pair, [max(before, 1), after]))
    grid = interval * np.arange(after)
    return np.interp(points, grid, y[max(before, 1) :]) - y[max(before, 1) - 1]


def compared(respond, model_interval, plant, interval, u):
    """Step responses of a model and of the truth, one below the other; the points are samples of the model's."""
    horizon = max(3 * records.slowest(plant.den), 10 * interval) + plant.delay * interval
    points = model_interval * np.unique(np.linspace(0, np.floor(horizon / model_interval), POINTS).astype(int))
    true = lambda values: records.simulate(plant, values, interval)
    with np.errstate(all="ignore"):
        pairs = step_pairs(plant, u)
        of = lambda which, h: np.concatenate([step_response(which, pair, h, horizon, points) for pair in pairs])
        return of(respond, model_interval), of(true, interval)


def error_of(found, truth):
    """The norm of the error in the norm of the truth."""
    with np.errstate(all="ignore"):
        return float(np.nan_to_num(np.linalg.norm(found - truth) / np.linalg.norm(truth), nan=np.inf))


def share_in_band(model, plant, interval, model_interval, u):
    """The share of the points that the model's 95 % band holds, of first order in its covariance."""
    num, den = np.array(model["num"]), np.array(model["den"])
    parameters = np.r_[den[1:], num]
    covariance = np.zeros((len(parameters), len(parameters)))
    for row, values in enumerate(model["covariance"] or []):
        covariance[row, : len(values)] = values
    of = lambda p: compared(of_model(model | {"den": np.r_[1.0, p[: len(den) - 1]], "num": p[len(den) - 1 :]}), model_interval, plant, interval, u)
    middle, truth = of(parameters)
    slopes = np.zeros((len(middle), len(parameters)))
    for i in np.flatnonzero(np.diag(covariance) > 0):
        moved = parameters.copy()
        moved[i] += max(1e-4 * np.sqrt(covariance[i, i]), 1e-9 * abs(moved[i]))
        slopes[:, i] = (of(moved)[0] - middle) / (moved[i] - parameters[i])
    deviation = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", slopes, covariance, slopes), 0))
    return float(np.mean(np.abs(middle - truth) <= SIGMAS * deviation + 1e-9 * np.max(np.abs(truth))))


def intervals_hold(model, gain, delay, plant, interval, model_interval, shifted):
    """For gain, poles and delay: whether the printed interval holds the truth. What is not printed has no entry. `gain` is the gain of an integrator."""
    num, den, held = np.array(plant.num), np.array(plant.den), {}
    if den[-1] != 0:
        gain = model["steady_state_gain"]
    if gain is not None and not plant.curve:
        held["gain"] = abs(gain[0] - num[-1] / den[-1 if den[-1] != 0 else -2]) <= SIGMAS * gain[1] + 1e-6 * abs(gain[0])
    printed = model["continuous_poles"] or []
    inside = []
    for pole in (p for p in np.roots(den) if p.imag >= 0):
        nearest = min(printed, key=lambda it: abs(complex(it["re"], it["im"]) - pole), default=None)
        parts = [("re", pole.real)] + ([("im", pole.imag)] if pole.imag > 0 else [])
        inside += [nearest is not None and abs(nearest[part] - value) <= SIGMAS * nearest[f"{part}_deviation"] + 1e-6 * abs(pole) for part, value in parts]
    if inside:
        held["poles"] = all(inside)
    if delay is not None:
        # The first sample that answers: one behind the dead time, or without dynamics that itself.
        low, high = delay
        lag, first = plant.delay * interval, int(len(den) > 1)
        least, most = (lag + by * interval for by in shifted)
        held["delay"] = (low - first) * model_interval - 1e-9 <= most and least <= (high - first + 1) * model_interval - interval + 1e-9
    return held


def channels(found):
    """Of each input of a fit: the model (`None` where it is left out), the interval of its delay, the gain of an integrator; then the judgement."""
    model = found["model"]
    if "outputs" not in model:
        return [(model, (found["delay"] or {}).get("interval"), found["integrator_gain"])], model
    (output,) = model["outputs"]
    of = {it["input"]: it for it in output["channels"]}
    return [(of.get(name), (of.get(name) or {}).get("delay_interval"), None) for name in model["inputs"]], output


def plant_as_logged(situation, rec):
    """The plant, with the limits of a sensor that clips behind it."""
    plant, y = PLANTS[situation.plant], rec.columns["y"]
    if situation.log != "clipped":
        return plant
    return replace(plant, curve=("output", "saturation", {"lower": np.min(y), "upper": np.max(y)}))


def judged(situation, rec, found, oracle):
    """What is so of a fit's JSON; `oracle` is the error of least squares."""
    plant = plant_as_logged(situation, rec)
    parts, output = channels(found)
    model_interval = found["record"]["sample_time"]
    truths = [plant] + ([records.Plant(*plant.other, plant.interval)] if plant.other else [])
    errors, bands, held = [], [], {}
    for (model, delay, gain), truth, name in zip(parts, truths, "uv"):
        u = rec.columns[name]
        if model is None:
            errors, bands = errors + [1.0], bands + [0.0]
            continue
        errors.append(error_of(*compared(of_model(model), model_interval, truth, rec.interval, u)))
        bands.append(share_in_band(model, truth, rec.interval, model_interval, u))
        for key, value in intervals_hold(model, gain, delay, truth, rec.interval, model_interval, SHIFTED.get(situation.log, (0, 0))).items():
            held[key] = held.get(key, True) and bool(value)
    named_here = named(output["verdict"])
    row = {
        "standing": output["judgement"]["standing"],
        "code": output["judgement"]["code"],
        "findings": " ".join(output["judgement"]["findings"]),
        "error": max(errors),
        "in_band": min(bands),
        **{f"{name}_held": held.get(name) for name in ("gain", "poles", "delay")},
        "named": ", ".join(sorted(named_here)),
        "false": ", ".join(sorted(named_here - causes(situation))),
    }
    return row | conclusions(situation, row, oracle)


def refused(situation, sentence, oracle):
    """The same of a fit that is refused: a gain that is named instead counts as a model that is called good."""
    plant, gain = PLANTS[situation.plant], re.search(STATIC, sentence)
    row = {"standing": "refused", "error": np.inf, "in_band": 0.0, "delay_held": None, "findings": sentence}
    named_here = named([sentence])
    row |= {"named": ", ".join(sorted(named_here)), "false": ", ".join(sorted(named_here - causes(situation)))}
    if gain and not named_here:
        truth = plant.num[0] if len(plant.den) == 1 and not plant.delay else 0.0
        row |= {"standing": "good", "code": "static_gain", "error": abs(float(gain[1]) - truth) / (truth or abs(float(gain[1])))}
    return row | conclusions(situation, row, oracle)


def solved_error(situation, rec, solved):
    """The step response's error of least squares of the true structure; `None` for a plant that is not solved so."""
    if solved is None:
        return None
    plant, interval, u = plant_as_logged(situation, rec), rec.interval, rec.columns["u"]
    pairs = [(solved, plant)]
    if plant.other:
        pairs.append((records.Plant(*solved.other, interval), records.Plant(*plant.other, interval)))
    return max(error_of(*compared(lambda v, it=it: records.simulate(it, v, interval), interval, truth, interval, u)) for it, truth in pairs)


def conclusions(situation, row, oracle):
    """Whether "good" is right, and whether the record should be called so."""
    good = row["standing"] == "good"
    right = (row["error"] <= NEAR or row["in_band"] >= IN_BAND) and row["delay_held"] is not False
    clean = situation.noise == "none" and situation.log == "plain"
    excited = situation.samples >= LEAST_SAMPLES and situation.noise == "white" and situation.log == "plain" and situation.input in WELL_EXCITED
    solvable = oracle is not None and oracle <= SOLVED
    return {"oracle": oracle, "good": good, "wrong": good and not right, "should": solvable and (clean or excited)}
