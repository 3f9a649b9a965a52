/// Round features that only one side has: holes, bosses and countersinks that are missing, invented or in another
/// place.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "verify/report/findings.h"

namespace partscribe::verify {

/// A place of the scan that lies too far from the artifact.
struct Spot {
  std::uint32_t point = 0, place = 0;
  Vec3 foot = Vec3::Zero();    // nearest on the artifact
  Vec3 normal = Vec3::Zero();  // of the artifact there
  double deviation = 0;        // mm, signed
  double weight = 1;           // points that it stands for
  double area = 0;             // mm^2
  double reach = 0;            // mm, to the next spot of the same patch
  std::int32_t row = -1;
  bool foreign = false;  // the artifact has no such surface, not even elsewhere
};

/// A round feature that only one side has, and the room that it takes.
struct Absence {
  Finding finding;
  Primitive axis;  // a cylinder or cone
  Vec3 center = Vec3::Zero();
  double low = 0, high = 0;
  bool hollow = true;
  bool open = false;  // material is missing about a hole that the artifact has too wide
  std::int32_t row = -1;
};

class Absences {
 public:
  Absences(const Compared& compared, const std::vector<Spot>& spots, const VerifyOptions& options);

  /// One of each, the largest first. Equal features of which both sides have some are counted in one line: "7 holes of
  /// diameter 3 in the artifact, 5 in the scan".
  const std::vector<Finding>& findings() const { return findings_; }

  /// The room of one of these features holds the point.
  bool speak_of(const Vec3& point) const;

 private:
  const Compared& c_;
  const std::vector<Spot>& spots_;
  double tolerance_, far_;
  std::vector<Absence> missing_, extra_, moved_;  // moved_: as the scan has them, and as the artifact does
  std::vector<Finding> findings_;

  void find_missing();
  double seen_from_axis(const Primitive& wall, const std::vector<std::uint32_t>& spots, double close) const;
  void join_pieces(double gap);
  void tell_missing(Absence& a) const;
  void find_extra();
  void join_moved();
  void count_equal();
  bool holds(const Absence& a, const Vec3& point, double margin) const;
  bool equal(const Absence& a, const Absence& b) const;
  const MeshFeature* feature_of(std::int32_t row) const;
  std::string name_of_row(std::int32_t row) const;
};

/// The row with the greatest weight; -1 if there is none.
std::int32_t most_of(const std::map<std::int32_t, double>& rows);

}  // namespace partscribe::verify
