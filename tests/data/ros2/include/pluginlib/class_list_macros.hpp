#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>

namespace pluginlib
{
/** What makes an object of a base, by the name of its class; one table for all libraries that are loaded. */
template <class Base>
std::map<std::string, std::function<std::shared_ptr<Base>()>> &makers()
{
    static std::map<std::string, std::function<std::shared_ptr<Base>()>> every;
    return every;
}
}  // namespace pluginlib

#define PLUGINLIB_NAMED(line) pluginlib_of_line_##line
#define PLUGINLIB_JOINED(line) PLUGINLIB_NAMED(line)
#define PLUGINLIB_EXPORT_CLASS(Derived, Base) \
    static const bool PLUGINLIB_JOINED(__LINE__) = \
        pluginlib::makers<Base>().emplace(#Derived, [] { return std::make_shared<Derived>(); }).second;
