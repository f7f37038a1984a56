#pragma once

#include <osg/BoundingBox>
#include <osg/Node>
#include <osg/ref_ptr>
#include <osgDB/Options>
#include <osgDB/ReaderWriter>

#include <string>
#include <vector>

namespace osgMidair
{

/// A model for MODEL.EXT.haptic, as it is in its file.
struct ModelFile
{
    osgDB::ReaderWriter::ReadResult read; ///< as of readModel() in <osgMidair/FileFormats>
    /// true: its tags say what of it is felt; false: all of it is
    bool isTagged = false;
    std::string settings; ///< of the HapticScene, as assignments; from a file, so wishes
    /// What says how something is felt and isn't followed; with it, all of it may not be felt.
    std::vector<std::string> unfollowed;
};

/// Reads \a name as readModel() does, and glTF with its extras as tags.
ModelFile readModelFile(const std::string& name, const osgDB::Options* options);

/// The box of all below \a node in the frame of its parent. (OSG's own has floats, which lose the
/// digits of places far from the origin.)
osg::BoundingBoxd boundsOf(osg::Node& node);

} // namespace osgMidair
