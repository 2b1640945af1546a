#!/bin/bash
# A sweep by GNU parallel, one task for each processor of this machine or, with --sshlogin, of several that share the folder:
#   meniscus sweep make design.toml --out DIR && examples/sweep/parallel.sh DIR
set -euo pipefail
tasks=${2:-$(nproc)}
seq "$tasks" | parallel --jobs "$tasks" meniscus sweep run "$1" --part "{}/$tasks"
meniscus sweep merge "$1"
