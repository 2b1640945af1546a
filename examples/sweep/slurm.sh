#!/bin/bash
# A sweep as a job array of Slurm:
#   meniscus sweep make design.toml --out DIR && sbatch --array=1-8 examples/sweep/slurm.sh DIR
# A task that is lost is run again by the same command; then `meniscus sweep merge DIR`.
#SBATCH --ntasks=1
#SBATCH --output=/dev/null
exec meniscus sweep run "$1"
