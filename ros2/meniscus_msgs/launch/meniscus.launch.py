"""Runs the estimator as a node, places its camera in the robot, and shows the liquid in RViz.

ros2 launch meniscus_msgs meniscus.launch.py source:=usb
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Returns estimator, place of the camera and RViz."""
    arguments = [
        DeclareLaunchArgument("program", default_value="meniscus", description="built with --features ros2"),
        DeclareLaunchArgument("source", default_value="shipped", description="usb, or the simulated camera"),
    ]
    estimator = ExecuteProcess(
        cmd=[LaunchConfiguration("program"), "run", "--ros2", "--view", "--source", LaunchConfiguration("source")],
        output="screen",
        sigterm_timeout="10",
    )
    # The optical frame of a camera that looks along the robot's x: replace it by where yours is mounted.
    camera = Node(
        package="tf2_ros",
        executable="static_transform_publisher",
        arguments=["--frame-id", "base_link", "--child-frame-id", "meniscus_camera", "--x", "0.3", "--z", "0.5"]
        + ["--roll", "-1.5708", "--yaw", "-1.5708"],
    )
    rviz = Node(
        package="rviz2",
        executable="rviz2",
        arguments=["-d", PathJoinSubstitution([FindPackageShare("meniscus_msgs"), "rviz", "meniscus.rviz"])],
    )
    return LaunchDescription([*arguments, estimator, camera, rviz])
