#include <filters/filter_base.hpp>
#include <pluginlib/class_list_macros.hpp>

namespace one_joint_filters {
class Half : public filters::FilterBase<double> {
 public:
  bool configure() override { return true; }
  bool update(const double& in, double& out) override {
    out = in / 2;
    return true;
  }
};
}  // namespace one_joint_filters

PLUGINLIB_EXPORT_CLASS(one_joint_filters::Half, filters::FilterBase<double>)
