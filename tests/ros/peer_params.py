#!/usr/bin/env python3
"""Lists, reads, sets and describes a node's parameters with rclpy's own client, as `ros2 param` does; one JSON line each,
as ../peers/peer_params.py prints them.

    peer_params.py --domain 0 /auv/depth_controller list
    peer_params.py --domain 0 /auv/depth_controller get depth.gain pitch.gain
    peer_params.py --domain 0 /auv/depth_controller set depth.gain=0.5 [--atomically]
    peer_params.py --domain 0 /auv/depth_controller describe depth.gain

Exit status 1: the node did not answer within --timeout seconds. 3: it answered, and refused a value or does not know a
parameter.
"""

import argparse
import json
import sys

import ros
from rcl_interfaces.msg import ParameterType
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient

REFUSED = 3


def parse_value(text: str):
    """JSON where it is JSON, else the text itself."""
    try:
        return json.loads(text)
    except json.JSONDecodeError:
        return text


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--domain", type=int, required=True)
    parser.add_argument("node", help="the node's full name, such as /auv/depth_controller")
    parser.add_argument("verb", choices=["list", "get", "set", "describe"])
    parser.add_argument("what", nargs="*", metavar="NAME[=VALUE]")
    parser.add_argument("--atomically", action="store_true", help="set all or none")
    parser.add_argument("--timeout", type=float, default=10.0, help="s (default %(default)s)")
    args = parser.parse_args()

    def show(**line) -> None:
        print(json.dumps(line), flush=True)

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
                        show(name=name)
                case "get":
                    values = [parameter_value_to_python(value) for value in answer(client.get_parameters(args.what)).values]
                    for name, value in zip(args.what, values):
                        show(name=name, value=value)
                    if len(values) != len(args.what) or None in values:
                        return REFUSED
                case "describe":
                    descriptors = answer(client.describe_parameters(args.what)).descriptors
                    for descriptor in descriptors:
                        show(**ros.to_json(descriptor))
                    known = [descriptor.type != ParameterType.PARAMETER_NOT_SET for descriptor in descriptors]
                    if len(descriptors) != len(args.what) or not all(known):
                        return REFUSED
                case "set":
                    pairs = [item.split("=", 1) for item in args.what]
                    parameters = [Parameter(name, value=parse_value(text)) for name, text in pairs]
                    if args.atomically:
                        result = answer(client.set_parameters_atomically(parameters)).result
                        show(names=[name for name, _ in pairs], **ros.to_json(result))
                        results = [result]
                    else:
                        results = answer(client.set_parameters(parameters)).results
                        for (name, _), result in zip(pairs, results):
                            show(name=name, **ros.to_json(result))
                    if not all(result.successful for result in results):
                        return REFUSED
        except ros.NoAnswer as failure:
            print(failure, file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
