/// Whether this build looks for faults of addresses or threads. Such a build reserves far more addresses than it uses,
/// so that a limit on them would end it.
#pragma once

namespace partscribe::core {

#if defined(__has_feature)  // clang's way to say it
#if __has_feature(address_sanitizer)
#define __SANITIZE_ADDRESS__ 1
#endif
#endif

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool sanitized = true;
#else
inline constexpr bool sanitized = false;
#endif

}  // namespace partscribe::core
