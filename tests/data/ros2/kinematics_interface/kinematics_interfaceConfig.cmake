add_library(kinematics_interface::kinematics_interface INTERFACE IMPORTED)
target_link_libraries(kinematics_interface::kinematics_interface INTERFACE Eigen3::Eigen rclcpp::rclcpp)
