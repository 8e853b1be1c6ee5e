#!/bin/bash
# shellcheck disable=SC2016
#SBATCH --job-name={{ name }}
#SBATCH --output={{ log }}
#SBATCH --open-mode=append
{% if array is not none %}
#SBATCH --array={{ array }}{% if max_running is not none %}%{{ max_running }}{% endif %}

{% endif %}
#SBATCH --nodes=1
#SBATCH --ntasks=1
{% if cpus is not none %}
#SBATCH --cpus-per-task={{ cpus }}
{% endif %}
{% if gpus is not none %}
#SBATCH --gres=gpu:{{ gpus }}
{% endif %}
{% if time is not none %}
#SBATCH --time={{ time }}
{% endif %}
{% if mem is not none %}
#SBATCH --mem={{ mem }}
{% endif %}
{% if partition is not none %}
#SBATCH --partition={{ partition }}
{% endif %}
{% if account is not none %}
#SBATCH --account={{ account }}
{% endif %}
{% if requeue %}
#SBATCH --requeue
#SBATCH --signal=B:USR1@30
{% else %}
#SBATCH --no-requeue
{% endif %}
{% for directive in directives %}
#SBATCH {{ directive }}
{% endfor %}
set -u
{% if redirect %}
{{ redirect }}
{% endif %}
cd {{ folder }} || exit 1
{% if setup %}
{{ setup }}
{% endif %}
{% if requeue %}
# A signal before the time limit comes to this shell: the task that it interrupts is queued again, one that was cancelled is not.
{{ command }} &
task=$!
again=no
trap 'again=yes; kill -TERM "$task"' USR1
trap 'kill -TERM "$task"' TERM
wait "$task"
status=$?
while kill -0 "$task" 2>/dev/null; do
    wait "$task"
    status=$?
done
if [ "$status" -eq 130 ] && [ "$again" = yes ]; then
    if [ "${SLURM_RESTART_COUNT:-0}" -lt 100 ]; then
        scontrol requeue "$SLURM_JOB_ID"
    else
        echo "error: it has been queued 100 times and never ended within its time: submit it with a longer --time" >&2
    fi
fi
exit "$status"
{% else %}
exec {{ command }}
{% endif %}
