#!/bin/bash
# Prints the SHA-256 of what the program computes, to hold against those of another machine (docs/loop.md):
#
#     tests/machines/hashes.sh [--flights] PROGRAM [ARGUMENT...]
#
# PROGRAM ARGUMENT... runs `planesman`, as `target/release/planesman` or `qemu-aarch64 -L /usr/aarch64-linux-gnu PROGRAM`; without --flights
# `planesman-reports` must be beside it (cargo build --release --package planesman-reports).
# Each scenario's bag without what has wall time, a sweep, models from the bag, both reports' numbers.
# tests/machines/expected.txt has what must be printed; with --flights its first ten lines.
set -euo pipefail
flights=false
if [[ ${1-} == --flights ]]; then
    flights=true
    shift
fi
root=$(cd "$(dirname "$0")/../.." && pwd)
program=("$@")
[[ -e ${program[0]} ]] && program[0]=$(realpath "${program[0]}")
if [[ -e ${program[-1]} ]]; then program[-1]=$(realpath "${program[-1]}"); fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

run() { "${program[@]}" "$@" >printed.txt; }
file() { printf '%s  %s\n' "$(sha256sum <"$1" | cut -c -64)" "$2"; }
# A model without its sentences, so that they can be reworded: numbers and codes.
model() { printf '%s  %s\n' "$(sed '/^ *"verdict": \[$/,/\]/d; /^ *"verdict": "/d' "$1" | sha256sum | cut -c -64)" "$2"; }

for scenario in dive open_loop remus_100 way_depths lauv turning_circle zigzag bluerov2; do
    run sim "$scenario" --out "$scenario.mcap"
    run bag info "$scenario.mcap" --sha256
    printf '%s  %s\n' "$(tail -n 1 printed.txt | cut -c -64)" "sim $scenario"
done
run sim "$root/launch-scripts/scenarios/too_fast.yaml" --out too_fast.mcap
run bag info too_fast.mcap --sha256
printf '%s  %s\n' "$(tail -n 1 printed.txt | cut -c -64)" "sim too_fast"

run sweep dive --vary depth_controller.depth.p=0.4..1.6 --samples 3 --seeds 2 --out sweep
file sweep/cases.csv "sweep dive"

if "$flights"; then exit; fi

# The choice of a model, and each estimator that iterates; the vehicle's coefficients; state equations.
signals=(--input plane_motion:dive_planes --output state:pitch_rate)
run sysid fit dive.mcap "${signals[@]}" --model chosen.json
model chosen.json "fit, chosen"
for method in output_error armax n4sid process frf recursive_prediction_error vehicle; do
    options=()
    [[ $method == vehicle ]] && options=(--vehicle brunner --speed 0.64)
    run sysid fit dive.mcap "${signals[@]}" --method "$method" "${options[@]}" --model "$method.json"
    model "$method.json" "fit, $method"
done
run sysid fit dive.mcap --equations "$root/launch-scripts/equations/vehicle.yaml" --json
model printed.txt "fit, equations"
run tune output_error.json --anyway --json
file printed.txt "gains"

# The reports' program stands beside it; what runs it may not run others, as qemu-user does not.
program[-1]=$(dirname "${program[-1]}")/planesman-reports
run reproduce --all
file printed.txt "reports"
