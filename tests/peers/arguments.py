"""The command lines of the peers' programs, the same for those that speak Cyclone DDS and those, in ../ros, that speak rclpy."""

import argparse
import json


def parser(doc: str, timeout: float = 60.0) -> argparse.ArgumentParser:
    """What every program takes."""
    made = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("--domain", type=int, required=True)
    made.add_argument("--timeout", type=float, default=timeout, help="s (default %(default)s)")
    return made


def endpoint(text: str) -> tuple[str, str, str]:
    """Kind (publication or subscription), topic and type of KIND:TOPIC=TYPE."""
    kind, _, rest = text.partition(":")
    topic, _, type_name = rest.partition("=")
    return kind, topic, type_name


def topics(doc: str) -> argparse.Namespace:
    made = parser(doc, timeout=5.0)
    made.add_argument("--expect", nargs="*", type=endpoint, default=[], metavar="KIND:TOPIC=TYPE")
    made.add_argument("--quiet", type=float, default=0.0, help="s (default %(default)s)")
    return made.parse_args()


def echo(doc: str) -> argparse.Namespace:
    made = parser(doc)
    made.add_argument("topic")
    made.add_argument("type", help="package/msg/Type")
    made.add_argument("--count", type=int, default=1)
    made.add_argument("--reliability", choices=["reliable", "best_effort"], default="best_effort")
    made.add_argument("--durability", choices=["volatile", "transient_local"], default="volatile")
    return made.parse_args()


def pub(doc: str) -> argparse.Namespace:
    made = parser(doc)
    made.add_argument("topic")
    made.add_argument("type", help="package/msg/Type")
    made.add_argument("--json", type=json.loads, default={}, help="the message; fields left out are zero")
    made.add_argument("--rate", type=float, default=10.0, help="Hz (default %(default)s)")
    made.add_argument("--duration", type=float, default=0.0, help="s; 0 (the default) sends one message")
    made.add_argument("--reliability", choices=["reliable", "best_effort"], default="reliable")
    return made.parse_args()


def call(doc: str) -> argparse.Namespace:
    made = parser(doc)
    made.add_argument("service")
    made.add_argument("type", help="package/srv/Type")
    made.add_argument("--json", type=json.loads, default={}, help="the request; fields left out are zero")
    return made.parse_args()


def action(doc: str) -> argparse.Namespace:
    made = parser(doc)
    made.add_argument("action")
    made.add_argument("type", help="package/action/Name")
    made.add_argument("--json", type=json.loads, default={}, help="the goal; fields left out are zero")
    made.add_argument("--cancel-after", type=float, help="s")
    return made.parse_args()


def params(doc: str, *more_verbs: str) -> argparse.Namespace:
    made = parser(doc)
    made.add_argument("node", help="the node's full name, such as /auv/depth_controller")
    made.add_argument("verb", choices=["list", "get", "set", "describe", *more_verbs])
    made.add_argument("what", nargs="*", metavar="NAME[=VALUE]")
    made.add_argument("--atomically", action="store_true", help="set all or none")
    return made.parse_args()


def actuator(doc: str) -> argparse.Namespace:
    made = parser(doc)
    made.add_argument("--namespace", default="/auv")
    made.add_argument("--rate", type=float, default=0.2, help="rad/s (default %(default)s)")
    return made.parse_args()


def value(text: str):
    """JSON where it is JSON, else the text itself."""
    try:
        return json.loads(text)
    except json.JSONDecodeError:
        return text


def show(**line) -> None:
    """One line of JSON."""
    print(json.dumps(line), flush=True)
