"""A ULog file made from nothing, so that the reader's traps are tested without any recording."""

import struct

import numpy as np
import pytest

MAGIC = b"ULog\x01\x12\x35\x01"
TYPES = {"uint64_t": "Q", "int32_t": "i", "float": "f", "uint8_t": "B", "uint32_t": "I", "double": "d"}


def message(kind, payload):
    return struct.pack("<HB", len(payload), ord(kind)) + payload


def topic(name, fields, rows, msg_id):
    """Return definition and data of one topic: ``fields`` is a list of (type, size, name), rows of flat numbers."""
    text = ";".join(f"{kind}[{size}] {field}" if size > 1 else f"{kind} {field}" for kind, size, field in fields)
    code = "<" + "".join(TYPES[kind] * size for kind, size, _ in fields)
    data = [message("D", struct.pack("<H", msg_id) + struct.pack(code, *row)) for row in rows]
    return message("F", f"{name}:{text};".encode()), message("A", struct.pack("<BH", 0, msg_id) + name.encode()), data


def parameter(name, value):
    kind, code = ("int32_t", "i") if isinstance(value, int) else ("float", "f")
    key = f"{kind} {name}".encode()
    return message("P", bytes([len(key)]) + key + struct.pack("<" + code, value))


def build(topics, parameters=None):
    parts = [topic(name, fields, rows, k) for k, (name, (fields, rows)) in enumerate(topics.items())]
    head = MAGIC + struct.pack("<Q", 1_000_000)
    definitions = b"".join(p[0] for p in parts) + b"".join(parameter(*p) for p in (parameters or {}).items())
    return head + definitions + b"".join(p[1] for p in parts) + b"".join(m for p in parts for m in p[2])


def imu_topic(n=50, *, old=True):
    """``sensor_combined`` in the old layout, with the magnetometer inside, every sample of it three times."""
    fields = [
        ("uint64_t", 1, "timestamp"),
        ("float", 3, "gyro_rad"),
        ("int32_t", 1, "accelerometer_timestamp_relative"),
        ("float", 3, "accelerometer_m_s2"),
    ]
    old_fields = [("int32_t", 1, "magnetometer_timestamp_relative"), ("float", 3, "magnetometer_ga")]
    old_fields += [("int32_t", 1, "baro_timestamp_relative")]
    rows = []
    for k in range(n):
        stamp = 2_000_000 + 4000 * k
        row = [stamp, 0.1, 0.2, 0.3 + k, 100, 0.0, 0.5, -9.75]
        rows.append([*row, -4000 * (k % 3) - 7, 0.25, 0.0, 0.5 + k // 3, 2147483647] if old else row)
    return (fields + old_fields if old else fields), rows


def attitude_topic(n=20, *, sample=True):
    fields = [("uint64_t", 1, "timestamp")] + [("uint64_t", 1, "timestamp_sample")] * sample + [("float", 4, "q")]
    return fields, [
        [2_003_000 + 10_000 * k] + [2_001_000 + 10_000 * k] * sample + [0.6, 0.0, 0.0, 0.8] for k in range(n)
    ]


@pytest.fixture
def ulog(tmp_path):
    """Return a function that writes topics and parameters into a ULog file and returns its path."""

    def write(topics, parameters=None, cut=None):
        path = tmp_path / "made.ulg"
        path.write_bytes(build(topics, parameters)[:cut])
        return path

    write.imu, write.attitude = imu_topic, attitude_topic
    return write


@pytest.fixture(scope="session")
def ulog_bytes():
    gps = [("uint64_t", 1, "timestamp"), ("int32_t", 1, "lat"), ("int32_t", 1, "lon"), ("uint8_t", 1, "fix_type")]
    rows = [[2_000_000 + 200_000 * k, 474_000_000, 85_000_000, 3] for k in range(5)]
    topics = {"sensor_combined": imu_topic(), "vehicle_attitude": attitude_topic(), "vehicle_gps_position": (gps, rows)}
    return build(topics, {"EKF2_MAG_DECL": 2.5, "SYS_MC_EST_GROUP": 2})


@pytest.fixture
def trial():
    """Return the fields of a small BROAD trial as MATLAB stores them."""
    n = 40
    rng = np.random.default_rng(5)
    q = np.tile([0.6, 0.0, 0.8, 0.0], (n, 1))
    q[3] = np.nan
    return {
        "imu_gyr": rng.standard_normal((n, 3)),
        "imu_acc": [0, 0, 9.81] + 0.1 * rng.standard_normal((n, 3)),
        "imu_mag": np.array([0, 20.0, -40.0]) + rng.standard_normal((n, 3)),
        "opt_quat": q,
        "opt_pos": np.tile([1.0, 2.0, 3.0], (n, 1)),
        "movement": (np.arange(n) > 10).astype(np.uint8)[:, None],
        "sampling_rate": np.array([[2000 / 7]]),
        "info": "a made trial",
    }
