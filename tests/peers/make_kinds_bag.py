#!/usr/bin/env python3
"""Writes the same messages, of a type with a field of every kind, into bags of every form.

    make_kinds_bag.py FOLDER

FOLDER then holds, by `rosbags`:

    little/     a bag as rosbag2 leaves it
    big/        payloads in big endian, chunks packed with zstd
    packed/     each message packed with zstd (rosbag2's compression_mode MESSAGE)
    file/       the whole file packed with zstd (compression_mode FILE)
    sqlite/     in the sqlite3 storage, with its definitions
    sqlite_packed/  the same, each message packed with zstd

and by `mcap`, with neither folder nor metadata.yaml:

    bare.mcap   no chunks, no index, no statistics, schemas and channels only where they are met; attachments and metadata between
    idl.mcap    the schema in ros2idl
"""

import argparse
from pathlib import Path
from typing import Any

import numpy
from mcap.writer import CompressionType, IndexType, Writer as McapWriter
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

PART = "bool flag\nfloat64 value\nint16[3] three\n"
NUMBERS = ["int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float32", "float64"]
KINDS = f"""bool truth
byte octet
char letter
{"".join(f"{kind} a_{kind}" + chr(10) for kind in NUMBERS)}string text
float64[3] array
int16[] sequence
uint32[<=5] bounded
string<=10 short_text
string[] texts
bool[] truths
byte[4] octets
char[] letters
odd_msgs/Part part
odd_msgs/Part[2] parts
odd_msgs/Part[] more
odd_msgs/Part[<=3] few
geometry_msgs/Quaternion turn
int8 last
"""
IDL_NAMES = {"bool": "boolean", "byte": "octet", "char": "uint8", "float32": "float", "float64": "double"}

STORE = get_typestore(Stores.ROS2_JAZZY)
STORE.register(get_types_from_msg(PART, "odd_msgs/msg/Part"))
STORE.register(get_types_from_msg(KINDS, "odd_msgs/msg/Kinds"))
TYPE = "odd_msgs/msg/Kinds"
Part, Kinds = STORE.types["odd_msgs/msg/Part"], STORE.types[TYPE]
Quaternion = STORE.types["geometry_msgs/msg/Quaternion"]


def part(random: numpy.random.Generator) -> Any:
    three = random.integers(-(2**15), 2**15, 3).astype(numpy.int16)
    return Part(flag=bool(random.integers(2)), value=float(random.normal()), three=three)


def message(random: numpy.random.Generator) -> Any:
    """A message whose lists and texts are of any length.

    Bytes and characters stay below 128: above, rosbags takes bytes for signed and mcap-ros2-support characters.
    """

    def integers(kind: str, count: int) -> Any:
        about = numpy.iinfo(kind)
        return random.integers(about.min, about.max, count, dtype=kind, endpoint=True)

    def text(longest: int) -> str:
        return "xyz€" * int(random.integers(longest))

    some = int(random.integers(9))
    whole = {f"a_{kind}": int(integers(kind, 1)[0]) for kind in NUMBERS if "int" in kind}
    return Kinds(
        truth=bool(random.integers(2)),
        octet=int(random.integers(128)),
        letter=int(random.integers(128)),
        **whole,
        a_float32=float(numpy.float32(random.normal())),
        a_float64=float(random.normal()),
        text=text(5),
        array=random.normal(size=3),
        sequence=integers("int16", some),
        bounded=integers("uint32", int(random.integers(6))),
        short_text=text(2),
        texts=[text(4) for _ in range(int(random.integers(4)))],
        truths=random.integers(2, size=some).astype(bool),
        octets=random.integers(128, size=4, dtype="uint8"),
        letters=random.integers(128, size=int(random.integers(4)), dtype="uint8"),
        part=part(random),
        parts=[part(random), part(random)],
        more=[part(random) for _ in range(int(random.integers(5)))],
        few=[part(random) for _ in range(int(random.integers(4)))],
        turn=Quaternion(*random.normal(size=4)),
        last=int(integers("int8", 1)[0]),
    )


def write(
    folder: Path,
    mode: CompressionMode,
    messages: list[Any],
    *,
    little_endian: bool,
    storage: StoragePlugin = StoragePlugin.MCAP,
) -> None:
    writer = Writer(folder, version=9, storage_plugin=storage)
    if mode != CompressionMode.NONE:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        kinds = writer.add_connection("/kinds", TYPE, typestore=STORE)
        for k, one in enumerate(messages):
            payload = STORE.serialize_cdr(one, TYPE, little_endian=little_endian)
            writer.write(kinds, k * 50_000_000, payload)


def idl() -> str:
    """The definitions in IDL, as `rosidl_adapter` would write them."""

    def declared(line: str) -> str:
        kind, name = line.split(" ")
        kind, _, count = kind.removesuffix("]").partition("[")
        kind, _, longest = kind.partition("<=")
        kind = kind.replace("/", "::msg::")
        kind = IDL_NAMES.get(kind, kind) + (f"<{longest}>" if longest else "")
        if "[" not in line:
            return f"{kind} {name};"
        if count.isdigit():
            return f"{kind} {name}[{count}];"
        bound = f", {count.removeprefix('<=')}" if count else ""
        return f"sequence<{kind}{bound}> {name};"

    def file(package: str, name: str, text: str) -> str:
        members = "\n".join(declared(line) for line in text.splitlines())
        return (
            f"{'=' * 80}\nIDL: {package}/msg/{name}\n"
            f"module {package} {{ module msg {{ struct {name} {{\n{members}\n}}; }}; }};\n"
        )

    quaternion = "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"
    return (
        file("odd_msgs", "Kinds", KINDS)
        + file("odd_msgs", "Part", PART)
        + file("geometry_msgs", "Quaternion", quaternion)
    )


def write_file(path: Path, encoding: str, text: str, messages: list[Any], *, bare: bool) -> None:
    form: dict[str, Any] = {"compression": CompressionType.LZ4}
    if bare:
        form = {"use_chunking": False, "index_types": IndexType.NONE, "use_statistics": False}
        form |= {"repeat_channels": False, "repeat_schemas": False, "use_summary_offsets": False}
    with path.open("wb") as file:
        writer = McapWriter(file, **form)
        writer.start(profile="ros2", library="odd")
        schema = writer.register_schema(TYPE, encoding, text.encode())
        channel = writer.register_channel("/kinds", "cdr", schema)
        for k, one in enumerate(messages):
            payload = bytes(STORE.serialize_cdr(one, TYPE))
            writer.add_message(channel, k * 50_000_000, payload, k * 50_000_000)
            if bare:
                writer.add_attachment(0, 0, "a picture", "image/png", b"\x05" * 1000)
                writer.add_metadata("a word", {"about": "nothing"})
        writer.finish()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    random = numpy.random.default_rng(1988)
    messages = [message(random) for _ in range(40)]
    write(folder / "little", CompressionMode.NONE, messages, little_endian=True)
    write(folder / "big", CompressionMode.STORAGE, messages, little_endian=False)
    write(folder / "packed", CompressionMode.MESSAGE, messages, little_endian=True)
    write(folder / "file", CompressionMode.FILE, messages, little_endian=True)
    sqlite = StoragePlugin.SQLITE3
    write(folder / "sqlite", CompressionMode.NONE, messages, little_endian=True, storage=sqlite)
    write(folder / "sqlite_packed", CompressionMode.MESSAGE, messages, little_endian=True, storage=sqlite)
    text, _ = STORE.generate_msgdef(TYPE, ros_version=2)
    write_file(folder / "bare.mcap", "ros2msg", text, messages, bare=True)
    write_file(folder / "idl.mcap", "ros2idl", idl(), messages, bare=False)


if __name__ == "__main__":
    main()
