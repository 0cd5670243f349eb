"""Every curve in the plot layouts of launch-scripts is a field of the message on its topic."""

import json
import re
import unittest
import xml.etree.ElementTree
from pathlib import Path

import ros_types

SCRIPTS = Path(__file__).resolve().parents[2] / "launch-scripts"
TYPES = {
    "/auv/state": "planesman_msgs/msg/VehicleState",
    "/auv/control_state": "planesman_msgs/msg/ControlState",
    "/auv/dha_state": "planesman_msgs/msg/DhaState",
    "/auv/model": "planesman_msgs/msg/ModelEstimate",
}
NUMBERS = {name for name in ros_types.PRIMITIVES if name != "string"}


def panels(node) -> list[str]:
    """The panels that a Foxglove mosaic shows."""
    if isinstance(node, str):
        return [node]
    assert set(node) == {"direction", "first", "second", "splitPercentage"}, node
    return panels(node["first"]) + panels(node["second"])


class Layouts(unittest.TestCase):
    def assert_is_a_number(self, topic: str, field: str):
        fields, _ = ros_types.definition(TYPES[topic])
        name, index = re.fullmatch(r"(\w+)(\[\d+\])?", field).groups()
        found = {f.name: f for f in fields}.get(name)
        self.assertIsNotNone(found, f"{topic} has no field {name}")
        self.assertIn(found.base, NUMBERS)
        self.assertEqual(found.shape == "one", index is None, f"{topic} {field}")

    def test_plotjuggler_plots_fields_that_are_there(self):
        root = xml.etree.ElementTree.parse(SCRIPTS / "layouts" / "plotjuggler.xml").getroot()
        curves = [curve.get("name") for curve in root.iter("curve")]
        self.assertGreater(len(curves), 10)
        for curve in curves:
            topic, field = curve.rsplit("/", 1)
            self.assert_is_a_number(topic, field)
        for plugin in root.iter("plugin"):
            topics = plugin.find("selected_topics").get("value").split(";")
            self.assertEqual(set(topics), set(TYPES))
        for splitter in root.iter("DockSplitter"):
            self.assertEqual(int(splitter.get("count")), len(splitter))
            self.assertEqual(len(splitter.get("sizes").split(";")), len(splitter))

    def test_foxglove_shows_fields_that_are_there_in_panels_that_are_described(self):
        layout = json.loads((SCRIPTS / "layouts" / "foxglove.json").read_text())
        described = layout["configById"]
        tabs = described[layout["layout"]]["tabs"]
        shown = [panel for tab in tabs for panel in panels(tab["layout"])]
        self.assertEqual(sorted([*shown, layout["layout"]]), sorted(described))
        for panel in shown:
            kind, config = panel.split("!")[0], described[panel]
            if kind == "RawMessages":
                self.assertIn(config["topicPath"], TYPES)
                continue
            self.assertEqual(kind, "Plot")
            for path in config["paths"]:
                topic, field = path["value"].split(".", 1)
                self.assert_is_a_number(topic, field)


if __name__ == "__main__":
    unittest.main()
