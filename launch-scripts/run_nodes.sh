#!/usr/bin/env bash
# Starts the loop's nodes without ROS and without the planesman launcher, each as a process of its
# own, and stops them all on Ctrl-C, on SIGTERM, or when one of them ends.
#
#   run_nodes.sh [OPTION...] [NODE...]        all nodes, or those named
#
# In one terminal `run_nodes.sh`, or in five: `run_nodes.sh plant_sim`, `run_nodes.sh sysid`, ...
# with the same options in each.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

usage() {
  cat << EOF
usage: run_nodes.sh [OPTION...] [NODE...]
nodes, all if none is named: ${all[*]}
  --params FILE     a ROS 2 parameter file [launch-scripts/params/params.yaml]
                    (planesman params --yaml --scenario dive > FILE writes one)
  --namespace NAME  of all nodes and topics [/auv]
  --lockstep        as fast as all nodes answer, instead of by the wall clock
  --factor F        by the wall clock, F times faster; stamps from 0, /clock
  --sim-time        by the wall clock; stamps from 0, /clock
  --no-record       without the recorder
  --bag FOLDER      the bag, must not exist yet [bags/planesman_TIME]
  --bin PROGRAM     the planesman program [target/release/planesman]
EOF
}

refuse() {
  echo "run_nodes.sh: $1" >&2
  exit 2
}

# In the order in which they are started; stopped in reverse, so that the recorder hears the last word.
all=(recorder sysid dha_actuator depth_controller plant_sim)
params=$here/params/params.yaml
namespace=/auv
time=real
factor=1.0
sim_time=false
record=true
bag=
bin=$here/../target/release/planesman
nodes=()

while (($# > 0)); do
  case $1 in
    --params | --namespace | --factor | --bag | --bin)
      (($# > 1)) || refuse "$1: its value is missing"
      declare "${1#--}=$2"
      shift
      ;;
    --lockstep) time=lockstep ;;
    --sim-time) sim_time=true ;;
    --no-record) record=false ;;
    -h | --help) usage && exit ;;
    -*) refuse "there is no option '$1' (--help lists them)" ;;
    *)
      [[ " ${all[*]} " == *" $1 "* ]] || refuse "there is no node '$1'; there are ${all[*]}"
      nodes+=("$1")
      ;;
  esac
  shift
done
[[ -x $bin ]] || refuse "there is no program '$bin': build it with 'cargo build --release', or name it with --bin"
[[ -f $params ]] || refuse "there is no parameter file '$params'"
[[ $factor =~ ^[0-9]+(\.[0-9]*)?$ ]] || refuse "--factor: '$factor' is no positive number"
[[ $time == real || $factor =~ ^1(\.0*)?$ ]] || refuse "--factor: lockstep runs as fast as it can"
((${#nodes[@]} > 0)) || nodes=("${all[@]}")
[[ $namespace == /* ]] || namespace=/$namespace

# Who makes the time and who follows it; who waits for whom: these belong together.
lockstep=false members='[]' follow=$sim_time
[[ $factor =~ ^1(\.0*)?$ ]] || follow=true
if [[ $time == lockstep ]]; then
  lockstep=true follow=true members='[sysid]'
  [[ $record == false ]] || members='[sysid, recorder]'
fi
frame_prefix=
[[ $namespace == /auv || $namespace == / ]] || frame_prefix=${namespace#/}/

# arguments_of NODE : sets `arguments` to what these options decide for it, over the parameter file.
arguments_of() {
  local values=()
  case $1 in
    recorder) values=("use_sim_time:=$follow" "answer:=$lockstep" "output:='${bag//\'/\'\'}'") ;;
    sysid) values=("use_sim_time:=$follow" "answer:=$lockstep") ;;
    dha_actuator | depth_controller) values=("use_sim_time:=$follow" "lockstep:=$lockstep" "frame_prefix:='$frame_prefix'") ;;
    plant_sim)
      values=("time:=$time" "factor:=$factor" "sim_time:=$sim_time"
        "lockstep.members:=$members" "frame_prefix:='$frame_prefix'")
      ;;
  esac
  arguments=(-r "__ns:=$namespace" --params-file "$params")
  local value
  for value in "${values[@]}"; do
    arguments+=(-p "$value")
  done
}

# As the planesman launcher has it: nobody beyond this machine, unless the environment says so.
export ROS_AUTOMATIC_DISCOVERY_RANGE=${ROS_AUTOMATIC_DISCOVERY_RANGE:-LOCALHOST}
# A node so started ends when this script is gone, whatever becomes of it.
export PLANESMAN_LAUNCHED=1
# Each node in a process group of its own: Ctrl-C is this script's, which stops them in order.
set -m

names=() pids=()
stopping=false
trap 'stopping=true' INT TERM
for node in "${all[@]}"; do
  [[ " ${nodes[*]} " == *" $node "* ]] || continue
  [[ $node != recorder || $record == true ]] || continue
  arguments_of "$node"
  "$bin" node "$node" --ros-args "${arguments[@]}" < /dev/null &
  names+=("$node") pids+=($!)
done

status=0 ended=
while [[ $stopping == false && -z $ended ]]; do
  wait -n -p ended || status=$?
done
trap '' INT TERM
if [[ $stopping == true ]]; then
  status=0 ended=
fi

for ((i = ${#pids[@]} - 1; i >= 0; i--)); do
  if [[ ${pids[i]} == "$ended" ]]; then
    echo "run_nodes.sh: the node ${names[i]} ended by itself (status $status); stopping the others" >&2
    status=1
  else
    kill -TERM "${pids[i]}" 2> /dev/null || true
    wait "${pids[i]}" || status=1
  fi
done
exit "$status"
