#pragma once
namespace rclcpp {
enum class FutureReturnCode { SUCCESS, INTERRUPTED, TIMEOUT };
}
