#!/bin/bash
# shellcheck disable=SC2016
#PBS -N {{ name[:15] }}
#PBS -j oe
#PBS -o {{ log }}
{% if array is not none %}
#PBS -t {{ array }}{% if max_running is not none %}%{{ max_running }}{% endif %}

{% endif %}
#PBS -l nodes=1:ppn={{ cpus if cpus is not none else 1 }}{% if gpus is not none %}:gpus={{ gpus }}{% endif %}

{% if mem is not none %}
#PBS -l mem={{ mem }}
{% endif %}
{% if time is not none %}
#PBS -l walltime={{ time }}
{% endif %}
{% if partition is not none %}
#PBS -q {{ partition }}
{% endif %}
{% if account is not none %}
#PBS -A {{ account }}
{% endif %}
#PBS -r {{ "y" if requeue else "n" }}
{% for directive in directives %}
#PBS {{ directive }}
{% endfor %}
set -u
{% if redirect %}
{{ redirect }}
{% endif %}
cd {{ folder }} || exit 1
{% if setup %}
{{ setup }}
{% endif %}
exec {{ command }}
