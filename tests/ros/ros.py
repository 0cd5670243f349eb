"""A node of ROS 2 Jazzy's own rclpy, for the programs beside this: types by name, messages as JSON, waiting with a
deadline. With it they find `arguments`, which they share with the programs of ../peers."""

import importlib
import math
import os
import sys
import time
from array import array
from collections import deque
from contextlib import contextmanager
from pathlib import Path

import numpy
import rclpy
from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy


sys.path.append(str(Path(__file__).resolve().parent.parent / "peers"))

# The standard output is for what the program prints. What the middleware writes there goes to the standard error.
sys.stdout = os.fdopen(os.dup(1), "w", encoding="utf-8")
os.dup2(2, 1)


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
        elif isinstance(given, list) and given and isinstance(given[0], dict):
            # `sequence<package/Type>`
            package, _, kind = message.get_fields_and_field_types()[name].split("<")[-1].rstrip(">").partition("/")
            element = interface(f"{package}/msg/{kind}")
            setattr(message, name, [fill(element(), fields) for fields in given])
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


SETTLE_SECONDS = 0.5
"""How long a publisher's subscribers have to be the same."""


class Subscription:
    def __init__(self):
        self._messages: deque = deque()

    def receive(self, message) -> None:
        self._messages.append(message)

    def take(self, count: int) -> list[dict]:
        return [to_json(self._messages.popleft()) for _ in range(min(count, len(self._messages)))]


class Publisher:
    def __init__(self, of, kind: type, publisher):
        self._node, self._kind, self._publisher = of, kind, publisher

    def wait_matched(self, timeout: float) -> bool:
        """Whether there is a subscriber, and no more came for a while."""
        count, since = 0, time.monotonic()

        def all_match() -> bool:
            nonlocal count, since
            if self._publisher.get_subscription_count() != count:
                count, since = self._publisher.get_subscription_count(), time.monotonic()
            return count > 0 and time.monotonic() - since >= SETTLE_SECONDS

        return spin_until(self._node, all_match, timeout)

    def publish(self, message: dict) -> None:
        self._publisher.publish(fill(self._kind(), message))

    def wait_acked(self, timeout: float) -> bool:
        return self._publisher.wait_for_all_acked(Duration(seconds=timeout))


class Peer:
    """The interface of ../peers/peer.py on rclpy."""

    def __init__(self, domain: int):
        self._made = node(domain)

    def __enter__(self) -> "Peer":
        self._node = self._made.__enter__()
        return self

    def __exit__(self, *error) -> None:
        self._made.__exit__(*error)

    def subscribe(
        self, topic: str, type_name: str, reliability: str = "reliable", durability: str = "volatile"
    ) -> Subscription:
        made = Subscription()
        self._node.create_subscription(interface(type_name), topic, made.receive, topic_qos(reliability, durability))
        return made

    def publisher(self, topic: str, type_name: str, reliability: str = "reliable") -> Publisher:
        kind = interface(type_name)
        return Publisher(self._node, kind, self._node.create_publisher(kind, topic, topic_qos(reliability)))

    def call(self, service: str, type_name: str, request: dict, timeout: float) -> dict:
        return call(self._node, service, type_name, request, timeout)

    def wait_until(self, condition, timeout: float) -> bool:
        return spin_until(self._node, condition, timeout)
