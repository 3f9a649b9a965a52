/// Checks documents against a JSON Schema, by the keywords that our schemas use.
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace partscribe::testing {

class JsonSchema {
 public:
  using Json = nlohmann::json;
  /// Which keys an object may have: `any`, or only those that the schema names.
  enum class Keys { any, named };

  explicit JsonSchema(const std::filesystem::path& file);

  const Json& document() const { return *document_; }

  /// The first fault and where it is ("document.objects[0].shape: oneOf"); empty if there is none. A keyword that
  /// is not checked here throws std::logic_error: it must not count as true.
  std::string fault(const Json& value, Keys keys) const { return fault(value, *document_, keys, "document"); }

 private:
  std::shared_ptr<const Json> document_;

  std::string fault(const Json& value, const Json& rule, Keys keys, const std::string& at) const;
  std::string fault_by(const std::string& keyword, const Json& argument, const Json& value, const Json& rule, Keys keys,
                       const std::string& at) const;
};

}  // namespace partscribe::testing
