#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace midair::samples
{

/// Draws what \a plot describes as plot.py reads it into the file \a path (.png, .svg, .pdf), by
/// Debian's Python and its package python3-matplotlib. Returns what went wrong, or an empty text.
std::string drawPlot(const std::string& path, const nlohmann::json& plot);

} // namespace midair::samples
