#pragma once

#include <memory>
#include <stdexcept>
#include <string>

namespace rclcpp
{
class Parameter
{
public:
    explicit Parameter(const std::string &text) : text_(text) {}
    explicit Parameter(double number) : number_(number), is_number_(true) {}

    double as_double() const
    {
        if (!is_number_)
            throw std::runtime_error("no number");
        return number_;
    }

    const std::string &as_string() const
    {
        if (is_number_)
            throw std::runtime_error("no text");
        return text_;
    }

private:
    std::string text_;
    double number_ = 0;
    bool is_number_ = false;
};

namespace node_interfaces
{
class NodeParametersInterface
{
public:
    using ConstSharedPtr = std::shared_ptr<const NodeParametersInterface>;
    virtual ~NodeParametersInterface() = default;
    virtual bool has_parameter(const std::string &name) const = 0;
    virtual Parameter get_parameter(const std::string &name) const = 0;
};
}  // namespace node_interfaces
}  // namespace rclcpp
