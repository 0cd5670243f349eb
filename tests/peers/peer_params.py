#!/usr/bin/env python3
"""Lists, reads, sets and describes a node's parameters as a Cyclone DDS peer; one JSON line each.

    peer_params.py --domain 0 /auv/depth_controller list
    peer_params.py --domain 0 /auv/depth_controller get depth.gain pitch.gain
    peer_params.py --domain 0 /auv/depth_controller set depth.gain=0.5 [--atomically]
    peer_params.py --domain 0 /auv/depth_controller describe depth.gain

A value is JSON: true, 3, 0.5, "text", [1.0, 2.0]; NaN is taken too; anything else is a string.
Exit status 1: the node did not answer within --timeout seconds. 3: it answered, and refused a value
or does not know a parameter.
"""

import sys

import arguments
import ros_types
from cyclone import Peer
from ros_service import Client, NoAnswer

REFUSED = 3


def fields_by_type() -> dict[int, str]:
    """ParameterType's number -> the ParameterValue field that holds such a value."""
    constants = ros_types.constants("rcl_interfaces/msg/ParameterType")
    names = {number: name.removeprefix("PARAMETER_").lower() for name, number in constants.items()}
    return {number: f"{name}_value" for number, name in names.items() if name != "not_set"}


def value_of(parameter_value: dict):
    """The plain value in a ParameterValue, None when it is not set."""
    field = fields_by_type().get(parameter_value["type"])
    return parameter_value[field] if field else None


def parameter_value(value) -> dict:
    """The ParameterValue that holds a plain value."""
    array = isinstance(value, list)
    sample = (value or [0.0])[0] if array else value
    name = {bool: "bool", int: "integer", float: "double", str: "string"}[type(sample)]
    field = f"{name}_array_value" if array else f"{name}_value"
    number = next(number for number, candidate in fields_by_type().items() if candidate == field)
    return {"type": number, field: value}


def main() -> int:
    args = arguments.params(__doc__)
    peer = Peer(args.domain)

    def call(service: str, type_name: str, request: dict) -> dict:
        client = Client(peer, f"{args.node}/{service}", f"rcl_interfaces/srv/{type_name}")
        return client.call(request, args.timeout)

    try:
        match args.verb:
            case "list":
                for name in call("list_parameters", "ListParameters", {"prefixes": args.what})["result"]["names"]:
                    arguments.show(name=name)
            case "get":
                values = [value_of(value) for value in call("get_parameters", "GetParameters", {"names": args.what})["values"]]
                for name, value in zip(args.what, values):
                    arguments.show(name=name, value=value)
                if len(values) != len(args.what) or None in values:
                    return REFUSED
            case "describe":
                descriptors = call("describe_parameters", "DescribeParameters", {"names": args.what})["descriptors"]
                for descriptor in descriptors:
                    arguments.show(**descriptor)
                # A node describes a parameter it does not know with the type NOT_SET.
                known = [descriptor["type"] in fields_by_type() for descriptor in descriptors]
                if len(descriptors) != len(args.what) or not all(known):
                    return REFUSED
            case "set":
                pairs = [item.split("=", 1) for item in args.what]
                request = {"parameters": [{"name": n, "value": parameter_value(arguments.value(v))} for n, v in pairs]}
                if args.atomically:
                    results = [call("set_parameters_atomically", "SetParametersAtomically", request)["result"]]
                    arguments.show(names=[name for name, _ in pairs], **results[0])
                else:
                    results = call("set_parameters", "SetParameters", request)["results"]
                    for (name, _), result in zip(pairs, results):
                        arguments.show(name=name, **result)
                if not all(result["successful"] for result in results):
                    return REFUSED
    except NoAnswer as failure:
        print(failure, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
