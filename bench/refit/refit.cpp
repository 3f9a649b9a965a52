/// All numbers of a part of many features at once: seconds, and how near they come to the truth.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>

#include "fit/input/prepare.h"
#include "fit/refine/refine.h"
#include "testing/sampled.h"

using namespace partscribe::fit;
using namespace partscribe::testing;

namespace {

const char* usage = "usage: refit [--points N] [--holes N] [--threads N]\n";

Parameter length(const std::string& name, double value) {
  Parameter p;
  p.name = name, p.value = p.fitted = value;
  return p;
}

/// A block of 300 x 200 x 40 with counterbored holes, each with a place and sizes of its own.
Candidate drilled_block(int holes) {
  Candidate c;
  c.procedure = "body with holes", c.object_name = "drilled_block";
  c.parameters = {length("length", 300), length("width", 200), length("height", 40)};
  Object block{"block", Box{Expr::of("length"), Expr::of("width"), Expr::of("height")}, {}, {}, ""};
  c.steps = {block};
  Difference cut;
  cut.objects = {"block"};
  constexpr int columns = 5;
  const int rows = (holes + columns - 1) / columns;
  for (int i = 0; i < holes; ++i) {
    const std::string name = "hole_" + std::to_string(i + 1);
    const double grow = 1 + 0.02 * i;
    c.parameters.push_back(length(name + "_x", 300.0 * (i % columns + 0.5) / columns + 1.3 * (i % 3)));
    c.parameters.push_back(length(name + "_y", 200.0 * (i / columns + 0.5) / rows - 0.9 * (i % 4)));
    c.parameters.push_back(length(name + "_d", 9 * grow));
    c.parameters.push_back(length(name + "_head_d", 16 * grow));
    c.parameters.push_back(length(name + "_head_depth", 8 * grow));
    Hole hole;
    hole.diameter = Expr::of(name + "_d"), hole.depth = Expr::of("height"), hole.through = true;
    hole.head_diameter = Expr::of(name + "_head_d"), hole.head_depth = Expr::of(name + "_head_depth");
    Frame at;
    at.x = Expr::of(name + "_x"), at.y = Expr::of(name + "_y"), at.z = Expr::of("height");
    c.steps.push_back({name, hole, at, {}, ""});
    cut.objects.push_back(name);
  }
  c.shape = cut;
  return c;
}

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

int main(int argc, char** argv) {
  std::size_t points = 200000;
  int holes = 20, threads = 2;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (i + 1 == argc) return std::fputs(usage, stderr), 2;
    const int value = std::atoi(argv[++i]);
    if (option == "--points")
      points = std::size_t(value);
    else if (option == "--holes")
      holes = value;
    else if (option == "--threads")
      threads = value;
    else
      return std::fputs(usage, stderr), 2;
  }
  const Candidate truth = drilled_block(holes);
  Sampling sampling;
  sampling.points = points, sampling.noise = 0.02, sampling.reach = 155, sampling.seen_from = Vec3::Zero();
  // Samples are drawn about the origin: the part stands with its middle there for the time being.
  Candidate moved = truth;
  for (Object& step : moved.steps) {
    step.frame.x = step.frame.x - Expr(150), step.frame.y = step.frame.y - Expr(100);
    step.frame.z = step.frame.z - Expr(20);
  }
  Scan scan = sampled(bare_model(moved), sampling);
  for (Vec3& p : scan.cloud.points) p += Vec3(150, 100, 20);
  Context context;
  context.threads = threads;
  auto input = prepare(scan, 0.1, context);
  if (!input) return std::fprintf(stderr, "%s\n", input.error().message.c_str()), 1;
  Candidate start = truth;
  Random random(7);
  for (Parameter& p : start.parameters) p.value = p.fitted = p.value + 0.2 * random.normal();
  const double wall = seconds_now();
  const std::clock_t cpu = std::clock();
  const RefineReport report = refine(start, *input, {}, context);
  const double took = seconds_now() - wall, processor = double(std::clock() - cpu) / CLOCKS_PER_SEC;
  double worst = 0, sum = 0;
  std::size_t beyond = 0;
  for (std::size_t i = 0; i < start.parameters.size(); ++i) {
    const Parameter& p = start.parameters[i];
    const double off = p.fitted - truth.parameters[i].value;
    worst = std::max(worst, std::abs(off)), sum += off * off / (p.sigma * p.sigma);
    beyond += std::abs(off) > 3 * p.sigma;
  }
  std::printf(
      "%zu objects, %zu parameters, %zu points, %d threads: %.2f s, %.2f s of processor time, rms %.4f mm; numbers off "
      "by at most %.4f mm, rms in sigmas %.2f, %zu beyond 3\n",
      start.steps.size(), start.parameters.size(), scan.cloud.size(), threads, took, processor, report.rms, worst,
      std::sqrt(sum / double(start.parameters.size())), beyond);
  return 0;
}
