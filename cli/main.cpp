/// The program: the list of its commands.
#include "cli/commands.h"

int main(int argc, char** argv) {
  using namespace partscribe;
  const std::vector<Command> commands = {
      build_command(),  scan_command(),   fit_command(),     emit_command(),
      verify_command(), report_command(), explain_command(), simulate_command(), views_command(),
  };
  return run_program(argc, argv, commands, PARTSCRIBE_VERSION);
}
