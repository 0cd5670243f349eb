#!/usr/bin/env python3
"""Lists, reads, sets and describes a node's parameters with rclpy's own client, as `ros2 param` does; one JSON line each,
as ../peers/peer_params.py prints them.

    peer_params.py --domain 0 /auv/depth_controller list
    peer_params.py --domain 0 /auv/depth_controller get depth.gain pitch.gain
    peer_params.py --domain 0 /auv/depth_controller set depth.gain=0.5 [--atomically]
    peer_params.py --domain 0 /auv/depth_controller describe depth.gain
    peer_params.py --domain 0 /auv/depth_controller reload

`reload` writes all values into a file as `ros2 param dump` does, and sets them from it as `ros2 param load` does.

Exit status 1: the node did not answer within --timeout seconds. 3: it answered, and refused a value or does not know a
parameter.
"""

import sys
import tempfile

import ros
import arguments
import yaml
from rcl_interfaces.msg import ParameterType
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient

REFUSED = 3


def nested(names: list[str], values: list) -> dict:
    """A mapping of mappings, one for each level of the names."""
    top: dict = {}
    for name, value in zip(names, values):
        *levels, last = name.split(".")
        inside = top
        for level in levels:
            inside = inside.setdefault(level, {})
        inside[last] = value.tolist() if hasattr(value, "tolist") else value
    return top


def main() -> int:
    args = arguments.params(__doc__, "reload")

    with ros.node(args.domain) as node:
        client = AsyncParameterClient(node, args.node)

        def answer(future):
            if not ros.spin_until(node, future.done, args.timeout):
                raise ros.NoAnswer(f"{args.node}: no answer within {args.timeout:g} s")
            return future.result()

        try:
            if not client.wait_for_services(args.timeout):
                raise ros.NoAnswer(f"{args.node}: not there within {args.timeout:g} s")
            match args.verb:
                case "list":
                    for name in answer(client.list_parameters(args.what)).result.names:
                        arguments.show(name=name)
                case "get":
                    values = [parameter_value_to_python(value) for value in answer(client.get_parameters(args.what)).values]
                    for name, value in zip(args.what, values):
                        arguments.show(name=name, value=value)
                    if len(values) != len(args.what) or None in values:
                        return REFUSED
                case "describe":
                    descriptors = answer(client.describe_parameters(args.what)).descriptors
                    for descriptor in descriptors:
                        arguments.show(**ros.to_json(descriptor))
                    known = [descriptor.type != ParameterType.PARAMETER_NOT_SET for descriptor in descriptors]
                    if len(descriptors) != len(args.what) or not all(known):
                        return REFUSED
                case "set":
                    pairs = [item.split("=", 1) for item in args.what]
                    parameters = [Parameter(name, value=arguments.value(text)) for name, text in pairs]
                    if args.atomically:
                        result = answer(client.set_parameters_atomically(parameters)).result
                        arguments.show(names=[name for name, _ in pairs], **ros.to_json(result))
                        results = [result]
                    else:
                        results = answer(client.set_parameters(parameters)).results
                        for (name, _), result in zip(pairs, results):
                            arguments.show(name=name, **ros.to_json(result))
                    if not all(result.successful for result in results):
                        return REFUSED
                case "reload":
                    names = sorted(answer(client.list_parameters()).result.names)
                    values = [parameter_value_to_python(value) for value in answer(client.get_parameters(names)).values]
                    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
                        yaml.dump({args.node: {"ros__parameters": nested(names, values)}}, file)
                        file.flush()
                        results = answer(client.load_parameter_file(file.name)).results
                    for result in results:
                        arguments.show(**ros.to_json(result))
                    if len(results) != len(names) or not all(result.successful for result in results):
                        return REFUSED
        except ros.NoAnswer as failure:
            print(failure, file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
