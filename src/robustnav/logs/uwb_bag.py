"""Messages of a ROS 1 bag by topic, through the optional package rosbags, made safe.

Only message types named here are read, by definitions of ours: rosbags builds its decoders as Python code from
definitions, and those inside a bag are whatever its writer put there.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from robustnav.errors import InputError, MissingExtra
from robustnav.logs.files import checked_path, unusable

EXPECTED = "a ROS 1 bag, version 2.0, with its index"
DEFINITIONS = {
    "fraunhofer_rtls_flare/msg/RTLSRange": (
        "uint16 id\ngeometry_msgs/Point pos\nfloat32 pr\nfloat32 range\nfloat32 mean\nfloat32 var\nfloat32 fpp\n"
        "float32 rxp\nfloat32 csn\nfloat32 cmn\nuint8 toc\nuint8 ra\n"
    ),
    "fraunhofer_rtls_flare/msg/RTLSStick": (
        "Header header\nuint16 id\nuint32 t\ngeometry_msgs/Point pos\ngeometry_msgs/Point mean\n"
        "geometry_msgs/Vector3 hrp\nuint8 noga\nuint8 nora\nRTLSRange[] ranges\n"
    ),
}
# What a damaged bag makes rosbags raise beside its own errors; AssertionError is among its checks.
_DAMAGE = (
    *(struct.error, ValueError, LookupError, ArithmeticError, AssertionError),
    *(OSError, EOFError, RuntimeError, MemoryError),
)


def read_bag(path: Path, topics: Mapping[str, str]) -> dict[str, list[Any]]:
    """Return the decoded messages of each topic in the order of the bag.

    Parameters
    ----------
    topics : message type by topic, written as ``sensor_msgs/msg/Imu``.

    Raises
    ------
    MissingExtra : rosbags is not installed.
    InputError : no bag, a damaged one, or a topic that is missing or of another type.
    """
    file = checked_path(path, EXPECTED)
    rosbag1, serde, typesys = _rosbags()
    store = _store(typesys)
    messages: dict[str, list[Any]] = {topic: [] for topic in topics}
    try:
        with rosbag1.Reader(file) as bag:
            wanted = _connections(file, bag.connections, topics, store)
            for connection, _, raw in bag.messages(connections=wanted):
                messages[connection.topic].append(store.deserialize_ros1(raw, connection.msgtype))
    except InputError:
        raise
    except (rosbag1.ReaderError, serde.SerdeError, typesys.TypesysError, *_DAMAGE) as why:
        got = f"{type(why).__name__}: {why}"[:200]
        raise unusable(file, got, EXPECTED, do="copy the recording again") from why
    return messages


def _rosbags() -> tuple[Any, Any, Any]:
    try:
        return (*(import_module(f"rosbags.{name}") for name in ("rosbag1", "serde", "typesys")),)  # type: ignore[return-value]
    except ModuleNotFoundError as why:
        raise MissingExtra("rosbags", "ros") from why


def _store(typesys: Any) -> Any:
    store = typesys.get_typestore(typesys.Stores.ROS1_NOETIC)
    for name, text in DEFINITIONS.items():
        store.register(typesys.get_types_from_msg(text, name))
    return store


def _connections(path: Path, present: Sequence[Any], topics: Mapping[str, str], store: Any) -> list[Any]:
    """Return the connections of the topics; their types must be those asked for, down to the definition's sum."""
    wanted = [connection for connection in present if connection.topic in topics]
    missing = sorted(set(topics) - {connection.topic for connection in wanted})
    if missing:
        got = f"topics {', '.join(sorted({c.topic for c in present})) or 'none'}"
        raise unusable(path, got, f"the topic {missing[0]}")
    for connection in wanted:
        kind = topics[connection.topic]
        if connection.msgtype != kind or connection.digest != store.generate_msgdef(kind)[1]:
            got = f"type {connection.msgtype}, sum {connection.digest}"
            raise unusable(path, got, f"type {kind} as we know it", place=connection.topic)
    return wanted
