#!/usr/bin/env bash
# check_archives.sh BUILD SCRATCH: makes the .deb and the tarball, unpacks each into an empty root, makes a project from the
# .deb and runs its scene, and compares the two. Nothing of the build or of the checkout is used then.
set -euo pipefail
build=$1 scratch=$2
rm -rf "$scratch"
mkdir -p "$scratch"
fail() { echo "FAIL: $1" >&2; exit 1; }

cpack --config "$build/CPackConfig.cmake" -B "$scratch/made" > "$scratch/cpack.log" 2>&1 ||
  { cat "$scratch/cpack.log" >&2; fail "cpack"; }
deb=("$scratch"/made/lithe_*.deb)
tarball=("$scratch"/made/lithe-*.tar.gz)
[[ ${#deb[@]} == 1 && -s ${deb[0]} ]] || fail "there is no .deb"
[[ ${#tarball[@]} == 1 && -s ${tarball[0]} ]] || fail "there is no tarball"

mkdir "$scratch/deb" "$scratch/tarball"
dpkg-deb --extract "${deb[0]}" "$scratch/deb"
tar -xzf "${tarball[0]}" -C "$scratch/tarball" --strip-components=1

# What programs and libraries link is named, and so is what compiles a scene.
depends=$(dpkg-deb --field "${deb[0]}" Depends)
for package in libhdf5 libspdlog libsundials libeigen3-dev g++; do
  [[ $depends == *"$package"* ]] || fail "the .deb does not depend on $package: $depends"
done

prefix=$scratch/deb/usr home=$scratch/deb/home
for path in bin/lithe include/lithe/lithe.h include/lithe_headers/engine/plugin.h lib/lithe/plugins/massless_rod.so \
  share/doc/lithe/examples/01_rigid_pendulum.cpp share/doc/lithe/docs/page.md share/doc/lithe/README.md; do
  [[ -e $prefix/$path ]] || fail "$path is not in the .deb"
done
grep -q "$build" "$prefix"/lib/cmake/lithe/*.cmake && fail "the package names the build folder"
diff -rq "$prefix" "$scratch/tarball" >&2 || fail "the tarball holds other files than the .deb"

mkdir "$home"
(
  cd "$home"
  export HOME=$home XDG_CACHE_HOME=$home/.cache LITHE_PRECOMPILED=off PATH=$prefix/bin:/usr/bin:/bin
  lithe new swing
  cd swing
  lithe run ./*.cpp
) > "$scratch/run.log" 2>&1 || { cat "$scratch/run.log" >&2; fail "lithe new, lithe run"; }
tail -n 1 "$scratch/run.log"
(cd "$home" && "$scratch/tarball/bin/lithe" new swing_of_the_tarball > /dev/null) || fail "lithe new of the tarball"
rm -rf "$scratch/deb" "$scratch/tarball"
