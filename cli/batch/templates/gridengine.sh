#!/bin/bash
# shellcheck disable=SC2016
#$ -S /bin/bash
#$ -N {{ name }}
#$ -j y
#$ -o {{ log }}
{% if array is not none %}
#$ -t {{ first + 1 }}-{{ last + 1 }}
{% if max_running is not none %}
#$ -tc {{ max_running }}
{% endif %}
{% endif %}
{% if cpus is not none %}
#$ -pe smp {{ cpus }}
{% endif %}
{% if gpus is not none %}
#$ -l gpu={{ gpus }}
{% endif %}
{% if mem is not none %}
#$ -l h_vmem={{ mem }}
{% endif %}
{% if time is not none %}
#$ -l h_rt={{ time }}
{% endif %}
{% if partition is not none %}
#$ -q {{ partition }}
{% endif %}
{% if account is not none %}
#$ -P {{ account }}
{% endif %}
#$ -r {{ "y" if requeue else "n" }}
{% for directive in directives %}
#$ {{ directive }}
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
