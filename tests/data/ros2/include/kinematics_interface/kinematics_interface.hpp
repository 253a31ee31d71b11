#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <rclcpp/node_interfaces/node_parameters_interface.hpp>

#include <memory>
#include <string>

namespace kinematics_interface
{
class KinematicsInterface
{
public:
    using Vector = Eigen::VectorXd;
    using Vector6 = Eigen::Matrix<double, 6, 1>;
    using Vector7 = Eigen::Matrix<double, 7, 1>;
    using Link = const std::string &;

    virtual ~KinematicsInterface() = default;
    virtual bool initialize(const std::string &description,
                            std::shared_ptr<rclcpp::node_interfaces::NodeParametersInterface> parameters,
                            const std::string &parameters_of) = 0;
    virtual bool convert_cartesian_deltas_to_joint_deltas(const Vector &q, const Vector6 &dx, Link, Vector &dq) = 0;
    virtual bool convert_joint_deltas_to_cartesian_deltas(const Vector &q, const Vector &dq, Link, Vector6 &dx) = 0;
    virtual bool calculate_link_transform(const Vector &q, Link, Eigen::Isometry3d &placed) = 0;
    virtual bool calculate_jacobian(const Vector &q, Link, Eigen::Matrix<double, 6, Eigen::Dynamic> &J) = 0;
    virtual bool calculate_jacobian_inverse(const Vector &q, Link, Eigen::Matrix<double, Eigen::Dynamic, 6> &J) = 0;
    virtual bool calculate_frame_difference(Vector7 &a, Vector7 &b, double dt, Vector6 &dx) = 0;
};
}  // namespace kinematics_interface
