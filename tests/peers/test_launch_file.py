"""What the launch files of launch-scripts/launch start, told by stand-ins for `launch` and `launch_ros`.

Neither package is to be had outside a ROS installation. The stand-ins have only what the launch
files use, and keep what they are given.
"""

import importlib.util
import os
import sys
import tempfile
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

    def __init__(
        self, *, package, executable, name, namespace, parameters, output, on_exit=None, respawn=False, respawn_delay=None
    ):
        super().__init__(
            package=package,
            executable=executable,
            name=name,
            namespace=namespace,
            parameters=parameters,
            output=output,
            on_exit=on_exit,
            respawn=respawn,
            respawn_delay=respawn_delay,
        )


class Process(Record):
    """With the names of launch's ExecuteProcess that are used here."""

    def __init__(self, *, cmd, name, output, on_exit):
        super().__init__(cmd=cmd, name=name, output=output, on_exit=on_exit)


class Context(dict):
    """A launch context: its configurations, and whether it shuts down."""

    is_shutdown = False


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


FOLDER = tempfile.TemporaryDirectory()
# The installed program; it knows the scenario `dive`.
PROGRAM = Path(FOLDER.name) / "lib" / "planesman" / "planesman"
PROGRAM.parent.mkdir(parents=True)
PROGRAM.write_text(
    """#!/bin/sh
case "$*" in
"params --yaml --scenario dive") echo "# $4" ;;
"params --yaml --scenario bluerov2") printf '/**/depth_controller:\\n  ros__parameters:\\n    mode: hover\\n' ;;
*) echo "no $4" >&2; exit 1 ;;
esac
"""
)
PROGRAM.chmod(0o755)
Path(FOLDER.name, "share").mkdir()
Path(FOLDER.name, "share", "planesman").symlink_to(SCRIPTS)

STAND_INS = {
    "ament_index_python": module("ament_index_python"),
    "ament_index_python.packages": module(
        "ament_index_python.packages", get_package_prefix=lambda name: {"planesman": FOLDER.name}[name]
    ),
    "launch": module("launch", LaunchDescription=Record),
    "launch.actions": module(
        "launch.actions",
        DeclareLaunchArgument=Declared,
        ExecuteProcess=Process,
        OpaqueFunction=Record,
        Shutdown=Record,
    ),
    "launch.logging": module("launch.logging", launch_config=Record(log_dir=FOLDER.name)),
    "launch.substitutions": module("launch.substitutions", LaunchConfiguration=Configuration),
    "launch_ros": module("launch_ros"),
    "launch_ros.actions": module("launch_ros.actions", Node=Node),
}


def started(launch_file: str, **arguments) -> list[Record]:
    """What `ros2 launch planesman FILE` with these arguments starts."""
    spec = importlib.util.spec_from_file_location("launch_file", SCRIPTS / "launch" / launch_file)
    loaded = importlib.util.module_from_spec(spec)
    with mock.patch.dict(sys.modules, STAND_INS), mock.patch.dict(os.environ):
        spec.loader.exec_module(loaded)
        *declared, opaque = loaded.generate_launch_description().positional[0]
        context = Context({argument.name: argument.default_value for argument in declared})
        for name, value in arguments.items():
            choices = next(argument.choices for argument in declared if argument.name == name)
            assert choices is None or value in choices, f"{name}:={value}"
            context[name] = value
        return opaque.function(context)


def launch(**arguments) -> dict[str, Node]:
    """The nodes of a dive, by name."""
    return {node.name: node for node in started("dive.launch.py", **arguments)}


def decided(nodes: dict[str, Node], node: str) -> dict:
    """What the launch decides over the parameter files."""
    return nodes[node].parameters[-1]


def exits(action, returncode: int, shutting_down: bool = False):
    """What follows when the action's process ends so."""
    context = Context()
    context.is_shutdown = shutting_down
    return action.on_exit(Record(process_name=action.name, returncode=returncode), context)


class LaunchFile(unittest.TestCase):
    def test_the_default_is_the_whole_loop_in_real_time(self):
        nodes = launch()
        self.assertEqual(list(nodes), EVERYBODY)
        for name, node in nodes.items():
            self.assertEqual((node.package, node.executable), ("planesman", name))
            self.assertEqual(node.namespace, "auv")
            self.assertEqual(Path(node.parameters[0]).read_text(), "# dive\n")
        self.assertEqual(decided(nodes, "plant_sim")["time"], "real")
        self.assertNotIn("lockstep.members", decided(nodes, "plant_sim"))
        self.assertFalse(any(decided(nodes, name).get("use_sim_time") for name in EVERYBODY))

    def test_a_node_of_ones_own_takes_the_place_of_ours(self):
        self.assertNotIn("depth_controller", launch(controller="false"))
        nodes = launch(actuator="false")
        self.assertNotIn("dha_actuator", nodes)
        installed = Path(nodes["sysid"].parameters[1])
        listens = SCRIPTS / installed.relative_to(Path(FOLDER.name, "share", "planesman"))
        [(_, inside)] = YAML(typ="safe").load(listens).items()
        self.assertEqual(inside["ros__parameters"]["input"], "planes:position[0]")
        self.assertEqual(len(launch()["sysid"].parameters), 2)
        nodes = launch(controller="false", actuator="false", time="lockstep", gates="filtered, /leak")
        self.assertEqual(list(nodes), ["recorder", "sysid", "plant_sim"])
        self.assertEqual(decided(nodes, "plant_sim")["lockstep.gates"], ["filtered", "/leak"])
        self.assertNotIn("lockstep.gates", decided(launch(time="lockstep"), "plant_sim"))
        with self.assertRaisesRegex(RuntimeError, "gates"):
            launch(gates="filtered")

    def test_with_respawn_nodes_that_may_come_back_do_not_end_the_launch(self):
        nodes = launch(respawn="true")
        again = [name for name, node in nodes.items() if node.respawn]
        self.assertEqual(again, ["sysid", "dha_actuator", "depth_controller"])
        self.assertTrue(all(nodes[name].on_exit is None for name in again))
        self.assertTrue(all(nodes[name].on_exit for name in ("plant_sim", "recorder")))
        self.assertFalse(any(node.respawn for node in launch().values()))

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

    def test_sysid_is_waited_for_only_where_its_input_can_come(self):
        def members(**arguments):
            nodes = launch(time="lockstep", **arguments)
            answering = [name for name in ("sysid", "recorder") if name in nodes and decided(nodes, name)["answer"]]
            self.assertEqual(decided(nodes, "plant_sim")["lockstep.members"], answering)
            return answering

        self.assertEqual(members(), ["sysid", "recorder"])
        self.assertEqual(members(controller="false"), ["sysid", "recorder"])
        self.assertEqual(members(scenario="bluerov2"), ["sysid", "recorder"])
        self.assertEqual(members(scenario="bluerov2", controller="false"), ["recorder"])
        self.assertEqual(members(sysid="false"), ["recorder"])
        self.assertNotIn("sysid", launch(sysid="false"))
        own = Path(FOLDER.name) / "own.yaml"
        own.write_text("/**/sysid:\n  ros__parameters:\n    input: thruster_command:command[0]\n")
        self.assertEqual(members(scenario="bluerov2", controller="false", params_file=str(own)), ["sysid", "recorder"])

    def test_reliable_sensors_are_published_and_recorded_so(self):
        nodes = launch(reliable_sensors="true")
        for name in ("plant_sim", "recorder"):
            self.assertTrue(decided(nodes, name)["reliable_sensors"])
        self.assertNotIn("reliable_sensors", decided(launch(), "plant_sim"))

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
        defaults = YAML(typ="safe").load(SCRIPTS / "params" / "params.yaml")
        for arguments in ({}, {"time": "lockstep", "gates": "estimate"}, {"factor": "2.5", "bag": "a/b", "duration": "9"}):
            for name, node in launch(**arguments).items():
                declared = defaults[f"/**/{name}"]["ros__parameters"]
                for parameter, value in node.parameters[-1].items():
                    if parameter == "use_sim_time":
                        self.assertIsInstance(value, bool)
                        continue
                    self.assertIs(type(value), type(declared[parameter]), f"{name}: {parameter}")

    def test_each_nodes_diagnostics_go_to_one_analyzer(self):
        analyzers = YAML(typ="safe").load(SCRIPTS / "params" / "analyzers.yaml")["/**"]["ros__parameters"]
        groups = [group["contains"] for group in analyzers.values() if isinstance(group, dict)]
        for node in EVERYBODY:
            # As `crates/ros/node` names a status: the node's full name, a colon, what it is of.
            for status in (f"/auv/{node}: connections", f"/auv2/{node}: vehicle"):
                taken = [group for group in groups if any(text in status for text in group)]
                self.assertEqual(len(taken), 1, status)

    def test_what_cannot_be_is_refused_before_anything_starts(self):
        for arguments, word in (
            ({"scenario": "nowhere"}, "scenario: no nowhere"),
            ({"params_file": "/nowhere/params.yaml"}, "params_file"),
            ({"factor": "fast"}, "fast"),
            ({"duration": "long"}, "long"),
            ({"vehicles": "0"}, "vehicles"),
            ({"vehicles": "some"}, "some"),
            ({"vehicles": "2", "factor": "2"}, "/clock"),
            ({"vehicles": "2", "frame_prefix": "a/"}, "frame_prefix"),
            ({"time": "lockstep", "factor": "2"}, "lockstep"),
        ):
            with self.subTest(arguments), self.assertRaisesRegex(RuntimeError, word):
                launch(**arguments)

    def test_several_vehicles_share_nothing(self):
        nodes = started("dive.launch.py", vehicles="3", bag="b")
        self.assertEqual(len(nodes), 15)
        for name, prefix in (("auv", ""), ("auv2", "auv2/"), ("auv3", "auv3/")):
            own = {node.name: node for node in nodes if node.namespace == name}
            self.assertEqual(list(own), EVERYBODY)
            self.assertEqual(decided(own, "plant_sim")["frame_prefix"], prefix)
            self.assertEqual(decided(own, "recorder")["output"], f"b/{name}")

    def test_it_ends_with_the_flight_and_fails_with_a_node(self):
        nodes = launch()
        for node in nodes.values():
            self.assertEqual(len(exits(node, 0)), 1)
            for code in (1, -9):
                with self.assertRaisesRegex(RuntimeError, node.name):
                    exits(node, code)
                self.assertEqual(exits(node, code, shutting_down=True), [])

    def test_a_vehicle_that_has_flown_leaves_the_others_flying(self):
        plants = [node for node in started("dive.launch.py", vehicles="2") if node.name == "plant_sim"]
        self.assertEqual(exits(plants[0], 0), [])
        self.assertEqual(len(exits(plants[1], 0)), 1)


class Replay(unittest.TestCase):
    def test_the_topics_of_the_signals_are_played_into_sysid_and_the_estimate_is_asked_for(self):
        sysid, play = started("replay.launch.py", bag=FOLDER.name)
        self.assertEqual((sysid.package, sysid.executable, sysid.namespace), ("planesman", "sysid", "/auv"))
        self.assertEqual(play.cmd[:4], ["ros2", "bag", "play", FOLDER.name])
        self.assertEqual(play.cmd[play.cmd.index("--topics") + 1 :], ["/auv/plane_motion", "/auv/state"])
        [fit] = exits(play, 0)
        self.assertEqual(fit.cmd[:4], ["ros2", "service", "call", "/auv/sysid/fit"])
        self.assertEqual(len(exits(fit, 0)), 1)
        with self.assertRaisesRegex(RuntimeError, "play"):
            exits(play, 2)

    def test_other_signals_are_another_bags_topics_and_have_no_flag(self):
        sysid, play = started(
            "replay.launch.py", bag=FOLDER.name, input="/cmd:data", output="imu:angular_velocity.y", namespace="/"
        )
        self.assertEqual(play.cmd[play.cmd.index("--topics") + 1 :], ["/cmd", "/imu"])
        self.assertEqual(sysid.parameters[-1]["break_on"], "")

    def test_a_bag_that_is_not_there_is_refused(self):
        with self.assertRaisesRegex(RuntimeError, "/nowhere"):
            started("replay.launch.py", bag="/nowhere")


if __name__ == "__main__":
    unittest.main()
