#!/usr/bin/env bash
# Makes the small files here that programs write: one tetrahedron by CalculiX (ccx 2.20) and by gmsh, as the readers' fuzz
# corpus (tools/fuzz.sh), and the mode shapes of the pendulum's 'paper' body, pendulum_paper.frd. brick.sid is
# write_sid() of corpus/gmsh/box_1_1_41 in steel: mean axes, two modes; corpus/sid/brick is the same with single blanks.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

mesh='*NODE, NSET=ALL
1, 0, 0, 0
2, 0.1, 0, 0
3, 0, 0.1, 0
4, 0, 0, 0.1
*ELEMENT, TYPE=C3D4, ELSET=EALL
1, 1, 2, 3, 4
*MATERIAL, NAME=STEEL
*ELASTIC
2.1e11, 0.3
*DENSITY
7850
*SOLID SECTION, ELSET=EALL, MATERIAL=STEEL
*NSET, NSET=TIP
4
*STEP'
printf '%s\n*FREQUENCY, SOLVER=MATRIXSTORAGE\n1\n*END STEP\n' "$mesh" >tet.inp
ccx tet >/dev/null || true
printf '%s\n*FREQUENCY\n8\n*NODE FILE\nU\n*END STEP\n' "$mesh" >modes.inp
ccx modes >/dev/null

pack() {  # files of one job as one input: "=== name", then the text
  for file in "$@"; do
    echo "=== ${file#*:}"
    cat "${file%%:*}"
  done
}
mkdir -p "$here"/corpus/{calculix,frd,gmsh,matrix_market,sid}
pack tet.inp:inp tet.sti:sti tet.mas:mas tet.dof:dof >"$here/corpus/calculix/tetrahedron"
pack modes.frd:frd >"$here/corpus/frd/tetrahedron"

# The same matrices as tables.
market() {
  echo "%%MatrixMarket matrix coordinate real symmetric"
  echo "12 12 $(wc -l <"$1")"
  awk '{ print ($1 > $2 ? $1 : $2), ($1 > $2 ? $2 : $1), $3 }' "$1"
}
market tet.sti >K
market tet.mas >M
printf 'node,x,y,z\n1,0,0,0\n2,0.1,0,0\n3,0,0.1,0\n4,0,0,0.1\n' >nodes
printf 'set,position,node\ntip,1,4\n' >sets
printf 'element,n1,n2,n3,n4\n1,1,2,3,4\n' >elements
pack K:K M:M nodes:nodes sets:sets elements:elements >"$here/corpus/matrix_market/tetrahedron"

# The same again as other codes would write it, from the descriptions in ../formats/README.md.
mkdir -p "$here"/corpus/{abaqus,ansys,nastran,op4}
labels='{ a = $1 - 1; b = $2 - 1; print int(a / 3) + 1 ",", a % 3 + 1 ",", int(b / 3) + 1 ",", b % 3 + 1 ",", $3 }'
awk "$labels" tet.sti >K.labels
awk "$labels" tet.mas >M.labels
pack tet.inp:inp K.labels:K M.labels:M >"$here/corpus/abaqus/labels"
pack tet.inp:inp tet.sti:K tet.mas:M >"$here/corpus/abaqus/coordinate"
printf '%s\n' '%%MatrixMarket matrix array integer general' '4 1' 1 2 3 4 >back
printf '%8d%20.13f%20.13f%20.13f\n' 1 0 0 0 2 0.1 0 0 3 0 0.1 0 4 0 0 0.1 >nwrite
pack K:K M:M back:mapping nwrite:nodes >"$here/corpus/ansys/matrix_market"
{  # Harwell-Boeing of a diagonal matrix, twelve rows
  printf '%-72s%8s\n%14d%14d%14d%14d%14d\n' tetrahedron 1 30 13 12 12 0
  printf '%-14s%14d%14d%14d%14d\n%-16s%-16s%-20s%-20s\n' RSA 12 12 12 0 '(I14)' '(I14)' '(d25.15)' '(d25.15)'
  for i in $(seq 13) $(seq 12); do printf '%14d\n' "$i"; done
  for i in $(seq 12); do printf '%25s\n' 0.125000000000000D+01; done
} >diagonal
awk 'BEGIN { print "    Matrix Eqn          Node    DOF"; split("UX UY UZ", d)
  for (i = 0; i < 12; ++i) printf "%14d%14d    %s\n", i + 1, int(i / 3) + 1, d[i % 3 + 1] }' >mapping
pack diagonal:K diagonal:M mapping:mapping nwrite:nodes >"$here/corpus/ansys/harwell_boeing"
bulk() {
  printf '%s\n' 'SOL 103' 'CEND' 'BEGIN BULK' 'GRID,1,,0.,0.,0.' 'GRID,2,,.1,0.,0.' 'GRID,3,,0.,.1,0.' 'GRID,4,,0.,0.,.1'
  printf '%s\n' 'CTETRA,1,1,1,2,3,4'
}
dmig() {
  printf 'DMIG,%s,0,6,2,0,,,12\n' "$1"
  awk -v name="$1" '{ a = $1 - 1; b = $2 - 1
    printf "DMIG,%s,%d,%d,,%d,%d,%.9e\n", name, int(b / 3) + 1, b % 3 + 1, int(a / 3) + 1, a % 3 + 1, $3 }' "$2"
}
{ bulk; dmig KAAX tet.sti; dmig MAAX tet.mas; echo ENDDATA; } >dmig.bdf
pack dmig.bdf:bdf >"$here/corpus/nastran/dmig"
{ bulk; echo ENDDATA; } >bulk.bdf
for op4 in text_dense text_sparse text_bigmat dense_double_le_32 sparse_double_be_64 bigmat_single_le_32; do
  pack bulk.bdf:bdf "$here/../formats/nastran/small_$op4.op4:op4" >"$here/corpus/op4/$op4"
done

# gmsh: boxes of few elements, in both versions and all element types.
cat >box.geo <<'G'
Point(1) = {0, 0, 0, 1}; Point(2) = {0.1, 0, 0, 1}; Point(3) = {0.1, 0.1, 0, 1}; Point(4) = {0, 0.1, 0, 1};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Transfinite Curve{1:4} = 2; Transfinite Surface{1};
If(bricks)
  Recombine Surface{1};
  out[] = Extrude {0, 0, 0.1} { Surface{1}; Layers{1}; Recombine; };
Else
  out[] = Extrude {0, 0, 0.1} { Surface{1}; Layers{1}; };
EndIf
Physical Volume("Steel") = {out[1]};
Physical Surface("Root") = {1};
Physical Point("Corner") = {1};
Mesh.SecondOrderIncomplete = 1;
G
for bricks in 0 1; do
  for order in 1 2; do
    for version in 22 41; do
      gmsh -3 -setnumber bricks $bricks -order $order -format msh$version box.geo -o box.msh >/dev/null
      pack box.msh:msh >"$here/corpus/gmsh/box_${bricks}_${order}_$version"
    done
  done
done

deck=$here/../../../examples/data/pendulum/paper/calculix/matrices.inp
sed '/^\*FREQUENCY/,$d' "$deck" >paper.inp
printf '*FREQUENCY\n12\n*NODE FILE\nU\n*END STEP\n' >>paper.inp
ccx paper >/dev/null
# Without the host, user and date of the run.
sed -E '/^    1U(USER|DATE|TIME|HOST|DIR)/d' paper.frd >"$here/pendulum_paper.frd"
