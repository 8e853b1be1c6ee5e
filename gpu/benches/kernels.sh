#!/usr/bin/env bash
# Compiled statistics of every kernel on AMD hardware that need not be there, as CSV: gpu/benches/kernels.sh KSTAT >gpu/benches/results/kernels.csv
# KSTAT compiles a WGSL file by naga and Mesa's RADV on null hardware and prints a line of statistics.
set -euo pipefail
kstat=$(realpath "${1:?usage: gpu/benches/kernels.sh KSTAT}")
cd "$(dirname "$0")/../.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The file of a part: one that stands in its stead (name=file), that of the subgroup path, or that of its name, in the kernel's own room first.
part() {
    local swap
    for swap in $swaps; do [ "${swap%%=*}" = "$1" ] && { echo "${swap#*=}"; return; }; done
    local room
    for room in "$kernels" gpu/src/kernels sim/src/gpu render/src/gpu; do
        [ "$path" = subgroups ] && [ -e "$room/$1_subgroup.wgsl" ] && { echo "$room/$1_subgroup.wgsl"; return; }
        [ -e "$room/$1.wgsl" ] && { echo "$room/$1.wgsl"; return; }
    done
    echo "no part $1" >&2
    exit 1
}
# The text with every part in it once.
flatten() {
    local line name
    while IFS= read -r line || [ -n "$line" ]; do
        case $line in
        '#import '*)
            name=${line#\#import }
            [[ " $seen " == *" $name "* ]] || { seen="$seen $name"; flatten "$(part "$name")"; }
            ;;
        *) printf '%s\n' "$line" ;;
        esac
    done <"$1"
}
# A row: name of the kernel, its file, path (plain or subgroups), parts that stand in others' stead.
row() {
    local name=$1 file=$2
    path=$3 swaps=${4:-} seen=
    flatten "$file" >"$work/$name.wgsl"
    bash "$kstat" "$work/$name.wgsl" | awk -v name="$name" -v path="$path" '{
        text = $0
        sub(/^[^ ]+ /, "", text); device = text; sub(/:.*/, "", device); sub(/^[^:]*: /, "", text)
        n = split(text, fields, ", "); line = name "," path "," device
        for (k = 1; k <= n; k++) { sub(/ B$/, "", fields[k]); m = split(fields[k], words, " "); line = line "," words[m] }
        print line
    }'
}
echo "kernel,path,device,instructions,valu,salu,vmem,smem,vgpr,spilled,lds_bytes,waves_per_simd,latency,inverse_throughput"
kernels=gpu/src/kernels
for name in groups scan_add radix_size radix_count segment_sum compact_flag compact_write copy; do row $name $kernels/$name.wgsl plain; done
for name in scan_block radix_scatter reduce_block segment_long; do
    for path in plain subgroups; do row $name $kernels/$name.wgsl $path; done
done
row radix_count_u64 $kernels/radix_count.wgsl plain key=$kernels/key_u64.wgsl
for path in plain subgroups; do row radix_scatter_u64 $kernels/radix_scatter.wgsl $path key=$kernels/key_u64.wgsl; done
kernels=sim/src/gpu
any=
for path in $kernels/*_any.wgsl; do
    name=$(basename "$path" _any.wgsl)
    any="$any $name=$path"
done
# The parts for models with hulls and surfaces.
with=
for part in hulls surfaces triangle; do with="$with $part=$kernels/${part}_with.wgsl"; done
for path in $(grep -l '^@compute' $kernels/*.wgsl); do
    name=$(basename "$path" .wgsl)
    case $name in
    pair_family) continue ;;
    solid_contacts)
        for family in plane ball box convex hull triangle; do
            points="points=$kernels/points_${family/hull/convex}.wgsl"
            swap=
            case $family in hull | triangle) swap=$with ;; esac
            row ${family}_contacts "$kernels/$name.wgsl" plain "$points $swap"
            row ${family}_family "$kernels/pair_family.wgsl" plain family=$kernels/family_$family.wgsl
            [ $family != plane ] || row ${family}_contacts_hulls "$kernels/$name.wgsl" plain "$points $with"
        done
        continue
        ;;
    # The visits of Gauss–Seidel to shapes of any kind alone.
    tile_manifolds | rest_manifolds)
        row "$name" "$kernels/$name.wgsl" plain "$any"
        row "${name}_rolls" "$kernels/$name.wgsl" plain "$any rolls=$kernels/rolls_with.wgsl"
        continue
        ;;
    visit_write)
        row "$name" "$kernels/$name.wgsl" plain "$any"
        continue
        ;;
    esac
    row "$name" "$kernels/$name.wgsl" plain
    # Those to spheres alone.
    case $name in *_sweep | tile_sweep_later | tile_visits) continue ;; esac
    # The same for shapes of any kind, where it differs.
    cp "$work/$name.wgsl" "$work/spheres.wgsl"
    path=plain swaps=$any seen=
    flatten "$kernels/$name.wgsl" >"$work/$name.wgsl"
    cmp -s "$work/$name.wgsl" "$work/spheres.wgsl" || row "${name}_any" "$kernels/$name.wgsl" plain "$any"
    path=plain swaps=$with seen=
    flatten "$kernels/$name.wgsl" >"$work/$name.wgsl"
    cmp -s "$work/$name.wgsl" "$work/spheres.wgsl" || row "${name}_surfaces" "$kernels/$name.wgsl" plain "$with"
    grep -q '^    if ROLLS\|^        if ROLLS' "$work/spheres.wgsl" || continue
    row "${name}_rolls" "$kernels/$name.wgsl" plain rolls=$kernels/rolls_with.wgsl
done
row pair_count $kernels/pair_write.wgsl plain pair_pass=$kernels/pair_count.wgsl
kernels=render/src/gpu
for name in clear_samples clear_nearest sample_nearest part_nearest block_nearest sample_depth uncover sample_id block_depth cap_dice cap_points visible_points point_colors relay sample_colors blur_nearest blur_depth blur_id blur_colors filter \
    layer_count layer_fill layer_total layer_sort layer_points layer_join layer_colors layer_colors_outputs blur_layer_count blur_layer_fill \
    blur_layer_join blur_layer_colors blur_layer_colors_outputs point_outputs sample_outputs blur_outputs filter_outputs; do
    row $name $kernels/$name.wgsl plain
done
