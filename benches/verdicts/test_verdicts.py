"""The generator and the judge beside what is known without them; no program is run."""

import math
import unittest

import numpy as np
from scipy.signal import step as continuous_step

import judge
import records
import report
from situations import ALL, PLANTS, Plant, Situation, causes

FIRST = Situation("first order, delay", "PRBS", "none", "plain", 500)


def found_of(plant, interval, delay, gain=1.0, deviation=0.0, sentences=()):
    """The JSON of a fit whose model is this plant, with so many times its gain."""
    b, a = records.sampled(plant.num, plant.den, interval, plant.delay)
    model = {
        "num": list(gain * b),
        "den": list(np.r_[a, np.zeros(len(b) - len(a))]),
        "covariance": np.diag(np.r_[np.zeros(len(b) - 1), (deviation * b) ** 2]).tolist(),
        "steady_state_gain": [gain * plant.num[-1] / plant.den[-1], deviation],
        "continuous_poles": [{"re": p.real, "im": p.imag, "re_deviation": 0.01, "im_deviation": 0.01} for p in np.roots(plant.den).astype(complex)],
        "judgement": {"standing": "good", "code": "simulates", "findings": []},
        "verdict": list(sentences),
    }
    return {"model": model, "delay": {"interval": delay}, "integrator_gain": None, "record": {"sample_time": interval}}


def judged(situation, **changes):
    rec = records.record(situation, 0)
    plant = PLANTS[situation.plant]
    return judge.judged(situation, rec, found_of(plant, rec.interval, **{"delay": [plant.delay + 1] * 2} | changes), 0.0)


class Generator(unittest.TestCase):
    def test_a_held_input_gives_the_step_response_of_the_continuous_plant(self):
        plant = PLANTS["oscillating"]
        time, expected = continuous_step((plant.num, plant.den), T=plant.interval * np.arange(80))
        np.testing.assert_allclose(records.simulate(plant, np.ones(80), plant.interval), expected, atol=1e-9)
        late = Plant(plant.num, plant.den, plant.interval, delay=5)
        np.testing.assert_allclose(records.simulate(late, np.ones(80), plant.interval)[5:], expected[:75], atol=1e-9)

    def test_a_loop_is_plant_and_controller_at_once(self):
        plant, random = PLANTS["PI loop, delay"], np.random.default_rng(1)
        r, d = random.normal(size=(2, 300))
        u, y = records.in_loop(plant, r, d, 0.1)
        np.testing.assert_allclose(y, records.simulate(plant, u, 0.1) + d, atol=1e-9)
        gain, integral = plant.controller
        np.testing.assert_allclose(u, gain * (r - y) + integral * 0.1 * np.cumsum(r - y), atol=1e-9)

    def test_curves_are_what_their_names_say(self):
        x = np.array([-2.0, -0.1, 0.0, 0.5, 2.0])
        self.assertEqual(list(records.curved("dead zone", {"lower": -1, "upper": 1}, x)), [-1, 0, 0, 0, 1])
        self.assertEqual(list(records.curved("saturation", {"upper": 1}, x)), [-2, -0.1, 0, 0.5, 1])
        self.assertEqual(list(records.curved("square law", {}, x)), list(x * abs(x)))
        self.assertEqual(list(records.curved("piecewise linear", {"level 1": 0, "slope 2": 0.5}, x)), [-2, -0.1, 0, 0.25, 1])
        self.assertEqual(list(records.curved("backlash", {"width": 1}, np.array([0.0, 1.0, 0.5, 0.0, -1.0]))), [0, 0.5, 0.5, 0.5, -0.5])

    def test_dry_friction_holds_what_is_too_weak(self):
        plant = PLANTS["dry friction"]
        self.assertTrue(np.all(records.simulate(plant, np.full(50, 0.2), 0.1) == 0))
        self.assertAlmostEqual(records.simulate(plant, np.ones(300), 0.1)[-1], 0.75, places=6)

    def test_a_record_is_drawn_from_its_name_and_seed(self):
        texts = [records.record(FIRST, seed).csv() for seed in (0, 0, 1)]
        self.assertEqual(texts[0], texts[1])
        self.assertNotEqual(texts[0], texts[2])

    def test_every_situation_has_a_finite_record_with_its_columns(self):
        self.assertGreaterEqual(len(set(ALL)), 400)
        self.assertEqual(len(set(ALL)), len(ALL))
        for situation in ALL:
            if situation.samples <= 500:
                columns = records.record(situation, 0).columns
                self.assertEqual(list(columns), ["time", "u", "v", "y"] if PLANTS[situation.plant].other else ["time", "u", "y"])
                self.assertTrue(all(len(it) == situation.samples for it in columns.values()), situation)
                self.assertTrue(all(np.all(np.isfinite(it)) for name, it in columns.items() if name != "time"), situation)

    def test_loggers_spoil_what_they_are_named_for(self):
        columns, random = {"u": np.zeros(500), "y": np.sin(np.arange(500.0))}, np.random.default_rng(1)
        log = lambda kind: records.logged(kind, columns, 0.1, random)
        self.assertEqual(len(set(log("plain")["time"])), 500)
        stamps = log("digits lost")["time"]
        self.assertEqual((len(set(stamps[:250])), len(set(stamps[250:]))), (250, 26))
        self.assertLess(len(set(log("quantised")["y"])), 27)
        self.assertEqual(np.sum(log("clipped")["y"] == log("clipped")["y"].max()) > 20, True)
        self.assertEqual(list(log("held")["y"][3:6]), [columns["y"][3]] * 3)

    def test_least_squares_of_the_truth_solves_what_carries_enough_and_nothing_else(self):
        def error(situation):
            rec = records.record(situation, 0)
            return judge.solved_error(situation, rec, records.oracle(situation, rec, np.random.default_rng(1)))

        for plant in ("static gain", "integrator with a lag", "two resonances", "backlash", "two inputs"):
            self.assertLess(error(Situation(plant, "many steps", "none", "plain", 500)), 1e-4, plant)
        self.assertLess(error(Situation("P loop, unstable", "setpoint PRBS", "none", "plain", 500)), 1e-4)
        self.assertGreater(error(Situation("PI loop, first order", "feedback alone", "AR(0.97)", "plain", 500)), 0.1)


class Judge(unittest.TestCase):
    def test_the_true_model_is_right(self):
        row = judged(FIRST)
        self.assertLess(row["error"], 1e-9)
        self.assertEqual((row["gain_held"], row["poles_held"], row["delay_held"]), (True, True, True))
        self.assertEqual((row["good"], row["wrong"], row["should"]), (True, False, True))

    def test_a_wrong_gain_is_wrong_unless_the_band_holds_the_truth(self):
        row = judged(FIRST, gain=1.1)
        self.assertAlmostEqual(row["error"], 0.1)
        self.assertEqual((row["gain_held"], row["wrong"]), (False, True))
        self.assertFalse(judged(FIRST, gain=1.1, deviation=0.1)["wrong"])

    def test_an_interval_without_the_true_delay_is_wrong(self):
        self.assertEqual([judged(FIRST, delay=it)["wrong"] for it in ([5, 7], [8, 8], [9, 11])], [True, False, True])

    def test_a_curve_of_the_model_is_simulated(self):
        situation = Situation("dead zone", "many steps", "none", "plain", 500)
        rec, plant = records.record(situation, 0), PLANTS["dead zone"]
        found = found_of(plant, rec.interval, [1, 1])
        self.assertGreater(judge.judged(situation, rec, found, None)["error"], 0.1)
        side, kind, parameters = plant.curve
        found["model"]["static_curve"] = {"side": side, "kind": kind, "parameters": [{"name": name, "value": it} for name, it in parameters.items()]}
        self.assertLess(judge.judged(situation, rec, found, None)["error"], 1e-9)

    def test_an_input_that_is_left_out_is_an_error(self):
        situation = Situation("two inputs", "PRBS", "none", "plain", 500)
        rec, plant = records.record(situation, 0), PLANTS["two inputs"]
        model = found_of(plant, rec.interval, [1, 1])["model"]
        output = {"channels": [model | {"input": "u", "delay_interval": [1, 1]}], "judgement": model["judgement"], "verdict": []}
        found = {"model": {"inputs": ["u", "v"], "outputs": [output]}, "record": {"sample_time": rec.interval}}
        row = judge.judged(situation, rec, found, 0.0)
        self.assertEqual((row["error"], row["wrong"]), (1.0, True))

    def test_limits_of_a_sensor_are_part_of_the_plant(self):
        situation = Situation("first order", "many steps", "none", "clipped", 500)
        rec, plant = records.record(situation, 0), PLANTS["first order"]
        found = found_of(plant, rec.interval, [1, 1])
        self.assertGreater(judge.judged(situation, rec, found, None)["error"], 0.05)
        side, kind, parameters = judge.plant_as_logged(situation, rec).curve
        found["model"]["static_curve"] = {"side": side, "kind": kind, "parameters": [{"name": name, "value": it} for name, it in parameters.items()]}
        self.assertLess(judge.judged(situation, rec, found, None)["error"], 1e-9)

    def test_a_refusal_that_names_the_gain_is_a_model(self):
        sentence = "planesman: y is u times 2.000000 plus 0.000000 in every sample, so there are no dynamics"
        static, integrator = (Situation(plant, "impulse in row 1", "none", "plain", 500) for plant in ("static gain", "integrator"))
        self.assertEqual([judge.refused(it, sentence, 0.0)["wrong"] for it in (static, integrator)], [False, True])
        self.assertFalse(judge.refused(static, "planesman: no such file", 0.0)["good"])

    def test_a_model_that_grows_without_bound_has_no_error_but_infinity(self):
        self.assertEqual(judge.error_of(np.array([np.inf, np.nan]), np.ones(2)), math.inf)

    def test_a_cause_that_is_not_in_the_record_is_false(self):
        sentences = ["residuals correlate with later inputs (x)", "the input has backlash of about 3", "verdict: usable with care: the times are in doubt. Next: x"]
        row = judged(FIRST, sentences=sentences)
        self.assertEqual(row["false"], "backlash, clock, closed loop")
        self.assertEqual(causes(Situation("PI loop, delay", "setpoint steps", "white", "jitter", 500)), {"closed loop", "clock"})


class Report(unittest.TestCase):
    def test_shares_count_what_they_are_of(self):
        base = dict(zip(report.GROUPS, ("p", "i", "n", "l", 500))) | {"seed": 0, "error": 0.1, "standing": "good", "seconds": 1.0}
        rows = [
            base | {"good": True, "wrong": False, "should": True, "named": "drift, clock", "false": "clock", "gain_held": True},
            base | {"good": True, "wrong": True, "should": False, "named": "", "false": ""},
            base | {"good": False, "wrong": False, "should": True, "standing": "refused"},
        ]
        self.assertEqual(report.counts(rows), {"precision": (1, 2), "recall": (1, 2), "causes": (1, 2)})
        text = report.markdown(rows, {"command": "run", "commit": "abc", "date": "today"})
        self.assertIn("| precision | 50.0 (1/2) | 98.0 |", text)
        self.assertIn("| p | i | n | l | 500 | 10 | 2 | 1 | 2 | 1 | good 2, refused 1 | clock 1 |", text)


if __name__ == "__main__":
    unittest.main()
