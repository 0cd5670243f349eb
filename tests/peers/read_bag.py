#!/usr/bin/env python3
"""Reads a rosbag2 bag with two foreign readers, `rosbags` and `mcap`, and tells what they found as JSON.

    read_bag.py BAG                    both read the bag's folder and must agree
    read_bag.py --mcap-only FILE       one .mcap file by mcap's stream reader, closed or cut off

The two must agree on every topic's type, type hash, count, times and payload bytes, and on the values of its
first messages, which each decodes by itself from the definitions in the bag. `rosbags` also computes the type
hashes from those definitions.

Exit status 1 when they disagree, 2 when the bag cannot be read.
"""

import argparse
import dataclasses
import hashlib
import itertools
import json
import struct
import sys
from array import array
from pathlib import Path
from typing import Any, Iterator

import numpy
import zstandard
from mcap.exceptions import McapError
from mcap.records import Channel, Footer, Header, Message, Schema
from mcap.stream_reader import StreamReader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader, AnyReaderError


@dataclasses.dataclass
class Topic:
    """What a reader found on one topic."""

    type: str
    type_hash: str
    offered_qos: list[dict[str, Any]]
    count: int = 0
    first: int | None = None
    """The least log time, ns."""
    last: int | None = None
    """The greatest log time, ns."""
    digest: Any = dataclasses.field(default_factory=hashlib.sha256)
    """Of all payloads, in order of log time."""
    values: list[Any] = dataclasses.field(default_factory=list)
    """The first messages, decoded."""

    def take(self, time: int, payload: bytes) -> None:
        self.count += 1
        self.first = time if self.first is None else min(self.first, time)
        self.last = time if self.last is None else max(self.last, time)
        self.digest.update(payload)

    def report(self) -> dict[str, Any]:
        return {
            "type": self.type,
            "type_hash": self.type_hash,
            "offered_qos": self.offered_qos,
            "count": self.count,
            "first": self.first,
            "last": self.last,
            "payloads_sha256": self.digest.hexdigest(),
            "values": self.values,
        }


def plain(value: Any) -> Any:
    """A decoded message as JSON knows it, whichever reader made it."""
    if isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, numpy.generic):
        return value.item()
    if isinstance(value, numpy.ndarray):
        return value.tolist()
    if isinstance(value, (list, tuple, array)):
        return [plain(item) for item in value]
    if isinstance(value, (bytes, bytearray)):
        return list(value)
    if dataclasses.is_dataclass(value):
        # rosbags makes fields of a type's constants; ROS tells them apart by upper case.
        names = [field.name for field in dataclasses.fields(value) if not field.name.isupper()]
    else:
        names = getattr(value, "__slots__", None) or vars(value)
    return {name: plain(getattr(value, name)) for name in names if not name.startswith("_")}


def qos_words(qos: Any) -> dict[str, Any]:
    """The policies that decide whether endpoints match."""
    words = {name: getattr(qos, name).name.lower() for name in ("history", "reliability", "durability")}
    return {"depth": qos.depth, **words}


def by_rosbags(bag: Path, decode: int) -> dict[str, Topic]:
    """What `rosbags` finds in a bag's folder."""
    with AnyReader([bag]) as reader:
        topics = {
            connection.topic: Topic(
                connection.msgtype,
                reader.typestore.hash_rihs01(connection.msgtype),
                [qos_words(qos) for qos in connection.ext.offered_qos_profiles],
            )
            for connection in reader.connections
        }
        told = {connection.topic: connection.msgcount for connection in reader.connections}
        for connection, time, payload in reader.messages():
            topic = topics[connection.topic]
            topic.take(time, payload)
            if len(topic.values) < decode:
                topic.values.append(plain(reader.deserialize(payload, connection.msgtype)))
    for name, topic in topics.items():
        if topic.count != told[name]:
            raise AnyReaderError(f"{name}: metadata.yaml tells of {told[name]} messages, {topic.count} are there")
    return topics


def records(file: Path) -> Iterator[Any]:
    """The records of an .mcap file, those inside chunks included, up to its end or to where it is cut off."""
    with file.open("rb") as stream:
        try:
            yield from StreamReader(stream, validate_crcs=True).records
        except (McapError, struct.error, ValueError, EOFError, zstandard.ZstdError) as error:
            print(f"{file}: {type(error).__name__}: {error}", file=sys.stderr)


def by_mcap(files: list[Path], decode: int) -> tuple[dict[str, Topic], bool]:
    """What `mcap` finds in the files one after the other, and whether each was closed."""
    topics: dict[str, Topic] = {}
    messages: list[tuple[int, str, bytes]] = []
    closed = True
    for file in files:
        schemas: dict[int, Schema] = {}
        channels: dict[int, Channel] = {}
        decoders: dict[int, Any] = {}
        factory = DecoderFactory()
        header = footer = False
        for record in records(file):
            if isinstance(record, Header):
                header = True
            elif isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                channels[record.id] = record
                schema = schemas[record.schema_id]
                if record.topic not in topics:
                    topics[record.topic] = Topic(schema.name, record.metadata.get("topic_type_hash", ""), [])
                decoders[record.id] = factory.decoder_for(record.message_encoding, schema)
            elif isinstance(record, Message):
                name = channels[record.channel_id].topic
                messages.append((record.log_time, name, record.data))
                if len(topics[name].values) < decode:
                    topics[name].values.append(plain(decoders[record.channel_id](record.data)))
            elif isinstance(record, Footer):
                footer = True
        if not header:
            raise McapError(f"{file.name} does not begin as an MCAP file")
        closed &= footer
    for time, name, payload in sorted(messages, key=lambda message: message[0]):
        topics[name].take(time, payload)
    return topics, closed


def disagreements(rosbags: dict[str, Topic], mcap: dict[str, Topic]) -> Iterator[str]:
    """Every topic and item in which the two reports differ."""
    for name in sorted(rosbags.keys() | mcap.keys()):
        if name not in rosbags or name not in mcap:
            yield f"{name}: only {'mcap' if name in mcap else 'rosbags'} finds it"
            continue
        found = [topics[name].report() for topics in (rosbags, mcap)]
        for item in found[0]:
            one, other = (json.dumps(report[item]) for report in found)
            # Only the one reader understands the QoS, and computes a hash where the file has none.
            is_told = item != "offered_qos" and not (item == "type_hash" and other == '""')
            if is_told and one != other:
                yield f"{name}: {item}: rosbags finds {one:.300}, mcap {other:.300}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bag", type=Path, help="a bag's folder, or with --mcap-only a file")
    parser.add_argument("--mcap-only", action="store_true", help="read one .mcap file, perhaps cut off, with mcap only")
    parser.add_argument("--decode", type=int, default=20, help="messages decoded per topic (default %(default)s)")
    args = parser.parse_args()

    try:
        if args.mcap_only:
            topics, closed = by_mcap([args.bag], args.decode)
            differences = []
        else:
            topics = by_rosbags(args.bag, args.decode)
            files = sorted(args.bag.glob("*.mcap"), key=lambda file: (len(file.name), file.name))
            others, closed = by_mcap(files, args.decode)
            differences = list(disagreements(topics, others))
    except (AnyReaderError, McapError, OSError) as error:
        print(f"{args.bag}: {error}", file=sys.stderr)
        return 2

    report = {name: topic.report() for name, topic in sorted(topics.items())}
    json.dump({"closed": closed, "topics": report}, sys.stdout, indent=1)
    print()
    for difference in itertools.islice(differences, 20):
        print(difference, file=sys.stderr)
    return 1 if differences else 0


if __name__ == "__main__":
    sys.exit(main())
