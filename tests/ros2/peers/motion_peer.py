"""An rclpy that publishes the motion of a glass as messages of every type, and the same samples as binary frames over UDP.

usage: motion_peer.py

A line of JSON from standard input is a list of events, in the order of their instants. The answer is a line when all are sent, with
the greatest delay behind an instant. All messages are built before the first is sent.
An event has: kind (a key of KINDS), domain and topic, or an address; publisher (0 without), due_ns (when it is sent), stamp_ns, x
(m along the line), v, a, and for faults: quaternion, frames. A number that is null is not a number. One with `announce` only makes
the publisher, and one with `await` waits until somebody reads it.

The line has the direction LINE in the world. The messages state the motion in other axes, from which the reader has to come back:
those of a body at the attitude ATTITUDE, and of a rail that stands askew.
"""

import json
import math
import socket
import struct
import sys
import time
from functools import partial

import numpy
import rclpy
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, Quaternion, TransformStamped
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

LINE = numpy.array([0.6, 0.8, 0.0])
UP = numpy.array([0.0, 0.0, 1.0])
GRAVITY = 9.80665
# Time for a reader to find its publisher, s.
PATIENCE = 10.0
# Axis and angle (rad) of the body's attitude, and of the rail's.
ATTITUDE = (numpy.array([1.0, 2.0, 2.0]) / 3.0, 0.7)
RAIL = (numpy.array([2.0, -1.0, 2.0]) / 3.0, 1.1)
PLACE = numpy.array([0.3, -0.2, 0.5])


def matrix(axis, angle: float):
    """Returns the matrix of a rotation, by Rodrigues' formula."""
    x, y, z = axis
    cross = numpy.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return numpy.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross


def quaternion(axis, angle: float) -> Quaternion:
    """Returns the quaternion of a rotation."""
    x, y, z = axis * math.sin(angle / 2.0)
    return Quaternion(x=x, y=y, z=z, w=math.cos(angle / 2.0))


def stamp(event) -> Time:
    """Returns the stamp of an event."""
    return Time(sec=event["stamp_ns"] // 1_000_000_000, nanosec=event["stamp_ns"] % 1_000_000_000)


def number(event, key: str) -> float:
    """Returns a number of an event; `null` is not a number, and what is absent is zero."""
    value = event.get(key, 0.0)
    return math.nan if value is None else float(value)


def put(to, vector) -> None:
    """Writes a vector into a message."""
    to.x, to.y, to.z = (float(part) for part in vector)


def turned(event, rotation) -> Quaternion:
    """Returns the quaternion of a rotation, or the wrong one of the event."""
    if "quaternion" in event:
        x, y, z, w = event["quaternion"]
        return Quaternion(x=x, y=y, z=z, w=w)
    return quaternion(*rotation)


def odometry(event) -> Odometry:
    """Pose in the world, twist in the axes of the body."""
    message = Odometry(child_frame_id="glass_holder")
    message.header.frame_id, message.header.stamp = "world", stamp(event)
    put(message.pose.pose.position, PLACE + LINE * number(event, "x"))
    message.pose.pose.orientation = turned(event, ATTITUDE)
    put(message.twist.twist.linear, matrix(*ATTITUDE).T @ (LINE * number(event, "v")))
    return message


def pose(event) -> PoseStamped:
    """Pose in the world."""
    message = PoseStamped()
    message.header.frame_id, message.header.stamp = "world", stamp(event)
    put(message.pose.position, PLACE + LINE * number(event, "x"))
    message.pose.orientation = turned(event, ATTITUDE)
    return message


def link(parent: str, child: str, at, translation, rotation) -> TransformStamped:
    """Returns a transform."""
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id, message.header.stamp = parent, at
    put(message.transform.translation, translation)
    message.transform.rotation = rotation
    return message


def transform(event) -> TransformStamped:
    """Place in the world."""
    return link("world", "glass_holder", stamp(event), PLACE + LINE * number(event, "x"), turned(event, ATTITUDE))


def chain(event) -> TFMessage:
    """A cart on a rail, and a holder that moves on the cart: 0.7 and 0.3 of the motion. The rail's place is static."""
    x, along = number(event, "x"), matrix(*RAIL).T @ LINE
    cart, holder = event.get("frames", ["cart", "glass_holder"])
    carried = matrix(*ATTITUDE).T @ along
    return TFMessage(
        transforms=[
            link("rail", cart, stamp(event), along * 0.7 * x, turned(event, ATTITUDE)),
            link(cart, holder, stamp(event), carried * 0.3 * x, quaternion(UP, 0.4)),
        ]
    )


def rail(_event) -> TFMessage:
    """The rail in the world."""
    return TFMessage(transforms=[link("world", "rail", Time(), PLACE, quaternion(*RAIL))])


def imu(event) -> Imu:
    """Specific force in the axes of the sensor."""
    message = Imu()
    message.header.frame_id, message.header.stamp = "imu", stamp(event)
    force = LINE * number(event, "a") + UP * GRAVITY
    if event.get("level"):
        # A sensor without an orientation, whose x is the line.
        message.orientation_covariance[0] = -1.0
        force = numpy.array([number(event, "a"), 0.0, GRAVITY])
    else:
        message.orientation = turned(event, ATTITUDE)
        force = matrix(*ATTITUDE).T @ force
    put(message.linear_acceleration, force)
    return message


def joints(event) -> JointState:
    """The joint that moves the glass, behind another one."""
    message = JointState(name=["wrist", "slide"])
    message.header.stamp = stamp(event)
    message.position, message.velocity = [1.5, number(event, "x")], [0.0, number(event, "v")]
    return message


def text(_event) -> String:
    """Something that is no motion."""
    return String(data="the glass moves")


LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
KINDS = {
    "odometry": (Odometry, odometry, QoSProfile(depth=50)),
    "pose": (PoseStamped, pose, QoSProfile(depth=50)),
    "transform": (TransformStamped, transform, QoSProfile(depth=50)),
    "chain": (TFMessage, chain, QoSProfile(depth=100)),
    "rail": (TFMessage, rail, LATCHED),
    "imu": (Imu, imu, qos_profile_sensor_data),
    "joints": (JointState, joints, QoSProfile(depth=50)),
    "text": (String, text, QoSProfile(depth=50)),
}


class Sender:
    """Publishers and a socket, each made at its first event."""

    def __init__(self) -> None:
        self.nodes, self.publishers, self.sequence = {}, {}, {}
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def publisher(self, event):
        """Returns the publisher of an event."""
        domain = event["domain"]
        if domain not in self.nodes:
            context = rclpy.Context()
            rclpy.init(context=context, domain_id=domain)
            self.nodes[domain] = rclpy.create_node(f"mover_{domain}", context=context)
        key = (domain, event["kind"], event["topic"], event.get("publisher", 0))
        if key not in self.publishers:
            kind, _, qos = KINDS[event["kind"]]
            self.publishers[key] = self.nodes[domain].create_publisher(kind, event["topic"], qos)
        return self.publishers[key]

    def frame(self, event) -> bytes:
        """Returns a binary frame: position, and velocity and acceleration where the event says so."""
        stated = event["states"]
        flags = 1 | (2 if "v" in stated else 0) | (4 if "a" in stated else 0)
        vectors = [LINE * number(event, "x") if "x" in stated else LINE * 0.0]
        vectors += [LINE * number(event, key) for key in "va" if key in stated]
        address = event["address"]
        sequence = self.sequence.get(address, 0)
        self.sequence[address] = sequence + 1
        data = struct.pack("<4sBBHIQ", b"MNSM", 1, flags, 0, sequence, event["stamp_ns"])
        return data + b"".join(struct.pack("<3d", *vector) for vector in vectors)

    def built(self, event):
        """Returns what sends the message of an event: a function without arguments."""
        if event["kind"] == "udp":
            host, port = event["address"].rsplit(":", 1)
            return partial(self.socket.sendto, self.frame(event), (host, int(port)))
        return partial(self.publisher(event).publish, KINDS[event["kind"]][1](event))

    def prepare(self, event) -> None:
        """Makes the publisher of an event, and waits for its reader where the event says so."""
        publisher = self.publisher(event)
        end = time.monotonic() + (PATIENCE if event.get("await") else 0.0)
        while publisher.get_subscription_count() == 0 and time.monotonic() < end:
            time.sleep(0.01)

    def play(self, events) -> float:
        """Sends the messages of events at their instants. Returns the greatest delay, s; an event without an instant has none."""
        late_s = 0.0
        for event, send in [(event, self.built(event)) for event in events]:
            time.sleep(max(0.0, 1e-9 * (event["due_ns"] - time.time_ns())))
            send()
            if event["due_ns"]:
                late_s = max(late_s, 1e-9 * (time.time_ns() - event["due_ns"]))
        return late_s


def main() -> None:
    """Runs the peer."""
    sender = Sender()
    print(json.dumps({"ready": True}), flush=True)
    for line in sys.stdin:
        events = json.loads(line)
        to_prepare = [event for event in events if "announce" in event or "await" in event]
        for event in to_prepare:
            sender.prepare(event)
        late_s = sender.play(events) if not to_prepare else 0.0
        print(json.dumps({"sent": len(events), "late_s": late_s}), flush=True)


if __name__ == "__main__":
    main()
