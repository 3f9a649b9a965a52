/// A simulated scan as files that read_scan reads back: range images, scan.json, merged points.
#include "core/number.h"
#include "geometry/io/read_geometry.h"
#include "scan/read/range_file.h"
#include "scan/read/sources.h"
#include "scan/simulate/simulate.h"

namespace partscribe::scan {
namespace {

std::string matrix(const Pose& pose, const std::string& indent) {
  std::string text = "[";
  for (int r = 0; r < 3; ++r) {
    text += "\n" + indent + "  [";
    for (int c = 0; c < 3; ++c) text += print_number(pose.rotation(r, c)) + ", ";
    text += print_number(pose.translation[r]) + "],";
  }
  return text + "\n" + indent + "  [0, 0, 0, 1]\n" + indent + "]";
}

}  // namespace

std::string view_file_name(std::size_t view) {
  auto number = std::to_string(view);
  return "view_" + (number.size() < 2 ? "0" + number : number) + ".png";
}

std::vector<SimulatedFile> files_of(const SimulatedScan& scan, const SimulateOptions& options) {
  std::vector<SimulatedFile> files;
  for (std::size_t v = 0; v < scan.views.size(); ++v) {
    const auto& image = scan.views[v].image;
    files.push_back({view_file_name(v), write_png({image.width, image.height, image.codes})});
  }
  std::string text = "{\n  \"unit\": \"mm\"";
  const auto put = [&](const char* key, double value) {
    text += std::string(",\n  \"") + key + "\": " + print_number(value);
  };
  if (!scan.views.empty()) {
    const auto& image = scan.views.front().image;  // all images share everything but pose and codes
    if (image.projection == Projection::pinhole) {
      text += ",\n  \"projection\": \"pinhole\",\n  \"K\": [[" + print_number(image.fx) + ", 0, " +
              print_number(image.cx) + "], [0, " + print_number(image.fy) + ", " + print_number(image.cy) +
              "], [0, 0, 1]]";
    } else {
      text += ",\n  \"projection\": \"orthographic\"";
      put("x0", image.x0), put("y0", image.y0), put("pitch_x", image.pitch_x), put("pitch_y", image.pitch_y);
    }
    put("width", image.width), put("height", image.height), put("z0", image.z0), put("q", image.q);
    put("invalid_code", image.invalid_code);
  }
  put("bits", options.bits), put("sigma", options.sigma), put("biterr", options.bit_error);
  put("mixed", options.mixed), put("outliers", options.outliers),
      put("drop_deg", snapped(degrees(options.drop_angle), 1e-6));
  text += ",\n  \"seed\": " + std::to_string(options.seed) + ",\n  \"views\": [";
  for (std::size_t v = 0; v < scan.views.size(); ++v) {
    const auto& view = scan.views[v];
    text += std::string(v ? "," : "") + "\n    {\n      \"png\": \"" + view_file_name(v) +
            "\",\n      \"points\": " + std::to_string(view.returns) +
            ",\n      \"bit_errors\": " + std::to_string(view.bit_errors) +
            ",\n      \"camera_to_world\": " + matrix(view.image.world_from_view, "      ") +
            ",\n      \"initial_guess\": " + matrix(view.initial_guess, "      ") + "\n    }";
  }
  text += "\n  ],\n  \"merged_points\": " + std::to_string(scan.merged.cloud.size()) + "\n}\n";
  files.push_back({"scan.json", text});
  files.push_back({"merged.ply", write_cloud_ply(scan.merged.cloud)});
  return files;
}

}  // namespace partscribe::scan
