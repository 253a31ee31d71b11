// Load a library, make an object of each plugin by the name of its class, and answer lines of standard input by numbers.
//
//     driver LIBRARY DYNAMICS KINEMATICS
//
//     text NAME VALUE, number NAME VALUE     a parameter          begin DESCRIPTION    a file, or - for none
//     H q   c q qd   g q   f qd   tau q qd qdd   pose LINK q   J LINK q   inverse LINK q
//     to_joints LINK q delta_x   to_cartesian LINK q delta_q   difference a b dt
#include <inverse_dynamics_solver/inverse_dynamics_solver.hpp>
#include <kinematics_interface/kinematics_interface.hpp>
#include <pluginlib/class_list_macros.hpp>

#include <dlfcn.h>

#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>
#include <vector>

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Parameters : rclcpp::node_interfaces::NodeParametersInterface
{
    std::map<std::string, rclcpp::Parameter> every;
    bool has_parameter(const std::string &name) const override { return every.count(name) > 0; }
    rclcpp::Parameter get_parameter(const std::string &name) const override { return every.at(name); }
};

static void print(bool fine, const MatrixXd &found)
{
    if (!fine)
        std::printf("refused");
    for (long k = 0; fine && k < found.size(); k++)
        std::printf("%.17g ", found(k / found.cols(), k % found.cols()));
    std::printf("\n");
    std::fflush(stdout);
}

int main(int, char **words)
{
    if (!dlopen(words[1], RTLD_NOW)) {
        std::fprintf(stderr, "%s\n", dlerror());
        return 1;
    }
    const auto dynamics = pluginlib::makers<inverse_dynamics_solver::InverseDynamicsSolver>().at(words[2])();
    const auto kinematics = pluginlib::makers<kinematics_interface::KinematicsInterface>().at(words[3])();
    const auto parameters = std::make_shared<Parameters>();
    for (std::string line; std::getline(std::cin, line);) {
        std::istringstream text(line);
        std::string what, link;
        text >> what;
        if (what == "text" || what == "number") {
            std::string name, value;
            text >> name >> value;
            parameters->every.erase(name);
            parameters->every.emplace(
                name, what == "text" ? rclcpp::Parameter(value) : rclcpp::Parameter(std::stod(value)));
            continue;
        }
        if (what != "H" && what != "c" && what != "g" && what != "f" && what != "tau" && what != "difference")
            text >> link;
        std::vector<VectorXd> given;  // vectors are parted by semicolons
        for (std::string part; std::getline(text, part, ';');) {
            std::istringstream numbers(part);
            std::vector<double> some;
            for (double x; numbers >> x;)
                some.push_back(x);
            given.push_back(Eigen::Map<VectorXd>(some.data(), static_cast<long>(some.size())));
        }
        Eigen::Isometry3d placed;
        Eigen::Matrix<double, 6, Eigen::Dynamic> J;
        Eigen::Matrix<double, Eigen::Dynamic, 6> inverse;
        Eigen::Matrix<double, 6, 1> delta_x = Eigen::Matrix<double, 6, 1>::Zero();
        VectorXd delta_q;
        try {
            if (what == "begin") {
                std::ostringstream description;
                if (link != "-")
                    description << std::ifstream(link).rdbuf();
                const bool fine = kinematics->initialize(description.str(), parameters, "kinematics");
                dynamics->initialize(parameters, "", description.str());
                print(fine, MatrixXd(1, 0));
            } else if (what == "H")
                print(true, dynamics->getInertiaMatrix(given[0]));
            else if (what == "c")
                print(true, dynamics->getCoriolisVector(given[0], given[1]));
            else if (what == "g")
                print(true, dynamics->getGravityVector(given[0]));
            else if (what == "f")
                print(true, dynamics->getFrictionVector(given[0]));
            else if (what == "tau")
                print(true, dynamics->getTorques(given[0], given[1], given[2]));
            else if (what == "pose") {
                const bool fine = kinematics->calculate_link_transform(given[0], link, placed);
                print(fine, fine ? MatrixXd(placed.affine()) : MatrixXd());
            } else if (what == "J") {
                const bool fine = kinematics->calculate_jacobian(given[0], link, J);
                print(fine, J);
            } else if (what == "inverse") {
                const bool fine = kinematics->calculate_jacobian_inverse(given[0], link, inverse);
                print(fine, inverse);
            } else if (what == "to_joints") {
                const bool fine =
                    kinematics->convert_cartesian_deltas_to_joint_deltas(given[0], given[1], link, delta_q);
                print(fine, delta_q);
            } else if (what == "to_cartesian") {
                const bool fine =
                    kinematics->convert_joint_deltas_to_cartesian_deltas(given[0], given[1], link, delta_x);
                print(fine, delta_x);
            } else {
                Eigen::Matrix<double, 7, 1> a = given.at(0), b = given.at(1);
                const bool fine = kinematics->calculate_frame_difference(a, b, given.at(2)(0), delta_x);
                print(fine, delta_x);
            }
        } catch (const std::exception &fault) {
            std::fprintf(stderr, "%s\n", fault.what());
            print(false, MatrixXd());
        }
    }
    return 0;
}
