#include "engine/study/chart_study.h"

#include <charconv>
#include <cstdio>

#include "engine/output/partial_file.h"
#include "engine/study/work_precision.h"

namespace lithe {
namespace {

struct Request {
  std::string out, peers;
  std::vector<double> tolerances{1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9};
  std::vector<std::string> methods;
  WorkPrecisionOptions options;
};

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    if (end > begin) parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

double number(const std::string& word, const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size())
    throw SceneError("'" + text + "' is not a number", "lithe chart, " + word, "write numbers like 1e-5");
  return value;
}

std::vector<double> numbers(const std::string& word, const std::string& text) {
  std::vector<double> values;
  for (const std::string& part : split(text)) values.push_back(number(word, part));
  return values;
}

void take(Request& request, const std::string& word) {
  const auto equals = std::min(word.find('='), word.size());
  const std::string key = word.substr(0, equals), text = word.substr(std::min(equals + 1, word.size()));
  WorkPrecisionOptions& options = request.options;
  if (key == "out")
    request.out = text;
  else if (key == "peers")
    request.peers = text;
  else if (key == "methods")
    request.methods = split(text);
  else if (key == "tolerances")
    request.tolerances = numbers(key, text);
  else if (key == "steps")
    options.steps = numbers(key, text);
  else if (key == "samples")
    options.samples = static_cast<int>(number(key, text));
  else if (key == "repeats")
    options.repeats = static_cast<int>(number(key, text));
  else if (key == "limit")
    options.time_limit = number(key, text);
  else if (key == "reference")
    options.reference_tolerance = number(key, text);
  else if (key == "progress")
    options.progress = text == "always" ? Progress::Show::always : Progress::Show::never;
  else
    throw SceneError("'" + word + "' is not known", "lithe chart",
                     "known are out, tolerances, steps, methods, samples, repeats, limit, reference, peers, progress");
}

}  // namespace

void chart_study(const StudyScene& scene, const std::vector<StudyMethod>& methods,
                 const std::vector<StudyMethod>& references, const std::vector<std::string>& words) {
  Request request;
  request.out = "results/charts/" + scene.name;
  request.options.references = references;
  for (const std::string& word : words) take(request, word);
  std::vector<ChartLine> peers;
  if (!request.peers.empty()) peers = read_work_points(request.peers);

  const WorkPrecision result =
      work_precision(scene, select_methods(methods, request.methods), request.tolerances, request.options);
  const std::string table = result.table();
  std::printf("%s", table.c_str());
  result.write_csv(request.out + ".csv");
  PartialFile text(request.out + ".txt");
  text.stream() << table;
  text.commit();
  result.write_chart(request.out, peers);
  std::printf("written: %s.svg, .png, .csv, .txt\n", request.out.c_str());
}

}  // namespace lithe
