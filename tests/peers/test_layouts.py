"""The layouts of launch-scripts have the form that their programs read; `tests/with_peers/viewers.rs` holds them to what a flight records."""

import json
import unittest
import xml.etree.ElementTree
from pathlib import Path

LAYOUTS = Path(__file__).resolve().parents[2] / "launch-scripts" / "layouts"


def panels(node) -> list[str]:
    """The panels that a Foxglove mosaic shows."""
    if isinstance(node, str):
        return [node]
    assert set(node) == {"direction", "first", "second", "splitPercentage"}, node
    return panels(node["first"]) + panels(node["second"])


class Layouts(unittest.TestCase):
    def test_plotjugglers_splitters_have_a_size_for_each_of_their_areas(self):
        root = xml.etree.ElementTree.parse(LAYOUTS / "plotjuggler.xml").getroot()
        for splitter in root.iter("DockSplitter"):
            self.assertEqual(int(splitter.get("count")), len(splitter))
            self.assertEqual(len(splitter.get("sizes").split(";")), len(splitter))

    def test_foxglove_shows_the_panels_that_are_described(self):
        layout = json.loads((LAYOUTS / "foxglove.json").read_text())
        described = layout["configById"]
        tabs = described[layout["layout"]]["tabs"]
        shown = [panel for tab in tabs for panel in panels(tab["layout"])]
        self.assertEqual(sorted([*shown, layout["layout"]]), sorted(described))


if __name__ == "__main__":
    unittest.main()
