#pragma once

#include "engine-bridge/HapticObject.h"

#include <map>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Materials by name, from JSON files: those that are shipped, and the user's own, which may
/// replace them.
class MaterialLibrary
{
public:
    MaterialLibrary() = default;

    /// Returns the shipped materials, and on top of them those of the file that the environment
    /// variable OSG_MIDAIR_MATERIALS names. What can't be read is in problems().
    static MaterialLibrary ofUser();

    /// Takes the materials in \a text, which is JSON: {"materials": {NAME: {"stiffness_N_m": ..,
    /// "force_N": .., "radius_m": .., "radiusGrowth": .., "rateGrowth_Hz_m": .., "roughness": ..,
    /// "texturePeriod_m": .., "lowVibration": .., "lowFrequency_Hz": .., "highVibration": ..,
    /// "highFrequency_Hz": ..}}}, each number optional. \a source is its name in messages. Throws
    /// base::InputError, and takes nothing, if something isn't understood or out of range.
    void add(const std::string& text, const std::string& source);

    /// Returns null if there is none of this name; upper and lower case count.
    const HapticMaterial* find(const std::string& name) const;
    std::vector<std::string> names() const; ///< sorted
    /// What was wrong with files, a sentence each.
    const std::vector<std::string>& problems() const { return _problems; }

private:
    void addFile(const std::string& path);

    std::map<std::string, HapticMaterial> _materials;
    std::vector<std::string> _problems;
};

} // namespace midair::bridge
