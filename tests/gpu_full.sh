#!/usr/bin/env bash
# The long tests of the GPU back end, minutes on a software adapter: beds that settle, and every model of the library that it can simulate,
# whole, against the CPU's centre of mass and spread. Usage: tests/gpu_full.sh SCREE [ADAPTER [MODEL ...]]; with models, only these are run.
set -euo pipefail
scree=$(realpath "${1:?usage: tests/gpu_full.sh SCREE [ADAPTER [MODEL ...]]}")
adapter=${2:-0}
models=("${@:3}")
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if [ ${#models[@]} = 0 ]; then
    models=(anchor card_house crater heap hopper incline pendulums pour quickstart tracked_vehicle wall)
    REQUIRE_GPU=1 cargo test --release -p sim --lib -- --ignored --nocapture gpu::
fi
# Mean of each coordinate of the last frame, and the root mean square distance from there: bodies that collide go other ways in time, so that
# single ones are no measure, and centres are compared by the spread.
means() {
    local frames=("$1"/frames/*.csv)
    awk -F, 'NR == 1 { for (k = 1; k <= NF; k++) if ($k ~ /^pos_[xyz]/) column[++n] = k; next }
        { for (k = 1; k <= n; k++) { sum[k] += $column[k]; square += $column[k] ^ 2 } }
        END { for (k = 1; k <= n; k++) { mean = sum[k] / (NR - 1); square -= mean ^ 2 * (NR - 1); printf "%.6f ", mean }
            printf "%.6f\n", sqrt(square / (NR - 1)) }' "${frames[-1]}"
}
failed=0
for model in "${models[@]}"; do
    codes=
    for backend in cpu gpu; do
        choice=(--backend "$backend")
        [ "$backend" = cpu ] || choice+=(--adapter "$adapter")
        # A warning of the run, exit code 5, is no failure of the back end.
        code=0
        "$scree" simulate "sim/models/$model.yaml" -o "$work/$model-$backend" --csv "${choice[@]}" >/dev/null 2>"$work/log" || code=$?
        [ "$code" = 0 ] || [ "$code" = 5 ] || { cat "$work/log"; exit 1; }
        codes+=" $code"
        echo "$model $backend: exit $code, centre and spread $(means "$work/$model-$backend")"
    done
    [ "${codes% *}" = " ${codes##* }" ] || { echo "$model: warnings on one back end alone"; failed=1; }
    paste -d' ' <(means "$work/$model-cpu") <(means "$work/$model-gpu") | awk -v model="$model" '{
        off = 0
        for (k = 1; k <= 3; k++) off += ($k - $(k + 4)) ^ 2
        if (off > (0.01 * $4) ^ 2 || ($4 / $8 - 1) ^ 2 > 0.01 ^ 2) { print model ": the heaps differ by more than 1 %"; exit 1 }
    }' || failed=1
done
exit $failed
