"""How the rounds are taken, and what becomes of them in the table; nothing is measured."""

import contextlib
import io
import unittest
from types import SimpleNamespace

import measure
import table
import tools


def case(**fields) -> SimpleNamespace:
    return SimpleNamespace(TITLE="Case", **fields)


def quietly(work, *arguments):
    with contextlib.redirect_stderr(io.StringIO()):
        return work(*arguments)


def document(rows: list[dict]) -> dict:
    return {"machine": {"machine": "one"}, "versions": {}, "rounds": 3, "rows": rows}


class Rounds(unittest.TestCase):
    def test_contenders_take_turns_in_each_round(self):
        order = []

        def contender(name):
            return lambda: order.append(name) or {"time [s]": 1.0}

        turns = case(contenders=lambda: {"planesman": contender("ours"), "peer": contender("peer")})
        rows = quietly(measure.measure, "case", turns, 3, False)
        self.assertEqual(order, ["ours", "peer"] * 3)
        self.assertEqual([row["costs"]["time [s]"] for row in rows], [[1.0] * 3] * 2)

    def test_each_size_is_measured_and_quick_takes_its_own(self):
        sizes = case(contenders=lambda: {"planesman": lambda size: {"time [s]": float(size)}}, X="size", POINTS=[1, 10], QUICK=[2], ROUNDS=1)
        rows = quietly(measure.measure, "case", sizes, 5, False)
        self.assertEqual([(row["point"], row["costs"]) for row in rows], [(1, {"time [s]": [1.0]}), (10, {"time [s]": [10.0]})])
        self.assertEqual([row["point"] for row in quietly(measure.measure, "case", sizes, 5, True)], [2])

    def test_a_contender_that_fails_ends_nothing_but_itself(self):
        def absent():
            raise tools.Missing("there is no peer")

        rows = quietly(measure.measure, "case", case(contenders=lambda: {"planesman": lambda: {"time [s]": 2.0}, "peer": absent}), 2, False)
        self.assertEqual(rows[0]["costs"], {"time [s]": [2.0, 2.0]})
        self.assertEqual(rows[1]["failed"], "there is no peer")
        text = table.markdown(document(rows), {"case": case()})
        self.assertIn("| Case | | peer | failed: there is no peer | | | |", text)

    def test_a_case_that_cannot_begin_is_a_row(self):
        def broken():
            raise ValueError("no such size")

        with contextlib.redirect_stderr(io.StringIO()):
            (row,) = measure.measure("case", case(contenders=broken), 2, False)
        self.assertEqual(row["failed"], "ValueError: no such size")


class Table(unittest.TestCase):
    def test_a_ratio_compares_the_costs_of_one_round(self):
        self.assertEqual(table.ratios([1.0, 2.0, 9.0], [2.0, 2.0, 3.0]), [0.5, 1.0, 3.0])

    def test_ours_stands_beside_the_peers_that_have_the_measure(self):
        def row(contender, costs):
            return {"case": "case", "point": None, "contender": contender, "costs": costs, "failed": None}

        rows = [row("planesman", {"a [s]": [1.0, 2.0, 9.0], "b [s]": [5.0] * 3}), row("one", {"a [s]": [2.0, 2.0, 3.0]}), row("other", {"b [s]": [2000.0] * 3})]
        lines = table.markdown(document(rows), {"case": case()}).splitlines()
        self.assertIn("| Case: a [s] | 2 | one | 2 | 0.5 | 1 | 3 |", lines)
        self.assertIn("| Case: b [s] | 5 | other | 2 000 | 0.0025 | 0.0025 | 0.0025 |", lines)

    def test_costs_against_size_have_a_table_of_their_own(self):
        rows = [{"case": "case", "point": size, "contender": "planesman", "costs": {"a [s]": [size, 3.0 * size]}, "failed": None} for size in (1, 10)]
        text = table.markdown(document(rows), {"case": case(X="size", POINTS=[1, 10])})
        self.assertIn("| size | planesman: a [s] |", text)
        self.assertIn("| 10 | 20 |", text)

    def test_numbers_have_three_digits(self):
        shown = [table.number(value) for value in (0, 0.012345, 83.24, 999.7, 1234.0, 240123.0)]
        self.assertEqual(shown, ["0", "0.0123", "83.2", "1 000", "1 230", "240 000"])


class Programs(unittest.TestCase):
    def test_times_are_read_with_their_unit(self):
        self.assertAlmostEqual(tools.seconds("dive of 60 s", "x, dive of 60 s: 8.9 ms"), 8.9e-3)
        self.assertAlmostEqual(tools.seconds("step, brunner", "one step, brunner with roll: 100 ns\none step, brunner: 83.1 ns"), 83.1e-9)
        with self.assertRaises(tools.Missing):
            tools.seconds("dive", "no time")

    def test_a_program_that_fails_says_why(self):
        with self.assertRaisesRegex(tools.Missing, "sh ended with 3: not so"):
            tools.output(["sh", "-c", "echo not so >&2; exit 3"])


if __name__ == "__main__":
    unittest.main()
