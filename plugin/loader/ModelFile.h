#pragma once

#include <osg/Node>
#include <osg/ref_ptr>
#include <osgDB/Options>
#include <osgDB/ReaderWriter>

#include <string>
#include <vector>

namespace osgMidair
{

/// A model for MODEL.EXT.haptic, unchanged.
struct ModelFile
{
    osgDB::ReaderWriter::ReadResult read; ///< as of readModel() in <osgMidair/FileFormats>
    /// true: only tagged parts are played; false: all of it
    bool isTagged = false;
    /// of the HapticScene, as assignments; requests, because they are from a file
    std::string settings;
    /// Ignored haptic statements; if there are any, an untagged model may not be played as a whole.
    std::vector<std::string> unfollowed;
};

/// Reads \a name as readModel() does, and its tags and the scene settings of glTF.
ModelFile readModelFile(const std::string& name, const osgDB::Options* options);

} // namespace osgMidair
