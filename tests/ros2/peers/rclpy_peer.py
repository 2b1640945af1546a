"""An unmodified rclpy beside the node: receives every topic that it has the messages of, publishes the same for comparison, reads
and sets parameters, and has plans predicted.

usage: rclpy_peer.py listen SECONDS [NAME]   one JSON object: what came when, of the topics under /NAME (default: /liquid)
       rclpy_peer.py talk SECONDS NAME       the node's topics under /NAME, from rclpy itself
       rclpy_peer.py parameters              one JSON object: values, and what became of changes
       rclpy_peer.py plan                    samples and options from standard input as JSON, one answer a line
"""

import array
import gc
import json
import math
import os
import pathlib
import sys
import time

import rclpy
from builtin_interfaces.msg import Time
from meniscus_msgs.msg import Estimate, PlanSample
from meniscus_msgs.srv import Plan
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import PointCloud2

# Time that a service may take, s.
PATIENCE = 20.0

# Calls of a service within that time.
CALLS = 2

# Rate of a talker, Hz. Beside 60 turns a second it comes at all times of a turn.
TALK_HZ = 53.0


def nanoseconds(stamp) -> int:
    """Returns a stamp in nanoseconds since 1970."""
    return stamp.sec * 1_000_000_000 + stamp.nanosec


def floats_of(cloud: PointCloud2) -> memoryview:
    """Returns the numbers of a cloud."""
    return memoryview(bytes(cloud.data)).cast("f")


def listen(node, seconds: float, name: str) -> dict:
    """Receives the topics under `name` for `seconds` after the first of each."""
    estimates, clouds, last, states = [], {"tracers": [], "surface": []}, {}, []
    once = []

    def on_estimate(message) -> None:
        now = time.time_ns()
        stamp = nanoseconds(message.header.stamp)
        estimates.append([message.number, stamp, now, message.latency, message.has_frame, message.turns_dropped, message.has_tracers])
        states.append([*message.along, *message.along_covariance])
        last["estimate"] = message

    def on_cloud(topic: str):
        def take(message) -> None:
            now = time.time_ns()
            clouds[topic].append([nanoseconds(message.header.stamp), now])
            # The heights of a turn without a frame were not measured: they are not numbers, which JSON lacks.
            if topic != "surface" or math.isfinite(floats_of(message)[4]):
                last[topic] = message

        return take

    def on_sensor_data(message) -> None:
        now = time.time_ns()
        once.append([nanoseconds(message.header.stamp), now])

    node.create_subscription(Estimate, f"/{name}/estimate", on_estimate, QoSProfile(depth=60))
    for topic in clouds:
        node.create_subscription(PointCloud2, f"/{name}/{topic}", on_cloud(topic), QoSProfile(depth=30))
    # As most readers of clouds subscribe: a lost part is not sent again, and nothing waits for it.
    node.create_subscription(PointCloud2, f"/{name}/tracers", on_sensor_data, qos_profile_sensor_data)
    patience = time.monotonic() + PATIENCE
    # The first of each topic: then all of them have found their publishers.
    while len(last) < 3 and time.monotonic() < patience:
        rclpy.spin_once(node, timeout_sec=0.1)
    print(json.dumps({"found": sorted(last)}), flush=True)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.1)
    described = {
        topic: {
            "frame": last[topic].header.frame_id,
            "fields": [field.name for field in last[topic].fields],
            "points": last[topic].width,
            "step": last[topic].point_step,
            "first": list(floats_of(last[topic])[: last[topic].point_step // 4]),
        }
        for topic in clouds
        if topic in last
    }
    final = last.get("estimate")
    return {
        "estimates": estimates,
        "clouds": clouds,
        "once": once,
        "described": described,
        "finite": all(math.isfinite(x) for state in states for x in state),
        "crest": final and [final.crest, final.crest_half_width, final.spill_probability, final.spill_limit, final.horizon],
    }


def talk(node, seconds: float, name: str) -> dict:
    """Publishes for `seconds` what the node does: in its order, with its sizes and its quality of service."""
    estimates = node.create_publisher(Estimate, f"/{name}/estimate", QoSProfile(depth=60))
    clouds = [
        (node.create_publisher(PointCloud2, f"/{name}/{topic}", QoSProfile(depth=30)), cloud_of(points, floats))
        for topic, points, floats in [("surface", 21, 5), ("tracers", 2134, 13)]
    ]
    number, due, end = 0, time.monotonic(), time.monotonic() + seconds
    while time.monotonic() < end:
        stamp = time.time_ns()
        estimate = Estimate(number=number, has_frame=True, has_tracers=True)
        for message in [estimate, *(cloud for _, cloud in clouds)]:
            message.header.stamp = Time(sec=stamp // 1_000_000_000, nanosec=stamp % 1_000_000_000)
        estimates.publish(estimate)
        for publisher, cloud in clouds:
            publisher.publish(cloud)
        number += 1
        due += 1.0 / TALK_HZ
        time.sleep(max(0.0, due - time.monotonic()))
    return {"sent": number}


def cloud_of(points: int, floats: int) -> PointCloud2:
    """Returns a cloud with the size of the node's."""
    cloud = PointCloud2(width=points, height=1, point_step=4 * floats, row_step=4 * floats * points, is_dense=True)
    cloud.header.frame_id = "glass"
    # An array of bytes is copied at once, a list byte by byte.
    cloud.data = array.array("B", bytes(cloud.row_step))
    return cloud


def client_of(node, kind, name: str):
    """Returns a client of a service that is there."""
    client = node.create_client(kind, name)
    if not client.wait_for_service(timeout_sec=PATIENCE):
        raise SystemExit(f"there is no service {name}")
    return client


def answer_of(node, client, request):
    """Returns the answer to a client. On a busy machine a first answer may not come: the request is made again."""
    for _ in range(CALLS):
        future = client.call_async(request)
        rclpy.spin_until_future_complete(node, future, timeout_sec=PATIENCE / CALLS)
        if future.done():
            return future.result()
    raise SystemExit(f"{client.srv_name} did not answer {CALLS} calls")


def parameters(node) -> dict:
    """Lists and reads parameters of the node; sets some when a line comes."""
    kinds = {"list": ListParameters, "get": GetParameters, "set": SetParameters, "describe": DescribeParameters}
    clients = {verb: client_of(node, kind, f"/meniscus/{verb}_parameters") for verb, kind in kinds.items()}

    def call(verb: str, **fields):
        return answer_of(node, clients[verb], kinds[verb].Request(**fields))

    # One call by each client. The first may take a heartbeat of Fast DDS, 3 s; later ones take a turn.
    listed = call("list").result.names
    values = call("get", names=listed).values
    described = call("describe", names=["tracers_hz"])
    call("set", parameters=[])
    print(json.dumps({"found": listed}), flush=True)
    sys.stdin.readline()
    changes = [("tracers_hz", 10.0), ("spill_limit", 0.25), ("tracers_hz", 100.0), ("liquid", "water"), ("colour", 1.0)]
    results = call("set", parameters=[Parameter(name, value=value).to_parameter_msg() for name, value in changes]).results
    set_ns = time.time_ns()
    again = call("get", names=["tracers_hz", "spill_limit"]).values
    read = {name: rclpy.parameter.parameter_value_to_python(value) for name, value in zip(listed, values)}
    return {
        "read": {name: list(value) if hasattr(value, "tolist") else value for name, value in read.items()},
        "set": [[name, result.successful, result.reason] for (name, _), result in zip(changes, results)],
        "again": [value.double_value for value in again],
        "described": described.descriptors[0].name,
        "set_ns": set_ns,
    }


def plans(node) -> None:
    """Has the plans predicted that come as lines of JSON, by one client, as a controller does."""
    client = client_of(node, Plan, "/liquid/plan")
    for line in sys.stdin:
        wanted = json.loads(line)
        request = Plan.Request(sequence=wanted["sequence"], follow=wanted["follow"])
        for stamp, position in wanted["samples"]:
            sample = PlanSample(stamp=Time(sec=stamp // 1_000_000_000, nanosec=stamp % 1_000_000_000))
            sample.position.x, sample.position.y, sample.position.z = position
            request.samples.append(sample)
        begun = time.monotonic()
        answer = answer_of(node, client, request)
        print(
            json.dumps(
                {
                    "accepted": answer.accepted,
                    "fault": answer.fault,
                    "reason": answer.reason,
                    "host_ns": nanoseconds(answer.stamp),
                    "camera_time": answer.camera_time,
                    "across": answer.across,
                    "profiles": [
                        [profile.after, [float(x) for x in profile.heights], [float(x) for x in profile.half_widths]]
                        for profile in answer.profiles
                    ],
                    "crest": [answer.crest, answer.crest_half_width, answer.crest_after],
                    "spill": answer.spill_probability,
                    "horizon": [answer.horizon, answer.planned],
                    "took_s": time.monotonic() - begun,
                }
            ),
            flush=True,
        )


def main() -> None:
    """Runs the peer."""
    verb, name = sys.argv[1], sys.argv[3] if len(sys.argv) > 3 else "liquid"
    if name != "liquid":
        # The configuration has to be there before the first participant.
        os.environ["FASTDDS_DEFAULT_PROFILES_FILE"] = str(pathlib.Path(__file__).with_name("fastdds_pair.xml"))
    # A full collection goes through all objects of the imported packages, and would count as latency of the node.
    gc.disable()
    rclpy.init()
    node = rclpy.create_node(f"{verb}_peer")
    if verb == "listen":
        print(json.dumps(listen(node, float(sys.argv[2]), name), allow_nan=False))
    elif verb == "talk":
        print(json.dumps(talk(node, float(sys.argv[2]), name)))
    elif verb == "parameters":
        print(json.dumps(parameters(node), allow_nan=False))
    else:
        plans(node)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
