"""A bag replayed into sysid by `ros2 bag play`; at its end the estimate is printed.

    ros2 launch planesman replay.launch.py bag:=runs/dive-TIME/bag params_file:=runs/dive-TIME/parameters.yaml
    planesman watch     # in another terminal: the estimate as it grows
"""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

# name: default, description.
ARGUMENTS = {
    'bag': (None, 'The bag.'),
    'params_file': ('', "Parameter file; the values for the node sysid are used."),
    'input': ('plane_motion:dive_planes', 'Input signal, TOPIC:FIELD.'),
    'input_type': ('planesman_msgs/msg/PlaneMotion', "Message type of the input's topic."),
    'output': ('state:pitch_rate', 'Output signal, TOPIC:FIELD.'),
    'output_type': ('planesman_msgs/msg/VehicleState', "Message type of the output's topic."),
    'namespace': ('auv', 'Namespace of sysid and of topics without a leading slash.'),
    'rate': ('1.0', 'Seconds of the bag per second.'),
}


def generate_launch_description():
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=start)])


def start(context):
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    bag = Path(given['bag']).expanduser().absolute()
    if not bag.exists():
        raise RuntimeError(f"bag: there is no '{bag}'")
    signals = {name: given[name] for name in ('input', 'input_type', 'output', 'output_type')}
    # As it may have been in the dive that the parameters come from.
    signals.update({'use_sim_time': False, 'answer': False})
    if signals['output'] != ARGUMENTS['output'][0]:
        signals['break_on'] = ''
    namespace = '/' + given['namespace'].strip('/')
    inside = namespace.rstrip('/') + '/'
    topics = sorted({topic_of(given[name], inside) for name in ('input', 'output')})
    fit = ExecuteProcess(
        cmd=['ros2', 'service', 'call', f'{inside}sysid/fit', 'planesman_msgs/srv/Fit'],
        name='fit',
        output='screen',
        on_exit=lambda event, context: ended(event, context, Shutdown(reason='the bag is replayed')),
    )
    # The bag's own estimates stay out; so does its /clock, since sysid goes by stamps.
    play = ExecuteProcess(
        cmd=['ros2', 'bag', 'play', str(bag), '--rate', given['rate'], '--delay', '2', '--topics', *topics],
        name='play',
        output='screen',
        on_exit=lambda event, context: ended(event, context, fit),
    )
    sysid = Node(
        package='planesman',
        executable='sysid',
        name='sysid',
        namespace=namespace,
        parameters=[*([given['params_file']] if given['params_file'] else []), signals],
        output='screen',
        on_exit=lambda event, context: ended(event, context, Shutdown(reason='sysid has ended')),
    )
    return [sysid, play]


def topic_of(signal, inside):
    """The full name of a signal's topic, by what stands before names of the namespace."""
    topic = signal.split(':')[0]
    return topic if topic.startswith('/') else inside + topic


def ended(event, context, then):
    """What follows the end of a process, an error if it failed."""
    if context.is_shutdown:
        return []
    if event.returncode != 0:
        # launch ends with an error only by an exception.
        raise RuntimeError(f'{event.process_name} has failed, exit code {event.returncode}')
    return [then]
