/// The range scanner: rays, noise, drop-out, mixed pixels, quantisation, bit errors.
#include "scan/simulate/simulate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/number.h"
#include "core/parallel.h"
#include "core/random.h"
#include "scan/read/sources.h"

namespace partscribe::scan {
namespace {

constexpr double margin = 1.02;         // of the image around the part's bounding sphere
constexpr double pinhole_distance = 5;  // bounding radii from sensor to part
constexpr double thinning_angle = pi / 3;
constexpr double step_slope = 6;  // pixel pitches; a surface that returns at all climbs 4.7 at most (78 degrees)

/// What a noise-free scanner sees at one pixel.
struct SeenSurface {
  double z = -1;  ///< -1: nothing
  double cosine = 0;
};

/// Seed of one pixel's randomness: threads and views cannot change it.
std::uint64_t pixel_seed(std::uint64_t seed, std::size_t view, std::size_t pixel) {
  Random outer(seed);
  Random inner(outer.next() ^ (std::uint64_t(view) << 40 | pixel));
  return inner.next();
}

/// Of the sphere that images show whole, mm.
double shown_radius(const Surface& surface) { return std::max(0.5 * surface.bounds.diagonal(), 1e-9) * margin; }

RangeImage empty_image(const Surface& surface, const Vec3& to_sensor, const SimulateOptions& options) {
  const Vec3 center = surface.bounds.center();
  const double radius = shown_radius(surface);
  const bool pinhole = options.projection == Projection::pinhole;
  const double distance = (pinhole ? pinhole_distance : 2) * radius;
  RangeImage image;
  image.projection = options.projection;
  image.width = image.height = options.resolution;
  image.codes.assign(std::size_t(options.resolution) * static_cast<std::size_t>(options.resolution), 0);
  image.z0 = distance - radius;
  image.q = code_step(surface, options);
  const double middle = 0.5 * (options.resolution - 1);
  image.cx = image.cy = middle;
  image.fx = image.fy = std::max(middle, 0.5) / std::tan(std::asin(1 / pinhole_distance));
  image.pitch_x = image.pitch_y = radius / std::max(middle, 0.5);
  image.x0 = image.y0 = -middle * image.pitch_x;
  image.world_from_view.rotation = rotation_onto_axis(-to_sensor);
  image.world_from_view.translation = center + distance * to_sensor;
  return image;
}

SeenSurface look(const Surface& surface, const RangeImage& image, int row, int column) {
  const Pose& pose = image.world_from_view;
  if (image.projection == Projection::orthographic) {
    const Vec3 origin = pose * Vec3(image.x0 + column * image.pitch_x, image.y0 + row * image.pitch_y, 0);
    const Vec3 direction = pose.rotation.col(2);
    const auto hit = surface.first_hit(origin, direction);
    return hit ? SeenSurface{hit->distance, -hit->normal.dot(direction)} : SeenSurface{};
  }
  const Vec3 ray = Vec3((column - image.cx) / image.fx, (row - image.cy) / image.fy, 1).normalized();
  const Vec3 direction = pose.rotation * ray;
  const auto hit = surface.first_hit(pose.translation, direction);
  return hit ? SeenSurface{hit->distance * ray.z(), -hit->normal.dot(direction)} : SeenSurface{};
}

/// What the electronics make of one pixel; 0 is no return.
std::uint16_t measure(const std::vector<SeenSurface>& sights, const RangeImage& image, int row, int column,
                      const SimulateOptions& options, Random& random, bool& bit_error) {
  // Every number is drawn whether it is needed or not, so that one option never shifts the chance of another.
  const double thin = random.uniform(), noise = random.normal(), mix = random.uniform(), share = random.uniform();
  const double outlier = random.uniform(), outlier_at = random.uniform(), flip = random.uniform();
  const auto bit = random.below(static_cast<std::uint64_t>(options.bits));
  const auto sight_at = [&](int r, int c) {
    return sights[std::size_t(r) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(c)];
  };
  const auto& sight = sight_at(row, column);
  if (sight.z < 0) return 0;
  const double angle = std::acos(std::clamp(sight.cosine, -1.0, 1.0));
  if (angle > options.drop_angle) return 0;
  if (angle > thinning_angle && thin < (angle - thinning_angle) / (options.drop_angle - thinning_angle)) return 0;
  double z = sight.z;
  const double pitch = image.projection == Projection::pinhole ? z / image.fx : image.pitch_x;
  double other = z;  // across the largest depth step among the four neighbours
  for (const auto& [dr, dc] : {std::pair{-1, 0}, std::pair{0, -1}, std::pair{0, 1}, std::pair{1, 0}}) {
    const int r = row + dr, c = column + dc;
    if (r < 0 || c < 0 || r >= image.height || c >= image.width) continue;
    const auto& beside = sight_at(r, c);
    if (beside.z >= 0 && std::abs(beside.z - z) > std::abs(other - z)) other = beside.z;
  }
  if (std::abs(other - z) > step_slope * pitch && mix < options.mixed) z += share * (other - z);
  z += noise * options.sigma / std::max(sight.cosine, 1.0 / 3);
  const int most = (1 << options.bits) - 1;
  if (outlier < options.outliers) z = image.z0 + outlier_at * (most - 1) * image.q;
  auto code = static_cast<int>(std::clamp(1 + std::round((z - image.z0) / image.q), 1.0, double(most)));
  bit_error = flip < options.bit_error;
  if (bit_error) code ^= 1 << bit;
  return static_cast<std::uint16_t>(code);
}

/// `pose` with the part, not the sensor, turned and moved a little.
Pose disturbed(const Pose& pose, const Vec3& center, const SimulateOptions& options, std::size_t view) {
  Random random(pixel_seed(options.seed, view, (std::size_t(1) << 39)));
  const auto direction = [&] {
    Vec3 v(random.normal(), random.normal(), random.normal());
    return Vec3(v / std::max(v.norm(), 1e-12));
  };
  const Mat3 turn = rotation_of(options.pose_noise_angle * direction());
  const Vec3 shift = options.pose_noise_shift * direction();
  return Pose{turn, center - turn * center + shift} * pose;
}

std::vector<Vec3> normalized(std::vector<Vec3> directions) {
  for (auto& d : directions) d.normalize();
  return directions;
}

}  // namespace

std::optional<std::vector<Vec3>> viewpoints(const std::string& name) {
  const double golden = 0.5 * (1 + std::sqrt(5.0));
  std::vector<Vec3> result;
  const auto signs = [&](double x, double y, double z) {
    for (const double a : {1.0, -1.0})
      for (const double b : {1.0, -1.0})
        for (const double c : {1.0, -1.0})
          if ((x != 0 || a > 0) && (y != 0 || b > 0) && (z != 0 || c > 0)) result.emplace_back(a * x, b * y, c * z);
  };
  const auto turns = [&](double x, double y, double z) { signs(x, y, z), signs(z, x, y), signs(y, z, x); };
  if (name == "tetrahedron") return normalized({{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}});
  if (name == "octahedron")
    turns(1, 0, 0);
  else if (name == "cube")
    signs(1, 1, 1);
  else if (name == "icosahedron")
    turns(0, 1, golden);
  else if (name == "dodecahedron")
    signs(1, 1, 1), turns(0, 1 / golden, golden);
  if (!result.empty()) return normalized(result);
  int count = 0;
  const auto [end, failure] = std::from_chars(name.data(), name.data() + name.size(), count);
  if (failure != std::errc() || end != name.data() + name.size() || count < 1 || count > 1000) return {};
  if (count == 1) return std::vector<Vec3>{{0, 0, 1}};
  for (int i = 0; i < count; ++i) {  // Fibonacci sphere
    const double z = 1 - (2.0 * i + 1) / count, r = std::sqrt(1 - z * z), a = 2 * pi * i / golden;
    result.emplace_back(r * std::cos(a), r * std::sin(a), z);
  }
  return result;
}

double code_step(const Surface& surface, const SimulateOptions& options) {
  return 2 * shown_radius(surface) / ((1 << options.bits) - 2);  // codes 1 .. 2^bits - 1
}

SimulatedScan simulate(const Surface& surface, const SimulateOptions& options, Context& context) {
  ensure(options.bits >= 4 && options.bits <= 16, "codes have 4 to 16 bits");
  ensure(options.resolution >= 2 && options.resolution <= 16384, "images have 2 to 16384 pixels a side");
  const auto directions = viewpoints(options.views);
  ensure(directions.has_value(), "the set of viewpoints must be known");
  SimulatedScan result;
  if (surface.bounds.empty()) return result;
  const Mat3 tilt = rotation_of(options.tilt * Vec3(.3, .8, .5).normalized());
  for (std::size_t v = 0; v < directions->size() && !context.cancelled; ++v) {
    context.report("simulating views", double(v) / double(directions->size()));
    SimulatedView view;
    auto& image = view.image = empty_image(surface, tilt * (*directions)[v], options);
    const auto width = static_cast<std::size_t>(image.width), height = static_cast<std::size_t>(image.height);
    std::vector<SeenSurface> sights(width * height);
    std::vector<char> flipped(width * height, 0);
    const auto each_pixel = [&](const std::function<void(int, int, std::size_t)>& body) {
      parallel_for(
          height, context.threads,
          [&](std::size_t begin, std::size_t end) {
            for (std::size_t r = begin; r < end; ++r)
              for (std::size_t c = 0; c < width; ++c) body(static_cast<int>(r), static_cast<int>(c), r * width + c);
          },
          8);
    };
    each_pixel([&](int r, int c, std::size_t pixel) { sights[pixel] = look(surface, image, r, c); });
    each_pixel([&](int r, int c, std::size_t pixel) {
      Random random(pixel_seed(options.seed, v, pixel));
      bool bit_error = false;
      image.codes[pixel] = measure(sights, image, r, c, options, random, bit_error);
      flipped[pixel] = bit_error;
    });
    for (const auto code : image.codes) view.returns += code != image.invalid_code;
    for (const auto f : flipped) view.bit_errors += f != 0;
    view.initial_guess = disturbed(image.world_from_view, surface.bounds.center(), options, v);

    auto cloud = cloud_of(image);
    auto& merged = result.merged.cloud;
    const auto number = static_cast<std::int32_t>(v);
    merged.points.insert(merged.points.end(), cloud.points.begin(), cloud.points.end());
    merged.rays.insert(merged.rays.end(), cloud.rays.begin(), cloud.rays.end());
    merged.pixel.insert(merged.pixel.end(), cloud.pixel.begin(), cloud.pixel.end());
    merged.view.insert(merged.view.end(), cloud.size(), number);
    result.merged.views.push_back(
        {view_file_name(v), image.world_from_view, image.projection == Projection::pinhole, image.width, image.height});
    result.views.push_back(std::move(view));
  }
  context.report("simulating views", 1);
  return result;
}

}  // namespace partscribe::scan
