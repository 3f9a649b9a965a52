#include "cli/paper/paper_subjects.h"

#include <algorithm>
#include <cmath>

#include "cli/paper/paper_models.h"
#include "core/number.h"
#include "core/random.h"
#include "model/json.h"
#include "scan/simulate/reliefs.h"

namespace partscribe::cli {
namespace {

constexpr int side = 256;

PaperSubject subject_of(std::string name, std::string file, std::string note, RangeImage image, double sigma,
                        Context& context) {
  PaperSubject subject;
  subject.name = std::move(name), subject.file = std::move(file), subject.note = std::move(note);
  subject.image = std::move(image);
  subject.filtered = rlts_filter(subject.image, {.sigma = sigma}, context);
  const SurfaceGraph graph = surface_graph(subject.image, subject.filtered, {});
  subject.characters = characterize(graph, {}, context);
  subject.patches = grow_patches(graph, subject.characters, {}, context);
  for (std::size_t i = 0; i < subject.filtered.depth.size(); ++i)
    if (subject.filtered.kept[i]) subject.deepest = std::max(subject.deepest, subject.filtered.depth[i]);
  return subject;
}

}  // namespace

RangeImage image_of_relief(const std::function<double(double, double)>& height, const Vec2& low, const Vec2& high,
                           double sigma, double bit_error, bool background, std::uint64_t seed) {
  constexpr int most_code = 65535;
  RangeImage image;
  image.width = image.height = side;
  // The sensor looks down: its y axis is that of the part turned over, and depth grows as heights fall.
  image.pitch_x = (high.x() - low.x()) / (side - 1), image.pitch_y = (high.y() - low.y()) / (side - 1);
  image.x0 = low.x(), image.y0 = -high.y();
  image.z0 = 100, image.q = 0.0025;
  image.world_from_view.rotation << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  image.world_from_view.translation = {0, 0, 200};
  Random random(seed);
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column) {
      double z = height(low.x() + column * image.pitch_x, high.y() - row * image.pitch_y);
      if (!std::isfinite(z) && background) z = 0;
      // Numbers are drawn for every pixel, so that those of one do not depend on what another shows.
      const double noise = sigma * random.normal(), flip = random.uniform(), bit = random.uniform();
      if (!std::isfinite(z)) {
        image.codes.push_back(image.invalid_code);
        continue;
      }
      int code = 1 + static_cast<int>(std::lround((200 - z + noise - image.z0) / image.q));
      if (flip < bit_error) code ^= 1 << static_cast<int>(16 * bit);
      image.codes.push_back(static_cast<std::uint16_t>(std::clamp(code, 1, most_code)));
    }
  return image;
}

Vec3 PaperSubject::place(int column, int row) const {
  return {image.x0 + column * image.pitch_x, -(image.y0 + row * image.pitch_y), -filtered.depth[index(column, row)]};
}

double PaperSubject::height(int column, int row) const { return place(column, row).z() + deepest; }

Vec3 PaperSubject::normal(int column, int row) const {
  const std::size_t i = index(column, row);
  if (!filtered.kept[i] || !std::isfinite(filtered.slope_column[i])) return Vec3::Zero();
  return Vec3(filtered.slope_column[i] / image.pitch_x, -filtered.slope_row[i] / image.pitch_y, 1).normalized();
}

std::vector<Vec3> PaperSubject::points() const {
  std::vector<Vec3> result;
  for (int row = 0; row < image.height; ++row)
    for (int column = 0; column < image.width; ++column)
      if (kept(column, row)) result.push_back(place(column, row));
  return result;
}

Scan scan_of(const PaperSubject& subject) {
  Scan scan;
  scan.views.push_back({});
  scan.views.back().file = subject.file;
  scan.views.back().width = subject.image.width, scan.views.back().height = subject.image.height;
  for (int row = 0; row < subject.image.height; ++row)
    for (int column = 0; column < subject.image.width; ++column) {
      const Vec3 normal = subject.normal(column, row);
      if (normal.isZero()) continue;
      scan.cloud.points.push_back(subject.place(column, row));
      scan.cloud.view.push_back(0);
      scan.cloud.pixel.push_back(std::int32_t(subject.index(column, row)));
      scan.cloud.rays.push_back({0, 0, -1});
    }
  return scan;
}

Result<PaperSubjects> paper_subjects(Context& context) {
  PaperSubjects subjects;
  auto model = model::read_model_json(pin_model_text, "the built-in pin");
  if (!model) return model.error();
  subjects.pin_model = std::move(*model);
  scan::SimulateOptions seen;
  seen.views = "octahedron", seen.bit_error = 0.001;
  const scan::Surface surface = scan::surface_of(subjects.pin_model);
  seen.sigma = 4 * scan::code_step(surface, seen);
  scan::SimulatedScan simulated = scan::simulate(surface, seen, context);
  subjects.pin_scan = std::move(simulated.merged);
  subjects.pin = subject_of("Cylindrical Pin", "pin", "a range image simulated from a CAD model, as published",
                            std::move(simulated.views[0].image), seen.sigma, context);
  constexpr double sigma = 0.1;  // mm
  subjects.mask = subject_of("Face Mask", "mask", "a sculpted stand-in: the range image of the paper is lost",
                             image_of_relief(scan::face_mask_height, {-98, -105}, {98, 105}, sigma, 0.001, false, 7),
                             sigma, context);
  subjects.hand =
      subject_of("Hand", "hand", "a sculpted stand-in: the range image of the paper is lost",
                 image_of_relief(scan::hand_height, {-85, -6}, {85, 184}, sigma, 0.001, false, 8), sigma, context);
  return subjects;
}

}  // namespace partscribe::cli
