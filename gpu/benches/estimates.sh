#!/usr/bin/env bash
# Estimated time of the stages on two GPUs, from bytes and instructions, as CSV: gpu/benches/estimates.sh >gpu/benches/results/estimates.csv
# A stage takes as long as its columns take to move at the copy bandwidth, or its vector instructions to issue, whichever is longer, and its
# dispatches besides. What is assumed of each stands below; what one was measured at is in README.md.
set -euo pipefail
cd "$(dirname "$0")/results"
awk -F, '
# Vector instructions of a kernel, one to a lane and row; loops count once.
NR == FNR { if ($2 == "plain") valu[$1] = $5; next }
FNR == 1 {
    # Copy bandwidth, bytes/s; instructions of 32 lanes issued a second; seconds of a dispatch.
    name[1] = "H200"; bandwidth[1] = 4.3e12; issue[1] = 132 * 4 * 1.7e9; dispatch[1] = 3e-6
    name[2] = "RX 7900 XTX"; bandwidth[2] = 0.85e12; issue[2] = 192 * 2.3e9; dispatch[2] = 3e-6
    print "workload,stage,rows,bytes,vector_instructions,dispatches,gpu,milliseconds,bound_by"
}
{
    # Workload, stage, rows, bytes a row, kernels, dispatches.
    n = split($5, kernels, " "); instructions = 0
    for (k = 1; k <= n; k++) {
        if (!(kernels[k] in valu)) { print "no kernel " kernels[k] >"/dev/stderr"; exit 1 }
        instructions += valu[kernels[k]]
    }
    for (g = 1; g <= 2; g++) {
        moves = $3 * $4 / bandwidth[g]; issues = $3 / 32 * instructions / issue[g]; calls = $6 * dispatch[g]
        most = moves > issues ? moves : issues
        bound = calls > most ? "dispatches" : (moves > issues ? "memory" : "arithmetic")
        printf "%s,%s,%d,%d,%d,%d,%s,%.3f,%s\n", $1, $2, $3, $4, instructions, $6, name[g], 1e3 * (most + calls), bound
    }
}' kernels.csv <(
    for spheres in 84000 1000000; do
        # 2.9 pairs and 2.8 contacts of a sphere.
        pairs=$((spheres * 29 / 10)) contacts=$((spheres * 28 / 10))
        cat <<ROWS
S $spheres,bounds,$spheres,80,bounds,1
S $spheres,contact_write: pairs held,$pairs,24,contact_find,8
S $spheres,contact_write: contacts,$contacts,72,contact_write,3
S $spheres,Jacobi iteration,$contacts,202,jacobi_contact jacobi_body,2
S $spheres,APGD trial,$contacts,257,apgd_contact apgd_body,4
S $spheres,Gauss–Seidel pass of four sweeps,$contacts,148,tile_sweep,5
ROWS
    done
    cat <<'ROWS'
mixed 100000,narrow phase: boxes,100000,120,box_contacts,2
mixed 100000,narrow phase: convex,900000,120,convex_contacts,2
mixed 100000,Gauss–Seidel pass of two sweeps,600000,234,tile_manifolds,6
ROWS
)
