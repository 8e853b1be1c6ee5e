#!/usr/bin/env bash
# The long tests of the GPU back end, minutes on a software adapter: beds that settle, and every model of the library that it can simulate,
# whole, against the CPU's centre of mass and spread: within 1 %, or within twice of the most that 1, 2 or 3e-10 m/s² sideways change on the
# CPU, where bodies scatter. A run may end with a warning (exit code 5) where one of these four does.
# Usage: tests/gpu_full.sh SCREE [ADAPTER [MODEL ...]]; with models, only these are run. Its output is kept in gpu/benches/results/models.txt.
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
"$scree" doctor | grep -F "adapter $adapter:"
failed=0
for model in "${models[@]}"; do
    codes=()
    gravity=$(sed -n 's/^gravity: \[0, 0, \(.*\)\]/\1/p' "sim/models/$model.yaml")
    for run in cpu gpu nearly1 nearly2 nearly3; do
        case $run in
        cpu) choice=(--backend cpu) ;;
        gpu) choice=(--backend gpu --adapter "$adapter") ;;
        nearly*) choice=(--backend cpu --set "gravity=[${run#nearly}e-10, 0, ${gravity:--9.81}]") ;;
        esac
        code=0
        "$scree" simulate "sim/models/$model.yaml" -o "$work/$model-$run" --csv "${choice[@]}" >/dev/null 2>"$work/log" || code=$?
        [ "$code" = 0 ] || [ "$code" = 5 ] || { cat "$work/log"; exit 1; }
        if [ $run = gpu ]; then of_gpu=$code; else codes+=("$code"); fi
        echo "$model $run: exit $code, centre and spread $(means "$work/$model-$run")"
    done
    [[ " ${codes[*]} " == *" $of_gpu "* ]] || { echo "$model: exit $of_gpu on the device, ${codes[*]} on the CPU"; failed=1; }
    for run in gpu nearly1 nearly2 nearly3; do echo "$(means "$work/$model-cpu") $(means "$work/$model-$run")"; done | awk -v model="$model" '{
        sum = 0
        for (k = 1; k <= 3; k++) sum += ($k - $(k + 4)) ^ 2
        centre = sqrt(sum) / $4
        spread = $8 / $4 - 1; if (spread < 0) spread = -spread
        if (NR == 1) { off = centre; wide = spread; allowed = allowed_wide = 0.01; next }
        if (2 * centre > allowed) allowed = 2 * centre
        if (2 * spread > allowed_wide) allowed_wide = 2 * spread
    } END {
        printf "%s: centre %.4f of the spread apart (allowed %.4f), spread %.4f (%.4f)\n", model, off, allowed, wide, allowed_wide
        exit (off > allowed || wide > allowed_wide)
    }' || { echo "$model: the heaps differ by more"; failed=1; }
done
exit $failed
