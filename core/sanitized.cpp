#include "core/sanitized.h"

// What builds that look for faults are told. A fault ends the program by a signal, as a crash does in any other build:
// whoever runs a reader in a child expects that. OpenCASCADE keeps some memory until the end.
#if defined(__SANITIZE_ADDRESS__)
extern "C" {
const char* __asan_default_options();
const char* __lsan_default_options();
const char* __lsan_default_suppressions();
const char* __asan_default_options() { return "abort_on_error=1:handle_abort=0:handle_segv=0"; }
const char* __lsan_default_options() { return "print_suppressions=0"; }
const char* __lsan_default_suppressions() { return "leak:libTK\n"; }
}
#endif
