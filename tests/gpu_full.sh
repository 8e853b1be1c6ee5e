#!/usr/bin/env bash
# The long tests of the GPU back end, minutes on a software adapter: beds that settle, and every model of the library that it can simulate,
# whole, against the CPU's centre of mass and spread: within 1 %, or within twice of what 1e-10 m/s² sideways change on the CPU, where
# bodies scatter. Usage: tests/gpu_full.sh SCREE [ADAPTER [MODEL ...]]; with models, only these are run.
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
    gravity=$(sed -n 's/^gravity: \[0, 0, \(.*\)\]/\1/p' "sim/models/$model.yaml")
    for backend in cpu gpu nearly; do
        case $backend in
        cpu) choice=(--backend cpu) ;;
        gpu) choice=(--backend gpu --adapter "$adapter") ;;
        nearly) choice=(--backend cpu --set "gravity=[1e-10, 0, ${gravity:--9.81}]") ;;
        esac
        # A warning of the run, exit code 5, is no failure of the back end.
        code=0
        "$scree" simulate "sim/models/$model.yaml" -o "$work/$model-$backend" --csv "${choice[@]}" >/dev/null 2>"$work/log" || code=$?
        [ "$code" = 0 ] || [ "$code" = 5 ] || { cat "$work/log"; exit 1; }
        [ "$backend" = nearly ] || codes+=" $code"
        echo "$model $backend: exit $code, centre and spread $(means "$work/$model-$backend")"
    done
    [ "${codes% *}" = " ${codes##* }" ] || { echo "$model: warnings on one back end alone"; failed=1; }
    paste -d' ' <(means "$work/$model-cpu") <(means "$work/$model-gpu") <(means "$work/$model-nearly") | awk -v model="$model" '{
        for (k = 1; k <= 3; k++) { off += ($k - $(k + 4)) ^ 2; own += ($k - $(k + 8)) ^ 2 }
        off = sqrt(off) / $4; own = 2 * sqrt(own) / $4
        wide = $8 / $4 - 1; own_wide = 2 * ($12 / $4 - 1)
        if (wide < 0) wide = -wide
        if (own_wide < 0) own_wide = -own_wide
        allowed = 0.01; if (own > allowed) allowed = own
        allowed_wide = 0.01; if (own_wide > allowed_wide) allowed_wide = own_wide
        printf "%s: centre %.4f of the spread apart (allowed %.4f), spread %.4f (%.4f)\n", model, off, allowed, wide, allowed_wide
        exit (off > allowed || wide > allowed_wide)
    }' || { echo "$model: the heaps differ by more"; failed=1; }
done
exit $failed
