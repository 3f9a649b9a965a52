#include "cli/report/report_scene.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "core/number.h"
#include "core/statistics.h"
#include "geometry/points/kd_tree.h"

namespace partscribe::cli {
namespace {

/// The part of a surface that lies across each direction: the mean of n n^T over the artifact's area, or without one
/// over the points.
Mat3 facing_of(const ArtifactVerdict* artifact, const PointCloud& cloud) {
  Mat3 sum = Mat3::Zero();
  if (artifact) {
    const TriangleMesh& mesh = artifact->mesh;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Vec3 n = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
      if (n.norm() > 0) sum += n * n.transpose() / n.norm();
    }
  } else {
    for (const auto& n : cloud.normals) sum += n * n.transpose();
  }
  return sum.trace() > 0 ? Mat3(sum / sum.trace()) : sum;
}

/// Looks at a plate so that its large face is seen: from another corner if it shows little more than an edge from here.
void turn_to_large_face(ReportView& view, const Mat3& facing) {
  constexpr double plate = 0.5, edge = 0.4;
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(facing);
  const Vec3 normal = axes.eigenvectors().col(2);
  const auto seen = [&](const Vec3& to_eye) { return std::abs(normal.dot(to_eye.normalized())); };
  if (axes.eigenvalues()[2] < plate || seen(view.to_eye) > edge) return;
  const std::pair<const char*, Vec3> corners[] = {{"from the right, front and above", {1, -0.75, 0.7}},
                                                  {"from the left, front and above", {-1, -0.75, 0.7}},
                                                  {"from the front, left and above", {-0.75, -1, 0.7}}};
  for (const auto& [words, to_eye] : corners)
    if (seen(to_eye) > seen(view.to_eye)) view.words = words, view.to_eye = to_eye;
}

/// The mean of the normals: long for a surface that was seen from one side only.
Vec3 mean_normal(const PointCloud& cloud) {
  Vec3 sum = Vec3::Zero();
  for (const auto& n : cloud.normals) sum += n;
  return cloud.normals.empty() ? sum : Vec3(sum / static_cast<double>(cloud.normals.size()));
}

/// Median distance between neighbours, from some hundred points.
double spacing_of(const PointCloud& cloud) {
  if (cloud.size() < 2) return 0;
  const KdTree tree(cloud.points);
  std::vector<double> distances;
  std::vector<Neighbour> found;
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / 400);
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    tree.nearest(cloud.points[i], 5, found);
    distances.push_back(std::sqrt(found.back().sq_distance));
  }
  return median_in_place(distances);
}

std::vector<ReportView> views_of(const std::optional<Model>& model, const ArtifactVerdict* artifact,
                                 const PointCloud& cloud) {
  const Pose scan_from_part = model && model->as_scanned ? evaluate(model->scan_from_part, values_of(*model)) : Pose{};
  std::vector<ReportView> views = {{"overview", "from the front, right and above", {0.75, -1, 0.7}, {0, 0, 1}},
                                   {"front", "from the front", {0, -1, 0}, {0, 0, 1}},
                                   {"right", "from the right", {1, 0, 0}, {0, 0, 1}},
                                   {"back", "from the back", {0, 1, 0}, {0, 0, 1}},
                                   {"left", "from the left", {-1, 0, 0}, {0, 0, 1}},
                                   {"top", "from above", {0, 0, 1}, {0, 1, 0}},
                                   {"bottom", "from below", {0, 0, -1}, {0, 1, 0}}};
  const Mat3& rotation = scan_from_part.rotation;
  turn_to_large_face(views.front(), rotation.transpose() * facing_of(artifact, cloud) * rotation);
  for (auto& view : views) view.to_eye = rotation * view.to_eye, view.up = rotation * view.up;
  // A scan from one side only is looked at from that side first.
  if (const Vec3 facing = mean_normal(cloud); facing.norm() > 0.5) {
    auto& first = views.front();
    first.words = "from the side of the scanner";
    first.to_eye = facing.normalized();
    if (std::abs(first.to_eye.dot(first.up)) > 0.9) first.up = rotation * Vec3(0, 1, 0);
  }
  return views;
}

constexpr double detail_of_others = 0.6;  // all of them together, of what the first shows; a page stays within 5 MB

/// Fills in what follows from the scene's artifact.
void draw(ReportScene& scene, Context& context) {
  scene.deviations = deviations_of(*scene.cloud, scene.artifact);
  if (scene.deviations.empty()) return;
  scene.features = features_of(*scene.cloud, *scene.artifact);
  SurfaceOptions options;
  options.max_error = 0.25 * scene.tolerance;
  options.most_vertices = static_cast<std::size_t>(scene.detail * static_cast<double>(options.most_vertices));
  scene.surface = deviation_surface(*scene.artifact, *scene.cloud, scene.deviations, options, context);
}

}  // namespace

const ArtifactVerdict* drawn_artifact(const Verdict& verdict) {
  const ArtifactVerdict* drawn = nullptr;
  for (const auto& artifact : verdict.artifacts)
    if (!artifact.mesh.empty() &&
        (!drawn || (artifact.verdict == verdict.verdict && drawn->verdict != verdict.verdict)))
      drawn = &artifact;
  return drawn;
}

std::vector<float> deviations_of(const PointCloud& cloud, const ArtifactVerdict* artifact) {
  if (!artifact) return {};
  const auto& given = artifact->point_deviation;
  std::vector<float> result(cloud.size(), std::numeric_limits<float>::quiet_NaN());
  // What is farther off than the largest judged deviation was not judged: the verifier set it aside as an outlier.
  const double judged = artifact->data_to_model.points ? artifact->data_to_model.local_max * (1 + 1e-6) + 1e-9
                                                       : std::numeric_limits<double>::infinity();
  std::size_t next = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!cloud.rejected.empty() && cloud.rejected[i]) continue;
    if (next == given.size()) return {};
    if (std::abs(given[next]) <= judged) result[i] = given[next];
    ++next;
  }
  return next == given.size() ? result : std::vector<float>();
}

ReportScene report_scene(const std::optional<Model>& model, const Verdict& verdict, const PointCloud& cloud,
                         Context& context) {
  ReportScene scene;
  scene.cloud = &cloud;
  scene.artifact = drawn_artifact(verdict);
  scene.tolerance = verdict.tolerance;
  scene.spacing = spacing_of(cloud);
  scene.views = views_of(model, scene.artifact, cloud);
  std::vector<const ArtifactVerdict*> others;
  for (const auto& artifact : verdict.artifacts)
    if (&artifact != scene.artifact && !artifact.mesh.empty()) others.push_back(&artifact);
  const ReportScene plain = scene;
  for (const auto* artifact : others) {
    ReportScene other = plain;
    other.artifact = artifact;
    other.detail = detail_of_others / static_cast<double>(others.size());
    draw(other, context);
    if (!other.surface.empty()) scene.others.push_back(std::move(other));
  }
  draw(scene, context);
  return scene;
}

ReportScene plain_scene(const ArtifactVerdict& geometry, const PointCloud& cloud, const std::optional<Model>& model,
                        Context& context) {
  ReportScene scene;
  scene.cloud = &cloud;
  scene.artifact = geometry.mesh.empty() ? nullptr : &geometry;
  scene.spacing = spacing_of(cloud);
  scene.views = views_of(model, scene.artifact, cloud);
  if (scene.artifact) {
    SurfaceOptions options;
    options.max_error = 1e-3 * geometry.mesh.bounds().diagonal();
    scene.surface = deviation_surface(geometry, cloud, {}, options, context);
  }
  return scene;
}

const std::vector<std::string>& view_words() {
  static const std::vector<std::string> words = {"iso", "front", "right", "back", "left", "top", "bottom"};
  return words;
}

std::optional<Vec3> direction_in(const std::string& text) {
  Vec3 direction;
  std::istringstream list(text);
  for (int k = 0; k < 3; ++k) {
    std::string word;
    std::getline(list, word, ',');
    const auto number = parse_number(word);
    if (!number) return {};
    direction[k] = *number;
  }
  if (!list.eof() || !(direction.norm() > 0)) return {};
  return direction.normalized();
}

ReportView view_named(const std::string& word, const ReportScene& scene) {
  const auto side = [&](const std::string& name) {
    return *std::find_if(scene.views.begin(), scene.views.end(), [&](const auto& view) { return view.name == name; });
  };
  if (word == "iso")
    return {word, "from the front, right and above", side("front").to_eye + side("right").to_eye + side("top").to_eye,
            side("top").to_eye};
  if (const auto direction = direction_in(word))
    return {"view", "from (" + word + ")", *direction, std::abs(direction->z()) > 0.99 ? Vec3(0, 1, 0) : Vec3(0, 0, 1)};
  return side(word);
}

}  // namespace partscribe::cli
