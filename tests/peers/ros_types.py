"""Cyclone DDS types of ROS messages, services and actions, made at run time from their definitions.

The files under `msgs/` are the only definition of a message; nothing here repeats one. A class made
here has the ROS field names, the DDS type name (`std_msgs::msg::dds_::Float64_`) and plain CDR, so
it matches what a ROS 2 node publishes.
"""

import dataclasses
import functools
import re
from pathlib import Path

from cyclonedds.idl import IdlStruct, make_idl_struct
from cyclonedds.idl import types

MSGS = Path(__file__).resolve().parents[2] / "msgs"

PRIMITIVES = {
    "bool": bool,
    "byte": types.uint8,
    "char": types.uint8,
    "int8": types.int8,
    "uint8": types.uint8,
    "int16": types.int16,
    "uint16": types.uint16,
    "int32": types.int32,
    "uint32": types.uint32,
    "int64": types.int64,
    "uint64": types.uint64,
    "float32": types.float32,
    "float64": types.float64,
    "string": str,
}

FIELD = re.compile(
    r"(?P<base>[A-Za-z][\w/]*)(?:<=(?P<string_bound>\d+))?"
    r"(?P<array>\[(?P<bounded><=)?(?P<length>\d*)\])?"
    r"\s+(?P<name>[a-z]\w*)(?:\s+(?P<default>.+))?"
)
CONSTANT = re.compile(r"(?P<base>[a-z]\w*)\s+(?P<name>[A-Z]\w*)\s*=\s*(?P<value>.+)")


@dataclasses.dataclass(frozen=True)
class Field:
    """One field: its base type (`float64`, `std_msgs/msg/Header`), and how many of it."""

    name: str
    base: str
    shape: str  # "one", "array" or "sequence"
    length: int | None  # of an array; the bound of a sequence, or None
    default: str | None


def find(type_name: str) -> Path:
    """The file that defines `package/msg/Type` or `package/srv/Type`."""
    package, kind, name = type_name.split("/")
    candidates = [MSGS / kind / f"{name}.{kind}"] if package == "planesman_msgs" else []
    candidates += sorted((MSGS / "standard").glob(f"**/{package}/{kind}/{name}.{kind}"))
    for path in candidates:
        if path.is_file():
            return path
    raise FileNotFoundError(f"no definition of {type_name} under {MSGS}")


def parse(text: str, package: str) -> tuple[list[Field], dict[str, object]]:
    """The fields and constants of one message's text; names without a package mean `package`."""
    fields, constants = [], {}
    for line in text.splitlines():
        line = line.split("#", 1)[0].strip()
        if not line:
            continue
        if constant := CONSTANT.fullmatch(line):
            value = constant["value"].strip()
            kind = PRIMITIVES[constant["base"]]
            constants[constant["name"]] = value.strip("\"'") if kind is str else _number(value, constant["base"])
            continue
        match = FIELD.fullmatch(line)
        if match is None:
            raise ValueError(f"neither a field nor a constant: {line}")
        base = match["base"]
        if base not in PRIMITIVES:
            owner, name = (package, base) if "/" not in base else (base.split("/")[0], base.split("/")[-1])
            base = f"{owner}/msg/{name}"
        is_array = match["array"] is not None and match["length"] != "" and match["bounded"] is None
        shape = "one" if match["array"] is None else "array" if is_array else "sequence"
        length = int(match["length"]) if match["length"] else None
        fields.append(Field(match["name"], base, shape, length, match["default"]))
    return fields, constants


def _number(text: str, base: str) -> object:
    if base == "bool":
        return text.lower() in ("true", "1")
    return float(text) if base.startswith("float") else int(text, 0)


def action_part(package: str, name: str) -> tuple[list[Field], dict[str, object]]:
    """What ROS derives from an action's file: `Manoeuvre_Goal`, `Manoeuvre_SendGoal_Request`, ..."""
    name, part = name.split("_", 1)
    goal, result, feedback = re.split(
        r"^---\s*$", find(f"{package}/action/{name}").read_text(), flags=re.MULTILINE
    )
    written = {"Goal": goal, "Result": result, "Feedback": feedback}
    if part in written:
        return parse(written[part], package)
    one = functools.partial(Field, shape="one", length=None, default=None)
    goal_id = one("goal_id", "unique_identifier_msgs/msg/UUID")
    stem = f"{package}/action/{name}"
    derived = {
        "SendGoal_Request": [goal_id, one("goal", f"{stem}_Goal")],
        "SendGoal_Response": [one("accepted", "bool"), one("stamp", "builtin_interfaces/msg/Time")],
        "GetResult_Request": [goal_id],
        "GetResult_Response": [one("status", "int8"), one("result", f"{stem}_Result")],
        "FeedbackMessage": [goal_id, one("feedback", f"{stem}_Feedback")],
    }
    return derived[part], {}


@functools.cache
def definition(type_name: str) -> tuple[list[Field], dict[str, object]]:
    """The fields and constants of `package/msg/Type`, `package/srv/Type_Request` or an action's part."""
    package, kind, name = type_name.split("/")
    if kind == "action":
        return action_part(package, name)
    if kind == "msg":
        return parse(find(type_name).read_text(), package)
    name, part = name.rsplit("_", 1)
    request, response = re.split(r"^---\s*$", find(f"{package}/{kind}/{name}").read_text(), flags=re.MULTILINE)
    return parse(request if part == "Request" else response, package)


def constants(type_name: str) -> dict[str, object]:
    """The constants that a message's file declares."""
    return definition(type_name)[1]


def dds_type_name(type_name: str) -> str:
    """`std_msgs/msg/Float64` is `std_msgs::msg::dds_::Float64_` in DDS."""
    package, kind, name = type_name.split("/")
    return f"{package}::{kind}::dds_::{name}_"


def ros_type_name(dds_type: str) -> str:
    """The inverse of `dds_type_name`; a name of another form is given back as it is."""
    match = re.fullmatch(r"(\w+)::(msg|srv|action)::dds_::(\w+)_", dds_type)
    return "/".join(match.groups()) if match else dds_type


@functools.cache
def message(type_name: str) -> type[IdlStruct]:
    """The Cyclone class of a message."""
    return make_idl_struct(type_name.rsplit("/", 1)[1], dds_type_name(type_name), _annotations(type_name))


def _annotations(type_name: str) -> dict[str, object]:
    fields, _ = definition(type_name)
    annotations = {field.name: _annotation(field) for field in fields}
    # rosidl gives an empty structure one byte, as IDL 4.2 knows no empty ones.
    return annotations or {"structure_needs_at_least_one_member": types.uint8}


def _annotation(field: Field):
    element = PRIMITIVES.get(field.base) or message(field.base)
    if field.shape == "array":
        return types.array[element, field.length]
    if field.shape == "sequence":
        return types.sequence[element, field.length] if field.length else types.sequence[element]
    return element


@functools.cache
def service_part(type_name: str, part: str) -> type[IdlStruct]:
    """A service's `Request` or `Response` as rmw_cyclonedds sends it: a header, then the fields.

    The header is the client's 64-bit identity and the number of its request; a response repeats
    that of the request it answers.
    """
    name = f"{type_name}_{part}"
    header = {"rmw_client": types.uint64, "rmw_sequence": types.int64}
    return make_idl_struct(name.rsplit("/", 1)[1], dds_type_name(name), header | _annotations(name))


def from_json(type_name: str, value: dict) -> IdlStruct:
    """A message from a JSON object. A field left out is zero or empty; an unknown one is refused."""
    return message(type_name)(**members(type_name, value))


def members(type_name: str, value: dict) -> dict[str, object]:
    """The members of a message's or service part's class from a JSON object, as in `from_json`."""
    fields, _ = definition(type_name)
    unknown = set(value) - {field.name for field in fields}
    if unknown:
        raise ValueError(f"{type_name} has no field {', '.join(sorted(unknown))}")
    out = {field.name: _field_from_json(field, value.get(field.name)) for field in fields}
    return out or {"structure_needs_at_least_one_member": 0}


def _field_from_json(field: Field, value):
    def one(item):
        if field.base not in PRIMITIVES:
            return from_json(field.base, item or {})
        if item is None:
            return "" if field.base == "string" else False if field.base == "bool" else _zero(field.base)
        return float(item) if field.base.startswith("float") else item

    if field.shape == "one":
        if value is None and field.default is not None and field.base in PRIMITIVES:
            quoted = field.default.strip("\"'")
            value = quoted if field.base == "string" else _number(quoted, field.base)
        return one(value)
    if field.shape == "array":
        items = value if value is not None else [None] * field.length
        if len(items) != field.length:
            raise ValueError(f"{field.name} takes {field.length} values, not {len(items)}")
        return [one(item) for item in items]
    return [one(item) for item in value or []]


def _zero(base: str):
    return 0.0 if base.startswith("float") else 0


def to_json(type_name: str, sample: IdlStruct) -> dict:
    """A JSON object of a message."""
    fields, _ = definition(type_name)
    out = {}
    for field in fields:
        value = getattr(sample, field.name)
        if field.base not in PRIMITIVES:
            convert = functools.partial(to_json, field.base)
        else:
            convert = lambda item: item
        out[field.name] = convert(value) if field.shape == "one" else [convert(item) for item in value]
    return out
