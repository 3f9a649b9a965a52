#include "core/json_text.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/number.h"

namespace partscribe::core {
namespace {

using Json = nlohmann::ordered_json;

bool fits_one_line(const Json& value) {
  if (value.is_object()) return value.size() <= 1 && (value.empty() || value.front().is_primitive());
  if (!value.is_array()) return true;
  for (const auto& item : value) {
    if (item.is_object()) return false;
    if (item.is_array()) {
      if (value.size() > 16) return false;
      for (const auto& inner : item)
        if (inner.is_structured() && !(inner.is_array() && inner.size() <= 4)) return false;
    }
  }
  return true;
}

void print(const Json& value, int depth, bool inline_text, std::string& out) {
  const auto line = [&](int d) { out += '\n', out.append(2 * static_cast<std::size_t>(d), ' '); };
  if (value.is_number_float()) {
    const double number = value.get<double>();
    out += std::isfinite(number) ? print_number(number) : "null";
    return;
  }
  if (value.is_primitive()) {
    out += value.dump(-1, ' ', false, Json::error_handler_t::replace);
    return;
  }
  const bool flat = inline_text || fits_one_line(value);
  out += value.is_object() ? '{' : '[';
  bool first = true;
  for (auto it = value.begin(); it != value.end(); ++it) {
    if (!first) out += flat ? ", " : ",";
    first = false;
    if (!flat) line(depth + 1);
    if (value.is_object()) out += Json(it.key()).dump(-1, ' ', false, Json::error_handler_t::replace) + ": ";
    print(*it, depth + 1, flat, out);
  }
  if (!flat && !value.empty()) line(depth);
  out += value.is_object() ? '}' : ']';
}

}  // namespace

std::string json_text(const Json& value) {
  std::string out;
  print(value, 0, false, out);
  out += '\n';
  return out;
}

}  // namespace partscribe::core
