"""A client of ROS services with rmw_cyclonedds' mapping of requests and responses onto topics.

Requests go to `rq/<service>Request`, responses come from `rr/<service>Reply`; each carries in its
data the client's identity and the request's number. A node answers in this form when it runs with
`RMW_IMPLEMENTATION=rmw_cyclonedds_cpp`. (The other form, Fast DDS', puts the number in RTPS inline
QoS, which Cyclone's Python interface does not reach.)
"""

import random
import time

import ros_types
from cyclone import Peer, topic_qos, wait_matched


class NoAnswer(Exception):
    """The service was not there, or did not answer, within the time given."""


class Client:
    """A client of one service."""

    def __init__(self, peer: Peer, service: str, type_name: str):
        self.service = service
        self.type_name = type_name
        self._peer = peer  # its participant lives as long as this does
        self._identity = random.getrandbits(64)
        self._sequence = 0
        self._request_type = ros_types.service_part(type_name, "Request")
        name = service.lstrip("/")
        # Responses first: a server may answer before a later reader is matched.
        self._responses = peer.reader(
            f"rr/{name}Reply", ros_types.service_part(type_name, "Response"), topic_qos()
        )
        self._requests = peer.writer(f"rq/{name}Request", self._request_type, topic_qos())

    def call(self, request: dict, timeout: float = 5.0) -> dict:
        """The response to `request`, both as JSON objects."""
        deadline = time.monotonic() + timeout
        if not wait_matched([self._requests, self._responses], timeout):
            raise NoAnswer(f"no server of {self.service} within {timeout:g} s")
        self._sequence += 1
        members = ros_types.members(f"{self.type_name}_Request", request)
        self._requests.write(self._request_type(rmw_client=self._identity, rmw_sequence=self._sequence, **members))
        while time.monotonic() < deadline:
            for response in self._responses.take(N=100):
                if (response.rmw_client, response.rmw_sequence) == (self._identity, self._sequence):
                    return ros_types.to_json(f"{self.type_name}_Response", response)
            time.sleep(0.005)
        raise NoAnswer(f"{self.service} did not answer within {timeout:g} s")
