"""A node of ROS 2 Jazzy's own rclpy, for the programs beside this: types by name, messages as JSON, waiting with a
deadline. With it they find `arguments`, which they share with the programs of ../peers."""

import importlib
import math
import sys
import time
from array import array
from contextlib import contextmanager
from pathlib import Path

import numpy
import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy


sys.path.append(str(Path(__file__).resolve().parent.parent / "peers"))


def interface(name: str) -> type:
    """The Python class of `package/msg/Type`, or of a service or an action."""
    package, kind, type_name = name.split("/")
    return getattr(importlib.import_module(f"{package}.{kind}"), type_name)


def to_json(value):
    """A message as what JSON can hold."""
    if hasattr(value, "get_fields_and_field_types"):
        return {name: to_json(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, (list, tuple, array, numpy.ndarray)):
        return [to_json(element) for element in value]
    if isinstance(value, bytes):
        return value[0]  # ROS's byte
    if isinstance(value, numpy.generic):
        return value.item()
    return value


def fill(message, fields: dict):
    """The message with the fields that JSON gives, the others as they are."""
    for name, given in fields.items():
        present = getattr(message, name)
        if isinstance(given, dict):
            fill(present, given)
        elif isinstance(present, float):
            setattr(message, name, float(given))
        else:
            setattr(message, name, given)
    return message


def topic_qos(reliability: str = "reliable", durability: str = "volatile", depth: int = 1000) -> QoSProfile:
    """`reliable` or `best_effort`, `volatile` or `transient_local`, KEEP_LAST."""
    return QoSProfile(
        depth=depth,
        reliability=ReliabilityPolicy[reliability.upper()],
        durability=DurabilityPolicy[durability.upper()],
    )


@contextmanager
def node(domain: int):
    """A node of its own in the domain, that ends with the block."""
    rclpy.init(domain_id=domain)
    made = rclpy.create_node("peer", enable_rosout=False, start_parameter_services=False)
    try:
        yield made
    finally:
        made.destroy_node()
        rclpy.try_shutdown()


def spin_until(of, condition, timeout: float) -> bool:
    """Whether `condition()` came true within `timeout` seconds, the node's callbacks being served meanwhile."""
    deadline = time.monotonic() + (timeout if math.isfinite(timeout) else 1e9)
    while not condition():
        if time.monotonic() >= deadline:
            return False
        rclpy.spin_once(of, timeout_sec=0.02)
    return True


class NoAnswer(Exception):
    """Nobody answered in time."""


def call(of, service: str, type_name: str, request: dict, timeout: float) -> dict:
    """A service's response as JSON.

    Raises NoAnswer when there is none within `timeout` seconds.
    """
    kind = interface(type_name)
    client = of.create_client(kind, service)
    try:
        if not client.wait_for_service(timeout):
            raise NoAnswer(f"{service}: not served within {timeout:g} s")
        future = client.call_async(fill(kind.Request(), request))
        if not spin_until(of, future.done, timeout):
            raise NoAnswer(f"{service}: no answer within {timeout:g} s")
        return to_json(future.result())
    finally:
        of.destroy_client(client)
