/// scan.json and sidecars: what the numbers of range images mean and where the views stood.
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <nlohmann/json.hpp>

#include "core/json_nesting.h"
#include "core/lies_within.h"
#include "core/number.h"
#include "scan/read/range_file.h"
#include "scan/read/sources.h"

namespace partscribe::scan {
namespace {

using nlohmann::json;

/// A document with the place of what is being read, for messages.
struct Place {
  std::string where;
  Error expected(const std::string& what, const json& found) const {
    auto text = found.is_null() ? std::string("nothing") : found.dump(-1, ' ', false, json::error_handler_t::replace);
    if (text.size() > 60) text = text.substr(0, 57) + "...";
    return bad_input(where + ": expected " + what + ", found " + text);
  }
};

/// The field of the view, or the one for all views.
const json& field(const json& view, const json& all, const char* name) {
  static const json none;
  if (const auto it = view.find(name); it != view.end()) return *it;
  if (const auto it = all.find(name); it != all.end()) return *it;
  return none;
}

bool usable_number(const json& value) { return value.is_number() && std::abs(value.get<double>()) < 1e15; }

Result<Pose> parse_pose(const json& value, const Place& place) {
  double m[16];
  std::size_t count = 0;
  bool good = value.is_array();
  if (good)
    for (const auto& row : value) {
      const bool nested = row.is_array();
      for (std::size_t i = 0; good && i < (nested ? row.size() : 1); ++i) {
        const auto& number = nested ? row[i] : row;
        good = usable_number(number) && count < 16;
        if (good) m[count++] = number.get<double>();
      }
    }
  if (!good || count != 16 || m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)
    return place.expected("a 4 x 4 matrix, row by row, the last row 0 0 0 1", value);
  Pose pose;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) pose.rotation(r, c) = m[4 * r + c];
    pose.translation[r] = m[4 * r + 3];
  }
  const double error = (pose.rotation.transpose() * pose.rotation - Mat3::Identity()).cwiseAbs().maxCoeff();
  if (!(error < 1e-3) || pose.rotation.determinant() < 0)
    return place.expected("a rotation without scale or mirror", value);
  if (error > 1e-12) {  // rounded in the file: the nearest rotation
    const Eigen::JacobiSVD<Mat3> svd(pose.rotation, Eigen::ComputeFullU | Eigen::ComputeFullV);
    pose.rotation = svd.matrixU() * svd.matrixV().transpose();
  }
  return pose;
}

Result<Pose> pose_of(const json& view, const json& all, bool guess, const Place& place) {
  for (const char* key : {guess ? "initial_guess" : "camera_to_world", guess ? "camera_to_world" : "world_from_view",
                          guess ? "world_from_view" : "initial_guess"})
    if (const auto& value = field(view, all, key); !value.is_null())
      return parse_pose(value, {place.where + "." + key});
  return Pose{};
}

std::optional<Error> numbers(const json& view, const json& all, const Place& place,
                             std::initializer_list<std::pair<const char*, double*>> wanted) {
  for (const auto& [key, to] : wanted) {
    const auto& value = field(view, all, key);
    if (!usable_number(value)) return Place{place.where + "." + key}.expected("a number", value);
    *to = value.get<double>();
  }
  return {};
}

/// A height map: z grows towards the sensor, so that the sensor's frame is the map's turned about x.
std::optional<Error> height_map(const json& view, const json& all, const Place& place, RangeImage& image) {
  const json none = json::object();
  const auto& size = field(view, all, "pixel_size");
  const auto& origin = field(view, all, "origin");
  if (!size.is_object()) return Place{place.where + ".pixel_size"}.expected("an object with x, y and z", size);
  double x = 0, y = 0, z = 0, x0 = 0, y0 = 0, z0 = 0;
  if (auto error = numbers(size, none, {place.where + ".pixel_size"}, {{"x", &x}, {"y", &y}, {"z", &z}})) return error;
  if (origin.is_object())
    if (auto error = numbers(origin, none, {place.where + ".origin"}, {{"x", &x0}, {"y", &y0}, {"z", &z0}}))
      return error;
  if (x == 0 || y == 0 || z == 0) return Place{place.where + ".pixel_size"}.expected("sizes other than 0", size);
  image.projection = Projection::orthographic;
  image.x0 = x0, image.pitch_x = x;
  image.y0 = -y0, image.pitch_y = -y;
  image.z0 = -(z0 + z), image.q = -z;
  const Pose turned{(Mat3() << 1, 0, 0, 0, -1, 0, 0, 0, -1).finished(), Vec3::Zero()};
  image.world_from_view = image.world_from_view * turned;
  return {};
}

/// Fills everything but the codes. `depth`: what they mean, if the file holds depths.
std::optional<Error> parse_meaning(const json& view, const json& all, const Place& place,
                                   const std::optional<DepthSteps>& depth, RangeImage& image) {
  const auto& invalid = field(view, all, field(view, all, "invalid_code").is_null() ? "invalid" : "invalid_code");
  if (!invalid.is_null()) {
    if (!invalid.is_number_integer() || invalid.get<std::int64_t>() < 0 || invalid.get<std::int64_t>() > 65535)
      return Place{place.where + ".invalid_code"}.expected("a code from 0 to 65535", invalid);
    image.invalid_code = static_cast<std::uint16_t>(invalid.get<int>());
  }
  if (!depth && !field(view, all, "pixel_size").is_null()) return height_map(view, all, place, image);
  if (depth) {
    image.z0 = depth->z0, image.q = depth->q, image.invalid_code = 0;
  } else if (const auto& scale = field(view, all, "scale"); !scale.is_null()) {
    double offset = 0, step = 0;
    if (auto error = numbers(view, all, place, {{"scale", &step}})) return error;
    if (!field(view, all, "offset").is_null())
      if (auto error = numbers(view, all, place, {{"offset", &offset}})) return error;
    image.q = step, image.z0 = offset + step;  // code 1
  } else if (auto error = numbers(view, all, place, {{"z0", &image.z0}, {"q", &image.q}})) {
    return error;
  }
  if (image.q == 0) return Place{place.where + ".q"}.expected("a step other than 0", 0);
  if (!field(view, all, "pitch_x").is_null()) {
    image.projection = Projection::orthographic;
    return numbers(view, all, place,
                   {{"x0", &image.x0}, {"y0", &image.y0}, {"pitch_x", &image.pitch_x}, {"pitch_y", &image.pitch_y}});
  }
  image.projection = Projection::pinhole;
  if (const auto& K = field(view, all, "K"); !K.is_null()) {
    const Place here{place.where + ".K"};
    bool good = K.is_array() && K.size() == 3;
    for (std::size_t r = 0; good && r < 3; ++r) {
      good = K[r].is_array() && K[r].size() == 3;
      for (std::size_t c = 0; good && c < 3; ++c) good = usable_number(K[r][c]);
    }
    if (!good || K[0][1] != 0) return here.expected("a 3 x 3 matrix without skew", K);
    image.fx = K[0][0].get<double>(), image.fy = K[1][1].get<double>();
    image.cx = K[0][2].get<double>(), image.cy = K[1][2].get<double>();
  } else if (!field(view, all, "fx").is_null()) {
    if (auto error =
            numbers(view, all, place, {{"fx", &image.fx}, {"fy", &image.fy}, {"cx", &image.cx}, {"cy", &image.cy}}))
      return error;
  } else {
    return bad_input(place.where +
                     ": expected K or fx, fy, cx, cy (pinhole), pitch_x, pitch_y, x0, y0 (orthographic) or pixel_size "
                     "(height map), found none");
  }
  if (!(image.fx != 0 && image.fy != 0)) return bad_input(place.where + ": expected focal lengths other than 0");
  return {};
}

Result<json> parse_document(const std::string& bytes, const std::string& name) {
  std::string_view text = bytes;
  if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
  if (nested_too_deeply(text)) return bad_input(name + ": expected JSON, found a document that is nested too deeply");
  try {
    json document = json::parse(text);
    if (!document.is_object())
      return bad_input(name + ": expected a JSON object, found " + std::string(document.type_name()));
    return document;
  } catch (const json::parse_error& error) {
    return bad_input(name + ", byte " + std::to_string(error.byte) + ": expected JSON, found something else");
  } catch (const json::exception& error) {
    return bad_input(name + ": expected JSON, found a document that is " + error.what());
  }
}

std::string unit_of(const json& view, const json& all) {
  const auto& unit = field(view, all, "unit");
  return unit.is_string() ? unit.get<std::string>() : std::string();
}

std::optional<Error> add_image(const Path& path, const json& view, const json& all, const Place& place, bool guess,
                               Pieces& pieces) {
  const auto bytes = read_source(path, pieces);
  if (!bytes.ok()) return bytes.error();
  auto codes = parse_range_file(*bytes, path.filename().string());
  if (!codes.ok()) return codes.error();
  RangeImage image;
  for (const auto& [key, size] : {std::pair{"width", codes->width}, std::pair{"height", codes->height}})
    if (const auto& stated = field(view, all, key); stated.is_number_integer() && stated.get<std::int64_t>() != size)
      return Place{place.where + "." + key}.expected(std::to_string(size) + " as " + path.filename().string() + " has",
                                                     stated);
  const auto pose = pose_of(view, all, guess, place);
  if (!pose.ok()) return pose.error();
  image.world_from_view = *pose;
  if (auto error = parse_meaning(view, all, place, codes->depth, image)) return error;
  image.width = codes->width, image.height = codes->height;
  image.codes = std::move(codes->codes);
  add_range_image(image, path.filename().string(), unit_of(view, all), pieces);
  return {};
}

bool is_file(const Path& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored);
}

}  // namespace

void add_pose_covariance(const Path& cloud, Pieces& pieces) {
  const Path path = cloud.parent_path() / "poses.json";
  std::error_code failure;
  if (!std::filesystem::is_regular_file(path, failure)) return;
  const auto text = read_file(path);
  if (!text.ok() || nested_too_deeply(*text)) return;
  const json poses = json::parse(*text, nullptr, false);
  if (!poses.is_object() || poses.value("cloud_sha256", json()) != pieces.sha256.back()) return;
  const json rows = poses.value("covariance_between_views", json()), center = poses.value("center", json());
  const auto size = static_cast<Eigen::Index>(rows.size());
  bool good = rows.is_array() && size > 0 && size % 6 == 0 && center.is_array() && center.size() == 3;
  for (std::size_t r = 0; good && r < rows.size(); ++r) good = rows[r].is_array() && rows[r].size() == r + 1;
  PoseCovariance found;
  found.matrix.setZero(good ? size : 0, good ? size : 0);
  for (Eigen::Index k = 0; good && k < 3; ++k) {
    good = usable_number(center[static_cast<std::size_t>(k)]);
    if (good) found.center[k] = center[static_cast<std::size_t>(k)].get<double>();
  }
  for (Eigen::Index r = 0; good && r < size; ++r) {
    for (Eigen::Index c = 0; good && c <= r; ++c) {
      const json& number = rows[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)];
      good = usable_number(number) && (r != c || number.get<double>() >= 0);
      if (good) found.matrix(r, c) = found.matrix(c, r) = number.get<double>();
    }
  }
  if (!good) {
    pieces.warnings.push_back(
        path.string() +
        ": expected a center and the lower triangle of a covariance of six numbers for each view, found "
        "something else; sigma does without what the poses add");
    return;
  }
  pieces.files.push_back(path.filename().string());
  pieces.sha256.push_back(sha256(*text));
  pieces.pieces.back().pose_covariance = std::move(found);
}

std::optional<Error> add_scan_json(const Path& path, const ReadOptions& options, Context& context, Pieces& pieces) {
  const auto bytes = read_source(path, pieces);
  if (!bytes.ok()) return bytes.error();
  const auto name = path.filename().string();
  const auto document = parse_document(*bytes, name);
  if (!document.ok()) return document.error();
  const json& all = *document;
  const bool height_maps = !all.contains("views") && all.contains("images");
  const char* list = height_maps ? "images" : "views";
  const auto views = all.find(list);
  if (views == all.end() || !views->is_array() || views->empty())
    return Place{name}.expected("a list \"views\" or \"images\"", views == all.end() ? json() : *views);
  const auto folder = path.parent_path();
  std::size_t index = 0;
  for (const auto& view : *views) {
    const Place place{name + ", " + list + "[" + std::to_string(index) + "]"};
    if (!view.is_object()) return place.expected("an object", view);
    std::string image, points;
    for (const char* key : {"png", "pgm", "npy", "ply", "file"}) {
      const auto it = view.find(key);
      if (it == view.end()) continue;
      if (!it->is_string()) return Place{place.where + "." + key}.expected("a file name", *it);
      const auto file = it->get<std::string>();
      if (!lies_within(folder / file, folder))
        return Place{place.where + "." + key}.expected("a file in the folder of " + name + " or below", *it);
      const auto suffix = Path(file).extension();
      (is_range_file(suffix.string()) ? image : points) = file;
    }
    if (height_maps && image.empty() && points.empty()) {
      const auto number = view.value("index", json(index));
      image = "range_" +
              (number.is_number_unsigned() ? std::to_string(number.get<std::uint64_t>()) : std::to_string(index)) +
              ".png";
    }
    if (image.empty() && points.empty()) return place.expected("a file (png, pgm, npy, ply or file)", view);
    context.report("reading " + name, static_cast<double>(index) / static_cast<double>(views->size()));
    ++index;
    if (!image.empty() && (points.empty() || is_file(folder / image))) {
      if (auto error = add_image(folder / image, view, all, place, options.initial_guess, pieces)) return error;
      continue;
    }
    const auto pose = pose_of(view, all, options.initial_guess, place);
    if (!pose.ok()) return pose.error();
    const bool pinhole = !field(view, all, "K").is_null() || field(view, all, "projection") == "pinhole";
    if (auto error = add_geometry(folder / points, *pose, pinhole, unit_of(view, all), context, pieces)) return error;
  }
  return {};
}

std::optional<Error> add_image_with_sidecar(const Path& path, const ReadOptions& options, Pieces& pieces) {
  const auto name = path.filename().string();
  Path sidecar = path;
  sidecar.replace_extension(".json");
  if (!is_file(sidecar)) sidecar = path.string() + ".json";
  if (!is_file(sidecar)) {
    if (!is_file(path)) return bad_input(name + ": expected a file, found none at " + path.string());
    Path hint = path;
    return bad_input(name + ": expected " + hint.replace_extension(".json").filename().string() +
                     " beside it, which says what camera it is from and what its codes mean, found none");
  }
  const auto bytes = read_source(sidecar, pieces);
  if (!bytes.ok()) return bytes.error();
  const auto document = parse_document(*bytes, sidecar.filename().string());
  if (!document.ok()) return document.error();
  return add_image(path, *document, json::object(), {sidecar.filename().string()}, options.initial_guess, pieces);
}

}  // namespace partscribe::scan
