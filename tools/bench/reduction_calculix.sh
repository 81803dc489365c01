#!/bin/sh
# The reduction against CalculiX's own *FREQUENCY, same mesh, one thread each:
#   tools/bench/reduction_calculix.sh PROGRAM [DOFS] [MODES]      PROGRAM: build/<preset>/tools/bench/reduction
# Prints time and memory of both, and the first elastic frequencies. Needs ccx and GNU time.
set -eu
program=$(realpath "$1")
dofs=${2:-60000}
modes=${3:-30}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
"$program" "$dofs" "$modes" 0 block.inp
/usr/bin/time -f 'calculix: %e s wall, %U s user, %M KiB' ccx block > calculix.log 2> calculix.time
tail -1 calculix.time
awk '/E I G E N V A L U E   O U T P U T/ {on = 1} on && $1 > 6 && NF >= 4 && $1 <= 9 {print "  mode " $1 - 6 ": " $4 " Hz"}
     /P A R T I C I P A T I O N/ {exit}' block.dat
/usr/bin/time -f 'lithe:    %e s wall, %U s user, %M KiB' "$program" "$dofs" "$modes" 0
