#pragma once
#include <memory>

#include "polyarm/controllers/controller.hpp"

namespace polyarm::controllers {

/// Filters states and exports the results as states, as ros2_control's ChainedFilter does: each of
/// `input_interfaces` goes through its filters to the one of `output_interfaces` at the same place,
/// `<controller>/<output>`. NaN and infinity are passed over: the output stays. Outputs begin with NaN.
class ChainedFilter : public Controller {
 public:
  /// One step of a chain; real-time but for the constructor.
  class Step {
   public:
    virtual ~Step() = default;
    virtual double update(double value) noexcept = 0;
    virtual void reset() noexcept = 0;
  };

  CallbackReturn on_configure(ControllerContext& context) override;
  CallbackReturn on_activate(const Cycle& cycle) noexcept override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;

 private:
  struct Way {
    std::size_t input = 0, output = 0;
    std::vector<std::unique_ptr<Step>> steps;
  };
  void read_chain(ControllerContext& context, const std::string& prefix, Way& way);

  std::vector<Way> ways_;
};

}  // namespace polyarm::controllers
