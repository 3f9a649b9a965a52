// Figures 2 to 6: filtering, registration, range images.
#include <algorithm>
#include <cmath>

#include "cli/describe.h"
#include "cli/paper/paper_figure.h"
#include "cli/paper/paper_models.h"
#include "cli/paper/sheet.h"
#include "core/number.h"
#include "core/random.h"
#include "model/distance/distance.h"
#include "model/json.h"
#include "scan/filter/filter.h"
#include "scan/register/register.h"

namespace partscribe::cli {
namespace {

/// A step, a slope, a ridge and a round, in codes.
double profile_codes(int i) {
  if (i < 60) return 900;
  if (i < 110) return 1500;
  if (i < 170) return 1500 - 8 * (i - 110);
  if (i < 200) return 1020 + 12 * (i - 170);
  if (i < 230) return 1380 - 12 * (i - 200);
  return 1020 + std::sqrt(std::max(0.0, 200.0 * 200 - std::pow((i - 290) * 4.0, 2)));
}

struct PlacedPoint {
  Vec3 point;
  std::size_t view;
};

/// Points within `half` of the plane x = at.
std::vector<PlacedPoint> cut_of(const std::vector<PlacedPoint>& points, double at, double half) {
  std::vector<PlacedPoint> result;
  for (const auto& p : points)
    if (std::abs(p.point.x() - at) < half) result.push_back(p);
  return result;
}

/// y to the right, z up, into a field of the sheet.
void draw_cut(const std::vector<PlacedPoint>& points, const Box3& bounds, const Vec3& corner, double scale,
              Sheet& sheet) {
  std::vector<Vec3> places;
  std::vector<Color> colors;
  for (const auto& p : points) {
    places.push_back(corner + scale * Vec3(p.point.y() - bounds.low.y(), p.point.z() - bounds.low.z(), 0));
    colors.push_back(series_color(p.view));
  }
  sheet.dots(places, colors);
}

/// The views side by side, lit along their direction of sight.
std::string picture_of_views(const std::vector<RangeImage>& images, const std::vector<scan::RegisterView>& filtered) {
  const int side = images[0].width;
  Sheet sheet(4 * side, 2 * side);
  for (std::size_t v = 0; v < filtered.size(); ++v)
    for (std::size_t i = 0; i < filtered[v].cloud.size(); ++i) {
      const PointCloud& cloud = filtered[v].cloud;
      if (cloud.rejected[i] || cloud.normals[i].isZero()) continue;
      const double light = std::max(0.0, -cloud.normals[i].dot(Vec3(-0.3, 0.35, 1).normalized()));
      sheet.pixel(int(v % 4) * side + int(cloud.pixel[i]) % side, int(v / 4) * side + int(cloud.pixel[i]) / side,
                  mixed({40, 48, 64}, {232, 236, 244}, light));
    }
  return sheet.png();
}

/// One section, of all views and of each.
std::string picture_of_section(const std::vector<PlacedPoint>& points, const Box3& bounds) {
  const Vec3 size = bounds.size();
  const double large = 480 / std::max(size.y(), size.z()), small = 230 / std::max(size.y(), size.z());
  Sheet sheet(1000, int((large + 2 * small) * size.z() + 80));
  const auto cut = cut_of(points, bounds.low.x() + 0.3 * size.x(), size.x() / 200);
  draw_cut(cut, bounds, {500 - 0.5 * large * size.y(), 2 * small * size.z() + 60, 0}, large, sheet);
  for (std::size_t v = 0; v < 8; ++v) {
    std::vector<PlacedPoint> one;
    for (const auto& p : cut)
      if (p.view == v) one.push_back(p);
    draw_cut(one, bounds, {10 + 250.0 * double(v % 4), v < 4 ? small * size.z() + 40 : 20, 0}, small, sheet);
  }
  return sheet.png();
}

/// Sections along x, each of all views.
std::string picture_of_contours(const std::vector<PlacedPoint>& points, const Box3& bounds) {
  const Vec3 size = bounds.size();
  const double scale = 230 / std::max(size.y(), size.z());
  Sheet sheet(1000, int(3 * (scale * size.z() + 20)));
  for (int k = 0; k < 12; ++k)
    draw_cut(cut_of(points, bounds.low.x() + (k + 0.5) / 12 * size.x(), size.x() / 200), bounds,
             {10 + 250.0 * (k % 4), 10 + (2 - k / 4) * (scale * size.z() + 20), 0}, scale, sheet);
  return sheet.png();
}

/// Heights lit from above on the left, raw or filtered.
Raster lit_image(const PaperSubject& subject, bool filtered) {
  const RangeImage& image = subject.image;
  Raster raster(image.width, image.height, {18, 20, 26});
  const Vec3 light = Vec3(-0.45, 0.5, 0.75).normalized();
  const auto raw = [&](int column, int row) {
    const auto point = view_point(image, row, column);
    return point ? -point->z() : std::nan("");
  };
  for (int row = 1; row + 1 < image.height; ++row)
    for (int column = 1; column + 1 < image.width; ++column) {
      Vec3 normal = subject.normal(column, row);
      if (!filtered) {
        const double dx = (raw(column + 1, row) - raw(column - 1, row)) / (2 * image.pitch_x);
        const double dy = (raw(column, row - 1) - raw(column, row + 1)) / (2 * image.pitch_y);
        normal = std::isfinite(dx + dy) ? Vec3(-dx, -dy, 1).normalized() : Vec3::Zero();
      }
      if (normal.isZero()) continue;
      raster.pixels[std::size_t(row) * std::size_t(image.width) + std::size_t(column)] =
          mixed({40, 48, 64}, {236, 239, 246}, std::max(0.0, normal.dot(light)));
    }
  return raster;
}

}  // namespace

PaperFigure filtered_profile_figure(Context& context) {
  constexpr int samples = 340;
  RangeImage image;
  image.width = samples, image.height = 1, image.z0 = 1, image.q = 1;
  Random random(3);
  std::size_t flipped = 0;
  for (int i = 0; i < samples; ++i) {
    int code = int(std::lround(profile_codes(i) + 5 * random.normal()));
    if (random.uniform() < 0.015) code ^= 1 << int(12 * random.uniform()), ++flipped;
    image.codes.push_back(std::uint16_t(std::clamp(code, 1, 4095)));
  }
  const FilteredImage filtered = rlts_filter(image, {.form = RltsForm::profile, .sigma = 5}, context);
  Sheet sheet(3 * samples + 20, 560);
  std::vector<Vec3> noisy, clean;
  double before = 0, after = 0;
  std::size_t kept = 0;
  for (int i = 0; i < samples; ++i) {
    const double raw = image.codes[std::size_t(i)], x = 10 + 3 * i;
    noisy.push_back({x, 300 + std::clamp(raw - 700, 0.0, 950.0) * 0.26, 0});
    before += std::pow(raw - profile_codes(i), 2) / samples;
    if (!filtered.kept[std::size_t(i)]) continue;
    const double z = filtered.depth[std::size_t(i)];
    after += std::pow(z - profile_codes(i), 2), ++kept;
    clean.push_back({x, 20 + std::clamp(z - 700, 0.0, 950.0) * 0.26, 0});
  }
  sheet.line({{10, 285, 0}, {10.0 + 3 * samples, 285, 0}}, 1, sheet_faint);
  sheet.line(noisy, 1.2, sheet_ink);
  sheet.line(clean, 1.2, series_color(0));
  PaperFigure figure;
  figure.title = "Figure 2: a noisy profile, filtered";
  figure.text =
      "Gaussian noise of 5 codes, bit errors with probability 0.015 and 12 bits; trimmed lines through five "
      "samples (reweighted least trimmed squares). " +
      std::to_string(flipped) + " of " + std::to_string(samples) + " samples have a flipped bit; the rms error is " +
      readable(std::sqrt(before)) + " codes before and " + readable(std::sqrt(after / double(kept))) +
      " after, of the " + std::to_string(kept) + " samples that are kept.";
  figure.pictures = {{"figure-2.png", sheet.png(), "above the noisy profile with spikes, below the filtered one"}};
  return figure;
}

Result<std::vector<PaperFigure>> registration_figures(Context& context) {
  const auto model = model::read_model_json(polyhedron_model_text, "the built-in polyhedron");
  if (!model) return model.error();
  scan::SimulateOptions options;
  const scan::Surface surface = scan::surface_of(*model);
  options.views = "cube", options.bits = 12, options.bit_error = 0.015;
  options.pose_noise_angle = 5 * pi / 180, options.pose_noise_shift = 3;
  options.sigma = 5 * scan::code_step(surface, options);
  scan::SimulatedScan simulated = scan::simulate(surface, options, context);
  std::vector<RangeImage> images;
  for (std::size_t v = 0; v < simulated.views.size(); ++v) {
    images.push_back(simulated.views[v].image);
    simulated.merged.views[v].file = "view " + std::to_string(v);
  }
  std::vector<scan::RegisterView> filtered = scan::views_to_register(simulated.merged, images, context);
  for (std::size_t v = 0; v < filtered.size(); ++v) filtered[v].guess = simulated.views[v].initial_guess;
  const auto registration = scan::register_views(filtered, {}, context);
  if (!registration) return registration.error();
  const Pose to_part = images[0].world_from_view * registration->views[0].world_from_view.inverse();
  std::vector<PlacedPoint> points;
  Box3 bounds;
  double worst = 0;
  std::size_t placed = 0;
  for (std::size_t v = 0; v < filtered.size(); ++v) {
    if (registration->views[v].status == scan::ViewStatus::refused) continue;
    ++placed;
    const Pose pose = to_part * registration->views[v].world_from_view;
    const PointCloud& cloud = filtered[v].cloud;
    for (std::size_t i = 0; i < cloud.size(); ++i)
      if (!cloud.rejected[i]) points.push_back({pose * cloud.points[i], v}), bounds.add(points.back().point);
    const Vec3 middle = surface.bounds.center();
    worst = std::max(worst, (pose * images[v].world_from_view.inverse() * middle - middle).norm());
  }
  const std::string count = std::to_string(filtered.size());
  PaperFigure views, section, contours;
  views.title = "Figure 3: a polyhedral part in " + count + " poses";
  views.text = "Range images of 12 bits with noise of 5 codes and bit errors with probability 0.015, filtered.";
  views.pictures = {{"figure-3.png", picture_of_views(images, filtered), "eight shaded views of a prism"}};
  section.title = "Figure 4: a section of the registered views";
  section.text = std::to_string(placed) + " of " + count +
                 " views are registered from guesses that are 5 degrees and 3 mm off. The middle of the part is " +
                 readable(worst) + " mm off its true place at most, which is " + readable(worst / images[0].pitch_x) +
                 " pixels. Above the section of all views, below what each adds.";
  // How far the section's points are from the true surface.
  const model::ModelDistance truth(*model);
  std::vector<double> off;
  for (const auto& p : cut_of(points, bounds.low.x() + 0.3 * bounds.size().x(), bounds.size().x() / 200))
    off.push_back(std::abs(truth(p.point).distance) / images[0].pitch_x);
  std::sort(off.begin(), off.end());
  section.table = {
      {"views registered", "of", "middle off, pixels", "points of the section", "half of them within, pixels",
       "nine tenths within, pixels"},
      {std::to_string(placed), count, readable(worst / images[0].pitch_x), std::to_string(off.size()),
       off.empty() ? "-" : readable(off[off.size() / 2]), off.empty() ? "-" : readable(off[off.size() * 9 / 10])}};
  section.pictures = {
      {"figure-4.png", picture_of_section(points, bounds), "one outline in eight colours, and its parts"}};
  contours.title = "Figure 5: contours along x";
  contours.text = "Twelve sections, each of all views in the frame of the first.";
  contours.pictures = {{"figure-5.png", picture_of_contours(points, bounds), "twelve outlines"}};
  return std::vector<PaperFigure>{views, section, contours};
}

PaperFigure range_images_figure(const PaperSubjects& subjects) {
  PaperFigure figure;
  figure.title = "Figure 6: range images";
  figure.text = "256 x 256 pixels of 16 bits; above as measured, below filtered.";
  figure.table = {{"image", "what it is", "returns", "set aside", "noise, mm"}};
  Sheet sheet(3 * 256, 2 * 256);
  int k = 0;
  for (const PaperSubject* s : {&subjects.pin, &subjects.mask, &subjects.hand}) {
    sheet.paste(lit_image(*s, false), 256 * k, 0);
    sheet.paste(lit_image(*s, true), 256 * k, 256);
    figure.table.push_back({s->name, s->note, std::to_string(s->filtered.returns), std::to_string(s->filtered.rejected),
                            readable(s->filtered.noise.sigma(1))});
    ++k;
  }
  figure.pictures = {{"figure-6.png", sheet.png(), "a pin, a face and a hand, shaded, noisy and smooth"}};
  return figure;
}

}  // namespace partscribe::cli
