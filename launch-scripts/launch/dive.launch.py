"""The loop under ROS 2 launch: the vehicle, its controller, its actuator, sysid and the recorder.

    ros2 launch planesman dive.launch.py
    ros2 launch planesman dive.launch.py --show-args

It ends when the scenario is flown, on Ctrl-C, or when a node ends; with an error when a node fails. A controller or actuator
of one's own takes the place of ours with `controller:=false` or `actuator:=false`; it is started beside this launch.
"""

import os
import subprocess
import time
from functools import partial
from pathlib import Path

import yaml
from ament_index_python.packages import get_package_prefix
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.logging import launch_config
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

YES_OR_NO = ['true', 'false']

# name: default, choices, description.
ARGUMENTS = {
    'scenario': ('dive', None, 'Scenario: a name (dive, way_depths, open_loop, remus_100, lauv, turning_circle, zigzag, bluerov2, too_fast, identified) or a file.'),
    'duration': ('', None,
                 "Simulated seconds after which the launch ends, 0: never; empty: the scenario's."),
    'params_file': ('', None, "Parameter file whose values replace the scenario's."),
    'vehicles': ('1', None,
                 'Number of vehicles, in the namespaces NAMESPACE, NAMESPACE2, ...; by the wall clock.'),
    'namespace': ('auv', None,
                  'Namespace of all nodes and topics; another one for a second vehicle.'),
    'frame_prefix': ('', None,
                     'Put before the frames of one vehicle; '
                     'empty: NAMESPACE/ unless the namespace is auv.'),
    'time': ('real', ['real', 'lockstep'],
             'real: the wall clock times the factor; lockstep: as fast as all nodes answer.'),
    'factor': ('1.0', None, 'Simulated seconds per second in real time, 0.01 to 100.'),
    'use_sim_time': ('false', YES_OR_NO,
                     'Stamps from 0 and a /clock topic that all nodes follow; '
                     'always so in lockstep and with a factor other than 1.'),
    'controller': ('true', YES_OR_NO,
                   'Whether depth_controller is started; false: a node of your own publishes plane_command.'),
    'actuator': ('true', YES_OR_NO,
                 'Whether dha_actuator is started; false: a node of your own publishes planes, which sysid takes for its input '
                 '(params/own_actuator.yaml; a params_file may name another).'),
    'sysid': ('true', YES_OR_NO,
              'Whether sysid is started. In lockstep a tick waits for it, unless its input cannot come: in a scenario whose mode is '
              'hover, with controller:=false, nobody moves planes.'),
    'gates': ('', None,
              'In lockstep, topics of nodes of your own that every tick waits for, separated by commas: lockstep.gates of plant_sim.'),
    'reliable_sensors': ('false', YES_OR_NO,
                         'Whether the sensors are published reliably in real time too, as reliable subscriptions need; always so in lockstep.'),
    'respawn': ('false', YES_OR_NO,
                'Whether a controller, actuator or sysid that ends is started again after a second, instead of ending the launch.'),
    'record': ('true', YES_OR_NO, 'Whether the recorder writes a bag.'),
    'bag': ('', None, "The bag's folder, which must not exist; empty: bags/planesman_TIME. "
                      'With several vehicles the folder of their bags.'),
}


def generate_launch_description():
    declared = [
        DeclareLaunchArgument(name, default_value=default, choices=choices, description=text)
        for name, (default, choices, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=start_nodes)])


def start_nodes(context):
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    vehicles = vehicles_of(given)
    if len(vehicles) > 1:
        # Without multicast, as on most loopback interfaces, a node finds twelve participants; so 32.
        os.environ.setdefault('ROS_STATIC_PEERS', 'localhost')
    files = [scenario_parameters(given['scenario'])]
    if given['actuator'] == 'false':
        files.append(Path(get_package_prefix('planesman')) / 'share' / 'planesman' / 'params' / 'own_actuator.yaml')
    if given['params_file']:
        files.append(Path(given['params_file']).expanduser().absolute())
        if not files[-1].is_file():
            raise RuntimeError(f"params_file: there is no file '{files[-1]}'")
    for vehicle in vehicles:
        vehicle['sysid_answers'] = sysid_has_input(given, files)
    flying = {vehicle['namespace'] for vehicle in vehicles}
    return [
        Node(
            package='planesman',
            executable=name,
            name=name,
            namespace=vehicle['namespace'],
            parameters=[*map(str, files), parameters],
            output='screen',
            **exit_rule(flying, vehicle, name),
        )
        for vehicle in vehicles
        for name, parameters in node_parameters(vehicle).items()
    ]


def exit_rule(flying, vehicle, name):
    """What follows when a node ends. The vehicle ends when it has flown, and a bag cannot be written twice."""
    if vehicle['respawn'] == 'true' and name not in ('plant_sim', 'recorder'):
        return {'respawn': True, 'respawn_delay': 1.0}
    return {'on_exit': partial(ended, flying, vehicle['namespace'] if name == 'plant_sim' else None)}


def ended(flying, flown, event, context):
    """One node gone, all go: a loop with a part missing would only look alive. But a vehicle that has flown its duration
    leaves the others `flying`."""
    if context.is_shutdown:
        return []
    if event.returncode != 0:
        # launch ends with an error only by an exception.
        raise RuntimeError(f'{event.process_name} has failed, exit code {event.returncode}')
    flying.discard(flown)
    if flown and flying:
        return []
    return [Shutdown(reason=f'{event.process_name} has ended')]


def vehicles_of(given):
    """The arguments of each vehicle."""
    count = given['vehicles']
    if not count.isdecimal() or int(count) == 0:
        raise RuntimeError(f"vehicles: '{count}' is no number of vehicles")
    if count == '1':
        return [given]
    if given['time'] == 'lockstep' or given['use_sim_time'] == 'true' or number(given, 'factor') != 1.0:
        raise RuntimeError('vehicles: several fly by the wall clock alone, since /clock has one publisher')
    if given['frame_prefix']:
        raise RuntimeError('frame_prefix: several vehicles would share it')
    bags = given['bag'] or f"bags/planesman_{time.strftime('%Y%m%dT%H%M%SZ', time.gmtime())}"
    names = [given['namespace'] + ('' if i == 1 else str(i)) for i in range(1, int(count) + 1)]
    return [{**given, 'namespace': name, 'bag': f"{bags}/{name.strip('/')}"} for name in names]


def scenario_parameters(scenario):
    """The scenario as a parameter file, beside the log of this launch."""
    program = Path(get_package_prefix('planesman')) / 'lib' / 'planesman' / 'planesman'
    printed = subprocess.run(
        [program, 'params', '--yaml', '--scenario', scenario], capture_output=True, text=True)
    if printed.returncode != 0:
        raise RuntimeError(f'scenario: {printed.stderr.strip()}')
    file = Path(launch_config.log_dir) / 'parameters.yaml'
    file.write_text(printed.stdout)
    return file


def sysid_has_input(given, files):
    """Whether the input of sysid can come. A controller of one's own that hovers commands thrusters, so that no plane moves."""
    values = {'mode': '', 'input': 'plane_motion:dive_planes'}
    for file in files:
        for node, content in (yaml.safe_load(Path(file).read_text()) or {}).items():
            for name in ('mode', 'input'):
                owner = 'depth_controller' if name == 'mode' else 'sysid'
                if node.split('/')[-1] in (owner, '**'):
                    values[name] = content.get('ros__parameters', {}).get(name, values[name])
    is_of_planes = values['input'].split(':')[0].split('/')[-1] in ('plane_motion', 'planes')
    return not (is_of_planes and values['mode'] == 'hover' and given['controller'] == 'false')


def node_parameters(given):
    """What this launch decides for each node, over what the parameter files say.

    In lockstep the vehicle waits in each tick for its members' answers, so the members, those
    who answer, and the actuator's patience are set together here. Who makes the time is set
    together with who follows it.
    """
    factor = number(given, 'factor')
    lockstep = given['time'] == 'lockstep'
    record = given['record'] == 'true'
    sim_time = given['use_sim_time'] == 'true'
    if lockstep and factor != 1.0:
        raise RuntimeError('factor: lockstep has no use for one, it runs as fast as it can')
    follow = {'use_sim_time': lockstep or sim_time or factor != 1.0}

    nodes = {}
    reliable = {'reliable_sensors': True} if given['reliable_sensors'] == 'true' else {}
    if record:
        nodes['recorder'] = {**follow, **reliable, 'answer': lockstep, 'output': given['bag']}
    if given['sysid'] == 'true':
        nodes['sysid'] = {**follow, 'answer': lockstep and given['sysid_answers']}
    frames = {'frame_prefix': frame_prefix(given)}
    if given['actuator'] == 'true':
        nodes['dha_actuator'] = {**follow, **frames, 'lockstep': lockstep}
    if given['controller'] == 'true':
        nodes['depth_controller'] = {**follow, **frames, 'lockstep': lockstep}
    nodes['plant_sim'] = {
        'time': given['time'],
        'factor': factor,
        'sim_time': sim_time,
        'end_when_flown': True,
        **frames,
        **reliable,
    }
    if given['duration']:
        nodes['plant_sim']['duration'] = number(given, 'duration')
    if lockstep:
        members = [name for name in ('sysid', 'recorder') if nodes.get(name, {}).get('answer')]
        nodes['plant_sim']['lockstep.members'] = members
    gates = [name.strip() for name in given['gates'].split(',') if name.strip()]
    if gates and not lockstep:
        raise RuntimeError('gates: only ticks of time:=lockstep wait for them')
    if gates:
        nodes['plant_sim']['lockstep.gates'] = gates
    return nodes


def number(given, name):
    try:
        return float(given[name])
    except ValueError:
        raise RuntimeError(f"{name}: '{given[name]}' is no number") from None


def frame_prefix(given):
    namespace = given['namespace'].strip('/')
    if given['frame_prefix'] or namespace in ('', 'auv'):
        return given['frame_prefix']
    return f'{namespace}/'
