"""The commands of crates/ros/node/benches/hop.rs with rclpy: ping SECONDS, pong, pub RATE, sub. By the Python of tests/ros/install.sh."""

import json
import sys
import time

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.qos import QoSProfile
from std_msgs.msg import String

QOS = QoSProfile(depth=100)
MESSAGE = String(data="x" * 91)
WARM_UP = 500
LOST = 0.5


def ping(node, seconds: float) -> None:
    hops, state = [], {"sent": 0.0, "answers": 0, "end": None}
    pings = node.create_publisher(String, "ping", QOS)

    def send() -> None:
        state["sent"] = time.perf_counter()
        pings.publish(MESSAGE)

    def received(_) -> None:
        now = time.perf_counter()
        state["answers"] += 1
        if state["answers"] > WARM_UP:
            hops.append((now - state["sent"]) / 2)
        elif state["answers"] == WARM_UP:
            state["end"] = now + seconds
        send()

    node.create_subscription(String, "pong", received, QOS)
    node.create_timer(LOST, lambda: send() if time.perf_counter() - state["sent"] >= LOST else None)
    while state["end"] is None or time.perf_counter() < state["end"]:
        rclpy.spin_once(node, timeout_sec=0.1)
    hops.sort()
    found = {name: hops[int(share * (len(hops) - 1))] * 1e6 for name, share in [("median", 0.5), ("p99", 0.99)]}
    print(json.dumps({"count": len(hops), **found}))


def pong(node) -> None:
    pongs = node.create_publisher(String, "pong", QOS)
    node.create_subscription(String, "ping", pongs.publish, QOS)
    rclpy.spin(node)


def publish(node, rate: float) -> None:
    output = node.create_publisher(String, "data", QOS)
    node.create_timer(1 / rate, lambda: output.publish(MESSAGE))
    rclpy.spin(node)


def subscribe(node) -> None:
    total = 0

    def received(_) -> None:
        nonlocal total
        total += 1

    node.create_subscription(String, "data", received, QOS)
    node.create_timer(1.0, lambda: print(f"total {total}", flush=True))
    rclpy.spin(node)


def main() -> None:
    command, *arguments = sys.argv[1:]
    rclpy.init()
    node = rclpy.create_node(f"hop_{command}")
    try:
        {"ping": ping, "pong": pong, "pub": publish, "sub": subscribe}[command](node, *map(float, arguments))
    except (KeyboardInterrupt, ExternalShutdownException):
        pass


if __name__ == "__main__":
    main()
