"""What launch-scripts/planesman.launch.py starts, told by stand-ins for `launch` and `launch_ros`.

Neither package is to be had outside a ROS installation. The stand-ins have only what the launch
file uses, and keep what they are given.
"""

import importlib.util
import sys
import types
import unittest
from pathlib import Path
from unittest import mock

from ruamel.yaml import YAML

SCRIPTS = Path(__file__).resolve().parents[2] / "launch-scripts"
EVERYBODY = ["recorder", "sysid", "dha_actuator", "depth_controller", "plant_sim"]


class Record:
    """An action: what it was made of."""

    def __init__(self, *positional, **named):
        self.positional = positional
        self.__dict__.update(named)


class Declared(Record):
    def __init__(self, name, *, default_value, choices=None, description):
        super().__init__(name=name, default_value=default_value, choices=choices, description=description)


class Node(Record):
    """With the names of launch_ros's Node; any other is refused as there."""

    def __init__(self, *, executable, arguments, name, namespace, parameters, output, on_exit):
        super().__init__(
            executable=executable,
            arguments=arguments,
            name=name,
            namespace=namespace,
            parameters=parameters,
            output=output,
            on_exit=on_exit,
        )


class Configuration:
    """A launch configuration, looked up in a context that is a dict."""

    def __init__(self, name):
        self.name = name

    def perform(self, context):
        return context[self.name]


def module(name, **content):
    made = types.ModuleType(name)
    made.__dict__.update(content)
    return made


STAND_INS = {
    "launch": module("launch", LaunchDescription=Record),
    "launch.actions": module(
        "launch.actions", DeclareLaunchArgument=Declared, OpaqueFunction=Record, Shutdown=Record
    ),
    "launch.substitutions": module("launch.substitutions", LaunchConfiguration=Configuration),
    "launch_ros": module("launch_ros"),
    "launch_ros.actions": module("launch_ros.actions", Node=Node),
}


def launch(**arguments) -> dict[str, Node]:
    """The nodes that `ros2 launch` with these arguments starts, by name."""
    spec = importlib.util.spec_from_file_location("planesman_launch", SCRIPTS / "planesman.launch.py")
    launch_file = importlib.util.module_from_spec(spec)
    with mock.patch.dict(sys.modules, STAND_INS):
        spec.loader.exec_module(launch_file)
        *declared, opaque = launch_file.generate_launch_description().positional[0]
    context = {argument.name: argument.default_value for argument in declared}
    context["bin"] = sys.executable  # Any program that is there.
    for name, value in arguments.items():
        choices = next(argument.choices for argument in declared if argument.name == name)
        assert choices is None or value in choices, f"{name}:={value}"
        context[name] = value
    return {node.name: node for node in opaque.function(context)}


def decided(nodes: dict[str, Node], node: str) -> dict:
    """What the launch decides over the parameter file."""
    return nodes[node].parameters[1]


class LaunchFile(unittest.TestCase):
    def test_the_default_is_the_whole_loop_in_real_time(self):
        nodes = launch()
        self.assertEqual(list(nodes), EVERYBODY)
        for name, node in nodes.items():
            self.assertEqual(node.executable, str(Path(sys.executable).absolute()))
            self.assertEqual(node.arguments, ["node", name])
            self.assertEqual(node.namespace, "auv")
            self.assertEqual(node.parameters[0], str(SCRIPTS / "params.yaml"))
        self.assertEqual(decided(nodes, "plant_sim")["time"], "real")
        self.assertNotIn("lockstep.members", decided(nodes, "plant_sim"))
        self.assertFalse(any(decided(nodes, name).get("use_sim_time") for name in EVERYBODY))

    def test_in_lockstep_who_is_waited_for_answers(self):
        for record in ("true", "false"):
            nodes = launch(time="lockstep", record=record)
            self.assertEqual("recorder" in nodes, record == "true")
            members = decided(nodes, "plant_sim")["lockstep.members"]
            answering = [name for name in nodes if decided(nodes, name).get("answer")]
            self.assertEqual(sorted(members), sorted(answering))
            for name in ("dha_actuator", "depth_controller"):
                self.assertIs(decided(nodes, name)["lockstep"], True, name)
            followers = [name for name in nodes if name != "plant_sim"]
            self.assertTrue(all(decided(nodes, name)["use_sim_time"] is True for name in followers))

    def test_whoever_does_not_make_the_clock_follows_it(self):
        for arguments in ({"factor": "10"}, {"use_sim_time": "true"}):
            nodes = launch(**arguments)
            self.assertNotIn("use_sim_time", decided(nodes, "plant_sim"))
            for name in EVERYBODY[:-1]:
                self.assertIs(decided(nodes, name)["use_sim_time"], True, name)
        self.assertEqual(decided(launch(factor="10"), "plant_sim")["factor"], 10.0)

    def test_a_second_vehicle_has_frames_of_its_own(self):
        self.assertEqual(decided(launch(), "plant_sim")["frame_prefix"], "")
        for namespace in ("auv2", "/auv2"):
            second = launch(namespace=namespace)
            self.assertEqual(second["plant_sim"].namespace, namespace)
            self.assertEqual(decided(second, "plant_sim")["frame_prefix"], "auv2/")
        chosen = launch(namespace="auv2", frame_prefix="other/")
        self.assertEqual(decided(chosen, "plant_sim")["frame_prefix"], "other/")

    def test_it_decides_only_declared_parameters_in_their_types(self):
        defaults = YAML(typ="safe").load(SCRIPTS / "params.yaml")
        for arguments in ({}, {"time": "lockstep"}, {"factor": "2.5", "bag": "a/b"}):
            for name, node in launch(**arguments).items():
                declared = defaults[f"/**/{name}"]["ros__parameters"]
                for parameter, value in node.parameters[1].items():
                    if parameter == "use_sim_time":
                        self.assertIsInstance(value, bool)
                        continue
                    self.assertIs(type(value), type(declared[parameter]), f"{name}: {parameter}")

    def test_what_cannot_be_is_refused_before_anything_starts(self):
        for arguments, word in (
            ({"bin": "/nowhere/planesman"}, "/nowhere/planesman"),
            ({"scenario_params": "/nowhere/params.yaml"}, "scenario_params"),
            ({"factor": "fast"}, "fast"),
            ({"time": "lockstep", "factor": "2"}, "lockstep"),
        ):
            with self.subTest(arguments), self.assertRaisesRegex(RuntimeError, word):
                launch(**arguments)


if __name__ == "__main__":
    unittest.main()
