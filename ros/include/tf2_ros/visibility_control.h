#pragma once
#define TF2_ROS_PUBLIC
#define TF2_ROS_LOCAL
#define TF2_ROS_PUBLIC_TYPE
