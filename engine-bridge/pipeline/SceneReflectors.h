#pragma once

#include "haptics/array/TransducerArray.h"
#include "haptics/surface/FlatFaces.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::bridge
{

/// The reflectors beside an array: its own, and the faces that a scene has there.
struct SceneReflectors
{
    std::vector<haptics::Reflector> all; ///< those that sound meets; caps and figures know them
    /// Those of them that fields are solved for: all but those of an accuracy above
    /// haptics::kMostCorrectedAccuracy_mm, by which a correction would gain nothing.
    std::vector<haptics::Reflector> corrected;
    std::vector<std::string> problems; ///< what isn't corrected or left out, a sentence each

    bool operator==(const SceneReflectors& other) const
    {
        return all == other.all && corrected == other.corrected && problems == other.problems;
    }
};

/// Returns the reflectors beside \a array, whose own come first, then \a faces, in the array frame.
/// A face of a closed body counts if all transducers are in front of it (to a tenth of them). Left
/// out by name are those beyond haptics::kMostReflectors, and those with values out of range.
SceneReflectors reflectorsBeside(const haptics::TransducerArray& array,
                                 const std::vector<haptics::FlatFace>& faces);

/// Returns true if \a a are \a b, and no corner of one has moved by more than \a tolerance_m.
bool areUnmoved(const std::vector<haptics::FlatFace>& a,
                const std::vector<haptics::FlatFace>& b,
                double tolerance_m);

/// Returns true if \a a are \a b, and no corner of the box around one has moved by more than \a
/// tolerance_m.
bool areUnmoved(const std::vector<haptics::ReflectingBody>& a,
                const std::vector<haptics::ReflectingBody>& b,
                double tolerance_m);

/// Returns a sentence for each of \a reflectors that has some of \a skipped (3 x n, points left
/// out) nearer than a wavelength.
std::vector<std::string> reflectorsNear(const std::vector<haptics::Reflector>& reflectors,
                                        const Eigen::Matrix3Xd& skipped,
                                        double wavelength_m);

} // namespace midair::bridge
