#!/usr/bin/env bash
# Makes the documentation as a site: build/site/index.html, which opens without a server or a network; .ci/run does so
# too. Warnings are errors. Everything comes from Debian's packages (tools/docs_packages.txt), installed if missing.
set -euo pipefail
cd "$(dirname "$0")/.."

stage_count=4
source tools/stages.sh
python=/usr/bin/python3  # Debian's, which has Debian's Sphinx
work=build/docs

# The repository's folders by links, so that pages keep the places that they have in it, and the generated reference.
mirror() {
  rm -rf "$work/source"
  mkdir -p "$work/source/reference"
  for entry in README.md CHANGELOG.md bodies docs engine examples integrators joints models plugins tests tools; do
    ln -s "$PWD/$entry" "$work/source/$entry"
  done
}
reference() {
  mkdir -p "$work"
  rm -rf "$work"/{doxygen,headers}  # what a header no longer has must not stay
  mkdir -p "$work"/{doxygen,headers}
  "$python" -B tools/docs/doxygen_headers.py "$work/headers" || return
  (cd "$work/headers" && doxygen "$OLDPWD/tools/docs/Doxyfile") || return
  mirror || return
  "$python" -B tools/docs/reference.py . "$work/source/reference" "$work/doxygen/xml"
}
# What MathJax needs to draw TeX as SVG, of Debian's copy.
mathjax() {
  local from=/usr/share/javascript/mathjax to=build/site/_static/mathjax
  mkdir -p "$to"/{config,jax/{input,output/SVG/fonts},extensions}
  cp -L "$from/MathJax.js" "$to/"
  cp -L "$from/config/TeX-AMS_SVG.js" "$to/config/"
  cp -rL "$from/extensions/." "$to/extensions/"
  cp -rL "$from/jax/element" "$to/jax/"
  cp -rL "$from/jax/input/TeX" "$to/jax/input/"
  cp -rL "$from/jax/output/SVG/." "$to/jax/output/SVG/"
  find "$to/jax/output/SVG/fonts" -mindepth 1 -maxdepth 1 ! -name TeX -exec rm -rf {} +
}
pages() {
  rm -rf build/site "$work/doctrees"
  mathjax || return
  LITHE_DOCS_SOURCE=$PWD/$work/source LITHE_DOXYGEN_XML=$PWD/$work/doxygen/xml \
    "$python" -B -m sphinx -q -W --keep-going -j auto -b html -c docs/site -d "$work/doctrees" "$work/source" build/site
}

if [[ ${LITHE_DOCS_PACKAGES:-install} == install ]]; then
  stage_shown "packages" tools/install_packages.sh tools/docs_packages.txt
fi
stage_shown "reference" reference
stage_shown "pages" pages
stage_shown "search and links without a network" "$python" -B tools/docs/site_check.py build/site
echo
echo "The site: $PWD/build/site/index.html"
