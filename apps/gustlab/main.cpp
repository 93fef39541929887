#include <cstdio>
#include <exception>

#include "commands.hpp"
#include "gustlab/build_info.hpp"
#include "gustlab/errors.hpp"

int main(int argc, char** argv) {
  CLI::App app{"Flies multirotors in simulation and finds the physics that a simulation leaves out"};
  app.require_subcommand(1);
  gustlab::add_diagnose(app);
  gustlab::add_identify(app);
  gustlab::add_score(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const gustlab::UserError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return error.exit_code();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "gustlab: %s\n", error.what());
    return 4;
  }
  return 0;
}
