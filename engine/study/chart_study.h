#pragma once

#include <string>
#include <vector>

#include "engine/study/study.h"

namespace lithe {

/// What `lithe chart` runs: work_precision() of a scene, its table printed and all of it written to OUT.csv, .txt, .svg
/// and .png. Words, all optional:
///   out=results/charts/NAME           without an extension
///   tolerances=1e-2,1e-4  steps=1e-2,1e-3  methods=runge,alpha  (parts of names)
///   samples=20  repeats=3  limit=60   (s a run)  reference=1e-11  (tolerance)
///   peers=FILE.csv  (read_work_points)  progress=always|never
/// Throws SceneError for a word that is none of these or a number that is none, and what work_precision() throws.
void chart_study(const StudyScene& scene, const std::vector<StudyMethod>& methods,
                 const std::vector<StudyMethod>& references, const std::vector<std::string>& words);

}  // namespace lithe
