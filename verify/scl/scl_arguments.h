/// The arguments of a call in an Alpha_1 procedure, taken and checked one after the other.
#pragma once

#include <initializer_list>
#include <string>
#include <vector>

#include "verify/scl/scl_value.h"

namespace partscribe::verify {

using SclValues = std::vector<SclValue>;

/// The first argument of a wrong kind is recorded, and all later ones are then empty. `values` must outlive it.
class SclArguments {
 public:
  explicit SclArguments(const SclValues& values) : values_(values) {}

  double number();
  int whole();
  bool truth();
  std::string text();
  Vec3 point();
  Vec3 vector();
  SclGeometryPtr geometry();
  SclGeometryPtr geometry(std::initializer_list<SclGeometryKind> kinds, const char* what);
  const SclValue& any() { return next(); }
  SclValues array(const char* what = "an array");
  std::vector<double> numbers();
  std::vector<Vec3> points_of(const SclValue& value);
  std::vector<std::vector<Vec3>> point_rows();
  std::vector<SclGeometryPtr> geometries(const char* what);

  bool ok() const { return trouble_.empty(); }
  Error error() const { return bad_input(trouble_); }
  /// Remembers the first misfit, with the number of the argument last taken.
  void expected(const std::string& what);
  bool more() const { return at_ < values_.size(); }

 private:
  const SclValue& next();
  const SclValues& values_;
  const SclValue nothing_;
  std::size_t at_ = 0;
  std::string trouble_;
};

}  // namespace partscribe::verify
