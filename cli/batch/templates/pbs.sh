#!/bin/bash
# shellcheck disable=SC2016
#PBS -N {{ name[:15] }}
#PBS -j oe
#PBS -o {{ log }}
{% if array is not none %}
#PBS -J {{ first }}-{{ last }}{% if max_running is not none %}%{{ max_running }}{% endif %}

{% endif %}
#PBS -l select=1:ncpus={{ cpus if cpus is not none else 1 }}{% if mem is not none %}:mem={{ mem }}{% endif %}{% if gpus is not none %}:ngpus={{ gpus }}{% endif %}

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
