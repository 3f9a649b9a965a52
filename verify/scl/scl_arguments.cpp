#include "verify/scl/scl_arguments.h"

#include <cmath>

namespace partscribe::verify {

double SclArguments::number() {
  double n = 0;
  if (!number_of(next(), n)) expected("a number");
  // Beyond a kilometre times a thousand the kernel's tolerances mean nothing.
  if (std::abs(n) > 1e9) expected("a number of at most 1000000000.0 in size"), n = 0;
  return n;
}

int SclArguments::whole() {
  const auto* n = next().as<std::int64_t>();
  if (!n || *n < -1'000'000 || *n > 1'000'000) {
    expected("a whole number");
    return 0;
  }
  return static_cast<int>(*n);
}

bool SclArguments::truth() {
  const auto* b = next().as<bool>();
  if (!b) expected("true or false");
  return b && *b;
}

std::string SclArguments::text() {
  const auto* s = next().as<std::string>();
  if (!s) expected("a string");
  return s ? *s : std::string();
}

Vec3 SclArguments::point() {
  const auto* p = next().as<SclPoint>();
  if (!p) expected("a point");
  return p ? p->at : Vec3(0, 0, 0);
}

Vec3 SclArguments::vector() {
  const auto* v = next().as<SclVector>();
  if (!v) expected("a vector");
  return v ? v->along : Vec3(0, 0, 0);
}

SclGeometryPtr SclArguments::geometry() {
  const auto* g = next().as<SclGeometryPtr>();
  if (!g) expected("an object");
  return g ? *g : nullptr;
}

SclGeometryPtr SclArguments::geometry(std::initializer_list<SclGeometryKind> kinds, const char* what) {
  const auto* g = next().as<SclGeometryPtr>();
  for (const auto kind : kinds)
    if (g && kind_of(**g) == kind) return *g;
  expected(what);
  return nullptr;
}

SclValues SclArguments::array(const char* what) {
  const auto* a = next().as<SclArray>();
  if (!a) expected(what);
  return a ? **a : SclValues();
}

std::vector<double> SclArguments::numbers() {
  std::vector<double> result;
  for (const auto& v : array("an array of numbers")) {
    double n = 0;
    if (!number_of(v, n)) expected("numbers only in the array");
    result.push_back(n);
  }
  return result;
}

std::vector<Vec3> SclArguments::points_of(const SclValue& value) {
  std::vector<Vec3> result;
  const auto* a = value.as<SclArray>();
  if (!a) {
    expected("an array of points");
    return result;
  }
  for (const auto& v : **a) {
    const auto* p = v.as<SclPoint>();
    if (p)
      result.push_back(p->at);
    else
      expected("points only in the array");
  }
  return result;
}

std::vector<std::vector<Vec3>> SclArguments::point_rows() {
  std::vector<std::vector<Vec3>> rows;
  for (const auto& row : array("an array of arrays of points")) rows.push_back(points_of(row));
  return rows;
}

std::vector<SclGeometryPtr> SclArguments::geometries(const char* what) {
  std::vector<SclGeometryPtr> result;
  const SclValue& value = next();
  if (const auto* one = value.as<SclGeometryPtr>()) return {*one};
  const auto* a = value.as<SclArray>();
  if (!a)
    expected(what);
  else
    for (const auto& v : **a) {
      const auto* g = v.as<SclGeometryPtr>();
      if (g)
        result.push_back(*g);
      else
        expected(what);
    }
  return result;
}

void SclArguments::expected(const std::string& what) {
  if (!trouble_.empty()) return;
  const SclValue& found = at_ <= values_.size() && at_ > 0 ? values_[at_ - 1] : nothing_;
  trouble_ = "argument " + std::to_string(at_) + ": expected " + what + ", found " + description_of(found);
}

const SclValue& SclArguments::next() {
  if (at_ >= values_.size()) return ++at_, nothing_;
  return values_[at_++];
}

}  // namespace partscribe::verify
