#!/bin/bash
# Makes a ROS 2 Jazzy of Python wheels: rclpy on Fast DDS, colcon, and planesman_msgs as ROS's own generators make it. `.ros` in
# the repository's root, or a folder of your choice.
#
#     tests/ros/install.sh [FOLDER]
#
# PyPI has no ros2 command line, no launch and no rosbag2; rclpy, rcl, rmw_fastrtps, Fast DDS and rosidl are the released ones.
#
# Needs the packages of apt-packages.txt.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
venv=$(realpath -m "${1:-$here/../../.ros}")

/usr/bin/python3 -m venv "$venv"
# All but empy have a wheel.
PIP_DISABLE_PIP_VERSION_CHECK=1 "$venv/bin/pip" install --quiet --no-deps --prefer-binary --use-pep517 \
    --requirement "$here/requirements.txt" --requirement "$here/../colcon/requirements.txt"

# The wheels' CMake files name folders of the Python that they were built with.
read -r include packages < <("$venv/bin/python" -c \
    'import sysconfig; paths = sysconfig.get_paths(); print(paths["include"], paths["purelib"])')
find "$venv/share" -name '*.cmake' -exec sed --in-place \
    --expression="s#/opt/python/cp311-cp311/include/python3.11#$include#g" \
    --expression="s#/opt/python/cp311-cp311/lib/python3.11/site-packages#$packages#g" {} +

export PATH="$venv/bin:$PATH" AMENT_PREFIX_PATH=$venv CMAKE_PREFIX_PATH=$venv LD_LIBRARY_PATH=$venv/lib
build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
{
    cmake -S "$here/../../msgs" -B "$build" -DBUILD_TESTING=OFF -DCMAKE_INSTALL_PREFIX="$venv" \
        -DCMAKE_INSTALL_RPATH="$venv/lib" -DPython3_EXECUTABLE="$venv/bin/python"
    cmake --build "$build" --parallel "$(nproc)"
    cmake --install "$build"
} >"$venv/planesman_msgs.log" 2>&1 || {
    tail -n 40 "$venv/planesman_msgs.log" >&2
    exit 1
}
"$venv/bin/python" -c 'import rclpy, planesman_msgs.msg'
