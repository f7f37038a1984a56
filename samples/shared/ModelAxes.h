#pragma once

#include <string>

namespace midair::samples
{

/// Returns a sentence on how OSG turns the axes of the model \a file (MODEL, MODEL.haptic or
/// MODEL.(..).haptic) with the reader \a options, or an empty text if they stay as in the file.
inline std::string turnedAxes(const std::string& file, const std::string& options = {})
{
    const std::size_t dot = file.rfind(".obj");
    const std::string rest = dot == std::string::npos ? "?" : file.substr(dot + 4);
    const bool isObj = rest.empty() || rest.front() == '.';
    if (!isObj || options.find("noRotation") != std::string::npos) return {};
    return "y is up in OBJ files; OpenSceneGraph rotates it to z. -O noRotation of osgviewer and "
           "midair-check turns that off";
}

} // namespace midair::samples
