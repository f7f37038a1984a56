#pragma once

#include "engine-bridge/HapticObject.h"

#include <map>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Materials by name, from JSON files: the shipped ones and the user's own, which may replace them.
class MaterialLibrary
{
public:
    MaterialLibrary() = default;

    /// Returns the shipped materials and those of the file in the environment variable
    /// OSG_MIDAIR_MATERIALS, which take precedence. Unreadable files are in problems().
    static MaterialLibrary ofUser();

    /// Adds the materials in the JSON \a text: {"materials": {NAME: {"stiffness_N_m": ..,
    /// "force_N": .., "radius_m": .., "radiusGrowth": .., "rateGrowth_Hz_m": .., "roughness": ..,
    /// "texturePeriod_m": .., "lowVibration": .., "lowFrequency_Hz": .., "highVibration": ..,
    /// "highFrequency_Hz": ..}}}, each number optional. \a source is its name in messages. Throws
    /// base::InputError, and adds nothing, if the text is invalid or a number out of range.
    void add(const std::string& text, const std::string& source);

    /// Returns null for an unknown name; case matters.
    const HapticMaterial* find(const std::string& name) const;
    std::vector<std::string> names() const; ///< sorted
    /// Problems of files, one sentence each.
    const std::vector<std::string>& problems() const { return _problems; }

private:
    void addFile(const std::string& path);

    std::map<std::string, HapticMaterial> _materials;
    std::vector<std::string> _problems;
};

} // namespace midair::bridge
