"""The interface of `peer.py` on Cyclone DDS."""

import time

import cyclone
import ros_types
from cyclone import SETTLE_SECONDS, dds_topic_name, topic_qos, wait_matched, wait_until
from cyclonedds.util import duration
from ros_service import Client, NoAnswer

__all__ = ["NoAnswer", "Peer"]


class Subscription:
    def __init__(self, reader, type_name: str):
        self._reader, self._type = reader, type_name

    def take(self, count: int) -> list[dict]:
        samples = self._reader.take(N=count) if count > 0 else []
        return [ros_types.to_json(self._type, sample) for sample in samples if sample.sample_info.valid_data]


class Publisher:
    def __init__(self, writer, type_name: str, reliability: str):
        self._writer, self._type, self._reliability = writer, type_name, reliability

    def wait_matched(self, timeout: float) -> bool:
        return wait_matched([self._writer], timeout)

    def publish(self, message: dict) -> None:
        self._writer.write(ros_types.from_json(self._type, message))

    def wait_acked(self, timeout: float) -> bool:
        if self._reliability == "reliable":
            return self._writer.wait_for_acks(duration(seconds=timeout))
        time.sleep(SETTLE_SECONDS)
        return True


class Peer:
    def __init__(self, domain: int):
        self._peer = cyclone.Peer(domain)

    def __enter__(self) -> "Peer":
        return self

    def __exit__(self, *_) -> None:
        pass

    def subscribe(
        self, topic: str, type_name: str, reliability: str = "reliable", durability: str = "volatile"
    ) -> Subscription:
        qos = topic_qos(reliability, durability)
        return Subscription(self._peer.reader(dds_topic_name(topic), ros_types.message(type_name), qos), type_name)

    def publisher(self, topic: str, type_name: str, reliability: str = "reliable") -> Publisher:
        writer = self._peer.writer(dds_topic_name(topic), ros_types.message(type_name), topic_qos(reliability))
        return Publisher(writer, type_name, reliability)

    def call(self, service: str, type_name: str, request: dict, timeout: float) -> dict:
        return Client(self._peer, service, type_name).call(request, timeout)

    def wait_until(self, condition, timeout: float) -> bool:
        return wait_until(condition, timeout, interval=0.002)
