#include "verify/report/findings.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/number.h"
#include "core/parallel.h"
#include "verify/compare/clusters.h"
#include "verify/features/absences.h"
#include "verify/report/words.h"

namespace partscribe::verify {
namespace {

constexpr double same_face = 0.7071;        // cosine of 45 degrees
constexpr double flattest_sight = 0.26;     // cosine of 75 degrees
constexpr std::size_t fewest_points = 9;    // that can prove a deviation
constexpr double smallest_said = 0.05;      // mm^2; less is a place, no area
constexpr std::size_t most_unscanned = 20;  // regions that are listed
constexpr std::size_t asked_for_reasons = 60;

class Finder {
 public:
  Finder(const Compared& compared, const std::vector<Finding>& whole, const VerifyOptions& options, int threads)
      : c_(compared),
        options_(options),
        threads_(threads),
        tolerance_(options.tolerance),
        far_(tolerance_ + 3 * compared.source.noise),
        words_(options.tolerance),
        found_(whole) {
    each_ = c_.field.samples.empty() ? 0 : c_.field.summary.area / static_cast<double>(c_.field.samples.size());
  }

  std::vector<Finding> run() {
    find_spots();
    tell_foreign_spots();
    const Absences absences(c_, spots_, options_);
    absences_ = &absences;
    // What is said of a whole feature comes first, patches and rejected points after it.
    for (const auto& f : absences.findings()) found_.push_back(f);
    sort_by_badness(found_, true);
    std::vector<Finding> faults = std::move(found_);
    found_.clear();
    any_ = !faults.empty();
    std::erase_if(spots_, [&](const Spot& s) { return absences.speak_of(c_.source.points[s.point]); });
    group_spots();
    group_samples(Support::contradicted);
    group_rejected();
    sort_by_badness(found_, false);
    faults.insert(faults.end(), found_.begin(), found_.end());
    found_.clear();
    group_samples(Support::not_scanned);
    std::stable_sort(found_.begin(), found_.end(), [](const Finding& a, const Finding& b) { return a.area > b.area; });
    if (found_.size() > most_unscanned) found_.resize(most_unscanned);
    faults.insert(faults.end(), found_.begin(), found_.end());
    return faults;
  }

 private:
  const Compared& c_;
  const VerifyOptions& options_;
  int threads_;
  double tolerance_, far_, each_ = 0;
  Words words_;
  std::vector<Spot> spots_;
  std::vector<Finding> found_;
  const Absences* absences_ = nullptr;
  bool any_ = false;  // something was said of a whole feature

  std::string name_of_row(std::int32_t row) const { return row < 0 ? "" : c_.rows[static_cast<std::size_t>(row)].name; }

  void find_spots() {
    const auto& places = c_.points.places;
    std::vector<double> members(places.size(), 0);
    for (std::size_t i = 0; i < c_.points.place.size(); ++i)
      if (!c_.points.outlier[i]) members[c_.points.place[i]] += 1;
    auto explained = [&](std::uint32_t point) { return c_.explained_point[point] != 0; };
    for (std::uint32_t p = 0; p < places.size(); ++p) {
      if (!places[p].surface || !(std::abs(places[p].mean) > tolerance_) || members[p] == 0 ||
          explained(places[p].point))
        continue;
      Spot spot;
      spot.point = places[p].point, spot.place = p, spot.deviation = places[p].mean, spot.weight = members[p];
      spots_.push_back(spot);
    }
    // Outliers that were found to be a surface of their own stand for themselves.
    for (std::uint32_t i = 0; i < c_.points.distance.size(); ++i) {
      if (!c_.points.crowded[i] || explained(i)) continue;
      Spot spot;
      spot.point = i, spot.place = c_.points.place[i], spot.deviation = c_.points.distance[i];
      spots_.push_back(spot);
    }
    parallel_for(
        spots_.size(), threads_,
        [&](std::size_t begin, std::size_t end) {
          for (std::size_t i = begin; i < end; ++i) {
            Spot& spot = spots_[i];
            const MeshHit hit = c_.surface.closest(c_.source.points[spot.point]);
            spot.foot = hit.point, spot.normal = c_.normals[hit.triangle];
            spot.row = c_.place_row[spot.place];
            const double spacing = std::max(c_.points.places[spot.place].spacing, 1e-9);
            spot.area = spot.weight * spacing * spacing;
            spot.reach = 3 * spacing * std::sqrt(std::max(spot.weight, 1.0));
          }
        },
        256);
  }

  /// A scanned surface is foreign to the artifact if it faces elsewhere than the artifact's nearest face, or if that
  /// face has its own points.
  void tell_foreign_spots() {
    parallel_for(
        spots_.size(), threads_,
        [&](std::size_t begin, std::size_t end) {
          std::vector<Neighbour> near;
          for (std::size_t i = begin; i < end; ++i) {
            Spot& spot = spots_[i];
            if (std::abs(spot.deviation) <= far_) continue;
            const Vec3 normal = scanned_normal(c_.source, spot.point, near);
            if (normal.squaredNorm() > 0.5 && std::abs(normal.dot(spot.normal)) < same_face) {
              spot.foreign = true;
              continue;
            }
            c_.source.tree->nearest(spot.foot, 8, near);
            const double spacing = 1.2 * c_.points.places[spot.place].spacing;
            std::size_t own = 0;
            for (const auto& n : near)
              own += n.sq_distance < spacing * spacing && std::abs(c_.points.distance[n.index]) <= far_ &&
                     c_.normals[c_.points.triangle[n.index]].dot(spot.normal) > same_face;
            spot.foreign = own >= 3 || std::abs(spot.deviation) > step_of();
          }
        },
        256);
  }

  /// A face may lie this far from its place before it counts as another face.
  double step_of() const { return std::max({6 * tolerance_, far_, 4 * c_.source.spacing}); }

  void group_spots() {
    std::vector<Vec3> places;
    std::vector<double> reach;
    for (const auto& s : spots_) places.push_back(c_.source.points[s.point]), reach.push_back(s.reach);
    const auto groups = clusters_of(places, reach, [&](std::uint32_t a, std::uint32_t b) {
      const Spot &p = spots_[a], &q = spots_[b];
      if (p.foreign != q.foreign || (p.deviation > 0) != (q.deviation > 0)) return false;
      return p.foreign || p.row == q.row;
    });
    std::vector<Finding> minor;
    for (const auto& group : groups) {
      Finding f;
      double weight = 0;
      Vec3 middle = Vec3::Zero();
      Box3 box;
      std::map<std::int32_t, double> rows;
      const Spot* worst = &spots_[group.front()];
      for (const auto i : group) {
        const Spot& s = spots_[i];
        weight += s.weight, middle += s.weight * c_.source.points[s.point], f.area += s.area;
        box.add(c_.source.points[s.point]);
        rows[s.row] += s.weight;
        if (std::abs(s.deviation) > std::abs(worst->deviation)) worst = &s;
      }
      const bool few = weight < static_cast<double>(options_.rule == Rule::max ? 1 : fewest_points);
      middle /= weight;
      f.points = static_cast<std::size_t>(weight);
      f.extent = box.diagonal();
      f.deviation = std::abs(worst->deviation);
      f.feature = name_of_row(most_of(rows));
      Vec3 direction = Vec3::Zero();
      double nearest = std::numeric_limits<double>::infinity();
      for (const auto i : group) {
        const Spot& s = spots_[i];
        const Vec3& p = c_.source.points[s.point];
        if (std::abs(s.deviation) > 0.5 * f.deviation) direction += s.weight * (p - s.foot).normalized();
        if ((p - middle).squaredNorm() < nearest) nearest = (p - middle).squaredNorm(), f.place = s.foot;
      }
      f.direction = direction.norm() > 0.2 * weight ? Vec3(direction.normalized()) : Vec3::Zero();
      const bool foreign = spots_[group.front()].foreign;
      const bool outside = spots_[group.front()].deviation > 0;
      f.kind = foreign ? Finding::Kind::missing_material : Finding::Kind::displaced;
      auto over = [&] {
        return (f.area >= smallest_said ? " over " + words_.area(f.area) + " mm^2" : std::string()) + " at " +
               words_.place(f.place);
      };
      if (foreign) {
        f.place = nearest_member(group, middle);
        f.reason = outside ? "the scan shows surface outside of the artifact's material"
                           : "the scan shows surface inside the artifact's material";
        f.text =
            (f.feature.empty() ? std::string() : "near " + f.feature + ": ") + "the scan shows surface up to " +
            words_.mm(f.deviation) + " mm " +
            (outside ? "outside of the artifact (material is missing)" : "inside the artifact (a recess is missing)") +
            over();
      } else {
        f.reason = "the scan has this face elsewhere";
        f.text = (f.feature.empty() ? std::string("the surface") : f.feature) + ": " + words_.mm(f.deviation) +
                 " mm too far " +
                 (f.direction.squaredNorm() > 0.5 ? "in " + direction_text(-f.direction)
                  : outside                       ? "inside"
                                                  : "outside") +
                 over();
      }
      (few ? minor : found_).push_back(std::move(f));
    }
    // A few points are worth a word only where nothing else is.
    if (!any_ && found_.empty() && !minor.empty()) {
      sort_by_badness(minor, false);
      found_.push_back(minor.front());
    }
  }

  Vec3 nearest_member(const std::vector<std::uint32_t>& group, const Vec3& middle) const {
    const Vec3* best = &c_.source.points[spots_[group.front()].point];
    for (const auto i : group) {
      const Vec3& p = c_.source.points[spots_[i].point];
      if ((p - middle).squaredNorm() < (*best - middle).squaredNorm()) best = &p;
    }
    return *best;
  }

  /// A finding about a whole feature speaks of this sample of the artifact's surface.
  bool told(std::uint32_t sample) const {
    const auto row = c_.sample_row[sample];
    return (row >= 0 && c_.explained_row[static_cast<std::size_t>(row)]) || c_.explained_sample[sample] ||
           absences_->speak_of(c_.field.samples[sample].point);
  }

  void group_samples(Support state) {
    const bool contradicted = state == Support::contradicted;
    const bool passed = !c_.field.passages.clusters.empty() || !c_.field.in_plain_view.empty();
    if (contradicted && !passed && c_.field.summary.contradicted <= c_.field.allowed_contradiction) return;
    std::vector<Vec3> places;
    std::vector<std::uint32_t> index;
    for (std::uint32_t i = 0; i < c_.field.samples.size(); ++i)
      if (c_.field.support[i] == state && !(contradicted && told(i)))
        places.push_back(c_.field.samples[i].point), index.push_back(i);
    const std::vector<double> reach(places.size(), 3 * std::sqrt(each_));
    const auto groups = clusters_of(places, reach, [&](std::uint32_t a, std::uint32_t b) {
      return !contradicted || c_.sample_row[index[a]] == c_.sample_row[index[b]];
    });
    const double least = contradicted ? passed ? 0 : 0.5 * c_.field.allowed_contradiction
                                      : std::max(c_.field.allowed_contradiction, 1e-3 * c_.field.summary.area);
    for (const auto& group : groups) {
      Finding f;
      f.kind = contradicted ? Finding::Kind::invented_material : Finding::Kind::not_scanned;
      f.area = each_ * static_cast<double>(group.size());
      if (f.area < least) continue;
      Vec3 middle = Vec3::Zero(), facing = Vec3::Zero();
      Box3 box;
      std::map<std::int32_t, double> rows;
      std::vector<std::uint32_t> members;
      for (const auto i : group) {
        members.push_back(index[i]);
        middle += places[i], box.add(places[i]);
        facing += c_.normals[c_.field.samples[index[i]].triangle];
        rows[c_.sample_row[index[i]]] += 1;
      }
      middle /= static_cast<double>(group.size());
      f.extent = box.diagonal();
      f.feature = name_of_row(most_of(rows));
      f.place = places[group.front()];
      for (const auto i : group)
        if ((places[i] - middle).squaredNorm() < (f.place - middle).squaredNorm()) f.place = places[i];
      const std::string where = words_.area(f.area) + " mm^2 at " + words_.place(f.place);
      const std::string name = f.feature.empty() ? "the surface" : f.feature;
      if (contradicted) {
        if (facing.norm() > 0.2 * static_cast<double>(group.size())) f.direction = -facing.normalized();
        f.reason = why_contradicted(members, f.deviation);
        f.text = name + ": the scan shows no such surface over " + where + ": " + f.reason;
      } else {
        f.reason = why_not_scanned(members);
        f.text = name + ": not scanned over " + where + ": " + f.reason;
      }
      found_.push_back(std::move(f));
    }
  }

  /// Every so many members, at most asked_for_reasons of them.
  std::vector<std::uint32_t> some_of(const std::vector<std::uint32_t>& members) const {
    std::vector<std::uint32_t> some;
    const std::size_t step = members.size() / asked_for_reasons + 1;
    for (std::size_t i = step / 2; i < members.size(); i += step) some.push_back(members[i]);
    return some;
  }

  std::string why_contradicted(const std::vector<std::uint32_t>& members, double& deviation) const {
    if (c_.source.surface && c_.source.closed_surface) {
      for (const auto i : some_of(members))
        deviation = std::max(deviation, c_.source.surface->closest(c_.field.samples[i].point).distance);
      return "the scanned mesh is closed here and up to " + words_.mm(deviation) + " mm away";
    }
    std::vector<std::size_t> votes(c_.source.sights.size(), 0);
    const auto some = some_of(members);
    for (const auto i : some)
      for (std::size_t v = 0; v < votes.size(); ++v) {
        const auto& s = c_.field.samples[i];
        votes[v] += seen_through(c_.source.sights[v], s.point, c_.normals[s.triangle], far_);
      }
    std::string views;
    std::size_t count = 0;
    for (std::size_t v = 0; v < votes.size(); ++v)
      if (2 * votes[v] > some.size() && ++count <= 3) views += (views.empty() ? "" : ", ") + std::to_string(v + 1);
    if (count == 0)
      for (std::size_t v = 0; v < votes.size(); ++v)
        if (votes[v] > 0 && ++count <= 3) views += (views.empty() ? "" : ", ") + std::to_string(v + 1);
    if (count > 3) return counted(count, "view") + " saw what lies behind it";
    if (count > 0) return (count == 1 ? "view " : "views ") + views + " saw what lies behind it";
    if (const auto through = passages_near(some)) return counted(through, "point") + " were seen through it";
    const auto& plain = c_.field.in_plain_view;
    const auto in_plain_view = [&](std::uint32_t i) { return std::binary_search(plain.begin(), plain.end(), i); };
    if (2 * std::count_if(some.begin(), some.end(), in_plain_view) > std::ssize(some))
      return "it lies in plain view of the scanner, and nothing was scanned there";
    return "it would hide surface that was scanned";
  }

  /// Points that were seen through the artifact near the samples.
  std::size_t passages_near(const std::vector<std::uint32_t>& samples) const {
    const double reach = 3 * c_.source.spacing;
    std::size_t count = 0;
    for (const auto& cluster : c_.field.passages.clusters)
      for (const auto m : cluster.members)
        count += std::any_of(samples.begin(), samples.end(), [&](std::uint32_t i) {
          return (c_.field.samples[i].point - c_.field.passages.places[m]).squaredNorm() < reach * reach;
        });
    return count;
  }

  std::string why_not_scanned(const std::vector<std::uint32_t>& members) const {
    if (c_.source.sights.empty())
      return c_.source.surface ? "the scanned mesh is open there"
                               : "no data there; where the scanner stood is not known";
    std::size_t unfaced = 0, hidden = 0, lost = 0;
    const double reach = 4 * std::max(c_.mesh.bounds().diagonal(), 1e-9);
    for (const auto i : some_of(members)) {
      const auto& s = c_.field.samples[i];
      const Vec3& normal = c_.normals[s.triangle];
      bool faced = false, seen = false;
      for (const auto& map : c_.source.sights) {
        const Pose world_from_view = map.view_from_world.inverse();
        const Vec3 back =
            map.parallel ? Vec3(-world_from_view.rotation.col(2)) : Vec3(world_from_view.translation - s.point);
        const Vec3 to_sensor = back.normalized();
        if (normal.dot(to_sensor) < flattest_sight) continue;
        faced = true;
        const double start = 1e-6 * reach + 0.1 * tolerance_;
        const double length = map.parallel ? reach : back.norm();
        if (!c_.surface.first_hit(s.point + start * to_sensor, to_sensor, std::max(length - start, start))) seen = true;
        if (seen) break;
      }
      ++(seen ? lost : faced ? hidden : unfaced);
    }
    if (unfaced >= hidden && unfaced >= lost) return "no view faces it";
    if (hidden >= lost) return "the part itself hides it from the views that face it";
    return "no data although views face it";
  }

  void group_rejected() {
    std::vector<Vec3> places;
    for (std::uint32_t i = 0; i < c_.points.distance.size(); ++i)
      if (c_.points.outlier[i] && c_.source.kept_place[i] != ScanSource::nowhere &&
          std::abs(c_.points.distance[i]) > far_ && !absences_->speak_of(c_.source.points[i]))
        places.push_back(c_.source.points[i]);
    for (const auto& p : c_.source.set_aside)
      if (c_.surface.closest(p).distance > far_) places.push_back(p);
    const std::vector<double> reach(places.size(), 3 * c_.source.spacing);
    std::vector<Vec3> samples;
    for (const auto& s : c_.field.samples) samples.push_back(s.point);
    const KdTree tree(samples);
    for (const auto& group : clusters_of(places, reach, [](std::uint32_t, std::uint32_t) { return true; })) {
      if (group.size() < 20) continue;
      Finding f;
      f.kind = Finding::Kind::rejected;
      f.points = group.size();
      Vec3 middle = Vec3::Zero();
      Box3 box;
      std::map<std::int32_t, double> rows;
      for (const auto i : group) {
        middle += places[i], box.add(places[i]);
        rows[c_.sample_row[tree.nearest_one(places[i]).index]] += 1;
      }
      middle /= static_cast<double>(group.size());
      // In the middle of a ring there is nothing: the member nearest to it stands for all.
      Vec3 member = places[group.front()];
      for (const auto i : group)
        if ((places[i] - middle).squaredNorm() < (member - middle).squaredNorm()) member = places[i];
      const MeshHit hit = c_.surface.closest(member);
      f.place = hit.point, f.extent = box.diagonal(), f.deviation = hit.distance;
      if (hit.distance > 0) f.direction = (member - hit.point) / hit.distance;
      f.area = static_cast<double>(f.points) * c_.source.spacing * c_.source.spacing;
      f.feature = name_of_row(most_of(rows));
      f.reason = "its points were set aside as outliers although they crowd";
      f.text = (f.feature.empty() ? "the surface" : f.feature) + ": " + counted(f.points, "point") +
               " set aside as outliers crowd " + words_.mm(f.deviation) + " mm away at " + words_.place(member);
      found_.push_back(std::move(f));
    }
  }

  /// The worst first: how far off, over how much. A whole feature that only one side has is off by all of its size.
  void sort_by_badness(std::vector<Finding>& findings, bool whole) const {
    auto badness = [&](const Finding& f) {
      const bool one_sided =
          whole && (f.kind == Finding::Kind::missing_material || f.kind == Finding::Kind::invented_material);
      const double size = f.kind == Finding::Kind::rejected
                              ? 0.1 * f.deviation
                              : std::max({f.deviation, tolerance_, one_sided ? f.extent : 0.0});
      return size * std::sqrt(f.area);
    };
    std::stable_sort(findings.begin(), findings.end(),
                     [&](const Finding& a, const Finding& b) { return badness(a) > badness(b); });
  }
};

}  // namespace

Vec3 scanned_normal(const ScanSource& source, std::uint32_t point, std::vector<Neighbour>& near) {
  if (!source.normals.empty() && source.normals[point].squaredNorm() > 0.5) return source.normals[point];
  source.tree->nearest(source.points[point], 12, near);
  Vec3 mean = Vec3::Zero();
  for (const auto& n : near) mean += source.points[n.index];
  mean /= static_cast<double>(near.size());
  Mat3 covariance = Mat3::Zero();
  for (const auto& n : near)
    covariance += (source.points[n.index] - mean) * (source.points[n.index] - mean).transpose();
  Eigen::SelfAdjointEigenSolver<Mat3> solver;
  solver.computeDirect(covariance);
  const Vec3 size = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  if (size[0] > 0.5 * size[1]) return Vec3::Zero();
  return solver.eigenvectors().col(0);
}

std::vector<Finding> all_findings(const Compared& compared, const std::vector<Finding>& whole,
                                  const VerifyOptions& options, int threads) {
  return Finder(compared, whole, options, threads).run();
}

}  // namespace partscribe::verify
