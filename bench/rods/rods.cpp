/// Whether dense and noisy clouds of simple parts, without rays, come out as what they are, with numbers as exact as
/// they say.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "core/number.h"
#include "core/random.h"
#include "core/statistics.h"
#include "fit/build.h"
#include "model/model.h"

using namespace partscribe::fit;

namespace {

const char* usage =
    "usage: rods [--runs N] [--first SEED] [--kind cylinder|sphere|box|cone] [--most POINTS] [--sigmas TOLERANCE] "
    "[--verbose] [--save FILE.xyz]\n";

/// A part and how it was scanned: places evenly spread over its surface, noise along the normal.
struct Scanned {
  std::vector<double> numbers;  // radius and length; radius; edges, longest first; radii and length
  double noise = 0, tolerance = 0;
  std::size_t points = 0;
  Scan scan;
};

double log_uniform(Random& random, double low, double high) { return low * std::pow(high / low, random.uniform()); }

struct Place {
  Vec3 point, normal;
};

/// On a frustum of a cone about z, capped at z = 0 and z = `length`.
Place on_frustum(Random& random, double bottom, double top, double length) {
  const double slant = std::hypot(length, bottom - top), side = pi * (bottom + top) * slant,
               caps = pi * (bottom * bottom + top * top);
  const double angle = random.uniform(0, 2 * pi), part = random.uniform() * (side + caps);
  const Vec3 out(std::cos(angle), std::sin(angle), 0);
  if (part >= side) {
    const bool low = part < side + pi * bottom * bottom;
    const double r = (low ? bottom : top) * std::sqrt(random.uniform());
    return {r * out + Vec3(0, 0, low ? 0 : length), Vec3(0, 0, low ? -1 : 1)};
  }
  // The radius falls along the side, and with it the area.
  const double u = random.uniform(), square = bottom * bottom + u * (top * top - bottom * bottom),
               r = std::sqrt(square);
  const double z = bottom == top ? u * length : (bottom - r) / (bottom - top) * length;
  return {r * out + Vec3(0, 0, z), (length * out + Vec3(0, 0, bottom - top)) / slant};
}

Place on_box(Random& random, const Vec3& size) {
  const Vec3 areas(size.y() * size.z(), size.x() * size.z(), size.x() * size.y());
  double part = random.uniform() * areas.sum();
  int axis = 0;
  while (axis < 2 && part >= areas[axis]) part -= areas[axis++];
  Place at;
  for (int k = 0; k < 3; ++k) at.point[k] = random.uniform(-0.5, 0.5) * size[k];
  at.normal = Vec3::Unit(axis) * (random.uniform() < 0.5 ? 1 : -1);
  at.point[axis] = 0.5 * size[axis] * at.normal[axis];
  return at;
}

/// The same for the same arguments always. Radius (half the middle edge of a box) 1 to 30 mm, noise 0.5 to 5 % of it,
/// 1,000 to `most` points, length 1.5 to 8 radii; of a cone the top is 0.3 to 0.85 times as wide as the bottom.
Scanned scanned(const std::string& kind, std::uint64_t seed, double most, double sigmas) {
  Random random(seed * 7919 + 41);
  Scanned s;
  const double radius = log_uniform(random, 1, 30), share = log_uniform(random, 0.005, 0.05),
               points = log_uniform(random, 1000, 200000);
  const double length = radius * random.uniform(1.5, 8), taper = random.uniform(0.3, 0.85), flat = random.uniform(1, 2);
  const Mat3 rotation = Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal())
                            .normalized()
                            .toRotationMatrix();
  const Vec3 shift = 100 * Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
  s.noise = share * radius, s.points = static_cast<std::size_t>(std::min(points, most));
  const Vec3 edges(length, 2 * radius, flat * radius);
  double size = 2 * radius;
  if (kind == "sphere")
    s.numbers = {radius};
  else if (kind == "box")
    s.numbers = {edges.x(), edges.y(), edges.z()}, std::sort(s.numbers.rbegin(), s.numbers.rend()), size = edges.norm();
  else if (kind == "cone")
    s.numbers = {radius, taper * radius, length}, size = std::hypot(2 * radius, length);
  else
    s.numbers = {radius, length}, size = std::hypot(2 * radius, length);
  s.scan.files = {"scan"};
  for (std::size_t i = 0; i < s.points; ++i) {
    Place at;
    if (kind == "sphere")
      at.normal = Vec3(random.normal(), random.normal(), random.normal()).normalized(), at.point = radius * at.normal;
    else if (kind == "box")
      at = on_box(random, edges);
    else
      at = on_frustum(random, radius, kind == "cone" ? taper * radius : radius, length);
    s.scan.cloud.points.push_back(rotation * (at.point + s.noise * random.normal() * at.normal) + shift);
  }
  s.tolerance = std::max(sigmas * s.noise, size / 1000);
  return s;
}

/// What came out: numbers in the order of the truth's, with their sigmas.
struct Found {
  std::string kind;
  std::vector<std::array<double, 2>> numbers;
  bool cylinder_may_be = false;  // the rivals say so
  double seconds = 0;
};

Found found_in(const Scanned& s, Context& context) {
  Found found;
  Scan scan = s.scan;
  BuildOptions options;
  options.tolerance = s.tolerance;
  const double start = double(std::clock());
  const auto built = build_model(scan, options, context);
  found.seconds = (double(std::clock()) - start) / CLOCKS_PER_SEC;
  if (!built) return found.kind = built.error().message, found;
  const Model& model = **built;
  const Shape& shape = model.objects.back().shape;
  found.kind = std::string(kind_of(shape));
  const auto add = [&](const Expr& e) {
    for (const Parameter& p : model.parameters)
      if (e.is_parameter() && p.name == e.parameter) found.numbers.push_back({p.fitted, p.sigma});
  };
  if (const auto* c = std::get_if<Cylinder>(&shape)) add(c->radius), add(c->height);
  if (const auto* b = std::get_if<Sphere>(&shape)) add(b->radius);
  if (const auto* b = std::get_if<Box>(&shape)) {
    add(b->size_x), add(b->size_y), add(b->size_z);
    std::sort(found.numbers.rbegin(), found.numbers.rend());
  }
  if (const auto* c = std::get_if<Cone>(&shape)) {
    add(c->bottom_radius), add(c->top_radius), add(c->height);
    if (found.numbers.size() == 3 && found.numbers[0] < found.numbers[1]) std::swap(found.numbers[0], found.numbers[1]);
  }
  found.cylinder_may_be = std::any_of(model.rivals.begin(), model.rivals.end(), [](const Rival& r) {
    return r.procedure == "cylinder" &&
           (r.reason.find("cannot tell") != std::string::npos || r.reason.find("fits as well") != std::string::npos);
  });
  return found;
}

}  // namespace

int main(int argc, char** argv) {
  std::uint64_t runs = 40, first = 1;
  std::string kind = "cylinder", file;
  double most = 200000, sigmas = 5;
  bool verbose = false;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    const auto value = [&]() -> std::string { return i + 1 < argc ? argv[++i] : ""; };
    if (option == "--runs")
      runs = std::strtoull(value().c_str(), nullptr, 10);
    else if (option == "--first")
      first = std::strtoull(value().c_str(), nullptr, 10);
    else if (option == "--kind")
      kind = value();
    else if (option == "--most")
      most = std::atof(value().c_str());
    else if (option == "--sigmas")
      sigmas = std::atof(value().c_str());
    else if (option == "--verbose")
      verbose = true;
    else if (option == "--save")
      file = value();
    else
      return std::fputs(usage, stderr), 2;
  }
  if (runs == 0 || most < 100) return std::fputs(usage, stderr), 2;
  std::size_t right = 0, open = 0, numbers = 0, held = 0, radii_held = 0;
  std::vector<double> seconds, off;
  for (std::uint64_t seed = first; seed < first + runs; ++seed) {
    const Scanned s = scanned(kind, seed, most, sigmas);
    if (std::FILE* out = file.empty() ? nullptr : std::fopen(file.c_str(), "w")) {
      for (const Vec3& p : s.scan.cloud.points) std::fprintf(out, "%.5f %.5f %.5f\n", p.x(), p.y(), p.z());
      std::fclose(out);
    }
    Context context;
    if (verbose && runs == 1)
      context.log = [](const std::string& line) { std::fprintf(stderr, "    %s\n", line.c_str()); };
    const Found found = found_in(s, context);
    seconds.push_back(found.seconds);
    const bool same = found.kind == kind && found.numbers.size() == s.numbers.size();
    const bool may_be = kind == "cylinder" && found.kind == "cone" && found.cylinder_may_be;
    right += same, open += may_be;
    std::string text;
    for (std::size_t k = 0; k < s.numbers.size(); ++k) {
      text += " " + print_number(snapped(s.numbers[k], 0.0001));
      if (!same) continue;
      const double u = std::abs(found.numbers[k][0] - s.numbers[k]) / std::max(found.numbers[k][1], 1e-12);
      ++numbers, held += u < 3, radii_held += k == 0 && u < 3;
      if (k == 0) off.push_back(u);
      text += " (" + print_number(snapped(found.numbers[k][0] - s.numbers[k], 0.00001)) + ", " +
              print_number(snapped(u, 0.01)) + " sigma)";
    }
    if (verbose)
      std::fprintf(stderr, "%s %llu:%s, noise %.2f %%, %zu points, T %.3g: %s%s, %.2f s\n", kind.c_str(),
                   static_cast<unsigned long long>(seed), text.c_str(),
                   100 * s.noise / (kind == "box" ? s.numbers[1] / 2 : s.numbers[0]), s.points, s.tolerance,
                   found.kind.c_str(), may_be ? ", the data cannot tell it from a cylinder" : "", found.seconds);
  }
  const auto share = [](std::size_t part, std::size_t all) {
    return all == 0 ? std::string("-") : print_number(snapped(100.0 * double(part) / double(all), 0.1)) + " %";
  };
  std::printf(
      "| kind | runs | right | cannot tell | first number within 3 sigmas | all numbers | its median error, sigmas | s "
      "|\n|---|---|---|---|---|---|---|---|\n"
      "| %s | %llu | %s | %s | %s | %s | %s | %s |\n",
      kind.c_str(), static_cast<unsigned long long>(runs), share(right, runs).c_str(), share(open, runs).c_str(),
      share(radii_held, right).c_str(), share(held, numbers).c_str(), print_number(snapped(median(off), 0.01)).c_str(),
      print_number(snapped(median(seconds), 0.01)).c_str());
}
