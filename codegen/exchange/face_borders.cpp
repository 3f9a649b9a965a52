#include "codegen/exchange/face_borders.h"

#include <algorithm>
#include <map>
#include <set>

#include "core/ensure.h"

namespace partscribe::codegen {
namespace {

using HalfEdge = std::pair<std::uint32_t, std::uint32_t>;  // from, to: as its triangle runs

}  // namespace

FaceBorders face_borders(const FacedBody& body) {
  const auto& triangles = body.mesh.triangles;
  std::map<HalfEdge, std::uint32_t> triangle_of;
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) triangle_of[{triangles[t][k], triangles[t][(k + 1) % 3]}] = t;
  const auto face = [&](const HalfEdge& e) { return body.face_of[triangle_of.at(e)]; };
  const auto twin = [](const HalfEdge& e) { return HalfEdge{e.second, e.first}; };
  const auto is_border = [&](const HalfEdge& e) { return face(e) != face(twin(e)); };
  /// The edge after `e` around its triangle.
  const auto after = [&](const HalfEdge& e) {
    const auto& t = triangles[triangle_of.at(e)];
    for (int k = 0; k < 3; ++k)
      if (t[k] == e.second) return HalfEdge{e.second, t[(k + 1) % 3]};
    return e;
  };

  // Where three faces or more meet, or one border touches another, curves begin and end.
  std::vector<std::uint32_t> borders_at(body.mesh.vertices.size(), 0);
  std::vector<HalfEdge> borders;
  for (const auto& [edge, t] : triangle_of)
    if (is_border(edge)) borders.push_back(edge), ++borders_at[edge.first];
  std::vector<std::uint8_t> corner(body.mesh.vertices.size(), 0);
  for (std::size_t v = 0; v < corner.size(); ++v) corner[v] = borders_at[v] > 2;

  FaceBorders result;
  result.loops.resize(body.faces.size());
  std::set<HalfEdge> walked;
  std::map<HalfEdge, BorderUse> use_of;  // by the first half-edge of a curve, in either direction
  for (const auto& begin : borders) {
    if (walked.contains(begin)) continue;
    std::vector<HalfEdge> loop;
    for (HalfEdge e = begin; walked.insert(e).second;) {
      loop.push_back(e);
      for (e = after(e); !is_border(e);) e = after(twin(e));
    }
    // Begin at a corner; a loop without one begins where its least vertex is, for both of its faces alike.
    auto first = std::find_if(loop.begin(), loop.end(), [&](const HalfEdge& e) { return corner[e.first]; });
    if (first == loop.end()) {
      first = std::min_element(loop.begin(), loop.end());
      corner[first->first] = 1;
    }
    std::rotate(loop.begin(), first, loop.end());
    std::vector<BorderUse> uses;
    for (std::size_t i = 0; i < loop.size();) {
      std::size_t end = i + 1;
      while (end < loop.size() && !corner[loop[end].first]) ++end;
      if (const auto known = use_of.find(loop[i]); known != use_of.end()) {
        uses.push_back(known->second);
      } else {
        BorderCurve curve;
        for (std::size_t k = i; k < end; ++k) curve.vertices.push_back(loop[k].first);
        curve.vertices.push_back(loop[end - 1].second);
        curve.left = face(loop[i]), curve.right = face(twin(loop[i]));
        const auto number = static_cast<std::uint32_t>(result.curves.size());
        uses.push_back({number, true});
        use_of[twin(loop[end - 1])] = {number, false};
        result.curves.push_back(std::move(curve));
      }
      i = end;
    }
    result.loops[face(begin)].push_back(std::move(uses));
  }
  return result;
}

}  // namespace partscribe::codegen
