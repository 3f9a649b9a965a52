#include "geometry/segment/label_faces.h"

#include <algorithm>
#include <cmath>

#include "geometry/segment/faces.h"

namespace partscribe::geometry {
namespace {

constexpr int rounds = 4;
constexpr double apart_cost = 0.4;   // of each of the neighbours that belongs to another face
constexpr double angle_unit = 0.14;  // rad
constexpr std::size_t least_members = 12;

void collect(std::vector<GrownFace>& faces, const std::vector<std::uint32_t>& label) {
  for (auto& face : faces) face.members.clear();
  for (std::uint32_t i = 0; i < label.size(); ++i)
    if (label[i] != no_face) faces[label[i]].members.push_back(i);
}

}  // namespace

void drop_faces(std::vector<GrownFace>& faces, std::vector<std::uint32_t>& label, std::size_t least) {
  std::vector<std::uint32_t> number(faces.size(), no_face);
  std::uint32_t kept = 0;
  for (std::uint32_t f = 0; f < faces.size(); ++f)
    if (faces[f].members.size() >= least) number[f] = kept++;
  for (auto& l : label)
    if (l != no_face) l = number[l];
  std::erase_if(faces, [&](const GrownFace& face) { return face.members.size() < least; });
}

double label_cost(double residual, double turn) {
  const double angle = turn / angle_unit;
  return std::min(0.5 * residual * residual, 30.0) + 0.25 * angle * angle;
}

std::vector<std::uint32_t> label_samples(const FaceSamples& samples, std::vector<GrownFace>& faces) {
  std::vector<std::uint32_t> label(samples.size(), no_face);
  for (std::uint32_t f = 0; f < faces.size(); ++f)
    for (const auto i : faces[f].members) label[i] = f;
  for (int round = 0; round < rounds; ++round) {
    const std::vector<std::uint32_t> before = label;
    std::vector<std::uint32_t> candidates;
    for (std::uint32_t i = 0; i < samples.size(); ++i) {
      candidates.clear();
      bool mixed = false;
      const auto consider = [&](std::uint32_t j) {
        if (before[j] != before[i]) mixed = true;
        if (before[j] != no_face && std::find(candidates.begin(), candidates.end(), before[j]) == candidates.end())
          candidates.push_back(before[j]);
      };
      consider(i);
      for (const auto j : samples.around(i)) consider(j);
      if (!mixed && round > 0) continue;
      for (const auto j : samples.around(i))
        if (mixed)
          for (const auto k : samples.around(j)) consider(k);
      const auto apart = [&](std::uint32_t face) {
        double sum = 0;
        for (const auto j : samples.around(i)) sum += before[j] != face;
        return apart_cost * sum;
      };
      double best = outlier_cost + apart(no_face);
      std::uint32_t chosen = no_face;
      for (const auto f : candidates) {
        const double cost = label_cost(residual_of(samples, i, faces[f].surface),
                                       turn_of(samples, i, faces[f].surface, faces[f].sense)) +
                            apart(f);
        if (cost < best) best = cost, chosen = f;
      }
      label[i] = chosen;
    }
    collect(faces, label);
    drop_faces(faces, label, least_members);
    for (auto& face : faces)
      if (const auto again = fit_samples(samples, face.surface.kind, face.members, face.surface)) {
        face.surface = *again;
        face.sense = sense_of(samples, face.surface, face.members);
      }
  }
  return label;
}

}  // namespace partscribe::geometry
