#!/usr/bin/env bash
# Some tests of each folder under valgrind's memcheck, which sees what the sanitizers do not: decisions by memory that
# was never written, in the packages too.
#   tools/valgrind.sh [FOLDER...]     LITHE_BUILD=build/gcc: of another build than that of the preset `v2`
# Not of `release`: valgrind 3.19 does not know one way in which Clang 16 writes vmovq (C5 79 D6, between registers).
# Exit code 1 where memcheck reports an error, or a test fails. Left out: hardening_test, which has a malloc of its own.
# What is not ours to fix is in tests/support/valgrind.supp, each with its reason.
set -euo pipefail
cd "$(dirname "$0")/.."
build=${LITHE_BUILD:-build/v2}
declare -A suites=(
  [engine]="Dual Rotations CubicSpline Lanes BandedCholesky LinearBlock PlainFrames ComplexFactor ConeSolver ConeProblem
    GaussSeidel DirectConeSolver JointFrictionProblem ForwardDynamics MotionLaws JointCoordinates SceneErrors GaussRule
    event recorder sensors TotalReaction output_csv output_table RunFile MeshField simulation simulation_islands
    equilibrium kinematics linearization Certificate SolvePace"
  [bodies]="RigidBody BeamStatics CraigBampton Fidelity InertiaIntegrals StressRecovery Shapes SeveralFrames PointMass
    Rainflow CalculixDeck Hdf5File"
  [joints]="RevoluteJoint UniversalJoint SphericalJoint GearPair RedundantRows ContactSurfaces ContactFriction Rope
    SpringDamper ControlDiagram MagicFormula RollerBearing TyreTerrain"
  [integrators]="CheckpointFile Contact RigidContact CompliantContact GeneralizedAlphaOrder LieBdf RadauStep RungeKutta8
    RestartOfRigidContact StabilizedIndex2 Adams"
  [models]="AdamsFunctions AdamsJoints Mjcf Sdf Tir UrdfErrors"
  [gradient]="StaticGradient Minimize"
  [plugins]="JointFromC NameErrors ParameterErrors PluginChecks")
order=(engine bodies joints integrators models gradient plugins)
[ $# -gt 0 ] && order=("$@")
bad=0
mkdir -p build/valgrind
[ -d "$build/tests" ] || { echo "$build has no tests: tools/everywhere.sh v2 builds them" >&2; exit 2; }
for folder in "${order[@]}"; do
  [ -n "${suites[$folder]:-}" ] || { echo "no folder '$folder': give some of ${!suites[*]}" >&2; exit 2; }
  filter=$(printf '%s.*:*/%s.*:' $(for suite in ${suites[$folder]}; do echo "$suite $suite"; done))
  log=build/valgrind/$folder.log result=0
  # OpenMP, MPI and Boost's threads would be run by turns anyway: one thread.
  OMP_NUM_THREADS=1 valgrind --quiet --error-exitcode=9 --suppressions=tests/support/valgrind.supp \
    --num-callers=30 "$(find "$build/tests" -name "${folder}_test" -type f)" --gtest_filter="$filter" --gtest_brief=1 >"$log" 2>&1 || result=$?
  ran=$(sed -n 's/^\[==========\] \([0-9]* tests\) from.* ran.*/\1/p' "$log")
  reports=$(grep -c '^==[0-9]*==    at ' "$log" || true)
  echo "$folder: ${ran:-no tests} ran, $reports errors, exit code $result"
  [ $result -eq 0 ] && [ -n "$ran" ] || { bad=1; tail -60 "$log"; }
done
exit $bad
