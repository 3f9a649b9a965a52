// Dierckx's FITPACK, as SciPy has it, by a script.
#include <cstring>

#include "core/files.h"
#include "core/process.h"
#include "peers.h"

namespace bench {
namespace {

using namespace partscribe::core;

std::string python_with_scipy() {
  Context context;
  for (const std::string& python : {std::string("python3"), std::string("/usr/bin/python3")}) {
    const auto run = run_process({python, "-c", "import scipy.interpolate"}, {}, context);
    if (run && run->exit_code == 0) return python;
  }
  return {};
}

std::string bytes_of(const std::vector<double>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(double)};
}

/// `mean_square`: of the residuals, mm^2.
std::optional<Answer> by_script(const std::string& python, const Question& question, double mean_square,
                                double seconds) {
  Context context;
  const TemporaryDirectory folder;
  const Path input = folder.path() / "input", output = folder.path() / "output";
  std::vector<double> numbers = {double(question.columns), double(question.rows),
                                 mean_square * double(question.points.size())};
  for (const Vec3& p : question.points) numbers.insert(numbers.end(), {p.x(), p.y(), p.z()});
  if (!write_file(input, bytes_of(numbers))) return std::nullopt;
  ProcessLimits limits;
  limits.seconds = 4 * seconds + 10;  // of wall time
  const auto run = run_process(
      {"/usr/bin/env", "OPENBLAS_NUM_THREADS=1", python, PARTSCRIBE_BENCH_FITPACK, input.string(), output.string()},
      limits, context);
  if (!run || run->exit_code != 0) return std::nullopt;
  const auto bytes = read_file(output);
  if (!bytes) return std::nullopt;
  numbers.resize(bytes->size() / sizeof(double));
  std::memcpy(numbers.data(), bytes->data(), numbers.size() * sizeof(double));
  std::size_t next = 2;
  std::vector<double> knots[2];
  for (auto& t : knots) {
    const auto count = std::ptrdiff_t(numbers[next + 1]);
    const auto from = numbers.begin() + std::ptrdiff_t(next) + 2;
    t.assign(from, from + count);
    next += 2 + std::size_t(count);
  }
  if (numbers[0] > seconds) return std::nullopt;
  const std::vector<double> rest(numbers.begin() + std::ptrdiff_t(next), numbers.end());
  return Answer{graph_of(knots[0], knots[1], 3, rest), numbers[0], numbers[1]};
}

}  // namespace

std::vector<Contestant> fitpack(double seconds) {
  const std::string python = python_with_scipy();
  if (python.empty()) return {};
  // The sum of squares that it is to reach: that of the noise, and what is allowed beside it.
  const Ask ask = [=](const Question& question, double allowed) {
    return by_script(python, question, 0.97 * question.sigma * question.sigma + allowed * allowed, seconds);
  };
  return {{"FITPACK regrid", {}, true, false, 3, ask}, {"FITPACK surfit", {}, false, true, 3, ask}};
}

}  // namespace bench
