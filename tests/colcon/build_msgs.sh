#!/usr/bin/env bash
# Builds the ROS package planesman_msgs with colcon and compiles its C and C++ type support.
#
# Debian 12 packages the ROS 2 build tools (ament 1.5, rosidl 3.3: the generation of Humble) but no
# message packages and no rosidl_default_generators. The packages ours depends on are therefore made here, in
# a temporary workspace: the messages from msgs/standard, the generators as a package that names
# those Debian has. rosidl 3.3 knows neither type hashes nor service events, so this checks that the
# definitions, package.xml and CMakeLists.txt build, not the hashes; those are tested in Rust.
#
# Needs the packages of apt-packages.txt. Without them: says so and exits with 77 (skipped).
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
msgs=$(cd "$here/../../msgs" && pwd)

# The Python that Debian's modules belong to, whatever else is first in PATH.
python=/usr/bin/python3

skip() {
  echo "skipped: $1 (install the packages listed in tests/colcon/apt-packages.txt)"
  exit 77
}
for tool in colcon cmake c++ make; do
  command -v "$tool" > /dev/null || skip "$tool is not installed"
done
for package in ament_cmake rosidl_adapter rosidl_generator_c rosidl_generator_cpp \
  rosidl_typesupport_introspection_c rosidl_typesupport_introspection_cpp; do
  [[ -f /usr/share/ament_index/resource_index/packages/$package ]] \
    || skip "the ament package $package is not installed"
done
"$python" -c 'import em, lark, catkin_pkg, colcon_ros' 2> /dev/null \
  || skip "$python lacks a module that colcon or rosidl needs"

workspace=$(mktemp -d)
trap 'rm -rf "$workspace"' EXIT
mkdir "$workspace/src"

# package_xml NAME DEPENDENCY... : the manifest of a package made here.
package_xml() {
  local name=$1 dependency
  shift
  echo '<?xml version="1.0"?>'
  echo '<package format="3">'
  echo "  <name>$name</name><version>0.0.0</version><description>made for a test</description>"
  echo '  <maintainer email="nobody@example.com">nobody</maintainer><license>none</license>'
  echo '  <buildtool_depend>ament_cmake</buildtool_depend>'
  for dependency in "$@"; do
    echo "  <depend>$dependency</depend>"
  done
  [[ $name == *_default_* || $name == user_* ]] \
    || echo '  <member_of_group>rosidl_interface_packages</member_of_group>'
  echo '  <export><build_type>ament_cmake</build_type></export>'
  echo '</package>'
}

# Stand-ins for the two meta packages that every message package names.
make_meta_package() {
  local name=$1 exported=$2 folder=$workspace/src/$1
  mkdir "$folder"
  package_xml "$name" > "$folder/package.xml"
  cat > "$folder/CMakeLists.txt" << EOF
cmake_minimum_required(VERSION 3.8)
project($name NONE)
find_package(ament_cmake REQUIRED)
ament_export_dependencies($exported)
ament_package()
EOF
}
make_meta_package rosidl_default_generators "rosidl_cmake rosidl_generator_c rosidl_generator_cpp \
rosidl_typesupport_introspection_c rosidl_typesupport_introspection_cpp"
make_meta_package rosidl_default_runtime "rosidl_runtime_c rosidl_runtime_cpp"

# dependencies_of FOLDER : the other packages that the definitions in a folder name.
dependencies_of() {
  local self
  self=$(basename "$1")
  { grep -rhoE '^[a-z][a-z0-9_]*/[A-Z]' "$1" || true; } | cut -d/ -f1 | sort -u | grep -vx "$self" || true
}

make_message_package() {
  local source=$1 name folder dependencies
  name=$(basename "$source")
  folder=$workspace/src/$name
  cp -r "$source" "$folder"
  mapfile -t dependencies < <(dependencies_of "$source")
  package_xml "$name" rosidl_default_generators "${dependencies[@]}" > "$folder/package.xml"
  {
    echo 'cmake_minimum_required(VERSION 3.8)'
    echo "project($name)"
    echo 'find_package(ament_cmake REQUIRED)'
    echo 'find_package(rosidl_default_generators REQUIRED)'
    for dependency in "${dependencies[@]}"; do
      echo "find_package($dependency REQUIRED)"
    done
    # shellcheck disable=SC2016 # CMake expands these
    echo 'file(GLOB definitions RELATIVE "${CMAKE_CURRENT_SOURCE_DIR}" msg/*.msg srv/*.srv)'
    # shellcheck disable=SC2016
    echo 'rosidl_generate_interfaces(${PROJECT_NAME} ${definitions}' "DEPENDENCIES ${dependencies[*]})"
    echo 'ament_package()'
  } > "$folder/CMakeLists.txt"
}

# The packages that planesman_msgs depends on, directly or through others.
needed=(action_msgs service_msgs unique_identifier_msgs builtin_interfaces std_msgs)
for name in "${needed[@]}"; do
  make_message_package "$msgs/standard/$name"
done
cp -r "$msgs" "$workspace/src/planesman_msgs"

# A package that uses ours the way a ROS node would.
user=$workspace/src/user_of_planesman_msgs
mkdir "$user"
package_xml user_of_planesman_msgs planesman_msgs > "$user/package.xml"
cat > "$user/CMakeLists.txt" << 'EOF'
cmake_minimum_required(VERSION 3.8)
project(user_of_planesman_msgs CXX)
find_package(ament_cmake REQUIRED)
find_package(planesman_msgs REQUIRED)
add_executable(use use.cpp)
target_compile_features(use PRIVATE cxx_std_17)
target_link_libraries(use planesman_msgs::planesman_msgs__rosidl_generator_cpp)
install(TARGETS use DESTINATION bin)
ament_package()
EOF
cat > "$user/use.cpp" << 'EOF'
#include <planesman_msgs/action/manoeuvre.hpp>
#include <planesman_msgs/msg/plane_motion.hpp>
#include <planesman_msgs/msg/vehicle_state.hpp>
#include <planesman_msgs/srv/fit.hpp>

int main() {
  planesman_msgs::msg::VehicleState state;
  state.header.frame_id = "map";
  state.planes_source = planesman_msgs::msg::VehicleState::PLANES_HELD;
  planesman_msgs::msg::PlaneMotion motion;
  motion.dive_planes = {0.0, 0.1};
  planesman_msgs::srv::Fit::Response fit;
  planesman_msgs::action::Manoeuvre::Goal goal;
  goal.amplitude = 0.1;
  return state.planes_source == 1 && motion.dive_planes.size() == 2 && !fit.success ? 0 : 1;
}
EOF

cd "$workspace"
found=$(colcon list --names-only --base-paths src/planesman_msgs)
if [[ $found != planesman_msgs ]]; then
  echo "colcon should find the package planesman_msgs alone in msgs/, but finds: $found" >&2
  exit 1
fi

colcon build --cmake-args "-DPython3_EXECUTABLE=$python" -DBUILD_TESTING=OFF > build.log 2>&1 \
  || { tail -n 60 build.log >&2; exit 1; }

# What the build has left behind: a header for each definition, and the compiled type support.
include=$workspace/install/planesman_msgs/include/planesman_msgs/planesman_msgs
snake_case() {
  basename "${1%.*}" | sed -E 's/([a-z0-9])([A-Z])/\1_\2/g' | tr '[:upper:]' '[:lower:]'
}
count=0
for definition in "$msgs"/{msg/*.msg,srv/*.srv,action/*.action}; do
  header=$include/$(basename "$(dirname "$definition")")/$(snake_case "$definition")
  for extension in h hpp; do
    [[ -f $header.$extension ]] || { echo "not generated: $header.$extension" >&2; exit 1; }
  done
  count=$((count + 1))
done
for library in generator_c typesupport_introspection_c typesupport_introspection_cpp; do
  library=$workspace/install/planesman_msgs/lib/libplanesman_msgs__rosidl_$library.so
  [[ -f $library ]] || { echo "not built: $library" >&2; exit 1; }
done

install/user_of_planesman_msgs/bin/use

echo "ok: colcon built planesman_msgs: $count definitions in C and C++"
