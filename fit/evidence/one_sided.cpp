#include "fit/evidence/one_sided.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "core/statistics.h"
#include "geometry/points/kd_tree.h"

namespace partscribe::fit {

std::vector<double> one_sided_mean(const AllPoints& all, double variance, int threads) {
  constexpr double reach = 1.5;         // as in smoothing_effect: a mean over 3 x 3 pixels
  constexpr std::size_t asked = 4;      // points of a node, at most
  constexpr double usual_factor = 3;    // times what an uneven grid does everywhere
  constexpr double least_share = 0.05;  // of the filter's deviation; a missing pixel of nine makes a seventh
  std::vector<double> result(all.nodes.size(), 0);
  if (!all.by_view || all.rays.empty() || all.foot.empty()) return result;
  const double radius = reach * std::sqrt(2 * variance);
  std::vector<std::vector<std::uint32_t>> members(static_cast<std::size_t>(all.group_count));
  std::vector<Vec3> ray(members.size(), Vec3::Zero());
  for (std::size_t i = 0; i < all.points.size(); ++i) {
    const auto g = static_cast<std::size_t>(all.group[i]);
    members[g].push_back(static_cast<std::uint32_t>(i)), ray[g] += all.rays[i];
  }
  struct Question {
    std::uint32_t node, point;
  };
  std::vector<std::vector<Question>> questions(members.size());
  std::vector<double> asked_of(all.nodes.size(), 0);
  for (std::size_t k = 0; k < all.nodes.size(); ++k) {
    const auto& node = all.nodes[k];
    const std::size_t stride = (node.end - node.begin + asked - 1) / asked;
    for (std::size_t i = node.begin; i < node.end; i += stride)
      questions[static_cast<std::size_t>(all.group[i])].push_back(
          {static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(i)}),
          asked_of[k] += 1;
  }
  std::vector<double> lengths;
  std::vector<std::vector<Vec3>> offsets(members.size());
  for (std::size_t g = 0; g < members.size(); ++g) {
    if (members[g].empty()) continue;
    const Vec3 along = ray[g].normalized();
    const auto across = [&](std::uint32_t i) { return Vec3(all.foot[i] - all.foot[i].dot(along) * along); };
    std::vector<Vec3> own;
    for (const auto i : members[g]) own.push_back(across(i));
    const KdTree tree(own);
    offsets[g].resize(questions[g].size());
    parallel_for(
        questions[g].size(), threads,
        [&](std::size_t begin, std::size_t end) {
          std::vector<Neighbour> near;
          for (std::size_t q = begin; q < end; ++q) {
            const std::uint32_t i = questions[g][q].point;
            const Vec3 place = across(i);
            tree.within(place, radius, near);
            Vec3 sum = Vec3::Zero();
            double count = 0;
            for (const auto& n : near)
              if (all.at.face[members[g][n.index]] == all.at.face[i]) sum += own[n.index] - place, count += 1;
            offsets[g][q] = sum / std::max(count, 1.0);
          }
        },
        64);
    for (const auto& o : offsets[g]) lengths.push_back(o.norm());
  }
  if (lengths.empty()) return result;
  const double usual = usual_factor * median_in_place(lengths) + least_share * std::sqrt(variance);
  for (std::size_t g = 0; g < members.size(); ++g)
    for (std::size_t q = 0; q < questions[g].size(); ++q)
      if (offsets[g][q].norm() > usual) {
        const std::uint32_t k = questions[g][q].node;
        result[k] -= all.jacobian.gradients[k].dot(offsets[g][q]) / asked_of[k];
      }
  return result;
}

}  // namespace partscribe::fit
