#pragma once

#include <osg/Node>
#include <osg/ref_ptr>
#include <osgDB/Options>

#include <string>
#include <vector>

namespace osgMidair
{

/// A model for MODEL.EXT.haptic, as it is in its file.
struct ModelFile
{
    osg::ref_ptr<osg::Node> node; ///< null: it can't be read
    std::string error;            ///< why; empty: OSG has told it, or there is no such file
    /// true: its tags say what of it is felt; false: all of it is
    bool isTagged = false;
    std::string settings; ///< of the HapticScene, as assignments; from a file, so wishes
    /// What says how something is felt and isn't followed; with it, all of it may not be felt.
    std::vector<std::string> unfollowed;
};

/// Reads \a name: glTF by the kit itself, whatever else reads it, since only so its extras are
/// tags; all else as OSG does.
ModelFile readModelFile(const std::string& name, const osgDB::Options* options);

} // namespace osgMidair
