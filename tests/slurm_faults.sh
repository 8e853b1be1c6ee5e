#!/usr/bin/env bash
# What becomes of a film whose tasks, nodes, disk, images, submitters or controller fail, on a private Slurm cluster of four nodes on this
# machine: after `scree resume` each image must be, bit for bit, that of a single run, with no temporary files left.
#   tests/slurm_faults.sh [SCREE]     a table of the faults and what came of them; exit code 1 if anything was lost
# It wants what cluster.sh wants, and root, for a disk that fills up.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
scree=$(realpath "${1:-scree}")
work=$(mktemp -d /tmp/slurm_faults.XXXXXX)
chmod 755 "$work"
cluster="$here/slurm/cluster.sh"
export SLURM_CONF=$work/cluster/slurm.conf
faults=0

# shellcheck disable=SC2317
end() {
    scancel --me >/dev/null 2>&1 || true
    bash "$cluster" down "$work/cluster" || true
    mountpoint -q "$work/small" && umount -l "$work/small"
    if [ "$faults" = 0 ]; then rm -rf "$work"; else echo "what was made is in $work"; fi
}
trap end EXIT

cat >"$work/stones.yaml" <<'MODEL'
step: 0.002
duration: 0.75
frame_rate: 20
materials: {stone: {density: 2600, friction: 0.5}}
bodies:
  - {name: ground, material: stone, plane: {normal: [0, 0, 1]}}
  - {name: block, material: stone, box: {size: [0.2, 0.2, 0.2]}, position: [0, 0, 0.3], velocity: [0.4, 0, 0]}
  - {name: stone, material: stone, sphere: {radius: 0.1}, position: [0.3, 0.05, 0.6]}
MODEL
picture=(--res 400x225 --samples 4)

# Wait until the queue is empty. Slurm misses a task whose end was lost with the controller when the node reports its jobs again, up to
# 200 s later (each twentieth ping; a ping each third of SlurmdTimeout): six minutes, then.
drain() {
    local since=$SECONDS
    while [ $((SECONDS - since)) -lt 360 ]; do
        [ -z "$(squeue -h 2>/dev/null || echo asking)" ] && return 0
        sleep 0.1
    done
    echo "the queue does not end:" >&2
    squeue >&2
    return 1
}

# Wait until a film has some images, and is not done.
begun() {
    local _
    for _ in $(seq 600); do
        [ "$(find "$1/images" -name '*.png' 2>/dev/null | wc -l)" -ge 2 ] && return 0
        sleep 0.05
    done
    return 1
}

film() { # DIR FLAGS…: submit the film of the run, into DIR
    local home=$1
    shift
    "$scree" submit "$work/data.yaml" -o "$home" --scheduler slurm --cpus 1 --threads 1 "${picture[@]}" "$@" >/dev/null 2>&1
}

check() { # NAME DIR: that nothing was lost
    local name=$1 home=$2 frame lost=0 result
    for frame in "$work"/reference/*.png; do
        cmp -s "$frame" "$home/images/$(basename "$frame")" || lost=$((lost + 1))
    done
    local left verified=yes
    left=$(find "$home" -name '.part-*' | wc -l)
    "$scree" verify "$home" >/dev/null 2>&1 || verified=no
    local movie=yes
    find "$home" -maxdepth 1 -name 'data.*' | grep -q . || movie=no
    result="all images as of a single run"
    if [ "$lost" != 0 ] || [ "$left" != 0 ] || [ "$verified" = no ] || [ "$movie" = no ]; then
        result="LOST: $lost images differ, $left temporary files, verified: $verified, movie: $movie"
        faults=$((faults + 1))
    fi
    printf '| %-44s | %-30s | %3d s |\n' "$name" "$result" "$((SECONDS - began))"
}

"$scree" simulate "$work/stones.yaml" -o "$work/run" >/dev/null 2>&1
sed "s|run: .*|run: '$work/run'|" "$work/run/metadata.yaml" >"$work/data.yaml"
"$scree" render "$work/data.yaml" -o "$work/reference" "${picture[@]}" >/dev/null 2>&1
bash "$cluster" up "$work/cluster" 4 1
printf '| %-44s | %-30s | %5s |\n' "fault" "after scree resume" "time"

began=$SECONDS
film "$work/none"
drain
check "none" "$work/none"

began=$SECONDS
film "$work/cut" --buckets 2 --frames-per-task 3
drain
check "none; images cut to 2, three a task" "$work/cut"

began=$SECONDS
film "$work/killed"
begun "$work/killed"
pkill -KILL -f "task $work/killed draw" || true
drain
"$scree" resume "$work/killed" >/dev/null 2>&1
drain
check "tasks killed in the middle (SIGKILL)" "$work/killed"

began=$SECONDS
film "$work/cancelled"
begun "$work/cancelled"
scancel --me
drain
"$scree" resume "$work/cancelled" >/dev/null 2>&1
drain
check "all tasks cancelled" "$work/cancelled"

began=$SECONDS
film "$work/node" --requeue
begun "$work/node"
scontrol update nodename=node2 state=down reason=test
sleep 1
# It may have come back by itself.
scontrol update nodename=node2 state=resume 2>/dev/null || true
drain
"$scree" resume "$work/node" >/dev/null 2>&1
drain
check "a node set down; its tasks are queued again" "$work/node"

began=$SECONDS
mkdir -p "$work/small"
if mount -t tmpfs -o size=700k tmpfs "$work/small" 2>/dev/null; then
    film "$work/small/film"
    drain
    mount -o remount,size=200m "$work/small"
    "$scree" resume "$work/small/film" >/dev/null 2>&1
    drain
    check "a disk that is full" "$work/small/film"
else
    echo "no tmpfs can be mounted here: the disk that is full is left out"
fi

began=$SECONDS
film "$work/damaged"
drain
printf 'torn' | dd of="$work/damaged/images/000003.png" bs=1 seek=200 conv=notrunc status=none
truncate -s 1000 "$work/damaged/images/000007.png"
echo '{' >"$work/damaged/images/.ledger/000009.png.json"
if "$scree" verify "$work/damaged" >/dev/null 2>&1; then
    echo "verify does not see what is damaged"
    faults=$((faults + 1))
fi
"$scree" resume "$work/damaged" >/dev/null 2>&1
drain
check "two images and a ledger's entry damaged" "$work/damaged"

began=$SECONDS
film "$work/two" &
film "$work/two" || true
wait
drain
check "two submitters at once" "$work/two"

began=$SECONDS
film "$work/restart"
begun "$work/restart"
bash "$cluster" controller "$work/cluster"
drain
"$scree" resume "$work/restart" >/dev/null 2>&1
drain
check "the controller restarted" "$work/restart"

exit $((faults > 0))
