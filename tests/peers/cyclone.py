"""A Cyclone DDS participant that speaks ROS 2 names and QoS on the loopback interface.

Everything that concerns DDS itself is here: the configuration that keeps all traffic on `lo`, DDS Security, how
ROS names and types are written in DDS, the QoS of ROS topics, and waiting with a deadline. What a
message consists of is in `ros_types.py`.
"""

import fcntl
import os
import socket
import struct
import sysconfig
import time
from pathlib import Path

from cyclonedds.core import DDSStatus, Policy, Qos
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

SIOCGIFFLAGS = 0x8913
"""The ioctl of netdevice(7) that reads an interface's flags."""

IFF_MULTICAST = 0x1000
"""The flag of an interface with multicast; most machines' `lo` does not have it."""

PLUGINS = Path("/usr/lib") / str(sysconfig.get_config_var("MULTIARCH")) / "libddsc0debian"
"""Where Debian's libddsc0debian has the plugins of DDS Security."""

SETTLE_SECONDS = 0.2
"""How long a matched writer waits before its first sample: the other side learns of it a little later."""


def has_multicast(interface: str) -> bool:
    """Whether an interface of this network namespace has the MULTICAST flag."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        name_and_flags = fcntl.ioctl(any_socket, SIOCGIFFLAGS, struct.pack("16sH14x", interface.encode(), 0))
    (flags,) = struct.unpack_from("H", name_and_flags, 16)
    return bool(flags & IFF_MULTICAST)


def security() -> str:
    """Cyclone's configuration of the enclave that ROS's variables name, as `rmw_cyclonedds_cpp` makes it."""
    if os.environ.get("ROS_SECURITY_ENABLE") != "true":
        return ""
    name = os.environ.get("ROS_SECURITY_ENCLAVE_OVERRIDE", "/").lstrip("/")
    enclave = Path(os.environ["ROS_SECURITY_KEYSTORE"]).absolute() / "enclaves" / name

    def library(name: str, functions: str) -> str:
        path = PLUGINS / f"libdds_security_{name}.so"
        return f'<Library path="{path}" initFunction="init_{functions}" finalizeFunction="finalize_{functions}"/>'

    return f"""
      <Security>
        <Authentication>
          {library("auth", "authentication")}
          <IdentityCA>file:{enclave}/identity_ca.cert.pem</IdentityCA>
          <IdentityCertificate>file:{enclave}/cert.pem</IdentityCertificate>
          <PrivateKey>file:{enclave}/key.pem</PrivateKey>
        </Authentication>
        <Cryptographic>{library("crypto", "crypto")}</Cryptographic>
        <AccessControl>
          {library("ac", "access_control")}
          <PermissionsCA>file:{enclave}/permissions_ca.cert.pem</PermissionsCA>
          <Governance>file:{enclave}/governance.p7s</Governance>
          <Permissions>file:{enclave}/permissions.p7s</Permissions>
        </AccessControl>
      </Security>"""


def configuration() -> str:
    """Cyclone's configuration: only `lo`, or the interface that PEER_INTERFACE names; peers found by unicast, at the
    addresses of ROS_STATIC_PEERS too, and by multicast where the interface has it. A test may freeze it for half a minute, or for
    as long as PEER_LEASE says."""
    interface = os.environ.get("PEER_INTERFACE", "lo")
    multicast = has_multicast(interface)
    addresses = ["127.0.0.1"] if interface == "lo" else []
    addresses += [address for address in os.environ.get("ROS_STATIC_PEERS", "").split(";") if address]
    peers = "".join(f'<Peer address="{address}"/>' for address in addresses)
    return f"""
    <CycloneDDS><Domain Id="any">
      <General>
        <Interfaces><NetworkInterface name="{interface}" multicast="{str(multicast).lower()}"/></Interfaces>
        <AllowMulticast>{"spdp" if multicast else "false"}</AllowMulticast>
      </General>
      <Discovery>
        <ParticipantIndex>auto</ParticipantIndex>
        <MaxAutoParticipantIndex>40</MaxAutoParticipantIndex>
        <Peers>{peers}</Peers>
        <SPDPInterval>1s</SPDPInterval>
        <LeaseDuration>{os.environ.get("PEER_LEASE", "30s")}</LeaseDuration>
      </Discovery>{security()}
    </Domain></CycloneDDS>"""


class Peer:
    """One DDS participant in a domain, with what it needs kept alive beside it."""

    def __init__(self, domain_id: int):
        self._domain = Domain(domain_id, configuration())
        self.participant = DomainParticipant(domain_id)

    def reader(self, dds_topic: str, data_type: type, qos: Qos) -> DataReader:
        """A reader of samples of `data_type` on a topic as DDS names it."""
        return DataReader(self.participant, Topic(self.participant, dds_topic, data_type, qos=qos), qos=qos)

    def writer(self, dds_topic: str, data_type: type, qos: Qos) -> DataWriter:
        """A writer of samples of `data_type` on a topic as DDS names it."""
        return DataWriter(self.participant, Topic(self.participant, dds_topic, data_type, qos=qos), qos=qos)


def topic_qos(reliability: str = "reliable", durability: str = "volatile", depth: int = 1000) -> Qos:
    """The QoS of a ROS topic: `reliable` or `best_effort`, `volatile` or `transient_local`, KEEP_LAST."""
    return Qos(
        Policy.Reliability.Reliable(duration(seconds=1))
        if reliability == "reliable"
        else Policy.Reliability.BestEffort,
        Policy.Durability.TransientLocal if durability == "transient_local" else Policy.Durability.Volatile,
        Policy.History.KeepLast(depth),
        # ROS 2 Jazzy speaks plain CDR (XCDR version 1).
        Policy.DataRepresentation(use_cdrv0_representation=True, use_xcdrv2_representation=False),
    )


def dds_topic_name(ros_topic: str) -> str:
    """`/auv/state` is `rt/auv/state` in DDS."""
    return "rt/" + ros_topic.lstrip("/")


def ros_topic_name(dds_topic: str) -> str | None:
    """The ROS name of a DDS topic, None for one that is no ROS topic (services, actions' parts)."""
    return dds_topic[2:] if dds_topic.startswith("rt/") else None


def wait_until(condition, timeout: float, interval: float = 0.02) -> bool:
    """Whether `condition()` came true within `timeout` seconds."""
    deadline = time.monotonic() + timeout
    while not condition():
        if time.monotonic() >= deadline:
            return False
        time.sleep(interval)
    return True


def wait_matched(endpoints: list[DataReader | DataWriter], timeout: float) -> bool:
    """Whether each reader and writer met a counterpart within `timeout` seconds, and it had time to know it."""
    matched = DDSStatus.PublicationMatched | DDSStatus.SubscriptionMatched
    met = wait_until(lambda: all(endpoint.get_status_changes() & matched for endpoint in endpoints), timeout)
    if met:
        time.sleep(SETTLE_SECONDS)
    return met
