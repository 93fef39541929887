// daiml: adaptive control on a learned basis, as Neural-Fly (O'Connell et al., Science Robotics 7(66) 2022): a network that
// was trained to be invariant of the wind gives features, their coefficients adapt in flight by the same law as asindy's.
//
// Features are the network's outputs and a constant 1. Without a network only the constant is left, which is the paper's
// comparison Neural-Fly-Constant. The weights that are shipped were trained by `gustlab train collect_iris`; the file says
// on what, and control/daiml_input.hpp why they fly other vehicles.
#include <algorithm>
#include <mutex>

#include "control/daiml_input.hpp"
#include "control/network.hpp"
#include "control/residual.hpp"
#include "controllers/controllers.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {

namespace {

// The network of a file. All runs of a sweep have the same, and to read it takes a tenth of a run: the last one is kept.
NetworkWeights read_network(const InputFile& file) {
  static std::mutex mutex;
  static std::string bytes;
  static NetworkWeights weights;
  const std::lock_guard lock(mutex);
  if (file.bytes != bytes) {
    weights = parse_network(file.bytes, file.path);
    bytes = file.bytes;
  }
  return weights;
}

class Daiml {
 public:
  void visit(ParameterVisitor& visitor) {
    visitor.file("weights", weights_,
                 {.help = "file that `gustlab train` wrote; \"\": a constant is the only feature"});
    residual_.visit(visitor);
  }

  void reset(const OffboardSetup& setup) {
    vehicle_ = setup.vehicle;
    mixer_ = Mixer(vehicle_);
    network_ = weights_.bytes.empty() ? Network() : Network(read_network(weights_));
    if (!weights_.bytes.empty() && !std::equal(daiml_input_names.begin(), daiml_input_names.end(),
                                               network_.weights().inputs.begin(), network_.weights().inputs.end()))
      throw ParameterError("weights", weights_.path + " looks at other inputs (see its line `inputs`); train it again");
    if (network_.outputs() + 1 > Adaptation::max_terms)
      throw ParameterError("weights",
                           weights_.path + " has more than " + std::to_string(Adaptation::max_terms - 1) + " outputs");
    phi_ = Adaptation::Row::Ones(network_.outputs() + 1);
    residual_.reset(setup, Adaptation::Parameters::Zero(phi_.cols(), 3));
  }

  Vector3 update(const OffboardInput& in) {
    if (network_.outputs() > 0) {
      const auto input =
          daiml_input(vehicle_, mixer_, in.seen.velocity_W_mps, in.seen.attitude_WB, in.seen.rotor_speed_radps);
      phi_.head(network_.outputs()) = network_.evaluate(input).transpose();
    }
    return residual_.update(in, phi_);
  }

  std::vector<std::string_view> telemetry_names() const { return residual_.telemetry_names(); }
  void telemetry(std::span<double> out) const { residual_.telemetry(out); }

 private:
  InputFile weights_{"configs/daiml.weights", {}};
  ResidualAdaptation residual_;
  VehicleModel vehicle_;
  Mixer mixer_;
  Network network_;
  Adaptation::Row phi_;
};

}  // namespace

std::unique_ptr<Controller> make_daiml() { return std::make_unique<Offboard<Daiml>>(); }

}  // namespace gustlab
