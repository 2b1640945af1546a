"""An unmodified Cyclone DDS beside the node, with the messages that rclpy's packages lack, written down from their definitions.

usage: cyclone_peer.py listen SECONDS    one JSON object: what came when
       cyclone_peer.py garbage SECONDS   requests that are none, and datagrams of noise to the ports of the domain
       cyclone_peer.py lie SECONDS DOMAIN    bytes under the name of an odometry on /lie
"""

import json
import os
import random
import socket
import sys
import time
from dataclasses import dataclass

from cyclonedds.core import InstanceState, Policy, Qos, ReadCondition, SampleState, ViewState, WaitSet
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, byte, float64, int32, sequence, uint8, uint32, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

RELIABLE = Qos(Policy.Reliability.Reliable(duration(milliseconds=100)), Policy.History.KeepLast(100))

# Ports of a domain after the RTPS specification 9.6.1.1: discovery and data, by multicast and to the first participants.
PORTS = [7400, 7401, *range(7410, 7420)]


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time
    frame_id: str


@dataclass
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Quaternion(IdlStruct, typename="geometry_msgs::msg::dds_::Quaternion_"):
    x: float64
    y: float64
    z: float64
    w: float64


@dataclass
class Transform(IdlStruct, typename="geometry_msgs::msg::dds_::Transform_"):
    translation: Vector3
    rotation: Quaternion


@dataclass
class TransformStamped(IdlStruct, typename="geometry_msgs::msg::dds_::TransformStamped_"):
    header: Header
    child_frame_id: str
    transform: Transform


@dataclass
class TFMessage(IdlStruct, typename="tf2_msgs::msg::dds_::TFMessage_"):
    transforms: sequence[TransformStamped]


@dataclass
class KeyValue(IdlStruct, typename="diagnostic_msgs::msg::dds_::KeyValue_"):
    key: str
    value: str


@dataclass
class DiagnosticStatus(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticStatus_"):
    level: uint8
    name: str
    message: str
    hardware_id: str
    values: sequence[KeyValue]


@dataclass
class DiagnosticArray(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticArray_"):
    header: Header
    status: sequence[DiagnosticStatus]


@dataclass
class Estimate(IdlStruct, typename="meniscus_msgs::msg::dds_::Estimate_"):
    header: Header
    stamp_std: float64
    latency: float64
    camera_time: uint64
    number: uint64
    has_frame: bool
    frame: uint32
    has_tracers: bool
    mode: uint8
    model_version: uint64
    along: array[float64, 4]
    along_covariance: array[float64, 16]
    across: array[float64, 2]
    across_covariance: array[float64, 4]
    acceleration: float64
    slosh_energy: float64
    heat: float64
    crest: float64
    crest_half_width: float64
    crest_after: float64
    spill_probability: float64
    spill_limit: float64
    spill_warning: bool
    horizon: float64
    planned: float64
    has_plan: bool
    plan: uint32
    frames_in_time: uint64
    frames_late: uint64
    frames_lost: uint64
    frames_never_handled: uint64
    turns_dropped: uint64


@dataclass
class Nonsense(IdlStruct, typename="meniscus_msgs::srv::dds_::Plan_Request_"):
    bytes: sequence[byte]


@dataclass
class Lie(IdlStruct, typename="nav_msgs::msg::dds_::Odometry_"):
    bytes: sequence[byte]


def nanoseconds(stamp: Time) -> int:
    """Returns a stamp in nanoseconds since 1970."""
    return stamp.sec * 1_000_000_000 + stamp.nanosec


def listen(participant: DomainParticipant, seconds: float) -> dict:
    """Receives for `seconds` after the first estimate."""
    topics = {"tf": TFMessage, "diagnostics": DiagnosticArray, "liquid/estimate": Estimate}
    readers = {
        name: DataReader(participant, Topic(participant, f"rt/{name}", kind, qos=RELIABLE), qos=RELIABLE)
        for name, kind in topics.items()
    }
    unread = SampleState.NotRead | ViewState.Any | InstanceState.Any
    news = WaitSet(participant)
    for reader in readers.values():
        news.attach(ReadCondition(reader, unread))
    came, last, reports = {name: [] for name in topics}, {}, []
    end = time.monotonic() + 20.0
    begun = False
    while time.monotonic() < end:
        news.wait(duration(milliseconds=100))
        for name, reader in readers.items():
            for message in reader.take(N=100):
                now = time.time_ns()
                header = message.transforms[0].header if name == "tf" else message.header
                number = message.number if name == "liquid/estimate" else None
                came[name].append([nanoseconds(header.stamp), now, number])
                last[name] = message
                if name == "diagnostics":
                    reports.append(message)
        if not begun and {"tf", "liquid/estimate"} <= set(last):
            begun, end = True, time.monotonic() + seconds
            print(json.dumps({"found": sorted(last)}), flush=True)
    result = {"came": came}
    if "tf" in last:
        transform = last["tf"].transforms[0]
        place, turn = transform.transform.translation, transform.transform.rotation
        result["tf"] = [transform.header.frame_id, transform.child_frame_id, [place.x, place.y, place.z]]
        result["rotation"] = [turn.x, turn.y, turn.z, turn.w]
    result["reports"] = [
        {
            status.name: [status.level, status.message, {value.key: value.value for value in status.values}]
            for status in report.status
        }
        for report in reports
    ]
    return result


def garbage(participant: DomainParticipant, seconds: float) -> dict:
    """Sends noise for `seconds`, two hundred datagrams and twenty requests a second."""
    draw = random.Random(7)
    writer = DataWriter(participant, Topic(participant, "rq/liquid/planRequest", Nonsense, qos=RELIABLE), qos=RELIABLE)
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
    sent, end = 0, time.monotonic() + seconds
    while time.monotonic() < end:
        for _ in range(5):
            noise = draw.randbytes(draw.randrange(1, 400))
            # Half of them begin as a message of the protocol does, so that its parts are looked at.
            head = b"RTPS\x02\x03\x01\x0f" + draw.randbytes(12) if draw.random() < 0.5 else b""
            for address in ["127.0.0.1", "239.255.0.1"]:
                sender.sendto(head + noise, (address, draw.choice(PORTS)))
                sent += 1
        writer.write(Nonsense(bytes=list(draw.randbytes(draw.randrange(0, 64)))))
        time.sleep(0.05)
    return {"sent": sent}


def lie(participant: DomainParticipant, seconds: float) -> dict:
    """Sends bytes for `seconds`, fifty messages a second."""
    draw = random.Random(11)
    writer = DataWriter(participant, Topic(participant, "rt/lie", Lie, qos=RELIABLE), qos=RELIABLE)
    sent, end = 0, time.monotonic() + seconds
    while time.monotonic() < end:
        # The first bytes are read as stamp, and as length of a name.
        writer.write(Lie(bytes=list(draw.randbytes(draw.randrange(0, 900)))))
        sent += 1
        time.sleep(0.02)
    return {"sent": sent}


def main() -> None:
    """Runs the peer."""
    # The configuration has to be there before the first participant.
    os.environ.setdefault("CYCLONEDDS_URI", "<General><Interfaces><NetworkInterface name='lo' multicast='true'/></Interfaces></General>")
    participant = DomainParticipant(int(sys.argv[3]) if len(sys.argv) > 3 else 0)
    work = {"listen": listen, "garbage": garbage, "lie": lie}[sys.argv[1]]
    print(json.dumps(work(participant, float(sys.argv[2]))))


if __name__ == "__main__":
    main()
