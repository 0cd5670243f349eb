"""The loop under ROS 2 launch: the vehicle, its controller, its actuator, sysid and the recorder.

    ros2 launch ./launch-scripts/planesman.launch.py
    ros2 launch ./launch-scripts/planesman.launch.py --show-args

Started by its path; no ament package is needed. Each node is the `planesman` program that
`cargo build --release` makes, as a process of its own (`planesman node NAME`).
"""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

HERE = Path(__file__).resolve().parent
YES_OR_NO = ['true', 'false']

# name: default, choices, description.
ARGUMENTS = {
    'bin': (str(HERE.parent / 'target' / 'release' / 'planesman'), None,
            'The planesman program.'),
    'namespace': ('auv', None,
                  'Namespace of all nodes and topics; another one for a second vehicle.'),
    'frame_prefix': ('', None,
                     'Put before the frames odom and base_link; '
                     'empty: NAMESPACE/ unless the namespace is auv.'),
    'scenario_params': (str(HERE / 'params.yaml'), None,
                        'Parameter file; planesman params --yaml --scenario NAME writes one.'),
    'time': ('real', ['real', 'lockstep'],
             'real: the wall clock times the factor; lockstep: as fast as all nodes answer.'),
    'factor': ('1.0', None, 'Simulated seconds per second in real time, 0.01 to 100.'),
    'use_sim_time': ('false', YES_OR_NO,
                     'Stamps from 0 and a /clock topic that all nodes follow; '
                     'always so in lockstep and with a factor other than 1.'),
    'record': ('true', YES_OR_NO, 'Whether the recorder writes a bag.'),
    'bag': ('', None, "The bag's folder, which must not exist; empty: bags/planesman_TIME."),
}


def generate_launch_description():
    declared = [
        DeclareLaunchArgument(name, default_value=default, choices=choices, description=text)
        for name, (default, choices, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=start_nodes)])


def start_nodes(context):
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    program = Path(given['bin']).expanduser().absolute()
    if not program.is_file():
        raise RuntimeError(
            f"there is no program '{program}': build it with 'cargo build --release', "
            "or name it with bin:=PATH")
    scenario = Path(given['scenario_params']).expanduser().absolute()
    if not scenario.is_file():
        raise RuntimeError(f"scenario_params: there is no file '{scenario}'")
    # One node gone, all go: a loop with a part missing would only look alive.
    return [
        Node(
            executable=str(program),
            arguments=['node', name],
            name=name,
            namespace=given['namespace'],
            parameters=[str(scenario), parameters],
            output='screen',
            on_exit=Shutdown(reason=f'{name} has ended'),
        )
        for name, parameters in node_parameters(given).items()
    ]


def node_parameters(given):
    """What this launch decides for each node, over what the parameter file says.

    In lockstep the vehicle waits in each tick for its members' answers, so the members, those
    who answer, and the actuator's patience are set together here. Who makes the time is set
    together with who follows it.
    """
    try:
        factor = float(given['factor'])
    except ValueError:
        raise RuntimeError(f"factor: '{given['factor']}' is no number") from None
    lockstep = given['time'] == 'lockstep'
    record = given['record'] == 'true'
    sim_time = given['use_sim_time'] == 'true'
    if lockstep and factor != 1.0:
        raise RuntimeError('factor: lockstep has no use for one, it runs as fast as it can')
    follow = {'use_sim_time': lockstep or sim_time or factor != 1.0}

    nodes = {}
    if record:
        nodes['recorder'] = {**follow, 'answer': lockstep, 'output': given['bag']}
    nodes['sysid'] = {**follow, 'answer': lockstep}
    nodes['dha_actuator'] = {**follow, 'lockstep': lockstep}
    nodes['depth_controller'] = {**follow, 'lockstep': lockstep}
    nodes['plant_sim'] = {
        'time': given['time'],
        'factor': factor,
        'sim_time': sim_time,
        'frame_prefix': frame_prefix(given),
    }
    if lockstep:
        members = [name for name in ('sysid', 'recorder') if name in nodes]
        nodes['plant_sim']['lockstep.members'] = members
    return nodes


def frame_prefix(given):
    namespace = given['namespace'].strip('/')
    if given['frame_prefix'] or namespace in ('', 'auv'):
        return given['frame_prefix']
    return f'{namespace}/'
