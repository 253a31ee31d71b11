#pragma once

#include <cstdio>
#include <string>

namespace rclcpp
{
struct Logger
{
    std::string name;
    const char *get_name() const { return name.c_str(); }
};

inline Logger get_logger(const std::string &name)
{
    return Logger{name};
}
}  // namespace rclcpp

#define RCLCPP_ERROR(logger, ...) \
    (std::fprintf(stderr, "[%s] ", (logger).get_name()), std::fprintf(stderr, __VA_ARGS__), std::fputc('\n', stderr))
